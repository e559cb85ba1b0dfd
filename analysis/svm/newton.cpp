// SPDX-License-Identifier: Apache-2.0
#include "analysis/svm/newton.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "analysis/svm/cholesky.hpp"

namespace gyrotherm::svm {
namespace {

constexpr int kStepsPerCentre = 25;
constexpr int kLineSearchSteps = 12;
constexpr double kRetreatFactor = 0.2;  // factor of σ
// The proximal step is too long if this many of its Newton steps were shorter than kShortStep.
constexpr int kShortSteps = 5;
constexpr double kShortStep = 0.02;
// Tolerance, in C, for the agreement of β̃ and β(r). Rounding errors can move points back and forth between two pieces.
constexpr double kAgreement = 1e-10;

// Maximum number of further centres after the first centre that reached the required gap.
constexpr int kFurtherCentres = 2;

enum class Piece : signed char { at_lower, falling, zero, rising, at_upper };

bool is_on_slope(Piece piece) { return piece == Piece::falling || piece == Piece::rising; }

// Returns the growth factor of σ, which is larger after a proximal step with few Newton steps.
double growth(int steps) {
  if (steps <= 4) return 8;
  return steps <= 10 ? 2.8 : 1.3;
}

class Newton {
 public:
  Newton(const SvrProblem& problem, const Eigen::VectorXd& start, const NewtonOptions& options);
  NewtonResult run();

 private:
  // Returns β(r) for the present centre and weight.
  [[nodiscard]] Eigen::ArrayXd shrink(const Eigen::ArrayXd& residual) const;
  [[nodiscard]] Eigen::ArrayXd residual() const { return problem_.y - response_ - Eigen::VectorXd::Constant(n_, b_); }
  [[nodiscard]] Piece find_piece(Eigen::Index i, double residual) const;

  // Performs one proximal step. Returns false if σ should be reduced.
  bool minimise();
  bool solve_pieces(const Eigen::ArrayXd& residual);
  bool solve_slope(Eigen::VectorXd& moved);
  [[nodiscard]] double balanced_offset(const Eigen::VectorXd& moved) const;
  [[nodiscard]] double line_search() const;
  [[nodiscard]] bool is_settled(double step) const;
  void take_centre();
  void retreat();
  void keep_if_best();

