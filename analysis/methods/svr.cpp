// SPDX-License-Identifier: Apache-2.0
#include "analysis/methods/svr.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "analysis/methods/held_out.hpp"
#include "analysis/methods/ridge_u.hpp"
#include "analysis/svm/kernel.hpp"

namespace gyrotherm::methods {
namespace {

SvrModel make_model(const FitInput& set, const svm::SvrSolution& solution, const svm::SvrParameters& parameters) {
  const std::vector<Eigen::Index> support = svm::support_rows(solution.beta);
  return SvrModel{.support_vectors = set.x(support, Eigen::all),
                  .beta = solution.beta(support),
                  .b = solution.b,
                  .parameters = parameters,
                  .relative_gap = solution.relative_gap,
                  .kkt_violation = solution.kkt_violation};
}

/// Returns one past the last cluster of the stretch that begins at `first`.
Eigen::Index end_of_stretch(const data::Clusters& clusters, Eigen::Index first) {
  Eigen::Index next = first + 1;
  const auto follows = [&](Eigen::Index k) {
    const double apart = clusters.start_s(k) - clusters.start_s(k - 1);
    return apart > 0 && apart < 1.5 * clusters.length_s;
  };
  while (next < clusters.start_s.size() && follows(next)) ++next;
  return next;
}

// Thresholds of the quick search. Folds with more training rows than kMostQuickRows are trained on every k-th row, at
// most kThinnedRows; all held-out rows are evaluated. The search is then as fast as for a small record.
constexpr Eigen::Index kMostQuickRows = 2000;
constexpr Eigen::Index kThinnedRows = 1000;

Eigen::Index thinning_factor(const std::vector<svm::TuningFold>& folds) {
  Eigen::Index most = 0;
  for (const svm::TuningFold& fold : folds) most = std::max(most, fold.train_y.size());
  return most <= kMostQuickRows ? 1 : (most + kThinnedRows - 1) / kThinnedRows;
}

// Keeps every k-th row of the fold. Row numbers in the data set are used if known; rows that two folds share are then
// kept in both or in neither.
void keep_every(Eigen::Index kth, svm::TuningFold& fold) {
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < fold.train_y.size(); ++i) {
    const Eigen::Index number = fold.train_rows.empty() ? i : fold.train_rows[static_cast<std::size_t>(i)];
    if (number % kth == 0) kept.push_back(i);
  }
  fold.train_x = fold.train_x(kept, Eigen::all).eval();
  fold.train_y = fold.train_y(kept).eval();
  if (fold.train_rows.empty()) return;
  for (Eigen::Index& row : kept) row = fold.train_rows[static_cast<std::size_t>(row)];
  fold.train_rows = std::move(kept);
}

/// Solves to the tight gap of the options if possible, otherwise to the normal gap. Fails as solve_svr does.
Result<svm::SvrSolution> solve_to_keep(const svm::GaussianSamples& samples, const Eigen::VectorXd& y,
                                       const svm::SvrParameters& parameters, const MethodOptions& options) {
  svm::KernelMemory memory;
  const svm::SvrOptions common = options.tuning.svr;
  if (options.tight_gap > 0 && options.tight_gap < common.relative_gap) {
    svm::SvrOptions tight = common;
    tight.relative_gap = options.tight_gap;
    auto solution = solve_svr(samples, memory, y, parameters, tight);
    if (solution || solution.error().kind != FaultKind::numeric) return solution;
  }
  return solve_svr(samples, memory, y, parameters, common);
}

/// Plane, and the unit of its residual: the RMS of the residual over the training rows.
struct PlaneResidual {
  PenalisedPlane plane;
  double unit{};
  [[nodiscard]] Eigen::VectorXd apply(const data::SampleMatrix& x, const Eigen::VectorXd& y) const {
    return ((y - x * plane.weights).array() - plane.b) / unit;
  }
};

/// Computes the residual of the plane. The unit is above 0 even for a zero residual, to avoid a division by 0.
PlaneResidual fit_plane_residual(const FitInput& set) {
  PlaneResidual residual{fit_plane(set), 1};
  const double spread = residual.apply(set.x, set.y).norm() / std::sqrt(static_cast<double>(set.y.size()));
  residual.unit = std::max(spread, std::numeric_limits<double>::epsilon());
  return residual;
}

}  // namespace

