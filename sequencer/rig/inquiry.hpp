// SPDX-License-Identifier: Apache-2.0
/// What each instrument is asked before a run, in lines for people; nothing is moved.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/clock.hpp"
#include "core/result.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/instruments.hpp"
#include "drivers/wires.hpp"
#include "sequencer/rig/gyro_settings.hpp"

namespace gyrotherm::rig {

/// How long some calls took.
struct RoundTrips {
  Duration least{}, median{}, most{};
};
/// Ten of them, by `clock`.
[[nodiscard]] RoundTrips time_calls(const std::function<void()>& call, const Clock& clock);
/// "10 reads: 0.210, 0.230, 0.410 ms (least, median, most)".
[[nodiscard]] std::string text(const RoundTrips& trips);

/// Whether a second suffices to speak to the chamber on its line, and what to do if not; empty where nothing is known
/// of the effort.
[[nodiscard]] std::string in_words(const drivers::ChamberEffort& effort);

/// Which word orders make sense of the unit's air temperature and set point; empty where the map leaves
/// nothing to find.
[[nodiscard]] Result<std::string> ask_word_order(const drivers::RegisterMap& map, drivers::Registers& registers);
/// Who it is, all that it says of itself, what of that it does not have, and how long ten readings take. Fails with the
/// first fault.
[[nodiscard]] Result<std::string> ask_chamber(drivers::Chamber& chamber, const Clock& clock);
/// The same, with one reading of each channel; one that is faulty says so in its place.
[[nodiscard]] Result<std::string> ask_thermometer(drivers::Thermometer& thermometer,
                                                  const std::vector<std::string>& channels, const Clock& clock);
/// How the reading of an input becomes the value of a channel.
struct AnalogueReading {
  std::string channel;  ///< "u1.discharge_current_a"
  std::string unit;     ///< of measure
  double scale = 1;
  double offset = 0;
};
/// Who it is, and one value of each channel, likewise.
[[nodiscard]] Result<std::string> ask_analogue(drivers::AnalogueInputs& inputs,
                                               const std::vector<AnalogueReading>& channels, const Clock& clock);
/// Warns if the air that a chamber shows is more than 15 K from every thermometer: then one of them is probably read in
/// another unit, or is not in this chamber. Empty: it is near one, or there is none.
[[nodiscard]] std::string warn_of_air(Celsius air, const std::vector<Celsius>& thermometers);
/// Describes an axis: the rate that it measured, beside the Earth's rotation on it; a warning if they disagree by more
/// than half of that rotation (at least 1.5 °/h), the bias that the unit may have, and one count.
[[nodiscard]] std::string describe_rate(const std::string& axis, DegreesPerHour measured,
                                        std::optional<DegreesPerHour> earth_rate, DegreesPerHour largest_bias,
                                        DegreesPerHour one_count);
/// Reads a gyro for two seconds and describes it: each axis (describe_rate), its housekeeping as far as it came, how
/// many frames were seen, lost and bad, and which settings of the unit were verified. `units`: the rig's.
/// `is_simulated`: the gyro takes no commands. `let_pass` lets a second pass where it does not pass by itself.
[[nodiscard]] Result<std::string> ask_gyro(drivers::Gyro& gyro, const GyroLine& line,
                                           const std::vector<UnitSettings>& units, bool is_simulated,
                                           const std::function<void()>& let_pass);

}  // namespace gyrotherm::rig
