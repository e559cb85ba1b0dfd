// SPDX-License-Identifier: Apache-2.0
#include "sequencer/control/control_message.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <utility>
#include <vector>

#include "core/text.hpp"

namespace gyrotherm::control {
namespace {

constexpr std::array kCommands{OperatorCommand::pause, OperatorCommand::resume, OperatorCommand::stop,
                               OperatorCommand::abort};

constexpr const char *kDrop = "drop", *kReturn = "return", *kAcknowledge = "acknowledge", *kAll = "all",
                     *kShelve = "shelve", *kUnshelve = "unshelve", *kTold = "told", *kNote = "note";
constexpr Duration kShortestShelving = std::chrono::seconds(1), kLongestShelving = std::chrono::hours(24);
constexpr std::string_view kForUser = "for=";

/// Returns the first token of a text, and the text after the blanks that follow it.
std::pair<std::string, std::string> split_first_token(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
  const auto end = std::min(text.find(' '), text.size());
  const auto remainder = text.substr(end);
  return {std::string(text.substr(0, end)),
          std::string(remainder.substr(std::min(remainder.find_first_not_of(' '), remainder.size())))};
}

ControlRequest make_unit_request(bool drop, std::string_view text) {
  auto [unit, reason] = split_first_token(text);
  return {.note = std::move(reason), .unit = UnitRequest{.drop = drop, .unit = std::move(unit)}};
}

/// Parses "12" or "12,15,40"; returns nothing if an item is not a number above 0.
std::optional<std::vector<std::int64_t>> parse_numbers(std::string_view text) {
  std::vector<std::int64_t> numbers;
  for (bool more = true; more;) {
    const auto comma = text.find(',');
    const auto item = text.substr(0, comma);
    const auto* end = item.data() + item.size();
    std::int64_t number{};
    const auto read = std::from_chars(item.data(), end, number);
    if (read.ec != std::errc() || read.ptr != end || number < 1) return std::nullopt;
    numbers.push_back(number);
    more = comma != std::string_view::npos;
    if (more) text.remove_prefix(comma + 1);
  }
  return numbers;
}

Result<ControlRequest> parse_acknowledgement(std::string_view text) {
  auto [alarms, comment] = split_first_token(text);
  const auto refuse = [](const std::string& why) { return failure(FaultKind::usage, "tell acknowledge", why); };
  Acknowledgement acknowledgement;
  if (alarms != kAll) {
    auto numbers = parse_numbers(alarms);
    if (!numbers)
      return refuse(
          fmt::format("\"{}\" is not an alarm number; expected a number that status lists, several such as "
                      "12,15, or all",
                      alarms));
    acknowledgement.alarms = std::move(*numbers);
  }
  if (comment.empty())
    return refuse(fmt::format("needs a comment: gyrotherm tell RUN.db acknowledge {} \"…\"", alarms));
  return ControlRequest{.note = std::move(comment), .acknowledgement = std::move(acknowledgement)};
}

/// Removes a time such as "2 h" or "90min" from the front of the text: one number with its unit.
std::optional<Duration> take_time(std::string_view& text) {
  auto [number, remainder] = split_first_token(text);
  auto time = parse_duration(number);
  if (!time) {
    auto [unit, after] = split_first_token(remainder);
    time = parse_duration(fmt::format("{} {}", number, unit));
    remainder = std::move(after);
  }
  if (!time) return std::nullopt;
  text.remove_prefix(text.size() - remainder.size());
  return *time;
}

/// Parses "12 2 h reason". Refuses a reason that begins with another time: the text "12 1 h 30 min reason" would
/// otherwise shelve the alarm for one hour.
Result<ControlRequest> parse_shelving(std::string_view text) {
  const auto refuse = [](const std::string& why) {
    return failure(FaultKind::usage, "tell shelve",
                   why + "; expected: gyrotherm tell RUN.db shelve ALARM \"2 h\" \"REASON\"");
  };
  const auto [alarm, remainder] = split_first_token(text);
  const auto numbers = parse_numbers(alarm);
  if (!numbers || numbers->size() != 1) return refuse(fmt::format("\"{}\" is not the number of one alarm", alarm));
  std::string_view rest = remainder;
  const auto time = take_time(rest);
  if (!time) return refuse(fmt::format("\"{}\" does not begin with a time such as \"2 h\"", remainder));
  if (*time < kShortestShelving || *time > kLongestShelving) return refuse("an alarm is shelved for 1 s to 24 h");
  const std::string reason(rest);
  if (reason.empty()) return refuse("a shelving needs a reason");
  if (take_time(rest))
    return refuse("the reason begins with another time; state the time as one number, such as \"90 min\"");
  return ControlRequest{
      .note = reason,
      .shelving = ShelvingRequest{.alarm = numbers->front(), .time = std::chrono::ceil<std::chrono::seconds>(*time)}};
}

Result<ControlRequest> parse_unshelving(std::string_view text) {
  const auto [alarm, remainder] = split_first_token(text);
  const auto numbers = parse_numbers(alarm);
  if (!numbers || numbers->size() != 1 || !remainder.empty())
    return failure(
        FaultKind::usage, "tell unshelve",
        fmt::format("\"{}\" is not the number of one alarm; expected: gyrotherm tell RUN.db unshelve ALARM", text));
  return ControlRequest{.shelving = ShelvingRequest{.alarm = numbers->front()}};
}

/// Returns the reason why a text is not valid in a request, or an empty string if it is valid.
std::string text_error(const std::string& text) {
  if (text.size() > kLongestNote) return fmt::format("the text is longer than {} bytes", kLongestNote);
  if (!is_utf8(text)) return "the text is not valid UTF-8";
  if (!is_one_line(text)) return "the text has control characters, expected one line";
  return {};
}

/// Splits a message "gyrotherm-tell/1 COMMAND TEXT" into command and text.
Result<std::pair<std::string_view, std::string_view>> split(std::string_view message) {
  const auto wrong = [](const char* why) { return failure(FaultKind::corrupted, "tell", why); };
  if (message.size() > kLongestRequest) return wrong("the message is too long");
  if (!message.starts_with(kControlSchema) || message.substr(kControlSchema.size(), 1) != " ")
    return wrong("the message has another protocol version");
  message.remove_prefix(kControlSchema.size() + 1);
  if (!is_one_line(message)) return wrong("the message has more than one line");
  const auto blank = message.find(' ');
  const auto text = blank == std::string_view::npos ? std::string_view() : message.substr(blank + 1);
  return std::pair{message.substr(0, blank), text};
}

}  // namespace

const char* name(OperatorCommand command) {
  switch (command) {
    case OperatorCommand::resume: return "resume";
    case OperatorCommand::pause: return "pause";
    case OperatorCommand::stop: return "stop";
    case OperatorCommand::abort: return "abort";
  }
  return "";
}

bool is_one_line(std::string_view text) {
  return std::none_of(text.begin(), text.end(), [](unsigned char c) { return c < ' ' || c == 0x7F; });
}

bool is_user_name(std::string_view name) {
  const auto is_permitted = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '.' ||
           c == '@' || c == '-';
  };
  return !name.empty() && name.size() <= kLongestUser && std::ranges::all_of(name, is_permitted);
}

