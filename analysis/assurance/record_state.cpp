// SPDX-License-Identifier: Apache-2.0
#include "analysis/assurance/record_state.hpp"

#include <algorithm>

namespace gyrotherm::assurance {
namespace {

bool is_judged(const Assessment& assessment, std::size_t run) {
  return std::ranges::any_of(assessment.charts, [&](const Chart& chart) { return chart.points[run].is_judged; });
}

/// Returns whether the record was made after the last run in control before the first open run.
bool follows_open_run(const History& history, const Assessment& assessment, const std::string& started_utc) {
  const auto open = std::ranges::find_if(assessment.runs, &RunVerdict::is_open);
  if (open == assessment.runs.end()) return false;
  return open == assessment.runs.begin() ||
         started_utc > history.checks[static_cast<std::size_t>(open - assessment.runs.begin()) - 1].started_utc;
}

}  // namespace

const char* name(CheckState state) {
  constexpr const char* kNames[] = {"unknown", "in_control", "explained", "out_of_control"};
  return kNames[static_cast<std::size_t>(state)];
}

RecordState find_state(const History& history, const Assessment& assessment, const std::string& started_utc) {
  RecordState found;
  const auto later = std::ranges::upper_bound(history.checks, started_utc, {}, &CheckEntry::started_utc);
  const auto next = static_cast<std::size_t>(later - history.checks.begin());
  if (next > 0) found.before = next - 1;
  if (next < history.checks.size()) found.after = next;
  if (follows_open_run(history, assessment, started_utc)) {
    found.state = CheckState::out_of_control;
    return found;
  }
  for (const auto& beside : {found.before, found.after}) {
    if (!beside) continue;
    if (assessment.runs[*beside].explanation) found.state = CheckState::explained;
    if (found.state == CheckState::unknown && is_judged(assessment, *beside)) found.state = CheckState::in_control;
  }
  return found;
}

}  // namespace gyrotherm::assurance
