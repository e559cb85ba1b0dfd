// SPDX-License-Identifier: Apache-2.0
/// The inputs of a model: terms as a user writes them, their values over clusters, and their scaling.
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
/// The word for the kind: "temperature", "gradient", "rate", "lag".
[[nodiscard]] const char* name(FactorKind kind);

/// One quantity of the thermometers: T_first (°C), T_first − T_second (°C), the causal dT_first/dt (°C/min), or the
/// causal lag of T_first (K): by how much a body that follows it with a time constant lags behind (FirstOrderLag).
struct Factor {
  FactorKind kind{};
  std::string first;
  std::string second;     ///< gradient only
  int time_constant_s{};  ///< lag only, 1 … kLongestTimeConstantS
  auto operator<=>(const Factor&) const = default;
};

inline constexpr std::size_t kMostFactors = 3;
inline constexpr int kLongestTimeConstantS = 86400;

/// One input of a model: a temperature, a gradient (the difference of two thermometers), a temperature rate or a lag,
/// or the product of up to kMostFactors of these. Factors are kept in order: A·B and B·A are the same term.
struct Term {
  std::vector<Factor> factors;
  auto operator<=>(const Term&) const = default;
};

void describe(auto& form, Like<Factor> auto& factor) {
  form("kind", one_of(factor.kind, {FactorKind::temperature, FactorKind::gradient, FactorKind::rate, FactorKind::lag}));
  form("first", factor.first);
  form.if_there("second", factor.kind == FactorKind::gradient, factor.second);
  form.expect("second", (factor.kind == FactorKind::gradient) == !factor.second.empty(),
              "expected of a gradient, and of nothing else");
  form.if_there("time_constant_s", factor.kind == FactorKind::lag,
                positive(factor.time_constant_s, kLongestTimeConstantS));
  form.expect("time_constant_s", (factor.kind == FactorKind::lag) == (factor.time_constant_s > 0),
              "expected of a lag, and of nothing else");
}

[[nodiscard]] Term temperature_term(std::string thermometer);
[[nodiscard]] Term gradient_term(std::string first, std::string second);
[[nodiscard]] Term rate_term(std::string thermometer);
/// The time constant is of 1 … kLongestTimeConstantS seconds.
[[nodiscard]] Term lag_term(int time_constant_s, std::string thermometer);
/// The product of two terms, which have kMostFactors factors at most together.
[[nodiscard]] Term operator*(const Term& a, const Term& b);

/// True if the term needs the rate of a thermometer.
[[nodiscard]] bool has_rate(const Term& term);

/// A factor as a sum of what is measured or kept, each with its sign: a gradient is the difference of two temperatures,
/// any other factor is itself.
[[nodiscard]] std::vector<std::pair<Factor, double>> parts_of(const Factor& factor);

/// The lags that terms are made of, each once, in order.
[[nodiscard]] std::vector<Factor> lags_in(const std::vector<Term>& terms);
/// The term with each lag as the temperature of a thermometer called lag_name: for whoever keeps the lags himself.
[[nodiscard]] Term with_lags_as_temperatures(Term term);
/// A name that no thermometer of a record has.
[[nodiscard]] std::string lag_name(const Factor& lag);

/// Reads "A", "A-B", "rate:A", "lag:600:A" (the lag of A with a time constant of 600 s, whole seconds), a power of one
/// like "A^2" ("A-B^2" is the square of the difference), or a product like "A*rate:A" and "A*A-B". A thermometer's name
/// may hold '-', '*' and '^': what can be read as a whole name is. Fails with usage, naming the nearest thermometer.
[[nodiscard]] Result<Term> parse_term(std::string_view text, const std::vector<std::string>& thermometers);
/// The text that parse_term reads as the same term, unless another thermometer bears that very name.
[[nodiscard]] std::string to_string(const Term& term);

/// The words are for people; the factors say the same where a thermometer's name holds a '-'.
void describe(auto& form, Like<Term> auto& term) {
  auto words = to_string(term);
  form("term", words);
  form("factors", term.factors);
  form.expect("factors", !term.factors.empty() && term.factors.size() <= kMostFactors, "expected one to three");
  if constexpr (!std::is_const_v<std::remove_reference_t<decltype(term)>>) std::ranges::sort(term.factors);
  form.expect("term", words == to_string(term), "does not say the same as its factors");
}

/// Rows are samples, row-major so that a sample is contiguous.
using SampleMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// The causal first-order lag of a temperature: what a body that follows a thermometer slowly has not yet followed. The
/// body follows the temperature T of the thermometer with the time constant τ: dF/dt = (T − F)/τ. It starts in
/// balance: F is the first temperature. T is taken as a staircase of the temperatures given, each since the one before
/// it, for which T_k − F_k = exp(−Δt/τ) (T_k − F_{k−1}) is the exact solution (the zero-order-hold equivalent;
/// Franklin, Powell, Workman, Digital Control of Dynamic Systems (1998), §4.3.3). A gap is a long step: over one of
/// many τ the body is in balance again.
class FirstOrderLag {
 public:
  explicit FirstOrderLag(double time_constant_s) : time_constant_s_(time_constant_s) {}

  /// By how much the body lags behind, T − F in K, once this temperature has lasted for `elapsed_s`.
  double push(double temperature_c, double elapsed_s);

 private:
  double time_constant_s_;
  double followed_c_ = std::numeric_limits<double>::quiet_NaN();  ///< F; NaN before the first temperature
};

/// All pairs i before j of the named thermometers: 28 for A…H.
[[nodiscard]] std::vector<Term> all_gradients(const std::vector<std::string>& names);

/// The values of the terms, clusters × terms, unscaled. Lags are those of the clusters' whole runs, however few of the
/// clusters are looked at; a cluster without a thermometer's mean is a longer step (FirstOrderLag). Fails with usage if
/// a thermometer is not in the clusters, or a lag is asked for and the history is not known.
[[nodiscard]] Result<SampleMatrix> evaluate(const std::vector<Term>& terms, const Clusters& clusters);

/// The rank of the terms as polynomials of the temperatures, their rates and lags (13 gradients that contain all of A
/// have rank 7).
[[nodiscard]] int rank_of(const std::vector<Term>& terms);

/// What makes the inputs that it was fitted to have zero mean and unit STD.
struct Scaling {
  Eigen::RowVectorXd mean;
  Eigen::RowVectorXd std;
};
/// Learns the scaling of `values`, a column per term. Fails with usage, naming the term, if a column does not vary.
[[nodiscard]] Result<Scaling> fit_scaling(const SampleMatrix& values, const std::vector<Term>& terms);
[[nodiscard]] SampleMatrix apply(const Scaling& scaling, const SampleMatrix& values);

}  // namespace gyrotherm::data
