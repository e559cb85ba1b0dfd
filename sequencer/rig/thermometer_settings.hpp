// SPDX-License-Identifier: Apache-2.0
/// A [[thermometer]] of a rig file: an instrument, its line and its calibrations.
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
#include "sequencer/rig/thermometer_certificate.hpp"

namespace gyrotherm::rig {

struct ThermometerSettings {
  /// Keyword of `kind` in the rig file.
  std::string driver;
  drivers::ThermometerKind kind{};
  std::string line;
  /// Channels in the order of the instrument's inputs.
  std::vector<std::string> channels;
  /// The channels as stored in the record.
  std::vector<record::Channel> calibrated;
  /// Names of the channels with a table [[thermometer.calibration]].
  std::set<std::string> individually_calibrated{};
  /// For dcon: addresses of the modules on the line.
  std::vector<std::uint8_t> addresses{1};
  drivers::DconChecksum checksum{};  ///< dcon
  /// For dcon: required type of the modules.
  std::optional<std::uint8_t> type;
  /// For mcc_usb_temp: sensor at each input. If absent, the configuration of the instrument is kept.
  std::optional<drivers::MccSensor> sensor;
  /// For process: the driver program.
  drivers::ProgramCommand command;
  /// For text: the description, with the parameters and link settings of the rig and the link for the line. Empty if it
  /// could not be read.
  std::optional<drivers::ThermometerDescription> description;
  /// The line of a thermometer without a description returns every request.
  bool echo{};
  std::string place;
  /// Certificate files whose values `calibrated` does not contain yet.
  std::vector<NamedCertificate> certificates{};
};

/// Reads the descriptions that the thermometers of a rig file name.
class DescriptionReader {
 public:
  /// Names are relative to `rig_file`. `known` contains the texts of the descriptions if they are known already, in
  /// order of the file.
  explicit DescriptionReader(std::string rig_file, std::vector<std::string> known = {});
  /// Reads the description that a thermometer names, with the link for `line`. Returns nothing on failure.
  [[nodiscard]] std::optional<drivers::ThermometerDescription> read(const TomlTable& thermometer,
                                                                    const std::string& line);
  /// Fails with bad_file if a description could not be read, with the first failure.
  [[nodiscard]] const Result<void>& outcome() const { return outcome_; }

 private:
  std::string rig_file_;
  std::vector<std::string> known_;
  std::size_t next_ = 0;
  Result<void> outcome_;
};

/// Reads the thermometer numbered `number`, from 1. Keys: driver, line, channels; the calibrations by `offsets` (K, one
/// per channel) or [[thermometer.calibration]] (channel, offset or polynomial, certificate, due); `certificate` and
/// `due` for all channels without their own (a `certificate` that ends in .xml is a file, with the `serial_number` of
/// its item; its values are not read here); `uncertainty` (K) with its `coverage_factor` or `distribution`,
/// `drift_k_per_year` and `calibrated` (a day), in either table; and the keys of the driver: addresses, checksum and
/// type (dcon), [thermometer.sensor] (mcc_usb_temp), [thermometer.link] (`echo`, for a line that carries bytes; text:
/// as [chamber.link]), command (process: its line is absent or "virtual", and its command runs in `folder`),
/// description and [thermometer.parameter] (text). `seen` contains the channels of the rig so far.
[[nodiscard]] ThermometerSettings read_thermometer(const TomlTable& table, const std::string& folder,
                                                   std::size_t number, std::set<std::string>& seen,
                                                   DescriptionReader& descriptions);

/// Makes the driver of a real thermometer on `line`. `place` names the instrument in its faults.
[[nodiscard]] std::unique_ptr<drivers::Thermometer> make_thermometer(const ThermometerSettings& settings,
                                                                     const std::string& place,
                                                                     const drivers::Line& line);
/// Makes the driver of a real thermometer whose driver is a program.
[[nodiscard]] std::unique_ptr<drivers::Thermometer> make_process_thermometer(const ThermometerSettings& settings,
                                                                             const std::string& place);
/// Makes the driver of a byte-oriented thermometer on an existing wire. A simulated one has no pauses. `clock` is the
/// clock of a wire with its own time.
[[nodiscard]] std::unique_ptr<drivers::Thermometer> make_thermometer(const ThermometerSettings& settings,
                                                                     const std::string& place,
                                                                     std::unique_ptr<drivers::ByteStream> stream,
                                                                     bool simulated, const Clock* clock = nullptr);
/// Makes the driver of a USB-TEMP on an existing wire. `clock` is the clock of a wire with its own time.
[[nodiscard]] std::unique_ptr<drivers::Thermometer> make_usb_temp(const ThermometerSettings& settings,
                                                                  const std::string& place,
                                                                  std::unique_ptr<drivers::HidReports> reports,
                                                                  const Clock* clock = nullptr);

}  // namespace gyrotherm::rig
