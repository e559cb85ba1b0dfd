// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "analysis/data/input_noise.hpp"
#include "analysis/methods/ridge_u.hpp"
#include "analysis/model/inputs.hpp"
#include "analysis/model/uncertainty.hpp"
#include "analysis/population/residual_correlation.hpp"
#include "bench/shared/sections.hpp"

namespace gyrotherm::bench {
namespace {

/// Predicts a unit's random run with `ridge-u` trained on its ramp run.
Result<Eigen::VectorXd> predict_with_ridge(const VirtualUnit& unit, const std::vector<data::Term>& terms) {
  const auto inputs = evaluate(terms, unit.rate.clusters), used = evaluate(terms, unit.random.clusters);
  const auto covariance =
      data::input_covariance(terms, unit.rate.clusters, model::thermometers_in_use(unit.rate.dataset).uncertainty_k);
  if (!inputs || !used || !covariance) return failure(FaultKind::usage, unit.name, "an input is missing");
  const auto plane = methods::penalised_plane(*inputs, unit.rate.clusters.bias_deg_per_h, *covariance);
  return ((*used * plane.weights).array() + plane.b).matrix().eval();
}

/// Prints one row: values over all pairs.
Result<void> print_row(const char* what, const std::vector<VirtualUnit>& units,
                       const std::vector<Eigen::VectorXd>& residuals) {
  std::vector<population::AxisResidual> axes;
  for (std::size_t i = 0; i < units.size(); ++i)
    axes.push_back({units[i].name, units[i].random.clusters, residuals[i]});
  const auto together = population::align_residuals(axes);
  if (!together) return failure(together.error());
  const auto found = population::correlate_residuals(*together);
  std::vector<double> r, effective;
  double by_chance = 0;
  int surprising = 0;
  for (Eigen::Index i = 0; i < found.correlation.rows(); ++i) {
    for (Eigen::Index j = i + 1; j < found.correlation.rows(); ++j) {
      r.push_back(found.correlation(i, j));
      effective.push_back(found.effective(i, j));
      by_chance += 1 / found.effective(i, j);
      if (found.probability(i, j) < 0.05) ++surprising;
    }
  }
  const auto pairs = static_cast<double>(r.size());
  std::ranges::sort(effective);
  double mean = 0, squares = 0;
  for (const double one : r) {
    mean += one / pairs;
    squares += one * one / pairs;
  }
  fmt::print("| {} | {:.0f} | {:+.3f} | {:.3f} | {:.3f} | {} of {} | {:.2g} | {:.2g} |\n", what,
             effective[effective.size() / 2], mean, std::sqrt(squares), std::sqrt(by_chance / pairs), surprising,
             r.size(), found.all_probability, found.largest_probability);
  return {};
}

}  // namespace

Result<void> measure_correlation(const std::vector<VirtualUnit>& units, const std::string& inputs) {
  const auto plan = model::plan_inputs(inputs, units.front().rate.dataset);
  if (!plan) return failure(plan.error());
  std::vector<Eigen::VectorXd> unexplained, noise, misfit;
  for (const VirtualUnit& unit : units) {
    const auto predicted = predict_with_ridge(unit, plan->fixed);
    if (!predicted) return failure(predicted.error());
    const Eigen::VectorXd& measured = unit.random.clusters.bias_deg_per_h;
    unexplained.push_back(measured - *predicted);
    noise.push_back(measured - unit.random_truth_deg_per_h);
    misfit.push_back(unit.random_truth_deg_per_h - *predicted);
  }
  fmt::print(
      "\nCorrelation between the residuals of `ridge-u` with the inputs {} on the random runs of {} units:\n\n"
      "| quantity | n_eff, median | mean r | r, RMS | expected by chance | pairs with p < 0.05 | p of all | "
      "p of the largest |\n|---|---|---|---|---|---|---|---|\n",
      inputs, units.size());
  if (const auto shown = print_row("measured residual", units, unexplained); !shown) return shown;
  if (const auto shown = print_row("noise: measured minus true bias", units, noise); !shown) return shown;
  return print_row("model error: true minus predicted bias", units, misfit);
}

}  // namespace gyrotherm::bench
