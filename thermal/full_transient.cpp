#include "thermal/full_transient.hpp"

#include <cassert>

namespace gyrotherm {

FullTransient::FullTransient(const ThermalSystem& system, Eigen::VectorXd start_c, double tolerance)
    : system_(system),
      matrices_(system),
      tolerance_(tolerance),
      field_c_(std::move(start_c)),
      rate_c_per_s_(Eigen::VectorXd::Zero(field_c_.size())) {}

Result<void> FullTransient::set(double step_s, const ThermalCoefficients& c) {
  assert(step_s > 0);
  const bool same_step = solver_ && step_s == step_s_;
  step_s_ = step_s;
  film_ = c[static_cast<std::size_t>(ThermalCoefficient::film)];
  matrix_ = &matrices_.sum(1 / step_s, 0.5, c);
  if (same_step) return solver_->replace(*matrix_);
  auto solver = ConjugateGradients::set_up(*matrix_, {.tolerance = tolerance_});
  if (!solver) return failure(solver.error());
  solver_ = std::move(*solver);
  return {};
}

Eigen::VectorXd FullTransient::load(const ThermalInputValues& u) const {
  return system_.inputs * u + film_ * u[0] * system_.film_ambient;
}

Result<Eigen::VectorXd> FullTransient::solve(const Eigen::VectorXd& right, const Eigen::VectorXd& guess) {
  auto solution = solver_->solve(right, guess);
  if (!solution) return failure(solution.error());
  iterations_ += solution->iterations;
  return std::move(solution->x);
}

Result<void> FullTransient::step(const ThermalInputValues& from, const ThermalInputValues& to) {
  return step(from, to, step_s_ * rate_c_per_s_);
}

// With A = C/h + K/2 the step is A d = B ū − K T and T⁺ = T + d, and K T = 2 A T − 2 C T/h: the change is solved for,
// so that the tolerance counts against it and not against the level.
Result<void> FullTransient::step(const ThermalInputValues& from, const ThermalInputValues& to,
                                 const Eigen::VectorXd& guess_c) {
  assert(solver_);
  const Eigen::VectorXd stored = system_.capacity * field_c_;
  const Eigen::VectorXd right = load((from + to) / 2) - 2 * (*matrix_ * field_c_) + (2 / step_s_) * stored;
  const auto change = solve(right, guess_c);
  if (!change) return failure(change.error());
  field_c_ += *change;
  rate_c_per_s_ = *change / step_s_;
  return {};
}

Result<void> FullTransient::damped_step(const ThermalInputValues& from, const ThermalInputValues& to) {
  assert(solver_);
  for (const ThermalInputValues& u : {ThermalInputValues((from + to) / 2), to}) {
    const Eigen::VectorXd stored = system_.capacity * field_c_;
    // C/(h/2) + K = 2 A, so 2 A d = B u − K T.
    const Eigen::VectorXd right = load(u) / 2 - *matrix_ * field_c_ + stored / step_s_;
    const auto change = solve(right, Eigen::VectorXd::Zero(field_c_.size()));
    if (!change) return failure(change.error());
    field_c_ += *change;
    rate_c_per_s_ = *change / (step_s_ / 2);
  }
  return {};
}

}  // namespace gyrotherm
