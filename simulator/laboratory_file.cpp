// SPDX-License-Identifier: Apache-2.0
#include "simulator/laboratory_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "core/toml_reader.hpp"
#include "simulator/virtual_gyro.hpp"
#include "simulator/virtual_laboratory.hpp"
#include "simulator/virtual_unit.hpp"

namespace gyrotherm::simulator {

namespace {

constexpr double kLongestCorrelationS = 1e9;

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
  p.room_humidity_percent = not_negative(table, "room_humidity_percent", p.room_humidity_percent);
  if (!(p.room_humidity_percent > 0 && p.room_humidity_percent <= 100))
    table.note_error("room_humidity_percent", "expected above 0 and at most 100 %");
  p.air_exchange_s = time_constant_s(table, "air_exchange_s", p.air_exchange_s);
  if (!(p.lowest_c <= p.start_c && p.start_c <= p.highest_c)) {
    table.note_error("start", "not between lowest and highest");
  }
  return p;
}

DeadBand read_dead_band(const TomlTable& table) {
  DeadBand band{.half_width_deg_per_h = not_negative(table, "half_width_deg_per_h"),
                .sags_below_c = table.celsius("sags_below").value};
  if (table.has("sags_below") && !(band.sags_below_c > kColdC))
    table.note_error("sags_below", fmt::format("{} °C, expected above {} °C", band.sags_below_c, kColdC));
  return band;
}

/// Reads the parameters of the read-out. In a laboratory with units each axis has its own Earth rate, so this table has
/// none.
ReadoutParameters read_readout(const TomlTable& table, bool of_units) {
  ReadoutParameters r;
  r.arcsec_per_pulse = positive(table, "arcsec_per_pulse");
  if (!of_units) r.earth_rate_deg_per_h = table.number("earth_rate_deg_per_h");
  r.angle_random_walk_deg_per_sqrt_h = not_negative(table, "angle_random_walk_deg_per_sqrt_h");
  r.drift_deg_per_h = not_negative(table, "drift_deg_per_h", r.drift_deg_per_h);
  r.drift_time_s = time_constant_s(table, "drift_time_s", r.drift_time_s);
  r.instability_deg_per_h = not_negative(table, "instability_deg_per_h", r.instability_deg_per_h);
  r.instability_from_s = time_constant_s(table, "instability_from_s", r.instability_from_s);
  r.instability_to_s = time_constant_s(table, "instability_to_s", r.instability_to_s);
  r.rate_random_walk_deg_per_h_per_sqrt_h = not_negative(table, "rate_random_walk_deg_per_h_per_sqrt_h", 0);
  r.turn_on_deg_per_h = table.number("turn_on_deg_per_h");
  r.turn_on_repeatability_deg_per_h = not_negative(table, "turn_on_repeatability_deg_per_h", 0);
  r.clock_skew_ppm = table.number("clock_skew_ppm");
  r.walk_growth = not_negative(table, "walk_growth", 0);
  r.scale_factor_ppm = table.number("scale_factor_ppm", 0);
  r.tilt_arcmin = table.number("tilt_arcmin", 0);
  r.crosswise_earth_rate_deg_per_h = table.number("crosswise_earth_rate_deg_per_h", 0);
  r.lost_pulses_per_h = not_negative(table, "lost_pulses_per_h", 0);
  if (table.has("dead_band")) r.dead_band = read_dead_band(table.table("dead_band"));
  if (r.walk_growth > kMostWalkGrowth)
    table.note_error("walk_growth", fmt::format("{}, expected at most {}", r.walk_growth, kMostWalkGrowth));
  if (r.instability_to_s < r.instability_from_s || r.instability_to_s > kLongestCorrelationS)
    table.note_error("instability_to_s", fmt::format("{} s, expected {} to {} s", r.instability_to_s,
                                                     r.instability_from_s, kLongestCorrelationS));
  return r;
}

/// Reads one number for all thermometers, or one for each of A…H and shell.
EachThermometer read_each_thermometer(const TomlTable& table, const char* key, double least) {
  EachThermometer all{};
  if (table.is_list(key)) {
    std::ranges::copy(numbers(table, key, all.size(), least), all.begin());
    return all;
  }
  all.fill(table.number(key));
  if (!(all.front() >= least)) table.note_error(key, fmt::format("{}, expected at least {}", all.front(), least));
  return all;
}

EachThermometer read_each_or_none(const TomlTable& table, const char* key, double least) {
  return table.has(key) ? read_each_thermometer(table, key, least) : EachThermometer{};
}

constexpr Vocabulary<FailureMode, 4> kFailureModes{{{"stuck", FailureMode::stuck},
                                                    {"offset", FailureMode::offset},
                                                    {"spikes", FailureMode::spikes},
                                                    {"dead", FailureMode::dead}}};

FailingThermometer read_failing(const TomlTable& table, const std::vector<std::string>& names) {
  const auto channel = table.choice("channel", names);
  FailingThermometer failing{.index = static_cast<std::size_t>(std::ranges::find(names, channel) - names.begin()),
                             .mode = one_of(kFailureModes, table, "how"),
                             .from_s = to_seconds(table.duration("from"))};
  // An invalid choice has already been reported.
  if (failing.index == names.size()) failing.index = 0;
  if (failing.mode == FailureMode::offset || failing.mode == FailureMode::spikes)
    failing.error_k = table.number("error_k");
  if (failing.mode == FailureMode::spikes) failing.spikes_per_h = not_negative(table, "spikes_per_h");
  return failing;
}

ThermometerParameters read_thermometers(const TomlTable& table, const std::vector<std::string>& names) {
  constexpr double kLowestOffsetK = -100;
  ThermometerParameters t{.noise_k = read_each_thermometer(table, "noise_k", 0),
                          .resolution_k = read_each_thermometer(table, "resolution_k", 0),
                          .time_constant_s = read_each_thermometer(table, "time_constant_s", 0),
                          .offset_k = read_each_thermometer(table, "offset_k", kLowestOffsetK),
                          .gain = read_each_or_none(table, "gain", -1),
                          .drift_k_per_sqrt_day = read_each_or_none(table, "drift_k_per_sqrt_day", 0),
                          .days_since_calibration = not_negative(table, "days_since_calibration", 0),
                          .drift_by_calendar = table.boolean("drift_by_calendar", false),
                          .self_heating_k = read_each_or_none(table, "self_heating_k", 0)};
  for (const auto& failing : table.tables("failing")) t.failing.push_back(read_failing(failing, names));
  return t;
}

HardSpread read_hard_spread(const TomlTable& table) {
  return {.amplitude = not_negative(table, "amplitude"),
          .growth = not_negative(table, "growth"),
          .ageing_per_year = not_negative(table, "ageing_per_year")};
}

SpreadParameters read_spread(const TomlTable& table, bool is_reduced) {
  SpreadParameters s{.bias = not_negative(table, "bias"),
                     .offset_k = not_negative(table, "offset_k"),
                     .gain = not_negative(table, "gain", 0),
                     .time_constant = not_negative(table, "time_constant", 0),
                     .turn_on_deg_per_h = not_negative(table, "turn_on_deg_per_h")};
  if (table.has("hard")) s.hard = read_hard_spread(table.table("hard"));
  if (is_reduced) return s;
  s.capacity = not_negative(table, "capacity");
  s.film = not_negative(table, "film");
  return s;
}

bool has_reduced_gyro(const TomlTable& table) {
  return table.choice("body", {"reference", "twin"}, "reference") == "twin";
}

}  // namespace

