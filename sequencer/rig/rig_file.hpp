// SPDX-License-Identifier: Apache-2.0
/// A rig in words: which instruments, on which lines, with which calibrations and limits. One TOML file per rig.
#pragma once

#include <map>
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
#include "drivers/instruments.hpp"
#include "drivers/line/line_address.hpp"
#include "drivers/line/link_settings.hpp"
#include "sequencer/interlocks/interlocks.hpp"
#include "sequencer/interlocks/limits.hpp"
#include "sequencer/profile/profile.hpp"
#include "sequencer/rig/analogue_settings.hpp"
#include "sequencer/rig/gyro_settings.hpp"
#include "sequencer/rig/thermometer_settings.hpp"
#include "simulator/virtual_laboratory.hpp"

namespace gyrotherm::rig {

struct Limiter {
  std::string protection_class;            ///< DIN 12880: "1", "2", "3.1" (over), "3.2" (under), "3.3" (both)
  std::optional<Celsius> lowest, highest;  ///< what it is set to; nothing: it does not look to that side
};

/// "class 3.3, below -50 °C, above 75 °C": when it trips.
[[nodiscard]] std::string in_words(const Limiter& limiter);

struct RigFile {
  std::string name;
  std::string title;
  std::string text;                  ///< the file, as read
  std::string file;                  ///< its path, as given
  drivers::RegisterMap chamber_map;  ///< on the link that suits the line
  std::string chamber_line;
  std::string chamber_power;                             ///< a power switch of the map, or empty
  drivers::LinkSettings chamber_link{};                  ///< replace those of the map
  std::optional<drivers::WordOrder> chamber_word_order;  ///< where the map's own does not suit the unit
  profile::ChamberLimits chamber_limits;
  Celsius safe_set_point;
  std::optional<Limiter> limiter;  ///< the chamber's own
  std::vector<ThermometerSettings> thermometers;
  std::vector<UnitSettings> units;  ///< under test, at least one
  std::vector<GyroLine> gyro_lines;
  std::vector<AnalogueSettings> analogue_inputs;
  bool safe_off{};  ///< safe is to be switched off, too
  /// Time for which the air of a chamber that was made safe is watched; 0: it is not.
  Duration safe_observe = std::chrono::minutes(5);
  interlocks::InterlockLimits limits;
  interlocks::RunLimits run_limits;
  bool simulated{};                     ///< every line is "virtual"; mixed rigs are refused
  simulator::GyroModelUsed gyro_model;  ///< of a virtual rig
};

/// The texts of the files that a rig file names, where they are already known (resume: the record's copies).
struct NamedTexts {
  std::optional<std::string> chamber_map{};           ///< [chamber] map
  std::optional<std::string> gyro_model{};            ///< [virtual.thermal] gyro
  std::map<std::string, std::string> gyro_streams{};  ///< [gyro] or [[gyro]] stream, by the unit's name
  std::vector<std::string> analogue_maps{};           ///< [[analogue_input]] map, in the order of the file
  std::string folder{};                               ///< where commands run; empty: the file's
};

/// Fails with bad_file, every mistake with its place. What `known` does not hold is read from its file, relative to
/// `file`. The rest of [virtual] is checked by parse_laboratory.
[[nodiscard]] Result<RigFile> parse_rig(std::string_view text, const std::string& file, const NamedTexts& known = {});
/// Does the same with a file, or with the shipped rig of that name.
[[nodiscard]] Result<RigFile> read_rig(const std::string& given);

/// The texts of the maps of all units of analogue inputs, in order of the file.
[[nodiscard]] std::vector<std::string> analogue_map_texts_of(const RigFile& rig);

/// All channels of all thermometers, in order of the file, each with the unit under test that it sits on; one that
/// several share, or that none has, is the rig's.
[[nodiscard]] std::vector<record::Channel> channels_of(const RigFile& rig);

/// The line on which the unit numbered `unit` is read.
[[nodiscard]] const GyroLine& line_of(const RigFile& rig, std::size_t unit);

}  // namespace gyrotherm::rig
