// SPDX-License-Identifier: Apache-2.0
#include "simulator/thermal/model_order_reduction_error.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cassert>
#include <vector>

namespace gyrotherm::thermal {
namespace {

constexpr double kStart_c = 20;
// Tolerance relative to the change in a step. It is small because the errors of a thousand steps add up.
constexpr double kTolerance = 1e-7;

struct Knot {
  double at_s;
  double air_c;
};

constexpr std::array<Knot, 5> kRamps{{{0, 20}, {480, 60}, {2280, 60}, {8280, -40}, {9480, -40}}};
constexpr double kSwitchOn_s = 3600;
constexpr double kLongest_s = 120;

struct Step {
  double length_s;
  ThermalInputValues from, to;
};

/// Appends steps from one corner to the next: short ones first, three times as long after every six.
void append_steps(std::vector<Step>& steps, double seconds, double shortest_s, const ThermalInputValues& from,
                  const ThermalInputValues& to) {
  constexpr int kStepsPerLength = 6;
  constexpr double kLengthFactor = 3;
  double gone_s = 0;
  double length_s = shortest_s;
  for (int i = 1; gone_s < seconds; ++i) {
    const double step_s = std::min(length_s, seconds - gone_s);
    steps.push_back(
        {step_s, from + (to - from) * (gone_s / seconds), from + (to - from) * ((gone_s + step_s) / seconds)});
    gone_s += step_s;
    if (i % kStepsPerLength == 0) length_s = std::min(kLengthFactor * length_s, kLongest_s);
  }
}

std::vector<Step> ramps(const ReducedModel& model, double shortest_s) {
  std::vector<Step> steps;
  for (std::size_t i = 1; i < kRamps.size(); ++i)
    append_steps(steps, kRamps[i].at_s - kRamps[i - 1].at_s, shortest_s, operating_inputs(model, kRamps[i - 1].air_c),
                 operating_inputs(model, kRamps[i].air_c));
  return steps;
}

/// Integrates the reduced model by the same rule as FullTransient.
class SmallTransient final {
 public:
  SmallTransient(const ReducedModel& model, const ThermalCoefficients& c, Eigen::VectorXd start)
      : conduction_(conduction_at(model, c)), inputs_(inputs_at(model, c)), states_(std::move(start)) {}

  void set(double step_s) {
    Eigen::MatrixXd matrix = conduction_ / 2;
    matrix.diagonal().array() += 1 / step_s;
    factor_.compute(matrix);
  }
  void step(const ThermalInputValues& from, const ThermalInputValues& to) {
    change_ = factor_.solve(inputs_ * ((from + to) / 2) - conduction_ * states_);
    states_ += change_;
  }
  void damped_step(const ThermalInputValues& from, const ThermalInputValues& to) {
    for (const ThermalInputValues& u : {ThermalInputValues((from + to) / 2), to})
      states_ += factor_.solve((inputs_ * u - conduction_ * states_) / 2);
  }
  [[nodiscard]] const Eigen::VectorXd& states() const { return states_; }
  [[nodiscard]] const Eigen::VectorXd& change() const { return change_; }

 private:
  Eigen::MatrixXd conduction_, inputs_;
  Eigen::LDLT<Eigen::MatrixXd> factor_;
  Eigen::VectorXd states_, change_;
};

/// A program that both models run. They start at the same temperature.
struct ErrorProgram {
  std::string_view stage;
  std::vector<Step> steps;
};

/// Returns the largest difference over A…H after any step.
Result<double> measure_error(const ErrorProgram& trial, const ThermalSystem& system, const ReducedSystem& reduced,
                             const ThermalCoefficients& c, Eigen::VectorXd full_start, Eigen::VectorXd small_start,
                             const ProgressSink& progress) {
  FullTransient full(system, std::move(full_start), kTolerance);
  SmallTransient small(reduced.model, c, std::move(small_start));
  double error_k = 0;
  double length_s = 0;
  for (std::size_t i = 0; i < trial.steps.size(); ++i) {
    const auto& step = trial.steps[i];
    if (!should_continue(progress, trial.stage, static_cast<double>(i) / static_cast<double>(trial.steps.size())))
      return failure(FaultKind::interrupted, "reduction", fmt::format("stopped in {}", trial.stage));
    const bool damped = step.length_s != length_s;
    if (damped) {
      length_s = step.length_s;
      if (const auto ready = full.set(length_s, c); !ready) return failure(ready.error());
      small.set(length_s);
    }
    if (damped)
      small.damped_step(step.from, step.to);
    else
      small.step(step.from, step.to);
    // Start from the reduced model's change. The solver then only corrects the error of that change.
    const auto done =
        damped ? full.damped_step(step.from, step.to) : full.step(step.from, step.to, reduced.basis * small.change());
    if (!done) return failure(done.error());
    const Eigen::VectorXd apart_k = full.outputs_c() - reduced.model.outputs * small.states();
    error_k = std::max(error_k, apart_k.head<8>().cwiseAbs().maxCoeff());
  }
  return error_k;
}

/// Returns the full model's field at rest. The ambient contributes a constant field.
Result<Eigen::VectorXd> full_steady_state(const ThermalSystem& system, const ThermalCoefficients& c,
                                          const ThermalInputValues& u, const SolveColumns& solve) {
  // Each round adds as many correct digits as kSolveTolerance has.
  constexpr int kRounds = 3;
  AffineMatrix matrices(system);
  const auto& matrix = matrices.sum(0, 1, c);
  ThermalInputValues powers = u;
  powers[0] = 0;
  const Eigen::VectorXd load = system.inputs * powers;
  Eigen::VectorXd above = Eigen::VectorXd::Zero(load.size());
  for (int round = 0; round < kRounds; ++round) {
    const auto missing = solve(matrix, load - matrix * above);
    if (!missing) return failure(missing.error());
    above += missing->col(0);
  }
  return Eigen::VectorXd(above.array() + u[0]);
}

}  // namespace

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
  auto solver = ConjugateGradients::create(*matrix_, {.tolerance = tolerance_});
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

// Let A = C/h + K/2. The step is A d = B ū − K T and T⁺ = T + d, and K T = 2 A T − 2 C T/h. The change d is solved for,
// so the tolerance applies to the change and not to the level.
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

Result<ReductionError> measure(const ThermalSystem& system, const ReducedSystem& reduced, const ReductionTrial& trial,
                               const SolveColumns& solve, const ProgressSink& progress) {
  const auto& model = reduced.model;
  const auto c = coefficients_at(model, trial.air_c, trial.film);
  const ThermalInputValues on = operating_inputs(model, kStart_c);
  const Eigen::MatrixXd rest = states_at(model, c, 0);
  ReductionError error = model.error;

  auto start = full_steady_state(system, c, on, solve);
  if (!start) return failure(start.error());
  const auto ramp_k = measure_error({"ramps", ramps(model, trial.shortest_s)}, system, reduced, c, std::move(*start),
                                    rest * on, progress);
  if (!ramp_k) return failure(ramp_k.error());
  error.ramp_k = *ramp_k;
  if (!trial.switch_on) return error;

  ErrorProgram switching{"switch-on", {}};
  append_steps(switching.steps, kSwitchOn_s, 1, on, on);
  const auto switch_on_k =
      measure_error(switching, system, reduced, c, Eigen::VectorXd::Constant(system.capacity.rows(), kStart_c),
                    rest.col(0) * kStart_c, progress);
  if (!switch_on_k) return failure(switch_on_k.error());
  error.switch_on_k = *switch_on_k;
  return error;
}

}  // namespace gyrotherm::thermal
