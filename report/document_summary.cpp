// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "report/document_parts.hpp"

namespace gyrotherm::report {
namespace {

/// A quantity of a result with a single row.
struct Figure {
  const ResultTable* table = nullptr;
  ReportedValue value{};
  std::string unit{};
};

std::optional<Figure> figure_in(const ResultTable* table, const char* quantity) {
  const Column* column = table == nullptr ? nullptr : find_column(*table, quantity);
  if (column == nullptr || column->values.empty() || !std::isfinite(column->values.front().value)) return {};
  return Figure{table, column->values.front(), column->unit};
}

std::optional<Figure> figure_of(const CalibrationReport& report, const char* key, const char* quantity,
                                const std::string& axis, Stage stage) {
  return figure_in(result_of(report, key, axis, stage), quantity);
}

/// Returns the same quantity of the same record at another stage. Records of other programs are not comparable: their
/// requirements on the unit differ by more than the effect of a model.
std::optional<Figure> same_at(const CalibrationReport& report, Stage stage, const Figure& figure,
                              const char* quantity) {
  const ResultTable& own = *figure.table;
  const auto found = std::ranges::find_if(report.results, [&](const ResultTable& table) {
    return table.stage == stage && table.key == own.key && table.axis == own.axis && table.run == own.run;
  });
  return found == report.results.end() ? std::nullopt : figure_in(&*found, quantity);
}

constexpr const char* kMean = "compensated_bias";

std::optional<Figure> mean_of(const CalibrationReport& report, const std::string& axis, Stage stage) {
  return figure_of(report, "compensated_mean", kMean, axis, stage);
}

/// Returns the mean as found of a unit that was adjusted.
std::optional<Figure> mean_as_found(const CalibrationReport& report, Stage last, const std::optional<Figure>& mean) {
  return mean && last == Stage::as_left ? same_at(report, Stage::as_found, *mean, kMean) : std::nullopt;
}

/// Returns the state by which the unit is judged: as left, or as found if it was not adjusted.
Stage last_stage_of(const CalibrationReport& report, const std::string& axis) {
  for (const Stage stage : {Stage::as_left, Stage::as_found})
    if (mean_of(report, axis, stage) || figure_of(report, "whole_run", "rmse", axis, stage)) return stage;
  return Stage::uncompensated;
}

void add_cautions(DocumentWriter& writer) {
  const CalibrationReport& report = writer.report;
  constexpr auto kCaution = Paragraph::Style::caution;
  if (report.state == ReportState::draft)
    writer.paragraph(report.missing.empty()
                         ? writer.word_of("say.draft")
                         : writer.say("say.missing", fmt::format("{}", fmt::join(report.missing, "; "))),
                     kCaution);
  if (report.simulated) writer.paragraph(writer.word_of("say.simulated"), kCaution);
  if (report.state == ReportState::superseded || report.replaced_by)
    writer.paragraph(report.replaced_by ? writer.say("say.superseded", report.replaced_by->number)
                                        : writer.word_of("say.superseded_plainly"),
                     kCaution);
}

std::string item_in_a_line(const DocumentWriter& writer) {
  const CalibratedItem& item = writer.report.item;
  std::string text = item.manufacturer;
  if (!item.model.empty()) text += (text.empty() ? "" : " ") + item.model;
  if (text.empty()) text = item.name;
  if (!item.serial_number.empty()) text = writer.say("label.serial_short", text, item.serial_number);
  const std::string& description = in(writer.language, item.description);
  return description.empty() ? text : description + "\n" + text;
}

void add_what_was_calibrated(DocumentWriter& writer) {
  const CalibrationReport& report = writer.report;
  const Language language = writer.language;
  DefinitionsWriter lines(writer);
  lines.line_of_duty("label.item", item_in_a_line(writer));
  lines.line_of_duty("label.customer", report.customer.name);
  std::string days = format_day(language, report.begun);
  if (!report.ended.empty() && report.ended != report.begun)
    days = writer.say("label.from_to", days, format_day(language, report.ended));
  lines.line_of_duty("label.performed", days);
  lines.line_of_duty("label.issued", format_day(language, report.issued));
  writer.add(std::move(lines).finish());
}

KeyFigures::One key_figure(const DocumentWriter& writer, const Figure& figure, const char* label_key, bool best) {
  const std::string stage = writer.word_of(std::string("key.") + name(figure.table->stage));
  std::string label = writer.say("key.of_stage", writer.word_of(label_key), stage);
  if (const std::string note = coverage_note(writer.language, figure.value); !note.empty()) label += " (" + note + ")";
  if (figure.table->in_sample) label += ", " + writer.word_of("label.in_sample");
  return {.value = format(writer.language, figure.value),
          .unit = format_unit(figure.unit),
          .label = std::move(label),
          .best = best};
}

void add_key_figures(DocumentWriter& writer, const std::string& axis) {
  const CalibrationReport& report = writer.report;
  const Stage last = last_stage_of(report, axis);
  KeyFigures keys{.title = axis.empty() ? "" : writer.say("heading.axis", axis), .figures = {}};
  const auto take = [&](const std::optional<Figure>& figure, const char* label_key, bool best) {
    if (figure) keys.figures.push_back(key_figure(writer, *figure, label_key, best));
  };
  const auto mean = mean_of(report, axis, last);
  take(mean, "key.mean", true);
  take(figure_of(report, "whole_run", "rmse", axis, last), "key.rmse", false);
  take(figure_of(report, "whole_run", "std", axis, last), "key.std", false);
  take(mean_as_found(report, last, mean), "key.mean", false);
  if (!keys.figures.empty()) writer.add(std::move(keys));
}

/// Returns a sentence about the block temperatures in the training of the axis' model; empty without a model.
std::string range_of(const DocumentWriter& writer, const std::string& axis) {
  const CalibrationReport& report = writer.report;
  const auto range = [&](Stage stage) {
    return std::ranges::find_if(report.trained_ranges,
                                [&](const TrainedRange& one) { return one.axis == axis && one.stage == stage; });
  };
  auto found = range(Stage::as_left);
  if (found == report.trained_ranges.end()) found = range(Stage::as_found);
  if (found == report.trained_ranges.end()) return {};
  const std::string prefix = axis.empty() ? "" : axis + ": ";
  if (!found->block) return writer.say("say.trained_range_unknown", prefix);
  // Integer degrees inside the range, as `train` prints them.
  const auto whole = [&](double celsius) { return format_number(writer.language, celsius, 0); };
  return writer.say("say.trained_range", prefix, whole(std::ceil(found->block->low_c)),
                    whole(std::floor(found->block->high_c)));
}

std::string sentence_of_change(const DocumentWriter& writer, const Figure& left, const Figure& found) {
  const double change = std::abs(left.value.value - found.value.value);
  const double both = std::hypot(left.value.expanded(), found.value.expanded());
  const std::string before = quantity_in_a_sentence(writer.language, found.value, found.unit);
  if (!std::isfinite(both)) return {};
  return writer.say(change > both ? "say.changed" : "say.unchanged", before);
}

/// Returns two or three sentences about one axis.
std::string meaning_of(const DocumentWriter& writer, const std::string& axis) {
  const CalibrationReport& report = writer.report;
  const Language language = writer.language;
  const Stage last = last_stage_of(report, axis);
  if (last == Stage::uncompensated) return {};
  const std::string prefix = axis.empty() ? "" : axis + ": ";
  std::string text;
  const auto mean = mean_of(report, axis, last);
  const auto found = mean_as_found(report, last, mean);
  if (mean)
    text = writer.say(last == Stage::as_left ? "say.mean_as_left" : "say.mean_as_found", prefix,
                      quantity_in_a_sentence(language, mean->value, mean->unit));
  if (mean && found) text += " " + sentence_of_change(writer, *mean, *found);
  const auto rmse = figure_of(report, "whole_run", "rmse", axis, last);
  if (!rmse) return text;
  const auto raw = same_at(report, Stage::uncompensated, *rmse, "rmse");
  text += text.empty() ? prefix : " ";
  const std::string own = quantity_in_a_sentence(language, rmse->value, rmse->unit);
  if (!raw || !(rmse->value.value > 0)) return text + writer.say("say.gain_plain", own);
  return text + writer.say("say.gain", own, quantity_in_a_sentence(language, raw->value, raw->unit),
                           format_significant(language, raw->value.value / rmse->value.value, 2));
}

/// Verdict over the results of one stage.
struct StageVerdict {
  Verdict worst = Verdict::pass;
  int passed = 0, all = 0;
  double least_probability = std::numeric_limits<double>::quiet_NaN();
};

StageVerdict verdict_at(const CalibrationReport& report, Stage stage) {
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
    writer.paragraph(writer.word_of("say.no_limits"));
    return;
  }
  DocumentTable table{.caption = writer.word_of("caption.verdicts"),
                      .header = {writer.word_of("column.stage"), writer.word_of("column.verdict"),
                                 writer.word_of("column.passed"), writer.word_of("column.least_probability")},
                      .text_columns = 2};
  for (const Stage stage : {Stage::as_left, Stage::as_found, Stage::uncompensated}) {
    const StageVerdict verdict = verdict_at(report, stage);
    if (verdict.all == 0) continue;
    table.rows.push_back({{.text = writer.word_of(name(stage))},
                          verdict_cell(writer, verdict.worst),
                          {.text = writer.say("title.of", verdict.passed, verdict.all)},
                          {.text = format_probability(writer.language, verdict.least_probability)}});
  }
  writer.table(std::move(table));
  writer.paragraph(writer.word_of(std::string("say.rule_") + name(report.rule)), Paragraph::Style::note);
}

std::string standing_of(const DocumentWriter& writer, const ComparedModel& model) {
  std::string text;
  const auto join = [&](bool there, const char* key) {
    if (there) text += (text.empty() ? "" : ", ") + writer.word_of(key);
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
  row.push_back({.text = standing_of(writer, model)});
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
  DocumentTable table{.caption = writer.word_of("caption.compared"), .header = {}, .text_columns = with_axis ? 3u : 2u};
  if (with_axis) table.header.push_back(writer.word_of("column.axis"));
  for (const char* key : {"column.model_role", "column.method", "column.rmse", "column.std", "column.expanded"})
    table.header.push_back(writer.word_of(key));
  for (const ComparedModel& model : report.compared) table.rows.push_back(compared_row(writer, model, with_axis));
  writer.paragraph(writer.word_of(say_of_models(report.compared)));
  writer.table(std::move(table));
}

}  // namespace

void add_summary(DocumentWriter& writer) {
  add_cautions(writer);
  writer.heading("heading.summary");
  add_what_was_calibrated(writer);
  for (const std::string& axis : axes_of(writer.report)) add_key_figures(writer, axis);
  for (const std::string& axis : axes_of(writer.report)) writer.paragraph(range_of(writer, axis));
  const bool in_sample = std::ranges::any_of(writer.report.results, &ResultTable::in_sample);
  if (in_sample) writer.paragraph(writer.word_of("say.in_sample"), Paragraph::Style::caution);
  add_verdict(writer);
  for (const std::string& axis : axes_of(writer.report)) writer.paragraph(meaning_of(writer, axis));
  add_compared(writer);
}

}  // namespace gyrotherm::report
