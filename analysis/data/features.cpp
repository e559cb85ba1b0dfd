#include "analysis/data/features.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <utility>

namespace gyrotherm {
namespace {

Result<Eigen::Index> column_of(const Clusters& clusters, const std::string& name, const Term& term) {
  const auto at = std::ranges::find(clusters.thermometers, name);
  if (at != clusters.thermometers.end()) return at - clusters.thermometers.begin();
  return failure(
      FaultKind::usage, fmt::format("input \"{}\"", text(term)),
      fmt::format("no thermometer \"{}\"; there are {}", name,
                  clusters.thermometers.empty() ? "none" : fmt::format("{}", fmt::join(clusters.thermometers, ", "))));
}

Result<Eigen::VectorXd> values_of(const Factor& factor, const Term& term, const Clusters& clusters) {
  const auto first = column_of(clusters, factor.first, term);
  if (!first) return failure(first.error());
  if (factor.kind == FactorKind::rate) return clusters.rate_c_per_min.col(*first);
  if (factor.kind == FactorKind::temperature) return clusters.temperature_c.col(*first);
  const auto second = column_of(clusters, factor.second, term);
  if (!second) return failure(second.error());
  return clusters.temperature_c.col(*first) - clusters.temperature_c.col(*second);
}

/// A polynomial of temperatures and rates: products of axes, each in order, with their coefficients.
using Axis = std::pair<FactorKind, std::string>;
using Polynomial = std::map<std::vector<Axis>, double>;

Polynomial polynomial_of(const Factor& factor) {
  if (factor.kind != FactorKind::gradient) return {{{{factor.kind, factor.first}}, 1}};
  return {{{{FactorKind::temperature, factor.first}}, 1}, {{{FactorKind::temperature, factor.second}}, -1}};
}

Polynomial product(const Polynomial& a, const Polynomial& b) {
  Polynomial result;
  for (const auto& [left, weight] : a) {
    for (const auto& [right, other] : b) {
      std::vector<Axis> axes = left;
      axes.insert(axes.end(), right.begin(), right.end());
      std::ranges::sort(axes);
      result[std::move(axes)] += weight * other;
    }
  }
  return result;
}

Polynomial polynomial_of(const Term& term) {
  Polynomial result{{{}, 1}};
  for (const Factor& factor : term.factors) result = product(result, polynomial_of(factor));
  return result;
}

}  // namespace

std::vector<Term> all_gradients(const std::vector<std::string>& names) {
  std::vector<Term> terms;
  for (std::size_t i = 0; i < names.size(); ++i) {
    for (std::size_t j = i + 1; j < names.size(); ++j) terms.push_back(gradient_term(names[i], names[j]));
  }
  return terms;
}

Result<SampleMatrix> evaluate(const std::vector<Term>& terms, const Clusters& clusters) {
  SampleMatrix values = SampleMatrix::Ones(clusters.temperature_c.rows(), static_cast<Eigen::Index>(terms.size()));
  for (std::size_t j = 0; j < terms.size(); ++j) {
    assert(!terms[j].factors.empty());
    for (const Factor& factor : terms[j].factors) {
      const auto column = values_of(factor, terms[j], clusters);
      if (!column) return failure(column.error());
      values.col(static_cast<Eigen::Index>(j)).array() *= column->array();
    }
  }
  return values;
}

int rank_of(const std::vector<Term>& terms) {
  if (terms.empty()) return 0;
  std::vector<Polynomial> polynomials;
  std::map<std::vector<Axis>, Eigen::Index> columns;
  for (const Term& term : terms) {
    polynomials.push_back(polynomial_of(term));
    for (const auto& [axes, weight] : polynomials.back()) {
      columns.try_emplace(axes, static_cast<Eigen::Index>(columns.size()));
    }
  }
  Eigen::MatrixXd weights =
      Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(terms.size()), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t i = 0; i < terms.size(); ++i) {
    for (const auto& [axes, weight] : polynomials[i]) weights(static_cast<Eigen::Index>(i), columns.at(axes)) = weight;
  }
  return static_cast<int>(weights.fullPivLu().rank());
}

Result<Scaling> fit_scaling(const SampleMatrix& values, const std::vector<Term>& terms) {
  assert(values.cols() == static_cast<Eigen::Index>(terms.size()));
  if (values.rows() < 2) return failure(FaultKind::usage, "scaling", "fewer than two clusters to scale by");
  Scaling scaling;
  scaling.mean = values.colwise().mean();
  scaling.std =
      ((values.rowwise() - scaling.mean).colwise().squaredNorm() / static_cast<double>(values.rows() - 1)).cwiseSqrt();
  const Eigen::RowVectorXd largest = values.cwiseAbs().colwise().maxCoeff();
  for (Eigen::Index j = 0; j < values.cols(); ++j) {
    constexpr double kRounding = 1e-12;
    if (scaling.std(j) > kRounding * largest(j)) continue;
    return failure(FaultKind::usage, fmt::format("input \"{}\"", text(terms[j])),
                   "does not vary over the training clusters");
  }
  return scaling;
}

SampleMatrix apply(const Scaling& scaling, const SampleMatrix& values) {
  return ((values.rowwise() - scaling.mean).array().rowwise() / scaling.std.array()).matrix();
}

}  // namespace gyrotherm
