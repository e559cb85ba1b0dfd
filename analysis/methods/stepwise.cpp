// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "analysis/methods/held_out.hpp"
#include "analysis/methods/linear.hpp"

namespace gyrotherm::methods {
namespace {

using Subset = std::vector<Eigen::Index>;

/// Regressions on subsets of the centred inputs. They use the triangle R of one QR decomposition of [X y]. A regression
/// on R costs p³ operations instead of np².
class SubsetRegression {
 public:
  SubsetRegression(const data::SampleMatrix& x, const Eigen::VectorXd& y) : samples_(x.rows()), inputs_(x.cols()) {
    Eigen::MatrixXd all(x.rows(), x.cols() + 1);
    all << x.rowwise() - x.colwise().mean(), y.array() - y.mean();
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(all);
    triangle_ = qr.matrixQR().topRows(std::min(all.rows(), all.cols())).triangularView<Eigen::Upper>();
  }

  [[nodiscard]] Eigen::Index inputs() const { return inputs_; }
  [[nodiscard]] Eigen::VectorXd weights(const Subset& subset) const {
    if (subset.empty()) return {};
    return triangle_(Eigen::all, subset).colPivHouseholderQr().solve(triangle_.col(inputs_));
  }
  [[nodiscard]] double residual(const Subset& subset) const {
    if (subset.empty()) return triangle_.col(inputs_).squaredNorm();
    return (triangle_.col(inputs_) - triangle_(Eigen::all, subset) * weights(subset)).squaredNorm();
  }
  /// Returns whether the input is nearly a linear combination of the subset.
  [[nodiscard]] bool is_dependent(Eigen::Index input, const Subset& subset) const {
    constexpr double kRoundingShare = 1e-9;
    if (subset.empty()) return false;
    const Eigen::MatrixXd taken = triangle_(Eigen::all, subset);
    const Eigen::VectorXd column = triangle_.col(input);
    return (column - taken * taken.colPivHouseholderQr().solve(column)).norm() <= kRoundingShare * column.norm();
  }
  /// Returns the partial F of the one input by which the larger set exceeds the smaller one.
  [[nodiscard]] double partial_f(double rss_smaller, double rss_larger, std::size_t larger) const {
    const double freedom = static_cast<double>(samples_) - static_cast<double>(larger) - 1;
    if (freedom <= 0) return 0;
    const double gained = std::max(rss_smaller - rss_larger, 0.0);
    return rss_larger > 0 ? gained / (rss_larger / freedom) : gained > 0 ? HUGE_VAL : 0;
  }

 private:
  Eigen::MatrixXd triangle_;
  Eigen::Index samples_, inputs_;
};

Subset remove_position(Subset subset, std::size_t position) {
  subset.erase(subset.begin() + static_cast<std::ptrdiff_t>(position));
  return subset;
}

/// Adds the best input if its F is large enough. Returns whether an input was added.
bool add_best(const SubsetRegression& regression, Subset& subset) {
  const double before = regression.residual(subset);
  double best = kFToEnter;
  Eigen::Index chosen = -1;
  for (Eigen::Index input = 0; input < regression.inputs(); ++input) {
    if (std::ranges::count(subset, input) > 0 || regression.is_dependent(input, subset)) continue;
    Subset larger = subset;
    larger.push_back(input);
    const double f = regression.partial_f(before, regression.residual(larger), larger.size());
    if (!(f > best)) continue;
    best = f;
    chosen = input;
  }
  if (chosen >= 0) subset.push_back(chosen);
  return chosen >= 0;
}

/// Drops the worst input if its F is small enough. Returns whether an input was dropped.
bool drop_worst(const SubsetRegression& regression, Subset& subset) {
  const double before = regression.residual(subset);
  double least = kFToRemove;
  std::size_t worst = subset.size();
  for (std::size_t i = 0; i < subset.size(); ++i) {
    const double f = regression.partial_f(regression.residual(remove_position(subset, i)), before, subset.size());
    if (!(f < least)) continue;
    least = f;
    worst = i;
  }
  if (worst == subset.size()) return false;
  subset = remove_position(subset, worst);
  return true;
}

}  // namespace

Result<Fit> fit_stepwise(const FitInput& set, const HyperParameters&, const MethodOptions&) {
  if (const auto sound = check_set(set, 3); !sound) return failure(sound.error());
  const SubsetRegression regression(set.x, set.y);
  Subset subset;
  // Terminates: the F to enter is larger than the F to remove, so each round lowers the residual sum of squares by at
  // least a constant factor.
  while (add_best(regression, subset)) {
    while (drop_worst(regression, subset)) {
    }
  }
  LinearModel reduced{.weights = regression.weights(subset), .b = set.y.mean()};
  LinearModel linear{.weights = Eigen::VectorXd::Zero(set.x.cols()), .b = 0};
  if (!subset.empty()) linear.weights(subset) = reduced.weights;
  reduced.b -= set.x.colwise().mean() * linear.weights;
  linear.b = reduced.b;
  std::vector<std::string> names;
  for (const Eigen::Index input : subset) names.push_back(to_string(set.terms[input]));
  const auto parameters = static_cast<double>(subset.size()) + 1;
  const data::SampleMatrix taken = set.x(Eigen::all, subset);
  return Fit{
      .function = std::move(linear),
      .effective_parameters = parameters,
      .particulars = fmt::format("{} of {} inputs entered, in this order: {}", subset.size(), set.x.cols(),
                                 names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "))),
      .variance = expand_to_inputs(coefficient_variance(taken, set.y, reduced, parameters), subset, set.x.cols())};
}

}  // namespace gyrotherm::methods
