// SPDX-License-Identifier: Apache-2.0
/// Conversion of a record to matrices. Temperatures are calibrated; the bias is computed from pulse counts and exact
/// intervals, less the Earth rate. Only this file of the module depends on the record format.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "acquisition/record/run_info.hpp"
#include "core/result.hpp"

namespace gyrotherm::record {
struct Record;
struct RecordFiles;
}  // namespace gyrotherm::record

namespace gyrotherm::data {

/// Axis of a unit under test. The name of the unit or axis is empty if the record has only one.
struct AxisChoice {
  std::string unit{};
  std::string axis{};
  bool operator==(const AxisChoice&) const = default;
};
/// Returns the name of the choice in messages: "gyro", "x", "u1.x".
[[nodiscard]] std::string qualified_name(const AxisChoice& choice);
/// Returns whether the choice names an axis, or a unit other than kOnlyUnit.
[[nodiscard]] inline bool is_named(const AxisChoice& choice) {
  return !choice.axis.empty() || (!choice.unit.empty() && choice.unit != record::kOnlyUnit);
}

/// Returns whether two identities (Dataset::identity) may belong to one gyro. An empty identity is unknown and matches
/// any.
[[nodiscard]] inline bool may_be_same_gyro(std::string_view a, std::string_view b) {
  return a.empty() || b.empty() || a == b;
}

struct Dataset;
/// Fails with usage if the records belong to different gyros. In the message, `called` is the name of the record
/// `other`, and `consequence` is appended, such as "; a report covers one gyro".
[[nodiscard]] Result<void> check_same_gyro(const Dataset& one, const Dataset& other, std::string_view called,
                                           std::string_view consequence = "");

/// Bias reference of a record without a known Earth rate: a mean of the record itself. Biases of different records are
/// then not comparable.
inline constexpr std::string_view kOwnReference = "mean of the first hold removed";

/// Returns true if biases with these references have the same zero. Two records that each refer to a mean of their own
/// have different zeros, although the names of the references are equal.
[[nodiscard]] inline bool have_same_zero(std::string_view a, std::string_view b) {
  return a == b && a != kOwnReference;
}

/// Bias reference of a record from whose bias nothing was subtracted: an imported record whose map states no Earth
/// rate, or 0.
inline constexpr std::string_view kNothingRemoved = "nothing removed";

/// Fails with usage if the biases of two records have different references, because their difference would be mistaken
/// for a property of the gyro. Two records also have different references if each refers to its own mean. In the
/// message, `called` is the name of the other record.
[[nodiscard]] Result<void> check_same_reference(const Dataset& one, std::string_view other_zero,
                                                std::string_view called);

/// Matrices of one axis of a record, one row per sample. Missing readings are NaN.
struct Dataset {
  std::string run_id;
  std::string path;
  /// Unit under test and axis. The axis is empty if the unit has only one.
  AxisChoice of;
  /// Identity of the gyro as far as the record states it: its serial number. A virtual gyro also has its seed ("seed
  /// 7"), and without a serial number the name of the unit if it is one of several.
  std::string identity;
  bool simulated{};
  bool imported{};
  /// Findings of the import that concern the use of the data (failed sensors, missing values).
  std::vector<std::string> import_warnings{};
  /// Titles of the run's texts without a valid release (record::RunInfo::releases).
  std::vector<std::string> unreleased{};
  std::string profile_name;
  /// Names of the columns of temperature_c: thermometers on the unit, thermometers of the rig, then the values reported
  /// by the unit itself, "self" and "aux:NAME".
  std::vector<std::string> thermometers;
  /// Unit of each input. Empty if all are temperatures.
  std::vector<std::string> input_units;
  /// Thermometers whose differences are the multi-point gradients.
  std::vector<std::string> gradients;
  /// Cathode, anode and shell (or a substitute).
  std::vector<std::string> three_point;
  /// Set if the record names no shell and G is used instead (errata 3.3).
  bool three_point_stand_in{};
  std::vector<std::string> cycles;
  std::vector<record::RunInfo::SegmentInfo> segments;
  /// Bias reference: "earth rate removed", "mean of the first hold removed" or "nothing removed".
  std::string bias_zero;
  /// Set if a mean of this record was removed. Its mean bias is then partly fitted.
  bool has_own_reference{};
  /// Time since the start of the run. Native records have whole seconds (the slot), imported records their own time
  /// stamps.
  Eigen::VectorXd time_s;
  /// Time from the start of the run to the sampling of each row, by the clock of the run.
  Eigen::VectorXd moment_s;
  Eigen::MatrixXd temperature_c;  ///< samples × thermometers
  Eigen::VectorXd bias_deg_per_h;
  /// True bias of a virtual gyro. Empty or NaN: unknown.
  Eigen::VectorXd true_bias_deg_per_h;
  Eigen::VectorXd set_point_c;  ///< NaN if imported
  Eigen::VectorXi segment;      ///< −1 if none
  Eigen::VectorXi cycle;        ///< −1 if none
  /// Segment in which the run was stopped or aborted. Empty if the run continued afterwards, or was never stopped.
  std::optional<int> stopped_in{};
  /// Start and end of each gap in the record.
  std::vector<std::pair<double, double>> gaps_s;
  Duration started_utc{};
  /// Uncertainty of each thermometer. Empty if unknown.
  std::vector<record::ThermometerUncertainty> thermometer_uncertainty;
  record::GyroUncertainty gyro_uncertainty;
  /// Earth rate that was removed.
  std::optional<double> earth_rate_deg_per_h;
  /// Unit vector of the input axis in the fixture.
  std::optional<std::array<double, 3>> direction;
  /// Rate that one pulse per second represents. 0 if pulses are not counted.
  double step_deg_per_h{};
};

/// Returns true if a known Earth rate was subtracted from the bias.
[[nodiscard]] bool is_earth_rate_removed(const Dataset& dataset);

/// Returns the thermometers on the block: the gradient thermometers without those of the shell. The shell is the last
/// thermometer of `three_point`, and each thermometer with the same name after its last dot ("u1.x.shell" and
/// "u1.y.shell"). Without gradient thermometers, all thermometers are used; the same applies if none is left.
[[nodiscard]] std::vector<std::string> block_thermometers(const Dataset& dataset);

/// Converts a record to matrices. The bias is the measured rate minus the Earth rate. The measured rate is arcsec per
/// pulse × pulses/interval (1 arcsec/s is exactly 1 °/h) for pulse counts, and scale × value for rates. If the Earth
/// rate is unknown, the mean of the first hold is removed from native records, and nothing from imported ones; an
/// imported Earth rate of 0 is the same reference. If the unit was also turned around, no mean is removed, since the
/// sign of the Earth rate changes. The bias is missing while the profile waits for an operator to handle the unit.
/// Bias, set point and segment are missing while the run is aborting, aborted or stopped. Temperatures are the readings
/// plus the offset of their channel. If there is no list of gradient thermometers, all thermometers are used. `of` must
/// be a result of choose_axis().
[[nodiscard]] Dataset make_dataset(const record::Record& record, const std::string& path, const AxisChoice& of);

/// Returns the segment in which the run was stopped or aborted, unless the run continued afterwards.
[[nodiscard]] std::optional<int> find_stopped_segment(const record::Record& record);

/// Name of the input for the unit's own temperature, and prefix of the names of its other values.
inline constexpr std::string_view kSelf = "self", kAux = "aux:";
/// Returns whether an input is reported by the unit itself.
[[nodiscard]] bool is_own_value(std::string_view input);
/// Returns whether an input is a temperature, of a thermometer or of the unit itself.
[[nodiscard]] bool is_temperature(std::string_view input);

/// Lists all axes of a run in order.
[[nodiscard]] std::vector<AxisChoice> list_axes(const record::RunInfo& info);
/// Finds the requested axis. An empty name matches the only axis or unit. If no axis or more than one matches, fails
/// with usage and lists the axes. `path` names the record in the message.
[[nodiscard]] Result<AxisChoice> choose_axis(const record::RunInfo& info, const AxisChoice& requested,
                                             const std::string& path);

/// Reads a record and converts one of its axes. Fails as read_record and choose_axis do, and with usage if the run is
/// not finished, because an unfinished run must not be mistaken for a finished one.
[[nodiscard]] Result<Dataset> load_dataset(const record::RecordFiles& files, const AxisChoice& requested = {});
[[nodiscard]] Result<Dataset> load_dataset(const std::string& path, const AxisChoice& requested = {});

/// Returns whether the unit is turned around while the Earth rate is unknown. The bias then differs by twice the Earth
/// rate between the two positions.
[[nodiscard]] bool jumps_by_turning(const Dataset& dataset);

/// Lists the profile name of each dataset.
[[nodiscard]] std::vector<std::string> list_programs(const std::vector<Dataset>& datasets);

/// Returns the time between neighbouring samples: 1 s, or the median step of an imported record.
[[nodiscard]] double sample_interval_s(const Dataset& dataset);

}  // namespace gyrotherm::data
