// SPDX-License-Identifier: Apache-2.0
#include "analysis/methods/svr_joint.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "analysis/methods/held_out.hpp"
#include "analysis/methods/ridge_u.hpp"
#include "analysis/methods/svr.hpp"
#include "analysis/svm/kernel.hpp"

namespace gyrotherm::methods {
namespace {

/// Of the target's STD. A rest of nothing has a unit too, in which the target is still of a size that can be solved.
constexpr double kLeastUnit = 1e-3;

/// The root mean square of what the plane of ridge-u leaves.
double unit_of(const FitInput& set) {
  return std::max(std::sqrt(beside_the_plane(set).array().square().mean()), kLeastUnit);
}

/// P.
Eigen::MatrixXd penalty_of(const FitInput& set) { return slope_penalty(set, 1); }

}  // namespace

Result<Choice> choose_svr_joint(std::span<const Fold> folds, const MethodOptions& options,
                                const ProgressSink& progress) {
  if (const auto sound = check_folds(folds); !sound) return failure(sound.error());
  std::vector<Fold> in_units(folds.begin(), folds.end());
  for (Fold& fold : in_units) {
    const FitInput set{fold.train_x, fold.train_y, fold.terms, fold.input_covariance};
    fold.plane_penalty = penalty_of(set);
    const double unit = unit_of(set);
    fold.train_y /= unit;
    fold.test_y /= unit;
    fold.target_scale *= unit;
  }
  auto choice = choose_svr(in_units, options, progress);
  if (choice) choice->parameters.push_back({"plane penalty", choice->tuning->best.plane_penalty});
  return choice;
}

Result<Fit> fit_svr_joint(const FitInput& set, const HyperParameters& parameters, const MethodOptions& options) {
  if (const auto sound = check_set(set, 2); !sound) return failure(sound.error());
  const double unit = unit_of(set);
  const svm::SvrParameters svr{.C = value_of(parameters, "C"),
                               .sigma = value_of(parameters, "sigma"),
                               .epsilon = value_of(parameters, "epsilon"),
                               .plane_penalty = value_of(parameters, "plane penalty")};
  const svm::PlaneSamples plane(set.x, penalty_of(set));
  const auto solution = solve_to_keep(svm::GaussianSamples(set.x), set.y / unit, svr, options, &plane);
  if (!solution) return failure(solution.error());
  const std::vector<Eigen::Index> support = svm::support_of(solution->beta);
  const auto free = (solution->beta.array() != 0 && solution->beta.array().abs() < solution->bound).count();
  ExpansionModel both{.centres = set.x(support, Eigen::all),
                      .lengths = Eigen::RowVectorXd::Ones(set.x.cols()),
                      .widths = Eigen::VectorXd::Constant(static_cast<Eigen::Index>(support.size()), svr.sigma),
                      .weights = unit * solution->beta(support),
                      .b = unit * solution->b,
                      .slope = unit * solution->slope};
  return Fit{
      .function = std::move(both),
      .effective_parameters = static_cast<double>(free),
      .particulars = fmt::format("plane and Gaussians of height {:.3g} solved together, relative duality gap {:.2g}",
                                 solution->bound / svr.C, solution->relative_gap)};
}

}  // namespace gyrotherm::methods
