// SPDX-License-Identifier: Apache-2.0
/// Finds a small change that lasts amid much larger noise: a cumulative sum over whitened vectors, one per second or
/// per cluster, and the limit above which it alarms.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>

#include "core/result.hpp"

namespace gyrotherm::fusion {

/// Adds a vector to Crosier's sum, less the slack, and returns the length of the sum before the slack was taken.
inline double add_less_slack(Eigen::VectorXd& sum, const Eigen::Ref<const Eigen::VectorXd>& vector, double slack) {
  sum += vector;
  const double length = sum.norm();
  sum *= length > slack ? 1 - slack / length : 0;
  return length;
}

/// Returns the average run length, in steps, of Crosier's multivariate cumulative sum of vectors that are N(0, I), from
/// 0 to its first alarm: with dimension p, slack k and limit h, all above 0.
///
/// The direction of the sum is uniform and tells nothing, so its length r is a Markov chain (Crosier, Technometrics 30
/// (1988) 291): before the slack is taken its square is noncentral χ²_p with λ = r². From r the run length is L(r) = 1
/// + P(0 | r) L(0) + ∫₀ʰ f(x | r) L(x) dx, Page's integral equation (Biometrika 41 (1954) 100), which is solved at the
/// nodes of Gauss and Legendre (Nyström's method). P(0 | r) is taken as what alarms and the nodes' own sum leave, so
/// that the probability of an alarm, on which all depends, is exact at each node. Three nodes a step and 24 more are
/// enough for some eight digits of a run of a million steps.
[[nodiscard]] double average_run_length(int dimension, double slack, double limit);

/// Returns the limit with this average run length, which is above 1 and at most 1e9, to 1e-7 of it, by false position
/// in the Illinois form (Dowell and Jarratt, BIT 11 (1971) 168) on the logarithm of the run length, which is nearly
/// straight. It is nearly 0 where the slack alone makes runs that long.
[[nodiscard]] double limit_for_run_length(int dimension, double slack, double run_length);

inline constexpr Eigen::Index kFewestHealthy = 360;  ///< vectors: ten hours of 100 s

/// Returns the limit at which the sum of ChangeDetector has this average run length over vectors like the healthy ones,
/// a column each in the order of time, all finite. A model's error lasts for up to half an hour, in which small means
/// add up: this, and not the variance of single vectors, is what makes alarms more frequent than those of white ones.
///
/// The run length is that of blocks of an hour drawn from the record with a fixed seed (circular block bootstrap,
/// Politis and Romano, 1992). A record cannot show runs that are longer than itself. Beyond its own length the limit is
/// that of white vectors with the one standard deviation s that explains the limit found at its own length: s h(k/s), h
/// by limit_for_run_length().
///
/// It is never below the limit of white vectors. Returns nothing for fewer than 360 vectors. `slack` and `run_length`
/// as limit_for_run_length() takes them.
[[nodiscard]] std::optional<double> limit_of_healthy(const Eigen::Ref<const Eigen::MatrixXd>& healthy, double slack,
                                                     double run_length);

struct ChangeOptions {
  int dimension{};              ///< p, numbers in a vector
  double shift = 1;             ///< what it is made for: |f_i| b, in standard deviations of one step
  double false_alarms_per_h{};  ///< that chance makes, while nothing changes
  double interval_s = 1;        ///< of a step
};

/// What an alarm says.
struct Change {
  int steps{};           ///< since the likeliest start of the change
  Eigen::VectorXd mean;  ///< of the vectors since then
  /// √steps · mean: isolate() says whose direction it is, and a size that is √steps times the fault's. Its length is
  /// not that of N(0, I), since the start was chosen by it.
  [[nodiscard]] Eigen::VectorXd root_sum() const { return std::sqrt(static_cast<double>(steps)) * mean; }
};

/// Crosier's multivariate cumulative sum (Technometrics 30 (1988) 291): S ← (S + x)(1 − k/|S + x|), or 0 where |S + x|
/// is at most k; an alarm when |S| exceeds h, upon which it begins anew. The slack k is half of the shift it is made
/// for, h follows from the false alarms by the exact run length of the chain: they come at the stated
/// rate, not below a bound. A change is found after some h/(shift − k) steps. When it began is asked of the last 8 h/k
/// vectors: the start from which the square of their sum over their number is greatest is the likeliest (Hinkley,
/// Biometrika 57 (1970) 1); the sum itself is no help, for in more than one dimension it is seldom 0.
///
/// The vectors must be N(0, I) and independent while nothing changes: parity or departures of single seconds, less a
/// bias that is known or tracked (the innovations of tracking::BiasTracker are white). limit_of_healthy() has
/// the limit for vectors that are not. A mean that stands off 0 by less than the slack does not add up to an alarm, but
/// makes alarms more frequent.
class ChangeDetector {
 public:
  /// Fails with usage if a number is not above 0, or false alarms are further apart than 1e9 steps or follow each other
  /// within ten.
  [[nodiscard]] static Result<ChangeDetector> make(const ChangeOptions& options);

  /// The next vector, of p numbers; one that is not finite passes unseen. A change if this one brings an alarm.
  std::optional<Change> push(const Eigen::Ref<const Eigen::VectorXd>& vector);

  /// Returns a detector that begins with nothing seen and alarms above this limit, which is above 0.
  [[nodiscard]] ChangeDetector with_limit(double limit) const { return {static_cast<int>(sum_.size()), slack_, limit}; }

  [[nodiscard]] double slack() const { return slack_; }
  [[nodiscard]] double limit() const { return limit_; }
  /// |S|, after the vector pushed last.
  [[nodiscard]] double level() const { return sum_.norm(); }

 private:
  ChangeDetector(int dimension, double slack, double limit);
  [[nodiscard]] Change since_likeliest_start() const;

  double slack_{}, limit_{};
  Eigen::VectorXd sum_;     ///< S
  Eigen::MatrixXd recent_;  ///< a ring of the vectors since the last alarm, a column each
  Eigen::Index known_{};    ///< how many there were
};

}  // namespace gyrotherm::fusion
