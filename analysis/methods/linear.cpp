// SPDX-License-Identifier: Apache-2.0
#include "analysis/methods/linear.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <utility>

#include "analysis/methods/held_out.hpp"

namespace gyrotherm::methods {
namespace {

/// Rank threshold, relative to the largest pivot of the decomposition. Smaller pivots are rounding errors, so their
/// columns count as linearly dependent.
constexpr double kRelativeRank = 1e-9;

/// Lower limit for the length of a direction, relative to the greatest, in the computation of the variance. Inputs that
/// are nearly dependent in training, such as powers of one temperature in a hold, may be independent elsewhere. For
/// inputs that are always dependent only rounding errors remain; the limit keeps them below a thousandth of the
/// target's variance.
constexpr double kMinRelativeLength = 3e-7;
constexpr double kTinyNorm = 1e-150;  ///< avoids squares that are 0

}  // namespace

PredictiveVariance coefficient_variance(const data::SampleMatrix& z, const Eigen::VectorXd& y, const LinearModel& plane,
                                        double effective_parameters, const Eigen::MatrixXd& penalty_rows) {
  const auto samples = static_cast<double>(z.rows());
  const Eigen::VectorXd residual = y - ((z * plane.weights).array() + plane.b).matrix();
  const double variance = residual.squaredNorm() / std::max(1.0, samples - effective_parameters);
  if (z.cols() == 0) return plane_variance(Eigen::MatrixXd::Constant(1, 1, variance / samples), std::sqrt(variance));
  const Eigen::RowVectorXd mean = z.colwise().mean();
  Eigen::MatrixXd stacked(z.rows() + penalty_rows.rows(), z.cols());
  stacked.topRows(z.rows()) = z.rowwise() - mean;
  if (penalty_rows.size() > 0) stacked.bottomRows(penalty_rows.rows()) = penalty_rows;
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(stacked);
  const Eigen::Index rank = std::min(stacked.rows(), stacked.cols());
  const Eigen::MatrixXd triangle = qr.matrixQR().topRows(rank).triangularView<Eigen::Upper>();
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(triangle, Eigen::ComputeFullV);
  Eigen::ArrayXd lengths = Eigen::ArrayXd::Zero(z.cols());
  lengths.head(rank) = svd.singularValues();
  const Eigen::ArrayXd open_along =
      lengths.max(std::max(kMinRelativeLength * lengths(0), kTinyNorm)).square().inverse();
  const Eigen::MatrixXd slopes = svd.matrixV() * open_along.matrix().asDiagonal() * svd.matrixV().transpose();
  const Eigen::VectorXd with_constant = -slopes * mean.transpose();
  Eigen::MatrixXd open(z.cols() + 1, z.cols() + 1);
  open << slopes, with_constant, with_constant.transpose(), 1 / samples - mean * with_constant;
  return plane_variance(variance * open, std::sqrt(variance));
}

Fit make_plane_fit(const FitInput& set, LinearModel plane, double effective_parameters,
                   const Eigen::MatrixXd& penalty_rows) {
  Fit fit;
  fit.effective_parameters = effective_parameters;
  fit.variance = coefficient_variance(set.x, set.y, plane, effective_parameters, penalty_rows);
  fit.function = std::move(plane);
  return fit;
}

PredictiveVariance expand_to_inputs(const PredictiveVariance& variance, const std::vector<Eigen::Index>& columns,
                                    Eigen::Index inputs) {
  std::vector<Eigen::Index> with_constant = columns;
  with_constant.push_back(inputs);
  Eigen::MatrixXd open = Eigen::MatrixXd::Zero(inputs + 1, inputs + 1);
  open(with_constant, with_constant) = variance.posterior;
  return plane_variance(std::move(open), variance.noise);
}

Result<Fit> fit_linear(const FitInput& set, const HyperParameters&, const MethodOptions&) {
  if (const auto sound = check_set(set, 2); !sound) return failure(sound.error());
  Eigen::MatrixXd design(set.x.rows(), set.x.cols() + 1);
  design << set.x, Eigen::VectorXd::Ones(set.x.rows());
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> qr;
  qr.setThreshold(kRelativeRank);
  qr.compute(design);
  if (set.x.rows() <= qr.rank()) {
    return failure(FaultKind::usage, "least squares",
                   fmt::format("{} clusters are too few for {} coefficients", set.x.rows(), qr.rank()));
  }
  const Eigen::VectorXd coefficients = qr.solve(set.y);
  return make_plane_fit(set, {.weights = coefficients.head(set.x.cols()), .b = coefficients(set.x.cols())},
                        static_cast<double>(qr.rank()));
}

namespace {

constexpr int kHighestOrder = 3;

int polynomial_order(const data::Term& term) {
  return static_cast<int>(std::ranges::count_if(
      term.factors, [](const data::Factor& factor) { return factor.kind != data::FactorKind::rate; }));
}

std::vector<Eigen::Index> select_columns(const std::vector<data::Term>& terms, int order, bool rates) {
  std::vector<Eigen::Index> columns;
  for (std::size_t j = 0; j < terms.size(); ++j) {
    const bool taken = has_rate(terms[j]) ? rates : polynomial_order(terms[j]) <= order;
    if (taken) columns.push_back(static_cast<Eigen::Index>(j));
  }
  return columns;
}

/// Lists every distinct polynomial that the inputs allow, simple ones first.
std::vector<HyperParameters> list_candidates(const std::vector<data::Term>& terms) {
  std::vector<HyperParameters> candidates;
  std::vector<std::vector<Eigen::Index>> found;
  for (int order = 1; order <= kHighestOrder; ++order) {
    for (const bool rates : {false, true}) {
      const auto columns = select_columns(terms, order, rates);
      if (columns.empty() || std::ranges::count(found, columns) > 0) continue;
      found.push_back(columns);
      candidates.push_back({{"order", static_cast<double>(order)}, {"rate terms", rates ? 1.0 : 0.0}});
    }
  }
  return candidates;
}

}  // namespace

Result<Choice> choose_polynomial(std::span<const Fold> folds, const MethodOptions& options,
                                 const ProgressSink& progress) {
  if (const auto sound = check_folds(folds); !sound) return failure(sound.error());
  return choose_among(list_candidates(folds.front().terms), fit_polynomial, folds, options, progress);
}

Result<Fit> fit_polynomial(const FitInput& set, const HyperParameters& parameters, const MethodOptions& options) {
  const auto columns = select_columns(set.terms, static_cast<int>(parameter_value(parameters, "order")),
                                      parameter_value(parameters, "rate terms") != 0);
  const data::SampleMatrix taken = set.x(Eigen::all, columns);
  auto fitted = fit_linear({taken, set.y, set.terms}, parameters, options);
  if (!fitted) return fitted;
  auto& polynomial = std::get<LinearModel>(fitted->function);
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(set.x.cols());
  weights(columns) = polynomial.weights;
  polynomial.weights = std::move(weights);
  fitted->variance = expand_to_inputs(*fitted->variance, columns, set.x.cols());
  return fitted;
}

}  // namespace gyrotherm::methods
