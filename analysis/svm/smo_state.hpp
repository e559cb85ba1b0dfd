/// The inner loop of sequential minimal optimisation, in single precision, over some or all points of a training set.
#pragma once

#include <algorithm>
#include <vector>

#include "analysis/svm/smo_direction.hpp"

namespace gyrotherm {

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

  /// Room for `count` points, each then to be placed.
  void resize(int count);
  /// `error` is h_i.
  void place(int i, double beta, float error);
  /// β_i alone; h stays.
  void set(int i, double beta);
  [[nodiscard]] int stride() const { return stride_; }
  [[nodiscard]] double beta(int i) const { return beta_[i]; }
  [[nodiscard]] const std::vector<double>& beta() const { return beta_; }
  [[nodiscard]] float error(int i) const { return h_[i]; }
  [[nodiscard]] float* errors() { return h_.data(); }
  [[nodiscard]] float u(int i) const { return h_[i] - rise_[i]; }
  [[nodiscard]] float v(int i) const { return h_[i] - fall_[i]; }

  /// Until the KKT violation is at most `tolerance`, or at most `fraction` of what it is at the start, or `most`
  /// iterations are done. `row_of(i)` gives K_i over these points, stride() floats. Working set: the most violating
  /// point i, and the j of the largest decrease to second order (Fan, Chen, Lin 2005). The step continues through the
  /// kinks of ε|β|.
  template <class RowOf>
  SmoRun run(RowOf row_of, double tolerance, double fraction, int most);

 private:
  struct Steepest {
    float slope;  // max u
    int index;
  };
  struct Partner {
    float least_slope;  // min v
    int index;
  };

  [[nodiscard]] Steepest steepest() const;
  [[nodiscard]] Partner partner_of(const Steepest& first, const float* row) const;
  [[nodiscard]] Steepest step(const Steepest& first, int second, const float* up, const float* down);
  [[nodiscard]] bool step_conjugately(const SmoPair& pair, float& moved, float& kept);
  [[nodiscard]] double step_alone(const SmoPair& pair);
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
  Steepest first = steepest();
  while (true) {
    const float* up = row_of(first.index);
    const Partner second = partner_of(first, up);
    run.violation = static_cast<double>(first.slope) - static_cast<double>(second.least_slope);
    if (run.iterations == 0) tolerance = std::max(tolerance, fraction * run.violation);
    if (run.violation <= tolerance || run.iterations >= most) return run;
    first = step(first, second.index, up, row_of(second.index));
    ++run.iterations;
  }
}

}  // namespace gyrotherm
