/// The [virtual] table of a rig file → the parameters of the virtual laboratory.
#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "core/toml_reader.hpp"
#include "simulator/gyro_thermal.hpp"
#include "simulator/world.hpp"
#include "simulator/world_parameters.hpp"

namespace gyrotherm {
namespace {

double positive(const TomlTable& table, const char* key) {
  const double value = table.number(key);
  if (table.has(key) && !(value > 0)) table.mistake(key, fmt::format("{} is not above 0", value));
  return value;
}

double not_negative(const TomlTable& table, const char* key) {
  const double value = table.number(key);
  if (table.has(key) && !(value >= 0)) table.mistake(key, fmt::format("{} is below 0", value));
  return value;
}

/// A time constant that a step of one second can follow.
double time_constant_s(const TomlTable& table, const char* key) {
  const double value = table.number(key);
  if (table.has(key) && !(value >= 1))
    table.mistake(key, fmt::format("{} s, expected at least the step of 1 s", value));
  return value;
}

/// As many numbers as wanted, none below `least`; on a mistake that many zeros.
std::vector<double> numbers(const TomlTable& table, const char* key, std::size_t count, double least) {
  auto values = table.numbers(key);
  if (values.size() != count) {
    table.mistake(key, fmt::format("{} numbers, expected {}", values.size(), count));
  } else if (const auto low = std::ranges::find_if(values, [&](double v) { return v < least; }); low != values.end()) {
    table.mistake(key, fmt::format("{}, expected at least {}", *low, least));
  }
  values.resize(count);
  return values;
}

PlantParameters read_plant(const TomlTable& table) {
  PlantParameters p;
  p.lowest_c = table.celsius("lowest").value;
  p.highest_c = table.celsius("highest").value;
  p.start_c = table.celsius("start").value;
  p.room_c = table.celsius("room").value;
  p.heating_k_per_min = positive(table, "heating_k_per_min");
  p.heating_slope_per_min = table.number("heating_slope_per_min");
  p.cooling_k_per_min = positive(table, "cooling_k_per_min");
  p.cooling_slope_per_min = table.number("cooling_slope_per_min");
  p.air_by_wall_s = time_constant_s(table, "air_by_wall_s");
  p.wall_by_air_s = time_constant_s(table, "wall_by_air_s");
  p.wall_by_room_s = time_constant_s(table, "wall_by_room_s");
  p.actuator_s = time_constant_s(table, "actuator_s");
  p.proportional_per_k = positive(table, "proportional_per_k");
  p.integral_time_s = time_constant_s(table, "integral_time_s");
  p.sensor_s = time_constant_s(table, "sensor_s");
  p.sensor_noise_k = not_negative(table, "sensor_noise_k");
  p.sensor_resolution_k = not_negative(table, "sensor_resolution_k");
  if (!(p.lowest_c <= p.start_c && p.start_c <= p.highest_c)) {
    table.mistake("start", "not between lowest and highest");
  }
  return p;
}

/// Each chain of nodes conducts from one to the next.
std::vector<ThermalLink> read_links(const TomlTable& table, const std::vector<std::string>& nodes) {
  std::vector<ThermalLink> links;
  for (const auto& conduction : table.tables("conduction")) {
    const double w_per_k = positive(conduction, "w_per_k");
    std::vector<std::size_t> chain;
    for (const auto& name : conduction.texts("chain")) {
      const auto found = std::ranges::find(nodes, name);
      if (found == nodes.end())
        conduction.mistake("chain", fmt::format("\"{}\" is not one of the nodes", name));
      else
        chain.push_back(static_cast<std::size_t>(found - nodes.begin()));
    }
    for (std::size_t i = 1; i < chain.size(); ++i) links.push_back({chain[i - 1], chain[i], w_per_k});
  }
  return links;
}

void expect_places(const TomlTable& table, const std::vector<std::string>& nodes) {
  for (std::size_t i = 0; i < kThermalPlaces; ++i) {
    const std::string_view name = i < kBlockPlaces ? kPlaceNames[i] : "air";
    if (std::ranges::count(nodes, name) != 1) table.mistake("nodes", fmt::format("expected \"{}\" once", name));
  }
}

/// The conductances that leave each node, and whether each node has a way to the chamber: else it would never come to
/// rest.
struct Connections {
  std::vector<double> leaving_w_per_k;
  std::vector<bool> anchored;
};

Connections connections_of(const NetworkParameters& n) {
  const auto air = static_cast<std::size_t>(std::ranges::find(n.nodes, "air") - n.nodes.begin());
  auto links = n.links;
  for (std::size_t i = 0; i < n.nodes.size(); ++i) {
    if (i != air && n.film_w_per_k[i] > 0) links.push_back({i, air, n.film_w_per_k[i]});
  }
  Connections found{n.chamber_w_per_k, std::vector<bool>(n.nodes.size())};
  for (std::size_t i = 0; i < n.nodes.size(); ++i) found.anchored[i] = n.chamber_w_per_k[i] > 0;
  for (const auto& link : links) {
    found.leaving_w_per_k[link.from] += link.w_per_k;
    found.leaving_w_per_k[link.to] += link.w_per_k;
  }
  for (std::size_t pass = 0; pass < n.nodes.size(); ++pass) {
    for (const auto& link : links) {
      const bool either = found.anchored[link.from] || found.anchored[link.to];
      found.anchored[link.from] = found.anchored[link.to] = either;
    }
  }
  return found;
}

void expect_sound_network(const TomlTable& table, const NetworkParameters& n) {
  const auto connections = connections_of(n);
  for (std::size_t i = 0; i < n.nodes.size(); ++i) {
    if (!connections.anchored[i]) {
      table.mistake("nodes", fmt::format("node \"{}\" has no way to the chamber", n.nodes[i]));
    }
    if (!(n.capacity_j_per_k[i] > connections.leaving_w_per_k[i])) {
      table.mistake(
          "capacity_j_per_k",
          fmt::format("node \"{}\": {} J/K, expected more than its conductances carry in a step of 1 s, {} J/K",
                      n.nodes[i], n.capacity_j_per_k[i], connections.leaving_w_per_k[i]));
    }
  }
}

NetworkParameters read_network(const TomlTable& table) {
  NetworkParameters n;
  n.start_c = table.celsius("start").value;
  n.nodes = table.texts("nodes");
  expect_places(table, n.nodes);
  const auto count = n.nodes.size();
  n.capacity_j_per_k = numbers(table, "capacity_j_per_k", count, 0);
  n.power_w = numbers(table, "power_w", count, 0);
  n.film_w_per_k = numbers(table, "film_w_per_k", count, 0);
  n.chamber_w_per_k = numbers(table, "chamber_w_per_k", count, 0);
  n.links = read_links(table, n.nodes);
  if (std::ranges::count(n.nodes, "air") == 1) expect_sound_network(table, n);
  return n;
}

BiasParameters read_bias(const TomlTable& table) {
  BiasParameters b;
  b.scale = table.number("scale");
  b.linear_deg_per_h_per_k = table.number("linear_deg_per_h_per_k");
  b.quadratic_deg_per_h_per_k2 = table.number("quadratic_deg_per_h_per_k2");
  b.wave_deg_per_h = table.number("wave_deg_per_h");
  b.wave_period_k = positive(table, "wave_period_k");
  b.arm_deg_per_h_per_k = table.number("arm_deg_per_h_per_k");
  b.arm_growth_per_k = table.number("arm_growth_per_k");
  const auto gradients = numbers(table, "gradient_deg_per_h_per_k", b.gradient_deg_per_h_per_k.size(), -1e6);
  std::ranges::copy(gradients, b.gradient_deg_per_h_per_k.begin());
  return b;
}

ReadoutParameters read_readout(const TomlTable& table) {
  ReadoutParameters r;
  r.arcsec_per_pulse = positive(table, "arcsec_per_pulse");
  r.earth_rate_deg_per_h = table.number("earth_rate_deg_per_h");
  r.angle_random_walk_deg_per_sqrt_h = not_negative(table, "angle_random_walk_deg_per_sqrt_h");
  r.drift_deg_per_h = not_negative(table, "drift_deg_per_h");
  r.drift_time_s = time_constant_s(table, "drift_time_s");
  r.turn_on_deg_per_h = table.number("turn_on_deg_per_h");
  r.clock_skew_ppm = table.number("clock_skew_ppm");
  return r;
}

ThermometerParameters read_thermometers(const TomlTable& table) {
  ThermometerParameters t;
  t.noise_k = not_negative(table, "noise_k");
  t.resolution_k = not_negative(table, "resolution_k");
  t.time_constant_s = not_negative(table, "time_constant_s");
  const auto offsets = numbers(table, "offset_k", t.offset_k.size(), -100);
  std::ranges::copy(offsets, t.offset_k.begin());
  return t;
}

SpreadParameters read_spread(const TomlTable& table) {
  return {.capacity = not_negative(table, "capacity"),
          .film = not_negative(table, "film"),
          .bias = not_negative(table, "bias"),
          .offset_k = not_negative(table, "offset_k"),
          .turn_on_deg_per_h = not_negative(table, "turn_on_deg_per_h")};
}

}  // namespace

Result<WorldParameters> parse_world(std::string_view rig_text, const std::string& file) {
  const auto root = TomlTable::parse(rig_text, file);
  if (!root) return failure(root.error());
  for (const auto& key : root->keys()) {
    if (key != "virtual") root->ignore(key);
  }
  if (!root->has("virtual"))
    return failure(FaultKind::bad_file, root->place(), "no [virtual] table: a rig of real instruments");
  const auto table = root->table("virtual");
  WorldParameters world{.plant = read_plant(table.table("plant")),
                        .network = read_network(table.table("network")),
                        .bias = read_bias(table.table("bias")),
                        .gyro = read_readout(table.table("gyro")),
                        .thermometers = read_thermometers(table.table("thermometers")),
                        .spread = read_spread(table.table("spread"))};
  if (const auto verdict = root->verdict(); !verdict) return failure(verdict.error());
  return world;
}

}  // namespace gyrotherm
