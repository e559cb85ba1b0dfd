// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cassert>
#include <cmath>
#include <limits>
#include <vector>

#include "analysis/methods/held_out.hpp"
#include "analysis/methods/kernel_methods.hpp"
#include "analysis/svm/cholesky.hpp"
#include "analysis/svm/svr.hpp"

namespace gyrotherm::methods {
namespace {

/// Position of the search in log2 of γ and σ.
struct Position {
  double gamma{}, sigma{};
};

constexpr double kGammaStep = 4, kSigmaStep = 1.5;
constexpr Position kLowestPosition = {2, -0.5}, kHighestPosition = {18, 5.5};

/// One σ and the values of γ to try with this σ. All of them share a kernel matrix.
struct Line {
  double sigma{};
  std::vector<double> gammas;
};

std::vector<Line> coarse_grid() {
  std::vector<Line> grid;
  for (double sigma = kHighestPosition.sigma; sigma >= kLowestPosition.sigma; sigma -= kSigmaStep) {
    auto& line = grid.emplace_back(Line{.sigma = sigma, .gammas = {}});
    for (double gamma = kLowestPosition.gamma; gamma <= kHighestPosition.gamma; gamma += kGammaStep)
      line.gammas.push_back(gamma);
  }
  return grid;
}

/// Returns the eight neighbours of a position, at a fraction of the coarse step.
std::vector<Line> find_neighbours(Position best, double part) {
  const double aside = part * kGammaStep;
  std::vector<Line> grid;
  for (const int j : {-1, 0, 1}) {
    grid.push_back({best.sigma + j * part * kSigmaStep, {best.gamma - aside, best.gamma + aside}});
    if (j != 0) grid.back().gammas.push_back(best.gamma);
  }
  return grid;
}

/// Warns if the optimum is on the edge of the grid. The true optimum may lie outside, or the parameter may have no
/// effect: for large σ the machine is nearly linear.
void warn_of_edge(const char* name, double at, double least, double largest, std::vector<std::string>& warnings) {
  if (at > least && at < largest) return;
  warnings.push_back(fmt::format("log2 {} = {} lies on the edge of the grid, {} … {}", name, at, least, largest));
}

/// Predicts the held-out rows, one column per γ of the line. If the machine for a γ cannot be trained, its column is
/// not finite.
Result<Eigen::MatrixXd> held_out_prediction(const Fold& fold, const Line& line) {
  const double sigma = std::exp2(line.sigma);
  const Eigen::MatrixXd among = svm::gaussian_kernel_lower(fold.train_x, sigma);
  const Eigen::MatrixXd across = svm::gaussian_kernel(fold.test_x, fold.train_x, sigma);
  Eigen::MatrixXd predicted(fold.test_x.rows(), static_cast<Eigen::Index>(line.gammas.size()));
  for (std::size_t i = 0; i < line.gammas.size(); ++i) {
    auto column = predicted.col(static_cast<Eigen::Index>(i));
    const auto machine = solve_ls_svm(among, fold.train_y, std::exp2(line.gammas[i]));
    if (machine)
      column = (across * machine->alpha).array() + machine->b;
    else
      column.setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  return predicted;
}

}  // namespace

Result<LsSvm> solve_ls_svm(const Eigen::Ref<const Eigen::MatrixXd>& kernel, const Eigen::Ref<const Eigen::VectorXd>& y,
                           double gamma) {
  assert(gamma > 0 && kernel.rows() == y.size());
  LsSvm machine{.factor = kernel, .eta = {}, .alpha = {}, .b = 0};
  machine.factor.diagonal().array() += 1 / gamma;
  if (!svm::factor_cholesky(machine.factor)) {
    return failure(FaultKind::numeric, "least-squares support vector machine",
                   fmt::format("the kernel with gamma = {:.4g} is not positive definite", gamma));
  }
  Eigen::MatrixXd both(y.size(), 2);
  both << Eigen::VectorXd::Ones(y.size()), y;
  svm::solve_cholesky(machine.factor, both);
  machine.eta = both.col(0);
  machine.b = both.col(1).sum() / machine.eta.sum();
  machine.alpha = both.col(1) - machine.b * machine.eta;
  return machine;
}

Eigen::VectorXd bordered_inverse_diagonal(const LsSvm& machine) {
  return svm::inverse_diagonal(machine.factor).array() - machine.eta.array().square() / machine.eta.sum();
}

Result<Choice> choose_ls_svm(std::span<const Fold> folds, const MethodOptions& options, const ProgressSink& progress) {
  std::vector<Line> lines;
  std::vector<Eigen::VectorXd> errors;
  const auto try_all = [&](const std::vector<Line>& grid) -> Result<Position> {
    const Trial trial = [&](const Fold& fold, std::size_t i) { return held_out_prediction(fold, grid[i]); };
    const auto more = held_out_errors(folds, grid.size(), trial, options, progress);
    if (!more) return failure(more.error());
    lines.insert(lines.end(), grid.begin(), grid.end());
    errors.insert(errors.end(), more->begin(), more->end());
    const LowestError least = find_least(errors);
    return Position{.gamma = lines[least.trial].gammas[static_cast<std::size_t>(least.candidate)],
                    .sigma = lines[least.trial].sigma};
  };
  auto best = try_all(coarse_grid());
  for (const double part : {0.5, 0.25}) {
    if (best && !options.quick) best = try_all(find_neighbours(*best, part));
  }
  if (!best) return failure(best.error());
  Choice choice;
  choice.parameters = {{"gamma", std::exp2(best->gamma)}, {"sigma", std::exp2(best->sigma)}};
  warn_of_edge("gamma", best->gamma, kLowestPosition.gamma, kHighestPosition.gamma, choice.warnings);
  warn_of_edge("sigma", best->sigma, kLowestPosition.sigma, kHighestPosition.sigma, choice.warnings);
  return choice;
}

Result<Fit> fit_ls_svm(const FitInput& set, const HyperParameters& parameters, const MethodOptions&) {
  if (const auto sound = check_set(set, 2); !sound) return failure(sound.error());
  const double gamma = parameter_value(parameters, "gamma"), sigma = parameter_value(parameters, "sigma");
  const auto machine = solve_ls_svm(svm::gaussian_kernel_lower(set.x, sigma), set.y, gamma);
  if (!machine) return failure(machine.error());
  const Eigen::VectorXd diagonal = bordered_inverse_diagonal(*machine);
  const auto samples = static_cast<double>(set.y.size());
  const double left_out = std::sqrt((machine->alpha.array() / diagonal.array()).square().mean());
  return Fit{
      .function = ExpansionModel{.centres = set.x,
                                 .lengths = Eigen::RowVectorXd::Ones(set.x.cols()),
                                 .widths = Eigen::VectorXd::Constant(set.x.rows(), sigma),
                                 .weights = machine->alpha,
                                 .b = machine->b},
      .effective_parameters = samples - diagonal.sum() / gamma,
      .particulars = fmt::format("leave-one-out RMSE, closed form: {:.3g} of the target's STD; too small, because "
                                 "the neighbours of a cluster remain in the training set",
                                 left_out)};
}

}  // namespace gyrotherm::methods
