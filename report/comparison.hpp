// SPDX-License-Identifier: Apache-2.0
/// Two calibrations of one unit: by how much it has drifted, and whether that is more than both are uncertain.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"
#include "report/calibration.hpp"
#include "report/document.hpp"

namespace gyrotherm::report {

inline constexpr const char* kComparisonSchema = "gyrotherm-comparison/1";

/// Quantities that depend on the zero of the bias. The store of a site has the same list (apps/site/migrations).
inline constexpr std::array<std::string_view, 5> kCountedFromAZero{"bias", "mean", "rmse", "largest",
                                                                   "compensated_bias"};

/// One quantity in both reports.
struct ComparedResult {
  std::string key{}, quantity{}, unit{};  ///< as in the reports
  std::string axis{};
  std::string profile{};        ///< of both records; "random, 2": each report's second of that profile
  Stage before_at{}, now_at{};  ///< as left and as found, where it is the same model
  std::string condition{};      ///< which row: "set_point 20, 2": the second of that set point; empty of a single one
  ReportedValue before{}, now{};
  double change{};                                             ///< now less before
  double expanded = std::numeric_limits<double>::quiet_NaN();  ///< U of the change, 95 %, √(U² + U²)
  /// (now − before)/√(U_now² + U_before²): beyond ±1 the two do not agree (ISO 13528, 9.7). What both have in common
  /// (one laboratory's thermometers and mount) makes U too large, and E_n too small, by what the budgets say of it.
  double normalised_error = std::numeric_limits<double>::quiet_NaN();
  double in_a_year = std::numeric_limits<double>::quiet_NaN();  ///< change over the time between, per year
};

struct Comparison {
  std::string before_number{}, now_number{};
  std::string before_sha256{}, now_sha256{};  ///< of the files
  std::string model{}, serial_number{};
  std::string laboratory{};                                        ///< of the report of now
  double days_between = std::numeric_limits<double>::quiet_NaN();  ///< between the beginnings of the runs
  bool simulated{};
  bool same_model{};  ///< the unit came with the model that it had left with
  std::vector<ComparedResult> results{};
};

/// Compares row by row what both have in records of the same profile, the first with the first, the second with the
/// second: uncompensated with uncompensated, and as left with as found, which is the drift of the compensated unit;
/// nothing that a model says of a record that it was fitted to. Fails with usage if they are not of one unit (serial
/// number and model) or have no result in common.
[[nodiscard]] Result<Comparison> compare(const CalibrationReport& before, const CalibrationReport& now);

/// The change with its U.
[[nodiscard]] ReportedValue change_of(const ComparedResult& result);
/// The results, greatest |E_n| first.
[[nodiscard]] std::vector<const ComparedResult*> by_weight(const Comparison& comparison);
/// How many have changed by more than both are uncertain: |E_n| > 1.
[[nodiscard]] std::size_t count_beyond(const Comparison& comparison);

/// As comparison.json has it, ending in a newline.
[[nodiscard]] std::string to_json(const Comparison& comparison);
/// The table, as text for a terminal, greatest E_n first.
[[nodiscard]] std::string describe(const Comparison& comparison);

/// Returns the comparison as a text for people: first how many results have changed by more than the uncertainty of
/// both calibrations, then all results, greatest |E_n| first.
[[nodiscard]] Document document_of(const Comparison& comparison, Language language);

}  // namespace gyrotherm::report
