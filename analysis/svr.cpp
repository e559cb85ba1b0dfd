#include "analysis/svr.hpp"

#include <fmt/format.h>

#include <cassert>
#include <cmath>
#include <string>
#include <utility>

#include "analysis/numerics/newton.hpp"
#include "analysis/numerics/smo.hpp"
#include "analysis/numerics/svr_problem.hpp"

namespace gyrotherm {
namespace {

// Of the KKT violation, in standard deviations of the target; most such solutions have a gap below 1e-3.
constexpr double kSmoTolerance = 1e-3;
// Times n. Trainings that need more are faster by Newton steps.
constexpr Eigen::Index kSmoIterationsPerPoint = 16;
// σ/C of the first proximal step after SMO.
constexpr double kFirstWeight = 3;

tl::unexpected<Fault> misuse(std::string what) {
  return failure(FaultKind::usage, "support vector regression", std::move(what));
}

Result<void> check_positive(const char* what, double value) {
  if (value > 0 && std::isfinite(value)) return {};
  return misuse(fmt::format("{} = {}, must be positive and finite", what, value));
}

Result<void> check_targets(const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Index rows) {
  if (y.size() != rows) return misuse(fmt::format("{} targets for {} samples", y.size(), rows));
  if (rows == 0) return misuse("no sample");
  for (Eigen::Index i = 0; i < rows; ++i) {
    if (!std::isfinite(y[i])) return misuse(fmt::format("target {} = {}, must be finite", i, y[i]));
  }
  return {};
}

Result<void> check_problem(const SvrProblem& problem, const SvrOptions& options) {
  if (problem.kernel.rows() != problem.kernel.cols()) {
    return misuse(fmt::format("kernel is {} × {}, must be square", problem.kernel.rows(), problem.kernel.cols()));
  }
  if (auto ok = check_targets(problem.y, problem.kernel.rows()); !ok) return ok;
  if (auto ok = check_positive("C", problem.C); !ok) return ok;
  if (auto ok = check_positive("relative_gap", options.relative_gap); !ok) return ok;
  if (problem.epsilon >= 0 && std::isfinite(problem.epsilon)) return {};
  return misuse(fmt::format("epsilon = {}, must be at least 0 and finite", problem.epsilon));
}

NewtonResult optimise(const SvrProblem& problem, const SvrOptions& options) {
  const double spread = std::sqrt((problem.y.array() - problem.y.mean()).square().mean());
  const auto iterations = static_cast<int>(kSmoIterationsPerPoint * problem.size());
  const SvrPoint start = solve_by_smo(problem, kSmoTolerance * spread, iterations).point;
  return solve_by_newton(
      problem, start,
      {.relative_gap = options.relative_gap, .max_steps = options.max_newton_steps, .first_weight = kFirstWeight});
}

}  // namespace

double relative_duality_gap(const Eigen::Ref<const Eigen::MatrixXd>& kernel, const Eigen::Ref<const Eigen::VectorXd>& y,
                            double C, double epsilon, const Eigen::Ref<const Eigen::VectorXd>& beta, double b) {
  const SvrProblem problem{kernel, y, C, epsilon};
  const SvrPoint point{beta, b};
  return certify(problem, point, response(problem, point.beta)).relative_gap;
}

Result<SvrSolution> solve_svr_kernel(const Eigen::Ref<const Eigen::MatrixXd>& kernel,
                                     const Eigen::Ref<const Eigen::VectorXd>& y, double C, double epsilon,
                                     const SvrOptions& options) {
  const SvrProblem problem{kernel, y, C, epsilon};
  if (auto ok = check_problem(problem, options); !ok) return failure(ok.error());
  assert(kernel.allFinite());
  NewtonResult optimum = optimise(problem, options);
  const Eigen::VectorXd judged = response(problem, optimum.point.beta);
  const Certificate certificate = certify(problem, optimum.point, judged);
  if (!(certificate.relative_gap <= options.relative_gap)) {
    return failure(FaultKind::numeric, "support vector regression",
                   fmt::format("relative duality gap {:.2g} after {} Newton steps, wanted {:.2g}; C = {}, epsilon = {}",
                               certificate.relative_gap, optimum.steps, options.relative_gap, C, epsilon));
  }
  SvrSolution solution;
  solution.kkt_violation = kkt_violation(problem, optimum.point.beta, judged);
  solution.beta = std::move(optimum.point.beta);
  solution.b = optimum.point.b;
  solution.relative_gap = certificate.relative_gap;
  solution.objective = certificate.objective;
  solution.support_vectors = static_cast<int>((solution.beta.array() != 0).count());
  solution.iterations = optimum.steps;
  return solution;
}

Result<SvrSolution> solve_svr(const Eigen::Ref<const SampleMatrix>& x, const Eigen::Ref<const Eigen::VectorXd>& y,
                              const SvrParameters& parameters, const SvrOptions& options) {
  if (auto ok = check_targets(y, x.rows()); !ok) return failure(ok.error());
  if (!x.allFinite()) return misuse("a sample has a value that is not finite");
  if (auto ok = check_positive("sigma", parameters.sigma); !ok) return failure(ok.error());
  return solve_svr_kernel(gaussian_kernel(x, x, parameters.sigma), y, parameters.C, parameters.epsilon, options);
}

}  // namespace gyrotherm
