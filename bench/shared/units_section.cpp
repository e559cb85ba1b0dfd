// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "analysis/data/input_noise.hpp"
#include "analysis/methods/kernel_methods.hpp"
#include "analysis/methods/ridge_u.hpp"
#include "analysis/model/inputs.hpp"
#include "analysis/model/uncertainty.hpp"
#include "analysis/population/type_prior.hpp"
#include "bench/shared/sections.hpp"

namespace gyrotherm::bench {
namespace {

constexpr double kSecondsPerHour = 3600;
constexpr std::array kShownHours = {0, 1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 62};
constexpr int kLastHour = 62;  // the whole ramp run

/// Result of one method of learning from the first hours of a ramp run: the errors on the random run of the unit.
struct MethodErrors {
  double expanded = std::numeric_limits<double>::quiet_NaN();  ///< U, root mean square
  double error{};                                              ///< true error, root mean square
  /// True error without its mean, root mean square.
  double shape{};
  /// Fraction of means with an error within U.
  double within_u = std::numeric_limits<double>::quiet_NaN();
  /// Added uncertainty from the thermometers' errors after a year, k = 1.
  double drift{};
};

MethodErrors assess(const Eigen::VectorXd& predicted, const Eigen::VectorXd& expanded, const Eigen::VectorXd& truth) {
  const Eigen::VectorXd error = predicted - truth;
  MethodErrors errors{.error = root_mean_square(error), .shape = root_mean_square(error.array() - error.mean())};
  if (expanded.size() == 0) return errors;
  errors.expanded = root_mean_square(expanded);
  errors.within_u = (error.cwiseAbs().array() <= expanded.array()).cast<double>().mean();
  return errors;
}

/// Compared methods of learning.
enum Method { kWithPrior, kAlone, kRidgeU, kTypeMean, kMethods };
constexpr std::array<const char*, kMethods> kMethodNames = {"type prior", "alone", "`ridge-u`",
                                                            "mean of the others, own constant"};

using ErrorsByHour = std::vector<std::array<MethodErrors, kMethods>>;

/// Returns the clusters of the first `hours`; all clusters for kLastHour.
data::Clusters first_hours(const data::Clusters& clusters, int hours) {
  std::vector<Eigen::Index> rows;
  for (Eigen::Index k = 0; k < clusters.start_s.size(); ++k)
    if (hours >= kLastHour || clusters.start_s(k) + clusters.length_s <= hours * kSecondsPerHour) rows.push_back(k);
  return pick_clusters(clusters, rows);
}

/// Returns a prior without knowledge of the type: the constant and each slope per STD are within a few °/h of 0, which
/// is about fifty times their real size. The noises are those of the type, as if they were known.
population::TypePrior uninformed_prior(const population::TypePrior& type) {
  population::TypePrior nothing = type;
  nothing.next_unit.mean.setZero();
  nothing.next_unit.covariance.setIdentity();
  return nothing;
}

/// Returns √(wᵀCw), with w the slopes of the unscaled terms and C their covariance from the thermometers' uncertainty
/// in use.
Result<double> compute_drift(const std::vector<data::Term>& terms, const Eigen::VectorXd& slopes,
                             const VirtualUnit& unit) {
  const auto uncertainty = model::thermometers_in_use(unit.random.dataset).uncertainty_k;
  const auto covariance = data::input_covariance(terms, unit.random.clusters, uncertainty);
  if (!covariance) return failure(covariance.error());
  return std::sqrt(slopes.dot(*covariance * slopes));
}

Result<MethodErrors> assess_prior(const population::TypePrior& prior, const data::Clusters& own,
                                  const VirtualUnit& unit) {
  std::vector<data::Clusters> runs;
  if (own.start_s.size() > 0) runs.push_back(own);
  const auto coefficients = learn_unit(prior, runs);
  if (!coefficients) return failure(coefficients.error());
  const auto drift_k = model::drifts_between_k(unit.rate.dataset, unit.random.dataset);
  const auto predicted = predict(prior, *coefficients, unit.random.clusters, drift_k);
  if (!predicted) return failure(predicted.error());
  auto errors = assess(predicted->bias_deg_per_h, predicted->expanded_deg_per_h, unit.random_truth_deg_per_h);
  const Eigen::VectorXd slopes = noise_aware_coefficients(prior, *coefficients).tail(prior.scaling.std.size());
  const auto drift = compute_drift(prior.terms, slopes.cwiseQuotient(prior.scaling.std.transpose()), unit);
  if (!drift) return failure(drift.error());
  errors.drift = *drift;
  return errors;
}

Result<MethodErrors> assess_ridge(const population::TypePrior& type, const data::Clusters& own, const VirtualUnit& unit,
                                  const std::vector<double>& uncertainty_k) {
  const auto inputs = evaluate(type.terms, own), used = evaluate(type.terms, unit.random.clusters);
  const auto covariance = data::input_covariance(type.terms, own, uncertainty_k);
  if (!inputs || !used || !covariance) return failure(FaultKind::usage, unit.name, "an input is missing");
  const auto plane = methods::penalised_plane(*inputs, own.bias_deg_per_h, *covariance);
  auto errors = assess((*used * plane.weights).array() + plane.b, {}, unit.random_truth_deg_per_h);
  const auto drift = compute_drift(type.terms, plane.weights, unit);
  if (!drift) return failure(drift.error());
  errors.drift = *drift;
  return errors;
}

/// Assesses predictions made with the mean slopes of the type and a constant from the unit's own clusters.
Result<MethodErrors> assess_mean(const population::TypePrior& type, const data::Clusters& own,
                                 const VirtualUnit& unit) {
  const auto none = learn_unit(type, {});
  if (!none) return failure(none.error());
  const population::LearntUnit& mean = *none;
  const auto here = predict(type, mean, own), there = predict(type, mean, unit.random.clusters);
  if (!here || !there) return failure(here ? there.error() : here.error());
  const double constant = own.start_s.size() > 0 ? (own.bias_deg_per_h - here->bias_deg_per_h).mean() : 0;
  return assess(there->bias_deg_per_h.array() + constant, {}, unit.random_truth_deg_per_h);
}

Result<ErrorsByHour> assess_by_hours(const population::TypePrior& type, const VirtualUnit& unit) {
  const auto uncertainty = model::thermometers_in_use(unit.rate.dataset).uncertainty_k;
  ErrorsByHour all;
  for (int hours = 0; hours <= kLastHour; ++hours) {
    const data::Clusters own = first_hours(unit.rate.clusters, hours);
    std::array<MethodErrors, kMethods>& errors = all.emplace_back();
    const auto with = assess_prior(type, own, unit);
    const auto mean = assess_mean(type, own, unit);
    if (!with || !mean) return failure(with ? mean.error() : with.error());
    errors[kWithPrior] = *with;
    errors[kTypeMean] = *mean;
    // These two methods need own data. Without it they apply no compensation.
    if (hours == 0) {
      errors[kAlone] = errors[kRidgeU] =
          assess(Eigen::VectorXd::Zero(unit.random_truth_deg_per_h.size()), {}, unit.random_truth_deg_per_h);
      continue;
    }
    const auto alone = assess_prior(uninformed_prior(type), own, unit);
    const auto ridge = assess_ridge(type, own, unit, uncertainty);
    if (!alone || !ridge) return failure(alone ? ridge.error() : alone.error());
    errors[kAlone] = *alone;
    errors[kRidgeU] = *ridge;
  }
  return all;
}

struct Figure {
  const char* name;
  double MethodErrors::*value;
  double scale;
};
constexpr std::array kFigures = {
    Figure{"U (k = 2), 10⁻³ °/h", &MethodErrors::expanded, 1000},
    Figure{"error relative to the true bias, RMS, 10⁻³ °/h", &MethodErrors::error, 1000},
    Figure{"the same without its mean, 10⁻³ °/h", &MethodErrors::shape, 1000},
    Figure{"share of errors within U, %", &MethodErrors::within_u, 100},
    Figure{"uncertainty from one year of thermometer drift (k = 1), 10⁻³ °/h", &MethodErrors::drift, 1000}};

MeanWithError mean_over_units(const std::vector<ErrorsByHour>& units, int hours, Method method,
                              double MethodErrors::*value) {
  std::vector<double> values;
  for (const ErrorsByHour& unit : units) values.push_back(unit[static_cast<std::size_t>(hours)][method].*value);
  return mean_with_error(values);
}

void print_tables(const std::vector<ErrorsByHour>& units) {
  for (const Figure& figure : kFigures) {
    fmt::print("\n**{}**, mean over the units ± its standard error\n\n| own hours |", figure.name);
    for (const int hours : kShownHours) fmt::print(" {} |", hours);
    fmt::print("\n|---|");
    for ([[maybe_unused]] const int hours : kShownHours) fmt::print("---|");
    for (int method = 0; method < kMethods; ++method) {
      if (std::isnan(mean_over_units(units, kLastHour, static_cast<Method>(method), figure.value).mean)) continue;
      fmt::print("\n| {} |", kMethodNames[static_cast<std::size_t>(method)]);
      for (const int hours : kShownHours) {
        const auto found = mean_over_units(units, hours, static_cast<Method>(method), figure.value);
        if (std::isnan(found.mean)) {
          fmt::print(" – |");
        } else {
          fmt::print(" {:.2f} ± {:.2f} |", figure.scale * found.mean, figure.scale * found.error);
        }
      }
    }
    fmt::print("\n");
  }
}

/// Prints the change of the error by the prior as a mean of paired differences between units.
void print_differences(const std::vector<ErrorsByHour>& units) {
  fmt::print("\n**Error with the type prior minus error without it, paired by unit**, 10⁻³ °/h\n\n| own hours |");
  for (const int hours : kShownHours) fmt::print(" {} |", hours);
  fmt::print("\n|---|");
  for ([[maybe_unused]] const int hours : kShownHours) fmt::print("---|");
  for (const Method method : {kAlone, kRidgeU}) {
    fmt::print("\n| minus {} |", kMethodNames[method]);
    for (const int hours : kShownHours) {
      std::vector<double> differences;
      for (const ErrorsByHour& unit : units) {
        const auto& at = unit[static_cast<std::size_t>(hours)];
        differences.push_back(1000 * (at[kWithPrior].error - at[method].error));
      }
      const auto found = mean_with_error(differences);
      fmt::print(" {:+.2f} ± {:.2f} |", found.mean, found.error);
    }
  }
  fmt::print("\n");
}

/// Returns the first hour from which on U without the prior is at most `wanted`, or the hour after the last one.
int first_hour_within(const ErrorsByHour& unit, double wanted) {
  int first = kLastHour + 1;
  for (; first > 1; --first)
    if (!(unit[static_cast<std::size_t>(first - 1)][kAlone].expanded <= wanted)) break;
  return first;
}

/// Additional hours that a unit needs without the prior to reach the U that it has with the prior.
struct SavedHours {
  /// Mean over the units. A unit that never reaches that U counts with the hour after the last one.
  MeanWithError hours;
  int never{};  ///< units that never reach it
};

SavedHours saved_hours_at_equal_u(const std::vector<ErrorsByHour>& units, int hours_with_prior) {
  SavedHours saved;
  std::vector<double> all;
  for (const ErrorsByHour& unit : units) {
    const int first = first_hour_within(unit, unit[static_cast<std::size_t>(hours_with_prior)][kWithPrior].expanded);
    if (first > kLastHour) ++saved.never;
    all.push_back(first - hours_with_prior);
  }
  saved.hours = mean_with_error(all);
  return saved;
}

/// Returns the first hour at which the mean error of another method no longer exceeds that of the prior after
/// `hours_with_prior` hours by more than two standard errors; −1 if there is none.
int first_hour_as_good(const std::vector<ErrorsByHour>& units, Method method, int hours_with_prior) {
  for (int hours = 1; hours <= kLastHour; ++hours) {
    std::vector<double> more;
    for (const ErrorsByHour& unit : units)
      more.push_back(unit[static_cast<std::size_t>(hours)][method].error -
                     unit[static_cast<std::size_t>(hours_with_prior)][kWithPrior].error);
    const auto found = mean_with_error(more);
    if (found.mean <= 2 * found.error) return hours;
  }
  return -1;
}

void print_savings(const std::vector<ErrorsByHour>& units) {
  fmt::print(
      "\n**Hours that a unit needs without the type prior to match the result with it.** Equal U: mean over the units; "
      "a "
      "unit that never reaches it counts as {} h. Error: until the paired difference is within two standard errors\n\n"
      "| own hours with the prior | equal U, alone: more hours | never, of {} units | error, alone | error, "
      "`ridge-u` |\n|---|---|---|---|---|",
      kLastHour + 1, units.size());
  const auto cell = [](int hours, int needed) {
    return needed < 0 ? fmt::format("more than {}", kLastHour) : fmt::format("{} ({:+})", needed, needed - hours);
  };
  for (const int hours : kShownHours) {
    const SavedHours saved = saved_hours_at_equal_u(units, hours);
    fmt::print("\n| {} | {:+.1f} ± {:.1f} | {} | {} | {} |", hours, saved.hours.mean, saved.hours.error, saved.never,
               cell(hours, first_hour_as_good(units, kAlone, hours)),
               cell(hours, first_hour_as_good(units, kRidgeU, hours)));
  }
  fmt::print("\n");
}

std::vector<population::UnitClusters> other_units(const std::vector<VirtualUnit>& units, std::size_t left_out) {
  std::vector<population::UnitClusters> others;
  for (std::size_t i = 0; i < units.size(); ++i)
    if (i != left_out) others.push_back({units[i].name, {units[i].rate.clusters, units[i].random.clusters}});
  return others;
}

}  // namespace

Result<void> measure_units(const std::vector<VirtualUnit>& units, const std::string& inputs) {
  const auto plan = model::plan_inputs(inputs, units.front().rate.dataset);
  if (!plan) return failure(plan.error());
  if (!plan->candidates.empty())
    return failure(FaultKind::usage, inputs, "selects inputs by data; expected fixed inputs");
  const auto turn_on = units.front().rate.dataset.gyro_uncertainty.turn_on_repeatability_deg_per_h;
  std::vector<ErrorsByHour> errors;
  fmt::print(
      "\nPriors from the other units:\n\n| next unit | white, wander, 10⁻³ °/h | time of the wander, h | shrinkage of "
      "the correlations, equivalent units |\n|---|---|---|---|\n");
  for (std::size_t left_out = 0; left_out < units.size(); ++left_out) {
    const auto others = other_units(units, left_out);
    const auto type = population::learn_type_prior(
        others, {.type = "virtual",
                 .terms = plan->fixed,
                 .turn_on_deg_per_h = turn_on.value_or(0.001),
                 .thermometer_uncertainty_k = model::thermometers_in_use(units[left_out].rate.dataset).uncertainty_k});
    if (!type) return failure(type.error());
    fmt::print("| {} | {:.2f}, {:.2f} | {:.1f} | {} |\n", units[left_out].name, 1000 * type->noise.white_deg_per_h,
               1000 * type->noise.wander_deg_per_h, type->noise.wander_time_s / kSecondsPerHour,
               type->correlations_worth_units > 0 ? fmt::format("{:.0f}", type->correlations_worth_units) : "all");
    std::fflush(stdout);
    auto by_hours = assess_by_hours(*type, units[left_out]);
    if (!by_hours) return failure(by_hours.error());
    errors.push_back(std::move(*by_hours));
  }
  print_tables(errors);
  print_differences(errors);
  print_savings(errors);
  return {};
}

}  // namespace gyrotherm::bench
