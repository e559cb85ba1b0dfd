// SPDX-License-Identifier: Apache-2.0
/// The virtual laboratory, one second at a time: a chamber's air, in it one unit under test or many, and of each axis
/// of each the gyro as a thermal body, its bias, its read-out and its thermometers. Reading has no side effects: every
/// random number belongs to a step, so that a world is reproduced by its seed and the set points of its steps alone.
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

struct LaboratoryParameters;  // simulator/laboratory_parameters.hpp
struct LaboratoryFaults;      // simulator/laboratory_file.hpp

/// What the gyro of a virtual rig is made of beside the rig file; all empty for the reference simulation's, which the
/// rig file holds whole.
struct GyroModelUsed {
  std::string name;    ///< of the reduced gyro's file, without its endings: "calibrated"
  std::string film;    ///< "chamber" or "still": how the air moves around the cabinet
  std::string text;    ///< the file, as read
  std::string path{};  ///< empty if its text was known
};

/// What the [virtual] table of a rig file names. `known`: the reduced gyro's text where it is already known (resume:
/// the record's copy); otherwise the file is read, relative to `file`. Fails with bad_file if it cannot be read; other
/// mistakes are for parse_laboratory to tell.
[[nodiscard]] Result<GyroModelUsed> gyro_model_of(std::string_view rig_text, const std::string& file,
                                                  const std::optional<std::string>& known = {});

/// Reads the [virtual] table of a rig file (the rest of the file is someone else's), and the reduced gyro that it names
/// like gyro_model_of. Fails with bad_file, every mistake with its place.
[[nodiscard]] Result<LaboratoryParameters> parse_laboratory(std::string_view rig_text, const std::string& file,
                                                            const std::optional<std::string>& gyro_model_text = {});

inline constexpr std::uint64_t kMostDaysLater = 36'500;  ///< a century

/// Which gyro, which of its runs, and when: two runs of one gyro share its physics and none of its noise. In a world of
/// units each axis has a gyro of its own, which depends on the seed and on the names of unit and axis alone: it is the
/// same one whatever else stands in the chamber.
struct LaboratorySeed {
  /// In the plain world 0 is the gyro of the file exactly, and any other draws another gyro of the same type. In a
  /// world of units 0 too draws another one for each axis.
  std::uint64_t gyro{};
  std::uint64_t run{};           ///< draws the noise
  std::uint64_t days_later = 0;  ///< the gyro and its thermometers are so much older; at most kMostDaysLater
};

/// The laboratory as it stands when chamber and gyro have long been at `first`, which the controller must accept.
[[nodiscard]] LaboratoryParameters soaked_at(LaboratoryParameters parameters, Celsius first);

/// A number that a unit tells of itself, beside its rates.
struct UnitValue {
  std::string name;
  double value{};
};

/// The name of the value that is the unit's own temperature, °C.
inline constexpr const char* kOwnTemperature = "self";

/// The one unit of a plain world, that is of a rig file without [[virtual.unit]].
inline constexpr const char* kPlainUnit = "gyro";

/// Units and their axes are named by index, in the order of the rig file.
class VirtualLaboratory {
 public:
  VirtualLaboratory(const LaboratoryParameters& parameters, LaboratorySeed seed);
  ~VirtualLaboratory();
  VirtualLaboratory(VirtualLaboratory&&) noexcept;
  VirtualLaboratory& operator=(VirtualLaboratory&&) noexcept;

  /// Whether the controller can be told this.
  [[nodiscard]] bool accepts(Celsius set_point) const;
  /// What the controller is told, which it must accept; in force from the next step on.
  void change_set_point(Celsius set_point);
  void switch_on(bool on);
  /// Manual mode of the controller: its output stays at this, −1 (full cooling) … 1 (full heating), while it is on;
  /// nothing: it follows the set point.
  void hold_output(std::optional<double> output);
  /// Every unit is so from the next step on: without power it is silent, cools down and, switched on again, starts
  /// anew; turned around each axis sees the Earth's rate with the other sign.
  void bring_unit_to(const UnitState& state);
  /// From now on the unit does not send, or sends again. It is for who serves its line to obey; nothing else changes.
  void silence(std::size_t unit, bool silent);
  /// Breaks what `faults` says, and mends what it does not: the chamber from the next step on, thermometers at once.
  void inject(const LaboratoryFaults& faults);
  /// Lets one second pass.
  void step();

  [[nodiscard]] Celsius set_point() const;
  [[nodiscard]] bool is_on() const;
  [[nodiscard]] bool holds_output() const;
  [[nodiscard]] const UnitState& unit() const;    ///< how people have left the units, all alike
  [[nodiscard]] Celsius air_as_measured() const;  ///< by the chamber's own sensor: noise, resolution
  [[nodiscard]] double output_percent() const;    ///< −100 (full cooling) … 100 (full heating)
  /// In the order of thermometer_names(); NaN is an open input.
  [[nodiscard]] std::span<const double> thermometers_as_measured_c() const;
  /// Of the plain world "A" … "H", "shell"; else each axis has these, after its name: "UNIT.A" where it has none of its
  /// own, or "UNIT.AXIS.A".
  [[nodiscard]] const std::vector<std::string>& thermometer_names() const;

  [[nodiscard]] const std::vector<std::string>& units() const;  ///< their names
  /// The names of a unit's axes; a single one may be "".
  [[nodiscard]] const std::vector<std::string>& axes(std::size_t unit = 0) const;
  [[nodiscard]] bool is_silent(std::size_t unit = 0) const;
  [[nodiscard]] std::span<const std::int64_t> pulses(std::size_t unit = 0) const;  ///< of each axis, accumulated
  [[nodiscard]] std::int64_t device_time_us(std::size_t unit = 0) const;  ///< the unit's own clock, with its skew
  [[nodiscard]] double arcsec_per_pulse() const;                          ///< of every axis
  /// What it tells of itself: kOwnTemperature first, where it has that, then the rig file's [[virtual.value]] in order.
  [[nodiscard]] std::span<const UnitValue> values(std::size_t unit = 0) const;
  /// Of each axis, what its temperatures, now and before, and its warm-up made of its bias in the second that has
  /// passed (at first: will make of it). Turn-on offset, bias instability, random walks and a hop are not in it: no
  /// temperature tells of them. No instrument can see it; the laboratory itself may be asked.
  [[nodiscard]] std::span<const DegreesPerHour> true_bias(std::size_t unit = 0) const;
  /// And of each axis what is not in it, for tests.
  [[nodiscard]] std::vector<DegreesPerHour> drift(std::size_t unit = 0) const;
  /// Where the bracket is on which a unit stands, for tests; nothing if it stands on none.
  [[nodiscard]] std::optional<Celsius> bracket(std::size_t unit) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace gyrotherm::simulator
