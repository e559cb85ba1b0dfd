// SPDX-License-Identifier: Apache-2.0
#include "analysis/methods/svr_linear.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "analysis/methods/held_out.hpp"
#include "analysis/methods/ridge_u.hpp"
#include "analysis/methods/svr.hpp"

namespace gyrotherm::methods {
namespace {

/// A plane, and in what units the rest of its training rows is 1 in the mean square.
struct Rest {
  PenalisedPlane plane;
  double unit{};
  [[nodiscard]] Eigen::VectorXd of(const data::SampleMatrix& x, const Eigen::VectorXd& y) const {
    return ((y - x * plane.weights).array() - plane.b) / unit;
  }
};

/// A rest of nothing has a unit too, so that there is nothing to divide by 0.
Rest rest_of(const FitInput& set) {
  Rest rest{plane_of(set), 1};
  const double spread = rest.of(set.x, set.y).norm() / std::sqrt(static_cast<double>(set.y.size()));
  rest.unit = std::max(spread, std::numeric_limits<double>::epsilon());
  return rest;
}

}  // namespace

Result<Choice> choose_svr_linear(std::span<const Fold> folds, const MethodOptions& options,
                                 const ProgressSink& progress) {
  std::vector<Fold> rests(folds.begin(), folds.end());
  for (Fold& fold : rests) {
    const FitInput set{fold.train_x, fold.train_y, fold.terms, fold.input_covariance};
    if (const auto sound = check_set(set, 2); !sound) return failure(sound.error());
    const Rest rest = rest_of(set);
    fold.train_y = rest.of(fold.train_x, fold.train_y);
    fold.test_y = rest.of(fold.test_x, fold.test_y);
    fold.target_scale *= rest.unit;
  }
  return choose_svr(rests, options, progress);
}

Result<Fit> fit_svr_linear(const FitInput& set, const HyperParameters& parameters, const MethodOptions& options) {
  if (const auto sound = check_set(set, 2); !sound) return failure(sound.error());
  const Rest rest = rest_of(set);
  const Eigen::VectorXd y = rest.of(set.x, set.y);
  auto fit = fit_svr({set.x, y, set.terms}, parameters, options);
  if (!fit) return fit;
  const auto& svr = std::get<SvrModel>(fit->function);
  const Eigen::Index count = svr.beta.size();
  ExpansionModel both{.centres = svr.support_vectors,
                      .lengths = Eigen::RowVectorXd::Ones(set.x.cols()),
                      .widths = Eigen::VectorXd::Constant(count, svr.parameters.sigma),
                      .weights = rest.unit * svr.beta,
                      .b = rest.plane.b + rest.unit * svr.b,
                      .slope = rest.plane.weights};
  return Fit{.function = std::move(both),
             .effective_parameters = rest.plane.effective_parameters + fit->effective_parameters};
}

}  // namespace gyrotherm::methods
