// SPDX-License-Identifier: Apache-2.0
/// Elements of a Digital Calibration Certificate, shared by dcc.cpp and dcc_results.cpp. Each function writes one
/// element of the schema, or a few.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "report/calibration.hpp"
#include "report/words.hpp"
#include "report/xml_text.hpp"

namespace gyrotherm::report {

/// Returns the text of a key in both languages. `value`, if given, replaces {}.
[[nodiscard]] Texts texts_for(std::string_view key);
[[nodiscard]] Texts texts_for(std::string_view key, std::string_view value);
/// Returns the text of a key from a report, or the key itself if the table does not have it. A report of a newer
/// version may have unknown keys.
[[nodiscard]] Texts texts_or_key(std::string_view key);
/// Returns a text that is the same in both languages.
[[nodiscard]] Texts same_text(std::string_view text);
/// Joins two texts in each language.
[[nodiscard]] Texts join_texts(const Texts& first, std::string_view between, const Texts& second);

/// Returns the language in which all texts of the laboratory are given: English if possible, otherwise German; English
/// if neither is complete.
[[nodiscard]] Language mandatory_language(const CalibrationReport& report);

/// Returns the text, or "not given" if it is empty.
[[nodiscard]] std::string text_or_not_given(std::string_view text);

/// Returns the text unchanged if it is a valid day such as "2026-11-25", otherwise nothing.
[[nodiscard]] std::optional<std::string> calendar_day(std::string_view text);

/// Writes the elements of one certificate.
class DccText {
 public:
  explicit DccText(const CalibrationReport& report) : report_(report), mandatory_(mandatory_language(report)) {}

  [[nodiscard]] const CalibrationReport& report() const { return report_; }
  [[nodiscard]] Language mandatory() const { return mandatory_; }
  [[nodiscard]] XmlText& xml() { return xml_; }

  /// Writes a text in both languages. If the text in the mandatory language is missing, it is replaced by the other
  /// text with a note.
  void text(const char* name, const Texts& texts, const XmlText::Attributes& attributes = {});
  /// Writes a proper name, without a language attribute.
  void proper_name(const char* name, std::string_view proper);
  /// Writes dcc:identification. An empty name is omitted.
  void identification(const char* issuer, std::string_view value, const Texts& name,
                      const XmlText::Attributes& attributes = {});
  /// Writes a quantity with one value or a list of values.
  void quantity(const Texts& name, const std::string& ref_type, std::string_view unit,
                const std::vector<ReportedValue>& values, const char* element = "dcc:quantity");
  /// Writes a quantity with a separate unit for each value; as texts if D-SI cannot express one of the units.
  void quantity(const Texts& name, const std::string& ref_type, const std::vector<std::string>& units,
                const std::vector<ReportedValue>& values);
  /// Writes a list of texts. Blanks become underscores, because blanks separate the items of an XML list.
  void quantity_of_texts(const Texts& name, const std::string& ref_type, const std::vector<std::string>& values);
  /// Writes a value as text, for an unknown value or a unit that D-SI cannot express.
  void quantity_as_text(const Texts& name, const std::string& ref_type, std::string_view unit, double value,
                        const char* element = "dcc:quantity");

 private:
  void single_value(const std::string& unit, const ReportedValue& value);
  void list(const std::string& unit, const std::vector<ReportedValue>& values);
  void degrees_of_freedom(const std::vector<ReportedValue>& values, const char* element);

  const CalibrationReport& report_;
  Language mandatory_;
  XmlText xml_;
};

/// Writes dcc:measurementResults.
void write_measurement_results(DccText& dcc);

/// Writes the comparison with a limit as dcc:metaData. `result_id` is the id of the result; it may be empty.
void write_conformity(DccText& dcc, const Conformity& conformity, const std::string& result_id);

/// Returns the verdict as an enumerator of the DCC; an empty text if it is unknown.
[[nodiscard]] const char* dcc_verdict(Verdict verdict);

}  // namespace gyrotherm::report
