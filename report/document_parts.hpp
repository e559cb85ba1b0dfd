// SPDX-License-Identifier: Apache-2.0
/// What documents are made with: for document*.cpp and comparison_document.cpp alone.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "report/document.hpp"

namespace gyrotherm::report {

/// Appends blocks to a document, in its language.
class BlockWriter {
 public:
  explicit BlockWriter(Language in_language) : language(in_language) {}

  /// The text of a heading is a key of the table of words, which is its id too: "heading.results" is "results".
  void heading(std::string_view key);
  void subheading(std::string text, std::string id);
  /// Empty text makes no paragraph.
  void paragraph(std::string text, Paragraph::Style style = Paragraph::Style::plain);
  /// A table without rows makes none.
  void table(DocumentTable table);
  template <class Part>
  void add(Part part) {
    blocks.emplace_back(std::in_place_type<Part>, std::move(part));
  }

  [[nodiscard]] std::string word_of(std::string_view key) const { return std::string(word(language, key)); }
  template <class... Values>
  [[nodiscard]] std::string say(std::string_view key, const Values&... values) const {
    return sentence(language, key, values...);
  }

  /// "Table 3: …" and "Figure 2: …", each counted from 1, once all of them are there.
  void number_captions();

  const Language language;
  std::vector<Block> blocks{};
};

/// … of a calibration report.
class DocumentWriter : public BlockWriter {
 public:
  DocumentWriter(const CalibrationReport& of, Language in_language) : BlockWriter(in_language), report(of) {}

  const CalibrationReport& report;
};

/// Lines of what and value; those without a value are left out, or say that it is not given.
class DefinitionsWriter {
 public:
  explicit DefinitionsWriter(const DocumentWriter& writer) : writer_(writer) {}
  void line(std::string_view label_key, std::string value);
  void line_of_duty(std::string_view label_key, std::string value);
  [[nodiscard]] Definitions finish() && { return std::move(made_); }

 private:
  const DocumentWriter& writer_;
  Definitions made_{};
};

/// "k = 2.03, ν = 35"; empty without U.
[[nodiscard]] std::string coverage_note(Language language, const ReportedValue& value);
/// "(0.002 000 ± 0.000 061) °/h (k = 2.02)".
[[nodiscard]] std::string quantity_in_a_sentence(Language language, const ReportedValue& value, std::string_view unit);
/// "R1", "R2" of the records of a report; empty of one that has one record alone, and of no run.
[[nodiscard]] std::string record_label(const CalibrationReport& report, const std::string& run);
/// The axes of the item, and those of results and figures that are not among them.
[[nodiscard]] std::vector<std::string> axes_of(const CalibrationReport& report);
/// "Axis u1.x"; "Results of the unit" of one without a name.
[[nodiscard]] std::string axis_heading(const DocumentWriter& writer, const std::string& axis);
/// The result of that key that speaks for the unit: none that the model was fitted to if there is another, of all
/// records together before one of a single; null if there is none.
[[nodiscard]] const ResultTable* result_of(const CalibrationReport& report, std::string_view key, std::string_view axis,
                                           Stage stage);

/// A verdict in words and by its sign.
[[nodiscard]] Cell verdict_cell(const DocumentWriter& writer, Verdict verdict);

void add_summary(DocumentWriter& writer);
void add_identification(DocumentWriter& writer);
void add_method(DocumentWriter& writer);
void add_equipment(DocumentWriter& writer);
void add_results(DocumentWriter& writer);
void add_uncertainty(DocumentWriter& writer);
void add_conformity(DocumentWriter& writer);
void add_deviations(DocumentWriter& writer);
void add_files(DocumentWriter& writer);
void add_statements(DocumentWriter& writer);

/// The tables of one axis, group by group.
void add_result_tables(DocumentWriter& writer, const std::string& axis);
/// The figures of one axis.
void add_figures(DocumentWriter& writer, const std::string& axis);

}  // namespace gyrotherm::report
