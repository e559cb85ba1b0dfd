// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <set>
#include <utility>

#include "report/cautions.hpp"
#include "report/document_parts.hpp"

namespace gyrotherm::report {
namespace {

constexpr std::array kStages = {Stage::uncompensated, Stage::as_found, Stage::as_left};

std::size_t stage_index(Stage stage) { return static_cast<std::size_t>(stage); }

/// Tables of the same result in one record, at most one per stage.
struct RecordTables {
  std::string run;
  std::array<const ResultTable*, kStages.size()> by_stage{};
  [[nodiscard]] const ResultTable& any() const {
    return **std::ranges::find_if(by_stage, [](auto* t) { return t; });
  }
};

/// Tables with one key and one detail from all records and stages, shown in adjacent columns.
struct TableGroup {
  std::vector<RecordTables> records;
  [[nodiscard]] const ResultTable& any() const { return records.front().any(); }
};

std::size_t row_count(const ResultTable& table) {
  return table.columns.empty() ? 0 : table.columns.front().values.size();
}

bool are_same_number(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

bool have_same_values(const Column& a, const Column& b) {
  return std::ranges::equal(a.values, b.values, [](const ReportedValue& x, const ReportedValue& y) {
    return are_same_number(x.value, y.value) && are_same_number(x.standard_uncertainty, y.standard_uncertainty);
  });
}

bool have_same_shape(const ResultTable& a, const ResultTable& b) {
  return row_count(a) == row_count(b) && std::ranges::equal(a.columns, b.columns, [](const Column& x, const Column& y) {
           return x.quantity == y.quantity && x.unit == y.unit;
         });
}

/// Adds a table to the group. Returns false if the table does not match, or if the group already has a table of this
/// record and stage.
bool add_to_group(TableGroup& tables, const ResultTable& table) {
  const ResultTable& other = tables.any();
  if (other.key != table.key || other.detail != table.detail || !have_same_shape(other, table)) return false;
  auto record = std::ranges::find(tables.records, table.run, &RecordTables::run);
  if (record == tables.records.end())
    record = tables.records.insert(tables.records.end(), RecordTables{.run = table.run});
  const ResultTable*& place = record->by_stage.at(stage_index(table.stage));
  if (place != nullptr) return false;
  place = &table;
  return true;
}

std::vector<TableGroup> group_tables(const CalibrationReport& report, Group group, const std::string& axis) {
  std::vector<TableGroup> all;
  for (const ResultTable* table : results_in_group(report, group)) {
    if (table->axis != axis) continue;
    if (std::ranges::any_of(all, [&](TableGroup& one) { return add_to_group(one, *table); })) continue;
    RecordTables record{.run = table->run};
    record.by_stage.at(stage_index(table->stage)) = table;
    all.push_back({{record}});
  }
  return all;
}

/// Returns true for a quantity that describes the condition of a row, such as the set point, and is equal at all
/// stages.
bool is_condition(const TableGroup& tables, const std::string& quantity) {
  static const std::set<std::string> kConditions = {"set_point", "starts", "within", "temperature", "nominal_share"};
  if (!kConditions.contains(quantity)) return false;
  for (const RecordTables& record : tables.records)
    for (const ResultTable* table : record.by_stage)
      if (table != nullptr && !have_same_values(*find_column(*table, quantity), *find_column(record.any(), quantity)))
        return false;
  return true;
}

struct Quantities {
  std::vector<std::string> conditions, results;
};

/// Separates conditions and results. If all quantities are conditions, the last one is the result.
Quantities separate_quantities(const TableGroup& tables) {
  Quantities found;
  for (const Column& column : tables.any().columns)
    (is_condition(tables, column.quantity) ? found.conditions : found.results).push_back(column.quantity);
  if (found.results.empty() && !found.conditions.empty()) {
    found.results.push_back(found.conditions.back());
    found.conditions.pop_back();
  }
  return found;
}

Cell value_cell(const DocumentWriter& writer, const ReportedValue& value, bool in_sample) {
  Cell cell{.text = format_result(writer.language, value), .note = coverage_note(writer.language, value)};
  if (in_sample) cell.note += (cell.note.empty() ? "" : "; ") + writer.translated("label.in_sample");
  return cell;
}

/// Returns a setting or another condition of a row.
Cell condition_cell(const DocumentWriter& writer, const ReportedValue& value) {
  return {.text = format(writer.language, value), .note = coverage_note(writer.language, value)};
}

std::string key_with_detail(const DocumentWriter& writer, const ResultTable& table) {
  const std::string key = writer.translated(table.key);
  return table.detail.empty() ? key : key + " " + table.detail;
}

/// Returns true if `name` contains `part`: "Hold bias" contains "Bias". Ignores the case of ASCII letters.
bool contains_name(const std::string& name, const std::string& part) {
  const auto same = [](char a, char b) {
    return std::tolower(static_cast<unsigned char>(a)) == std::tolower(static_cast<unsigned char>(b));
  };
  return !std::ranges::search(name, part, same).empty();
}

/// Returns "Temperature sensitivity / (°/(h·K))", or "Whole run: Mean / (°/h)" for a key with several quantities.
std::string quantity_name(const DocumentWriter& writer, const TableGroup& tables, const std::string& quantity) {
  const ResultTable& table = tables.any();
  const Column& column = *find_column(table, quantity);
  const std::string key = key_with_detail(writer, table), own = writer.translated(quantity);
  return name_with_unit(contains_name(key, own) ? key : key + ": " + own, column.unit);
}

/// Builds a table of results: columns for quantity, record and conditions, then one per stage.
class ResultsTable {
 public:
  ResultsTable(const DocumentWriter& writer, const std::vector<const TableGroup*>& of) : writer_(writer) {
    for (const TableGroup* tables : of)
      for (const RecordTables& record : tables->records) take(record);
    has_record_column_ =
        std::ranges::any_of(runs_, [&](const std::string& run) { return !record_label(writer.report, run).empty(); });
    has_quantity_column_ = of.size() > 1 || separate_quantities(*of.front()).results.size() > 1;
    start(*of.front());
    for (const TableGroup* tables : of) add(*tables);
  }

  [[nodiscard]] DocumentTable finish(std::string caption) && {
    table_.caption = std::move(caption);
    return std::move(table_);
  }
  [[nodiscard]] bool has_quantity_column() const { return has_quantity_column_; }

 private:
  void take(const RecordTables& record) {
    runs_.insert(record.run);
    for (const Stage stage : kStages)
      if (record.by_stage.at(stage_index(stage)) != nullptr) stages_.insert(stage);
  }
  void start(const TableGroup& first) {
    if (has_quantity_column_) table_.header.push_back(writer_.translated("column.quantity"));
    if (has_record_column_) table_.header.push_back(writer_.translated("column.record"));
    table_.text_columns = table_.header.size();
    for (const std::string& condition : separate_quantities(first).conditions)
      table_.header.push_back(name_with_unit(writer_.translated(condition), find_column(first.any(), condition)->unit));
    for (const Stage stage : stages_) table_.header.push_back(writer_.translated(name(stage)));
  }
  void add(const TableGroup& tables) {
    const Quantities quantities = separate_quantities(tables);
    for (const std::string& quantity : quantities.results)
      for (const RecordTables& record : tables.records)
        for (std::size_t row = 0; row < row_count(record.any()); ++row)
          add_row(tables, record, quantities.conditions, quantity, row);
  }
  void add_row(const TableGroup& tables, const RecordTables& record, const std::vector<std::string>& conditions,
               const std::string& quantity, std::size_t row) {
    std::vector<Cell> cells;
    if (has_quantity_column_) cells.push_back({.text = quantity_name(writer_, tables, quantity)});
    if (has_record_column_) cells.push_back({.text = record_label(writer_.report, record.run)});
    for (const std::string& condition : conditions) {
      cells.push_back(condition_cell(writer_, find_column(record.any(), condition)->values[row]));
      if (&condition == &conditions.front()) cells.back().note = hold_note(record.any(), condition, row);
    }
    for (const Stage stage : stages_) {
      const ResultTable* table = record.by_stage.at(stage_index(stage));
      cells.push_back(table == nullptr
                          ? Cell{.text = "–"}
                          : value_cell(writer_, find_column(*table, quantity)->values[row], table->in_sample));
    }
    table_.rows.push_back(std::move(cells));
  }

  /// Returns "no. 2" for the second row of a record with the same set point; empty if the set point occurs once.
  [[nodiscard]] std::string hold_note(const ResultTable& table, const std::string& condition, std::size_t row) const {
    if (condition != "set_point") return {};
    const std::vector<ReportedValue>& values = find_column(table, condition)->values;
    const auto is_same = [&](const ReportedValue& one) { return one.value == values[row].value; };
    if (std::ranges::count_if(values, is_same) < 2) return {};
    const auto number = std::count_if(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(row) + 1, is_same);
    return writer_.sentence("label.row", number);
  }

  const DocumentWriter& writer_;
  std::set<std::string> runs_{};
  std::set<Stage> stages_{};
  bool has_record_column_{}, has_quantity_column_{};
  DocumentTable table_{};
};

std::string group_name(const DocumentWriter& writer, Group group) {
  return writer.translated(std::string("group.") + name(group));
}

/// Returns "Random drift: Noise floor / (°/h)". If the rows name the quantities, the caption omits them.
std::string results_caption(const DocumentWriter& writer, const TableGroup& tables, bool has_quantity_column) {
  const std::string group = group_name(writer, tables.any().group);
  std::string own = has_quantity_column ? key_with_detail(writer, tables.any())
                                        : quantity_name(writer, tables, separate_quantities(tables).results.front());
  return contains_name(own, group) ? own : group + ": " + own;
}

void add_group(DocumentWriter& writer, Group group, const std::string& axis) {
  const std::vector<TableGroup> all = group_tables(writer.report, group, axis);
  std::vector<const TableGroup*> without_conditions;
  for (const TableGroup& one : all) {
    if (one.any().columns.empty()) continue;
    if (separate_quantities(one).conditions.empty()) {
      without_conditions.push_back(&one);
      continue;
    }
    ResultsTable table(writer, {&one});
    std::string caption = results_caption(writer, one, table.has_quantity_column());
    writer.table(std::move(table).finish(std::move(caption)));
  }
  if (without_conditions.empty()) return;
  ResultsTable table(writer, without_conditions);
  std::string caption = table.has_quantity_column() ? group_name(writer, group)
                                                    : results_caption(writer, *without_conditions.front(), false);
  writer.table(std::move(table).finish(std::move(caption)));
}

std::string axis_and_stage(const DocumentWriter& writer, const std::string& axis, Stage stage) {
  const std::string by_stage = writer.translated(name(stage));
  return axis.empty() ? by_stage : axis + ", " + by_stage;
}

std::string freedom_text(Language language, double degrees_of_freedom) {
  return std::isfinite(degrees_of_freedom) ? format_number(language, model::whole_degrees(degrees_of_freedom), 0) : "∞";
}

std::vector<Cell> budget_row(const DocumentWriter& writer, const model::BudgetRow& row) {
  const Language language = writer.language;
  const std::string unit = model::row_unit(row);
  std::string source = writer.translated(std::string("source.") + model::name(row.source));
  if (!row.of.empty()) source += " " + row.of;
  std::string note;
  const auto add_note = [&](bool holds, const char* key) {
    if (holds) note += (note.empty() ? "" : ", ") + writer.translated(key);
  };
  add_note(row.assumed, "label.assumed");
  add_note(row.chosen_on_these_folds, "label.chosen_on_these_folds");
  add_note(row.only_start_held_out, "label.only_start_held_out");
  add_note(row.without_holds, "label.without_holds");
  return {
      {.text = std::move(source), .note = std::move(note)},
      {.text = model::name(row.evaluation)},
      {.text = writer.translated(std::string("distribution.") + model::name(row.distribution))},
      {.text = append_unit("0", unit)},
      {.text = append_unit(format_significant(language, row.standard_uncertainty, 2), unit)},
      {.text = freedom_text(language, row.degrees_of_freedom)},
      {.text = unit == "°/h" ? format_plain(language, row.sensitivity)
                             : append_unit(format_significant(language, row.sensitivity, 2), sensitivity_unit(unit))},
      {.text = format_significant(language, model::contribution_deg_per_h(row), 2)}};
}

/// Returns a summary row at the end of a budget: name, degrees of freedom and value.
std::vector<Cell> budget_sum(std::string text, std::string freedom, std::string value) {
  std::vector<Cell> row(8);
  row[0].text = std::move(text);
  row[5].text = std::move(freedom);
  row[7].text = std::move(value);
  return row;
}

DocumentTable budget_table(const DocumentWriter& writer, const ReportedBudget& reported) {
  const Language language = writer.language;
  std::string of = axis_and_stage(writer, reported.axis, reported.stage);
  if (const std::string record = record_label(writer.report, reported.run); !record.empty()) of += ", " + record;
  DocumentTable table{
      .caption = writer.sentence("caption.budget", format_plain(language, reported.budget.averaging_s), of),
      .header = {},
      .text_columns = 3};
  for (const char* key : {"column.source", "column.type", "column.distribution", "column.estimate", "column.u_i",
                          "column.nu_i", "column.c_i", "column.u_i_y"})
    table.header.push_back(writer.translated(key));
  for (const model::BudgetRow& row : reported.budget.rows) table.rows.push_back(budget_row(writer, row));
  const model::CombinedUncertainty combined = model::combined(reported.budget.rows);
  table.rows.push_back(budget_sum(writer.translated("budget.combined"),
                                  freedom_text(language, combined.degrees_of_freedom),
                                  format_significant(language, combined.standard_deg_per_h, 2)));
  table.rows.push_back(
      budget_sum(writer.sentence("budget.expanded", format_number(language, combined.coverage_factor, 2)), "",
                 format_significant(language, combined.expanded_deg_per_h, 2)));
  return table;
}

/// Returns the name of a limited quantity: "compensated_mean.compensated_bias" becomes "Mean compensated bias".
std::string limited_quantity(const DocumentWriter& writer, const std::string& quantity) {
  const auto dot = quantity.find('.');
  const std::string key = writer.translated(quantity.substr(0, dot));
  if (dot == std::string::npos) return key;
  const std::string own = writer.translated(quantity.substr(dot + 1));
  return contains_name(key, own) ? key : key + ": " + own;
}

/// A limit is exact, so it is printed with all of its digits.
constexpr int kDigitsOfLimit = 12;

std::vector<Cell> conformity_row(const DocumentWriter& writer, const Conformity& one) {
  const std::string record = record_label(writer.report, one.run);
  return {{.text = name_with_unit(limited_quantity(writer, one.quantity), one.unit)},
          {.text = one.axis.empty() ? "–" : one.axis, .note = record},
          {.text = writer.translated(name(one.stage))},
          verdict_cell(writer, one.verdict),
          {.text = format_compared(writer.language, one), .note = coverage_note(writer.language, one.value)},
          {.text = format_plain(writer.language, one.limit, kDigitsOfLimit)},
          {.text = format_probability(writer.language, one.probability)}};
}

}  // namespace

Cell verdict_cell(const DocumentWriter& writer, Verdict verdict) {
  using Mark = Cell::Mark;
  const Mark mark = verdict == Verdict::pass ? Mark::pass : verdict == Verdict::fail ? Mark::fail : Mark::caution;
  return {.mark = mark, .text = writer.translated(name(verdict))};
}

void add_result_tables(DocumentWriter& writer, const std::string& axis) {
  for (const Group group : {Group::turn_on, Group::warm_up, Group::bias, Group::sensitivity, Group::hysteresis,
                            Group::random_drift, Group::compensation})
    add_group(writer, group, axis);
}

void add_model_cautions(DocumentWriter& writer, const std::string& axis, std::optional<Stage> stage) {
  for (const ModelVerification& one : writer.report.verifications) {
    if (one.axis != axis || (stage && one.stage != *stage)) continue;
    const std::string text = describe_cautions(writer.language, one);
    if (text.empty()) continue;
    std::string of = axis_and_stage(writer, axis, one.stage);
    if (const std::string record = record_label(writer.report, one.run); !record.empty()) of += ", " + record;
    writer.paragraph(of + ": " + text, Paragraph::Style::caution);
  }
}

void add_results(DocumentWriter& writer) {
  const CalibrationReport& report = writer.report;
  writer.heading("heading.results");
  if (report.results.empty()) writer.paragraph(writer.translated("say.no_results"));
  if (!report.results.empty()) {
    writer.paragraph(writer.translated("say.stages"));
    writer.paragraph(writer.translated("say.coverage") + " " +
                     writer.translated(has_unknown_zero(report) ? "say.no_u_unknown_zero" : "say.no_u"));
  }
  if (std::ranges::any_of(report.results, &ResultTable::in_sample))
    writer.paragraph(writer.translated(report.simulated ? "say.in_sample_virtual" : "say.in_sample"),
                     Paragraph::Style::caution);
  if (!report.figures.empty()) writer.paragraph(writer.translated("say.figures"), Paragraph::Style::note);
  const std::vector<std::string> axes = all_axes(report);
  for (std::size_t k = 0; k < axes.size(); ++k) {
    writer.subheading(axis_heading(writer, axes[k]), fmt::format("results-{}", k + 1));
    add_model_cautions(writer, axes[k]);
    add_result_tables(writer, axes[k]);
    add_figures(writer, axes[k]);
  }
}

void add_uncertainty(DocumentWriter& writer) {
  writer.heading("heading.uncertainty");
  if (writer.report.budgets.empty()) {
    writer.paragraph(writer.translated("say.no_budget"));
    return;
  }
  writer.paragraph(writer.translated("say.budget"));
  for (const ReportedBudget& budget : writer.report.budgets) writer.table(budget_table(writer, budget));
}

void add_conformity(DocumentWriter& writer) {
  const CalibrationReport& report = writer.report;
  writer.heading("heading.conformity");
  if (report.conformity.empty()) {
    writer.paragraph(writer.translated("say.no_limits"));
    return;
  }
  writer.paragraph(writer.translated(std::string("say.rule_") + name(report.rule)));
  writer.paragraph(writer.translated("say.probability"));
  DocumentTable table{.caption = writer.translated("caption.conformity"), .header = {}, .text_columns = 4};
  for (const char* key : {"column.quantity", "column.axis", "column.stage", "column.verdict", "column.value",
                          "column.limit", "column.probability"})
    table.header.push_back(writer.translated(key));
  for (const Conformity& one : report.conformity) table.rows.push_back(conformity_row(writer, one));
  writer.table(std::move(table));
}

}  // namespace gyrotherm::report
