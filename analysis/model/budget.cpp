// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/budget.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "analysis/data/distributions.hpp"

namespace gyrotherm::model {
namespace {

/// Growth of the standard uncertainty of a mean with the averaging time τ: constant, 1/√τ, 1/τ or √τ.
enum class TimeScaling { constant, inverse_root, inverse, root };

struct SourceInfo {
  const char* name;
  const char* unit;
  Variability variability;
  TimeScaling scaling;
};

/// One row per Source, in the order of the enumeration.
constexpr std::array<SourceInfo, 20> kSources{
    {{"angle random walk", "°/h", Variability::within_a_run, TimeScaling::inverse_root},
     {"flicker", "°/h", Variability::within_a_run, TimeScaling::constant},
     {"rate random walk", "°/h", Variability::within_a_run, TimeScaling::root},
     {"counting of pulses", "°/h", Variability::within_a_run, TimeScaling::inverse},
     {"thermometer noise", "°/h", Variability::within_a_run, TimeScaling::inverse_root},
     {"model form", "°/h", Variability::within_a_run, TimeScaling::constant},
     {"coefficients", "°/h", Variability::within_a_run, TimeScaling::constant},
     {"hysteresis", "°/h", Variability::within_a_run, TimeScaling::constant},
     {"turn-on", "°/h", Variability::between_runs, TimeScaling::constant},
     {"thermometer drift", "K", Variability::between_runs, TimeScaling::constant},
     {"input drift", "1", Variability::between_runs, TimeScaling::constant},
     {"thermometer calibration", "K", Variability::never, TimeScaling::constant},
     {"latitude", "°", Variability::never, TimeScaling::constant},
     {"azimuth", "°", Variability::never, TimeScaling::constant},
     {"tilt", "°", Variability::never, TimeScaling::constant},
     {"fixture elevation", "°", Variability::never, TimeScaling::constant},
     {"fixture roll", "°", Variability::never, TimeScaling::constant},
     {"axis direction", "°", Variability::never, TimeScaling::constant},
     {"scale factor", "ppm", Variability::never, TimeScaling::constant},
     {"extrapolation", "°/h", Variability::within_a_run, TimeScaling::constant}}};

const SourceInfo& source_info(Source source) { return kSources[static_cast<std::size_t>(source)]; }

}  // namespace

const char* name(Source source) { return source_info(source).name; }

std::string row_unit(const BudgetRow& row) {
  return row.source == Source::input_drift && !row.unit.empty() ? row.unit : source_info(row.source).unit;
}

const char* name(Variability variability) {
  constexpr std::array kNames = {"within a run", "between runs", "never"};
  return kNames[static_cast<std::size_t>(variability)];
}

Variability variability(Source source) { return source_info(source).variability; }

const char* name(Evaluation evaluation) { return evaluation == Evaluation::a ? "A" : "B"; }

const char* name(ErrorDistribution distribution) {
  constexpr std::array kNames = {"normal", "rectangular", "triangular"};
  return kNames[static_cast<std::size_t>(distribution)];
}

std::vector<std::string> remarks(const BudgetRow& row) {
  std::vector<std::string> all;
  if (row.assumed) all.emplace_back("assumed");
  if (row.chosen_on_these_folds) all.emplace_back("chosen on these folds");
  if (row.only_start_held_out) all.emplace_back("only power-on held out");
  if (row.without_holds) all.emplace_back("from the residual, no holds");
  return all;
}

double contribution_deg_per_h(const BudgetRow& row) { return std::abs(row.sensitivity) * row.standard_uncertainty; }

double degrees_of_freedom_for(double uncertainty, double error) {
  return error > 0 ? std::max(1.0, 0.5 * std::pow(uncertainty / error, 2)) : std::numeric_limits<double>::infinity();
}

double whole_degrees(double degrees_of_freedom) {
  constexpr double kRounding = 1e-9;
  if (!std::isfinite(degrees_of_freedom)) return degrees_of_freedom;
  return std::max(1.0, std::floor(degrees_of_freedom * (1 + kRounding)));
}

CombinedUncertainty combined(const std::vector<BudgetRow>& rows, double share) {
  double variance = 0;
  for (const BudgetRow& row : rows) variance += std::pow(contribution_deg_per_h(row), 2);
  // Σ (u_i²/u_c²)²/ν_i; the ratio avoids overflow and underflow.
  double relative_variance = 0;
  for (const BudgetRow& row : rows) {
    if (variance == 0) continue;
    relative_variance += std::pow(std::pow(contribution_deg_per_h(row), 2) / variance, 2) / row.degrees_of_freedom;
  }
  CombinedUncertainty all{.standard_deg_per_h = std::sqrt(variance)};
  if (relative_variance > 0) all.degrees_of_freedom = 1 / relative_variance;
  all.coverage_factor = data::coverage_factor(share, whole_degrees(all.degrees_of_freedom));
  all.expanded_deg_per_h = all.coverage_factor * all.standard_deg_per_h;
  return all;
}

bool are_nearly_equal(const CombinedUncertainty& a, const CombinedUncertainty& b) {
  constexpr double kRounding = 1e-6;
  const auto same = [](double one, double other) {
    return std::abs(one - other) <= kRounding * std::max(std::abs(one), std::abs(other));
  };
  return same(a.standard_deg_per_h, b.standard_deg_per_h) && same(a.coverage_factor, b.coverage_factor) &&
         same(a.expanded_deg_per_h, b.expanded_deg_per_h);
}

std::vector<BudgetRow> differing_rows(const std::vector<BudgetRow>& rows) {
  std::vector<BudgetRow> differing;
  std::ranges::copy_if(rows, std::back_inserter(differing),
                       [](const BudgetRow& row) { return variability(row.source) != Variability::never; });
  return differing;
}

Budget convert_averaging(Budget budget, double averaging_s) {
  const double ratio = averaging_s / budget.averaging_s, root = std::sqrt(ratio);
  for (BudgetRow& row : budget.rows) {
    const TimeScaling scaling = source_info(row.source).scaling;
    if (scaling == TimeScaling::inverse_root) row.standard_uncertainty /= root;
    if (scaling == TimeScaling::inverse) row.standard_uncertainty /= ratio;
    if (scaling == TimeScaling::root) row.standard_uncertainty *= root;
  }
  budget.averaging_s = averaging_s;
  return budget;
}

CombinedUncertainty mean_uncertainty(const Uncertainty& uncertainty, double averaging_s) {
  return combined(convert_averaging(uncertainty.budget, averaging_s).rows);
}

double extrapolation_factor(double excess) { return 3 * (std::pow(1 + 2 * excess, 2) - 1); }

double form_variance(const std::vector<BudgetRow>& rows) {
  double variance = 0;
  for (const BudgetRow& row : rows)
    if (row.source == Source::model_form) variance += std::pow(contribution_deg_per_h(row), 2);
  return variance;
}

double expanded_outside(const Uncertainty& uncertainty, double averaging_s, double excess) {
  const std::vector<BudgetRow> rows = convert_averaging(uncertainty.budget, averaging_s).rows;
  const CombinedUncertainty all = combined(rows);
  if (!(excess > 0)) return all.expanded_deg_per_h;
  return all.coverage_factor *
         std::sqrt(std::pow(all.standard_deg_per_h, 2) + extrapolation_factor(excess) * form_variance(rows));
}

}  // namespace gyrotherm::model
