// SPDX-License-Identifier: Apache-2.0
/// What others may ask of a run and what it answers, and the messages that this travels in. Pure.
///
/// A message is one line of text in UTF-8: "gyrotherm-tell/1 WORD TEXT", or "gyrotherm-tell/1 for=USER WORD TEXT" where
/// the speaker asks for somebody else; the answer is "gyrotherm-tell/1 done TEXT" or "gyrotherm-tell/1 refused TEXT".
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"

namespace gyrotherm::control {

/// The milder first.
enum class OperatorCommand { resume, pause, stop, abort };

[[nodiscard]] const char* name(OperatorCommand command);

inline constexpr std::size_t kLongestNote = 2000;  ///< bytes of a note, and of any other text of a request
inline constexpr std::size_t kLongestUser = 64;    ///< bytes of the name of a monitor's user

/// A unit under test is to be dropped from the run, or returned to it.
struct UnitRequest {
  bool drop{};
  std::string unit;
  bool operator==(const UnitRequest&) const = default;
};

/// Acknowledges alarms. The comment is the request's note.
struct Acknowledgement {
  std::vector<std::int64_t> alarms{};  ///< numbers of rows; empty: all
  bool operator==(const Acknowledgement&) const = default;
};

/// A command, a wish for one unit, an acknowledgement, a word of who was told of an alarm, or a note for the record.
struct ControlRequest {
  std::optional<OperatorCommand> command{};  ///< nothing: one of those below, or a note
  /// The answer of a resume, the reason of a stop, an abort or a unit's request, or the comment of an acknowledgement.
  /// In a report of a message sent: its address, its rule and its alarm.
  std::string note{};
  std::optional<UnitRequest> unit{};
  std::optional<Acknowledgement> acknowledgement{};
  bool told{};             ///< the note says who was told
  std::string for_user{};  ///< whom a monitor asks for; empty: the speaker asks for themselves
  bool operator==(const ControlRequest&) const = default;
};

/// What was made of it.
struct ControlAnswer {
  bool done{};
  std::string text;  ///< what was done, or why not
  bool operator==(const ControlAnswer&) const = default;
};

/// Whether it has no control characters.
[[nodiscard]] bool is_one_line(std::string_view text);
/// Whether a user of a monitor may be called so: 1 to 64 of [A-Za-z0-9_.@-].
[[nodiscard]] bool is_user_name(std::string_view name);

/// Reads a command and its text. "pause" has no text. "resume", "stop" and "abort" may have one: the answer or the
/// reason. "drop" and "return" have the unit's name and may have a reason. "acknowledge" has alarm numbers, separated
/// by commas, or "all", and a comment. "told" and "note" have a text. A text is one line in UTF-8. Fails with
/// usage.
[[nodiscard]] Result<ControlRequest> request_of(const std::string& word, const std::string& text);

/// The word and the text that request_of() made it of.
[[nodiscard]] std::string word_of(const ControlRequest& request);
[[nodiscard]] std::string text_of(const ControlRequest& request);

inline constexpr std::string_view kControlSchema = "gyrotherm-tell/1";
inline constexpr std::size_t kLongestRequest = 4096;  ///< bytes of a message

/// The name of `for_user` must be one.
[[nodiscard]] std::string to_message(const ControlRequest& request);
[[nodiscard]] std::string to_message(const ControlAnswer& answer);
/// Both fail with corrupted if the message is not what to_message() writes.
[[nodiscard]] Result<ControlRequest> parse_request(std::string_view message);
[[nodiscard]] Result<ControlAnswer> parse_answer(std::string_view message);

}  // namespace gyrotherm::control
