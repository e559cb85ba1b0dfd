// SPDX-License-Identifier: Apache-2.0
/// Inputs of a model: terms as the user writes them, their values over clusters, and their scaling.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "core/form.hpp"
#include "core/result.hpp"

namespace gyrotherm::data {

enum class FactorKind { temperature, gradient, rate, lag };
/// Returns the keyword for the kind: "temperature", "gradient", "rate", "lag".
[[nodiscard]] const char* name(FactorKind kind);

/// Quantity derived from thermometers: T_first (°C), T_first − T_second (°C), the causal dT_first/dt (°C/min), or the
/// causal lag of T_first (K). The lag is the temperature difference between T_first and a body that follows it with a
/// time constant (FirstOrderLag).
struct Factor {
  FactorKind kind{};
  std::string first;
  std::string second;  ///< gradient only
  /// Time constant of a lag, 1 … kLongestTimeConstantS.
  int time_constant_s{};
  auto operator<=>(const Factor&) const = default;
};

inline constexpr std::size_t kMostFactors = 3;
inline constexpr int kLongestTimeConstantS = 86400;

/// Input of a model: a temperature, a gradient (difference of two thermometers), a temperature rate or a lag, or a
/// product of up to kMostFactors of these. Factors are sorted, so A·B and B·A are the same term.
struct Term {
  std::vector<Factor> factors;
  auto operator<=>(const Term&) const = default;
};

void describe(auto& form, Like<Factor> auto& factor) {
  form("kind", one_of(factor.kind, {FactorKind::temperature, FactorKind::gradient, FactorKind::rate, FactorKind::lag}));
  form("first", factor.first);
  form.if_present("second", factor.kind == FactorKind::gradient, factor.second);
  form.expect("second", (factor.kind == FactorKind::gradient) == !factor.second.empty(),
              "expected for a gradient and only for a gradient");
  form.if_present("time_constant_s", factor.kind == FactorKind::lag,
                  positive(factor.time_constant_s, kLongestTimeConstantS));
  form.expect("time_constant_s", (factor.kind == FactorKind::lag) == (factor.time_constant_s > 0),
              "expected for a lag and only for a lag");
}

[[nodiscard]] Term temperature_term(std::string thermometer);
[[nodiscard]] Term gradient_term(std::string first, std::string second);
[[nodiscard]] Term rate_term(std::string thermometer);
/// Makes a lag term. The time constant must be 1 … kLongestTimeConstantS seconds.
[[nodiscard]] Term lag_term(int time_constant_s, std::string thermometer);
/// Returns the product of two terms, which together must have at most kMostFactors factors.
[[nodiscard]] Term operator*(const Term& a, const Term& b);

/// Returns whether the term contains the rate of a thermometer.
[[nodiscard]] bool has_rate(const Term& term);

/// Splits a factor into signed measured or filtered quantities. A gradient is the difference of two temperatures; any
/// other factor is its only part.
[[nodiscard]] std::vector<std::pair<Factor, double>> split_factor(const Factor& factor);

/// Lists the distinct lags of the terms in order.
[[nodiscard]] std::vector<Factor> lags_in(const std::vector<Term>& terms);
/// Returns the term with each lag replaced by the temperature of a thermometer called lag_name, for callers that
/// compute the lags themselves.
[[nodiscard]] Term replace_lags(Term term);
/// Returns a name for the lag that cannot be the name of a thermometer.
[[nodiscard]] std::string lag_name(const Factor& lag);

/// Parses "A", "A-B", "rate:A", "lag:600:A" (lag of A with a time constant of 600 s, in whole seconds), a power such as
/// "A^2" ("A-B^2" is the square of A-B), or a product such as "A*rate:A" and "A*A-B". A thermometer name may contain
/// '-', '*' and '^'; text that matches a whole name is read as that name. Fails with usage and suggests the nearest
/// thermometer.
[[nodiscard]] Result<Term> parse_term(std::string_view text, const std::vector<std::string>& thermometers);
/// Returns text that parse_term reads as the same term, unless it equals the name of another thermometer.
[[nodiscard]] std::string to_string(const Term& term);

/// Describes a term. The text is for users; the factors are unambiguous even if a thermometer name contains '-'.
void describe(auto& form, Like<Term> auto& term) {
  auto text = to_string(term);
  form("term", text);
  form("factors", term.factors);
  form.expect("factors", !term.factors.empty() && term.factors.size() <= kMostFactors, "expected one to three");
  if constexpr (!std::is_const_v<std::remove_reference_t<decltype(term)>>) std::ranges::sort(term.factors);
  form.expect("term", text == to_string(term), "does not match its factors");
}

/// Row-major matrix with one sample per row; each sample is contiguous.
using SampleMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Causal first-order lag of a temperature: the difference T − F between the temperature T of a thermometer and the
/// temperature F of a body that follows it with the time constant τ, dF/dt = (T − F)/τ. The body starts in equilibrium:
/// F equals the first temperature. T is taken as a staircase; each temperature applies to the whole time since the
/// previous one. The exact solution is then T_k − F_k = exp(−Δt/τ) (T_k − F_{k−1}), the zero-order-hold equivalent
/// (Franklin, Powell, Workman, Digital Control of Dynamic Systems (1998), §4.3.3). A gap is one long step. After a gap
/// of many τ the body is in equilibrium again.
class FirstOrderLag {
 public:
  explicit FirstOrderLag(double time_constant_s) : time_constant_s_(time_constant_s) {}

  /// Advances the body by `elapsed_s` at this temperature and returns its lag T − F, K.
  double push(double temperature_c, double elapsed_s);

 private:
  double time_constant_s_;
  /// F. NaN before the first temperature.
  double followed_c_ = std::numeric_limits<double>::quiet_NaN();
};

/// Returns the gradients of all pairs i < j of the named thermometers: 28 for A…H.
[[nodiscard]] std::vector<Term> all_gradients(const std::vector<std::string>& names);

/// Computes the values of the terms, clusters × terms, unscaled. Lags use the history of the whole runs, even if only
/// some of their clusters are selected; if a cluster has no mean of a thermometer, the next step is longer
/// (FirstOrderLag). Fails with usage if a thermometer is not in the clusters, or if a lag is required and the history
/// is unknown.
[[nodiscard]] Result<SampleMatrix> evaluate(const std::vector<Term>& terms, const Clusters& clusters);

/// Returns the rank of the terms as polynomials of the temperatures, their rates and lags. For example, 13 gradients
/// that connect all of A…H have rank 7.
[[nodiscard]] int polynomial_rank(const std::vector<Term>& terms);

/// Scaling that gives the inputs it was fitted to zero mean and unit STD.
struct Scaling {
  Eigen::RowVectorXd mean;
  Eigen::RowVectorXd std;
};
/// Fits the scaling to `values`, one column per term. Fails with usage and names the term if a column does not vary.
[[nodiscard]] Result<Scaling> fit_scaling(const SampleMatrix& values, const std::vector<Term>& terms);
[[nodiscard]] SampleMatrix apply(const Scaling& scaling, const SampleMatrix& values);

}  // namespace gyrotherm::data
