// SPDX-License-Identifier: Apache-2.0
/// Helpers that build documents, used only by document*.cpp and comparison*.cpp.
#pragma once

#include <optional>
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

  /// Appends a heading. Its text is a key of words.hpp and also gives the id: "heading.results" becomes "results".
  void heading(std::string_view key);
  void subheading(std::string text, std::string id);
  /// Appends a paragraph unless the text is empty.
  void paragraph(std::string text, Paragraph::Style style = Paragraph::Style::plain);
  /// Appends a table unless it has no rows.
  void table(DocumentTable table);
  template <class Part>
  void add(Part part) {
    blocks.emplace_back(std::in_place_type<Part>, std::move(part));
  }

  [[nodiscard]] std::string translated(std::string_view key) const { return std::string(translate(language, key)); }
  template <class... Values>
  [[nodiscard]] std::string sentence(std::string_view key, const Values&... values) const {
    return report::sentence(language, key, values...);
  }

  /// Numbers all captions from 1: "Table 3: …" and "Figure 2: …". Call it after the last block.
  void number_captions();

  const Language language;
  std::vector<Block> blocks{};
};

/// A writer for the document of a calibration report.
class DocumentWriter : public BlockWriter {
 public:
  DocumentWriter(const CalibrationReport& of, Language in_language) : BlockWriter(in_language), report(of) {}

  const CalibrationReport& report;
};

/// Collects lines of label and value. Lines without a value are omitted; required ones are marked "not given".
class DefinitionsWriter {
 public:
  explicit DefinitionsWriter(const DocumentWriter& writer) : writer_(writer) {}
  void line(std::string_view label_key, std::string value);
  void required_line(std::string_view label_key, std::string value);
  [[nodiscard]] Definitions finish() && { return std::move(made_); }

 private:
  const DocumentWriter& writer_;
  Definitions made_{};
};

/// Returns the mark of the report, "DRAFT · SIMULATED", for its pages and figures; empty for a valid report.
[[nodiscard]] std::string document_mark(const DocumentWriter& writer);
/// Returns "k = 2.03, ν = 35"; empty without U.
[[nodiscard]] std::string coverage_note(Language language, const ReportedValue& value);
/// Returns "(0.002 000 ± 0.000 061) °/h (k = 2.02)".
[[nodiscard]] std::string quantity_text(Language language, const ReportedValue& value, std::string_view unit);
/// Returns the short name of a record, "R1" or "R2"; empty without a run, or if the report has only one record.
[[nodiscard]] std::string record_label(const CalibrationReport& report, const std::string& run);
/// Returns the axes of the item and further axes of results and figures.
[[nodiscard]] std::vector<std::string> all_axes(const CalibrationReport& report);
/// Returns "Axis u1.x", or "Results of the unit" for an axis without a name.
[[nodiscard]] std::string axis_heading(const DocumentWriter& writer, const std::string& axis);
/// Returns the most representative result of a key. Prefers a result on an unseen record to an in-sample one, then a
/// result of all records to one of a single record. Among several records it takes the one with the worst verdict on
/// any result of the axis and stage, then the one with the largest RMSE. Returns null if there is none.
[[nodiscard]] const ResultTable* find_representative_result(const CalibrationReport& report, std::string_view key,
                                                            std::string_view axis, Stage stage);

/// Adds the cautions about the models of an axis, one paragraph per record. `stage` limits them to one stage.
void add_model_cautions(DocumentWriter& writer, const std::string& axis, std::optional<Stage> stage = {});

/// Returns a verdict with text and sign.
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

/// Adds the tables of one axis, group by group.
void add_result_tables(DocumentWriter& writer, const std::string& axis);
/// Adds the figures of one axis.
void add_figures(DocumentWriter& writer, const std::string& axis);

}  // namespace gyrotherm::report
