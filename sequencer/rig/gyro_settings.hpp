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
  bool can_be_turned{};      ///< people can turn it around in the chamber, so that its input axes point the other way
  bool go_on_when_silent{};  ///< the run goes on for the other units when it falls silent
  bool has_own_thermometers{};  ///< the rig file says which sit on it
  /// Bias that a good unit may have, °/h: its own or else that of its stream; nothing: neither states one.
  std::optional<double> largest_bias_deg_per_h{};
  std::size_t analogue_values{};  ///< how many of its values, the last ones, analogue inputs measure
};

/// A line, with the frames of everything that is read on it, and whose it is.
struct GyroLine {
  std::string line;
  drivers::FrameFormat frame;                 ///< of the axes of all its units
  std::optional<drivers::GyroStream> stream;  ///< where the rig file names one; its frame is `frame`
  bool listen_only{};                         ///< nothing is sent to the gyro
  struct Share {
    std::size_t unit{};                 ///< among the rig's
    std::vector<std::size_t> axes{};    ///< of its axes, where each is among the frame's
    std::vector<std::size_t> values{};  ///< … of its values
  };
  std::vector<Share> shares;
};

/// "gyro", "gyro u1", "gyro x+y+z": the line's instrument, in words.
[[nodiscard]] std::string title_of(const GyroLine& line, const std::vector<UnitSettings>& units);

/// Compares the identity of a line's gyro with the serial number in the rig file. Fails with mismatch if it names
/// another one. A line that several units share is not compared, nor a unit without a serial number.
[[nodiscard]] Result<void> compare_serial_number(const GyroLine& line, const std::vector<UnitSettings>& units,
                                                 const std::string& identity);

struct GyroSettings {
  std::vector<UnitSettings> units;
  std::vector<GyroLine> lines;
};

/// [gyro], a rig's only unit, or [[gyro]]. Each has a `line` with `stream` (a description's path relative to
/// `rig_file`) or a `frame` of its own, or `shares_line_with` another unit whose interface sends its frames too; the
/// `axis` of the stream that is wanted, or [[gyro.axis]] for each; `arcsec_per_pulse` where the frames do not say it;
/// how it points: `latitude`, `azimuth`, `elevation` of the one input axis, or each axis' `direction` in [fixture]; how
/// well all that is known; `rate_hz`, the frames a second that the unit is set to; `listen_only`, for a line that takes
/// no commands; `largest_bias_deg_per_h`; `can_be_turned`; `thermometers` and `three_point` that sit on it (`channels`
/// are all that there are); `values`, which of a shared line's are its own; `when_silent`. docs/files.md describes
/// every key. `known`: the texts of streams, by unit, where they are known already. Mistakes of the rig file are noted
/// in its tables; fails with bad_file if a description cannot be read or has mistakes of its own.
[[nodiscard]] Result<GyroSettings> read_gyros(const TomlTable& root, const std::string& rig_file,
                                              const std::vector<std::string>& channels,
                                              const std::map<std::string, std::string>& known);

/// The driver of a real one on `line`; one read may take `within`. The gyro is sent the stream's commands, and its line
/// is read all the time.
[[nodiscard]] std::unique_ptr<drivers::Gyro> make_gyro(const GyroLine& settings, const drivers::Line& line,
                                                       Duration within);
/// The driver of a simulated one, which sends one frame a second by itself and whose wire is there already; `clock`: of
/// a wire with a time of its own.
[[nodiscard]] std::unique_ptr<drivers::Gyro> make_simulated_gyro(const GyroLine& settings,
                                                                 std::unique_ptr<drivers::ByteStream> stream,
                                                                 Duration within, const Clock* clock = nullptr);

}  // namespace gyrotherm::rig
