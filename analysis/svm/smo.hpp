// SPDX-License-Identifier: Apache-2.0
/// Sequential minimal optimisation in n variables, which moves two of them at a time. It solves easy problems quickly
/// and provides a good start for hard ones. It uses a kernel in single precision, so its result must be certified
/// separately.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "analysis/svm/svr_problem.hpp"

namespace gyrotherm::svm {

/// Points i and j of a pair: β_i rises, β_j falls.
struct SmoPair {
  int i{};
  int j{};
  /// Initial decrease of the dual per unit of step, and its reduction per unit.
  double slack{};
  double curvature{};
};

/// Point with the largest u.
struct SmoSteepest {
  float slope;  ///< max u
  int index;
};

/// Point that moves together with the point of largest u.
struct SmoPartner {
  /// Minimum of v over all points. It may belong to a point other than `index`.
  float least_slope;
  int index;
};

/// Step along the direction of the pair plus `kept` times the direction of the previous step.
struct SmoStep {
  float length{};
  float kept{};
};

/// Direction d of the last steps, as a sum of pair directions e_i − e_j. Stores the few points that moved and the range
/// of each. The range of a point ends at its bound and at zero, because the dual is quadratic only between them.
class SmoDirection {
 public:
  static constexpr int kMostSteps = 5;
  /// Number of entries, at least two for the start and two for each further step.
  static constexpr int kEntries = 16;
  static_assert(2 * (kMostSteps + 1) <= kEntries);

  struct Point {
    int index;
    double beta;
    /// Range of β.
    double low;
    double high;
  };
  struct Length {
    double units;
    /// Entry of the point that limits the length by reaching the end of its range, or −1.
    int stopped_by;
  };

  void clear();
  [[nodiscard]] bool empty() const { return count_ == 0; }
  [[nodiscard]] bool is_full() const { return steps_ >= kMostSteps; }
  /// Sets d to e_i − e_j.
  void start(const Point& i, const Point& j);
  /// Sets d to e_i − e_j + kept d.
  void set_direction(const Point& i, const Point& j, double kept);
  /// Returns the distance that the points can move along d, at most `units`.
  [[nodiscard]] Length reach(double units) const;
  /// Moves β by the distance `length` along the direction d.
  void move(const Length& length);

  [[nodiscard]] int count() const { return count_; }
  [[nodiscard]] int index(int entry) const { return index_[entry]; }
  [[nodiscard]] double beta(int entry) const { return beta_[entry]; }

 private:
  [[nodiscard]] int find_entry(const Point& point);

  int count_ = 0;
  int steps_ = 0;
  std::array<int, kEntries> index_{};
  // Entries above count_ are zero.
  std::array<double, kEntries> part_{};
  std::array<double, kEntries> beta_{};
  std::array<double, kEntries> low_{};
  std::array<double, kEntries> high_{};
};

/// Result of a run.
struct SmoRun {
  int iterations{};
  /// KKT violation max u − min v at the end.
  double violation{};
};

/// Points from which SMO chooses two at a time. With h = y − Kβ, u_i = h_i − rise_i is the gain per unit if β_i rises,
/// and v_i = h_i − fall_i the loss per unit if it falls. rise_i and fall_i are the slopes of ε|β_i|; at a bound one of
/// them is so large that β_i cannot cross it. Arrays are padded to whole lanes with points that cannot move.
///
/// A step follows the direction of the pair, made conjugate to the previous step (Torres-Barrán, Alaíz, Dorronsoro,
/// "Faster SVM training via conjugate SMO", Pattern Recognition 2021). This reduces the number of steps by about 40 %.
/// The first step after a point reaches a bound or zero is not conjugate, nor is the first after kMostSteps steps,
/// because longer sequences cost more than they gain.
class SmoState {
 public:
  SmoState(double C, double epsilon) : C_(C), epsilon_(epsilon) {}

  /// Allocates `count` points. Each must then be set by set_point().
  void resize(int count);
  /// Initialises point i. `error` is h_i.
  void set_point(int i, double beta, float error);
  /// Sets β_i without updating h.
  void set(int i, double beta);
  [[nodiscard]] int stride() const { return stride_; }
  [[nodiscard]] double beta(int i) const { return beta_[i]; }
  [[nodiscard]] const std::vector<double>& beta() const { return beta_; }
  [[nodiscard]] float error(int i) const { return h_[i]; }
  [[nodiscard]] float* errors() { return h_.data(); }
  [[nodiscard]] float u(int i) const { return h_[i] - rise_[i]; }
  [[nodiscard]] float v(int i) const { return h_[i] - fall_[i]; }

  /// Optimises until the KKT violation is at most `tolerance`, or at most `fraction` of its initial value, or until
  /// `most` iterations are done. `kernel_row(i)` returns K_i over these points, stride() floats. The working set is the
  /// most violating point i and the point j with the largest second-order decrease (Fan, Chen, Lin 2005). The step
  /// continues through the kinks of ε|β|.
  template <class KernelRow>
  SmoRun run(KernelRow kernel_row, double tolerance, double fraction, int most);

 private:
  [[nodiscard]] SmoSteepest steepest() const;
  [[nodiscard]] SmoPartner find_partner(const SmoSteepest& first, const float* row) const;
  [[nodiscard]] SmoSteepest step(const SmoSteepest& first, int second, const float* up, const float* down);
  [[nodiscard]] std::optional<SmoStep> step_conjugately(const SmoPair& pair);
  [[nodiscard]] SmoStep step_alone(const SmoPair& pair);
  [[nodiscard]] SmoDirection::Point point(int i, bool rising) const;

  double C_;
  double epsilon_;
  int stride_ = 0;
  std::vector<float> h_;
  std::vector<float> rise_;
  std::vector<float> fall_;
  std::vector<double> beta_;
  SmoDirection direction_;       // d of the last step
  std::vector<float> response_;  // Kd
  double curvature_ = 0;         // dᵀKd
};

template <class KernelRow>
SmoRun SmoState::run(KernelRow kernel_row, double tolerance, double fraction, int most) {
  SmoRun run;
  direction_.clear();
  SmoSteepest first = steepest();
  while (true) {
    const float* up = kernel_row(first.index);
    const SmoPartner second = find_partner(first, up);
    run.violation = static_cast<double>(first.slope) - static_cast<double>(second.least_slope);
    if (run.iterations == 0) tolerance = std::max(tolerance, fraction * run.violation);
    if (run.violation <= tolerance || run.iterations >= most) return run;
    first = step(first, second.index, up, kernel_row(second.index));
    ++run.iterations;
  }
}

/// Minimises the dual from the feasible `start`, or from β = 0, until the KKT violation is at most `tolerance` or
/// `most` iterations are done.
///
/// A small problem (n ≤ 640 points) uses all points in every iteration. A larger problem does so for at most n
/// iterations, or for none if there is a start. It then continues in working sets whose rows fit in a second-level
/// cache, which makes an iteration much cheaper. Each working set contains the most violating points and the free
/// points of the previous set. The points of a set are optimised; then the gradient of all points is updated. The
/// optimisation ends early after 4n iterations if few points are free, because a Newton step of the caller is then
/// cheap.
[[nodiscard]] Eigen::VectorXd solve_by_smo(const SvrProblem& problem, double tolerance, int most,
                                           const Eigen::VectorXd* start = nullptr);

}  // namespace gyrotherm::svm
