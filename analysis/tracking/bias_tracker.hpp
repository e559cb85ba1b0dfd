// SPDX-License-Identifier: Apache-2.0
/// Bias tracking: a Kalman filter estimates the residual bias of a thermal model, with its uncertainty, while the gyro
/// is known to be at rest. It does not filter the output of the gyro and must not receive rates while the gyro rotates.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "analysis/tracking/state_space.hpp"

namespace gyrotherm::tracking {

/// Estimate of a bias, or of its mean over a period.
struct Estimate {
  double deg_per_h{};
  /// Standard deviation of its error, if the noise model is correct.
  double std_deg_per_h{};
};

/// Filter quantities of one interval.
struct TrackedInterval {
  /// State and covariance predicted before the mean of the interval is used.
  State predicted = State::Zero();
  Covariance predicted_covariance = Covariance::Zero();
  /// Mean minus its prediction. NaN if there is no mean.
  double innovation{};
  /// Expected variance of the innovation.
  double innovation_variance{};
};

/// Kalman filter (J. Basic Eng. 82 (1960) 35) for the states of a noise model. The covariance is updated in Joseph's
/// form, which keeps it symmetric and positive (Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking
/// and Navigation, 2001, section 5.2).
class BiasTracker {
 public:
  explicit BiasTracker(const StateSpace& space);

  /// Processes the mean of the next interval. Pass NaN if the gyro was not at rest or nothing was measured; the filter
  /// then only predicts, and its uncertainty grows.
  TrackedInterval push(double rate_deg_per_h);

  /// Returns the bias in the last interval pushed, or at the start.
  [[nodiscard]] Estimate estimate() const;
  /// Predicts the mean of the bias over the next `intervals`, at least 1.
  [[nodiscard]] Estimate forecast(int intervals) const;

  [[nodiscard]] const State& state() const { return state_; }
  [[nodiscard]] const Covariance& covariance() const { return covariance_; }

 private:
  StateSpace space_;
  State state_ = State::Zero();
  Covariance covariance_;
  /// Set once an interval was pushed.
  bool started_ = false;
};

/// Processes a sequence with a new tracker.
[[nodiscard]] std::vector<TrackedInterval> track(const StateSpace& space,
                                                 const Eigen::Ref<const Eigen::VectorXd>& rates_deg_per_h);

/// Tracker of the bias in a stream. Takes one compensated rate per second and returns the residual bias to subtract. It
/// averages the rates of an interval and pushes the mean to a BiasTracker if the gyro was at rest throughout the
/// interval. The bias returned for a row depends only on earlier intervals, so it contains neither noise nor rotation
/// of the row.
class RestTracker {
 public:
  /// Starts tracking. One interval of the space consists of `rows` rows of the stream.
  RestTracker(const StateSpace& space, int rows);

  /// Processes the next row, the residual rate of the thermal model, NaN if unknown. Returns the bias to subtract from
  /// it.
  Estimate push(double rate_deg_per_h, bool at_rest);
  /// Skips missing rows. The uncertainty of the bias grows meanwhile.
  void skip_rows(std::int64_t rows);

  [[nodiscard]] const BiasTracker& tracker() const { return tracker_; }

 private:
  BiasTracker tracker_;
  int rows_;
  int pushed_{};  ///< rows in this interval
  /// Sum of the rates in this interval. NaN if one is not usable.
  double sum_{};
  /// Bias predicted for this interval.
  Estimate bias_;
};

}  // namespace gyrotherm::tracking
