// SPDX-License-Identifier: Apache-2.0
/// A [[thermometer]] of a rig file: which instrument, on which line, with which calibrations.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "acquisition/record/run_info.hpp"
#include "core/toml_reader.hpp"
#include "drivers/instruments.hpp"
#include "drivers/line/line_address.hpp"
#include "drivers/line/process_stream.hpp"
#include "drivers/thermometer/dcon_thermometer.hpp"
#include "drivers/thermometer/mcc_usb_temp.hpp"
#include "drivers/thermometer/thermometer_kinds.hpp"

namespace gyrotherm::rig {

struct ThermometerSettings {
  std::string driver;  ///< the name of its kind
  drivers::ThermometerKind kind{};
  std::string line;
  std::vector<std::string> channels;         ///< in the order of the instrument's inputs
  std::vector<record::Channel> calibrated;   ///< the same, as the record keeps them
  std::vector<std::uint8_t> addresses{1};    ///< dcon: of the modules on the line
  drivers::DconChecksum checksum{};          ///< dcon
  std::optional<std::uint8_t> type;          ///< dcon: that the modules must be set to
  std::optional<drivers::MccSensor> sensor;  ///< mcc_usb_temp: at each input; nothing: as it was set up before
  drivers::ProgramCommand command;           ///< process: the program that is its driver
  bool echo{};                               ///< the line returns every request
  std::string place;
};

/// The one numbered `number`, from 1. Keys: driver, line, channels; the calibrations by `offsets` (K, one a channel) or
/// [[thermometer.calibration]] (channel, offset or polynomial, certificate, due), and `certificate` and `due` for all
/// channels without their own; `uncertainty` (K) with its `coverage_factor` or `distribution`, `drift_k_per_year` and
/// `calibrated` (a day) in either table likewise; and those of the driver: addresses, checksum and type (dcon),
/// [thermometer.sensor] (mcc_usb_temp), [thermometer.link] `echo` (of a line that carries bytes), command (process,
/// which has no line but "virtual"; it runs in `folder`). `seen`: the channels of the rig so far.
[[nodiscard]] ThermometerSettings read_thermometer(const TomlTable& table, const std::string& folder,
                                                   std::size_t number, std::set<std::string>& seen);

/// The driver of a real one, on `line`. `place` names the instrument in its faults.
[[nodiscard]] std::unique_ptr<drivers::Thermometer> make_thermometer(const ThermometerSettings& settings,
                                                                     const std::string& place,
                                                                     const drivers::Line& line);
/// The driver of a real one whose driver is a program.
[[nodiscard]] std::unique_ptr<drivers::Thermometer> make_process_thermometer(const ThermometerSettings& settings,
                                                                             const std::string& place);
/// The driver of one that is spoken to in bytes, whose wire is there already; a simulated one needs no pauses.
/// `clock`: of a wire with a time of its own.
[[nodiscard]] std::unique_ptr<drivers::Thermometer> make_thermometer(const ThermometerSettings& settings,
                                                                     const std::string& place,
                                                                     std::unique_ptr<drivers::ByteStream> stream,
                                                                     bool simulated, const Clock* clock = nullptr);
/// The driver of a USB-TEMP whose wire is there already; likewise.
[[nodiscard]] std::unique_ptr<drivers::Thermometer> make_usb_temp(const ThermometerSettings& settings,
                                                                  const std::string& place,
                                                                  std::unique_ptr<drivers::HidReports> reports,
                                                                  const Clock* clock = nullptr);

}  // namespace gyrotherm::rig
