// SPDX-License-Identifier: Apache-2.0
/// The virtual laboratory, advanced one second at a time: a chamber's air and in it one or more units under test. Each
/// axis of a unit is a gyro with a thermal body, bias, read-out and thermometers. Random numbers are drawn only when a
/// step is made, so reading has no side effects. The same seed and set points therefore reproduce a run exactly.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/quantity.hpp"
#include "core/result.hpp"
#include "core/sample.hpp"

namespace gyrotherm::simulator {

class ChamberLimiter;         // simulator/chamber_limiter.hpp
struct LaboratoryParameters;  // simulator/laboratory_parameters.hpp
struct LaboratoryFaults;      // simulator/laboratory_file.hpp

/// The reduced model that a rig file refers to. All fields are empty for the reference simulation, which the rig file
/// describes completely.
struct GyroModelUsed {
  /// File name of the reduced gyro without its endings: "calibrated".
  std::string name;
  /// Air movement around the cabinet: "chamber" or "still".
  std::string film;
  /// Content of the file.
  std::string text;
  /// Empty if the text was given.
  std::string path{};
};

/// Returns the reduced model that the [virtual] table names. `known` is the model's text if it is already available
/// (resume uses the copy in the record). Otherwise the file is read, relative to `file`. Fails with bad_file if it
/// cannot be read; parse_laboratory reports all other errors.
[[nodiscard]] Result<GyroModelUsed> find_gyro_model(std::string_view rig_text, const std::string& file,
                                                    const std::optional<std::string>& known = {});

/// Reads the [virtual] table of a rig file, and the reduced gyro that it names (see find_gyro_model). Ignores the other
/// tables. Fails with bad_file and reports every error with its position.
[[nodiscard]] Result<LaboratoryParameters> parse_laboratory(std::string_view rig_text, const std::string& file,
                                                            const std::optional<std::string>& gyro_model_text = {});

inline constexpr std::uint64_t kMaxDaysLater = 36'500;

/// Selects the gyro, the run and the day. Two runs of one gyro share its physics but no noise. In a laboratory with
/// units each axis has its own gyro, which depends only on the seed and on the names of unit and axis, not on other
/// units in the chamber.
struct LaboratorySeed {
  /// If there are no units, 0 is exactly the gyro of the file, and any other seed draws another gyro of the type. With
  /// units, seed 0 also draws a gyro for each axis.
  std::uint64_t gyro{};
  /// Seed of the noise.
  std::uint64_t run{};
  /// Age of the gyro and its thermometers; at most kMaxDaysLater.
  std::uint64_t days_later = 0;
};

/// Returns the laboratory with chamber and gyro at rest at `first`, which the controller must accept.
[[nodiscard]] LaboratoryParameters soak_at(LaboratoryParameters parameters, Celsius first);

/// A value that a unit reports in addition to its rates.
struct UnitValue {
  std::string name;
  double value{};
};

/// Name of the value that holds the unit's own temperature, °C.
inline constexpr const char* kOwnTemperature = "self";

/// Name of the single unit if the rig file has no [[virtual.unit]].
inline constexpr const char* kPlainUnit = "gyro";

/// The laboratory. Units and their axes are identified by their index in the rig file.
class VirtualLaboratory {
 public:
  VirtualLaboratory(const LaboratoryParameters& parameters, LaboratorySeed seed);
  ~VirtualLaboratory();
  VirtualLaboratory(VirtualLaboratory&&) noexcept;
  VirtualLaboratory& operator=(VirtualLaboratory&&) noexcept;

