/// The inner loop of sequential minimal optimisation, in single precision, over some or all points of a training set.
#pragma once

#include <algorithm>
#include <vector>

namespace gyrotherm {

struct SmoRun {
  int iterations{};
  double violation{};  ///< max u − min v at the end
};

/// Points that move two at a time, all others standing still. With g = Kβ − y, u_i = −g_i − rise_i is what β_i gains by
/// rising and v_i = −g_i − fall_i what it loses by falling; rise and fall are the slopes of ε|β_i|, and walls at the
/// bounds. Arrays are padded to whole lanes with points that cannot move.
class SmoState {
 public:
  SmoState(double C, double epsilon) : C_(C), epsilon_(epsilon) {}

  /// Room for `count` points, each then to be placed.
  void resize(int count);
  void place(int i, double beta, float gradient);
  /// β_i alone; the gradients stay.
  void set(int i, double beta);
  [[nodiscard]] int stride() const { return stride_; }
  [[nodiscard]] double beta(int i) const { return beta_[i]; }
  [[nodiscard]] const std::vector<double>& beta() const { return beta_; }
  [[nodiscard]] float gradient(int i) const { return g_[i]; }
  [[nodiscard]] float* gradients() { return g_.data(); }
  [[nodiscard]] float u(int i) const { return -g_[i] - rise_[i]; }
  [[nodiscard]] float v(int i) const { return -g_[i] - fall_[i]; }

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

  double C_;
  double epsilon_;
  int stride_ = 0;
  std::vector<float> g_;
  std::vector<float> rise_;
  std::vector<float> fall_;
  std::vector<double> beta_;
};

template <class RowOf>
SmoRun SmoState::run(RowOf row_of, double tolerance, double fraction, int most) {
  SmoRun run;
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
