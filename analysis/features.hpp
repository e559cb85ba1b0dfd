/// The inputs of a model: temperatures, gradients (differences of two thermometers), temperature rates, and their
/// scaling.
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/clusters.hpp"
#include "analysis/svr.hpp"
#include "core/result.hpp"

namespace gyrotherm {

enum class TermKind { temperature, gradient, rate, squared };

/// T_first, T_first − T_second, causal dT_first/dt (°C/min), or T_first².
struct Term {
  TermKind kind{};
  std::string first;
  std::string second;  ///< gradient only
  auto operator<=>(const Term&) const = default;
};

/// "A", "A-B", "rate:A", "A^2". Fails with usage, naming the nearest thermometer. A name that holds a '-' is matched
/// whole first.
[[nodiscard]] Result<Term> parse_term(std::string_view text, const std::vector<std::string>& thermometers);
[[nodiscard]] std::string text(const Term& term);

/// All pairs i before j of the named thermometers: 28 for A…H.
[[nodiscard]] std::vector<Term> all_gradients(const std::vector<std::string>& names);

/// Clusters × terms, unscaled. Fails with usage if a thermometer is not in the clusters.
[[nodiscard]] Result<SampleMatrix> evaluate(const std::vector<Term>& terms, const Clusters& clusters);

/// Numerical rank of the terms as functions of the temperatures (13 gradients that contain all of A have rank 7).
[[nodiscard]] int rank_of(const std::vector<Term>& terms);

/// Zero mean and unit STD on the data it was fitted to.
struct Scaling {
  Eigen::RowVectorXd mean;
  Eigen::RowVectorXd std;
};
/// Fails with usage, naming the term, if a column does not vary.
[[nodiscard]] Result<Scaling> fit_scaling(const SampleMatrix& values, const std::vector<Term>& terms);
[[nodiscard]] SampleMatrix apply(const Scaling& scaling, const SampleMatrix& values);

}  // namespace gyrotherm