std::string command_keyword(const ControlRequest& request) {
  if (request.command) return name(*request.command);
  if (request.unit) return request.unit->drop ? kDrop : kReturn;
  if (request.acknowledgement) return kAcknowledge;
  if (request.shelving) return request.shelving->time ? kShelve : kUnshelve;
  return request.told ? kTold : kNote;
}

std::string command_text(const ControlRequest& request) {
  if (request.acknowledgement) {
    const auto& alarms = request.acknowledgement->alarms;
    return fmt::format("{} {}", alarms.empty() ? kAll : fmt::format("{}", fmt::join(alarms, ",")), request.note);
  }
  if (request.shelving && request.shelving->time)
    return fmt::format("{} {:g} s {}", request.shelving->alarm, to_seconds(*request.shelving->time), request.note);
  if (request.shelving) return fmt::format("{}", request.shelving->alarm);
  if (!request.unit) return request.note;
  return request.note.empty() ? request.unit->unit : request.unit->unit + " " + request.note;
}

namespace {

/// Returns the error for an unknown command. The list of commands omits `told`, which only programs send.
std::string unknown_command_error(const std::string& keyword) {
  const std::vector<std::string> words{"pause",  "resume",      "stop",   "abort",    "drop",
                                       "return", "acknowledge", "shelve", "unshelve", "note"};
  const auto near = find_nearest(keyword, words);
  return fmt::format("is not one of {}{}", fmt::join(words, ", "),
                     near.empty() ? "" : fmt::format("; did you mean \"{}\"?", near));
}

}  // namespace

