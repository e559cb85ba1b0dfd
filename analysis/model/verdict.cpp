// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/verdict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "analysis/data/correlated_fit.hpp"
#include "analysis/data/distributions.hpp"
#include "core/count_text.hpp"
#include "core/number_text.hpp"

namespace gyrotherm::model {
namespace {

constexpr double kShare = 0.95;
constexpr double kFewestEffective = 5;

/// Paired comparison of one figure of the raw bias and of the residual.
struct Comparison {
  double raw{}, residual{};
  Reduction reduction;
  double effective{};
  bool is_smaller{}, is_larger{};
};

/// Compares the root mean squares of both, after subtraction of the means if `centred`.
Comparison compare(const Eigen::VectorXd& bias, const Eigen::VectorXd& residual, const Eigen::VectorXi& positions,
                   bool centred) {
  const auto count = static_cast<double>(bias.size());
  const double divisor = centred ? count - 1 : count;
  const Eigen::VectorXd prediction = bias - residual;
  const double mean_bias = bias.mean(), mean_prediction = prediction.mean();
  const Eigen::VectorXd b = bias.array() - mean_bias, p = prediction.array() - mean_prediction;
  const double mean_square = p.squaredNorm() / divisor, offset = centred ? 0 : mean_prediction;
  const auto root_mean_square = [&](const Eigen::VectorXd& values, double mean) {
    return std::sqrt(values.squaredNorm() / divisor + (centred ? 0 : mean * mean));
  };
  Comparison result{.raw = root_mean_square(b, mean_bias),
                    .residual = root_mean_square(b - p, mean_bias - mean_prediction),
                    .reduction = {0, 0},
                    .effective = count};
  constexpr double kRounding = 1e-12;
  const bool varies = p.norm() > kRounding * b.norm();
  if (!varies && offset == 0) return result;
  Eigen::MatrixXd x = Eigen::MatrixXd::Ones(bias.size(), varies ? 2 : 1);
  if (varies) x.col(0) = p;
  const int longest = positions(positions.size() - 1) - positions(0) + 1;
  const data::CorrelatedFit fit = data::fit_with_correlated_noise(x, b, positions, longest);
  result.effective = data::effective_number(fit.residual, positions).of_mean;
  const double k = data::coverage_factor(kShare, std::max(1.0, result.effective - 2));
  const double by_slope = varies ? (2 * fit.coefficients(0) - 1) * mean_square : 0;
  const double change = by_slope + offset * (2 * mean_bias - mean_prediction);
  const double u = 2 * std::hypot(varies ? mean_square * fit.u(0) : 0, offset * fit.u(fit.u.size() - 1));
  result.reduction = {result.raw - result.residual, u / (result.raw + result.residual)};
  result.is_smaller = change - k * u > 0;
  result.is_larger = change + k * u < 0;
  return result;
}

std::string describe_comparison(const char* what, const Comparison& compared) {
  constexpr int kDigits = 4;
  const auto& [change, error] = compared.reduction;
  return fmt::format("{} {} → {} °/h, {} by {}", what, format_digits(compared.raw, kDigits),
                     format_digits(compared.residual, kDigits), change < 0 ? "larger" : "smaller",
                     format_with_error(std::abs(change), error));
}

Gain decide(const Comparison& std, const Comparison& rmse, bool rmse_counts) {
  if (std.is_larger || (rmse_counts && rmse.is_larger)) return Gain::does_not_improve;
  if (std.is_smaller) return Gain::improves;
  return std.effective < kFewestEffective ? Gain::not_enough_data : Gain::undecided;
}

/// Returns whether a gain is undecided because the model removes an offset, but no variation.
bool removes_only_offset(Gain gain, const Comparison& rmse, bool rmse_counts) {
  return gain == Gain::undecided && rmse_counts && rmse.is_smaller;
}

/// Returns the reason for a gain that the figures alone do not explain; empty if there is none.
std::string explain(Gain gain, const Comparison& std, const Comparison& rmse, bool rmse_counts) {
  if (gain == Gain::does_not_improve && std.is_smaller) return "; the rmse counts, so the offset decides";
  if (removes_only_offset(gain, rmse, rmse_counts)) return "; only a constant offset is removed";
  if (gain == Gain::undecided) return "; the change of the std is within its uncertainty";
  if (gain == Gain::not_enough_data)
    return fmt::format("; only {:.1f} effective clusters, at least {:g} are needed", std.effective, kFewestEffective);
  return {};
}

}  // namespace

const char* name(Gain gain) {
  constexpr std::array kNames = {"improves", "does not improve", "undecided", "not enough data", "in-sample"};
  return kNames[static_cast<std::size_t>(gain)];
}

Verdict judge_gain(const Eigen::VectorXd& bias, const Eigen::VectorXd& residual, const data::Clusters& clusters,
                   const std::vector<Eigen::Index>& rows, BiasZero zero, int fewest) {
  assert(bias.size() == residual.size() && bias.size() == std::ssize(rows) && fewest >= 5);
  Verdict verdict{.statement = fmt::format("{}, at least {} are needed", format_count(rows.size(), "cluster"), fewest)};
  if (std::ssize(rows) < fewest) return verdict;
  const Eigen::VectorXi positions = cluster_positions(clusters, rows);
  const bool rmse_counts = zero != BiasZero::mean_of_first_hold;
  const Comparison std = compare(bias, residual, positions, true);
  const Comparison rmse = rmse_counts ? compare(bias, residual, positions, false) : Comparison{};
  verdict.gain = decide(std, rmse, rmse_counts);
  verdict.std_deg_per_h = std.reduction;
  if (rmse_counts) verdict.rmse_deg_per_h = rmse.reduction;
  verdict.effective = std.effective;
  verdict.only_offset = removes_only_offset(verdict.gain, rmse, rmse_counts);
  verdict.statement = describe_comparison("std", std);
  if (rmse_counts) verdict.statement += "; " + describe_comparison("rmse", rmse);
  verdict.statement += explain(verdict.gain, std, rmse, rmse_counts);
  if (!rmse_counts)
    verdict.statement += "; the zero is the mean of the record's first hold, so the rmse does not count";
  return verdict;
}

Verdict judge_held_out(const Eigen::VectorXd& residual, const data::Clusters& clusters, double effective_parameters) {
  constexpr int kFewest = 20;
  constexpr double kFewestPerParameter = 5;
  const std::vector<Eigen::Index> rows = data::finite_rows(residual);
  const Eigen::VectorXd raw = clusters.bias_deg_per_h(rows);
  Verdict verdict =
      judge_gain(raw.array() - raw.mean(), residual(rows), clusters, rows, BiasZero::mean_of_raw, kFewest);
  if (std::ssize(rows) >= kFewest && static_cast<double>(rows.size()) < kFewestPerParameter * effective_parameters) {
    verdict.gain = Gain::not_enough_data;
    verdict.only_offset = false;
    verdict.statement +=
        fmt::format("; {} clusters for {:.3g} effective parameters, at least {:g} per parameter are needed",
                    rows.size(), effective_parameters, kFewestPerParameter);
  }
  return verdict;
}

std::optional<std::string> make_no_gain_warning(std::string_view residual_name, const Verdict& verdict) {
  const bool is_smaller = !(verdict.std_deg_per_h.value <= 0) && !(verdict.rmse_deg_per_h.value <= 0);
  if (is_smaller) return std::nullopt;
  return fmt::format("no better than no model: {} {}", residual_name, verdict.statement);
}

bool is_below_nominal(double seen, double nominal, double effective) {
  constexpr double kImprobable = 0.025;
  return seen < nominal && data::binomial_at_most(seen * effective, effective, nominal) < kImprobable;
}

std::string describe_verdict(const Verdict& verdict) {
  return fmt::format("verdict: {}; {}{}", name(verdict.gain), verdict.statement,
                     verdict.intervals_hold == false ? "; the intervals do not hold" : "");
}

}  // namespace gyrotherm::model
