#include "analysis/numerics/smo.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "analysis/numerics/lanes.hpp"

namespace gyrotherm {
namespace {

// Stands for a slope that no step may climb: β_i is at its bound, or i is padding.
constexpr float kWall = 1e30F;
constexpr float kLeastCurvature = 1e-12F;

struct Steepest {
  float slope;  // max u
  int index;
};

struct Partner {
  float least_slope;  // min v
  int index;
};

// g += step (up − down), and the largest u = −g − rise of the new g. `count` is a multiple of the lanes.
GYROTHERM_CLONES
void move(float* g, const float* up, const float* down, float step, const float* rise, int count, Steepest& steepest) {
  FloatLanes best = {};
  best -= kWall;
  IndexLanes where = {};
  IndexLanes at = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
  for (int i = 0; i < count; i += kFloatLanes) {
    auto& gradient = *reinterpret_cast<UnalignedFloatLanes*>(g + i);
    gradient += step * (*reinterpret_cast<const UnalignedFloatLanes*>(up + i) -
                        *reinterpret_cast<const UnalignedFloatLanes*>(down + i));
    const FloatLanes u = -gradient - *reinterpret_cast<const UnalignedFloatLanes*>(rise + i);
    const IndexLanes better = u > best;
    best = better ? u : best;
    where = better ? at : where;
    at += kFloatLanes;
  }
  steepest = {best[0], where[0]};
  for (int lane = 1; lane < kFloatLanes; ++lane) {
    if (best[lane] > steepest.slope) steepest = {best[lane], where[lane]};
  }
}

// The least v = −g − fall, and the j of the largest (u_i − v_j)²/(2 − 2K_ij) among the v_j below `u`; `row` is K_i.
// Quotients are compared crosswise, without a division.
GYROTHERM_CLONES
void choose_partner(const float* row, const float* g, const float* fall, float u, int count, Partner& partner) {
  FloatLanes least = {};
  least += kWall;
  FloatLanes best_square = {};
  FloatLanes best_curvature = {};
  best_curvature += 1.0F;
  IndexLanes where = {};
  IndexLanes at = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
  const FloatLanes zero = {};
  const FloatLanes flat = zero + kLeastCurvature;
  for (int i = 0; i < count; i += kFloatLanes) {
    const FloatLanes v =
        -*reinterpret_cast<const UnalignedFloatLanes*>(g + i) - *reinterpret_cast<const UnalignedFloatLanes*>(fall + i);
    least = v < least ? v : least;
    const FloatLanes exact = 2.0F - 2.0F * *reinterpret_cast<const UnalignedFloatLanes*>(row + i);
    const FloatLanes curvature = exact > flat ? exact : flat;
    const FloatLanes difference = u - v;
    const FloatLanes slack = difference > zero ? difference : zero;
    const FloatLanes square = slack * slack;
    const IndexLanes better = square * best_curvature > best_square * curvature;
    best_square = better ? square : best_square;
    best_curvature = better ? curvature : best_curvature;
    where = better ? at : where;
    at += kFloatLanes;
  }
  int best = 0;
  partner.least_slope = least[0];
  for (int lane = 1; lane < kFloatLanes; ++lane) {
    partner.least_slope = std::min(partner.least_slope, least[lane]);
    if (best_square[lane] * best_curvature[best] > best_square[best] * best_curvature[lane]) best = lane;
  }
  partner.index = where[best];
}

// How far β_i may rise and β_j fall together: the decrease per unit is `slack` at first, falls by `curvature`, and by
// 2ε where one of them passes zero.
double pair_step(double beta_i, double beta_j, double slack, double curvature, double C, double epsilon) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  const double room = std::min(C - beta_i, beta_j + C);
  std::array<double, 2> kinks = {beta_i < 0 ? -beta_i : kNever, beta_j > 0 ? beta_j : kNever};
  if (kinks[1] < kinks[0]) std::swap(kinks[0], kinks[1]);
  double step = 0;
  for (const double kink : kinks) {
    const double end = std::min(kink, room);
    if (step + slack / curvature <= end) return step + slack / curvature;
    slack -= (end - step) * curvature + 2 * epsilon;
    step = end;
    if (step == room || slack <= 0) return step;
  }
  return std::min(room, step + slack / curvature);
}

class Smo {
 public:
  explicit Smo(const SvrProblem& problem);
  SmoResult run(double tolerance, int max_iterations);

 private:
  [[nodiscard]] const float* row(int i) const { return rows_.col(i).data(); }
  void set(int i, double beta);
  void take_step(int i, int j);

  const SvrProblem& problem_;
  int stride_;            // n rounded up to whole lanes
  Eigen::MatrixXf rows_;  // K, a column per point, padded with zeros
  Eigen::VectorXd beta_;
  std::vector<float> g_;     // Kβ − y
  std::vector<float> rise_;  // slope of ε|β_i| upwards
  std::vector<float> fall_;  // and downwards
  Steepest steepest_{};
};

Smo::Smo(const SvrProblem& problem)
    : problem_(problem),
      stride_((static_cast<int>(problem.size()) + kFloatLanes - 1) / kFloatLanes * kFloatLanes),
      rows_(stride_, problem.size()),
      beta_(Eigen::VectorXd::Zero(problem.size())),
      g_(stride_),
      rise_(stride_, kWall),
      fall_(stride_, -kWall) {
  const int n = static_cast<int>(problem.size());
  for (int i = 0; i < n; ++i) {
    rows_.col(i).head(n) = problem.kernel.col(i).cast<float>();
    rows_.col(i).tail(stride_ - n).setZero();
    g_[i] = static_cast<float>(-problem.y[i]);
    set(i, 0);
  }
  move(g_.data(), row(0), row(0), 0, rise_.data(), stride_, steepest_);
}

void Smo::set(int i, double beta) {
  const auto epsilon = static_cast<float>(problem_.epsilon);
  beta_[i] = beta;
  rise_[i] = beta >= problem_.C ? kWall : beta >= 0 ? epsilon : -epsilon;
  fall_[i] = beta <= -problem_.C ? -kWall : beta > 0 ? epsilon : -epsilon;
}

void Smo::take_step(int i, int j) {
  const double slack = double{steepest_.slope} + double{g_[j]} + double{fall_[j]};
  const double curvature = std::max(2 - 2 * problem_.kernel(i, j), double{kLeastCurvature});
  const double step = pair_step(beta_[i], beta_[j], slack, curvature, problem_.C, problem_.epsilon);
  set(i, step == problem_.C - beta_[i] ? problem_.C : beta_[i] + step);
  set(j, step == beta_[j] + problem_.C ? -problem_.C : beta_[j] - step);
  move(g_.data(), row(i), row(j), static_cast<float>(step), rise_.data(), stride_, steepest_);
}

SmoResult Smo::run(double tolerance, int max_iterations) {
  SmoResult result;
  while (result.iterations < max_iterations) {
    Partner partner{};
    choose_partner(row(steepest_.index), g_.data(), fall_.data(), steepest_.slope, stride_, partner);
    result.converged = double{steepest_.slope} - double{partner.least_slope} <= tolerance;
    if (result.converged) break;
    take_step(steepest_.index, partner.index);
    ++result.iterations;
  }
  result.point.beta = std::move(beta_);
  result.point.b = best_offset(problem_, response(problem_, result.point.beta));
  return result;
}

}  // namespace

SmoResult solve_by_smo(const SvrProblem& problem, double tolerance, int max_iterations) {
  return Smo(problem).run(tolerance, max_iterations);
}

}  // namespace gyrotherm
