#include "simulator/thermal_network.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cassert>

namespace gyrotherm {
namespace {

Eigen::Index node_of(const NetworkParameters& network, std::string_view name) {
  const auto found = std::ranges::find(network.nodes, name);
  assert(found != network.nodes.end());
  return found - network.nodes.begin();
}

void conduct(Eigen::MatrixXd& conductance, Eigen::Index a, Eigen::Index b, double w_per_k) {
  conductance(a, b) += w_per_k;
  conductance(b, a) += w_per_k;
}

Eigen::MatrixXd conductances_of(const NetworkParameters& network) {
  const auto count = static_cast<Eigen::Index>(network.nodes.size());
  Eigen::MatrixXd conductance = Eigen::MatrixXd::Zero(count, count);
  const auto air = node_of(network, "air");
  for (Eigen::Index i = 0; i < count; ++i) {
    if (i != air) conduct(conductance, i, air, network.film_w_per_k[static_cast<std::size_t>(i)]);
  }
  for (const auto& link : network.links) {
    conduct(conductance, static_cast<Eigen::Index>(link.from), static_cast<Eigen::Index>(link.to), link.w_per_k);
  }
  return conductance;
}

Eigen::Map<const Eigen::VectorXd> as_vector(const std::vector<double>& values) {
  return {values.data(), static_cast<Eigen::Index>(values.size())};
}

}  // namespace

NetworkEquations equations_of(const NetworkParameters& network) {
  const Eigen::VectorXd per_capacity = as_vector(network.capacity_j_per_k).cwiseInverse();
  const auto to_chamber = as_vector(network.chamber_w_per_k);
  Eigen::MatrixXd balance = conductances_of(network);
  balance.diagonal() -= (balance.rowwise().sum() + to_chamber).eval();
  return {.rates = per_capacity.asDiagonal() * balance,
          .chamber = per_capacity.cwiseProduct(to_chamber),
          .heating = per_capacity.cwiseProduct(as_vector(network.power_w))};
}

Eigen::VectorXd at_rest(const NetworkEquations& equations, Celsius air) {
  return equations.rates.partialPivLu().solve(-(equations.chamber * air.value + equations.heating));
}

ThermalNetwork::ThermalNetwork(const NetworkParameters& network) {
  const auto equations = equations_of(network);
  const auto count = equations.chamber.size();
  transition_ = Eigen::MatrixXd::Identity(count, count) + equations.rates;
  chamber_ = equations.chamber;
  heating_k_ = equations.heating;
  state_c_ = at_rest(equations, {network.start_c});
  next_c_.resize(count);
  for (std::size_t i = 0; i < kThermalPlaces; ++i) {
    place_nodes_[i] = node_of(network, i < kBlockPlaces ? kPlaceNames[i] : "air");
  }
  publish();
}

void ThermalNetwork::step(Celsius air) {
  next_c_.noalias() = transition_ * state_c_;
  next_c_ += chamber_ * air.value + heating_k_;
  state_c_.swap(next_c_);
  publish();
}

void ThermalNetwork::publish() {
  for (std::size_t i = 0; i < kThermalPlaces; ++i) places_c_[i] = state_c_[place_nodes_[i]];
}

}  // namespace gyrotherm