Result<GyroModelUsed> find_gyro_model(std::string_view rig_text, const std::string& file,
                                      const std::optional<std::string>& known) {
  const auto root = TomlTable::parse(rig_text, file);
  if (!root) return failure(root.error());
  const auto table = root->table("virtual");
  if (!has_reduced_gyro(table)) return GyroModelUsed{};
  const auto thermal = table.table("thermal");
  const auto named = thermal.text("gyro");
  GyroModelUsed used{.name = std::filesystem::path(named).stem().stem().string(),
                     .film = thermal.text("film"),
                     .text = known.value_or("")};
  if (known || named.empty()) return used;
  auto model = read_named(thermal, "gyro", file, kShippedGyro, known);
  if (!model) return failure(std::move(model.error()));
  used.text = std::move(model->text);
  used.path = std::move(model->path);
  return used;
}

Result<LaboratoryParameters> parse_laboratory(std::string_view rig_text, const std::string& file,
                                              const std::optional<std::string>& gyro_model_text) {
  const auto root = TomlTable::parse(rig_text, file);
  if (!root) return failure(root.error());
  for (const auto& key : root->keys()) {
    if (key != "virtual") root->ignore(key);
  }
  if (!root->has("virtual"))
    return failure(FaultKind::bad_file, root->location(), "no [virtual] table; this rig has real instruments");
  const auto table = root->table("virtual");
  const bool is_reduced = has_reduced_gyro(table);
  LaboratoryParameters laboratory{.plant = read_plant(table.table("plant")),
                                  .body = {},
                                  .gyro = read_readout(table.table("gyro"), has_units(table)),
                                  .thermometers = {},
                                  .spread = read_spread(table.table("spread"), is_reduced)};
  read_units(table, laboratory);
  laboratory.thermometers = read_thermometers(table.table("thermometers"), list_thermometer_names(laboratory.units));
  assign_failures_to_axes(laboratory.thermometers.failing, laboratory.units);
  if (table.has("power_on")) laboratory.soaked = table.table("power_on").boolean("soaked", false);
  if (is_reduced)
    laboratory.body = read_reduced_gyro(table);
  else
    laboratory.body = read_lumped_gyro(table);
  if (const auto verdict = root->verdict(); !verdict) return failure(verdict.error());
  if (!is_reduced) return laboratory;
  const auto used = find_gyro_model(rig_text, file, gyro_model_text);
  if (!used) return failure(used.error());
  auto model = thermal::parse_reduced_model(used->text, used->name);
  if (!model) return failure(model.error());
  std::get<ReducedGyroParameters>(laboratory.body).model = std::move(*model);
  return laboratory;
}

double positive(const TomlTable& table, const char* key) {
  const double value = table.number(key);
  if (table.has(key) && !(value > 0)) table.note_error(key, fmt::format("{} is not above 0", value));
  return value;
}

double not_negative(const TomlTable& table, const char* key, std::optional<double> fallback) {
  const double value = table.number(key, fallback);
  if (table.has(key) && !(value >= 0)) table.note_error(key, fmt::format("{} is below 0", value));
  return value;
}

double time_constant_s(const TomlTable& table, const char* key, std::optional<double> fallback) {
  const double value = table.number(key, fallback);
  if (table.has(key) && !(value >= 1))
    table.note_error(key, fmt::format("{} s, expected at least 1 s, the step", value));
  return value;
}

std::vector<double> numbers(const TomlTable& table, const char* key, std::size_t count, double least) {
  auto values = table.numbers(key);
  if (values.size() != count) {
    table.note_error(key, fmt::format("{} numbers, expected {}", values.size(), count));
  } else if (const auto low = std::ranges::find_if(values, [&](double v) { return v < least; }); low != values.end()) {
    table.note_error(key, fmt::format("{}, expected at least {}", *low, least));
  }
  values.resize(count);
  return values;
}

}  // namespace gyrotherm::simulator
