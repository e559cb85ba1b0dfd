// SPDX-License-Identifier: Apache-2.0
/// A small change that lasts, found amid noise much larger than it: a cumulative sum over whitened vectors, a second or
/// a cluster each.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>

#include "core/result.hpp"

namespace gyrotherm::fusion {

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

/// Adds a vector to Crosier's sum, less the slack, and returns the length of the sum before the slack was taken.
inline double add_less_slack(Eigen::VectorXd& sum, const Eigen::Ref<const Eigen::VectorXd>& vector, double slack) {
  sum += vector;
  const double length = sum.norm();
  sum *= length > slack ? 1 - slack / length : 0;
  return length;
}

/// Crosier's multivariate cumulative sum (Technometrics 30 (1988) 291): S ← (S + x)(1 − k/|S + x|), or 0 where |S + x|
/// is at most k; an alarm when |S| exceeds h, upon which it begins anew. The slack k is half of the shift it is made
/// for, h follows from the false alarms by the exact run length of the chain (run_length.hpp): they come at the stated
/// rate, not below a bound. A change is found after some h/(shift − k) steps. When it began is asked of the last 8 h/k
/// vectors: the start from which the square of their sum over their number is greatest is the likeliest (Hinkley,
/// Biometrika 57 (1970) 1); the sum itself is no help, for in more than one dimension it is seldom 0.
///
/// The vectors must be N(0, I) and independent while nothing changes: parity or departures of single seconds, less a
/// bias that is known or tracked (the innovations of tracking::BiasTracker are white). learnt_limit.hpp has the limit
/// for vectors that are not. A mean that stands off 0 by less than the slack does not add up to an alarm, but makes
/// alarms more frequent.
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
