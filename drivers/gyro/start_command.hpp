// SPDX-License-Identifier: Apache-2.0
/// Commands that a gyro is sent before its frames are read, and the evidence that it obeyed: the settings on which the
/// meaning of its frames depends, and how each of them is verified.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/clock.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"
#include "core/toml_reader.hpp"
#include "drivers/gyro/frame_format.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm::drivers {

/// A command, and what must come within `wait` of it. Without `reply` and `messages` nothing is required.
struct GyroCommand {
  std::string send;
  Duration wait{};
  std::string reply;
  std::string refusal{};                  ///< begins an answer that refuses
  std::vector<std::uint32_t> messages{};  ///< ids, one of which must come
  /// The gyro then sends no frames, or sends them again; nothing: it continues. For the simulator.
  std::optional<bool> then_silent{};
};

/// A question for the identity of a gyro.
struct GyroQuestion {
  std::string send;
  Duration wait{};
  std::string begins;  ///< the identity follows this
  std::string ends;    ///< and ends before this
};
/// Reads the table [identity]: `send`, `wait`, `begins`, `ends`.
[[nodiscard]] GyroQuestion read_question(const TomlTable& table);
/// Asks the question. Returns the text between `begins` and `ends`; empty if none comes within `wait`. Fails with the
/// fault of the line.
[[nodiscard]] Result<std::string> ask_question(const GyroQuestion& question, ByteStream& line, Duration within,
                                               const Clock* clock);

/// True if the gyro must answer the command.
[[nodiscard]] bool is_answered(const GyroCommand& command);
/// Returns the first line of a text, without its end.
[[nodiscard]] std::string first_line(const std::string& text);

/// Replaces each "{rate_hz}" in the text.
[[nodiscard]] std::string with_rate(std::string text, double rate_hz);

/// Reads the tables `key`, [[start]] or [[stop]]: `send`, `wait`, `reply`, `refusal`, `message` and `then`. "{rate_hz}"
/// in `send` and `reply` becomes the frame rate of `format`. Mistakes are noted in the tables.
[[nodiscard]] std::vector<GyroCommand> read_commands(const TomlTable& root, const char* key, const FrameFormat& format);

/// Sends the command and waits for its answer, or for the whole of `wait` if none is required. The command's own text
/// that an adapter sends back is not an answer, unless the answer begins the command. Fails with timeout if no answer
/// comes (the fault reports what came instead), refused if the gyro refuses, mismatch if a message that is required
/// shows other settings than the description, or with the fault of the line. `within`: for the write.
[[nodiscard]] Result<void> send_command(const GyroCommand& command, const FrameFormat& format, ByteStream& line,
                                        Duration within, const Clock* clock);

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
