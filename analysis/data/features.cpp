// SPDX-License-Identifier: Apache-2.0
#include "analysis/data/features.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cassert>
#include <charconv>
#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <utility>

#include "core/text.hpp"

namespace gyrotherm::data {
namespace {

constexpr std::string_view kRatePrefix = "rate:", kLagPrefix = "lag:";

bool contains(const std::vector<std::string>& names, std::string_view name) {
  return std::ranges::find(names, name) != names.end();
}

std::string input_location(std::string_view term) { return fmt::format("input \"{}\"", term); }

/// Parser of one term. All error messages quote the whole text.
class TermReader {
 public:
  TermReader(std::string_view whole, const std::vector<std::string>& thermometers)
      : whole_(whole), thermometers_(thermometers) {}

  /// Tries to split at each '*' in turn, since a name may contain one. If no split parses, returns the error of the
  /// first.
  [[nodiscard]] Result<Term> product(std::string_view text) const {
    auto best = power(text);
    for (auto star = text.find('*'); star != text.npos && !best; star = text.find('*', star + 1)) {
      const auto first = power(text.substr(0, star));
      const auto remainder = first ? product(text.substr(star + 1)) : first;
      if (!first || !remainder) {
        if (star == text.find('*')) best = failure(remainder.error());
        continue;
      }
      if (first->factors.size() + remainder->factors.size() > kMostFactors) return too_many();
      return *first * *remainder;
    }
    return best;
  }

 private:
  [[nodiscard]] tl::unexpected<Fault> too_many() const {
    return failure(FaultKind::usage, input_location(whole_), fmt::format("has more than {} factors", kMostFactors));
  }

  [[nodiscard]] tl::unexpected<Fault> unknown(std::string_view name) const {
    if (is_own_value(name))
      return failure(FaultKind::usage, input_location(whole_),
                     fmt::format("the record has no such value of the unit{}", list_own_values()));
    const std::string suggestion = find_nearest(name, thermometers_);
    return failure(FaultKind::usage, input_location(whole_),
                   fmt::format("no thermometer \"{}\"; the record has {}{}", name,
                               thermometers_.empty() ? "none" : fmt::format("{}", fmt::join(thermometers_, ", ")),
                               suggestion.empty() ? "" : fmt::format("; did you mean \"{}\"?", suggestion)));
  }

  /// Returns "; it has aux:current", or an empty text if the unit reports no values of its own.
  [[nodiscard]] std::string list_own_values() const {
    std::vector<std::string> own;
    std::ranges::copy_if(thermometers_, std::back_inserter(own), is_own_value);
    return own.empty() ? std::string() : fmt::format("; it has {}", fmt::join(own, ", "));
  }

  [[nodiscard]] Result<Term> power(std::string_view text) const {
    auto single = factor(text);
    const auto caret = text.rfind('^');
    if (single || caret == text.npos) return single;
    single = factor(text.substr(0, caret));
    if (!single) return single;
    const auto times = text.substr(caret + 1);
    if (times == "2") return *single * *single;
    if (times == "3") return *single * *single * *single;
    return failure(FaultKind::usage, input_location(whole_),
                   fmt::format("expected the power ^2 or ^3, got ^{}", times));
  }

  [[nodiscard]] Result<Term> factor(std::string_view text) const {
    if (contains(thermometers_, text)) return temperature_term(std::string(text));
    if (text.starts_with(kLagPrefix)) return lag(text.substr(kLagPrefix.size()));
    if (!text.starts_with(kRatePrefix)) return gradient(text);
    const std::string_view name = text.substr(kRatePrefix.size());
    if (!contains(thermometers_, name)) return unknown(name);
    return rate_term(std::string(name));
  }

  /// Reads the part of a lag after its prefix: "600:A".
  [[nodiscard]] Result<Term> lag(std::string_view text) const {
    const auto colon = text.find(':');
    int time_constant_s = 0;
    const std::string_view digits = text.substr(0, colon);
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), time_constant_s);
    const bool whole = error == std::errc{} && end == digits.data() + digits.size();
    if (colon == text.npos || !whole || time_constant_s < 1 || time_constant_s > kLongestTimeConstantS) {
      return failure(FaultKind::usage, input_location(whole_),
                     fmt::format("expected lag:SECONDS:THERMOMETER with 1 to {} whole seconds", kLongestTimeConstantS));
    }
    const std::string_view name = text.substr(colon + 1);
    if (!contains(thermometers_, name)) return unknown(name);
    return lag_term(time_constant_s, std::string(name));
  }

