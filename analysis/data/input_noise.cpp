// SPDX-License-Identifier: Apache-2.0
#include "analysis/data/input_noise.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/quantity.hpp"

namespace gyrotherm::data {
namespace {

/// Quantity with an independent error: a temperature, a rate or a lag, represented as a factor.
using Quantity = Factor;

/// Computes the derivative of the term with respect to one quantity in each cluster. Empty if the term does not depend
/// on the quantity.
Result<Eigen::VectorXd> derivative(const Term& term, const Quantity& quantity, const Clusters& clusters) {
  Eigen::VectorXd sum;
  for (std::size_t k = 0; k < term.factors.size(); ++k) {
    for (const auto& [part, sign] : split_factor(term.factors[k])) {
      if (part != quantity) continue;
      Term others = term;
      others.factors.erase(others.factors.begin() + static_cast<std::ptrdiff_t>(k));
      if (sum.size() == 0) sum.setZero(clusters.temperature_c.rows());
      if (others.factors.empty()) {
        sum.array() += sign;
        continue;
      }
      const auto product = evaluate({others}, clusters);
      if (!product) return failure(product.error());
      sum += sign * product->col(0);
    }
  }
  return sum;
}

/// Returns the error of the quantity for an error of 1 K in the last mean of the thermometer.
double error_gain(const Quantity& quantity, double length_s) {
  switch (quantity.kind) {
    case FactorKind::rate: return kSecondsPerMinute / length_s;
    case FactorKind::lag: return std::exp(-length_s / quantity.time_constant_s);
    case FactorKind::temperature:
    case FactorKind::gradient: break;
  }
  return 1;
}

/// Adds the contribution of one quantity, with this standard uncertainty, to the covariance.
Result<void> add(const Quantity& quantity, double error, const std::vector<Term>& terms, const Clusters& clusters,
                 Eigen::MatrixXd& covariance) {
  std::vector<Eigen::Index> columns;
  SampleMatrix derivatives(clusters.temperature_c.rows(), 0);
  for (std::size_t j = 0; j < terms.size(); ++j) {
    const auto after = derivative(terms[j], quantity, clusters);
    if (!after) return failure(after.error());
    if (after->size() == 0) continue;
    columns.push_back(static_cast<Eigen::Index>(j));
    derivatives.conservativeResize(Eigen::NoChange, derivatives.cols() + 1);
    derivatives.rightCols<1>() = *after;
  }
  const double weight = error * error / static_cast<double>(std::max<Eigen::Index>(1, derivatives.rows()));
  covariance(columns, columns) += weight * (derivatives.transpose() * derivatives);
  return {};
}

/// Returns the standard uncertainty of each quantity in the terms.
Result<std::map<Quantity, double>> quantity_errors(const std::vector<Term>& terms, const Clusters& clusters,
                                                   const std::vector<double>& uncertainty_k) {
  const auto fail = [](std::string what) { return failure(FaultKind::usage, "uncertainty", std::move(what)); };
  if (uncertainty_k.size() != clusters.thermometers.size()) {
    return fail(
        fmt::format("{} thermometers have {} uncertainties", clusters.thermometers.size(), uncertainty_k.size()));
  }
  if (!std::ranges::all_of(uncertainty_k, [](double u) { return u >= 0 && std::isfinite(u); })) {
    return fail("expected numbers of at least 0");
  }
  std::map<Quantity, double> errors;
  for (const Term& term : terms) {
    for (const Factor& factor : term.factors) {
      for (const auto& [quantity, sign] : split_factor(factor)) {
        const auto at = std::ranges::find(clusters.thermometers, quantity.first) - clusters.thermometers.begin();
        errors[quantity] = uncertainty_k[static_cast<std::size_t>(at)] * error_gain(quantity, clusters.length_s);
      }
    }
  }
  return errors;
}

}  // namespace

Result<Eigen::MatrixXd> input_covariance(const std::vector<Term>& terms, const Clusters& clusters,
                                         const std::vector<double>& uncertainty_k) {
  if (const auto known = evaluate(terms, clusters); !known) return failure(known.error());
  const auto errors = quantity_errors(terms, clusters, uncertainty_k);
  if (!errors) return failure(errors.error());
  const auto count = static_cast<Eigen::Index>(terms.size());
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(count, count);
  for (const auto& [quantity, error] : *errors) {
    if (const auto added = add(quantity, error, terms, clusters, covariance); !added) return failure(added.error());
  }
  return covariance;
}

}  // namespace gyrotherm::data
