// SPDX-License-Identifier: Apache-2.0
/// Assesses bias tracking and the ways it is compared with: on a residual, on that residual shuffled, and on a step and
/// a ramp. Tests the innovations of its filter.
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

// The innovations of a filter are tested for their size and for whiteness.

/// The test of Ljung and Box (Biometrika 65 (1978) 297): Q = n(n + 2) Σ_k r_k²/n_k over the lags, n_k pairs k apart
/// and r_k their autocorrelation about 0, is χ² of as many degrees of freedom if the values are white.
struct Whiteness {
  double statistic{};
  int lags{};
  double probability{};  ///< of a statistic this large in white values; NaN if there are too few
};
/// Values that are NaN are missing; pairs are of those that are there.
[[nodiscard]] Whiteness whiteness_of(const Eigen::Ref<const Eigen::VectorXd>& values, int lags);

/// The innovations of a filter, judged (Bar-Shalom, Li, Kirubarajan, 2001, section 5.4).
struct Consistency {
  int innovations{};
  double mean_square{};  ///< NIS: the mean of the squared innovations, each over its expected variance; should be 1
  double low{}, high{};  ///< where chance leaves it in 95 of 100 cases, if it is χ²_n/n
  Whiteness whiteness{};
};
/// Leaves the first `settling` intervals out, in which the start's own uncertainty is most of the innovation.
[[nodiscard]] Consistency consistency_of(const std::vector<TrackedInterval>& intervals, std::size_t settling = 0);

void describe(auto& form, Like<Consistency> auto& consistency) {
  form("innovations", consistency.innovations);
  form("normalised_innovation_squared", consistency.mean_square);
  form("expected_from", consistency.low);
  form("expected_to", consistency.high);
  form("ljung_box", consistency.whiteness.statistic);
  form("ljung_box_lags", consistency.whiteness.lags);
  form("ljung_box_probability", consistency.whiteness.probability);
}

// The denoisers are compared.

/// One value per cluster as a sequence of equal intervals from the first cluster to the last, NaN where there is none.
[[nodiscard]] Eigen::VectorXd evenly_spaced(const Eigen::Ref<const Eigen::VectorXd>& values,
                                            const data::Clusters& clusters);

/// What a denoiser makes of a bias that changes amid the noise, less what it makes of the noise alone: of a step of
/// 1 °/h, and of a ramp of 0.01 °/h/min that ends after 6 h.
struct Response {
  double step_delay_s{};              ///< until what it says has half the step; NaN if not within a day
  double step_overshoot{};            ///< beyond the step, as a part of it
  double ramp_delay_s{};              ///< how far behind it is where the ramp ends
  double ramp_overshoot_deg_per_h{};  ///< beyond the ramp's end
};
[[nodiscard]] Response response_of(const Denoiser& denoiser, const StateSpace& space);

/// Figures of one denoiser; NaN where there is nothing to judge by, as of the forecasts of one that is late.
struct DenoiserFigures {
  std::string name;
  double latency_s{};
  double next_hour_rmse{};           ///< °/h: its forecast of an hour less the mean of the rates measured in it
  double next_hour_rmse_error{};     ///< standard error, by the number of whole hours
  double next_hour_rmse_to_truth{};  ///< … less the mean of the true bias
  double rmse_to_truth{};            ///< °/h: what it says of the bias of an interval less the true bias there
  double shuffled_gain{};   ///< 1 − its next-hour RMSE/that of saying 0, where there is nothing to be followed
  double allan_interval{};  ///< Allan deviation at one interval of the rate that is left, °/h: the angle's
  double allan_hour{};      ///< … at an hour
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

/// A residual as it was tracked and as it is known afterwards, an interval each, °/h: for drawings.
struct TrackedSeries {
  std::vector<double> residual;                ///< NaN where it is missing
  std::vector<double> foretold;                ///< the bias, by the intervals before
  std::vector<double> smoothed, smoothed_std;  ///< by all of them: no part of any figure
};
[[nodiscard]] TrackedSeries series_of(const BiasNoise& noise, const Eigen::VectorXd& residual_deg_per_h,
                                      double interval_s);

void describe(auto& form, Like<TrackedSeries> auto& series) {
  form("residual_deg_per_h", series.residual);
  form("foretold_deg_per_h", series.foretold);
  form("smoothed_deg_per_h", series.smoothed);
  form("smoothed_std_deg_per_h", series.smoothed_std);
}

/// Everything that is said of tracking one residual.
struct Assessment {
  BiasNoise noise;
  double interval_s{};
  double steady_gain{};  ///< where that of the Kalman filter settles: what of an innovation it takes for bias
  int hours{};           ///< whole ones that were foretold
  std::vector<DenoiserFigures> denoisers;
  Consistency consistency{};  ///< of the Kalman filter
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

/// Judges by a residual, means over equal intervals with NaN where one is missing, and by the true bias in each where
/// that is known (else empty).
///
/// Forecasts are made at the end of every interval from the second hour's on, each for the hour that follows, and only
/// hours without a gap count. The residual that is shuffled (eight times, by seeds) has lost its mean first: what is
/// left has the same values and no order, so that who still gains on it, gains by chance or by a mistake of the judge.
/// The rate that is left is the residual less what was said of the bias one interval before: what would be integrated
/// to an angle.
[[nodiscard]] Assessment judge(const BiasNoise& noise, const Eigen::VectorXd& residual_deg_per_h, double interval_s,
                               const Eigen::VectorXd& true_bias_deg_per_h = {});

}  // namespace gyrotherm::tracking
