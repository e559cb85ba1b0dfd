// SPDX-License-Identifier: Apache-2.0
/// From a record to matrices: temperatures calibrated, bias from counts with the exact interval and Earth rate removed.
/// The only file of this room that knows records.
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

/// Which axis of which unit under test; empty where a record has no choice.
struct AxisChoice {
  std::string unit{};
  std::string axis{};
  bool operator==(const AxisChoice&) const = default;
};
/// "gyro", "x", "u1.x".
[[nodiscard]] std::string in_words(const AxisChoice& choice);
/// Whether it is one of several, and not the only axis of the only unit.
[[nodiscard]] inline bool is_named(const AxisChoice& choice) {
  return !choice.axis.empty() || (!choice.unit.empty() && choice.unit != record::kOnlyUnit);
}

/// Whether two identities (Dataset::identity) may be of one gyro: an empty one says nothing.
[[nodiscard]] inline bool may_be_one_gyro(std::string_view a, std::string_view b) {
  return a.empty() || b.empty() || a == b;
}

struct Dataset;
/// Fails with usage where two records say that they are of different gyros: the one "is of another gyro (…) than", as
/// the other is `called`, "(…)" and `so`.
[[nodiscard]] Result<void> check_one_gyro(const Dataset& one, const Dataset& other, std::string_view called,
                                          std::string_view so = "");

/// The zero of a record that knows no better: a mean of its own, which no other record counts from.
inline constexpr std::string_view kOwnZero = "mean of the first hold removed";

/// Fails with usage where the biases of two records are counted from different zeros, which tells them apart by what is
/// no gyro's: the one "counts its bias from another zero (…) than", as the other is `called`, "(…)". The zeros
/// of two records are different too if each is a mean of its own record.
[[nodiscard]] Result<void> check_one_zero(const Dataset& one, std::string_view other_zero, std::string_view called);

/// One axis of a record as matrices, one row per sample; NaN where a reading was missing.
struct Dataset {
  std::string run_id;
  std::string path;
  AxisChoice of;         ///< its unit under test and axis; the axis is empty where the unit has one
  std::string identity;  ///< which gyro that is, as far as the record says: its serial number; of a virtual one the
                         ///< seed too, which draws it ("seed 7"), and the unit's name if it is one of several
  bool simulated{};
  bool imported{};
  std::string profile_name;
  std::vector<std::string> thermometers;  ///< names of the columns of temperature_c: the thermometers on the unit and
                                          ///< the rig's, then "self" and "aux:NAME", what the unit tells of itself
  std::vector<std::string> input_units;   ///< one each; empty: all are temperatures
  std::vector<std::string> gradients;     ///< those whose differences are the multi-point gradients
  std::vector<std::string> three_point;   ///< cathode, anode, shell (or a stand-in)
  bool three_point_stand_in{};            ///< the record names no shell; G stands in (errata 3.3)
  std::vector<std::string> cycles;
  std::vector<record::RunInfo::SegmentInfo> segments;
  std::string bias_zero;          ///< "earth rate removed", "mean of the first hold removed" or "nothing removed"
  bool zero_is_its_own{};         ///< what was removed is a mean of this record: its mean is then partly fitted
  Eigen::VectorXd time_s;         ///< since the run started: whole seconds (the slot) of our own records, else the
                                  ///< foreign record's own time
  Eigen::VectorXd moment_s;       ///< since the run started, by its clock: when each row was sampled
  Eigen::MatrixXd temperature_c;  ///< samples × thermometers
  Eigen::VectorXd bias_deg_per_h;
  Eigen::VectorXd true_bias_deg_per_h;            ///< of a virtual gyro, from its laboratory; empty or NaN: not known
  Eigen::VectorXd set_point_c;                    ///< NaN if imported
  Eigen::VectorXi segment;                        ///< −1 if none
  Eigen::VectorXi cycle;                          ///< −1 if none
  std::vector<std::pair<double, double>> gaps_s;  ///< start, end of each gap in the record
  Duration started_utc{};
  std::vector<record::ThermometerUncertainty> thermometer_uncertainty;  ///< of each; empty: nothing is said
  record::GyroUncertainty gyro_uncertainty;
  std::optional<double> earth_rate_deg_per_h;      ///< as removed
  std::optional<std::array<double, 3>> direction;  ///< of the input axis in the fixture; of length 1
  double step_deg_per_h{};                         ///< what one pulse in a second is; 0 where none is counted
};

/// Makes matrices of a record. The bias is arcsec per pulse × pulses / interval (1 arcsec/s is 1 °/h exactly) where
/// pulses were counted, scale × number where a rate was read, less the Earth rate. Where that is not known, the mean of
/// the first hold is removed from our own records and nothing from imported ones, nor where the unit was turned around:
/// there the Earth's rate has the other sign. There is no bias while the profile waited for people: they handle the
/// unit. Temperatures are the readings plus their channel's offset. Without a list of gradient thermometers, all are
/// taken. `of` is one that choose_axis() found.
[[nodiscard]] Dataset make_dataset(const record::Record& record, const std::string& path, const AxisChoice& of);

/// The input that is the unit's own temperature, and what the names of its other own values begin with.
inline constexpr std::string_view kSelf = "self", kAux = "aux:";
/// Whether an input is what the unit tells of itself.
[[nodiscard]] bool is_own_value(std::string_view input);
/// Whether an input is a thermometer's or the unit's own temperature, and not another of its values.
[[nodiscard]] bool is_temperature(std::string_view input);

/// All axes of a run, in order.
[[nodiscard]] std::vector<AxisChoice> axes_of(const record::RunInfo& info);
/// The one that is wanted: an empty name is that of the only one. Fails with usage, telling what there is; `path` names
/// the record.
[[nodiscard]] Result<AxisChoice> choose_axis(const record::RunInfo& info, const AxisChoice& wanted,
                                             const std::string& path);

/// Reads a record and makes matrices of one of its axes. Fails like read_record and choose_axis, and with usage if the
/// run has not finished (an unfinished run is never mistaken for a finished one).
[[nodiscard]] Result<Dataset> load_dataset(const record::RecordFiles& files, const AxisChoice& wanted = {});
[[nodiscard]] Result<Dataset> load_dataset(const std::string& path, const AxisChoice& wanted = {});

/// Whether the unit is turned around and the Earth's rate is not known: twice that lies between its two positions.
[[nodiscard]] bool jumps_by_turning(const Dataset& dataset);

/// The profile of each.
[[nodiscard]] std::vector<std::string> programs_of(const std::vector<Dataset>& datasets);

/// The time between neighbouring samples: 1 s, or the median step of an imported record.
[[nodiscard]] double sample_interval_s(const Dataset& dataset);

}  // namespace gyrotherm::data
