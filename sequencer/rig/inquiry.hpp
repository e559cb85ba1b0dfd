// SPDX-License-Identifier: Apache-2.0
/// Queries each instrument before a run and describes the answers as text. Does not move the chamber.
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
#include "sequencer/rig/supply_settings.hpp"

namespace gyrotherm::rig {

/// Puts the title of an instrument in front of the position of a fault, unless the position begins with it: "chamber:
/// tcp 10.0.0.5:502".
[[nodiscard]] Fault name_instrument(const std::string& title, Fault fault);

/// Durations of the successful ones of ten calls; zero if all failed.
struct RoundTrips {
  Duration least{}, median{}, most{};
  std::size_t failed = 0;
  /// The fault of the first call that failed.
  std::optional<Fault> fault{};
};
/// Calls the function ten times and measures the duration of each successful call with `clock`.
[[nodiscard]] RoundTrips time_calls(const std::function<Result<void>()>& call, const Clock& clock);
/// Returns "10 reads: 0.210, 0.230, 0.410 ms (least, median, most)", with a warning if calls failed.
[[nodiscard]] std::string text(const RoundTrips& trips);
/// Fails with the first fault if half of the calls failed, or more.
[[nodiscard]] Result<void> check_calls(const RoundTrips& trips);

/// Describes whether the exchanges with the chamber fit into one second, and suggests a remedy if they do not. Returns
/// an empty text if their number is unknown.
[[nodiscard]] std::string describe(const drivers::ChamberEffort& effort);

/// Decodes the chamber's air temperature and set point in every word order; empty if the map needs no decision. Fails
/// as the registers do.
[[nodiscard]] Result<std::vector<drivers::OrderFinding>> find_word_orders(const drivers::RegisterMap& map,
                                                                          drivers::Registers& registers);
/// Describes the word orders that give plausible values of the chamber's air temperature and set point; empty if the
/// map needs no decision.
[[nodiscard]] Result<std::string> query_word_order(const drivers::RegisterMap& map, drivers::Registers& registers);
/// Describes the chamber: identity, state, verified items, missing items, and the time of ten readings. Warns if some
/// of these fail. Fails with the first fault, also if half of the ten readings fail.
[[nodiscard]] Result<std::string> query_chamber(drivers::Chamber& chamber, const Clock& clock);
/// Longest time for one reading of a thermometer in a run.
inline constexpr Duration kLongestScan = std::chrono::milliseconds(800);
/// Describes a thermometer: identity, one reading or fault of each channel, and the time of ten readings. Fails if it
/// cannot be identified, if half of the readings lose a channel, and with timeout if a reading takes longer than
/// kLongestScan.
[[nodiscard]] Result<std::string> query_thermometer(drivers::Thermometer& thermometer,
                                                    const std::vector<std::string>& channels, const Clock& clock);
/// The conversion of an input's reading to the value of a channel.
struct AnalogueReading {
  std::string channel;  ///< "u1.discharge_current_a"
  std::string unit;     ///< unit of measure
  double scale = 1;
  double offset = 0;
};
/// Describes analogue inputs: identity, one value or fault of each channel, and the time of ten readings. Fails if they
/// cannot be identified, or if half of the readings lose a channel.
[[nodiscard]] Result<std::string> query_analogue(drivers::AnalogueInputs& inputs,
                                                 const std::vector<AnalogueReading>& channels, const Clock& clock);
/// Describes a supply: identity, state, settings and readings of each used output, and the time of ten readings. Warns
/// if an output that is on has other settings than the rig file. Fails if it cannot be identified, or if half of the
/// readings lose an output.
[[nodiscard]] Result<std::string> query_supply(drivers::PowerSupply& supply, const SupplySettings& settings,
                                               const Clock& clock);
/// Returns a warning if the chamber's air differs from every thermometer by more than 15 K: one of the instruments then
/// probably reports another unit of measure, or is not in this chamber. Returns an empty text otherwise, or if there is
/// no thermometer.
[[nodiscard]] std::string describe_air_mismatch(Celsius air, const std::vector<Celsius>& thermometers);
/// Describes an axis: the measured rate and the Earth's rate along the axis. Warns if they differ by more than half of
/// the Earth's rate (at least 1.5 °/h), plus the bias that the unit may have, plus one count.
[[nodiscard]] std::string describe_rate(const std::string& axis, DegreesPerHour measured,
                                        std::optional<DegreesPerHour> earth_rate, DegreesPerHour largest_bias,
                                        DegreesPerHour one_count);
/// Reads a gyro for two seconds and describes it: each axis (describe_rate), the housekeeping received, the numbers of
/// frames seen, lost and bad, and the unit's verified settings. `units` contains all units of the rig. `is_simulated`
/// is true if the gyro accepts no commands. `let_pass` advances a clock that does not run by itself by one second.
[[nodiscard]] Result<std::string> query_gyro(drivers::Gyro& gyro, const GyroLine& line,
                                             const std::vector<UnitSettings>& units, bool is_simulated,
                                             const std::function<void()>& let_pass);

}  // namespace gyrotherm::rig
