// SPDX-License-Identifier: Apache-2.0
/// Detection of a small, lasting change in much larger noise: a cumulative sum over whitened vectors, one per second or
/// per cluster, and the alarm limit.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>

#include "core/result.hpp"

namespace gyrotherm::fusion {

/// Adds a vector to Crosier's sum, subtracts the slack, and returns the length of the sum before the subtraction.
inline double add_less_slack(Eigen::VectorXd& sum, const Eigen::Ref<const Eigen::VectorXd>& vector, double slack) {
  sum += vector;
  const double length = sum.norm();
  sum *= length > slack ? 1 - slack / length : 0;
  return length;
}

/// Returns the average run length: the mean number of steps until Crosier's multivariate cumulative sum of N(0, I)
/// vectors, which starts at 0, raises its first alarm. The dimension p, the slack k and the limit h must be above 0.
///
/// The direction of the sum is uniform and carries no information, so its length r is a Markov chain (Crosier,
/// Technometrics 30 (1988) 291): before the slack is subtracted, its square is noncentral χ²_p with λ = r². The run
/// length from r is L(r) = 1 + P(0 | r) L(0) + ∫₀ʰ f(x | r) L(x) dx, Page's integral equation (Biometrika 41 (1954)
/// 100), which is solved at the Gauss-Legendre nodes (Nyström's method). P(0 | r) is computed as 1 minus the alarm
/// probability minus the sum over the nodes. The alarm probability, on which the result depends most, is therefore
/// exact at each node. A rule with 24 nodes, plus three per unit of the limit, gives about eight digits for a run
/// length of a million steps.
[[nodiscard]] double average_run_length(int dimension, double slack, double limit);

/// Returns the limit with this average run length (above 1, at most 1e9), with a relative error of 1e-7, by false
/// position in the Illinois form (Dowell and Jarratt, BIT 11 (1971) 168) on the logarithm of the run length, which is
/// nearly linear. The limit is nearly 0 if the slack is so large that even the smallest limit gives this run length.
[[nodiscard]] double limit_for_run_length(int dimension, double slack, double run_length);

/// Smallest number of healthy vectors: ten hours of 100 s clusters.
inline constexpr Eigen::Index kFewestHealthy = 360;

/// Greatest learnt limit at the length of the record, as a multiple of the limit of white vectors.
inline constexpr double kMaxLimitFactor = 64;

/// Returns the limit at which the sum of ChangeDetector has this average run length for vectors like the healthy ones.
/// `healthy` has one column per vector in time order, all finite. The errors of a model are correlated over up to half
/// an hour, and small means add up during that time. This correlation, rather than the variance of single vectors,
/// makes alarms more frequent than with white vectors.
///
/// The run length is measured on sequences of one-hour blocks drawn from the record with a fixed seed (circular block
/// bootstrap, Politis and Romano, 1992). A record cannot show runs longer than itself. For longer runs the limit is
/// that of white vectors with a standard deviation s: s h(k/s), with h from limit_for_run_length(). s is chosen so that
/// this formula gives the limit measured at the record's own length.
///
/// The limit is never below that of white vectors. Returns no value for fewer than 360 vectors, or if a limit of
/// kMaxLimitFactor times that of white vectors is still too low: the vectors are then too strongly correlated, or their
/// mean exceeds the slack. `slack` and `run_length` are as for limit_for_run_length().
[[nodiscard]] std::optional<double> learn_sum_limit(const Eigen::Ref<const Eigen::MatrixXd>& healthy, double slack,
                                                    double run_length);

struct ChangeOptions {
  /// p, the number of components of a vector.
  int dimension{};
  /// Change that the sum is designed for: |f_i| b, in standard deviations of one step.
  double shift = 1;
  /// Rate of false alarms without a change.
  double false_alarms_per_h{};
  double interval_s = 1;  ///< length of a step
};

/// A detected change.
struct Change {
  /// Number of steps since the most likely start.
  int steps{};
  /// Mean of the vectors of these steps.
  Eigen::VectorXd mean;
  /// Returns √steps · mean for isolate(), which then returns √steps times the size of the fault. Its length does not
  /// have the distribution for an N(0, I) vector, because the start was chosen to maximise it.
  [[nodiscard]] Eigen::VectorXd root_sum() const { return std::sqrt(static_cast<double>(steps)) * mean; }
};

/// Crosier's multivariate cumulative sum (Technometrics 30 (1988) 291): S ← (S + x)(1 − k/|S + x|), or 0 if |S + x| is
/// at most k. An alarm occurs when |S| exceeds h; the sum then restarts. The slack k is half of the shift that the sum
/// is designed for. h is computed from the rate of false alarms by the exact run length of the chain, so false alarms
/// occur at the stated rate and not merely below a bound. A change is detected after about h/(shift − k) steps. Its
/// beginning is estimated from the last 8 h/k vectors: the most likely start maximises the square of their sum divided
/// by their number (Hinkley, Biometrika 57 (1970) 1); the sum itself does not help, since it is rarely 0 in more than
/// one dimension.
///
/// The vectors must be independent and N(0, I) while there is no change. Examples are parity vectors, and departures of
/// single seconds from which a known or tracked bias was subtracted (the innovations of tracking::BiasTracker are
/// white). learn_sum_limit() computes the limit for other vectors. A mean below the slack does not cause an alarm on
/// its own, but it makes false alarms more frequent.
class ChangeDetector {
 public:
  /// Fails with usage if a number is not above 0, or if false alarms are more than 1e9 or fewer than ten steps apart.
  [[nodiscard]] static Result<ChangeDetector> make(const ChangeOptions& options);

  /// Adds the next vector of p components to the sum; ignores a vector that is not finite. Returns a change if this
  /// vector causes an alarm.
  std::optional<Change> push(const Eigen::Ref<const Eigen::VectorXd>& vector);

  /// Returns a new detector with this limit, which must be above 0.
  [[nodiscard]] ChangeDetector with_limit(double limit) const { return {static_cast<int>(sum_.size()), slack_, limit}; }

  [[nodiscard]] double slack() const { return slack_; }
  [[nodiscard]] double limit() const { return limit_; }
  /// Returns |S| after the last vector.
  [[nodiscard]] double level() const { return sum_.norm(); }

 private:
  ChangeDetector(int dimension, double slack, double limit);
  [[nodiscard]] Change find_change() const;

  double slack_{}, limit_{};
  Eigen::VectorXd sum_;  ///< S
  /// Ring of the vectors since the last alarm, one column each.
  Eigen::MatrixXd recent_;
  Eigen::Index known_{};  ///< number of these vectors
};

}  // namespace gyrotherm::fusion
