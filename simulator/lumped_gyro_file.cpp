/// [virtual.network] and [virtual.bias] → the parameters of the reference simulation's gyro.
#include <fmt/format.h>

#include <algorithm>

#include "simulator/laboratory_file.hpp"
#include "simulator/virtual_gyro.hpp"

namespace gyrotherm {
namespace {

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

LumpedBias read_bias(const TomlTable& table) {
  LumpedBias b;
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

}  // namespace

LumpedGyroParameters read_lumped_gyro(const TomlTable& table) {
  return {.network = read_network(table.table("network")), .bias = read_bias(table.table("bias"))};
}

}  // namespace gyrotherm
