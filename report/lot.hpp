// SPDX-License-Identifier: Apache-2.0
/// What a chamber full of gyros came to: every axis of every unit in one table, and which of them stand out.
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
  std::string unit, axis;  ///< the axis is empty where the unit has one
  std::string serial_number, model;
  std::string folder;   ///< of its models and its report, relative to the lot's
  std::string verdict;  ///< "PASS", "FAIL", "no limit", or "failed" where it could not be trained
  std::string trouble;  ///< why it could not be; else empty
  /// Of the random run, which no model has seen: before, and what multi-point with temperature leaves; standard
  /// deviation and root mean square. Not known where it could not be trained.
  double raw_std_deg_per_h = kNotKnown, compensated_std_deg_per_h = kNotKnown, compensated_rmse_deg_per_h = kNotKnown;
  double floor_deg_per_h = kNotKnown;     ///< its noise
  double expanded_deg_per_h = kNotKnown;  ///< U of a mean over 1 h, by the model's budget
  double missing_s{};                     ///< seconds of both runs in which it was not read
  /// How far its raw and its compensated standard deviation lie from the lot's middle, in robust standard deviations.
  double raw_score = kNotKnown, compensated_score = kNotKnown;
  bool stands_out{};  ///< one of the scores is beyond kStandsOut, either way
};

/// Iglewicz and Hoaglin, "How to Detect and Handle Outliers" (ASQC 1993): a modified z-score beyond this.
inline constexpr double kStandsOut = 3.5;

struct Lot {
  std::string rig_name, rig_title;
  bool simulated{};
  std::string program_version;
  std::uint64_t seed{};
  bool quick{};
  std::vector<LotAxis> axes;
  std::vector<std::string> events;  ///< of units that fell silent, were dropped or returned, in words
};

/// Of what an axis' report says.
void take_figures(const Report& report, LotAxis& axis);

/// The modified z-score of each value among those that are known: 0.6745 (x − median) / MAD of the logarithms; NaN
/// where there are fewer than six, or where half of them are the same.
[[nodiscard]] std::vector<double> robust_scores(const std::vector<double>& values);

/// Gives each axis its scores among the others.
void compare(Lot& lot);

/// "PASS", "FAIL" or "no limit" of all; an axis that could not be trained fails.
[[nodiscard]] std::string verdict_of(const Lot& lot);

/// As lot.json has it, ending in a newline.
[[nodiscard]] std::string to_json(const Lot& lot);
/// The table, as text for a terminal.
[[nodiscard]] std::string describe(const Lot& lot);
/// The summary as a page: table, figure, and a link to each unit's report.
[[nodiscard]] std::string html_of(const Lot& lot);

/// One report of a unit with several axes: the table of them, then all that each axis' own report says.
[[nodiscard]] std::string html_of_unit(const Lot& lot, const std::string& unit,
                                       const std::vector<std::pair<std::string, Report>>& axes);

}  // namespace gyrotherm::report