  /// Tries to split at each '-' in turn, since a name may contain one. If no split parses, returns the error of the
  /// first.
  [[nodiscard]] Result<Term> gradient(std::string_view text) const {
    for (auto dash = text.find('-'); dash != text.npos; dash = text.find('-', dash + 1)) {
      const auto first = text.substr(0, dash), second = text.substr(dash + 1);
      if (!contains(thermometers_, first) || !contains(thermometers_, second)) continue;
      if (first != second) return gradient_term(std::string(first), std::string(second));
      return failure(FaultKind::usage, input_location(whole_), "a gradient needs two different thermometers");
    }
    const auto dash = text.find('-');
    if (dash == text.npos) return unknown(text);
    const auto first = text.substr(0, dash), second = text.substr(dash + 1);
    return unknown(contains(thermometers_, first) ? second : first);
  }

  std::string_view whole_;
  const std::vector<std::string>& thermometers_;
};

std::string to_string(const Factor& factor) {
  switch (factor.kind) {
    case FactorKind::temperature: return factor.first;
    case FactorKind::gradient: return factor.first + "-" + factor.second;
    case FactorKind::rate: return std::string(kRatePrefix) + factor.first;
    case FactorKind::lag: return fmt::format("{}{}:{}", kLagPrefix, factor.time_constant_s, factor.first);
  }
  return {};
}

Result<Eigen::Index> find_column(const Clusters& clusters, const std::string& name, const Term& term) {
  const auto at = std::ranges::find(clusters.thermometers, name);
  if (at != clusters.thermometers.end()) return at - clusters.thermometers.begin();
  return failure(
      FaultKind::usage, fmt::format("input \"{}\"", to_string(term)),
      fmt::format("no thermometer \"{}\", with which the model was trained; the record has {}", name,
                  clusters.thermometers.empty() ? "none" : fmt::format("{}", fmt::join(clusters.thermometers, ", "))));
}

/// Computes the lag of one thermometer in each row of the history, K. The lag is 0 in the first row of each run that
/// has a temperature. The lag is NaN if the temperature is missing; the next step is then longer.
Eigen::VectorXd compute_lag(const TemperatureHistory& history, Eigen::Index thermometer, double time_constant_s) {
  FirstOrderLag lag(time_constant_s);
  Eigen::VectorXd values(history.elapsed_s.size());
  // Time since the last known temperature.
  double elapsed_s = 0;
  for (Eigen::Index k = 0; k < values.size(); ++k) {
    const double temperature_c = history.temperature_c(k, thermometer);
    elapsed_s += history.elapsed_s(k);
    values(k) = std::isnan(temperature_c) ? temperature_c : lag.push(temperature_c, elapsed_s);
    if (!std::isnan(temperature_c)) elapsed_s = 0;
  }
  return values;
}

Result<Eigen::VectorXd> lag_values(const Factor& factor, Eigen::Index column, const Clusters& clusters) {
  if (!has_history(clusters))
    return failure(FaultKind::usage, input_location(to_string(factor)), "needs the temperatures of the whole run");
  return compute_lag(clusters.history, column, factor.time_constant_s)(clusters.moments).eval();
}

Result<Eigen::VectorXd> factor_values(const Factor& factor, const Term& term, const Clusters& clusters) {
  const auto first = find_column(clusters, factor.first, term);
  if (!first) return failure(first.error());
  if (factor.kind == FactorKind::rate) return clusters.rate_c_per_min.col(*first);
  if (factor.kind == FactorKind::temperature) return clusters.temperature_c.col(*first);
  if (factor.kind == FactorKind::lag) return lag_values(factor, *first, clusters);
  const auto second = find_column(clusters, factor.second, term);
  if (!second) return failure(second.error());
  return clusters.temperature_c.col(*first) - clusters.temperature_c.col(*second);
}

/// Polynomial in temperatures, rates and lags: the coefficient of each product. The factors of each product are sorted.
using Axis = Factor;
using Polynomial = std::map<std::vector<Axis>, double>;

Polynomial make_polynomial(const Factor& factor) {
  Polynomial sum;
  for (const auto& [part, sign] : split_factor(factor)) sum[{part}] = sign;
  return sum;
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

Polynomial make_polynomial(const Term& term) {
  Polynomial result{{{}, 1}};
  for (const Factor& factor : term.factors) result = product(result, make_polynomial(factor));
  return result;
}

}  // namespace

const char* name(FactorKind kind) {
  constexpr const char* kNames[] = {"temperature", "gradient", "rate", "lag"};
  return kNames[static_cast<std::size_t>(kind)];
}

