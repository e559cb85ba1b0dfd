// SPDX-License-Identifier: Apache-2.0
#include "simulator/lumped_gyro.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <numeric>

#include "simulator/laboratory_file.hpp"
#include "simulator/virtual_gyro.hpp"

namespace gyrotherm::simulator {
namespace {

Eigen::Index find_node(const NetworkParameters& network, std::string_view name) {
  const auto found = std::ranges::find(network.nodes, name);
  assert(found != network.nodes.end());
  return found - network.nodes.begin();
}

void add_conductance(Eigen::MatrixXd& conductance, Eigen::Index a, Eigen::Index b, double w_per_k) {
  conductance(a, b) += w_per_k;
  conductance(b, a) += w_per_k;
}

Eigen::MatrixXd make_conductances(const NetworkParameters& network) {
  const auto count = static_cast<Eigen::Index>(network.nodes.size());
  Eigen::MatrixXd conductance = Eigen::MatrixXd::Zero(count, count);
  const auto air = find_node(network, "air");
  for (Eigen::Index i = 0; i < count; ++i) {
    if (i != air) add_conductance(conductance, i, air, network.film_w_per_k[static_cast<std::size_t>(i)]);
  }
  for (const auto& link : network.links) {
    add_conductance(conductance, static_cast<Eigen::Index>(link.from), static_cast<Eigen::Index>(link.to),
                    link.w_per_k);
  }
  return conductance;
}

Eigen::Map<const Eigen::VectorXd> as_vector(const std::vector<double>& values) {
  return {values.data(), static_cast<Eigen::Index>(values.size())};
}

enum BlockLocation : std::size_t { A, B, C, D, E };

/// Returns the mean of A…H.
double block_mean_c(BlockTemperatures block_c) {
  return std::accumulate(block_c.begin(), block_c.end(), 0.0) / kBlockLocations;
}

double gradient_part(const LumpedBias& bias, BlockTemperatures t) {
  double sum = 0;
  for (std::size_t x = 1; x < kBlockLocations; ++x) sum += bias.gradient_deg_per_h_per_k[x - 1] * (t[A] - t[x]);
  return sum;
}

/// Reads the chains of nodes. Each chain conducts from one node to the next.
std::vector<ThermalLink> read_links(const TomlTable& table, const std::vector<std::string>& nodes) {
  std::vector<ThermalLink> links;
  for (const auto& conduction : table.tables("conduction")) {
    const double w_per_k = positive(conduction, "w_per_k");
    std::vector<std::size_t> chain;
    for (const auto& name : conduction.texts("chain")) {
      const auto found = std::ranges::find(nodes, name);
      if (found == nodes.end())
        conduction.note_error("chain", fmt::format("\"{}\" is not one of the nodes", name));
      else
        chain.push_back(static_cast<std::size_t>(found - nodes.begin()));
    }
    for (std::size_t i = 1; i < chain.size(); ++i) links.push_back({chain[i - 1], chain[i], w_per_k});
  }
  return links;
}

void expect_locations(const TomlTable& table, const std::vector<std::string>& nodes) {
  for (std::size_t i = 0; i < kThermalLocations; ++i) {
    const std::string_view name = i < kBlockLocations ? kLocationNames[i] : "air";
    if (std::ranges::count(nodes, name) != 1)
      table.note_error("nodes", fmt::format("expected \"{}\" exactly once", name));
  }
}

/// The sum of the conductances that leave each node, and whether each node is connected to the chamber. A node without
/// a connection would never reach a steady state.
struct Connections {
  std::vector<double> leaving_w_per_k;
  std::vector<bool> anchored;
};

Connections find_connections(const NetworkParameters& n) {
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

void check_network(const TomlTable& table, const NetworkParameters& n) {
  const auto connections = find_connections(n);
  for (std::size_t i = 0; i < n.nodes.size(); ++i) {
    if (!connections.anchored[i]) {
      table.note_error("nodes", fmt::format("node \"{}\" has no path to the chamber", n.nodes[i]));
    }
    if (!(n.capacity_j_per_k[i] > connections.leaving_w_per_k[i])) {
      table.note_error(
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
  expect_locations(table, n.nodes);
  const auto count = n.nodes.size();
  n.capacity_j_per_k = numbers(table, "capacity_j_per_k", count, 0);
  n.power_w = numbers(table, "power_w", count, 0);
  n.film_w_per_k = numbers(table, "film_w_per_k", count, 0);
  n.chamber_w_per_k = numbers(table, "chamber_w_per_k", count, 0);
  n.links = read_links(table, n.nodes);
  if (std::ranges::count(n.nodes, "air") == 1) check_network(table, n);
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

NetworkEquations make_equations(const NetworkParameters& network) {
  const Eigen::VectorXd per_capacity = as_vector(network.capacity_j_per_k).cwiseInverse();
  const auto to_chamber = as_vector(network.chamber_w_per_k);
  Eigen::MatrixXd balance = make_conductances(network);
  balance.diagonal() -= (balance.rowwise().sum() + to_chamber).eval();
  return {.rates = per_capacity.asDiagonal() * balance,
          .chamber = per_capacity.cwiseProduct(to_chamber),
          .heating = per_capacity.cwiseProduct(as_vector(network.power_w))};
}

Eigen::VectorXd rest_temperatures(const NetworkEquations& equations, Celsius air) {
  return equations.rates.partialPivLu().solve(-(equations.chamber * air.value + equations.heating));
}

ThermalNetwork::ThermalNetwork(const NetworkParameters& network) {
  const auto equations = make_equations(network);
  const auto count = equations.chamber.size();
  transition_ = Eigen::MatrixXd::Identity(count, count) + equations.rates;
  chamber_ = equations.chamber;
  heating_k_ = equations.heating;
  state_c_ = rest_temperatures(equations, {network.start_c});
  next_c_.resize(count);
  for (std::size_t i = 0; i < kThermalLocations; ++i) {
    location_nodes_[i] = find_node(network, i < kBlockLocations ? kLocationNames[i] : "air");
  }
  publish();
}

void ThermalNetwork::step(Celsius air) {
  next_c_.noalias() = transition_ * state_c_;
  next_c_ += chamber_ * air.value;
  if (on_) next_c_ += heating_k_;
  state_c_.swap(next_c_);
  publish();
}

void ThermalNetwork::publish() {
  for (std::size_t i = 0; i < kThermalLocations; ++i) locations_c_[i] = state_c_[location_nodes_[i]];
}

DegreesPerHour reference_bias(const LumpedBias& bias, BlockTemperatures t) {
  const double x = block_mean_c(t) - 20;
  const double absolute = bias.linear_deg_per_h_per_k * x + bias.quadratic_deg_per_h_per_k2 * x * x;
  const double wave = bias.wave_deg_per_h * std::sin(2 * std::numbers::pi * x / bias.wave_period_k);
  const double arms_k = (t[B] + t[D] - t[C] - t[E]) / 2;
  const double arms = bias.arm_deg_per_h_per_k * arms_k * (1 + bias.arm_growth_per_k * x);
  return {bias.scale * (absolute + gradient_part(bias, t) + arms + wave)};
}

Celsius LumpedGyro::block() const { return {block_mean_c(locations_c().first<kBlockLocations>())}; }

LumpedGyroParameters read_lumped_gyro(const TomlTable& table) {
  return {.network = read_network(table.table("network")), .bias = read_bias(table.table("bias"))};
}

}  // namespace gyrotherm::simulator
