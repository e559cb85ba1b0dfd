// SPDX-License-Identifier: Apache-2.0
#include "report/document.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <optional>
#include <utility>

#include "report/document_parts.hpp"

namespace gyrotherm::report {

void BlockWriter::heading(std::string_view key) {
  add(Heading{.text = translated(key), .id = std::string(key.substr(key.find('.') + 1))});
}

void BlockWriter::subheading(std::string text, std::string id) {
  add(Heading{.text = std::move(text), .sub = true, .id = std::move(id)});
}

void BlockWriter::paragraph(std::string text, Paragraph::Style style) {
  if (!text.empty()) add(Paragraph{style, std::move(text)});
}

void BlockWriter::table(DocumentTable table) {
  if (table.rows.empty()) return;
  for ([[maybe_unused]] const auto& row : table.rows) assert(row.size() == table.header.size());
  add(std::move(table));
}

void BlockWriter::number_captions() {
  int tables = 0, figures = 0;
  for (Block& block : blocks) {
    if (auto* table = std::get_if<DocumentTable>(&block))
      table->caption = fmt::format("{} {}: {}", translated("title.table"), ++tables, table->caption);
    if (auto* figure = std::get_if<DocumentFigure>(&block))
      figure->caption = fmt::format("{} {}: {}", translated("title.figure"), ++figures, figure->caption);
  }
}

void DefinitionsWriter::line(std::string_view label_key, std::string value) {
  if (!value.empty()) made_.lines.emplace_back(writer_.translated(label_key), std::move(value));
}

void DefinitionsWriter::required_line(std::string_view label_key, std::string value) {
  line(label_key, value.empty() ? writer_.translated("label.not_given") : std::move(value));
}

std::string coverage_note(Language language, const ReportedValue& value) {
  if (!std::isfinite(value.value) || !(value.expanded() > 0)) return {};
  // At this and higher ν, k has the value of the normal distribution to the printed digits.
  constexpr double kNormal = 10'000;
  std::string note = "k\u00a0=\u00a0" + format_number(language, value.coverage_factor, 2);
  if (value.degrees_of_freedom < kNormal)
    note += ", ν\u00a0=\u00a0" + format_number(language, model::whole_degrees(value.degrees_of_freedom), 0);
  return note;
}

std::string quantity_text(Language language, const ReportedValue& value, std::string_view unit) {
  std::string text = format(language, value);
  const bool has_u = std::isfinite(value.expanded()) && value.expanded() > 0;
  if (has_u && !text.starts_with('(')) text = "(" + text + ")";
  if (const std::string printed = format_unit(unit); !printed.empty()) text = append_unit(text, unit);
  if (has_u) text += " (k\u00a0=\u00a0" + format_number(language, value.coverage_factor, 2) + ")";
  return text;
}

std::string record_label(const CalibrationReport& report, const std::string& run) {
  int number = 0, found = 0;
  for (const UsedFile& file : report.files) {
    if (file.role != "record") continue;
    ++number;
    if (file.id == run) found = number;
  }
  if (number < 2 || run.empty()) return {};
  return found > 0 ? fmt::format("R{}", found) : run.substr(0, 8);
}

std::vector<std::string> all_axes(const CalibrationReport& report) {
  std::vector<std::string> axes = report.item.axes;
  const auto take = [&](const std::string& axis) {
    if (std::ranges::find(axes, axis) == axes.end()) axes.push_back(axis);
  };
  for (const ResultTable& table : report.results) take(table.axis);
  for (const FigureData& figure : report.figures) take(figure.axis);
  return axes;
}

std::string axis_heading(const DocumentWriter& writer, const std::string& axis) {
  return axis.empty() ? writer.translated("heading.results_of") : writer.sentence("heading.axis", axis);
}

namespace {

/// Returns the order of a result among those of several records: its worst verdict, then the RMSE of its record.
/// Returns −1 for what the report does not have.
std::pair<int, double> rank_record(const CalibrationReport& report, const ResultTable& table) {
  const auto is_same = [&](const auto& one) {
    return one.axis == table.axis && one.stage == table.stage && one.run == table.run;
  };
  int worst = -1;
  for (const Conformity& one : report.conformity)
    if (is_same(one)) worst = std::max(worst, static_cast<int>(one.verdict));
  double rmse = -1;
  for (const ResultTable& one : report.results) {
    const Column* column = one.key == "whole_run" && is_same(one) ? find_column(one, "rmse") : nullptr;
    if (column != nullptr && !column->values.empty()) rmse = std::fmax(rmse, column->values.front().value);
  }
  return {worst, rmse};
}

}  // namespace

const ResultTable* find_representative_result(const CalibrationReport& report, std::string_view key,
                                              std::string_view axis, Stage stage) {
  const ResultTable* best = nullptr;
  const auto rank = [&](const ResultTable& table) {
    return std::pair((table.in_sample ? 0 : 2) + (table.run.empty() ? 1 : 0), rank_record(report, table));
  };
  for (const ResultTable& table : report.results) {
    if (table.key != key || table.axis != axis || table.stage != stage) continue;
    if (best == nullptr || rank(table) > rank(*best)) best = &table;
  }
  return best;
}

namespace {

std::string document_title(const DocumentWriter& writer) {
  const std::string own = text_in(writer.language, writer.report.title);
  const std::string title = own.empty() ? writer.translated("title.report") : own;
  return writer.report.state == ReportState::draft ? writer.sentence("title.draft", title) : title;
}

}  // namespace

std::string document_mark(const DocumentWriter& writer) {
  std::string mark;
  const auto join = [&](std::string_view key) { mark += (mark.empty() ? "" : " · ") + writer.translated(key); };
  if (writer.report.state == ReportState::draft) join("mark.draft");
  if (writer.report.simulated) join("mark.simulated");
  if (writer.report.state == ReportState::superseded) join("mark.superseded");
  return mark;
}

Document make_document(const CalibrationReport& report, Language language) {
  DocumentWriter writer(report, language);
  add_summary(writer);
  add_identification(writer);
  add_method(writer);
  add_equipment(writer);
  add_results(writer);
  add_uncertainty(writer);
  add_conformity(writer);
  add_deviations(writer);
  add_files(writer);
  add_statements(writer);
  writer.number_captions();
  return {
      .language = language,
      .title = document_title(writer),
      .number = report.number.empty() ? "–" : report.number,
      .laboratory = report.laboratory.name,
      .logo = report.logo,
      .mark = document_mark(writer),
      .end = report.number.empty() ? writer.translated("title.end") : writer.sentence("title.end_of", report.number),
      .page_of = writer.translated("title.page_of"),
      .blocks = std::move(writer.blocks)};
}

}  // namespace gyrotherm::report
