// SPDX-License-Identifier: Apache-2.0
/// Sequential minimal optimisation in n variables: two of them move at a time. Fast on easy trainings, and a good start
/// of the hard ones. Works on a kernel in single precision, so its result is to be certified by others.
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
  double slack{};      ///< decrease of the dual per unit, at first
  double curvature{};  ///< by which that falls, per unit
};

/// The point whose u is largest.
struct SmoSteepest {
  float slope;  ///< max u
  int index;
};

/// The point that moves with the steepest one.
struct SmoPartner {
  float least_slope;  ///< min v of all points, not of this one
  int index;
};

/// A step along the pair's direction plus `kept` times the direction of the step before.
struct SmoStep {
  float length{};
  float kept{};
};

/// The direction d in which the last steps went, as a sum of pairs' directions e_i − e_j: the few points that moved,
/// and how far each may go on. Each point that is part of it stays on its side of zero and in its bounds: there the
/// dual is quadratic.
class SmoDirection {
 public:
  static constexpr int kMostSteps = 5;
  static constexpr int kPlaces = 16;  ///< at least two for each step and the first
  static_assert(2 * (kMostSteps + 1) <= kPlaces);

  struct Point {
    int index;
    double beta;
    double low;  ///< β may go from low to high
    double high;
  };
  struct Length {
    double units;
    int stopped_by;  ///< the place of the point that meets an end, or −1
  };

  void clear();
  [[nodiscard]] bool empty() const { return count_ == 0; }
  [[nodiscard]] bool full() const { return steps_ >= kMostSteps; }
  /// d becomes e_i − e_j alone.
  void start(const Point& i, const Point& j);
  /// d becomes e_i − e_j + kept d.
  void turn(const Point& i, const Point& j, double kept);
  /// How far the points can go along d, at most `units`.
  [[nodiscard]] Length reach(double units) const;
  /// Moves the points along d.
  void move(const Length& length);

  [[nodiscard]] int count() const { return count_; }
  [[nodiscard]] int index(int place) const { return index_[place]; }
  [[nodiscard]] double beta(int place) const { return beta_[place]; }

 private:
  [[nodiscard]] int place_of(const Point& point);

  int count_ = 0;
  int steps_ = 0;
  std::array<int, kPlaces> index_{};
  // Beyond count_: zeros.
  std::array<double, kPlaces> part_{};
  std::array<double, kPlaces> beta_{};
  std::array<double, kPlaces> low_{};
  std::array<double, kPlaces> high_{};
};

/// How a run ended.
struct SmoRun {
  int iterations{};
  double violation{};  ///< max u − min v at the end
};

/// Points of which two are chosen at a time to move. With h = y − Kβ, u_i = h_i − rise_i is what β_i gains by rising
/// and v_i = h_i − fall_i what it loses by falling; rise and fall are the slopes of ε|β_i|, and walls at the bounds.
/// Arrays are padded to whole lanes with points that cannot move.
///
/// A step goes along the pair's own direction made conjugate to the step before it (Torres-Barrán, Alaíz, Dorronsoro,
/// "Faster SVM training via conjugate SMO", Pattern Recognition 2021), which takes some 0.6 times the steps. Conjugacy
/// starts afresh where a point meets a bound or zero, and after a few steps: later it costs more than it gains.
class SmoState {
 public:
  SmoState(double C, double epsilon) : C_(C), epsilon_(epsilon) {}

  /// Makes room for `count` points, each then to be placed.
  void resize(int count);
  /// Places point i; `error` is h_i.
  void place(int i, double beta, float error);
  /// Sets β_i alone; h stays.
  void set(int i, double beta);
  [[nodiscard]] int stride() const { return stride_; }
  [[nodiscard]] double beta(int i) const { return beta_[i]; }
  [[nodiscard]] const std::vector<double>& beta() const { return beta_; }
  [[nodiscard]] float error(int i) const { return h_[i]; }
  [[nodiscard]] float* errors() { return h_.data(); }
  [[nodiscard]] float u(int i) const { return h_[i] - rise_[i]; }
  [[nodiscard]] float v(int i) const { return h_[i] - fall_[i]; }

  /// Optimises until the KKT violation is at most `tolerance`, or at most `fraction` of what it is at the start, or
  /// `most` iterations are done. `row_of(i)` gives K_i over these points, stride() floats. Working set: the most
  /// violating point i, and the j of the largest decrease to second order (Fan, Chen, Lin 2005). The step continues
  /// through the kinks of ε|β|.
  template <class RowOf>
  SmoRun run(RowOf row_of, double tolerance, double fraction, int most);

 private:
  [[nodiscard]] SmoSteepest steepest() const;
  [[nodiscard]] SmoPartner partner_of(const SmoSteepest& first, const float* row) const;
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
  SmoDirection direction_;       // d, of the last step
  std::vector<float> response_;  // Kd
  double curvature_ = 0;         // dᵀKd
};

template <class RowOf>
SmoRun SmoState::run(RowOf row_of, double tolerance, double fraction, int most) {
  SmoRun run;
  direction_.clear();
  SmoSteepest first = steepest();
  while (true) {
    const float* up = row_of(first.index);
    const SmoPartner second = partner_of(first, up);
    run.violation = static_cast<double>(first.slope) - static_cast<double>(second.least_slope);
    if (run.iterations == 0) tolerance = std::max(tolerance, fraction * run.violation);
    if (run.violation <= tolerance || run.iterations >= most) return run;
    first = step(first, second.index, up, row_of(second.index));
    ++run.iterations;
  }
}

/// Starts at `start`, which is feasible, or at β = 0, and stops once the KKT violation is at most `tolerance`, or after
/// `most` iterations.
///
/// All points take part at first if it starts at 0. A training that needs more than n iterations goes on in working
/// sets whose rows fit a second-level cache, where an iteration costs a fraction: each time the most violating points
/// and those of the last set that are free are optimised among themselves, and then the gradient of all points follows.
/// It stops sooner where few points are free, for a Newton step is cheap then.
[[nodiscard]] Eigen::VectorXd solve_by_smo(const SvrProblem& problem, double tolerance, int most,
                                           const Eigen::VectorXd* start = nullptr);

}  // namespace gyrotherm::svm
