// SPDX-License-Identifier: Apache-2.0
/// The axes of one record, each compensated by its own model, as fusion takes them: where they point, what they read in
/// each second, and how uncertain that is, each by itself and together with the others.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "analysis/data/dataset.hpp"
#include "analysis/fusion/geometry.hpp"
#include "analysis/fusion/rest.hpp"
#include "analysis/model/model.hpp"
#include "core/result.hpp"

namespace gyrotherm::model {

/// Some of the axes: a bit for each, the first the lowest.
using AxisSet = std::uint64_t;

/// One axis of a record, and the model that compensates it.
struct CompensatedAxis {
  data::Dataset dataset;
  Model model;
};

/// Axes of one record, second by second. Rows are seconds, or thermometers of all axes together.
struct FusedAxes {
  bool simulated{};
  std::string run_id{}, profile_name{};
  std::vector<record::RunInfo::SegmentInfo> segments{};
  Eigen::VectorXd time_s{};  ///< since the run started
  Eigen::VectorXi segment{};
  std::vector<std::string> names{};  ///< "gyro", "u1.x"
  Eigen::MatrixX3d directions{};     ///< a row per axis, in the fixture
  /// Seconds × axes: the whole rate, the Earth's in it, less what each axis's model predicts from the trailing means of
  /// its thermometers; NaN where that is not known, and while people had the unit or it was turned around.
  Eigen::MatrixXd rate_deg_per_h{};
  std::vector<std::string> thermometers{};
  Eigen::MatrixXd temperature_c{};                ///< seconds × thermometers
  std::vector<double> thermometer_in_a_year_k{};  ///< how well each is known in a year of use
  /// Axes × thermometers: mean slope of each model over the record.
  Eigen::MatrixXd sensitivity_deg_per_h_per_k{};
  std::vector<Model> models{};           ///< of each axis; each has its uncertainty
  std::vector<double> step_deg_per_h{};  ///< of each axis: one pulse in a second
  /// Covariance, (°/h)², of what thermometers do to the axes between training and this run.
  Eigen::MatrixXd by_thermometer_drift{};
  Eigen::MatrixXd learnt{};  ///< … of what training and use have in common: certificates, angles, scale factors
  std::optional<fusion::Attitude> attitude{};  ///< where the record knows latitude and azimuths
  /// The axes with an input beyond the trained range, per second.
  std::vector<AxisSet> outside{};
  /// Seconds × axes: the variance, (°/h)², that is added to an axis outside, widening() of its model's form; 0 inside.
  Eigen::MatrixXd widening{};
  std::vector<std::string> warnings{};  ///< a model of another gyro
  [[nodiscard]] Eigen::Index axes() const { return directions.rows(); }
};

/// Compensates the axes as CompensationStream does, causally and with the seconds that are missing, and asks their
/// models for how uncertain that is. What a thermometer that axes share does to them together is the mean over the
/// record of the products of their slopes: signed, so that what two axes have in common is neither lost nor taken
/// twice. The attitude is the rotation that turns the directions into the azimuths and elevations that the record says
/// (Wahba's problem by a singular value decomposition; Markley, J. Astronaut. Sci. 36 (1988) 245).
///
/// Fails with usage if there are more than 64 axes, samples are not one a second, an axis has no direction, a model no
/// uncertainty or is of another axis of the unit, or the Earth's rate on an axis is not known; if directions and angles
/// of a record do not fit each other; and as CompensationStream and make_clusters do. It does not ask for three axes:
/// geometry_of() does.
[[nodiscard]] Result<FusedAxes> fused_axes(const std::vector<CompensatedAxis>& axes,
                                           Outside outside = Outside::continued);

/// What makes a mean over some time uncertain, (°/h)².
struct FusedUncertainty {
  /// Variances of what is new in each mean and of no other axis: angle random walk, steps of the pulse counter
  /// (white where they are not; a mean of τ seconds has 1/√6 of a pulse over τ of them), noise of the thermometers.
  Eigen::VectorXd noise;
  Eigen::MatrixXd bias;    ///< covariance of what is slow, or another in each run: model, turn-on, thermometers' drift
  Eigen::MatrixXd learnt;  ///< covariance of what training and use have in common, which no comparison of axes shows
  [[nodiscard]] Eigen::MatrixXd differing() const { return Eigen::MatrixXd(noise.asDiagonal()) + bias; }
};
[[nodiscard]] FusedUncertainty uncertainty_of_means(const FusedAxes& axes, double averaging_s);

/// The axes in a set, rising.
[[nodiscard]] std::vector<Eigen::Index> members(AxisSet set);
[[nodiscard]] std::string names_in(const FusedAxes& axes, AxisSet set);

/// The geometry of some of the axes with this covariance of all of them. Fails as geometry_of() does.
[[nodiscard]] Result<fusion::Geometry> geometry_of_set(const FusedAxes& axes, AxisSet set,
                                                       const Eigen::MatrixXd& covariance);

/// The Earth's rotation in the axes of the fixture, °/h, at that attitude.
[[nodiscard]] Eigen::Vector3d earth_in_fixture(const fusion::Attitude& attitude);

}  // namespace gyrotherm::model
