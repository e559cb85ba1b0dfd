// SPDX-License-Identifier: Apache-2.0
#include "report/draft.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/json.hpp"
#include "core/text.hpp"
#include "report/order.hpp"

namespace gyrotherm::report {

void describe(auto& form, Like<DraftSources> auto& sources) {
  form("program_version", sources.program_version);
  form("calibration_sha256", sources.calibration_sha256);
  form("unit", sources.unit);
  form("records", sources.records);
  form("models_left", sources.models_left);
  form("models_found", sources.models_found);
  form("folder_left", sources.folder_left);
  form("folder_found", sources.folder_found);
  form("inputs", sources.inputs);
  form("laboratory", sources.laboratory);
  form("order", sources.order);
  form("check_standard", sources.check_standard);
  form("unverified", sources.unverified);
}

std::string to_json(const DraftSources& sources) {
  Json json{{"schema", kSourcesSchema}};
  json.update(make_json(sources));
  return json_text(json, 1) + "\n";
}

Result<DraftSources> draft_sources_from_json(std::string_view json, const std::string& file) {
  const auto place = JsonNode::parse(json, file);
  if (!place) return failure(place.error());
  if (const std::string schema = (*place)["schema"].text(); schema != kSourcesSchema)
    (*place)["schema"].note_error(fmt::format("\"{}\", expected \"{}\"", schema, kSourcesSchema));
  DraftSources sources;
  read_json(*place, sources);
  if (auto verdict = place->verdict(); !verdict) return failure(verdict.error());
  return sources;
}

Result<std::vector<std::string>> find_changed_keys(std::string_view before, std::string_view now) {
  const auto first = nlohmann::json::parse(before, nullptr, false), second = nlohmann::json::parse(now, nullptr, false);
  if (first.is_discarded() || second.is_discarded()) return failure(FaultKind::bad_file, "", "is not a JSON document");
  std::vector<std::string> keys;
  for (const auto& change : nlohmann::json::diff(first, second)) {
    const std::string key = change["path"].get<std::string>().substr(1);
    if (std::ranges::find(keys, key) == keys.end()) keys.push_back(key);
  }
  return keys;
}

namespace {

/// Returns true for numbers that are equal except for the last digits of a double, or both unknown.
bool agree(double a, double b) {
  constexpr double kRelative = 1e-9;
  if (!std::isfinite(a) || !std::isfinite(b)) return std::isnan(a) ? std::isnan(b) : a == b;
  return std::abs(a - b) <= kRelative * std::max(std::abs(a), std::abs(b));
}

std::string describe_line(const Conformity& line) {
  return plain(fmt::format("conformity of {}, axis \"{}\", {}", line.quantity, line.axis, name(line.stage)));
}

bool is_of_table(const Conformity& line, const ResultTable& table) {
  return line.quantity.substr(0, line.quantity.find('.')) == table.key && line.axis == table.axis &&
         line.stage == table.stage && line.run == table.run;
}

/// Checks one line against the tables of the report: the table with the same worst row must exist.
void check_line(std::vector<std::string>& found, const CalibrationReport& report, const Conformity& line) {
  const std::string quantity = line.quantity.substr(line.quantity.find('.') + 1);
  bool is_judged = false, is_right = false;
  for (const ResultTable& table : report.results) {
    const Column* column = find_column(table, quantity);
    if (table.in_sample || column == nullptr || !is_of_table(line, table)) continue;
    is_judged = true;
    const Conformity worst = judge_column(report, table, *column, line.limit, line.rule);
    is_right = is_right || (worst.verdict == line.verdict && agree(worst.value.value, line.value.value) &&
                            agree(worst.value.expanded(), line.value.expanded()) &&
                            agree(worst.probability, line.probability) && column->unit == line.unit);
  }
  if (line.rule != report.rule)
    found.push_back(describe_line(line) + ": another decision rule than that of the report");
  if (is_judged && !is_right) found.push_back(describe_line(line) + ": does not follow from the result and the limit");
  if (!is_judged && line.verdict != Verdict::not_known)
    found.push_back(describe_line(line) + ": the report has no such result");
}

/// Lists results that a limit of the report applies to, but that have no verdict.
void list_unjudged(std::vector<std::string>& found, const CalibrationReport& report) {
  for (const Conformity& limit : report.conformity) {
    const auto dot = limit.quantity.find('.');
    for (const ResultTable& table : report.results) {
      if (table.in_sample || table.stage != limit.stage || table.key != limit.quantity.substr(0, dot) ||
          find_column(table, limit.quantity.substr(dot + 1)) == nullptr)
        continue;
      const auto judges = [&](const Conformity& line) {
        return line.quantity == limit.quantity && agree(line.limit, limit.limit) && is_of_table(line, table);
      };
      if (std::ranges::any_of(report.conformity, judges)) continue;
      const std::string text = plain(fmt::format("{}, axis \"{}\", {}: has no verdict for its limit", limit.quantity,
                                                 table.axis, name(table.stage)));
      if (std::ranges::find(found, text) == found.end()) found.push_back(text);
    }
  }
}

/// Checks that each compensated mean has the uncertainty of its budget.
void check_budgets(std::vector<std::string>& found, const CalibrationReport& report) {
  for (const ReportedBudget& budget : report.budgets)
    for (const ResultTable& table : report.results) {
      if (table.key != "compensated_mean" || table.axis != budget.axis || table.stage != budget.stage ||
          table.run != budget.run)
        continue;
      const Column* mean = find_column(table, "compensated_bias");
      if (mean == nullptr || mean->values.empty()) continue;
      const model::CombinedUncertainty all = combined(budget.budget.rows);
      if (!agree(mean->values.front().standard_uncertainty, all.standard_deg_per_h) ||
          !agree(mean->values.front().coverage_factor, all.coverage_factor))
        found.push_back(plain(fmt::format("uncertainty of compensated_mean, axis \"{}\", {}: is not that of its budget",
                                          table.axis, name(table.stage))));
    }
}

}  // namespace

std::vector<std::string> find_contradictions(const CalibrationReport& report) {
  std::vector<std::string> found;
  for (const Conformity& line : report.conformity) check_line(found, report, line);
  list_unjudged(found, report);
  check_budgets(found, report);
  return found;
}

}  // namespace gyrotherm::report
