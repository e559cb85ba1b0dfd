// SPDX-License-Identifier: Apache-2.0
#include "report/comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "analysis/assurance/record_state.hpp"
#include "analysis/data/dataset.hpp"
#include "core/file.hpp"
#include "core/json.hpp"
#include "report/document_parts.hpp"
#include "report/plot/svg.hpp"

namespace gyrotherm::report {

void describe(auto& form, Like<ComparedResult> auto& result) {
  form("key", result.key);
  form("quantity", result.quantity);
  form.if_present("detail", !result.detail.empty(), result.detail);
  form("unit", result.unit);
  form("axis", result.axis);
  form("profile", result.profile);
  form.if_present("before_record", !result.before_record.empty(), result.before_record);  // since 0.2.0
  form.if_present("now_record", !result.now_record.empty(), result.now_record);
  form("days_between", result.days_between);
  form.derived("before_at", name(result.before_at));
  form.derived("now_at", name(result.now_at));
  form("condition", result.condition);
  form("before", result.before.value);
  form.derived("before_U", result.before.expanded());
  form("now", result.now.value);
  form.derived("now_U", result.now.expanded());
  form("change", result.change);
  form("U", result.expanded);
  form("E_n", result.normalised_error);
  form("change_in_a_year", result.in_a_year);
}

void describe(auto& form, Like<CheckedRecord> auto& record) {
  form.derived("report", record.is_before ? "before" : "now");
  form("record", record.name);
  form("started_utc", record.started_utc);
  form("state", record.state);
  form("checked_before", record.checked_before);
  form("checked_after", record.checked_after);
}

void describe(auto& form, Like<Comparison> auto& comparison) {
  form("before", comparison.before_number);
  form("now", comparison.now_number);
  form.derived("before_state", name(comparison.before_state));
  form.derived("now_state", name(comparison.now_state));
  form("before_sha256", comparison.before_sha256);
  form("now_sha256", comparison.now_sha256);
  form("unit_model", comparison.model);
  form("serial_number", comparison.serial_number);
  form("laboratory", comparison.laboratory);
  form("days_between", comparison.days_between);
  form("simulated", comparison.simulated);
  form("same_model", comparison.same_model);
  form("results", comparison.results);
  if (comparison.standard) form("check_standard", comparison.checked);
}

namespace {

constexpr double kDaysInAYear = 365.25;
// Quantity that is not compared: the temperature of a hold is a condition set by the chamber, not a result of the unit.
constexpr std::string_view kConditionQuantity = "temperature";

/// Returns the profile of a run; empty if unknown.
std::string find_profile(const CalibrationReport& report, const std::string& run) {
  const auto file = std::ranges::find(report.files, run, &UsedFile::id);
  return run.empty() || file == report.files.end() ? std::string() : file->profile;
}

/// Record of a report with comparable results, or all records of the report: `run` and `profile` are then empty.
struct ComparableRecord {
  std::string run, profile;
  /// Position among the records of its profile, from 0.
  std::size_t position{};
  bool is_paired{};
};

/// Lists the runs of a report in the order of its records. An empty id stands for the results of all records.
std::vector<std::string> list_runs(const CalibrationReport& report) {
  std::vector<std::string> runs;
  const auto add_once = [&](const std::string& run) {
    if (std::ranges::find(runs, run) == runs.end()) runs.push_back(run);
  };
  for (const UsedFile& file : report.files)
    if (file.role == "record") add_once(file.id);
  for (const ResultTable& table : report.results) add_once(table.run);
  return runs;
}

/// Returns whether a report has the same record, unchanged, as another.
bool shares_record(const CalibrationReport& report, const CalibrationReport& other, const std::string& run) {
  const auto find_record = [&](const CalibrationReport& in) { return std::ranges::find(in.files, run, &UsedFile::id); };
  const auto file = find_record(report), same = find_record(other);
  return !run.empty() && file != report.files.end() && same != other.files.end() && file->sha256 == same->sha256 &&
         file->started_utc == same->started_utc;
}

/// Lists the records with results at a stage that are not in-sample: those that the other report has too, or the
/// others.
std::vector<ComparableRecord> list_comparable(const CalibrationReport& report, const CalibrationReport& other,
                                              Stage stage, bool shared) {
  std::vector<ComparableRecord> records;
  std::map<std::string, std::size_t> known;
  for (const std::string& run : list_runs(report)) {
    if (shares_record(report, other, run) != shared) continue;
    ComparableRecord record{.run = run, .profile = find_profile(report, run)};
    if (!run.empty()) record.position = known[record.profile]++;
    const auto is_its_result = [&](const ResultTable& table) {
      return table.run == run && table.stage == stage && !table.in_sample;
    };
    if (std::ranges::any_of(report.results, is_its_result)) records.push_back(std::move(record));
  }
  return records;
}

/// Returns the free record with which to compare `one`; null if there is none.
ComparableRecord* find_counterpart(const ComparableRecord& one, std::vector<ComparableRecord>& others,
                                   bool at_same_position) {
  const auto found = std::ranges::find_if(others, [&](const ComparableRecord& other) {
    return !other.is_paired && other.profile == one.profile && other.run.empty() == one.run.empty() &&
           (!at_same_position || other.position == one.position);
  });
  return found == others.end() ? nullptr : &*found;
}

/// Pairs the records of two reports: first those at the same position, then the others in their order.
std::vector<std::pair<ComparableRecord, ComparableRecord>> pair_records(std::vector<ComparableRecord> before,
                                                                        std::vector<ComparableRecord> now) {
  std::vector<std::pair<ComparableRecord, ComparableRecord>> pairs;
  for (const bool at_same_position : {true, false}) {
    for (ComparableRecord& one : before) {
      ComparableRecord* other = one.is_paired ? nullptr : find_counterpart(one, now, at_same_position);
      if (other == nullptr) continue;
      one.is_paired = other->is_paired = true;
      pairs.emplace_back(one, *other);
    }
  }
  return pairs;
}

/// Returns the profile of a pair. Records after the first are numbered if both have the same position: "random, 2".
std::string describe_profile(const ComparableRecord& before, const ComparableRecord& now) {
  const bool is_numbered = before.position == now.position && before.position > 0 && !before.profile.empty();
  return is_numbered ? fmt::format("{}, {}", before.profile, before.position + 1) : before.profile;
}

/// Returns the start of a run; empty if unknown.
std::string find_start(const CalibrationReport& report, const std::string& run) {
  const auto file = std::ranges::find(report.files, run, &UsedFile::id);
  return run.empty() || file == report.files.end() ? std::string() : file->started_utc;
}

/// Returns the days between two instants such as "2026-11-25T14:03:07Z", or two days; NaN if one is unknown.
double days_between(const std::string& before, const std::string& now) {
  constexpr std::size_t kDayLength = 10;  // length of "2026-11-25"
  const auto first = record::parse_day(before.substr(0, kDayLength)),
             second = record::parse_day(now.substr(0, kDayLength));
  return first && second ? static_cast<double>((*second - *first).count()) : std::numeric_limits<double>::quiet_NaN();
}

/// Returns true if each as-found model is an as-left model of the previous calibration. Results without compensation
/// need no model.
bool has_same_models(const CalibrationReport& before, const CalibrationReport& now) {
  for (const UsedFile& found : now.files) {
    if (found.role != "model_found") continue;
    const auto is_same_model = [&](const UsedFile& left) {
      return left.role == "model_left" && left.sha256 == found.sha256;
    };
    if (std::ranges::none_of(before.files, is_same_model)) return false;
  }
  return true;
}

/// Returns the condition of a row, "set_point 20" or "temperature 10"; empty if the table has no such column.
std::string row_condition(const ResultTable& table, std::size_t row) {
  for (const char* quantity : {"set_point", "temperature"}) {
    const Column* column = find_column(table, quantity);
    const bool is_nominal = column != nullptr && !std::isfinite(column->values[row].standard_uncertainty);
    if (is_nominal) return fmt::format("{} {:g}", quantity, column->values[row].value);
  }
  return {};
}

struct Row {
  std::string condition;
  ReportedValue value;
};

/// Returns the rows of a column. Rows with the same condition are numbered after the first.
std::vector<Row> column_rows(const ResultTable& table, const Column& column) {
  std::vector<Row> rows;
  std::map<std::string, int> seen;
  for (std::size_t row = 0; row < column.values.size(); ++row) {
    std::string condition = row_condition(table, row);
    const int number = ++seen[condition];
    if (number > 1) condition += fmt::format(", {}", number);
    rows.push_back({std::move(condition), column.values[row]});
  }
  return rows;
}

void set_change(ComparedResult& result, const ReportedValue& before, const ReportedValue& now) {
  result.before = before;
  result.now = now;
  result.change = now.value - before.value;
  result.expanded = std::hypot(before.expanded(), now.expanded());
  if (result.expanded > 0) result.normalised_error = result.change / result.expanded;
  if (result.days_between > 0) result.in_a_year = result.change * kDaysInAYear / result.days_between;
}

/// Returns the result of a run at a stage with the key, axis and detail of `table`; null if there is none, or if it is
/// in-sample.
const ResultTable* find_matching_table(const CalibrationReport& report, const std::string& run, Stage stage,
                                       const ResultTable& table) {
  const auto found = std::ranges::find_if(report.results, [&](const ResultTable& other) {
    return other.run == run && other.stage == stage && !other.in_sample && other.key == table.key &&
           other.axis == table.axis && other.detail == table.detail;
  });
  return found == report.results.end() ? nullptr : &*found;
}

class ReportComparer {
 public:
  ReportComparer(const CalibrationReport& before, const CalibrationReport& now, Comparison& comparison)
      : before_(before), now_(now), comparison_(comparison) {}

