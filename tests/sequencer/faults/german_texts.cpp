// SPDX-License-Identifier: Apache-2.0
#include "tests/sequencer/faults/german_texts.hpp"

#include <regex>

#include "report/stored_texts.hpp"

namespace gyrotherm::faults {
namespace {

/// Returns the kind of the deviation; empty if a report does not show the event.
std::string deviation_kind_for_test(const Event& event) {
  switch (event.kind) {
    case EventKind::interlock: return "interlock";
    case EventKind::fault: return event.about.interlock.empty() ? "fault" : "alarm";
    case EventKind::note: return "note";
    case EventKind::resumed: return "resumed";
    case EventKind::interrupted: return "stopped";
    case EventKind::state:
      return event.text == name(RunState::execute) || event.text == name(RunState::complete) ? "" : "held";
    default: return "";
  }
}

/// Removes names that stay as they are: the name of the chamber, and the task that the profile's author wrote for the
/// operator.
std::string without_names(std::string german) {
  constexpr std::string_view kTask = "Aufforderung des Profils: ", kChamber = "chamber of fault schedules";
  for (auto at = german.find(kChamber); at != std::string::npos; at = german.find(kChamber))
    german.erase(at, kChamber.size());
  const auto at = german.find(kTask);
  if (at != std::string::npos) german.erase(at + kTask.size(), german.find(';', at) - at - kTask.size());
  return german;
}

}  // namespace

std::string find_untranslated(const Event& event) {
  static const std::regex kWord(
      R"((^|[^\w"])(the|is|are|not|NOT|and|or|with|without|for|by|than|its|no|of|to|has|does)($|[^\w"]))"
      R"(|(^|[^\w"])(reads|from|but|silent|jumped)($|[^\w"]))");
  const auto kind = deviation_kind_for_test(event);
  if (kind.empty()) return {};
  const auto german = report::translate_event(plot::Language::german, kind, event.text);
  if (german != event.text && !std::regex_search(without_names(german), kWord)) return {};
  return kind + ": " + event.text + " → " + german;
}

}  // namespace gyrotherm::faults
