// SPDX-License-Identifier: Apache-2.0
/// The axes of one record as input of the fusion, each compensated by its own model: directions, readings in each
/// second, and their uncertainties and covariances.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "analysis/data/dataset.hpp"
#include "analysis/fusion/geometry.hpp"
#include "analysis/fusion/rate_fusion.hpp"
#include "analysis/fusion/rest.hpp"
#include "analysis/model/model.hpp"
#include "core/result.hpp"

namespace gyrotherm::model {

/// A set of axes: one bit per axis, the lowest for the first.
using AxisSet = std::uint64_t;

/// One axis of a record, and the model that compensates it.
struct CompensatedAxis {
  data::Dataset dataset;
  Model model;
};

/// The compensated axes of one record, one row per second. `thermometers` lists the thermometers of all axes.
struct FusedAxes {
  bool simulated{};
  std::string run_id{}, profile_name{};
  std::vector<record::RunInfo::SegmentInfo> segments{};
  Eigen::VectorXd time_s{};  ///< since the run's start
  Eigen::VectorXi segment{};
  std::vector<std::string> names{};  ///< "gyro", "u1.x"
  Eigen::MatrixX3d directions{};     ///< one row per axis
  /// Seconds × axes: the measured rate, including the Earth rate, minus the prediction of the axis's model from the
  /// trailing means of its thermometers. NaN while the prediction is unknown, while an operator handled the unit, and
  /// while the unit was turned around.
  Eigen::MatrixXd rate_deg_per_h{};
  std::vector<std::string> thermometers{};
  Eigen::MatrixXd temperature_c{};  ///< seconds × thermometers
  /// Uncertainty of each thermometer after a year of use.
  std::vector<double> thermometer_in_a_year_k{};
  /// Axes × thermometers: mean slope of each model over the record.
  Eigen::MatrixXd sensitivity_deg_per_h_per_k{};
  /// Models of the axes, each with an uncertainty budget.
  std::vector<Model> models{};
  /// Quantisation step of each axis: the rate of one pulse per second.
  std::vector<double> step_deg_per_h{};
  /// Covariance caused by the thermometers' drift between training and this run, (°/h)².
  Eigen::MatrixXd thermometer_drift_covariance{};
  /// Covariance of the errors that training and use share: certificates, angles, scale factors, (°/h)².
  Eigen::MatrixXd learnt{};
  /// Attitude of the fixture, if latitude and azimuths are known.
  std::optional<fusion::Attitude> attitude{};
  /// Axes with an input outside the trained range, per second.
  std::vector<AxisSet> outside{};
  /// Seconds × axes: variance added to an axis with an input outside the trained range, (°/h)²: extrapolation_factor()
  /// times its model form variance. Otherwise 0.
  Eigen::MatrixXd added_variance{};
  std::vector<std::string> warnings{};
  [[nodiscard]] Eigen::Index axes() const { return directions.rows(); }
};

/// Compensates the axes like CompensationStream, which is causal and handles gaps, and collects the uncertainties of
/// their models. A thermometer that several axes share correlates their errors. This covariance is the variance of the
/// thermometer times the mean, over the record, of the products of the axes' signed slopes. The attitude is the
/// rotation of the directions into the recorded azimuths and elevations (Wahba's problem by a singular value
/// decomposition; Markley, J. Astronaut. Sci. 36 (1988) 245).
///
/// Fails with usage if there are more than 64 axes, if a record does not have one sample per second, if an axis has no
/// direction, if a model has no uncertainty or belongs to another axis of the unit, if the Earth rate on an axis is
/// unknown, or if directions and angles of a record are inconsistent. Also fails like CompensationStream and
/// make_clusters. Fewer than three axes are permitted here; make_geometry() rejects them.
[[nodiscard]] Result<FusedAxes> compensate_axes(const std::vector<CompensatedAxis>& axes,
                                                Outside outside = Outside::continued);

/// Components of the variance of a mean over a given averaging time, (°/h)².
struct FusedUncertainty {
  /// Variances of errors that are independent between means and between axes: angle random walk, quantisation (treated
  /// as white; its standard deviation in a mean over τ seconds is 1/√6 of a pulse divided by τ) and thermometer noise.
  Eigen::VectorXd noise;
  /// Covariance of errors that vary slowly or differ between runs: model form, turn-on, thermometer drift.
  Eigen::MatrixXd bias;
  /// Covariance of errors that training and use share. No comparison of axes can reveal them.
  Eigen::MatrixXd learnt;
  [[nodiscard]] Eigen::MatrixXd varying_covariance() const { return Eigen::MatrixXd(noise.asDiagonal()) + bias; }
};
[[nodiscard]] FusedUncertainty uncertainty_of_means(const FusedAxes& axes, double averaging_s);

/// Returns the covariance of a fused rate vector, (°/h)²: that of its axes' varying errors, the errors that training
/// and use share (`learnt`), and the variance `added` to each axis outside its trained range. The last two contain only
/// the axes of `gains`. Every U of a fused rate comes from this covariance.
[[nodiscard]] Eigen::Matrix3d rate_covariance(const fusion::Gains& gains, const Eigen::MatrixXd& learnt,
                                              const Eigen::VectorXd& added);

/// Returns the indices of the axes in a set, in ascending order.
[[nodiscard]] std::vector<Eigen::Index> members(AxisSet set);
[[nodiscard]] std::string names_in(const FusedAxes& axes, AxisSet set);

/// Returns the geometry of a set of axes; `covariance` is the covariance of all axes. Fails like make_geometry().
[[nodiscard]] Result<fusion::Geometry> geometry_of_set(const FusedAxes& axes, AxisSet set,
                                                       const Eigen::MatrixXd& covariance);

/// Returns the Earth's rotation in the axes of a fixture with this attitude, °/h.
[[nodiscard]] Eigen::Vector3d earth_in_fixture(const fusion::Attitude& attitude);

}  // namespace gyrotherm::model
