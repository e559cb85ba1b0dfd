/// The words that go between `gyrotherm tell` and the program that carries a run out: one message each way.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/result.hpp"
#include "sequencer/run/operator_requests.hpp"

namespace gyrotherm {

inline constexpr std::string_view kControlSchema = "gyrotherm-tell/1";
inline constexpr std::size_t kLongestRequest = 4096;  ///< bytes of a message
inline constexpr std::size_t kLongestNote = 2000;     ///< bytes of a note

/// A command, or a note for the record.
struct ControlRequest {
  std::optional<OperatorCommand> command;  ///< nothing: a note
  std::string note;
  bool operator==(const ControlRequest&) const = default;
};

/// What was made of it.
struct ControlAnswer {
  bool done{};
  std::string text;  ///< what was done, or why not
  bool operator==(const ControlAnswer&) const = default;
};

/// "pause", "resume", "stop", "abort" or "note", which wants a text of one line in UTF-8. Fails with usage.
[[nodiscard]] Result<ControlRequest> request_of(const std::string& word, const std::string& note);

[[nodiscard]] std::string to_message(const ControlRequest& request);
[[nodiscard]] std::string to_message(const ControlAnswer& answer);
/// Fail with corrupted if the message is not what to_message() writes.
[[nodiscard]] Result<ControlRequest> parse_request(std::string_view message);
[[nodiscard]] Result<ControlAnswer> parse_answer(std::string_view message);

}  // namespace gyrotherm
