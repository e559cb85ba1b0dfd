// SPDX-License-Identifier: Apache-2.0
/// One unit under test of the virtual laboratory: its axes, each a laser gyro of its own with its thermometers, and
/// what the unit tells of itself.
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

/// "UNIT.AXIS", or "UNIT" where the axis has no name.
[[nodiscard]] std::string axis_name(std::string_view unit, std::string_view axis);

/// The names of the world's thermometers (VirtualLaboratory::thermometer_names); without units, of the plain world's.
[[nodiscard]] std::vector<std::string> thermometer_names_of(const std::vector<UnitParameters>& units);

/// The seed for what has this name in a world of units: the same whatever else is in the world. The gyro's seed is
/// mixed with the name's FNV-1a hash of 64 bits, so that each name has another gyro, with seed 0 too.
[[nodiscard]] LaboratorySeed seed_of(LaboratorySeed seed, std::string_view name);

/// One axis, drawn, before it is made.
struct DrawnAxis {
  LaboratoryParameters gyro;
  LaboratorySeed seed;  ///< its own
  std::optional<OutputHop> hop{};
};

/// Where the cabinet of a gyro rests that is so while its air is at this temperature.
[[nodiscard]] Celsius cabinet_at_rest(const DrawnAxis& axis, Celsius air);

class VirtualAxis {
 public:
  explicit VirtualAxis(const DrawnAxis& drawn);

  /// Switched on it starts anew.
  void switch_on(bool on);
  /// Lets one second pass with the air around it here, and heater and cooler at `output` (VirtualGyro::step).
  void step(Celsius air, double output, const UnitState& state);

  [[nodiscard]] PlaceTemperatures thermometers_c() const { return thermometers_.readings_c(); }
  [[nodiscard]] Celsius cabinet() const { return {gyro_->places_c().back()}; }
  [[nodiscard]] Celsius block() const { return gyro_->block(); }
  [[nodiscard]] const GyroReadout& readout() const { return readout_; }
  [[nodiscard]] DegreesPerHour true_bias() const { return true_bias_; }  ///< in the second that has passed
  /// What is added to bias and Earth rate in the second to come: the read-out's drift, and the hop.
  [[nodiscard]] DegreesPerHour drift() const { return readout_.drift() + hopped(); }

 private:
  [[nodiscard]] DegreesPerHour hopped() const;

  std::unique_ptr<VirtualGyro> gyro_;
  std::optional<OutputHop> hop_;
  DegreesPerHour true_bias_;
  ThermometerBank thermometers_;
  GyroReadout readout_;
  double seconds_{};
};

/// What a unit tells beside its rates: its own temperature first, if it has one, then its other values.
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
  std::vector<OwnValue> laws_;
  RandomStream thermometer_noise_, value_noise_;
  double sensed_c_;
  std::vector<UnitValue> values_;
};

class VirtualUnit {
 public:
  /// `seed`: the unit's own. `axes`: at least one.
  VirtualUnit(const LaboratoryParameters& type, std::span<const DrawnAxis> axes, LaboratorySeed seed);

  /// From the next step on.
  void bring_to(const UnitState& state);
  void step(Celsius air, double output);

  [[nodiscard]] std::span<const VirtualAxis> axes() const { return axes_; }
  [[nodiscard]] Celsius cabinets() const;  ///< their mean
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
