// SPDX-License-Identifier: Apache-2.0
/// Commands that are sent to a gyro before its frames are read, and verification of the settings that determine the
/// meaning of the frames.
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

/// A command to a gyro, and the answer that must arrive within `wait`. If `reply` and `messages` are empty, no answer
/// is required.
struct GyroCommand {
  std::string send;
  Duration wait{};
  std::string reply;
  /// Start of an answer that refuses the command.
  std::string refusal{};
  /// Ids of messages, any of which is an answer.
  std::vector<std::uint32_t> messages{};
  /// For the simulator: true if the command stops the stream of frames, false if it starts it, empty if it does
  /// neither.
  std::optional<bool> then_silent{};
  /// `send`, `reply` and `refusal` are bytes instead of text.
  bool is_binary{};
};

/// A query for the identity of a gyro.
struct IdentityQuery {
  std::string send;
  Duration wait{};
  /// Texts around the identity in the answer.
  std::string begins;
  std::string ends;
};
/// Reads the table [identity]: `send`, `wait`, `begins`, `ends`.
[[nodiscard]] IdentityQuery read_identity_query(const TomlTable& table);
/// Sends the query. Returns the text between `begins` and `ends`, or an empty text if it does not arrive within `wait`.
/// Fails with the fault of the line.
[[nodiscard]] Result<std::string> query_identity(const IdentityQuery& query, ByteStream& line, Duration within,
                                                 const Clock* clock);

/// Returns true if the command requires an answer.
[[nodiscard]] bool requires_answer(const GyroCommand& command);
/// Returns the name of a command in messages and in [[setting]]: the first line of its text, or its bytes like
/// "FA FF 30 00 D1".
[[nodiscard]] std::string command_name(const GyroCommand& command);
/// Returns the first line of a text, without its line end.
[[nodiscard]] std::string first_line(const std::string& text);

/// Replaces each "{rate_hz}" in the text by the rate.
[[nodiscard]] std::string substitute_rate(std::string text, double rate_hz);

/// Reads the tables `key`, [[start]] or [[stop]]: `send`, `wait`, `reply`, `refusal`, `message` and `then`. "{rate_hz}"
/// in `send` and `reply` is replaced by the frame rate of `format`. A command in bytes has `send_bytes`, `reply_bytes`
/// and `refusal_bytes` instead. Errors are noted in the tables.
[[nodiscard]] std::vector<GyroCommand> read_commands(const TomlTable& root, const char* key, const FrameFormat& format);

/// Sends a command and waits for its answer, or for the whole of `wait` if no answer is required. `within` limits the
/// write. An echo of the command is not accepted as an answer, except for a required reply that is the beginning of the
/// command. If only an echo arrives, the command is sent once more, because the end of a frame before the reply may
/// look like the beginning of an echo. Fails with timeout if no answer arrives (the fault contains the received bytes),
/// refused if the answer begins with `refusal`, mismatch if a required message shows settings that differ from the
/// description, or with the fault of the line.
[[nodiscard]] Result<void> send_command(const GyroCommand& command, const FrameFormat& format, ByteStream& line,
                                        Duration within, const Clock* clock);

/// Means by which a setting is verified.
enum class SettingEvidence {
  /// The answer to a start command.
  reply,
  /// A decoded configuration message.
  message,
  /// A field of each frame.
  frame,
  /// The measured frame rate.
  pace,
  /// Not verified.
  nothing,
};

/// A setting of the gyro that the meaning of the frames depends on.
struct StreamSetting {
  std::string name;
  std::string value;  ///< assumed by the description
  /// Property of the frames that another value would change: "scale", "content" or "rate".
  std::string affects;
  SettingEvidence evidence{};
  std::string note{};  ///< reason if not verified
};

/// Reads the tables [[setting]] of a stream. The evidence `reply` requires a command of `start` with an answer,
/// `message` requires a field with a `mismatch` rule, `pace` requires `rate_hz`, and `nothing` requires a note. Errors
/// are noted in the tables.
[[nodiscard]] std::vector<StreamSetting> read_settings(const TomlTable& root, const std::vector<GyroCommand>& start,
                                                       const FrameFormat& format);

/// Returns the verified and unverified settings as text: "verified: rotation in radians; NOT verified: filter as found
/// (…)". Empty if there are no settings. Unless `is_queried`, the start commands were not sent, and settings that need
/// them are unverified.
[[nodiscard]] std::string describe(const std::vector<StreamSetting>& settings, bool is_queried);

}  // namespace gyrotherm::drivers
