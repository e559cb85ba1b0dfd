#include "sequencer/run/control_message.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "core/text.hpp"

namespace gyrotherm {
namespace {

constexpr std::array kCommands{OperatorCommand::pause, OperatorCommand::resume, OperatorCommand::stop,
                               OperatorCommand::abort};

bool is_one_line(std::string_view text) {
  return std::none_of(text.begin(), text.end(), [](unsigned char c) { return c < ' ' || c == 0x7F; });
}

/// A message is "gyrotherm-tell/1 WORD TEXT": its word and its text.
Result<std::pair<std::string_view, std::string_view>> split(std::string_view message) {
  const auto wrong = [](const char* why) { return failure(FaultKind::corrupted, "tell", why); };
  if (message.size() > kLongestRequest) return wrong("a message that is too long");
  if (!message.starts_with(kControlSchema) || message.substr(kControlSchema.size(), 1) != " ")
    return wrong("a message of another version");
  message.remove_prefix(kControlSchema.size() + 1);
  if (!is_one_line(message)) return wrong("a message of more than one line");
  const auto blank = message.find(' ');
  const auto text = blank == std::string_view::npos ? std::string_view() : message.substr(blank + 1);
  return std::pair{message.substr(0, blank), text};
}

}  // namespace

Result<ControlRequest> request_of(const std::string& word, const std::string& note) {
  const auto refuse = [&](const std::string& why) { return failure(FaultKind::usage, "tell " + word, why); };
  for (const auto command : kCommands) {
    if (word != name(command)) continue;
    if (!note.empty()) return refuse("takes no text; \"note\" does");
    return ControlRequest{.command = command, .note = {}};
  }
  if (word != "note") return refuse("is none of pause, resume, stop, abort, note");
  if (note.empty()) return refuse("wants a text: gyrotherm tell RUN.db note \"…\"");
  if (note.size() > kLongestNote) return refuse(fmt::format("a note has at most {} bytes", kLongestNote));
  if (!is_utf8(note)) return refuse("a note is text in UTF-8");
  if (!is_one_line(note)) return refuse("a note is one line of text");
  return ControlRequest{.command = {}, .note = note};
}

std::string to_message(const ControlRequest& request) {
  return fmt::format("{} {} {}", kControlSchema, request.command ? name(*request.command) : "note", request.note);
}

std::string to_message(const ControlAnswer& answer) {
  return fmt::format("{} {} {}", kControlSchema, answer.done ? "done" : "refused", answer.text)
      .substr(0, kLongestRequest);
}

Result<ControlRequest> parse_request(std::string_view message) {
  const auto parts = split(message);
  if (!parts) return failure(parts.error());
  auto request = request_of(std::string(parts->first), std::string(parts->second));
  if (!request) return failure(FaultKind::corrupted, request.error().where, request.error().what);
  return request;
}

Result<ControlAnswer> parse_answer(std::string_view message) {
  const auto parts = split(message);
  if (!parts) return failure(parts.error());
  if (parts->first != "done" && parts->first != "refused")
    return failure(FaultKind::corrupted, "tell", "an answer that is neither done nor refused");
  return ControlAnswer{.done = parts->first == "done", .text = std::string(parts->second)};
}

}  // namespace gyrotherm