  /// Returns whether the controller accepts this set point.
  [[nodiscard]] bool accepts(Celsius set_point) const;
  /// Sends the controller a set point, which it must accept. It applies from the next step on.
  void change_set_point(Celsius set_point);
  void switch_on(bool on);
  /// Holds the controller's output, −1 (full cooling) … 1 (full heating), while it is on (manual mode). An empty value
  /// makes it follow the set point.
  void hold_output(std::optional<double> output);
  /// Disconnects the chamber's machinery, or connects it again. The controller keeps its state.
  void cut_power(bool cut);
  /// Returns the chamber's own limiter, for the person who sets and resets it.
  [[nodiscard]] ChamberLimiter& limiter();
  /// Changes the state of all units from the next step on. A unit without power is silent and cools down; switching on
  /// restarts it. Each axis of a turned unit measures the Earth rate with the opposite sign.
  void set_unit_state(const UnitState& state);
  /// Connects a unit to a source of power, or changes the state of that source, from the next step on. A unit with
  /// sources has power while all of them are on, regardless of `off` in its state.
  void feed(std::size_t unit, std::size_t source, bool on);
  /// Marks a unit as silent or sending. Only the server of the unit's line reads this mark; the simulation continues
  /// unchanged.
  void silence(std::size_t unit, bool silent);
  /// Applies these faults and removes all others. Faults of the chamber apply from the next step on, faults of
  /// thermometers immediately.
  void inject(const LaboratoryFaults& faults);
  /// Advances by one second.
  void step();

  [[nodiscard]] Celsius set_point() const;
  [[nodiscard]] bool is_on() const;
  [[nodiscard]] bool holds_output() const;
  /// Returns the state of all units.
  [[nodiscard]] const UnitState& unit() const;
  /// Returns the reading of the chamber's own sensor, with noise and resolution.
  [[nodiscard]] Celsius air_as_measured() const;
  /// Returns the readings of the chamber's humidity sensor, relative to water, and of its dew-point sensor. Both are
  /// free of noise.
  [[nodiscard]] double humidity_percent() const;
  [[nodiscard]] Celsius dew_point() const;
  /// Returns the output: −100 (full cooling) … 100 (full heating).
  [[nodiscard]] double output_percent() const;
  /// Returns the readings in the order of thermometer_names(). NaN is an open input.
  [[nodiscard]] std::span<const double> thermometers_as_measured_c() const;
  /// Returns the names of the thermometers. A laboratory without units has "A" … "H" and "shell". Otherwise each axis
  /// has these with its name in front: "UNIT.A" if the axis has no name, or "UNIT.AXIS.A".
  [[nodiscard]] const std::vector<std::string>& thermometer_names() const;

  [[nodiscard]] const std::vector<std::string>& units() const;
  /// Returns the names of a unit's axes. A single axis may have the name "".
  [[nodiscard]] const std::vector<std::string>& axes(std::size_t unit = 0) const;
  [[nodiscard]] bool is_silent(std::size_t unit = 0) const;
  /// Returns whether the unit has no power.
  [[nodiscard]] bool is_off(std::size_t unit = 0) const;
  /// Returns the resistance of the unit's load at its present temperature.
  [[nodiscard]] double load_ohm(std::size_t unit) const;
  /// Returns the accumulated count of each axis.
  [[nodiscard]] std::span<const std::int64_t> pulses(std::size_t unit = 0) const;
  /// Returns the time of the unit's clock, with its skew.
  [[nodiscard]] std::int64_t device_time_us(std::size_t unit = 0) const;
  /// Returns the size of a pulse, which is equal for all axes.
  [[nodiscard]] double arcsec_per_pulse() const;
  /// Returns the values that the unit reports: kOwnTemperature first, if the unit has it, then the [[virtual.value]] of
  /// the rig file in order.
  [[nodiscard]] std::span<const UnitValue> values(std::size_t unit = 0) const;
  /// Returns the bias of each axis in the past second (before the first step: in the next one), caused by present and
  /// past temperatures and by the warm-up. It excludes turn-on offset, bias instability, random walks and hops, which
  /// do not depend on temperature. No instrument transmits it.
  [[nodiscard]] std::span<const DegreesPerHour> true_bias(std::size_t unit = 0) const;
  /// Returns the parts of each axis' rate that true_bias excludes. Used by tests.
  [[nodiscard]] std::vector<DegreesPerHour> drift(std::size_t unit = 0) const;
  /// Returns the temperature of the bracket that carries a unit, or nothing without a bracket. Used by tests.
  [[nodiscard]] std::optional<Celsius> bracket(std::size_t unit) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace gyrotherm::simulator
