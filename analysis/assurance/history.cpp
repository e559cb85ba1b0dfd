// SPDX-License-Identifier: Apache-2.0
#include "analysis/assurance/history.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/json.hpp"
#include "core/sha256.hpp"

namespace gyrotherm::assurance {
namespace {

constexpr const char *kKind = "kind", *kPrevious = "previous", *kCheck = "check", *kExplanation = "explanation";

std::string_view last_line(std::string_view text) {
  text.remove_suffix(1);  // the newline at its end
  const auto before = text.rfind('\n');
  return before == std::string_view::npos ? text : text.substr(before + 1);
}

template <class T>
std::string append_line(std::string text, const char* kind, const T& value) {
  Json json{{kKind, kind}, {kPrevious, sha256(last_line(text))}};
  const Json members = make_json(value);
  for (const auto& [key, member] : members.items()) json[key] = member;
  return std::move(text) + json_text(json) + "\n";
}

bool is_known(const History& history, const std::string& run_id) {
  return std::ranges::find(history.checks, run_id, &CheckEntry::run_id) != history.checks.end();
}

void read_check(const JsonNode& node, History& history) {
  CheckEntry check;
  read_json(node, check);
  if (is_known(history, check.run_id)) node["run_id"].note_error("is already in the history");
  if (!history.checks.empty() && check.started_utc <= history.checks.back().started_utc)
    node["started_utc"].note_error("is not after the previous check run");
  history.checks.push_back(std::move(check));
}

void read_explanation(const JsonNode& node, History& history) {
  Explanation explanation;
  read_json(node, explanation);
  if (std::ranges::find(kCauses, explanation.cause) == kCauses.end())
    node["cause"].note_error(fmt::format("expected {}", fmt::join(kCauses, ", ")));
  for (const std::string& run_id : explanation.run_ids)
    if (!is_known(history, run_id)) node["run_ids"].note_error("names a run that is not in the history");
  history.explanations.push_back(std::move(explanation));
}

/// Reads the line numbered `number`, which follows `previous`; the first line is the head.
Result<void> read_line(std::string_view line, std::string_view previous, std::size_t number, const std::string& file,
                       History& history) {
  const auto at = fmt::format("{}:{}", file, number);
  const auto parsed = JsonNode::parse(line, at);
  if (!parsed) return failure(parsed.error());
  const JsonNode& node = *parsed;
  if (number == 1) {
    if (node["schema"].text() != kHistorySchema)
      node["schema"].note_error(fmt::format("expected \"{}\"", kHistorySchema));
    read_json(node, history.head);
    return node.verdict();
  }
  if (node[kPrevious].text() != sha256(previous))
    return failure(FaultKind::bad_file, at, "does not follow from the line before it: one of them was changed");
  if (const std::string kind = node[kKind].text(); kind == kCheck)
    read_check(node, history);
  else if (kind == kExplanation)
    read_explanation(node, history);
  else
    node[kKind].note_error("expected \"check\" or \"explanation\"");
  return node.verdict();
}

/// Returns the result of a check run that belongs to a chart; null if the run does not have it.
const CheckResult* find_result(const CheckEntry& check, const CheckResult& of) {
  const auto is_same = [&](const CheckResult& one) {
    return one.kind == of.kind && one.axis == of.axis && one.thermometer == of.thermometer && one.plateau == of.plateau;
  };
  const auto found = std::ranges::find_if(check.results, is_same);
  return found == check.results.end() ? nullptr : &*found;
}

std::vector<RunVerdict> cover_runs(const History& history) {
  std::vector<RunVerdict> runs(history.checks.size());
  for (std::size_t e = 0; e < history.explanations.size(); ++e)
    for (std::size_t r = 0; r < runs.size(); ++r)
      if (std::ranges::count(history.explanations[e].run_ids, history.checks[r].run_id) > 0) runs[r].explanation = e;
  return runs;
}

/// Returns whether a new level begins with the run `r`: the runs before it have an explanation with a new level.
bool begins_level(const History& history, const std::vector<RunVerdict>& runs, std::size_t r) {
  if (r == 0 || !runs[r - 1].explanation || runs[r - 1].explanation == runs[r].explanation) return false;
  return history.explanations[*runs[r - 1].explanation].new_level;
}

}  // namespace

Result<History> parse_history(std::string_view text, const std::string& file) {
  if (text.empty()) return failure(FaultKind::bad_file, file, "is empty, expected a history of check runs");
  if (!text.starts_with("{\""))
    return failure(FaultKind::bad_file, file,
                   "is not a history of check runs, expected a JSON object in each line, as gyrotherm standard writes");
  if (!text.ends_with('\n'))
    return failure(FaultKind::bad_file, file, "the last line is incomplete; restore the file from a copy");
  History history;
  std::string_view previous;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const auto line = text.substr(0, text.find('\n'));
    if (auto read = read_line(line, previous, number, file, history); !read) return failure(read.error());
    previous = line;
    text.remove_prefix(line.size() + 1);
  }
  return history;
}

std::string start_history(const HistoryHead& head) {
  Json json{{"schema", kHistorySchema}};
  const Json members = make_json(head);
  for (const auto& [key, member] : members.items()) json[key] = member;
  return json_text(json) + "\n";
}

std::string append(std::string text, const CheckEntry& check) { return append_line(std::move(text), kCheck, check); }

std::string append(std::string text, const Explanation& explanation) {
  return append_line(std::move(text), kExplanation, explanation);
}

bool Assessment::is_open() const { return std::ranges::any_of(runs, &RunVerdict::is_open); }

const ChartLimits& limits_of(const HistoryLimits& limits, CheckKind kind) {
  return kind == CheckKind::thermometer ? limits.thermometers : limits.gyro;
}

HistoryLimits find_limits(const History& history) {
  if (history.checks.empty()) return {};
  const auto& results = history.checks.front().results;
  const auto thermometers =
      static_cast<std::size_t>(std::ranges::count(results, CheckKind::thermometer, &CheckResult::kind));
  const double half = history.head.false_alarm_rate / 2;
  return {limits_for(half, results.size() - thermometers), limits_for(half, thermometers)};
}

Assessment assess(const History& history) { return assess(history, find_limits(history)); }

Assessment assess(const History& history, const HistoryLimits& limits) {
  Assessment assessment{.limits = limits, .runs = cover_runs(history)};
  if (history.checks.empty()) return assessment;
  for (const CheckResult& of : history.checks.front().results) {
    const auto scale = of.kind == CheckKind::scatter ? ChartScale::cube_root_of_variance : ChartScale::linear;
    std::vector<ChartInput> inputs;
    for (std::size_t r = 0; r < history.checks.size(); ++r) {
      const CheckResult* result = find_result(history.checks[r], of);
      inputs.push_back({.value = result ? result->value : std::numeric_limits<double>::quiet_NaN(),
                        .starts_level = begins_level(history, assessment.runs, r),
                        .is_excluded = assessment.runs[r].explanation.has_value()});
    }
    assessment.charts.push_back({of, scale, judge(inputs, limits_of(limits, of.kind), scale)});
    for (std::size_t r = 0; r < inputs.size(); ++r)
      if (assessment.charts.back().points[r].is_out())
        assessment.runs[r].charts.push_back(assessment.charts.size() - 1);
  }
  return assessment;
}

}  // namespace gyrotherm::assurance
