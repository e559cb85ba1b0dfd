// SPDX-License-Identifier: Apache-2.0
/// One unit under test of the virtual laboratory: its axes, each a laser gyro with its own thermometers, and the values
/// that the unit reports.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/quantity.hpp"
#include "core/random.hpp"
#include "core/sample.hpp"
#include "simulator/gyro_readout.hpp"
#include "simulator/laboratory_parameters.hpp"
#include "simulator/thermometer_bank.hpp"
#include "simulator/virtual_gyro.hpp"
#include "simulator/virtual_laboratory.hpp"

namespace gyrotherm::simulator {

/// Returns "UNIT.AXIS", or "UNIT" if the axis has no name.
[[nodiscard]] std::string axis_name(std::string_view unit, std::string_view axis);

/// Returns the names of the laboratory's thermometers (VirtualLaboratory::thermometer_names). `units` is empty for a
/// laboratory without units.
[[nodiscard]] std::vector<std::string> list_thermometer_names(const std::vector<UnitParameters>& units);

/// Returns the seed of the unit or axis with this name. It does not depend on other units. The gyro's seed is mixed
/// with the 64-bit FNV-1a hash of the name, so each name has a different gyro, even with seed 0.
[[nodiscard]] LaboratorySeed derive_seed(LaboratorySeed seed, std::string_view name);

/// Drawn parameters of one axis.
struct DrawnAxis {
  LaboratoryParameters gyro;
  /// The seed of this axis.
  LaboratorySeed seed;
  std::optional<OutputHop> hop{};
};

/// Returns the temperature of the axis' cabinet at rest in air of this temperature.
[[nodiscard]] Celsius cabinet_at_rest(const DrawnAxis& axis, Celsius air);

class VirtualAxis {
 public:
  explicit VirtualAxis(const DrawnAxis& drawn);

  /// Switches the gyro's power. Switching on restarts warm-up and turn-on offset.
  void switch_on(bool on);
  /// Advances by one second in this air, with heater and cooler at `output` (VirtualGyro::step).
  void step(Celsius air, double output, const UnitState& state);

  [[nodiscard]] LocationTemperatures thermometers_c() const { return thermometers_.readings_c(); }
  [[nodiscard]] Celsius cabinet() const { return {gyro_->locations_c().back()}; }
  [[nodiscard]] Celsius block() const { return gyro_->block(); }
  [[nodiscard]] const GyroReadout& readout() const { return readout_; }
  /// Returns the true bias of the past second.
  [[nodiscard]] DegreesPerHour true_bias() const { return true_bias_; }
  /// Returns the sum of all terms that are added to bias and Earth rate in the next second: the read-out's drift and
  /// the hop.
  [[nodiscard]] DegreesPerHour drift() const { return readout_.drift() + hop_rate(); }

 private:
  [[nodiscard]] DegreesPerHour hop_rate() const;

  std::unique_ptr<VirtualGyro> gyro_;
  std::optional<OutputHop> hop_;
  DegreesPerHour true_bias_;
  ThermometerBank thermometers_;
  GyroReadout readout_;
  double seconds_{};
};

/// The values that a unit reports in addition to its rates: first the temperature of its own thermometer, if it has
/// one, then the other values.
class Housekeeping {
 public:
  /// Starts in equilibrium with the block and reads it once.
  Housekeeping(const LaboratoryParameters& type, Celsius block, std::uint64_t seed);

  /// Follows the block for one second, then reads it.
  void step(Celsius block);
  [[nodiscard]] std::span<const UnitValue> values() const { return values_; }

 private:
  void read(Celsius block);

  std::optional<OwnThermometer> thermometer_;
  std::vector<OwnValue> value_parameters_;
  RandomStream thermometer_noise_, value_noise_;
  double sensed_c_;
  std::vector<UnitValue> values_;
};

class VirtualUnit {
 public:
  /// Creates the unit with its own seed and at least one axis.
  VirtualUnit(const LaboratoryParameters& type, std::span<const DrawnAxis> axes, LaboratorySeed seed);

  /// Changes the state from the next step on.
  void set_state(const UnitState& state);
  void step(Celsius air, double output);

  [[nodiscard]] std::span<const VirtualAxis> axes() const { return axes_; }
  /// Returns the mean temperature of the cabinets.
  [[nodiscard]] Celsius cabinets() const;
  [[nodiscard]] const UnitState& state() const { return state_; }
  [[nodiscard]] std::span<const std::int64_t> pulses() const { return pulses_; }
  [[nodiscard]] std::int64_t device_time_us() const { return axes_.front().readout().device_time_us(); }
  [[nodiscard]] std::span<const DegreesPerHour> true_bias() const { return true_bias_; }
  [[nodiscard]] std::span<const UnitValue> values() const { return housekeeping_.values(); }

 private:
  void gather();

  std::vector<VirtualAxis> axes_;
  Housekeeping housekeeping_;
  UnitState state_;
  std::vector<std::int64_t> pulses_;
  std::vector<DegreesPerHour> true_bias_;
};

}  // namespace gyrotherm::simulator
