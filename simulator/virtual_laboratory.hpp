// SPDX-License-Identifier: Apache-2.0
/// The virtual laboratory, one second at a time: a chamber's air, the gyro as a thermal body, its bias and its
/// read-out. Reading has no side effects: every random number belongs to a step, so that a world is reproduced by its
/// seed and the set points of its steps alone.
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
  std::string name;  ///< of the reduced gyro's file, without its endings: "calibrated"
  std::string film;  ///< "chamber" or "still": how the air moves around the cabinet
  std::string text;  ///< the file, as read
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

/// Which gyro, which of its runs, and when: two runs of one gyro share its physics and none of its noise.
struct LaboratorySeed {
  std::uint64_t gyro{};          ///< 0 is the gyro of the file exactly; any other draws another gyro of the same type
  std::uint64_t run{};           ///< draws the noise
  std::uint64_t days_later = 0;  ///< the gyro and its thermometers are so much older; at most kMostDaysLater
};

/// The laboratory as it stands when chamber and gyro have long been at `first`, which the controller must accept.
[[nodiscard]] LaboratoryParameters soaked_at(LaboratoryParameters parameters, Celsius first);

class VirtualLaboratory {
 public:
  VirtualLaboratory(const LaboratoryParameters& parameters, LaboratorySeed seed);
  ~VirtualLaboratory();
  VirtualLaboratory(VirtualLaboratory&&) noexcept;
  VirtualLaboratory& operator=(VirtualLaboratory&&) noexcept;

  /// Whether the controller can be told this.
  [[nodiscard]] bool accepts(Celsius set_point) const;
  /// What the controller is told, which it must accept; in force from the next step on.
  void command(Celsius set_point);
  void switch_on(bool on);
  /// The gyro is so from the next step on: without power it is silent, cools down and, switched on again, starts anew;
  /// turned around it sees the Earth's rate with the other sign.
  void bring_unit_to(const UnitState& state);
  /// Breaks what `faults` says, and mends what it does not: the chamber from the next step on, thermometers at once.
  void inject(const LaboratoryFaults& faults);
  /// Lets one second pass.
  void step();

  [[nodiscard]] Celsius set_point() const;
  [[nodiscard]] bool is_on() const;
  [[nodiscard]] const UnitState& unit() const;
  [[nodiscard]] Celsius air_as_measured() const;  ///< by the chamber's own sensor: noise, resolution
  [[nodiscard]] double output_percent() const;    ///< −100 (full cooling) … 100 (full heating)
  [[nodiscard]] std::span<const double> thermometers_as_measured_c() const;  ///< in the order of thermometer_names()
  [[nodiscard]] const std::vector<std::string>& thermometer_names() const;
  [[nodiscard]] std::int64_t pulses() const;          ///< accumulated
  [[nodiscard]] std::int64_t device_time_us() const;  ///< the gyro's own clock, with its skew
  [[nodiscard]] double arcsec_per_pulse() const;
  /// What its temperatures, now and before, and its warm-up made of the gyro's bias in the second that has passed (at
  /// first: will make of it). Turn-on offset, bias instability and random walks are not in it: no temperature tells of
  /// them. No instrument can see it; the laboratory itself may be asked.
  [[nodiscard]] DegreesPerHour true_bias() const;
  [[nodiscard]] DegreesPerHour drift() const;  ///< and that is what is not in it, for tests

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace gyrotherm::simulator
