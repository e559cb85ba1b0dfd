/// A rig in words: which instruments, on which lines, with which calibrations and limits. One TOML file per rig.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/record/run_info.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"
#include "drivers/chamber/register_map.hpp"
#include "rig/gyro_settings.hpp"
#include "rig/limiter.hpp"
#include "rig/thermometer_settings.hpp"
#include "sequencer/interlocks/interlocks.hpp"
#include "sequencer/interlocks/limits.hpp"
#include "sequencer/profile/profile.hpp"
#include "simulator/virtual_laboratory.hpp"

namespace gyrotherm {

struct RigFile {
  std::string name;
  std::string title;
  std::string text;         ///< the file, as read
  std::string file;         ///< its path, as given
  RegisterMap chamber_map;  ///< on the link that suits the line
  std::string chamber_line;
  std::optional<WordOrder> chamber_word_order;  ///< where the map's own does not suit the unit
  ChamberLimits chamber_limits;
  Celsius safe_set_point;
  std::optional<Limiter> limiter;  ///< the chamber's own
  std::vector<ThermometerSettings> thermometers;
  GyroSettings gyro;
  std::vector<std::string> gradients;
  std::vector<std::string> three_point;
  bool safe_off{};  ///< safe is to be switched off, too
  InterlockLimits limits;
  RunLimits run_limits;
  bool simulated{};          ///< every line is "virtual"; mixed rigs are refused
  GyroModelUsed gyro_model;  ///< of a virtual rig
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
[[nodiscard]] std::vector<Channel> channels_of(const RigFile& rig);

}  // namespace gyrotherm
