// SPDX-License-Identifier: Apache-2.0
/// A rig in words: which instruments, on which lines, with which calibrations and limits. One TOML file per rig.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/record/run_info.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"
#include "core/toml_reader.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/gyro/framed_gyro.hpp"
#include "drivers/instruments.hpp"
#include "drivers/line/line_address.hpp"
#include "rig/thermometer_settings.hpp"
#include "sequencer/interlocks/interlocks.hpp"
#include "sequencer/interlocks/limits.hpp"
#include "sequencer/profile/profile.hpp"
#include "simulator/virtual_laboratory.hpp"

namespace gyrotherm::rig {

struct Limiter {
  std::string protection_class;            ///< DIN 12880: "1", "2", "3.1" (over), "3.2" (under), "3.3" (both)
  std::optional<Celsius> lowest, highest;  ///< what it is set to; nothing: it does not look to that side
};

/// "class 3.3, below -50 °C, above 75 °C": when it trips.
[[nodiscard]] std::string in_words(const Limiter& limiter);

struct GyroSettings {
  std::string line;
  drivers::FrameFormat frame;
  std::optional<drivers::GyroStream> stream;  ///< where the rig file names one; its frame is `frame`
  record::GyroInfo info;
  bool can_be_turned{};  ///< people can turn it around in the chamber, so that its input axis points the other way
};

/// Either [gyro.frame], or `stream`, a description's path relative to `rig_file`, with the `axis` wanted;
/// `arcsec_per_pulse` where the frames do not say it; `latitude`, `azimuth`, `elevation` of the input axis in degrees,
/// and how well they, the scale factor and the turn-on bias are known; `can_be_turned`.
/// `known`: the description's text where it is known already. Mistakes of the rig file are noted in the table; fails
/// with bad_file if the description cannot be read or has mistakes of its own.
[[nodiscard]] Result<GyroSettings> read_gyro(const TomlTable& table, const std::string& rig_file,
                                             const std::optional<std::string>& known);

/// The driver of a real one on `line`; one read may take `within`. The gyro is sent the stream's commands, and its line
/// is read all the time.
[[nodiscard]] std::unique_ptr<drivers::Gyro> make_gyro(const GyroSettings& settings, const drivers::Line& line,
                                                       Duration within);
/// The driver of a simulated one, which sends one frame a second by itself and whose wire is there already; `clock`: of
/// a wire with a time of its own.
[[nodiscard]] std::unique_ptr<drivers::Gyro> make_simulated_gyro(const GyroSettings& settings,
                                                                 std::unique_ptr<drivers::ByteStream> stream,
                                                                 Duration within, const Clock* clock = nullptr);

struct RigFile {
  std::string name;
  std::string title;
  std::string text;                  ///< the file, as read
  std::string file;                  ///< its path, as given
  drivers::RegisterMap chamber_map;  ///< on the link that suits the line
  std::string chamber_line;
  std::optional<drivers::WordOrder> chamber_word_order;  ///< where the map's own does not suit the unit
  profile::ChamberLimits chamber_limits;
  Celsius safe_set_point;
  std::optional<Limiter> limiter;  ///< the chamber's own
  std::vector<ThermometerSettings> thermometers;
  GyroSettings gyro;
  std::vector<std::string> gradients;
  std::vector<std::string> three_point;
  bool safe_off{};  ///< safe is to be switched off, too
  interlocks::InterlockLimits limits;
  interlocks::RunLimits run_limits;
  bool simulated{};                     ///< every line is "virtual"; mixed rigs are refused
  simulator::GyroModelUsed gyro_model;  ///< of a virtual rig
};

/// The texts of the files that a rig file names, where they are already known (resume: the record's copies).
struct NamedTexts {
  std::optional<std::string> chamber_map;    ///< [chamber] map
  std::optional<std::string> gyro_model;     ///< [virtual.thermal] gyro
  std::optional<std::string> gyro_stream{};  ///< [gyro] stream
};

/// Fails with bad_file, every mistake with its place. What `known` does not hold is read from its file, relative to
/// `file`. The rest of [virtual] is checked by parse_laboratory.
[[nodiscard]] Result<RigFile> parse_rig(std::string_view text, const std::string& file, const NamedTexts& known = {});
[[nodiscard]] Result<RigFile> read_rig(const std::string& file);

/// All channels of all thermometers, in order of the file.
[[nodiscard]] std::vector<record::Channel> channels_of(const RigFile& rig);

}  // namespace gyrotherm::rig
