// SPDX-License-Identifier: Apache-2.0
/// Requests that other programs send to a run, its answers, and the messages that carry them. Pure.
///
/// A message is one line of text in UTF-8: "gyrotherm-tell/1 COMMAND TEXT", or "gyrotherm-tell/1 for=USER COMMAND TEXT"
/// if a client acts for one of its own users. The answer is "gyrotherm-tell/1 done TEXT" or "gyrotherm-tell/1 refused
/// TEXT".
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm::control {

/// Commands of an operator, from the mildest to the most severe.
enum class OperatorCommand { resume, pause, stop, abort };

[[nodiscard]] const char* name(OperatorCommand command);

/// Longest note, and longest other text of a request, in bytes.
inline constexpr std::size_t kLongestNote = 2000;
/// Longest name of a monitor's user, in bytes.
inline constexpr std::size_t kLongestUser = 64;

/// Drops a unit under test from the run, or returns it.
struct UnitRequest {
  bool drop{};
  std::string unit;
  bool operator==(const UnitRequest&) const = default;
};

/// Acknowledges alarms. ControlRequest::note is the operator's comment.
struct Acknowledgement {
  std::vector<std::int64_t> alarms{};  ///< row numbers; empty: all
  bool operator==(const Acknowledgement&) const = default;
};

/// Shelves an alarm for a time, or unshelves it. ControlRequest::note is the reason of a shelving.
struct ShelvingRequest {
  std::int64_t alarm{};
  /// Whole seconds; absent: unshelves the alarm.
  std::optional<Duration> time{};
  bool operator==(const ShelvingRequest&) const = default;
};

/// One request: a command, a request for one unit, an acknowledgement, a shelving, a report of a sent notification, or
/// a note for the record.
struct ControlRequest {
  /// Absent: another kind of request.
  std::optional<OperatorCommand> command{};
  /// The answer given with a resume, the reason for a stop, an abort, a unit's request or a shelving, or the comment on
  /// an acknowledgement. In a report of a sent notification: its address, its rule and its alarm.
  std::string note{};
  std::optional<UnitRequest> unit{};
  std::optional<Acknowledgement> acknowledgement{};
  std::optional<ShelvingRequest> shelving{};
  /// The note reports a notification that was sent.
  bool told{};
  /// The monitor's user for whom the client acts; empty: the client acts for itself.
  std::string for_user{};
  bool operator==(const ControlRequest&) const = default;
};

/// The result of a request.
struct ControlAnswer {
  bool done{};
  /// The action that was carried out, or the reason of the refusal.
  std::string text;
  bool operator==(const ControlAnswer&) const = default;
};

/// Returns true if the text has no control characters.
[[nodiscard]] bool is_one_line(std::string_view text);
/// Returns true for a valid name of a monitor's user: 1 to 64 of [A-Za-z0-9_.@-].
[[nodiscard]] bool is_user_name(std::string_view name);

/// Parses a command and its text. "pause" has no text. "resume", "stop" and "abort" may have one: the answer or the
/// reason. "drop" and "return" have the unit's name and may have a reason. "acknowledge" has alarm numbers, separated
/// by commas, or "all", and a comment. "shelve" has an alarm number, a time such as "2 h" of 1 s to 24 h, and a reason.
/// "unshelve" has an alarm number. "told" and "note" have a text. A text is one line in UTF-8. Fails with usage.
[[nodiscard]] Result<ControlRequest> make_request(const std::string& keyword, const std::string& text);

/// Return the command and the text that make_request() would parse.
[[nodiscard]] std::string command_keyword(const ControlRequest& request);
[[nodiscard]] std::string command_text(const ControlRequest& request);

inline constexpr std::string_view kControlSchema = "gyrotherm-tell/1";
inline constexpr std::size_t kLongestRequest = 4096;  ///< bytes of a message

/// Writes a request. `for_user` must be empty or a valid name.
[[nodiscard]] std::string to_message(const ControlRequest& request);
/// Writes an answer, cut at kLongestRequest.
[[nodiscard]] std::string to_message(const ControlAnswer& answer);
/// Parse a message. Both fail with corrupted if the message has a form that to_message() does not write.
[[nodiscard]] Result<ControlRequest> parse_request(std::string_view message);
[[nodiscard]] Result<ControlAnswer> parse_answer(std::string_view message);

}  // namespace gyrotherm::control