  const SvrProblem& problem_;
  const NewtonOptions& options_;
  Eigen::Index n_;
  double sigma_;
  Eigen::VectorXd centre_;
  Eigen::VectorXd centre_response_;  // Kc
  // β̃. It differs from β(r) until the proximal step has converged.
  Eigen::VectorXd beta_;
  Eigen::VectorXd response_;  // Kβ̃
  double b_;
  Eigen::VectorXd direction_;           // direction of β̃
  Eigen::VectorXd response_direction_;  // K times direction_
  double b_direction_ = 0;
  std::vector<Piece> pieces_;
  std::vector<Eigen::Index> slope_;  // F
  // Memory for the equations of F.
  Eigen::MatrixXd system_;
  NewtonResult best_;
};

Newton::Newton(const SvrProblem& problem, const Eigen::VectorXd& start, const NewtonOptions& options)
    : problem_(problem),
      options_(options),
      n_(problem.size()),
      sigma_(options.first_weight * problem.C),
      centre_(start),
      centre_response_(problem.kernel.response(start)),
      beta_(start),
      response_(centre_response_),
      b_(best_offset(problem, response_)),
      pieces_(static_cast<std::size_t>(n_)),
      best_{{start, b_}, response_, certify(problem, {start, b_}, response_).relative_gap, 0} {}

Eigen::ArrayXd Newton::shrink(const Eigen::ArrayXd& residual) const {
  const double threshold = sigma_ * problem_.epsilon;
  const auto raw = centre_.array() + sigma_ * residual;
  return ((raw - threshold).max(0.0) + (raw + threshold).min(0.0)).max(-problem_.C).min(problem_.C);
}

Piece Newton::find_piece(Eigen::Index i, double residual) const {
  const double raw = centre_[i] + sigma_ * residual;
  const double excess = std::abs(raw) - sigma_ * problem_.epsilon;
  if (excess <= 0) return Piece::zero;
  if (excess >= problem_.C) return raw > 0 ? Piece::at_upper : Piece::at_lower;
  return raw > 0 ? Piece::rising : Piece::falling;
}

// Computes the Newton direction at the present point.
bool Newton::solve_pieces(const Eigen::ArrayXd& residual) {
  const Eigen::ArrayXd target = shrink(residual);
  slope_.clear();
  direction_ = target.matrix() - beta_;
  for (Eigen::Index i = 0; i < n_; ++i) {
    pieces_[i] = find_piece(i, residual[i]);
    if (!is_on_slope(pieces_[i])) continue;
    slope_.push_back(i);
    direction_[i] = 0;
  }
  response_direction_.setZero(n_);
  add_response(problem_, direction_, response_direction_);
  if (slope_.empty()) {
    b_direction_ = balanced_offset(response_ + response_direction_) - b_;
    return true;
  }
  Eigen::VectorXd on_slope_direction = Eigen::VectorXd::Zero(n_);
  if (!solve_slope(on_slope_direction)) return false;
  add_response(problem_, on_slope_direction, response_direction_);
  direction_ += on_slope_direction;
  return true;
}

// Solves the rows of F, (K_FF + I/σ)Δ + b1 = y − sε + (c − β̃)/σ − Kβ̃ and Σ(β̃ + Δ) = 0. In Kβ̃ and Σβ̃ all other
// points have already moved.
bool Newton::solve_slope(Eigen::VectorXd& moved) {
  const auto count = static_cast<Eigen::Index>(slope_.size());
  if (system_.rows() < count) system_.resize(count + count / 4, count + count / 4);
  auto system = system_.topLeftCorner(count, count);
  Eigen::MatrixXd sides(count, 2);
  for (Eigen::Index p = 0; p < count; ++p) {
    const Eigen::Index i = slope_[p];
    const double* column = problem_.kernel.column(i);
    for (Eigen::Index q = p; q < count; ++q) system(q, p) = column[slope_[q]];
    system(p, p) += 1 / sigma_;
    const double edge = pieces_[i] == Piece::rising ? problem_.epsilon : -problem_.epsilon;
    sides(p, 0) = problem_.y[i] - edge + (centre_[i] - beta_[i]) / sigma_ - response_[i] - response_direction_[i];
    sides(p, 1) = 1;
  }
  if (!factor_cholesky(system)) return false;
  solve_cholesky(system, sides);
  const double sum = beta_.sum() + direction_.sum();
  const double offset = (sides.col(0).sum() + sum) / sides.col(1).sum();
  b_direction_ = offset - b_;
  for (Eigen::Index p = 0; p < count; ++p) moved[slope_[p]] = sides(p, 0) - offset * sides(p, 1);
  return true;
}

// Finds b with Σβ_i(y − Kβ − b) = 0. Used if no β depends on b to first order.
double Newton::balanced_offset(const Eigen::VectorXd& moved) const {
  const Eigen::ArrayXd z = problem_.y - moved;
  const double reach = problem_.epsilon + 2 * problem_.C / sigma_;
  double low = z.minCoeff() - reach;
  double high = z.maxCoeff() + reach;
  for (;;) {
    const double middle = low + 0.5 * (high - low);
    if (!(low < middle && middle < high)) return middle;
    (shrink(z - middle).sum() > 0 ? low : high) = middle;
  }
}

// Returns a step along the direction at which the slope of Φ is small.
double Newton::line_search() const {
  const double linear = direction_.dot(response_);
  const double quadratic = direction_.dot(response_direction_);
  const Eigen::ArrayXd from = residual();
  const Eigen::ArrayXd change = -(response_direction_.array() + b_direction_);
  const auto slope = [&](double t) { return linear + quadratic * t + (shrink(from + t * change) * change).sum(); };
  const double first = std::abs(slope(0));
  if (slope(1) <= 0.5 * first) return 1;
  double low = 0;
  double high = 1;
  double step = 0.5;
  for (int i = 0; i < kLineSearchSteps; ++i) {
    step = 0.5 * (low + high);
    const double here = slope(step);
    if (std::abs(here) < 0.2 * first) break;
    (here > 0 ? high : low) = step;
  }
  return step;
}

// Returns whether a full step left every point on its piece, or β̃ and β(r) agree.
bool Newton::is_settled(double step) const {
  const Eigen::ArrayXd r = residual();
  bool same = step == 1;
  for (Eigen::Index i = 0; i < n_ && same; ++i) same = find_piece(i, r[i]) == pieces_[i];
  return same || (shrink(r) - beta_.array()).abs().maxCoeff() <= kAgreement * problem_.C;
}

bool Newton::minimise() {
  int short_steps = 0;
  for (int step = 0; step < kStepsPerCentre && best_.steps < options_.max_steps; ++step) {
    ++best_.steps;
    if (!solve_pieces(residual())) return false;
    const double t = line_search();
    beta_ += t * direction_;
    response_ += t * response_direction_;
    b_ += t * b_direction_;
    if (is_settled(t)) return true;
    short_steps += t < kShortStep;
    if (short_steps >= kShortSteps) return false;
  }
  return false;
}

// Makes the solution the new centre. Points on flat pieces get their exact values; the rounding error of the sum is
// spread over the other points.
void Newton::take_centre() {
  const Eigen::ArrayXd r = residual();
  const Eigen::ArrayXd shrunk = shrink(r);
  std::vector<Eigen::Index> free;
  for (Eigen::Index i = 0; i < n_; ++i) {
    const bool slope = is_on_slope(find_piece(i, r[i]));
    centre_[i] = slope ? std::clamp(beta_[i], -problem_.C, problem_.C) : shrunk[i];
    if (slope) free.push_back(i);
  }
  spread_sum(problem_, free, centre_);
  add_response(problem_, centre_ - beta_, response_);
  beta_ = centre_;
  centre_response_ = response_;
}

// Returns to the centre for a shorter step.
void Newton::retreat() {
  beta_ = centre_;
  response_ = centre_response_;
  b_ = best_offset(problem_, response_);
  sigma_ *= kRetreatFactor;
}

// Keeps the present centre if it is the best so far. If it reaches the required gap, recomputes the gap from a response
// computed from scratch.
void Newton::keep_if_best() {
  SvrPoint point{centre_, best_offset(problem_, response_)};
  double gap = certify(problem_, point, response_).relative_gap;
  if (gap <= options_.relative_gap) {
    response_ = problem_.kernel.response(centre_);
    centre_response_ = response_;
    point.b = best_offset(problem_, response_);
    gap = certify(problem_, point, response_).relative_gap;
  }
  if (!(gap < best_.relative_gap)) return;
  best_.point = std::move(point);
  best_.response = response_;
  best_.relative_gap = gap;
}

NewtonResult Newton::run() {
  const auto reaches = [this](double gap) { return best_.relative_gap <= gap; };
  const double requested = options_.relative_gap;
  const double aim = reaches(requested) ? requested : std::min(options_.aim, requested);
  for (int further = kFurtherCentres; !reaches(aim) && best_.steps < options_.max_steps;) {
    if (reaches(requested) && further-- == 0) break;
    const int before = best_.steps;
    if (!minimise()) {
      retreat();
      continue;
    }
    take_centre();
    keep_if_best();
    sigma_ *= growth(best_.steps - before);
  }
  return std::move(best_);
}

}  // namespace

NewtonResult solve_by_newton(const SvrProblem& problem, const Eigen::VectorXd& start, const NewtonOptions& options) {
  return Newton(problem, start, options).run();
}

}  // namespace gyrotherm::svm
