// SPDX-License-Identifier: Apache-2.0
#include "analysis/methods/linear.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>

#include "analysis/methods/held_out.hpp"

namespace gyrotherm::methods {

Result<Fit> fit_linear(const FitInput& set, const HyperParameters&, const MethodOptions&) {
  if (const auto sound = check_set(set, 2); !sound) return failure(sound.error());
  Eigen::MatrixXd design(set.x.rows(), set.x.cols() + 1);
  design << set.x, Eigen::VectorXd::Ones(set.x.rows());
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> qr;
  qr.setThreshold(1e-9);
  qr.compute(design);
  if (set.x.rows() <= qr.rank()) {
    return failure(FaultKind::usage, "least squares",
                   fmt::format("{} clusters are too few for {} coefficients", set.x.rows(), qr.rank()));
  }
  const Eigen::VectorXd coefficients = qr.solve(set.y);
  return Fit{.function = LinearModel{.weights = coefficients.head(set.x.cols()), .b = coefficients(set.x.cols())},
             .effective_parameters = static_cast<double>(qr.rank())};
}

namespace {

constexpr int kHighestOrder = 3;

int order_of(const data::Term& term) {
  return static_cast<int>(std::ranges::count_if(
      term.factors, [](const data::Factor& factor) { return factor.kind != data::FactorKind::rate; }));
}

std::vector<Eigen::Index> columns_of(const std::vector<data::Term>& terms, int order, bool rates) {
  std::vector<Eigen::Index> columns;
  for (std::size_t j = 0; j < terms.size(); ++j) {
    const bool taken = has_rate(terms[j]) ? rates : order_of(terms[j]) <= order;
    if (taken) columns.push_back(static_cast<Eigen::Index>(j));
  }
  return columns;
}

/// Every different polynomial that the inputs offer, the simple first.
std::vector<HyperParameters> candidates_of(const std::vector<data::Term>& terms) {
  std::vector<HyperParameters> candidates;
  std::vector<std::vector<Eigen::Index>> seen;
  for (int order = 1; order <= kHighestOrder; ++order) {
    for (const bool rates : {false, true}) {
      const auto columns = columns_of(terms, order, rates);
      if (columns.empty() || std::ranges::count(seen, columns) > 0) continue;
      seen.push_back(columns);
      candidates.push_back({{"order", static_cast<double>(order)}, {"rate terms", rates ? 1.0 : 0.0}});
    }
  }
  return candidates;
}

}  // namespace

Result<Choice> choose_polynomial(std::span<const Fold> folds, const MethodOptions& options,
                                 const ProgressSink& progress) {
  if (const auto sound = check_folds(folds); !sound) return failure(sound.error());
  return choose_among(candidates_of(folds.front().terms), fit_polynomial, folds, options, progress);
}

Result<Fit> fit_polynomial(const FitInput& set, const HyperParameters& parameters, const MethodOptions& options) {
  const auto columns =
      columns_of(set.terms, static_cast<int>(value_of(parameters, "order")), value_of(parameters, "rate terms") != 0);
  const data::SampleMatrix taken = set.x(Eigen::all, columns);
  auto fitted = fit_linear({taken, set.y, set.terms}, parameters, options);
  if (!fitted) return fitted;
  auto& polynomial = std::get<LinearModel>(fitted->function);
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(set.x.cols());
  weights(columns) = polynomial.weights;
  polynomial.weights = std::move(weights);
  return fitted;
}

}  // namespace gyrotherm::methods
