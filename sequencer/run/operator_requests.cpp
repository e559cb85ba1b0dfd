// SPDX-License-Identifier: Apache-2.0
#include "sequencer/run/operator_requests.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "core/text.hpp"

namespace gyrotherm::run {
namespace {

constexpr std::array kCommands{OperatorCommand::pause, OperatorCommand::resume, OperatorCommand::stop,
                               OperatorCommand::abort};

constexpr const char *kDrop = "drop", *kReturn = "return";

/// The unit's name, and behind it the reason.
ControlRequest request_of_unit(bool drop, std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
  const auto end = std::min(text.find(' '), text.size());
  const auto reason = text.substr(end);
  return {.note = std::string(reason.substr(std::min(reason.find_first_not_of(' '), reason.size()))),
          .unit = UnitRequest{.drop = drop, .unit = std::string(text.substr(0, end))}};
}

bool is_milder(const OperatorRequest& a, const OperatorRequest& b) { return a.command < b.command; }

/// What the state alone has against the command.
std::string objection_of(RunState state, OperatorCommand command) {
  if (state == RunState::aborting && command != OperatorCommand::abort) return "the chamber is being made safe";
  if (state > RunState::aborting) return fmt::format("the run is over: {}", name(state));
  if (command == OperatorCommand::resume && state != RunState::held)
    return fmt::format("the run is not held: {}", name(state));
  if (command == OperatorCommand::pause && state == RunState::held) return "the run is held already";
  return {};
}

}  // namespace

std::string word_of(const ControlRequest& request) {
  if (request.command) return name(*request.command);
  if (request.unit) return request.unit->drop ? kDrop : kReturn;
  return "note";
}

std::string text_of(const ControlRequest& request) {
  if (!request.unit) return request.note;
  return request.note.empty() ? request.unit->unit : request.unit->unit + " " + request.note;
}

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

Result<ControlRequest> request_of(const std::string& word, const std::string& note) {
  const auto refuse = [&](const std::string& why) { return failure(FaultKind::usage, "tell " + word, why); };
  std::optional<OperatorCommand> found;
  for (const auto command : kCommands) {
    if (word != name(command)) continue;
    if (command != OperatorCommand::resume && !note.empty()) return refuse("takes no text; \"note\" does");
    found = command;
  }
  const bool of_a_unit = word == kDrop || word == kReturn;
  if (!found && !of_a_unit && word != "note")
    return refuse("is none of pause, resume, stop, abort, drop, return, note");
  if (of_a_unit && note.find_first_not_of(' ') == std::string::npos)
    return refuse(fmt::format("wants a unit: gyrotherm tell RUN.db {} UNIT \"…\"", word));
  if (!found && note.empty()) return refuse("wants a text: gyrotherm tell RUN.db note \"…\"");
  if (note.size() > kLongestNote) return refuse(fmt::format("a note has at most {} bytes", kLongestNote));
  if (!is_utf8(note)) return refuse("a note is text in UTF-8");
  if (!is_one_line(note)) return refuse("a note is one line of text");
  if (of_a_unit) return request_of_unit(word == kDrop, note);
  return ControlRequest{.command = found, .note = note};
}

std::string OperatorRequests::objection(RunState state, OperatorCommand command) const {
  const auto* first = foremost();
  if (first && first->command > command)
    return fmt::format("{} by {} comes first, within a second", name(first->command), first->who);
  const bool keeps_held = command == OperatorCommand::pause && first && first->command == OperatorCommand::resume;
  return keeps_held ? std::string() : objection_of(state, command);
}

const OperatorRequest* OperatorRequests::foremost() const {
  const auto most = std::max_element(waiting_.begin(), waiting_.end(), is_milder);
  return most == waiting_.end() ? nullptr : &*most;
}

bool OperatorRequests::end_the_run() const {
  const auto* first = foremost();
  return first && first->command >= OperatorCommand::stop;
}

OperatorRequests::Taken OperatorRequests::take() {
  Taken taken;
  const auto* first = foremost();
  for (auto& request : waiting_)
    if (&request == first)
      taken.carried_out = std::move(request);
    else
      taken.dropped.push_back(std::move(request));
  waiting_.clear();
  return taken;
}

}  // namespace gyrotherm::run
