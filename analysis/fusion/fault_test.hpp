// SPDX-License-Identifier: Apache-2.0
/// Detection and isolation of a fault among several candidates by a generalised likelihood test. The same test serves
/// for axes that contradict each other in motion, for axes at rest, for thermometers, and for all of them together;
/// only the tested vector and the effect of each candidate's fault on it differ.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace gyrotherm::fusion {

/// A vector that is N(0, I) without a fault, and N(b f_i, I) if candidate i has a fault of unknown size b.
struct FaultTest {
  std::vector<std::string> candidates;
  /// f_i, one column per candidate: the effect of a fault of one unit on the vector.
  Eigen::MatrixXd effects;
  [[nodiscard]] int degrees_of_freedom() const { return static_cast<int>(effects.rows()); }
};

struct TestOptions {
  /// Probability of a false alarm of one test, between 0 and 1.
  double false_alarm_probability = 1e-6;
  /// Margin by which the best explanation must exceed the next to be accepted, in units of −2 ln likelihood: 6 is a
  /// likelihood ratio of 20.
  double margin = 6;
};

/// Isolation of the faulty candidate by one vector.
struct Isolation {
  /// The faulty candidate, if its fault alone explains the vector and it has no rival.
  std::optional<Eigen::Index> candidate{};
  /// The candidate whose fault explains most of the statistic.
  Eigen::Index likeliest{};
  /// Other candidates within the margin, which the vector cannot distinguish from the likeliest one.
  std::vector<Eigen::Index> rivals{};
  /// Difference between the likeliest candidate and the next, in units of −2 ln likelihood.
  double margin{};
  /// Estimated size of the likeliest candidate's fault and its standard deviation, in the candidate's unit.
  double size{}, size_std{};
  /// Statistic that remains after fitting this fault; χ² with one fewer degree of freedom.
  double left{};
  /// Set if the remaining statistic is within its limit.
  bool explains{};
};

/// Result of the test of one vector.
struct Finding {
  double statistic{};  ///< pᵀp
  /// Limit that is exceeded by chance with the false-alarm probability; infinite without degrees of freedom.
  double limit{};
  int freedom{};
  /// True if the statistic exceeds the limit.
  bool fault{};
  /// Set for a fault, if any candidate has an effect.
  std::optional<Isolation> isolation{};
};

/// Tests a finite vector. Detection: without a fault pᵀp is χ² with as many degrees of freedom as p has components
/// (Sturza, Navigation 35 (1988) 483). Isolation: a fault of candidate i explains (f_iᵀp)²/|f_i|² of the statistic, the
/// gain of the likelihood ratio in −2 ln; the candidate that explains most is the likeliest (Daly, Gai and Harrison, J.
/// Guidance and Control 2 (1979) 9). Candidates with parallel effects explain the same part, and none of them is
/// isolated: four axes have a parity vector of one component and permit detection, but not isolation. For an empty
/// vector no test is possible, and no fault is reported.
[[nodiscard]] Finding examine(const FaultTest& test, const Eigen::Ref<const Eigen::VectorXd>& vector,
                              const TestOptions& options = {});

/// Isolates the faulty candidate of a fault that was detected by other means, such as a ChangeDetector. Returns no
/// value if no candidate has an effect.
[[nodiscard]] std::optional<Isolation> isolate(const FaultTest& test, const Eigen::Ref<const Eigen::VectorXd>& vector,
                                               const TestOptions& options = {});

/// Returns the probability that a fault of this size, in the candidate's unit, is detected: the probability that a
/// noncentral χ² variable with λ = size² |f_i|² exceeds the limit (Sturza's detector operating characteristic).
[[nodiscard]] double detection_probability(const FaultTest& test, Eigen::Index candidate, double size,
                                           double false_alarm_probability);

/// Returns the size of a candidate's fault that is detected with this probability; infinite if it has no effect on the
/// vector.
[[nodiscard]] double detectable_size(const FaultTest& test, Eigen::Index candidate, double probability,
                                     double false_alarm_probability);

}  // namespace gyrotherm::fusion
