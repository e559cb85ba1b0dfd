// SPDX-License-Identifier: Apache-2.0
#include "simulator/virtual_unit.hpp"

#include <fmt/format.h>

#include <cassert>
#include <limits>
#include <utility>

#include "simulator/gyro_ageing.hpp"
#include "simulator/lumped_gyro.hpp"

namespace gyrotherm::simulator {
namespace {

std::unique_ptr<VirtualGyro> make_gyro(const LumpedGyroParameters& p, LaboratorySeed /*seed*/) {
  return std::make_unique<LumpedGyro>(p);
}
std::unique_ptr<VirtualGyro> make_gyro(const ReducedGyroParameters& p, LaboratorySeed seed) {
  return std::make_unique<ReducedGyro>(p, make_history(p.storage, seed));
}

std::unique_ptr<VirtualGyro> make_gyro(const DrawnAxis& axis) {
  return std::visit([&](const auto& body) { return make_gyro(body, axis.seed); }, axis.gyro.body);
}

Celsius cabinet_at_rest(const LumpedGyroParameters& parameters) {
  return {LumpedGyro(parameters).locations_c().back()};
}

std::uint64_t fnv1a(std::string_view text) {
  std::uint64_t hash = 0xcbf29ce484222325U;
  for (const char byte : text) hash = (hash ^ static_cast<unsigned char>(byte)) * 0x100000001b3U;
  return hash;
}

}  // namespace

std::string axis_name(std::string_view unit, std::string_view axis) {
  return axis.empty() ? std::string(unit) : fmt::format("{}.{}", unit, axis);
}

std::vector<std::string> list_thermometer_names(const std::vector<UnitParameters>& units) {
  if (units.empty()) return {kLocationNames.begin(), kLocationNames.end()};
  std::vector<std::string> names;
  for (const auto& unit : units)
    for (const auto& axis : unit.axes)
      for (const auto location : kLocationNames) names.push_back(axis_name(axis_name(unit.name, axis.name), location));
  return names;
}

LaboratorySeed derive_seed(LaboratorySeed seed, std::string_view name) {
  seed.gyro = splitmix64(splitmix64(seed.gyro) ^ fnv1a(name));
  return seed;
}

Celsius cabinet_at_rest(const DrawnAxis& axis, Celsius air) {
  return std::visit([](const auto& body) { return cabinet_at_rest(body); }, soak_at(axis.gyro, air).body);
}

VirtualAxis::VirtualAxis(const DrawnAxis& drawn)
    : gyro_(make_gyro(drawn)),
      hop_(drawn.hop),
      true_bias_(gyro_->bias()),
      thermometers_(drawn.gyro.thermometers, gyro_->locations_c(), noise_seed(drawn.seed)),
      readout_(drawn.gyro.gyro, noise_seed(drawn.seed)) {}

void VirtualAxis::switch_on(bool on) {
  gyro_->switch_on(on);
  if (on) readout_.restart();
}

void VirtualAxis::step(Celsius air, double output, const UnitState& state) {
  true_bias_ = gyro_->bias();
  if (!state.off) readout_.step(true_bias_ + hop_rate(), gyro_->block(), state.turned);
  gyro_->step(air, output);
  thermometers_.step(gyro_->locations_c());
  ++seconds_;
}

DegreesPerHour VirtualAxis::hop_rate() const {
  if (!hop_ || seconds_ < hop_->at_s) return {};
  return {seconds_ - hop_->at_s < hop_->for_s.value_or(std::numeric_limits<double>::infinity()) ? hop_->deg_per_h : 0};
}

Housekeeping::Housekeeping(const LaboratoryParameters& type, Celsius block, std::uint64_t seed)
    : thermometer_(type.own_temperature),
      value_parameters_(type.values),
      thermometer_noise_(seed, RandomPurpose::own_temperature),
      value_noise_(seed, RandomPurpose::own_values),
      sensed_c_(block.value) {
  if (thermometer_) values_.push_back({.name = kOwnTemperature, .value = 0});
  for (const auto& own_value : value_parameters_) values_.push_back({.name = own_value.name, .value = 0});
  read(block);
}

void Housekeeping::step(Celsius block) {
  if (thermometer_) sensed_c_ += -std::expm1(-1 / thermometer_->time_constant_s) * (block.value - sensed_c_);
  read(block);
}

void Housekeeping::read(Celsius block) {
  auto value = values_.begin();
  if (thermometer_) {
    const auto& t = *thermometer_;
    const double shown_c = sensed_c_ + t.offset_k + t.noise_k * thermometer_noise_.normal();
    (value++)->value = round_to_resolution(shown_c, t.resolution_k);
  }
  for (const auto& own_value : value_parameters_)
    (value++)->value =
        own_value.at_20_c + own_value.per_k * (block.value - 20) + own_value.noise * value_noise_.normal();
}

VirtualUnit::VirtualUnit(const LaboratoryParameters& type, std::span<const DrawnAxis> axes, LaboratorySeed seed)
    : axes_(axes.begin(), axes.end()),
      housekeeping_(type, axes_.front().block(), noise_seed(seed)),
      pulses_(axes_.size()),
      true_bias_(axes_.size()) {
  gather();
}

void VirtualUnit::set_state(const UnitState& state) {
  const auto before = std::exchange(state_, state);
  if (before.off == state.off) return;
  for (auto& axis : axes_) axis.switch_on(!state.off);
}

void VirtualUnit::step(Celsius air, double output) {
  for (auto& axis : axes_) axis.step(air, output, state_);
  housekeeping_.step(axes_.front().block());
  gather();
}

void VirtualUnit::gather() {
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    pulses_[i] = axes_[i].readout().pulses();
    true_bias_[i] = axes_[i].true_bias();
  }
}

Celsius VirtualUnit::cabinets() const {
  double sum_c = 0;
  for (const auto& axis : axes_) sum_c += axis.cabinet().value;
  return {sum_c / static_cast<double>(axes_.size())};
}

}  // namespace gyrotherm::simulator
