// SPDX-License-Identifier: Apache-2.0
/// Comparison of two calibrations of one unit: the drift between them, and whether the drift exceeds their combined
/// uncertainty.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "report/calibration.hpp"
#include "report/document.hpp"
#include "report/report_files.hpp"
#include "report/standard/check_view.hpp"

namespace gyrotherm::report {

inline constexpr const char* kComparisonSchema = "gyrotherm-comparison/1";

/// One quantity that both reports contain.
struct ComparedResult {
  std::string key{}, quantity{}, unit{};
  /// Addition to the key, such as the gradient "A-D"; may be empty.
  std::string detail{};
  std::string axis{};
  /// Profile of both records; "random, 2" is the second record of that profile in each report.
  std::string profile{};
  /// Records of the pair, "R1", as their reports name them; empty for a result of all records and in a report of one.
  std::string before_record{}, now_record{};
  /// Days between the starts of both records; those between the reports if a start is unknown.
  double days_between = std::numeric_limits<double>::quiet_NaN();
  /// Stages of the compared results: the same stage twice, or as_left before and as_found now.
  Stage before_at{}, now_at{};
  /// Condition of the row: "set_point 20, 2" is the second row at that set point; empty for a single row.
  std::string condition{};
  ReportedValue before{}, now{};
  double change{};                                             ///< now − before
  double expanded = std::numeric_limits<double>::quiet_NaN();  ///< U of the change, 95 %
  /// (now − before)/√(U_now² + U_before²). The results disagree outside ±1 (ISO 13528, 9.7). Errors common to both
  /// calibrations, such as those of the laboratory's thermometers and mount, make U too large and E_n too small by
  /// their share of the budgets.
  double normalised_error = std::numeric_limits<double>::quiet_NaN();
  /// Change extrapolated to a year; NaN if the days between are unknown.
  double in_a_year = std::numeric_limits<double>::quiet_NaN();
};

/// State of the check standard of the rig at the time of one record (docs/check-standard.md).
struct CheckedRecord {
  bool is_before{};  ///< record of the earlier report
  std::string name{}, started_utc{};
  std::string state{};  ///< "in_control", "explained", "out_of_control" or "unknown"
  /// Start of the last check run before the record and of the first one after it; empty if there is none.
  std::string checked_before{}, checked_after{};
};

struct Comparison {
  std::string before_number{}, now_number{};
  ReportState before_state = ReportState::authorised, now_state = ReportState::authorised;
  std::string before_sha256{}, now_sha256{};  ///< hashes of calibration.json
  std::string model{}, serial_number{};
  std::string laboratory{};  ///< laboratory of the later report
  /// Days between the first days of both calibrations.
  double days_between = std::numeric_limits<double>::quiet_NaN();
  bool simulated{};
  /// True if each as-found model of this calibration is an as-left model of the previous one.
  bool same_model{};
  std::vector<ComparedResult> results{};
  /// History of check runs, and the state at each record of both reports; empty without a history.
  std::optional<standard::CheckedStandard> standard{};
  std::vector<CheckedRecord> checked{};
};

/// Compares the results that both reports have for the same profile, row by row: the first record of one report with
/// the first of the other, and so on. It compares uncompensated results with each other, and results as left with the
/// later ones as found; the second comparison gives the drift of the compensated unit. Results of a model on its own
/// training record are skipped, and so are values without a U above 0. A record without a counterpart at its position
/// is then compared with the next free record of the profile. Records that both reports have are compared only if there
/// is nothing else to compare. Fails with usage if the reports are not of one unit (serial number and model), if `now`
/// began before `before`, or if they have no result in common.
[[nodiscard]] Result<Comparison> compare(const CalibrationReport& before, const CalibrationReport& now);

/// Adds the state of the check standard at the time of each record of both reports. Fails with usage if the history is
/// of another rig than the records, if it is of a virtual rig and they are not or the reverse, or if it has no check
/// run.
[[nodiscard]] Result<void> add_check_standard(Comparison& comparison, const CalibrationReport& before,
                                              const CalibrationReport& now, standard::CheckedStandard standard);

/// Compares two filed reports, and adds the check standard of the file `history` unless it is empty. Fails as
/// compare(), the reader of histories and add_check_standard() do.
[[nodiscard]] Result<Comparison> compare_files(const FiledReport& before, const FiledReport& now,
                                               const std::string& history);

/// Returns whether a record was made while the check standard was out of control and not explained.
[[nodiscard]] bool is_check_open(const Comparison& comparison);

/// Returns the change with its expanded uncertainty.
[[nodiscard]] ReportedValue change_with_uncertainty(const ComparedResult& result);
/// Returns the results sorted by |E_n|, greatest first and unknown ones last.
[[nodiscard]] std::vector<const ComparedResult*> sort_by_normalised_error(const Comparison& comparison);
/// Counts the results with |E_n| > 1.
[[nodiscard]] std::size_t count_disagreements(const Comparison& comparison);

/// Returns comparison.json, ending in a newline.
[[nodiscard]] std::string to_json(const Comparison& comparison);
/// Returns the comparison as a table for a terminal, greatest |E_n| first.
[[nodiscard]] std::string describe(const Comparison& comparison);

/// Returns the comparison as a document: first the number of results that changed by more than the uncertainty of both
/// calibrations, then all results, greatest |E_n| first.
[[nodiscard]] Document make_document(const Comparison& comparison, Language language);

}  // namespace gyrotherm::report
