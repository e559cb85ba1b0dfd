// SPDX-License-Identifier: Apache-2.0
/// Bias tracking: a Kalman filter that follows what a thermal model leaves of the bias while the gyro is known to be at
/// rest, and says how well it knows it. It is no filter of the output: what rotates must not be shown to it.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "analysis/tracking/state_space.hpp"

namespace gyrotherm::tracking {

/// What is known of a bias, or of its mean over a time.
struct Estimate {
  double deg_per_h{};
  double std_deg_per_h{};  ///< of its error, if the noise is what the filter was told
};

/// What one interval was to the filter.
struct TrackedInterval {
  State predicted = State::Zero();  ///< before its mean was seen
  Covariance predicted_covariance = Covariance::Zero();
  double innovation{};           ///< the mean less what was predicted of it; NaN if there is none
  double innovation_variance{};  ///< what its square is expected to be
};

/// The filter of Kalman (J. Basic Eng. 82 (1960) 35) for the states of a noise. The covariance is updated in Joseph's
/// form, which keeps it symmetric and positive (Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking
/// and Navigation, 2001, section 5.2).
class BiasTracker {
 public:
  explicit BiasTracker(const StateSpace& space);

  /// The next interval's mean; NaN where the gyro was not at rest, or none was measured: the filter then goes on by
  /// what it knows, and its uncertainty grows.
  TrackedInterval push(double rate_deg_per_h);

  /// The bias in the interval pushed last, or at the start.
  [[nodiscard]] Estimate now() const;
  /// The mean of the bias over the `intervals` to come, at least 1.
  [[nodiscard]] Estimate forecast(int intervals) const;

  [[nodiscard]] const State& state() const { return state_; }
  [[nodiscard]] const Covariance& covariance() const { return covariance_; }

 private:
  StateSpace space_;
  State state_ = State::Zero();
  Covariance covariance_;
  bool started_ = false;  ///< an interval has been pushed
};

/// Pushes a sequence through a new tracker.
[[nodiscard]] std::vector<TrackedInterval> track(const StateSpace& space,
                                                 const Eigen::Ref<const Eigen::VectorXd>& rates_deg_per_h);

/// Tracks the bias of a stream: a compensated rate a second in, the bias that is left in it out. Averages the rates of
/// an interval and pushes the mean if the gyro was at rest all the while. What it says of a row is from the intervals
/// before it: it takes nothing of a row's own noise or rotation away.
class RestTracker {
 public:
  /// `rows` of the stream make an interval of the space.
  RestTracker(const StateSpace& space, int rows);

  /// The next row: what the thermal model left, NaN where that is not known. Returns the bias to take from it.
  Estimate push(double rate_deg_per_h, bool at_rest);
  /// Rows that are missing: the bias wanders on, and nothing is seen of it.
  void pass(std::int64_t rows);

  [[nodiscard]] const BiasTracker& tracker() const { return tracker_; }

 private:
  BiasTracker tracker_;
  int rows_;
  int pushed_{};   ///< of this interval
  double sum_{};   ///< of its rates; NaN if one counts for nothing
  Estimate bias_;  ///< in this interval, foretold
};

}  // namespace gyrotherm::tracking
