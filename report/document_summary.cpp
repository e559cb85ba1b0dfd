// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "report/cautions.hpp"
#include "report/document_parts.hpp"
#include "report/stored_texts.hpp"

namespace gyrotherm::report {
namespace {

/// Value of one quantity in a result that has a single row.
struct SummaryValue {
  const ResultTable* table = nullptr;
  std::string quantity{};
  ReportedValue value{};
  std::string unit{};
};

std::optional<SummaryValue> find_value(const ResultTable* table, const char* quantity) {
  const Column* column = table == nullptr ? nullptr : find_column(*table, quantity);
  if (column == nullptr || column->values.empty() || !std::isfinite(column->values.front().value)) return {};
  return SummaryValue{table, quantity, column->values.front(), column->unit};
}

std::optional<SummaryValue> find_result_value(const CalibrationReport& report, const char* key, const char* quantity,
                                              const std::string& axis, Stage stage) {
  return find_value(find_representative_result(report, key, axis, stage), quantity);
}

/// Returns the same quantity of the same record at another stage. Only the same record is comparable, because the
/// difference between profiles exceeds the effect of a model.
std::optional<SummaryValue> find_at_stage(const CalibrationReport& report, Stage stage, const SummaryValue& figure,
                                          const char* quantity) {
  const ResultTable& own = *figure.table;
  const auto found = std::ranges::find_if(report.results, [&](const ResultTable& table) {
    return table.stage == stage && table.key == own.key && table.axis == own.axis && table.run == own.run;
  });
  return found == report.results.end() ? std::nullopt : find_value(&*found, quantity);
}

constexpr const char* kMeanQuantity = "compensated_bias";

std::optional<SummaryValue> find_mean(const CalibrationReport& report, const std::string& axis, Stage stage) {
  return find_result_value(report, "compensated_mean", kMeanQuantity, axis, stage);
}

/// Returns the as-found mean for comparison with the as-left mean; nothing if the unit was not adjusted.
std::optional<SummaryValue> find_mean_as_found(const CalibrationReport& report, Stage last,
                                               const std::optional<SummaryValue>& mean) {
  return mean && last == Stage::as_left ? find_at_stage(report, Stage::as_found, *mean, kMeanQuantity) : std::nullopt;
}

/// Returns the last stage with a result of the axis: as left, otherwise as found, otherwise uncompensated.
Stage find_last_stage(const CalibrationReport& report, const std::string& axis) {
  for (const Stage stage : {Stage::as_left, Stage::as_found})
    if (find_mean(report, axis, stage) || find_result_value(report, "whole_run", "rmse", axis, stage)) return stage;
  return Stage::uncompensated;
}

void add_cautions(DocumentWriter& writer) {
  const CalibrationReport& report = writer.report;
  constexpr auto kCaution = Paragraph::Style::caution;
  if (report.state == ReportState::draft)
    writer.paragraph(report.missing.empty()
                         ? writer.translated("say.draft")
                         : writer.sentence("say.missing", translate_missing(writer.language, report.missing)),
                     kCaution);
  if (report.simulated) writer.paragraph(writer.translated("say.simulated"), kCaution);
  for (const RecordCaution& one : list_record_cautions(writer.language, report)) {
    const std::string record = record_label(report, one.run);
    writer.paragraph(record.empty() ? one.text : record + ": " + one.text, kCaution);
  }
  if (report.state == ReportState::superseded || report.replaced_by)
    writer.paragraph(report.replaced_by ? writer.sentence("say.superseded", report.replaced_by->number)
                                        : writer.translated("say.superseded_plainly"),
                     kCaution);
}

std::string item_text(const DocumentWriter& writer) {
  const CalibratedItem& item = writer.report.item;
  std::string text = item.manufacturer;
  if (!item.model.empty()) text += (text.empty() ? "" : " ") + item.model;
  if (text.empty()) text = item.name;
  if (!item.serial_number.empty()) text = writer.sentence("label.serial_short", text, item.serial_number);
  const std::string& description = text_in(writer.language, item.description);
  return description.empty() ? text : description + "\n" + text;
}

void add_calibrated_item(DocumentWriter& writer) {
  const CalibrationReport& report = writer.report;
  const Language language = writer.language;
  DefinitionsWriter lines(writer);
  lines.required_line("label.item", item_text(writer));
  lines.required_line("label.customer", report.customer.name);
  std::string days = format_day(language, report.begun);
  if (!report.ended.empty() && report.ended != report.begun)
    days = writer.sentence("label.from_to", days, format_day(language, report.ended));
  lines.required_line("label.performed", days);
  lines.required_line("label.issued", format_day(language, report.issued));
  writer.add(std::move(lines).finish());
}

/// Returns the worst verdict on a figure: on its own quantity, axis, stage and record. Returns nothing if no limit
/// applies to it.
std::optional<Verdict> find_verdict(const CalibrationReport& report, const SummaryValue& figure) {
  std::optional<Verdict> worst;
  const ResultTable& own = *figure.table;
  for (const Conformity& one : report.conformity)
    if (one.quantity == own.key + "." + figure.quantity && one.axis == own.axis && one.stage == own.stage &&
        one.run == own.run)
      worst = std::max(worst.value_or(Verdict::pass), one.verdict);
  return worst;
}

KeyFigures::Entry key_figure(const DocumentWriter& writer, const SummaryValue& figure, const char* label_key) {
  const std::string stage = writer.translated(std::string("key.") + name(figure.table->stage));
  std::string label = writer.sentence("key.of_stage", writer.translated(label_key), stage);
  if (const std::string note = coverage_note(writer.language, figure.value); !note.empty()) label += " (" + note + ")";
  if (const std::string record = record_label(writer.report, figure.table->run); !record.empty())
    label += ", " + record;
  if (figure.table->in_sample) label += ", " + writer.translated("label.in_sample");
  const std::optional<Verdict> verdict = find_verdict(writer.report, figure);
  if (verdict) label += "; " + writer.translated(name(*verdict));
  return {.value = format(writer.language, figure.value),
          .unit = format_unit(figure.unit),
          .label = std::move(label),
          .best = verdict == Verdict::pass};
}

void add_key_figures(DocumentWriter& writer, const std::string& axis) {
  const CalibrationReport& report = writer.report;
  const Stage last = find_last_stage(report, axis);
  KeyFigures keys{.title = axis.empty() ? "" : writer.sentence("heading.axis", axis), .figures = {}};
  const auto take = [&](const std::optional<SummaryValue>& figure, const char* label_key) {
    if (figure) keys.figures.push_back(key_figure(writer, *figure, label_key));
  };
  const auto mean = find_mean(report, axis, last);
  take(mean, "key.mean");
  take(find_result_value(report, "whole_run", "rmse", axis, last), "key.rmse");
  take(find_result_value(report, "whole_run", "std", axis, last), "key.std");
  take(find_mean_as_found(report, last, mean), "key.mean");
  if (!keys.figures.empty()) writer.add(std::move(keys));
}

/// Returns a sentence about the block temperatures in the training of the axis' model; empty without a model.
std::string trained_range_text(const DocumentWriter& writer, const std::string& axis) {
  const CalibrationReport& report = writer.report;
  const auto range = [&](Stage stage) {
    return std::ranges::find_if(report.trained_ranges,
                                [&](const TrainedRange& one) { return one.axis == axis && one.stage == stage; });
  };
  auto found = range(Stage::as_left);
  if (found == report.trained_ranges.end()) found = range(Stage::as_found);
  if (found == report.trained_ranges.end()) return {};
  const std::string prefix = axis.empty() ? "" : axis + ": ";
  if (!found->block) return writer.sentence("say.trained_range_unknown", prefix);
  // Rounded inwards to integer degrees, as `train` prints them.
  const auto whole = [&](double celsius) { return format_number(writer.language, celsius, 0); };
  const bool is_named = !found->block->thermometers.empty();  // not in models of gyrotherm 0.1.0
  std::string text = writer.sentence(is_named ? "say.trained_range" : "say.trained_range_unnamed", prefix,
                                     whole(std::ceil(found->block->low_c)), whole(std::floor(found->block->high_c)));
  if (is_named)
    text += " " + writer.sentence("say.trained_block", fmt::format("{}", fmt::join(found->block->thermometers, ", ")));
  for (const model::ThermometerRange& other : found->block->others)
    text += " " + writer.sentence("say.trained_other", other.thermometer, whole(std::ceil(other.low_c)),
                                  whole(std::floor(other.high_c)));
  return text;
}

std::string change_text(const DocumentWriter& writer, const SummaryValue& left, const SummaryValue& found) {
  const double change = std::abs(left.value.value - found.value.value);
  const double both = std::hypot(left.value.expanded(), found.value.expanded());
  const std::string before = quantity_text(writer.language, found.value, found.unit);
  if (!std::isfinite(both)) return {};
  return writer.sentence(change > both ? "say.changed" : "say.unchanged", before);
}

/// Returns "u1.x, R2: " before a sentence about a result of a record; empty without an axis and with one record.
std::string sentence_prefix(const DocumentWriter& writer, const std::string& axis, const std::string& run) {
  const std::string record = record_label(writer.report, run);
  const std::string text = axis.empty() || record.empty() ? axis + record : axis + ", " + record;
  return text.empty() ? text : text + ": ";
}

/// Returns a sentence about the bias of the whole run before and after compensation, as RMSE, or as STD if the zero of
/// the bias is unknown. Begins with the axis and record unless the text before it, about `mean`, is of the same record.
std::string gain_text(const DocumentWriter& writer, const SummaryValue& figure,
                      const std::optional<SummaryValue>& mean) {
  const CalibrationReport& report = writer.report;
  const Language language = writer.language;
  const ResultTable& table = *figure.table;
  const bool is_std = figure.quantity == "std";
  const std::string prefix =
      !mean || mean->table->run != table.run ? sentence_prefix(writer, table.axis, table.run) : std::string();
  const std::string own = quantity_text(language, figure.value, figure.unit);
  const auto raw = find_at_stage(report, Stage::uncompensated, figure, figure.quantity.c_str());
  if (!raw || !(figure.value.value > 0))
    return prefix + writer.sentence(is_std ? "say.std_gain_plain" : "say.gain_plain", own);
  return prefix + writer.sentence(is_std ? "say.std_gain" : "say.gain", own,
                                  quantity_text(language, raw->value, raw->unit),
                                  format_significant(language, raw->value.value / figure.value.value, 2));
}

/// Returns two or three sentences about one axis. A mean with an unknown zero is left out.
std::string axis_summary(const DocumentWriter& writer, const std::string& axis) {
  const CalibrationReport& report = writer.report;
  const Language language = writer.language;
  const Stage last = find_last_stage(report, axis);
  if (last == Stage::uncompensated) return {};
  std::string text;
  auto mean = find_mean(report, axis, last);
  if (mean && has_unknown_zero(report, *mean->table, kMeanQuantity)) mean.reset();
  const auto found = find_mean_as_found(report, last, mean);
  if (mean)
    text = writer.sentence(last == Stage::as_left ? "say.mean_as_left" : "say.mean_as_found",
                           sentence_prefix(writer, axis, mean->table->run),
                           quantity_text(language, mean->value, mean->unit));
  if (mean && found) text += " " + change_text(writer, *mean, *found);
  auto figure = find_result_value(report, "whole_run", "rmse", axis, last);
  if (figure && has_unknown_zero(report, *figure->table, figure->quantity)) figure = find_value(figure->table, "std");
  if (!figure) return text;
  return text + (text.empty() ? "" : " ") + gain_text(writer, *figure, mean);
}

/// Verdict over the results of one stage.
struct StageVerdict {
  Verdict worst = Verdict::pass;
  int passed = 0, all = 0;
  double least_probability = std::numeric_limits<double>::quiet_NaN();
};

StageVerdict stage_verdict(const CalibrationReport& report, Stage stage) {
  StageVerdict found;
  for (const Conformity& one : report.conformity) {
    if (one.stage != stage) continue;
    ++found.all;
    if (one.verdict == Verdict::pass) ++found.passed;
    found.worst = std::max(found.worst, one.verdict);
    found.least_probability = std::fmin(found.least_probability, one.probability);
  }
  return found;
}

void add_verdict(DocumentWriter& writer) {
  const CalibrationReport& report = writer.report;
  if (report.conformity.empty()) {
    writer.paragraph(writer.translated("say.no_limits"));
    return;
  }
  DocumentTable table{.caption = writer.translated("caption.verdicts"),
                      .header = {writer.translated("column.stage"), writer.translated("column.verdict"),
                                 writer.translated("column.passed"), writer.translated("column.least_probability")},
                      .text_columns = 2};
  for (const Stage stage : {Stage::as_left, Stage::as_found, Stage::uncompensated}) {
    const StageVerdict verdict = stage_verdict(report, stage);
    if (verdict.all == 0) continue;
    table.rows.push_back({{.text = writer.translated(name(stage))},
                          verdict_cell(writer, verdict.worst),
                          {.text = writer.sentence("title.of", verdict.passed, verdict.all)},
                          {.text = format_probability(writer.language, verdict.least_probability)}});
  }
  writer.table(std::move(table));
  writer.paragraph(writer.translated(std::string("say.rule_") + name(report.rule)), Paragraph::Style::note);
}

std::string model_roles(const DocumentWriter& writer, const ComparedModel& model) {
  std::string text;
  const auto join = [&](bool there, const char* key) {
    if (there) text += (text.empty() ? "" : ", ") + writer.translated(key);
  };
  join(model.left, "model.left");
  join(model.recommended, "model.recommended");
  join(model.simple, "model.simple");
  return text.empty() ? "–" : text;
}

std::vector<Cell> compared_row(const DocumentWriter& writer, const ComparedModel& model, bool with_axis) {
  const auto number = [&](double value) { return Cell{.text = format_significant(writer.language, value, 3)}; };
  std::vector<Cell> row;
  if (with_axis) row.push_back({.text = model.axis});
  row.push_back({.text = model_roles(writer, model)});
  row.push_back({.text = model.method, .note = model.inputs});
  row.push_back(number(model.rmse_deg_per_h));
  row.push_back(number(model.std_deg_per_h));
  row.push_back({.text = format_significant(writer.language, model.expanded_deg_per_h, 2)});
  return row;
}

void add_compared(DocumentWriter& writer) {
  const CalibrationReport& report = writer.report;
  if (report.compared.empty()) return;
  const bool with_axis =
      std::ranges::any_of(report.compared, [](const ComparedModel& model) { return !model.axis.empty(); });
  DocumentTable table{
      .caption = writer.translated("caption.compared"), .header = {}, .text_columns = with_axis ? 3u : 2u};
  if (with_axis) table.header.push_back(writer.translated("column.axis"));
  for (const char* key : {"column.model_role", "column.method", "column.rmse", "column.std", "column.expanded"})
    table.header.push_back(writer.translated(key));
  for (const ComparedModel& model : report.compared) table.rows.push_back(compared_row(writer, model, with_axis));
  writer.paragraph(writer.translated(models_text_key(report.compared)));
  writer.table(std::move(table));
}

}  // namespace

void add_summary(DocumentWriter& writer) {
  add_cautions(writer);
  writer.heading("heading.summary");
  add_calibrated_item(writer);
  for (const std::string& axis : all_axes(writer.report))
    add_model_cautions(writer, axis, find_last_stage(writer.report, axis));
  for (const std::string& axis : all_axes(writer.report)) add_key_figures(writer, axis);
  for (const std::string& axis : all_axes(writer.report)) writer.paragraph(trained_range_text(writer, axis));
  const bool in_sample = std::ranges::any_of(writer.report.results, &ResultTable::in_sample);
  if (in_sample)
    writer.paragraph(writer.translated(writer.report.simulated ? "say.in_sample_virtual" : "say.in_sample"),
                     Paragraph::Style::caution);
  add_verdict(writer);
  for (const std::string& axis : all_axes(writer.report)) writer.paragraph(axis_summary(writer, axis));
  add_compared(writer);
}

}  // namespace gyrotherm::report