Result<ControlRequest> make_request(const std::string& keyword, const std::string& text) {
  const auto refuse = [&](const std::string& why) { return failure(FaultKind::usage, "tell " + keyword, why); };
  std::optional<OperatorCommand> found;
  for (const auto command : kCommands) {
    if (keyword != name(command)) continue;
    if (command == OperatorCommand::pause && !text.empty()) return refuse("takes no text; use \"note\" to record one");
    found = command;
  }
  const bool is_for_unit = keyword == kDrop || keyword == kReturn;
  const bool is_for_alarm = keyword == kAcknowledge || keyword == kShelve || keyword == kUnshelve;
  if (!found && !is_for_unit && !is_for_alarm && keyword != kTold && keyword != kNote)
    return refuse(unknown_command_error(keyword));
  if (is_for_unit && text.find_first_not_of(' ') == std::string::npos)
    return refuse(fmt::format("needs a unit: gyrotherm tell RUN.db {} UNIT \"…\"", keyword));
  if (is_for_alarm && text.empty())
    return refuse(fmt::format("needs alarms and a text: gyrotherm tell RUN.db {} ALARMS \"…\"", keyword));
  if (!found && text.empty()) return refuse(fmt::format("needs a text: gyrotherm tell RUN.db {} \"…\"", keyword));
  if (const auto why = text_error(text); !why.empty()) return refuse(why);
  if (is_for_unit) return make_unit_request(keyword == kDrop, text);
  if (keyword == kAcknowledge) return parse_acknowledgement(text);
  if (keyword == kShelve) return parse_shelving(text);
  if (keyword == kUnshelve) return parse_unshelving(text);
  return ControlRequest{.command = found, .note = text, .told = keyword == kTold};
}

std::string to_message(const ControlRequest& request) {
  const auto user = request.for_user.empty() ? "" : fmt::format("{}{} ", kForUser, request.for_user);
  return fmt::format("{} {}{} {}", kControlSchema, user, command_keyword(request), command_text(request));
}

std::string to_message(const ControlAnswer& answer) {
  return fmt::format("{} {} {}", kControlSchema, answer.done ? "done" : "refused", answer.text)
      .substr(0, kLongestRequest);
}

Result<ControlRequest> parse_request(std::string_view message) {
  auto parts = split(message);
  if (!parts) return failure(parts.error());
  std::string for_user;
  if (parts->first.starts_with(kForUser)) {
    for_user = parts->first.substr(kForUser.size());
    if (!is_user_name(for_user))
      return failure(FaultKind::corrupted, "tell", "invalid user name, expected 1 to 64 letters, digits or _ . @ -");
    const auto blank = std::min(parts->second.find(' '), parts->second.size());
    parts = std::pair{parts->second.substr(0, blank), parts->second.substr(std::min(blank + 1, parts->second.size()))};
  }
  auto request = make_request(std::string(parts->first), std::string(parts->second));
  if (!request) return failure(FaultKind::corrupted, request.error().where, request.error().what);
  request->for_user = std::move(for_user);
  return request;
}

Result<ControlAnswer> parse_answer(std::string_view message) {
  const auto parts = split(message);
  if (!parts) return failure(parts.error());
  if (parts->first != "done" && parts->first != "refused")
    return failure(FaultKind::corrupted, "tell", "the answer is neither \"done\" nor \"refused\"");
  return ControlAnswer{.done = parts->first == "done", .text = std::string(parts->second)};
}

}  // namespace gyrotherm::control