  /// Compares the records that both reports have, or the others.
  void compare(bool shared) {
    compare(Stage::uncompensated, Stage::uncompensated, shared);
    compare(Stage::as_left, Stage::as_found, shared);
  }

 private:
  void compare(Stage before_at, Stage now_at, bool shared) {
    const auto pairs =
        pair_records(list_comparable(before_, now_, before_at, shared), list_comparable(now_, before_, now_at, shared));
    for (const auto& [before, now] : pairs) {
      const double days = days_between(find_start(before_, before.run), find_start(now_, now.run));
      const ComparedResult pair{.profile = describe_profile(before, now),
                                .before_record = record_label(before_, before.run),
                                .now_record = record_label(now_, now.run),
                                .days_between = std::isfinite(days) ? days : comparison_.days_between,
                                .before_at = before_at,
                                .now_at = now_at};
      for (const ResultTable& table : before_.results) {
        if (table.run != before.run || table.stage != before_at || table.in_sample) continue;
        if (const ResultTable* other = find_matching_table(now_, now.run, now_at, table)) compare(pair, table, *other);
      }
    }
  }

  void compare(const ComparedResult& pair, const ResultTable& table, const ResultTable& other) {
    const bool have_same_zero =
        data::have_same_zero(find_bias_reference(before_, table), find_bias_reference(now_, other));
    for (const Column& column : table.columns) {
      if (!have_same_zero && depends_on_bias_reference(column.quantity)) continue;
      const Column* matching = column.quantity == kConditionQuantity ? nullptr : find_column(other, column.quantity);
      if (matching != nullptr) compare(pair, table, column, other, *matching);
    }
  }

