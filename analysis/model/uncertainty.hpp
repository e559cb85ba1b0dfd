// SPDX-License-Identifier: Apache-2.0
/// The uncertainty of a compensated bias: a model's sensitivity to each thermometer, the budget of this and all other
/// sources, and the interval that should contain the bias of an unseen run.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "analysis/data/dataset.hpp"
#include "analysis/model/budget.hpp"
#include "analysis/model/model.hpp"
#include "core/result.hpp"

namespace gyrotherm::model {

/// Computes ∂b/∂T, °/h per K, one row per cluster and one column per thermometer of the clusters. The thermometer error
/// is assumed to be constant in time, so rates and lags do not respond to it. Uses the central difference of `predict`
/// over ± 1 mK for every method. Outside the trained range the slope of the plane is evaluated at the input, and that
/// of the other parts of the function at the bounded point (Outside::continued). NaN where an input is unknown. Fails
/// with usage if the clusters lack a thermometer that the model needs.
[[nodiscard]] Result<Eigen::MatrixXd> sensitivities(const Model& model, const data::Clusters& clusters);

/// Returns mean, root mean square and greatest magnitude of each column of sensitivities() that is not all 0.
[[nodiscard]] std::vector<Sensitivity> summarise_sensitivities(const Eigen::MatrixXd& sensitivities,
                                                               const std::vector<std::string>& thermometers);

/// Computes the standard deviation of each thermometer's noise in the mean of one cluster, K. The variance of a sample
/// is estimated from second differences, (T_{k+1} − 2T_k + T_{k−1})²/6, which are insensitive to the slow change of the
/// temperature, and is divided by the number of samples in a cluster. The noise is assumed to be white; it includes the
/// resolution.
[[nodiscard]] Eigen::RowVectorXd thermometer_noise_k(const data::Dataset& dataset, const data::Clusters& clusters);

/// Returns the standard uncertainty of a residual for use in an expanded uncertainty, °/h: its root mean square, unless
/// a transient of a few means dominates the residual. In that case returns the greater of q₉₅/1.96 and q₆₈, the
/// quantiles of its magnitude that contain 95 % and 68.27 % of the means of another run (conformal prediction: Lei et
/// al., J. Am. Stat. Assoc. 113 (2018) 1094). The quantiles are taken at (n + 1)/n of these shares, with n the
/// effective number of means. All three are equal for normal residuals. Quantiles above the root mean square are not
/// used.
[[nodiscard]] double robust_standard_deg_per_h(const Eigen::VectorXd& residual_deg_per_h, double effective);

/// Returns the factor by which the correlation of the in-sample residuals enlarges the variance of a linear function.
/// The number of residuals is replaced by the effective number of their mean, because the inputs vary as slowly as the
/// residuals.
[[nodiscard]] double correlation_factor(const Model& model);

/// Half of the difference between the residuals during warming and during cooling at equal temperatures.
struct Hysteresis {
  double half_deg_per_h{};
  double degrees_of_freedom = 1;  ///< ½(u/Δu)², GUM G.3
};

/// Estimates hysteresis in steps of 5 °C of the thermometers' mean. Returns the root mean square of half the difference
/// between the mean residuals at rising and at falling temperature (more than 0.05 °C/min), minus the difference
/// expected by chance. The unit's own values are not treated as thermometers; if there is no thermometer, the unit's
/// own temperature is used. 0 if no step has three clusters of both directions, or if chance explains the whole
/// difference.
[[nodiscard]] Hysteresis estimate_hysteresis(const Eigen::VectorXd& residual_deg_per_h, const data::Clusters& clusters);

/// Training records of a model, the training clusters of each, and the held-out residual of all these clusters, record
/// by record; NaN where a cluster has no residual.
struct TrainingBasis {
  const std::vector<data::Dataset>& datasets;
  const std::vector<data::Clusters>& clusters;
  /// The constant of each power-on is subtracted, if the training subtracted it.
  const Eigen::VectorXd& held_out_residual_deg_per_h;
  /// True if the hyper-parameters were chosen by the same residual, which then underestimates the error.
  bool chosen_on_these_folds = false;
  /// True if the caller adds a budget row for the model's predictive variance. Uncertainty::variance_in_training then
  /// stays NaN.
  bool variance_is_a_row = false;
};

/// Computes the budget of a mean over 1 h, and its components. The sources:
/// - angle random walk, flicker (its Allan deviation, 0.664 B) and rate random walk (K√(τ/3)) as estimated by the Allan
///   fit of the compensated holds, from the record with the longest total hold time; degrees of freedom ½(u/Δu)² (GUM
///   G.3). If the fit finds no angle random walk, the noise floor less its quantisation is used as if it were white. If
///   no record has a hold, it is data::residual_noise() of the held-out residual, and the row states this. Rows are not
///   tested for significance: an uncertain row has few degrees of freedom;
/// - quantisation, if the first record counts pulses of size q: each end of a mean is uniformly off by up to half a
///   pulse, so the error of the mean has a triangular distribution within ± q/τ, and u = q/(√6 τ) (GUM 4.3.9);
/// - noise of the thermometers: thermometer_noise_k() times the sensitivities;
/// - model form: its variance is the held-out RMSE², or robust_standard_deg_per_h()² if a transient dominates the
///   residual, minus noise floor² and hysteresis², with the degrees of freedom of this difference;
/// - hysteresis: a/√3, with ± a the limits of its error;
/// - turn-on, once in use and once in training, the latter divided by the root of the number of power-ons;
/// - each thermometer's calibration and its drift u·√(years since calibration), times the root mean square of its
///   sensitivity. Other inputs have no calibration row: their constant error is a property of the unit;
/// - if the Earth rate was subtracted: latitude, azimuth and tilt times the slopes of the Earth rate on the input axis,
///   and the scale factor times the Earth rate. For an axis in a fixture, the fixture's elevation and roll and the axis
///   direction replace the tilt.
/// Values that the record does not state are assumed and marked: thermometers 0.02 K of calibration, 0.05 K of drift
/// per year, one year since the calibration; turn-on 0.001 °/h; latitude 0.01°, azimuth 0.1°, tilt, elevation, roll and
/// direction 1′ each; scale factor 10 ppm. The first record describes thermometers and gyro. Fails with usage if the
/// clusters lack a thermometer that the model needs.
[[nodiscard]] Result<Uncertainty> evaluate_uncertainty(const Model& model, const TrainingBasis& on);

/// Returns the budget row for the scale factor error of a measured rate, °/h.
[[nodiscard]] BudgetRow budget_of_scale_factor(const data::Dataset& dataset, double rate_deg_per_h);

/// Returns the budget rows for the angles that a record states: latitude, azimuth and tilt (or the angles of a
/// fixture), each with the slope of the Earth rate as its sensitivity. Returns no row if the record does not state the
/// angles.
[[nodiscard]] std::vector<BudgetRow> budget_of_angles(const data::Dataset& dataset);

/// Returns the budget rows of a bias from which the Earth rate was subtracted: those of the angles, and a scale factor
/// row that applies to the Earth rate. Returns no row if no Earth rate was subtracted.
[[nodiscard]] std::vector<BudgetRow> budget_of_earth_rate(const data::Dataset& dataset);

/// Returns the budget rows for the calibration of a thermometer and for its drift until the run of a record, with this
/// sensitivity.
[[nodiscard]] std::vector<BudgetRow> budget_of_thermometer(const data::Dataset& dataset,
                                                           const Sensitivity& sensitivity);

/// Uncertainty of each thermometer of a record after a year of use, K: the root sum of squares of its calibration, if
/// the record states it, and of the drift in a year, assumed to be 0.05 K if the record does not state it.
struct ThermometersInUse {
  std::vector<double> uncertainty_k;
};
[[nodiscard]] ThermometersInUse thermometers_in_use(const data::Dataset& dataset);

/// Returns the standard deviation of the bias from power-on to power-on that a record states, or 0.001 °/h.
[[nodiscard]] double turn_on_repeatability(const data::Dataset& dataset);

/// Computes the standard uncertainty that the thermometers' drift in a year adds to the compensated bias, °/h: the root
/// sum of squares of each drift, as stated in the record or 0.05 K, times the root mean square of the model's
/// sensitivity. 0 for a model without an uncertainty.
[[nodiscard]] double yearly_drift_deg_per_h(const Model& model, const data::Dataset& dataset);

/// Computes the drift of a budget's thermometer between the training and the run of a record, K, as if the drifts from
/// calibration to training and from calibration to run were independent. If neither day of calibration is known, a year
/// is assumed between them.
[[nodiscard]] double drift_between_k(const BudgetRow& row, const data::Dataset& dataset);

/// Computes the drift of each thermometer of `used` between two runs, K, as if the drifts from the calibration to each
/// run were independent. Assumes a drift of 0.05 K per year and one year since the calibration where a record does not
/// state them, and one year between the runs if neither states the day.
[[nodiscard]] std::vector<double> drifts_between_k(const data::Dataset& trained, const data::Dataset& used);

/// Returns a model's budget rows for the run of an unseen record. The uncertainty of a drift row becomes
/// drift_between_k(). The row is marked as assumed if the record does not state the drift or the day of calibration.
[[nodiscard]] std::vector<BudgetRow> rows_for_run(const data::Dataset& dataset, std::vector<BudgetRow> rows);

/// Computes the half-width of the interval, °/h, that should contain each cluster's mean of compensated bias with
/// probability kCoverage in an unseen run. It combines the sources that differ within a run or between runs, for means
/// over the cluster length, and is expanded like a budget. Errors that are equal in training and in use are excluded,
/// since the model has learnt them. A thermometer contributes its sensitivity in this cluster times its drifts until
/// training and until this run. The two drifts are treated as independent, which is an upper limit for a random walk.
/// If neither day of calibration is known, a year is assumed between them. Outside the trained range
/// extrapolation_factor() is added. If the model has a predictive variance and the budget a row `coefficients`, the
/// variance in this cluster replaces the row. Without such a row only the excess of the variance over its mean in
/// training is added, because the held-out residual includes this mean. `trained` is the uncertainty of the model. NaN
/// where an input is unknown. Fails like sensitivities().
[[nodiscard]] Result<Eigen::VectorXd> interval_half_widths(const Model& model, const Uncertainty& trained,
                                                           const data::Dataset& dataset,
                                                           const data::Clusters& clusters);

/// Returns the budget row for the use of a model outside its trained range in a run: the variance that
/// interval_half_widths() adds there, averaged over all clusters of the run with known inputs. `rows` is the budget
/// without this row. The row is of type B, because extrapolation_factor() assumes the growth of the error. No value if
/// no cluster is outside. Fails like sensitivities().
[[nodiscard]] Result<std::optional<BudgetRow>> budget_of_extrapolation(const Model& model, const Uncertainty& trained,
                                                                       const std::vector<BudgetRow>& rows,
                                                                       const data::Clusters& clusters);

/// Partial derivatives of the Earth rate on an axis in a fixture, °/h per degree: with respect to elevation and roll of
/// the fixture, signed, and to a tilt of the axis, as a root mean square over all directions perpendicular to the axis.
struct FixtureSlopes {
  double elevation{}, roll{}, direction{};
};
/// Computes the derivatives from latitude, from azimuth and elevation of the axis, and from azimuth and elevation of
/// the fixture; all must be known. The fixture is raised about its own horizontal axis and rolled about its x axis.
[[nodiscard]] FixtureSlopes fixture_slopes(const record::GyroUncertainty& known);

/// Partial derivatives of the Earth rate on an axis, Ω(cos φ cos az cos el + sin φ sin el), with respect to latitude,
/// azimuth and elevation, °/h per degree.
struct EarthRateSlopes {
  double latitude{}, azimuth{}, elevation{};
};
[[nodiscard]] EarthRateSlopes earth_rate_slopes(double latitude_deg, double azimuth_deg, double elevation_deg);

}  // namespace gyrotherm::model
