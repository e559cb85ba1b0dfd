// SPDX-License-Identifier: Apache-2.0
/// How uncertain a compensated bias is: how far a model goes with each thermometer, what that and all else comes to in
/// a budget, and the interval in which a run that it has not seen should lie.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "analysis/data/dataset.hpp"
#include "analysis/model/budget.hpp"
#include "analysis/model/model.hpp"
#include "core/result.hpp"

namespace gyrotherm::model {

/// ∂b/∂T, °/h per K: a row per cluster, a column per thermometer of the clusters, for an error of a thermometer that is
/// constant in time (neither a rate nor a lag sees it). Of a model of any method, by the central difference of
/// `predict` over ± 1 mK. Beyond the trained range the plane has its slope and all else that of the bounded point
/// (Outside::continued). NaN where an input is not known. Fails with usage if the clusters lack a
/// thermometer that the model needs.
[[nodiscard]] Result<Eigen::MatrixXd> sensitivities(const Model& model, const data::Clusters& clusters);

/// Mean, root mean square and greatest of the columns of sensitivities(), of those that are not all 0.
[[nodiscard]] std::vector<Sensitivity> over_the_record(const Eigen::MatrixXd& sensitivities,
                                                       const std::vector<std::string>& thermometers);

/// The standard deviation of each thermometer's noise in a mean of one cluster, K: that of its samples, from their
/// second differences (T_{k+1} − 2T_k + T_{k−1})²/6, in which what the temperature does drops out, by the root of the
/// samples in a cluster. It is taken to be white; resolution is in it.
[[nodiscard]] Eigen::RowVectorXd thermometer_noise_k(const data::Dataset& dataset, const data::Clusters& clusters);

/// Returns the standard uncertainty by which a residual is to be expanded, °/h: its root mean square, unless a
/// transient of few means sets that. Then it is the greater of q₉₅/1.96 and q₆₈, the quantiles of its magnitude that
/// hold 95 % and 68.27 % of the means of another run (conformal prediction: Lei et al., J. Am. Stat. Assoc. 113 (2018)
/// 1094), (n + 1)/n of the share, n the effective number of means. Of normal residuals all three are the same.
/// Quantiles above the root mean square are not used.
[[nodiscard]] double robust_standard_deg_per_h(const Eigen::VectorXd& residual_deg_per_h, double effective);

/// Half of how a residual differs between warming and cooling at equal temperatures.
struct Hysteresis {
  double half_deg_per_h{};
  double degrees_of_freedom = 1;  ///< ½(u/Δu)², GUM G.3
};

/// Returns the root mean square, over steps of 5 °C of the thermometers' mean, of half the difference between the mean
/// residual where it rises and where it falls by more than 0.05 °C/min, less what chance makes of such means. The
/// unit's own values are not among these thermometers; without any, its own temperature stands for them. 0 if no step
/// has three of both, or chance makes more.
[[nodiscard]] Hysteresis hysteresis_of(const Eigen::VectorXd& residual_deg_per_h, const data::Clusters& clusters);

/// The training records of a model, each with the clusters that it was trained on, and what it leaves of these where it
/// has not seen them: the held-out residual, one record after the other, NaN where there is none.
struct TrainedOn {
  const std::vector<data::Dataset>& datasets;
  const std::vector<data::Clusters>& clusters;
  const Eigen::VectorXd& held_out_residual_deg_per_h;
  bool chosen_on_these_folds = false;  ///< the residual chose parameters too
  /// The budget gets a row of the model's own variance. Uncertainty::variance_in_training is then left out.
  bool variance_is_a_row = false;
};

/// The budget of a mean over 1 h, and what it is made of. The sources:
/// - angle random walk, flicker (its Allan deviation, 0.664 B) and rate random walk (K√(τ/3)) as the Allan fit of the
///   compensated holds estimates them (of the record with most of them), their degrees of freedom ½(u/Δu)² (GUM G.3);
///   where it sees no angle random walk, the noise floor, less what counting makes of it, as if it were white; nothing
///   where there is no hold. No row is tested for significance: a row that is uncertain has few degrees of freedom;
/// - counting, where the first record counts pulses of q: each end of a mean is off by up to half a pulse, evenly, so
///   that the mean is off by up to q/τ, as a triangle: q/(√6 τ) (GUM 4.3.9);
/// - noise of the thermometers, as above;
/// - model form: the held-out RMSE², or where a transient sets that robust_standard_deg_per_h()², less noise floor² and
/// hysteresis², with the degrees of freedom of that difference;
/// - hysteresis as limits, ± a: a/√3;
/// - turn-on, once in use and once in training, there divided by the root of the records;
/// - each thermometer's calibration (of another input none, for what it is off by is a part of the unit), and its drift
/// u·√(years since), by the root mean square of its sensitivity;
/// - latitude, azimuth and tilt by the slopes of the Earth rate on the input axis, of an axis in a fixture its
/// elevation,
///   roll and the axis's direction each by its own instead of the tilt, and the scale factor by the Earth rate, where
///   that is removed.
/// What the record does not say is assumed, and marked: thermometers 0.02 K of calibration, 0.05 K of drift in a year,
/// a year since the calibration; turn-on 0.001 °/h; latitude 0.01°, azimuth 0.1°, tilt, elevation, roll and
/// direction 1′ each; scale factor 10 ppm.
/// What thermometers and gyro are is what the first record says. Fails with usage if the clusters lack a thermometer
/// that the model needs.
[[nodiscard]] Result<Uncertainty> uncertainty_of(const Model& model, const TrainedOn& on);

/// The scale factor's row for a rate that was measured by it, °/h, as in a budget.
[[nodiscard]] BudgetRow budget_of_scale_factor(const data::Dataset& dataset, double rate_deg_per_h);

/// Returns the rows of a bias from which the Earth's rate was taken away: latitude, azimuth and tilt, or the angles of
/// a fixture, by the slopes of that rate, where the record says the angles, and the scale factor by the rate itself, as
/// in a budget. Empty where none was taken away.
[[nodiscard]] std::vector<BudgetRow> budget_of_earth_rate(const data::Dataset& dataset);

/// The calibration of a thermometer and its drift until the run of a record, as in a budget, for that sensitivity.
[[nodiscard]] std::vector<BudgetRow> budget_of_thermometer(const data::Dataset& dataset,
                                                           const Sensitivity& sensitivity);

/// How well the thermometers of a record are known in a year of use, K: of each, the root sum square of its
/// calibration, if the record says it, and of the drift of a year; where the record does not say that, `assumed`: 0.05
/// K.
struct ThermometersInUse {
  std::vector<double> uncertainty_k;
  bool assumed{};  ///< any of them
};
[[nodiscard]] ThermometersInUse thermometers_in_use(const data::Dataset& dataset);

/// The standard uncertainty that a year's drift of the thermometers adds to the compensated bias, °/h: root sum of
/// squares of each one's drift, as the record says it or 0.05 K, by the root mean square of the model's sensitivity to
/// it. 0 of a model that says nothing of its uncertainty.
[[nodiscard]] double drift_in_a_year_deg_per_h(const Model& model, const data::Dataset& dataset);

/// How far the thermometer of a budget's row of drift may have walked between the training and the run of a record, K,
/// as if its drift until the one and until the other were independent; where neither day of calibration is known, in a
/// year.
[[nodiscard]] double drift_between_k(const BudgetRow& row, const data::Dataset& dataset);

/// Computes how far each thermometer of `used` may have drifted between the two runs, K, as if its drift from the
/// calibration to the one and to the other were independent. A drift of 0.05 K in a year and a year since the
/// calibration are assumed where a record does not state them; a year between the runs where neither states the day.
[[nodiscard]] std::vector<double> drifts_between_k(const data::Dataset& trained, const data::Dataset& used);

/// The rows of a model's budget as they are in the run of a record that it has not seen: the thermometers have drifted
/// by drift_between_k(), which is assumed if the record does not say how far they do, or since when.
[[nodiscard]] std::vector<BudgetRow> in_the_run(const data::Dataset& dataset, std::vector<BudgetRow> rows);

/// Half the width of the interval, °/h, that should hold each cluster's mean of compensated bias with kCoverage, on a
/// run that the model has not seen: what differs within a run or between runs, at the cluster length, expanded as a
/// budget is. What is the same in training and in use is not in it, for the model has learnt it. A thermometer counts
/// by its sensitivity in that very cluster, and by its drift until the training and until this run, as if they were
/// independent: of one walk that is an upper limit. Outside the trained range widening() is added. Where neither day of
/// calibration is known, a year is between. Where a model knows its own variance, that of the cluster counts: all of it
/// in the place of a row `coefficients`, else what exceeds its mean in training, which the held-out residual contains.
/// `trained` is that of the model. NaN where an input is not known. Fails as sensitivities() does.
[[nodiscard]] Result<Eigen::VectorXd> interval_half_widths(const Model& model, const Uncertainty& trained,
                                                           const data::Dataset& dataset,
                                                           const data::Clusters& clusters);

/// The slopes of the Earth rate on an axis in a fixture by the fixture's elevation and roll, signed, and with where the
/// axis lies in it: of a turn that may have any direction across the axis, root mean square. °/h per degree.
struct FixtureSlopes {
  double elevation{}, roll{}, direction{};
};
/// Computes them from latitude, azimuth and elevation of the axis, and azimuth and elevation of the fixture, which must
/// all be known. The fixture is raised about its own horizontal axis and rolled about its x.
[[nodiscard]] FixtureSlopes fixture_slopes(const record::GyroUncertainty& known);

/// The Earth rate on an axis, Ω(cos φ cos az cos el + sin φ sin el), by each of its angles, °/h per degree.
struct EarthRateSlopes {
  double latitude{}, azimuth{}, elevation{};
};
[[nodiscard]] EarthRateSlopes earth_rate_slopes(double latitude_deg, double azimuth_deg, double elevation_deg);

}  // namespace gyrotherm::model
