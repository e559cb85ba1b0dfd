#include "analysis/features.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <utility>

#include "core/nearest.hpp"

namespace gyrotherm {
namespace {

constexpr std::string_view kRatePrefix = "rate:";
constexpr std::string_view kSquareSuffix = "^2";

bool contains(const std::vector<std::string>& names, std::string_view name) {
  return std::ranges::find(names, name) != names.end();
}

tl::unexpected<Fault> unknown(std::string_view term, std::string_view name,
                              const std::vector<std::string>& thermometers) {
  const std::string meant = nearest(name, thermometers);
  return failure(FaultKind::usage, fmt::format("input \"{}\"", term),
                 fmt::format("no thermometer \"{}\"{}; there are {}", name,
                             meant.empty() ? "" : fmt::format(", did you mean \"{}\"?", meant),
                             thermometers.empty() ? "none" : fmt::format("{}", fmt::join(thermometers, ", "))));
}

/// Splits at each '-' in turn, since a name may hold one; what is unknown is said of the first split.
Result<Term> parse_gradient(std::string_view text, const std::vector<std::string>& thermometers) {
  for (auto dash = text.find('-'); dash != text.npos; dash = text.find('-', dash + 1)) {
    const auto first = text.substr(0, dash), second = text.substr(dash + 1);
    if (!contains(thermometers, first) || !contains(thermometers, second)) continue;
    if (first != second) return Term{TermKind::gradient, std::string(first), std::string(second)};
    return failure(FaultKind::usage, fmt::format("input \"{}\"", text), "a thermometer differs from itself by nothing");
  }
  const auto dash = text.find('-');
  if (dash == text.npos) return unknown(text, text, thermometers);
  const auto first = text.substr(0, dash), second = text.substr(dash + 1);
  return unknown(text, contains(thermometers, first) ? second : first, thermometers);
}

Result<Term> parse_single(TermKind kind, std::string_view text, std::string_view name,
                          const std::vector<std::string>& thermometers) {
  if (!contains(thermometers, name)) return unknown(text, name, thermometers);
  return Term{kind, std::string(name), ""};
}

Result<Eigen::Index> column_of(const Clusters& clusters, const std::string& name, const Term& term) {
  const auto at = std::ranges::find(clusters.thermometers, name);
  if (at == clusters.thermometers.end()) return unknown(text(term), name, clusters.thermometers);
  return at - clusters.thermometers.begin();
}

Result<Eigen::VectorXd> values_of(const Term& term, const Clusters& clusters) {
  const auto first = column_of(clusters, term.first, term);
  if (!first) return failure(first.error());
  const auto temperature = clusters.temperature_c.col(*first);
  switch (term.kind) {
    case TermKind::temperature: return temperature;
    case TermKind::rate: return clusters.rate_c_per_min.col(*first);
    case TermKind::squared: return temperature.cwiseAbs2();
    case TermKind::gradient: break;
  }
  const auto second = column_of(clusters, term.second, term);
  if (!second) return failure(second.error());
  return temperature - clusters.temperature_c.col(*second);
}

}  // namespace

Result<Term> parse_term(std::string_view text, const std::vector<std::string>& thermometers) {
  if (contains(thermometers, text)) return Term{TermKind::temperature, std::string(text), ""};
  if (text.starts_with(kRatePrefix)) {
    return parse_single(TermKind::rate, text, text.substr(kRatePrefix.size()), thermometers);
  }
  if (text.ends_with(kSquareSuffix)) {
    return parse_single(TermKind::squared, text, text.substr(0, text.size() - kSquareSuffix.size()), thermometers);
  }
  return parse_gradient(text, thermometers);
}

std::string text(const Term& term) {
  switch (term.kind) {
    case TermKind::temperature: return term.first;
    case TermKind::gradient: return term.first + "-" + term.second;
    case TermKind::rate: return std::string(kRatePrefix) + term.first;
    case TermKind::squared: return term.first + std::string(kSquareSuffix);
  }
  return {};
}

std::vector<Term> all_gradients(const std::vector<std::string>& names) {
  std::vector<Term> terms;
  for (std::size_t i = 0; i < names.size(); ++i) {
    for (std::size_t j = i + 1; j < names.size(); ++j) terms.push_back({TermKind::gradient, names[i], names[j]});
  }
  return terms;
}

Result<SampleMatrix> evaluate(const std::vector<Term>& terms, const Clusters& clusters) {
  SampleMatrix values(clusters.temperature_c.rows(), static_cast<Eigen::Index>(terms.size()));
  for (std::size_t j = 0; j < terms.size(); ++j) {
    const auto column = values_of(terms[j], clusters);
    if (!column) return failure(column.error());
    values.col(static_cast<Eigen::Index>(j)) = *column;
  }
  return values;
}

int rank_of(const std::vector<Term>& terms) {
  if (terms.empty()) return 0;
  // One axis per temperature, per rate and per square; a gradient is the difference of two temperature axes.
  std::map<std::pair<TermKind, std::string>, Eigen::Index> axes;
  const auto axis = [&](TermKind kind, const std::string& name) {
    return axes.try_emplace({kind, name}, static_cast<Eigen::Index>(axes.size())).first->second;
  };
  const auto count = static_cast<Eigen::Index>(terms.size());
  Eigen::MatrixXd directions = Eigen::MatrixXd::Zero(count, 2 * count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Term& term = terms[i];
    const bool gradient = term.kind == TermKind::gradient;
    directions(i, axis(gradient ? TermKind::temperature : term.kind, term.first)) += 1;
    if (gradient) directions(i, axis(TermKind::temperature, term.second)) -= 1;
  }
  return static_cast<int>(directions.fullPivLu().rank());
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