double FirstOrderLag::push(double temperature_c, double elapsed_s) {
  assert(elapsed_s > 0);
  if (std::isnan(followed_c_)) followed_c_ = temperature_c;
  const double behind = std::exp(-elapsed_s / time_constant_s_) * (temperature_c - followed_c_);
  followed_c_ = temperature_c - behind;
  return behind;
}

Term temperature_term(std::string thermometer) { return {{{FactorKind::temperature, std::move(thermometer), {}}}}; }

Term gradient_term(std::string first, std::string second) {
  return {{{FactorKind::gradient, std::move(first), std::move(second)}}};
}

Term rate_term(std::string thermometer) { return {{{FactorKind::rate, std::move(thermometer), {}}}}; }

Term lag_term(int time_constant_s, std::string thermometer) {
  assert(time_constant_s >= 1 && time_constant_s <= kLongestTimeConstantS);
  return {{{FactorKind::lag, std::move(thermometer), {}, time_constant_s}}};
}

Term operator*(const Term& a, const Term& b) {
  Term product = a;
  product.factors.insert(product.factors.end(), b.factors.begin(), b.factors.end());
  assert(product.factors.size() <= kMostFactors);
  std::ranges::sort(product.factors);
  return product;
}

bool has_rate(const Term& term) { return std::ranges::count(term.factors, FactorKind::rate, &Factor::kind) > 0; }

std::vector<std::pair<Factor, double>> split_factor(const Factor& factor) {
  if (factor.kind != FactorKind::gradient) return {{factor, 1}};
  return {{{FactorKind::temperature, factor.first, {}}, 1}, {{FactorKind::temperature, factor.second, {}}, -1}};
}

std::vector<Factor> lags_in(const std::vector<Term>& terms) {
  std::set<Factor> lags;
  for (const Term& term : terms)
    std::ranges::copy_if(term.factors, std::inserter(lags, lags.end()),
                         [](const Factor& factor) { return factor.kind == FactorKind::lag; });
  return {lags.begin(), lags.end()};
}

/// A thermometer name in a record cannot contain a line break.
std::string lag_name(const Factor& lag) { return '\n' + to_string(lag); }

Term replace_lags(Term term) {
  // The factors keep their order, which keeps their product bit-identical.
  for (Factor& factor : term.factors)
    if (factor.kind == FactorKind::lag) factor = {FactorKind::temperature, lag_name(factor), {}};
  return term;
}

Result<Term> parse_term(std::string_view text, const std::vector<std::string>& thermometers) {
  return TermReader(text, thermometers).product(text);
}

std::string to_string(const Term& term) {
  std::string text;
  for (auto factor = term.factors.begin(); factor != term.factors.end();) {
    const auto next = std::find_if(factor, term.factors.end(), [&](const Factor& other) { return other != *factor; });
    if (!text.empty()) text += '*';
    text += to_string(*factor);
    if (next - factor > 1) text += fmt::format("^{}", next - factor);
    factor = next;
  }
  return text;
}

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
      const auto column = factor_values(factor, terms[j], clusters);
      if (!column) return failure(column.error());
      values.col(static_cast<Eigen::Index>(j)).array() *= column->array();
    }
  }
  return values;
}

int polynomial_rank(const std::vector<Term>& terms) {
  if (terms.empty()) return 0;
  std::vector<Polynomial> polynomials;
  std::map<std::vector<Axis>, Eigen::Index> columns;
  for (const Term& term : terms) {
    polynomials.push_back(make_polynomial(term));
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
  if (values.rows() < 2)
    return failure(FaultKind::usage, "scaling",
                   "at least two clusters are needed; use longer records or shorter clusters");
  Scaling scaling;
  scaling.mean = values.colwise().mean();
  scaling.std =
      ((values.rowwise() - scaling.mean).colwise().squaredNorm() / static_cast<double>(values.rows() - 1)).cwiseSqrt();
  const Eigen::RowVectorXd largest = values.cwiseAbs().colwise().maxCoeff();
  for (Eigen::Index j = 0; j < values.cols(); ++j) {
    constexpr double kRounding = 1e-12;
    if (scaling.std(j) > kRounding * largest(j)) continue;
    return failure(FaultKind::usage, fmt::format("input \"{}\"", to_string(terms[j])),
                   "does not vary over the training clusters");
  }
  return scaling;
}

SampleMatrix apply(const Scaling& scaling, const SampleMatrix& values) {
  return ((values.rowwise() - scaling.mean).array().rowwise() / scaling.std.array()).matrix();
}

}  // namespace gyrotherm::data
