// SPDX-License-Identifier: Apache-2.0
/// Settings of a gyro on which the meaning of its frames depends, and how each is verified.
#pragma once

#include <string>
#include <vector>

#include "core/toml_reader.hpp"
#include "drivers/gyro/start_command.hpp"

namespace gyrotherm::drivers {

/// Ways to verify that a setting has the described value.
enum class SettingEvidence {
  reply,    ///< a start command is answered
  message,  ///< a configuration message is decoded
  frame,    ///< each frame carries it
  pace,     ///< frames are timed
  nothing,  ///< not verified
};

/// One setting: its described value, and what a wrong one would change.
struct StreamSetting {
  std::string name;
  std::string value;
  std::string affects;  ///< "scale", "content" or "rate"
  SettingEvidence evidence{};
  std::string note{};  ///< reason for `nothing`
};

/// Reads the tables [[setting]] of a stream. A setting that a reply shows names a command of `start` that is answered;
/// one that a message shows needs a field with a rule of the verdict `mismatch`; one that the pace shows needs
/// `rate_hz`; one that nothing shows needs a note. Mistakes are noted in the tables.
[[nodiscard]] std::vector<StreamSetting> read_settings(const TomlTable& root, const std::vector<GyroCommand>& start,
                                                       const FrameFormat& format);

/// Describes what was verified and what was not: "verified: rotation in radians; NOT verified: filter as found (…)".
/// `is_asked`: the start commands were sent. Empty without settings.
[[nodiscard]] std::string in_words(const std::vector<StreamSetting>& settings, bool is_asked);

}  // namespace gyrotherm::drivers