  void compare(const ComparedResult& pair, const ResultTable& table, const Column& column, const ResultTable& other,
               const Column& matching) {
    const std::vector<Row> rows = column_rows(other, matching);
    for (const Row& row : column_rows(table, column)) {
      const auto same = std::ranges::find(rows, row.condition, &Row::condition);
      const bool is_measured = std::isfinite(row.value.standard_uncertainty);
      if (same == rows.end() || !is_measured || !std::isfinite(same->value.standard_uncertainty)) continue;
      ComparedResult result = pair;
      result.key = table.key;
      result.detail = table.detail;
      result.quantity = column.quantity;
      result.unit = column.unit;
      result.axis = table.axis;
      result.condition = row.condition;
      set_change(result, row.value, same->value);
      if (!std::isfinite(result.normalised_error)) continue;
      comparison_.results.push_back(std::move(result));
    }
  }

  const CalibrationReport& before_;
  const CalibrationReport& now_;
  Comparison& comparison_;
};

const std::string kOutOfControl = name(assurance::CheckState::out_of_control);

/// Returns whether a rig of that name made records of the report.
bool was_made_on(const CalibrationReport& report, const std::string& rig) {
  return std::ranges::any_of(report.files,
                             [&](const UsedFile& file) { return file.role == "rig" && file.name == rig; });
}

CheckedRecord check_record(const standard::CheckedStandard& standard, const UsedFile& file, bool is_before) {
  const auto& started = file.started_utc;
  const auto found =
      started.empty() ? assurance::RecordState{} : find_state(standard.history, standard.assessment, started);
  const auto start_of = [&](const std::optional<std::size_t>& run) {
    return run ? standard.history.checks[*run].started_utc : std::string();
  };
  return {.is_before = is_before,
          .name = file.name,
          .started_utc = started,
          .state = name(found.state),
          .checked_before = start_of(found.before),
          .checked_after = start_of(found.after)};
}

/// Describes the state of the check standard at each record, for a terminal.
std::string describe_checks(const Comparison& comparison) {
  std::string text;
  for (const CheckedRecord& one : comparison.checked) {
    const auto shown = [](const std::string& utc) { return utc.empty() ? std::string("none") : utc; };
    auto state = one.state;
    std::ranges::replace(state, '_', ' ');
    text += fmt::format("check standard, {} {}: {}; check runs {} before it and {} after it\n",
                        one.is_before ? "before" : "now", one.name, state, shown(one.checked_before),
                        shown(one.checked_after));
  }
  if (is_check_open(comparison))
    text +=
        "warning: the check standard was out of control and no cause is recorded; a change of the unit may be a "
        "change of the rig\n";
  return text;
}

/// Returns a caution about a report that is not valid, for a terminal; empty for a valid one.
std::string describe_state(const std::string& number, ReportState state) {
  if (state == ReportState::authorised) return {};
  const char* const what =
      state == ReportState::draft ? "is a draft, not a calibration report" : "is superseded and no longer valid";
  return fmt::format("caution: {} {}\n", number.empty() ? "a report without a number" : number, what);
}

}  // namespace

Result<Comparison> compare(const CalibrationReport& before, const CalibrationReport& now) {
  if (before.item.serial_number != now.item.serial_number || before.item.model != now.item.model)
    return failure(FaultKind::usage, now.number,
                   fmt::format("calibrates {} {}, but the other report calibrates {} {}", now.item.model,
                               now.item.serial_number, before.item.model, before.item.serial_number));
  if (days_between(before.begun, now.begun) < 0)
    return failure(FaultKind::usage, now.number,
                   fmt::format("is the earlier report: its calibration began on {}, that of {} on {}; name the earlier "
                               "report first",
                               now.begun, before.number, before.begun));
  Comparison comparison{.before_number = before.number,
                        .now_number = now.number,
                        .before_state = before.state,
                        .now_state = now.state,
                        .model = now.item.model,
                        .serial_number = now.item.serial_number,
                        .laboratory = now.laboratory.name,
                        .days_between = days_between(before.begun, now.begun),
                        .simulated = before.simulated || now.simulated,
                        .same_model = has_same_models(before, now)};
  ReportComparer comparer(before, now, comparison);
  comparer.compare(false);
  if (comparison.results.empty()) comparer.compare(true);
  if (comparison.results.empty())
    return failure(FaultKind::usage, now.number,
                   "has no result in common with the other report for the same profile and bias reference");
  return comparison;
}

Result<void> add_check_standard(Comparison& comparison, const CalibrationReport& before, const CalibrationReport& now,
                                standard::CheckedStandard standard) {
  const auto& head = standard.history.head;
  const auto refuse = [&](std::string why) { return failure(FaultKind::usage, standard.file, std::move(why)); };
  if (standard.history.checks.empty()) return refuse("has no check run yet");
  std::vector<CheckedRecord> checked;
  for (const CalibrationReport* report : {&before, &now}) {
    if (report->simulated != head.simulated)
      return refuse("is of a virtual rig and the records are not, or the reverse");
    if (!was_made_on(*report, head.rig))
      return refuse(
          fmt::format("is of the rig {}, on which no record of report {} was made", head.rig, report->number));
    for (const UsedFile& file : report->files)
      if (file.role == "record") checked.push_back(check_record(standard, file, report == &before));
  }
  comparison.checked = std::move(checked);
  comparison.standard = std::move(standard);
  return {};
}

Result<Comparison> compare_files(const FiledReport& before, const FiledReport& now, const std::string& history) {
  auto comparison = compare(before.report, now.report);
  if (!comparison) return comparison;
  comparison->before_sha256 = before.sha256;
  comparison->now_sha256 = now.sha256;
  if (history.empty()) return comparison;
  auto checked = read_text_file(history, kLargestTable).and_then([&](const std::string& text) {
    return standard::assess_standard(text, history);
  });
  if (!checked) return failure(checked.error());
  if (auto added = add_check_standard(*comparison, before.report, now.report, std::move(*checked)); !added)
    return failure(added.error());
  return comparison;
}

bool is_check_open(const Comparison& comparison) {
  return std::ranges::count(comparison.checked, kOutOfControl, &CheckedRecord::state) > 0;
}

std::string to_json(const Comparison& comparison) {
  Json json{{"schema", kComparisonSchema}};
  json.update(make_json(comparison));
  return json_text(json, 1) + "\n";
}

ReportedValue change_with_uncertainty(const ComparedResult& result) {
  constexpr double kCoverage = 2;  // arbitrary: only k·u is printed
  return {.value = result.change, .standard_uncertainty = result.expanded / kCoverage, .coverage_factor = kCoverage};
}

std::vector<const ComparedResult*> sort_by_normalised_error(const Comparison& comparison) {
  std::vector<const ComparedResult*> all;
  for (const ComparedResult& result : comparison.results) all.push_back(&result);
  // A NaN would not be a strict weak order.
  const auto magnitude = [](const ComparedResult* one) {
    return std::isnan(one->normalised_error) ? -1 : std::abs(one->normalised_error);
  };
  std::ranges::stable_sort(all, std::ranges::greater(), magnitude);
  return all;
}

std::size_t count_disagreements(const Comparison& comparison) {
  return static_cast<std::size_t>(std::ranges::count_if(
      comparison.results, [](const ComparedResult& one) { return std::abs(one.normalised_error) > 1; }));
}

namespace {

/// Returns the words of a keyword: "as_left" becomes "as left".
std::string words_of_keyword(std::string keyword) {
  std::ranges::replace(keyword, '_', ' ');
  return keyword;
}

/// Returns ", R1 → R2, 335 days" for a pair of records; empty if both reports have one record.
std::string describe_pair(const ComparedResult& one) {
  if (one.before_record.empty() && one.now_record.empty()) return {};
  const auto label = [](const std::string& record) { return record.empty() ? std::string("R1") : record; };
  const auto days = std::isfinite(one.days_between) ? fmt::format(", {:.0f} days", one.days_between) : std::string();
  return fmt::format(", {} → {}{}", label(one.before_record), label(one.now_record), days);
}

/// Returns " at set point 20 °C (row 2)" for the condition "set_point 20, 2", and nothing for no condition.
std::string describe_condition(const std::string& condition) {
  if (condition.empty()) return {};
  const auto comma = std::min(condition.find(", "), condition.size());
  const auto row = comma < condition.size() ? fmt::format(" (row {})", condition.substr(comma + 2)) : std::string();
  return " at " + words_of_keyword(condition.substr(0, comma)) + " °C" + row;
}

}  // namespace

std::string describe(const Comparison& comparison) {
  const auto all = sort_by_normalised_error(comparison);
  std::string text =
      fmt::format("{}{} {}: {} against {}{}\n", comparison.simulated ? "SIMULATED " : "", comparison.model,
                  comparison.serial_number, comparison.now_number, comparison.before_number,
                  std::isfinite(comparison.days_between) ? fmt::format(", {:.0f} days later", comparison.days_between)
                                                         : std::string());
  text += describe_state(comparison.now_number, comparison.now_state) +
          describe_state(comparison.before_number, comparison.before_state);
  if (!comparison.same_model) text += "the as-found model is not the as-left model of the previous calibration\n";
  text += fmt::format("  {:>6}  {:>9}  {:>9}  {:>9}  {:>9}\n", "E_n", "before", "now", "change", "U");
  for (const ComparedResult* one : all)
    text += fmt::format(
        "  {:>6}  {:>9}  {:>9}  {:>9}  {:>9}  {} {}.{}{}{}{}, {} → {}{}{}{}\n", plot::decimal(one->normalised_error, 2),
        plot::format_significant(one->before.value), plot::format_significant(one->now.value),
        plot::format_significant(one->change), plot::format_significant(one->expanded), one->axis, one->key,
        one->quantity, one->detail.empty() ? "" : " " + one->detail, describe_condition(one->condition),
        one->unit.empty() || one->unit == "1" ? "" : ", " + one->unit, words_of_keyword(name(one->before_at)),
        words_of_keyword(name(one->now_at)), one->profile.empty() ? "" : ", ", one->profile, describe_pair(*one));
  text += describe_checks(comparison);
  const auto changed = count_disagreements(comparison);
  return text + fmt::format("{} of {} results {} by more than their combined uncertainty (|E_n| > 1)\n", changed,
                            all.size(), changed == 1 ? "differs" : "differ");
}

}  // namespace gyrotherm::report
