// SPDX-License-Identifier: Apache-2.0
#include "analysis/svm/svr.hpp"

#include <fmt/format.h>

#include <cassert>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>

#include "analysis/svm/lanes.hpp"
#include "analysis/svm/newton.hpp"
#include "analysis/svm/smo.hpp"
#include "analysis/svm/svr_problem.hpp"
#include "analysis/svm/warm_start.hpp"

namespace gyrotherm::svm {
namespace {

// KKT violation at which SMO stops, in standard deviations of the target. Most such solutions have a gap below 1e-3.
constexpr double kSmoTolerance = 1e-3;
// Iteration limits of SMO per point. After that many iterations Newton steps are faster. The limit is lower for small
// trainings.
constexpr Eigen::Index kSmoIterationsPerPoint = 64;
constexpr Eigen::Index kSmoIterationsPerPointOfFew = 16;
constexpr Eigen::Index kSmallTraining = 640;
// σ/C of the first proximal step after SMO.
constexpr double kFirstWeight = 3;
// If C is larger than kLargeBound standard deviations of the target, the held-out errors of solutions with a gap just
// below 1e-3 differ by several percent. The desired gap is then kAimFraction of the required one.
constexpr double kLargeBound = 64;
constexpr double kAimFraction = 0.1;

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

Result<void> check(Eigen::Index size, const Eigen::Ref<const Eigen::VectorXd>& y, double C, double epsilon,
                   const SvrOptions& options) {
  if (auto ok = check_targets(y, size); !ok) return ok;
  if (auto ok = check_positive("C", C); !ok) return ok;
  if (auto ok = check_positive("relative_gap", options.relative_gap); !ok) return ok;
  if (!(epsilon >= 0 && std::isfinite(epsilon))) {
    return misuse(fmt::format("epsilon = {}, must be at least 0 and finite", epsilon));
  }
  const std::size_t needed = least_kernel_bytes(size);
  if (needed <= options.memory_bytes) return {};
  constexpr double kGiB = 1024.0 * 1024.0 * 1024.0;
  return misuse(fmt::format("{} samples need {:.1f} GiB for their kernel, the limit is {:.1f} GiB", size,
                            static_cast<double>(needed) / kGiB, static_cast<double>(options.memory_bytes) / kGiB));
}

NewtonResult optimise(const SvrProblem& problem, const SvrOptions& options, const SvrStart* near) {
  const double spread = std::sqrt((problem.y.array() - problem.y.mean()).square().mean());
  const auto iterations = static_cast<int>(
      problem.size() * (problem.size() <= kSmallTraining ? kSmoIterationsPerPointOfFew : kSmoIterationsPerPoint));
  const auto begin = near == nullptr ? std::optional<Eigen::VectorXd>{} : feasible_start(problem, *near);
  const Eigen::VectorXd start = solve_by_smo(problem, kSmoTolerance * spread, iterations, begin ? &*begin : nullptr);
  return solve_by_newton(problem, start,
                         {.relative_gap = options.relative_gap,
                          .aim = options.relative_gap * (problem.C > kLargeBound * spread ? kAimFraction : 1),
                          .max_steps = options.max_newton_steps,
                          .first_weight = kFirstWeight});
}

GYROTHERM_CLONES
void add_squared_differences(const double* values, double value, Eigen::Index count, double* sum) {
  for (Eigen::Index i = 0; i < count; ++i) sum[i] += (values[i] - value) * (values[i] - value);
}

// Computes the kernel between one position and the rows of `columns` from `first` on. Uses the differences of the
// coordinates, so equal rows have the distance 0 exactly. The first element of `out` is the value for row `first`.
void fill_kernel(const Eigen::MatrixXd& columns, Eigen::Index first, const Eigen::RowVectorXd& position, double sigma,
                 double* out) {
  const Eigen::Index count = columns.rows() - first;
  std::fill_n(out, count, 0.0);
  for (Eigen::Index k = 0; k < position.size(); ++k)
    add_squared_differences(columns.col(k).data() + first, position(k), count, out);
  exponentiate(out, count, -0.5 / (sigma * sigma), out);
}

}  // namespace

Result<SvrSolution> solve_svr(const GaussianSamples& samples, KernelMemory& memory,
                              const Eigen::Ref<const Eigen::VectorXd>& y, const SvrParameters& parameters,
                              const SvrOptions& options, const SvrStart* start) {
  if (auto ok = check(samples.size(), y, parameters.C, parameters.epsilon, options); !ok) return failure(ok.error());
  if (auto ok = check_positive("sigma", parameters.sigma); !ok) return failure(ok.error());
  Kernel kernel(samples, parameters.sigma, memory, options.memory_bytes - least_kernel_bytes(samples.size()));
  const SvrProblem problem{kernel, y, parameters.C, parameters.epsilon};
  NewtonResult optimum = optimise(problem, options, start);
  const Certificate certificate = certify(problem, optimum.point, optimum.response);
  if (!(certificate.relative_gap <= options.relative_gap)) {
    return failure(
        FaultKind::numeric, "support vector regression",
        fmt::format("relative duality gap {:.2g} after {} Newton steps, required {:.2g}; C = {}, epsilon = {}",
                    certificate.relative_gap, optimum.steps, options.relative_gap, parameters.C, parameters.epsilon));
  }
  SvrSolution solution;
  solution.kkt_violation = kkt_violation(problem, optimum.point.beta, optimum.response);
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
  const GaussianSamples samples(x);
  KernelMemory memory;
  return solve_svr(samples, memory, y, parameters, options);
}

std::vector<Eigen::Index> support_rows(const Eigen::VectorXd& beta) {
  std::vector<Eigen::Index> support;
  for (Eigen::Index i = 0; i < beta.size(); ++i)
    if (beta[i] != 0) support.push_back(i);
  return support;
}

Eigen::MatrixXd gaussian_kernel(const Eigen::Ref<const SampleMatrix>& a, const Eigen::Ref<const SampleMatrix>& b,
                                double sigma) {
  assert(a.cols() == b.cols());
  const Eigen::MatrixXd columns = a;
  Eigen::MatrixXd out(a.rows(), b.rows());
  for (Eigen::Index j = 0; j < b.rows(); ++j) fill_kernel(columns, 0, b.row(j), sigma, out.col(j).data());
  return out;
}

Eigen::MatrixXd gaussian_kernel_lower(const Eigen::Ref<const SampleMatrix>& x, double sigma) {
  const Eigen::MatrixXd columns = x;
  Eigen::MatrixXd out(x.rows(), x.rows());
  for (Eigen::Index j = 0; j < x.rows(); ++j) fill_kernel(columns, j, x.row(j), sigma, &out(j, j));
  return out;
}

}  // namespace gyrotherm::svm
