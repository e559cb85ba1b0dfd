// SPDX-License-Identifier: Apache-2.0
/// The gyros of a rig file, [gyro] or each [[gyro]]: the units under test with their axes, and the lines on which they
/// are read.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/record/run_info.hpp"
#include "core/result.hpp"
#include "core/toml_reader.hpp"
#include "drivers/gyro/framed_gyro.hpp"
#include "drivers/instruments.hpp"
#include "drivers/line/line_address.hpp"

namespace gyrotherm::rig {

/// A unit under test.
struct UnitSettings {
  record::UnitInfo info;
  /// The unit can be turned around in the chamber, which reverses its input axes.
  bool can_be_turned{};
  /// The run continues for the other units if this one is silent.
  bool continue_when_silent{};
  /// The rig file assigns thermometers to this unit.
  bool has_own_thermometers{};
  /// The rig file states the thermometers of this unit's three-point model, possibly none.
  bool has_own_three_point{};
  /// Largest bias of a good unit, °/h, from the unit's table or otherwise from its stream; absent if neither states
  /// one.
  std::optional<double> largest_bias_deg_per_h{};
  /// Number of the unit's values that analogue inputs measure. They follow the values of the frames.
  std::size_t analogue_values{};
};

/// A line, the frames of all units on it, and each unit's share of them.
struct GyroLine {
  std::string line;
  /// Frame with the axes of all its units.
  drivers::FrameFormat frame;
  /// Stream that the rig file names; its frame is `frame`.
  std::optional<drivers::GyroStream> stream;
  /// Nothing is sent to the gyro.
  bool listen_only{};
  struct Share {
    /// Index among the rig's units.
    std::size_t unit{};
    /// For each axis of the unit, its index in the frame.
    std::vector<std::size_t> axes{};
    /// For each value of the unit, its index in the frame.
    std::vector<std::size_t> values{};
  };
  std::vector<Share> shares;
};

/// Returns the title of the line's instrument: "gyro", "gyro u1", "gyro x+y+z".
[[nodiscard]] std::string line_title(const GyroLine& line, const std::vector<UnitSettings>& units);

/// Compares the identity of a line's gyro with the serial number of its unit. Fails with mismatch if the identity does
/// not contain the number as a token. Skips lines that several units share, and units without a serial number.
[[nodiscard]] Result<void> compare_serial_number(const GyroLine& line, const std::vector<UnitSettings>& units,
                                                 const std::string& identity);

/// Reads a list of thermometer channels. Notes an error for a name that is not in `channels` or is listed twice, unless
/// `channels` is empty, which is an error already.
[[nodiscard]] std::vector<std::string> read_channel_names(const TomlTable& table, const char* key,
                                                          const std::vector<std::string>& channels);

struct GyroSettings {
  std::vector<UnitSettings> units;
  std::vector<GyroLine> lines;
};

/// Reads [gyro], a rig's only unit, or every [[gyro]]. Keys: `line` with `stream` (a description's path relative to
/// `rig_file`) or with its own `frame`, or `shares_line_with` another unit whose interface also sends this unit's
/// frames; `axis`, the stream's axis to use, or [[gyro.axis]] for each; `arcsec_per_pulse` if the frames have no scale;
/// the direction: `latitude`, `azimuth`, `elevation` of a single input axis, or the `direction` of each axis in
/// [fixture]; the uncertainties of these; `rate_hz`, the unit's frame rate; `listen_only` for a line without commands;
/// `largest_bias_deg_per_h`; `can_be_turned`; `thermometers` and `three_point` on the unit (`channels`: all channels of
/// the rig); `values`, the unit's own values of a shared line; `when_silent`. docs/files.md describes every key.
/// `known` contains the texts of streams by unit, if they are known already. Records errors of the rig file in its
/// tables. Fails with bad_file if a description cannot be read or has errors.
[[nodiscard]] Result<GyroSettings> read_gyros(const TomlTable& root, const std::string& rig_file,
                                              const std::vector<std::string>& channels,
                                              const std::map<std::string, std::string>& known);

/// Makes the driver of a real gyro on `line`; one read takes at most `within`. It sends the stream's commands to the
/// gyro, and reads the line continuously.
[[nodiscard]] std::unique_ptr<drivers::Gyro> make_gyro(const GyroLine& settings, const drivers::Line& line,
                                                       Duration within);
/// Makes the driver of a simulated gyro, which sends one frame a second by itself on a wire that exists already.
/// `clock` is the clock of a wire with its own time.
[[nodiscard]] std::unique_ptr<drivers::Gyro> make_simulated_gyro(const GyroLine& settings,
                                                                 std::unique_ptr<drivers::ByteStream> stream,
                                                                 Duration within, const Clock* clock = nullptr);

}  // namespace gyrotherm::rig
