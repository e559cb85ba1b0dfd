// SPDX-License-Identifier: Apache-2.0
/// Summary of a lot, the gyros tested together in one chamber: one table with all axes of all units, and the outliers.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/result.hpp"
#include "report/report.hpp"

namespace gyrotherm::report {

inline constexpr const char* kLotSchema = "gyrotherm-lot/1";

/// One axis of the lot.
struct LotAxis {
  std::string unit, axis;  ///< axis is empty if unnamed
  std::string serial_number, model;
  /// Folder of the models and the report, relative to the folder of the lot.
  std::string folder;
  /// "PASS", "FAIL", "no limit", or "failed" if training failed.
  std::string verdict;
  /// Reason for a training failure, or empty.
  std::string trouble;
  /// Standard deviation and RMSE of the bias in the random run, which was not used in training: uncompensated (raw),
  /// and compensated by multi-point with temperature. Unknown if training failed.
  double raw_std_deg_per_h = kNotKnown, compensated_std_deg_per_h = kNotKnown, compensated_rmse_deg_per_h = kNotKnown;
  double floor_deg_per_h = kNotKnown;     ///< noise floor
  double expanded_deg_per_h = kNotKnown;  ///< U of a 1 h mean
  double missing_s{};                     ///< time without a reading, both runs
  /// Distance of the uncompensated and the compensated standard deviation from the lot's median, in robust standard
  /// deviations.
  double raw_score = kNotKnown, compensated_score = kNotKnown;
  /// True if one of the scores exceeds ±kOutlierScore.
  bool is_outlier{};
};

/// Modified z-score above which a value is an outlier: Iglewicz and Hoaglin, "How to Detect and Handle Outliers" (ASQC
/// 1993).
inline constexpr double kOutlierScore = 3.5;

struct Lot {
  std::string rig_name, rig_title;
  bool simulated{};
  std::string program_version;
  std::uint64_t seed{};
  bool quick{};
  std::vector<LotAxis> axes;
  /// Messages about units that fell silent, were dropped or returned.
  std::vector<std::string> events;
  /// The number of the order; may be empty.
  std::string order_number{};
};

/// Copies the verdict and the values of an axis from its report.
void copy_results(const Report& report, LotAxis& axis);

/// Returns the modified z-score of each value relative to the known values: 0.6745 (x − median)/MAD, computed from the
/// logarithms. Returns NaN for all values if fewer than six are known, or if the MAD is 0.
[[nodiscard]] std::vector<double> robust_scores(const std::vector<double>& values);

/// Computes the scores of all axes and marks the outliers.
void compare(Lot& lot);

/// Returns "PASS", "FAIL" or "no limit" for the lot. An axis whose training failed counts as a failure.
[[nodiscard]] std::string overall_verdict(const Lot& lot);

/// Returns lot.json, ending in a newline.
[[nodiscard]] std::string to_json(const Lot& lot);
/// Returns the table as text for a terminal.
[[nodiscard]] std::string describe(const Lot& lot);
/// Returns the summary as a page with a table, a figure and a link to the report of each unit.
[[nodiscard]] std::string to_html(const Lot& lot);

/// Returns one report for a unit with several axes: a table of the axes, then the report of each axis.
[[nodiscard]] std::string unit_to_html(const Lot& lot, const std::string& unit,
                                       const std::vector<std::pair<std::string, Report>>& axes);

}  // namespace gyrotherm::report
