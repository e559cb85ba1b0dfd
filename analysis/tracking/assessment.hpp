// SPDX-License-Identifier: Apache-2.0
/// Assessment of bias tracking and of the denoisers with which it is compared. Each is applied to a residual, to the
/// same residual in random order, and to a step and a ramp. Includes tests of the innovations of the filter.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "analysis/tracking/bias_tracker.hpp"
#include "analysis/tracking/state_space.hpp"
#include "core/form.hpp"

namespace gyrotherm::tracking {

struct Denoiser;  // analysis/tracking/baselines.hpp

// Tests for the size and the whiteness of the innovations of a filter.

/// Result of the Ljung–Box test (Biometrika 65 (1978) 297). Q = n(n + 2) Σ_k r_k²/n_k over the lags, with n_k the
/// number of pairs at lag k and r_k their autocorrelation about 0. For white values Q follows χ² with as many degrees
/// of freedom as lags.
struct Whiteness {
  double statistic{};
  int lags{};
  /// Probability of a statistic at least this large for white values. NaN if there are too few values.
  double probability{};
};
/// Tests values for whiteness. NaN values are missing; pairs with a missing value are skipped.
[[nodiscard]] Whiteness test_whiteness(const Eigen::Ref<const Eigen::VectorXd>& values, int lags);

/// Consistency of the innovations of a filter (Bar-Shalom, Li, Kirubarajan, 2001, section 5.4).
struct Consistency {
  int innovations{};
  /// NIS: mean of the squared innovations, each divided by its expected variance. Its expectation is 1.
  double mean_square{};
  /// Limits of the central 95 % of χ²_n/n.
  double low{}, high{};
  Whiteness whiteness{};
};
/// Computes the consistency. Skips the first `settling` intervals, whose innovations are dominated by the initial
/// uncertainty.
[[nodiscard]] Consistency test_consistency(const std::vector<TrackedInterval>& intervals, std::size_t settling = 0);

void describe(auto& form, Like<Consistency> auto& consistency) {
  form("innovations", consistency.innovations);
  form("normalised_innovation_squared", consistency.mean_square);
  form("expected_from", consistency.low);
  form("expected_to", consistency.high);
  form("ljung_box", consistency.whiteness.statistic);
  form("ljung_box_lags", consistency.whiteness.lags);
  form("ljung_box_probability", consistency.whiteness.probability);
}

// Comparison of denoisers.

/// Returns the values of the clusters as a sequence of equal intervals from the first cluster to the last. NaN where a
/// cluster is missing.
[[nodiscard]] Eigen::VectorXd space_evenly(const Eigen::Ref<const Eigen::VectorXd>& values,
                                           const data::Clusters& clusters);

/// Response of a denoiser to a bias that changes amid the noise, minus its response to the same noise without the
/// change. The changes are a step of 1 °/h and a ramp of 0.01 °/h/min that ends after 6 h.
struct Response {
  /// Time until the estimate reaches half the step. NaN if this takes more than a day.
  double step_delay_s{};
  /// Overshoot, as a fraction of the step.
  double step_overshoot{};
  /// Time by which the estimate lags behind the bias at the end of the ramp.
  double ramp_delay_s{};
  /// Greatest excess of the estimate over the end value of the ramp.
  double ramp_overshoot_deg_per_h{};
};
[[nodiscard]] Response measure_response(const Denoiser& denoiser, const StateSpace& space);

/// Results of one denoiser. NaN where a result is not available, such as the forecasts of a denoiser with latency.
struct DenoiserFigures {
  std::string name;
  double latency_s{};
  /// RMS of the forecast of one hour minus the mean of the rates measured in that hour, °/h. Its standard error follows
  /// from the number of whole hours.
  double next_hour_rmse{};
  double next_hour_rmse_error{};
  /// RMS of the same forecast minus the mean of the true bias, °/h.
  double next_hour_rmse_to_truth{};
  /// RMS of the bias estimate of an interval minus the true bias in that interval, °/h.
  double rmse_to_truth{};
  /// Gain on shuffled residuals, in which there is no bias to track: 1 − (next-hour RMSE)/(next-hour RMSE of a zero
  /// forecast).
  double shuffled_gain{};
  /// Allan deviation of the residual rate at one interval and at one hour, °/h. A user would integrate the residual
  /// rate to an angle.
  double allan_interval{};
  double allan_hour{};
  Response response;
};

void describe(auto& form, Like<DenoiserFigures> auto& figures) {
  form("name", figures.name);
  form("latency_s", figures.latency_s);
  form("next_hour_rmse_deg_per_h", figures.next_hour_rmse);
  form("next_hour_rmse_error_deg_per_h", figures.next_hour_rmse_error);
  form("next_hour_rmse_to_truth_deg_per_h", figures.next_hour_rmse_to_truth);
  form("rmse_to_truth_deg_per_h", figures.rmse_to_truth);
  form("shuffled_gain", figures.shuffled_gain);
  form("allan_deviation_of_interval_deg_per_h", figures.allan_interval);
  form("allan_deviation_of_hour_deg_per_h", figures.allan_hour);
  form("step_delay_s", figures.response.step_delay_s);
  form("step_overshoot", figures.response.step_overshoot);
  form("ramp_delay_s", figures.response.ramp_delay_s);
  form("ramp_overshoot_deg_per_h", figures.response.ramp_overshoot_deg_per_h);
}

/// Residual with the predicted and the smoothed bias, one value per interval, °/h. Used for plots.
struct TrackedSeries {
  std::vector<double> residual;  ///< NaN where missing
  /// Bias predicted from the previous intervals.
  std::vector<double> predicted;
  /// Bias estimated from all intervals. Not used in any result.
  std::vector<double> smoothed, smoothed_std;
};
[[nodiscard]] TrackedSeries make_series(const BiasNoise& noise, const Eigen::VectorXd& residual_deg_per_h,
                                        double interval_s);

void describe(auto& form, Like<TrackedSeries> auto& series) {
  form("residual_deg_per_h", series.residual);
  form("foretold_deg_per_h", series.predicted);
  form("smoothed_deg_per_h", series.smoothed);
  form("smoothed_std_deg_per_h", series.smoothed_std);
}

/// Complete assessment of tracking one residual.
struct Assessment {
  BiasNoise noise;
  double interval_s{};
  /// Steady-state gain of the Kalman filter: the fraction of an innovation that is added to the bias estimate.
  double steady_gain{};
  /// Number of whole hours that were predicted.
  int hours{};
  std::vector<DenoiserFigures> denoisers;
  /// Consistency of the Kalman filter.
  Consistency consistency{};
  TrackedSeries series;
};

void describe(auto& form, Like<Assessment> auto& assessment) {
  form("noise", assessment.noise);
  form("interval_s", assessment.interval_s);
  form("steady_gain", assessment.steady_gain);
  form("hours", assessment.hours);
  form("denoisers", assessment.denoisers);
  form("innovations", assessment.consistency);
  form("series", assessment.series);
}

/// Assesses the denoisers on a residual. The residual is a sequence of means over equal intervals, NaN where one is
/// missing. `true_bias_deg_per_h` is the true bias of each interval, or empty if unknown.
///
/// A forecast of the following hour is made at the end of every interval from the second hour on. Only forecasts of
/// hours without a gap are assessed. The mean of the residual is removed, and the values are shuffled eight times with
/// different seeds. Shuffled values have no temporal order, so any gain on them is due to chance or to a flaw of this
/// assessment. The residual rate is the residual minus the bias estimate of the previous interval.
[[nodiscard]] Assessment assess(const BiasNoise& noise, const Eigen::VectorXd& residual_deg_per_h, double interval_s,
                                const Eigen::VectorXd& true_bias_deg_per_h = {});

}  // namespace gyrotherm::tracking