Result<Choice> choose_svr(std::span<const Fold> folds, const MethodOptions& options, const ProgressSink& progress) {
  std::vector<svm::TuningFold> unnamed(folds.begin(), folds.end());
  const Eigen::Index kth = options.quick ? thinning_factor(unnamed) : 1;
  if (kth > 1)
    for (svm::TuningFold& fold : unnamed) keep_every(kth, fold);
  auto tuned = tune_svr(unnamed, options.tuning, progress);
  if (!tuned) return failure(tuned.error());
  // Keeps the total weight of the losses relative to the norm term of the objective.
  tuned->best.C /= static_cast<double>(kth);
  if (auto& rule = tuned->one_standard_error) rule->best.C /= static_cast<double>(kth);
  if (kth > 1) tuned->warnings.push_back(fmt::format("the quick search trained on one row in {} of each fold", kth));
  Choice choice;
  choice.parameters = {{"C", tuned->best.C}, {"sigma", tuned->best.sigma}, {"epsilon", tuned->best.epsilon}};
  choice.warnings = tuned->warnings;
  choice.tuning = std::move(*tuned);
  return choice;
}

Result<Fit> fit_svr(const FitInput& set, const HyperParameters& parameters, const MethodOptions& options) {
  if (const auto sound = check_set(set, 2); !sound) return failure(sound.error());
  const svm::SvrParameters svr{.C = parameter_value(parameters, "C"),
                               .sigma = parameter_value(parameters, "sigma"),
                               .epsilon = parameter_value(parameters, "epsilon")};
  const auto solution = solve_to_keep(svm::GaussianSamples(set.x), set.y, svr, options);
  if (!solution) return failure(solution.error());
  const auto free = (solution->beta.array() != 0 && solution->beta.array().abs() < svr.C).count();
  return Fit{.function = make_model(set, *solution, svr), .effective_parameters = static_cast<double>(free)};
}

Eigen::VectorXd forward_prediction(const Eigen::Ref<const Eigen::VectorXd>& values, const ForwardPrediction& options) {
  assert(options.order > 0 && options.step > 0 && options.step < 2);
  const Eigen::Index order = options.order;
  Eigen::VectorXd weights = Eigen::VectorXd::Constant(order, 1 / static_cast<double>(order));
  Eigen::VectorXd predicted = values;
  for (Eigen::Index n = order; n < values.size(); ++n) {
    const Eigen::VectorXd before = values.segment(n - order, order).reverse();
    predicted(n) = weights.dot(before);
    const double power = before.squaredNorm();
    if (power > 0) weights += options.step * (values(n) - predicted(n)) / power * before;
  }
  return predicted;
}

Eigen::VectorXd filter_bias(const data::Clusters& training) {
  Eigen::VectorXd filtered = training.bias_deg_per_h;
  for (Eigen::Index first = 0, end = 0; first < filtered.size(); first = end) {
    end = end_of_stretch(training, first);
    const auto stretch = training.bias_deg_per_h.segment(first, end - first);
    const double mean = stretch.mean();
    filtered.segment(first, end - first) = forward_prediction(stretch.array() - mean).array() + mean;
  }
  return filtered;
}

Result<Choice> choose_svr_linear(std::span<const Fold> folds, const MethodOptions& options,
                                 const ProgressSink& progress) {
  std::vector<Fold> residual_folds(folds.begin(), folds.end());
  for (Fold& fold : residual_folds) {
    const FitInput set{fold.train_x, fold.train_y, fold.terms, fold.input_covariance};
    if (const auto sound = check_set(set, 2); !sound) return failure(sound.error());
    const PlaneResidual residual = fit_plane_residual(set);
    fold.train_y = residual.apply(fold.train_x, fold.train_y);
    fold.test_y = residual.apply(fold.test_x, fold.test_y);
    fold.target_scale *= residual.unit;
  }
  return choose_svr(residual_folds, options, progress);
}

Result<Fit> fit_svr_linear(const FitInput& set, const HyperParameters& parameters, const MethodOptions& options) {
  if (const auto sound = check_set(set, 2); !sound) return failure(sound.error());
  const PlaneResidual residual = fit_plane_residual(set);
  const Eigen::VectorXd y = residual.apply(set.x, set.y);
  auto fit = fit_svr({set.x, y, set.terms}, parameters, options);
  if (!fit) return fit;
  const auto& svr = std::get<SvrModel>(fit->function);
  const Eigen::Index count = svr.beta.size();
  ExpansionModel both{.centres = svr.support_vectors,
                      .lengths = Eigen::RowVectorXd::Ones(set.x.cols()),
                      .widths = Eigen::VectorXd::Constant(count, svr.parameters.sigma),
                      .weights = residual.unit * svr.beta,
                      .b = residual.plane.b + residual.unit * svr.b,
                      .slope = residual.plane.weights};
  return Fit{.function = std::move(both),
             .effective_parameters = residual.plane.effective_parameters + fit->effective_parameters};
}

}  // namespace gyrotherm::methods
