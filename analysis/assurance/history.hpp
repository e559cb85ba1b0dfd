// SPDX-License-Identifier: Apache-2.0
/// History of the check runs of a rig: a file of JSON lines to which results and explanations are only appended. Each
/// line contains the SHA-256 of the previous one. The charts and their verdicts are computed from the history.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/assurance/check_run.hpp"
#include "analysis/assurance/control_chart.hpp"
#include "core/form.hpp"
#include "core/result.hpp"

namespace gyrotherm::assurance {

inline constexpr const char* kHistorySchema = "gyrotherm-check-standard/1";

/// What all check runs of a history have in common.
struct HistoryHead {
  std::string rig{};
  bool simulated{};
  std::vector<std::string> serial_numbers{};
  std::string profile{};
  std::string profile_sha256{};
  /// False alarms per check run, all charts together.
  double false_alarm_rate{};
  /// Plausible changes, for the diagnosis: standard deviations. 0: from the turn-on repeatability of the record.
  double mount_change_deg{};
  double gyro_change_deg_per_h{};
  bool operator==(const HistoryHead&) const = default;
};

/// Golden axis: its Earth rate and direction, which determine the effect of a tilt of the mount.
struct CheckedAxis {
  std::string axis{};
  double earth_rate_deg_per_h{};
  /// Unit vector of the axis in the fixture; empty if it is not in a fixture.
  std::vector<double> direction{};
  double turn_on_deg_per_h{};  ///< stated turn-on repeatability; 0: unknown
};

struct CheckedThermometer {
  std::string name{};
  double u_k{};               ///< standard uncertainty of the certificate with the drift of a year; 0: unknown
  double drift_k_per_year{};  ///< standard uncertainty of the drift after one year; 0: unknown
};

struct CheckEntry {
  std::string run_id{};
  std::string started_utc{};  ///< "2026-11-25T14:03:07Z"
  std::string record{};
  std::string sha256{};  ///< digest of the record
  std::string program_version{};
  std::vector<CheckedAxis> axes{};
  std::vector<CheckedThermometer> thermometers{};
  std::vector<CheckResult> results{};
};

struct Explanation {
  std::vector<std::string> run_ids{};
  std::string cause{};  ///< one of kCauses
  /// Part concerned, such as the name of a thermometer. May be empty.
  std::string part{};
  std::string by{};
  std::string utc{};
  std::string note{};
  /// The cause was removed or accepted: later runs have a level of their own.
  bool new_level{};
};
inline constexpr std::array<std::string_view, 5> kCauses{"thermometer", "mount", "gyro", "false_alarm", "other"};

struct History {
  HistoryHead head;
  std::vector<CheckEntry> checks;
  std::vector<Explanation> explanations;
};

/// Parses a history. Fails with bad_file, with the line, on syntax errors, another schema, a line that does not follow
/// from the previous one, or an incomplete last line.
[[nodiscard]] Result<History> parse_history(std::string_view text, const std::string& file);

/// Return the text of a new history, and the text with one more line.
[[nodiscard]] std::string start_history(const HistoryHead& head);
[[nodiscard]] std::string append(std::string text, const CheckEntry& check);
[[nodiscard]] std::string append(std::string text, const Explanation& explanation);

/// One result over all runs.
struct Chart {
  CheckResult of{};  ///< the result of the first run that has it
  ChartScale scale{};
  std::vector<ChartPoint> points{};  ///< one for each check run of the history
};

/// Verdict over one check run.
struct RunVerdict {
  std::vector<std::size_t> charts{};  ///< indices of the charts that are out of control
  /// Index of the explanation that covers the run, if any.
  std::optional<std::size_t> explanation{};
  [[nodiscard]] bool is_out() const { return !charts.empty(); }
  [[nodiscard]] bool is_open() const { return is_out() && !explanation; }
};

/// Limits of the two families of charts. Each family has half of the false-alarm rate, so that the many thermometers do
/// not widen the limits of the gyro.
struct HistoryLimits {
  ChartLimits gyro{};  ///< bias, temperature coefficient, scatter and Earth rate
  ChartLimits thermometers{};
};
[[nodiscard]] const ChartLimits& limits_of(const HistoryLimits& limits, CheckKind kind);
/// Computes the limits for the results of a history.
[[nodiscard]] HistoryLimits find_limits(const History& history);

struct Assessment {
  HistoryLimits limits{};
  std::vector<Chart> charts{};
  std::vector<RunVerdict> runs{};
  [[nodiscard]] bool is_open() const;
};

/// Computes all charts of a history. The results of the first check run determine the charts.
[[nodiscard]] Assessment assess(const History& history);
/// Computes the charts with known limits, for many histories of the same size.
[[nodiscard]] Assessment assess(const History& history, const HistoryLimits& limits);

void describe(auto& form, Like<HistoryHead> auto& head) {
  form("rig", head.rig);
  form("simulated", head.simulated);
  form("serial_numbers", head.serial_numbers);
  form("profile", head.profile);
  form("profile_sha256", head.profile_sha256);
  form("false_alarm_rate", positive(head.false_alarm_rate, 0.2));
  form("mount_change_deg", positive(head.mount_change_deg));
  form("gyro_change_deg_per_h", not_negative(head.gyro_change_deg_per_h));
}

void describe(auto& form, Like<CheckedAxis> auto& axis) {
  form("axis", axis.axis);
  form("earth_rate_deg_per_h", axis.earth_rate_deg_per_h);
  form("direction", axis.direction);
  form("turn_on_deg_per_h", not_negative(axis.turn_on_deg_per_h));
  form.expect("direction", axis.direction.empty() || axis.direction.size() == 3, "expected three numbers or none");
}

void describe(auto& form, Like<CheckedThermometer> auto& thermometer) {
  form("name", thermometer.name);
  form("u_k", not_negative(thermometer.u_k));
  form("drift_k_per_year", not_negative(thermometer.drift_k_per_year));
}

void describe(auto& form, Like<CheckEntry> auto& check) {
  form("run_id", check.run_id);
  form("started_utc", check.started_utc);
  form("record", check.record);
  form("sha256", check.sha256);
  form("program_version", check.program_version);
  form("axes", check.axes);
  form("thermometers", check.thermometers);
  form("results", check.results);
}

void describe(auto& form, Like<Explanation> auto& explanation) {
  form("run_ids", explanation.run_ids);
  form("cause", explanation.cause);
  form("part", explanation.part);
  form("by", explanation.by);
  form("utc", explanation.utc);
  form("note", explanation.note);
  form("new_level", explanation.new_level);
}

}  // namespace gyrotherm::assurance
