// SPDX-License-Identifier: Apache-2.0
/// Whether one of several candidates is at fault, and which: a generalised likelihood test. It is the same for axes
/// that contradict each other in motion, for axes at rest, for thermometers, and for all of them together; what differs
/// is the vector that is tested, and what a fault of each candidate does to it.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace gyrotherm::fusion {

/// A vector that is N(0, I) while nothing is at fault, and N(b f_i, I) if candidate i is, by an unknown amount b.
struct FaultTest {
  std::vector<std::string> candidates;
  Eigen::MatrixXd effects;  ///< f_i, a column per candidate: what its fault of one unit does to the vector
  [[nodiscard]] int freedom() const { return static_cast<int>(effects.rows()); }
};

struct TestOptions {
  double false_alarm_probability = 1e-6;  ///< of one test while nothing is at fault; above 0 and below 1
  /// By how much the best explanation must be ahead of the next before it is believed, in units of −2 ln likelihood: 6
  /// is a likelihood ratio of 20.
  double margin = 6;
};

/// What is said of the candidates of one vector.
struct Isolation {
  std::optional<Eigen::Index> candidate{};  ///< the one at fault, if one alone explains the vector and none rivals it
  Eigen::Index likeliest{};                 ///< the one whose fault explains most
  std::vector<Eigen::Index> rivals{};       ///< others within the margin of it, which the vector cannot tell from it
  double margin{};                          ///< from the likeliest to the next
  double size{}, size_std{};                ///< of its fault, in the candidate's unit
  double left{};                            ///< of the statistic, once its fault is admitted; χ² of one degree less
  bool explains{};                          ///< what is left is within the limit for it
};

/// What one vector comes to.
struct Finding {
  double statistic{};  ///< pᵀp
  double limit{};      ///< that it exceeds by chance with the false-alarm probability; infinite without freedom
  int freedom{};
  bool fault{};                          ///< the statistic is above the limit
  std::optional<Isolation> isolation{};  ///< of a fault, if any candidate's effect is not 0
};

/// Detection: pᵀp is χ² while nothing is at fault, with as many degrees of freedom as p has numbers (Sturza, Navigation
/// 35 (1988) 483). Isolation: a fault of candidate i takes (f_iᵀp)²/|f_i|² from the statistic, which is what the
/// likelihood ratio gains in −2 ln; the one that takes most is the likeliest (Daly, Gai and Harrison, J. Guidance and
/// Control 2 (1979) 9). Candidates with parallel effects take the same, and none of them is isolated: four axes have a
/// parity vector of one number, and detect but do not isolate. Without numbers there is no test, and no fault is found.
/// The vector is finite.
[[nodiscard]] Finding examine(const FaultTest& test, const Eigen::Ref<const Eigen::VectorXd>& vector,
                              const TestOptions& options = {});

/// Who it is, where something else has found that there is a fault, as a ChangeDetector does; empty if no candidate's
/// effect is seen.
[[nodiscard]] std::optional<Isolation> isolate(const FaultTest& test, const Eigen::Ref<const Eigen::VectorXd>& vector,
                                               const TestOptions& options = {});

/// The probability that a fault of this size is detected, in the candidate's unit: that noncentral χ² with λ = size²
/// |f_i|² exceeds the limit (Sturza's detector operating characteristic).
[[nodiscard]] double detection_probability(const FaultTest& test, Eigen::Index candidate, double size,
                                           double false_alarm_probability);

/// The size of a candidate's fault that is detected with this probability; infinite if the vector does not see it.
[[nodiscard]] double detectable_size(const FaultTest& test, Eigen::Index candidate, double probability,
                                     double false_alarm_probability);

}  // namespace gyrotherm::fusion
