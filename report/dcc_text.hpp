// SPDX-License-Identifier: Apache-2.0
/// The parts of a Digital Calibration Certificate: what dcc.cpp and dcc_results.cpp share. Each function writes one
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

/// The words of a key in both languages; with `of`, which stands in them for {}.
[[nodiscard]] Texts words(std::string_view key);
[[nodiscard]] Texts words(std::string_view key, std::string_view of);
/// The words of a key of the report's own, which a newer report may have and this program not know: then the key.
[[nodiscard]] Texts words_if_any(std::string_view key);
/// What is the same in both.
[[nodiscard]] Texts in_no_language(std::string_view text);
/// Both, one after the other.
[[nodiscard]] Texts joined(const Texts& first, std::string_view between, const Texts& second);

/// The language in which every text of people is, English before German; English if none is.
[[nodiscard]] Language mandatory_language(const CalibrationReport& report);

/// A text that must not be empty: as it is, or "not given".
[[nodiscard]] std::string given(std::string_view text);

/// "2026-11-25" if it is a day, else nothing.
[[nodiscard]] std::optional<std::string> calendar_day(std::string_view text);

/// Writes the parts of one certificate.
class DccText {
 public:
  explicit DccText(const CalibrationReport& report) : report_(report), mandatory_(mandatory_language(report)) {}

  [[nodiscard]] const CalibrationReport& report() const { return report_; }
  [[nodiscard]] Language mandatory() const { return mandatory_; }
  [[nodiscard]] XmlText& xml() { return xml_; }

  /// A text in both languages; where people wrote but the other than the mandatory one, it stands for that too, and
  /// says so.
  void text(const char* name, const Texts& texts, const XmlText::Attributes& attributes = {});
  /// The text of a name, which is in no language.
  void proper_name(const char* name, std::string_view proper);
  /// dcc:identification. A name of {} is left out.
  void identification(const char* issuer, std::string_view value, const Texts& name,
                      const XmlText::Attributes& attributes = {});
  /// A quantity of one value, or of a list of them.
  void quantity(const Texts& name, const std::string& ref_type, std::string_view unit,
                const std::vector<ReportedValue>& values, const char* element = "dcc:quantity");
  /// A quantity of which each value has a unit of its own, which D-SI must know.
  void quantity(const Texts& name, const std::string& ref_type, const std::vector<std::string>& units,
                const std::vector<ReportedValue>& values);
  /// A quantity of words; blanks in them become underscores, for in a list of XML they part one from the next.
  void quantity_of_words(const Texts& name, const std::string& ref_type, const std::vector<std::string>& values);
  /// A value with a unit that D-SI does not know, as text.
  void quantity_as_text(const Texts& name, const std::string& ref_type, std::string_view unit, double value,
                        const char* element = "dcc:quantity");

 private:
  void single(const std::string& unit, const ReportedValue& value);
  void list(const std::string& unit, const std::vector<ReportedValue>& values);
  void degrees_of_freedom(const std::vector<ReportedValue>& values, const char* element);

  const CalibrationReport& report_;
  Language mandatory_;
  XmlText xml_;
};

/// dcc:measurementResults.
void write_measurement_results(DccText& dcc);

/// dcc:metaData or dcc:statement of a limit; `result_id` may be empty.
void write_conformity(DccText& dcc, const Conformity& conformity, const std::string& result_id);

/// The DCC's word of a verdict; nothing of one that is not known.
[[nodiscard]] const char* dcc_verdict(Verdict verdict);

}  // namespace gyrotherm::report
