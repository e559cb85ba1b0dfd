// SPDX-License-Identifier: Apache-2.0
#include "analysis/population/type_prior.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <set>
#include <utility>

#include "analysis/data/dataset.hpp"
#include "analysis/data/input_noise.hpp"
#include "analysis/data/statistics.hpp"

namespace gyrotherm::population {
namespace {

tl::unexpected<Fault> refuse_units(std::string what) {
  return failure(FaultKind::usage, "type prior", std::move(what));
}

/// One run of one unit as training data.
struct RunValues {
  Eigen::VectorXd time_s;
  data::SampleMatrix inputs;  ///< unscaled terms
  Eigen::VectorXd bias_deg_per_h;
};

/// Returns the clusters that have a value of every term.
Result<RunValues> run_values(const data::Clusters& run, const std::vector<data::Term>& terms) {
  const auto inputs = evaluate(terms, run);
  if (!inputs) return failure(inputs.error());
  Eigen::MatrixXd all(inputs->rows(), inputs->cols() + 1);
  all << *inputs, run.bias_deg_per_h;
  const auto rows = data::finite_rows(all);
  return RunValues{run.start_s(rows), (*inputs)(rows, Eigen::all), run.bias_deg_per_h(rows)};
}

struct UnitValues {
  std::vector<RunValues> runs;
};

Result<std::vector<UnitValues>> all_values(std::span<const UnitClusters> units, const std::vector<data::Term>& terms) {
  std::vector<UnitValues> values;
  for (const UnitClusters& unit : units) {
    values.emplace_back();
    for (const data::Clusters& run : unit.runs) {
      auto of_run = run_values(run, terms);
      if (!of_run) return failure(of_run.error());
      if (of_run->time_s.size() == 0) return refuse_units(fmt::format("a run of \"{}\" has no values", unit.unit));
      values.back().runs.push_back(std::move(*of_run));
    }
  }
  return values;
}

std::vector<data::Term> terms_or_default(const TypePriorOptions& options, const data::Clusters& clusters) {
  if (!options.terms.empty()) return options.terms;
  std::vector<std::string> names;
  std::ranges::remove_copy_if(clusters.thermometers, std::back_inserter(names), data::is_own_value);
  if (names.empty()) return {data::temperature_term(std::string(data::kSelf))};
  std::vector<data::Term> terms{data::temperature_term(names.front())};
  for (std::size_t j = 1; j < names.size(); ++j) terms.push_back(data::gradient_term(names.front(), names[j]));
  return terms;
}

Result<void> check_units(std::span<const UnitClusters> units) {
  constexpr std::size_t kMinUnits = 3;
  if (units.size() < kMinUnits)
    return refuse_units(fmt::format("{} units are too few, at least {} are needed", units.size(), kMinUnits));
  std::set<std::string> names;
  for (const UnitClusters& unit : units) {
    if (!names.insert(unit.unit).second) return refuse_units(fmt::format("unit \"{}\" is given twice", unit.unit));
    if (unit.runs.empty()) return refuse_units(fmt::format("unit \"{}\" has no run", unit.unit));
    for (const data::Clusters& run : unit.runs) {
      const data::Clusters& first = units.front().runs.front();
      if (run.length_s != first.length_s || run.thermometers != first.thermometers)
        return refuse_units(
            fmt::format("unit \"{}\" has different thermometers or a different cluster length", unit.unit));
    }
  }
  return {};
}

Eigen::Index rows_in(const std::vector<UnitValues>& units) {
  Eigen::Index rows = 0;
  for (const UnitValues& unit : units)
    for (const RunValues& run : unit.runs) rows += run.time_s.size();
  return rows;
}

data::SampleMatrix all_inputs(const std::vector<UnitValues>& units, Eigen::Index terms) {
  data::SampleMatrix all(rows_in(units), terms);
  Eigen::Index at = 0;
  for (const UnitValues& unit : units) {
    for (const RunValues& run : unit.runs) {
      all.middleRows(at, run.inputs.rows()) = run.inputs;
      at += run.inputs.rows();
    }
  }
  return all;
}

/// Returns the covariance of the scaled terms within runs. The variation between units is excluded, because it includes
/// the errors of the thermometers.
Eigen::MatrixXd spread_within_runs(const std::vector<UnitValues>& units, const data::Scaling& scaling) {
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(scaling.std.size(), scaling.std.size());
  for (const UnitValues& unit : units) {
    for (const RunValues& run : unit.runs) {
      const Eigen::MatrixXd scaled = apply(scaling, run.inputs);
      const Eigen::MatrixXd centred = scaled.rowwise() - scaled.colwise().mean();
      sum += centred.transpose() * centred;
    }
  }
  return sum / static_cast<double>(rows_in(units));
}

/// Returns the transformation from scaled terms to the components in which the population is estimated, of unit
/// variance over all clusters: terms × components.
Eigen::MatrixXd find_components(const data::SampleMatrix& scaled) {
  constexpr double kLeastShare = 1e-5;
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(scaled);
  const Eigen::Index rank = std::min(scaled.rows(), scaled.cols());
  const Eigen::MatrixXd triangle = qr.matrixQR().topRows(rank).triangularView<Eigen::Upper>();
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(triangle, Eigen::ComputeThinV);
  const Eigen::VectorXd spread = svd.singularValues() / std::sqrt(static_cast<double>(scaled.rows()));
  Eigen::Index kept = 0;
  while (kept < spread.size() && spread(kept) > kLeastShare * spread(0)) ++kept;
  return svd.matrixV().leftCols(kept) * spread.head(kept).cwiseInverse().asDiagonal();
}

/// Returns one row per cluster: 1, and the components.
Eigen::MatrixXd make_design(const data::SampleMatrix& scaled, const Eigen::MatrixXd& components) {
  Eigen::MatrixXd design(scaled.rows(), components.cols() + 1);
  design << Eigen::VectorXd::Ones(scaled.rows()), scaled * components;
  return design;
}

/// Times, design and bias of a run; design and bias are in one matrix because they are whitened together.
struct DesignedRun {
  Eigen::VectorXd time_s;
  Eigen::MatrixXd design_and_bias;
};
using DesignedUnits = std::vector<std::vector<DesignedRun>>;

DesignedUnits make_designs(const std::vector<UnitValues>& units, const data::Scaling& scaling,
                           const Eigen::MatrixXd& components) {
  DesignedUnits all;
  for (const UnitValues& unit : units) {
    all.emplace_back();
    for (const RunValues& run : unit.runs) {
      Eigen::MatrixXd together(run.time_s.size(), components.cols() + 2);
      together << make_design(apply(scaling, run.inputs), components), run.bias_deg_per_h;
      all.back().push_back({run.time_s, std::move(together)});
    }
  }
  return all;
}

double mean_square_bias(const DesignedUnits& units) {
  double squares = 0, rows = 0;
  for (const auto& runs : units) {
    for (const DesignedRun& run : runs) {
      squares += run.design_and_bias.rightCols<1>().squaredNorm();
      rows += static_cast<double>(run.time_s.size());
    }
  }
  return squares / rows;
}

UnitInformation whitened_information(const UnexplainedNoise& noise, const DesignedRun& run) {
  const WhitenedColumns white = whiten(noise, run.time_s, run.design_and_bias);
  const Eigen::Index coefficients = white.columns.cols() - 1;
  return unit_information(white.columns.leftCols(coefficients), white.columns.col(coefficients), white.log_determinant);
}

std::vector<UnitInformation> collect_information(const UnexplainedNoise& noise, const DesignedUnits& units) {
  std::vector<UnitInformation> all;
  for (const auto& runs : units) {
    UnitInformation sum = no_information(runs.front().design_and_bias.cols() - 1);
    for (const DesignedRun& run : runs) sum = sum + whitened_information(noise, run);
    all.push_back(std::move(sum));
  }
  return all;
}

/// Returns the root mean square of the least-squares residuals of all units, the starting value for the noises.
double least_squares_rms(const DesignedUnits& units) {
  double squares = 0, rows = 0;
  for (const auto& runs : units) {
    Eigen::Index count = 0;
    for (const DesignedRun& run : runs) count += run.time_s.size();
    Eigen::MatrixXd all(count, runs.front().design_and_bias.cols());
    Eigen::Index at = 0;
    for (const DesignedRun& run : runs) {
      all.middleRows(at, run.time_s.size()) = run.design_and_bias;
      at += run.time_s.size();
    }
    const Eigen::MatrixXd design = all.leftCols(all.cols() - 1);
    const Eigen::VectorXd bias = all.rightCols<1>();
    squares += (bias - design * design.colPivHouseholderQr().solve(bias)).squaredNorm();
    rows += static_cast<double>(count);
  }
  return std::sqrt(squares / rows);
}

/// Logarithms of the white noise, the wander and its correlation time.
using NoiseLogarithms = std::array<double, 3>;

UnexplainedNoise noise_at(const NoiseLogarithms& at, double turn_on_deg_per_h) {
  return {std::exp(at[0]), std::exp(at[1]), std::exp(at[2]), turn_on_deg_per_h};
}

/// Searches for the noise parameters with the highest restricted likelihood for this Σ, one coordinate at a time with
/// steps that are halved. Noise with a correlation time below three clusters is treated as white.
Result<UnexplainedNoise> search_noise(const UnexplainedNoise& start, const DesignedUnits& units,
                                      const Eigen::MatrixXd& covariance, double cluster_length_s) {
  constexpr double kFirstStep = 0.8, kLastStep = 0.04;
  const auto likelihood_at = [&](const NoiseLogarithms& at) -> Result<double> {
    return fit_population_mean(collect_information(noise_at(at, start.turn_on_deg_per_h), units), covariance)
        .map([](const PopulationFit& fit) { return fit.log_likelihood; });
  };
  NoiseLogarithms at{std::log(start.white_deg_per_h), std::log(start.wander_deg_per_h), std::log(start.wander_time_s)};
  const NoiseLogarithms low{at[0] - 7, at[1] - 7, std::log(3 * cluster_length_s)},
      high{at[0] + 7, at[1] + 7, std::log(1e7)};
  auto best = likelihood_at(at);
  if (!best) return failure(best.error());
  for (double step = kFirstStep; step > kLastStep; step /= 2) {
    for (bool gained = true; gained;) {
      gained = false;
      for (std::size_t k = 0; k < at.size(); ++k) {
        for (const double side : {-step, step}) {
          NoiseLogarithms tried = at;
          tried[k] = std::clamp(at[k] + side, low[k], high[k]);
          const auto found = likelihood_at(tried);
          if (!found || !(*found > *best)) continue;
          at = tried;
          best = found;
          gained = true;
        }
      }
    }
  }
  return noise_at(at, start.turn_on_deg_per_h);
}

/// Returns the sum over all units of the log predictive density of the unit given the other units; no value if a fit
/// fails. The variances, to which the correlations are shrunk with the weight of `worth_units`, are fitted to the other
/// units too. 0: no correlations.
std::optional<double> leave_one_out_density(const std::vector<UnitInformation>& units, const Eigen::MatrixXd& start,
                                            double worth_units) {
  double sum = 0;
  for (std::size_t left_out = 0; left_out < units.size(); ++left_out) {
    std::vector<UnitInformation> others = units;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(left_out));
    auto fit = fit_population(others, start, {.independent = true});
    if (fit && worth_units > 0) {
      const Eigen::MatrixXd own = fit->population.covariance;
      fit = fit_population(others, own, {.shrinkage = Shrinkage{own.diagonal(), worth_units}});
    }
    if (!fit) return {};
    sum += log_predictive(next_unit(fit->population), units[left_out]);
  }
  return sum;
}

struct Chosen {
  PopulationFit fit;
  double worth_units{};
};

/// Shrinks the correlations towards 0; the shrinkage is chosen by leave-one-unit-out.
Result<Chosen> fit_correlations(const std::vector<UnitInformation>& units, const PopulationFit& independent,
                                bool quick) {
  constexpr std::array kWorth = {100.0, 30.0, 10.0, 3.0, 1.0};
  constexpr std::size_t kFewestToLeaveOneOut = 4;
  const Eigen::MatrixXd& start = independent.population.covariance;
  Chosen chosen{independent, 0};
  if (quick || units.size() < kFewestToLeaveOneOut) return chosen;
  auto best = leave_one_out_density(units, start, 0);
  for (const double worth : kWorth) {
    const auto predicted = leave_one_out_density(units, start, worth);
    if (!predicted || (best && !(*predicted > *best))) continue;
    const auto fit = fit_population(units, start, {.shrinkage = Shrinkage{start.diagonal(), worth}});
    if (!fit) return failure(fit.error());
    best = predicted;
    chosen = {*fit, worth};
  }
  return chosen;
}

/// Learnt population and noise, in components.
struct LearntPopulation {
  Chosen chosen;
  UnexplainedNoise noise;
};

Result<LearntPopulation> learn(const DesignedUnits& units, double cluster_length_s, const TypePriorOptions& options) {
  constexpr int kRounds = 4;
  const double left = least_squares_rms(units) / std::sqrt(2.0);
  if (!(left > 0)) return refuse_units("the least-squares residual is zero, so the noise cannot be estimated");
  constexpr double kFirstClusters = 36;
  UnexplainedNoise noise{left, left, kFirstClusters * cluster_length_s, options.turn_on_deg_per_h};
  const Eigen::Index coefficients = units.front().front().design_and_bias.cols() - 1;
  Eigen::MatrixXd covariance = mean_square_bias(units) * Eigen::MatrixXd::Identity(coefficients, coefficients);
  Result<PopulationFit> fit = failure(FaultKind::numeric, "type prior", "was not run");
  for (int round = 0; round < kRounds; ++round) {
    fit = fit_population(collect_information(noise, units), covariance, {.independent = true});
    if (!fit) return failure(fit.error());
    covariance = fit->population.covariance;
    if (round + 1 == kRounds) break;
    const auto searched = search_noise(noise, units, covariance, cluster_length_s);
    if (!searched) return failure(searched.error());
    noise = *searched;
  }
  auto chosen = fit_correlations(collect_information(noise, units), *fit, options.quick);
  if (!chosen) return failure(chosen.error());
  return LearntPopulation{std::move(*chosen), noise};
}

/// Transforms coefficients of the components to coefficients of the scaled terms.
Coefficients term_coefficients(const Coefficients& of_components, const Eigen::MatrixXd& components) {
  Eigen::MatrixXd back = Eigen::MatrixXd::Zero(components.rows() + 1, components.cols() + 1);
  back(0, 0) = 1;
  back.bottomRightCorner(components.rows(), components.cols()) = components;
  const Eigen::MatrixXd covariance = back * of_components.covariance * back.transpose();
  return {back * of_components.mean, 0.5 * (covariance + covariance.transpose())};
}

/// Returns the covariance of the scaled terms due to the thermometers' uncertainty, averaged over all clusters with a
/// value of each term.
Result<Eigen::MatrixXd> term_error_covariance(std::span<const UnitClusters> units, const TypePrior& prior,
                                              const std::vector<double>& uncertainty_k) {
  const auto terms = static_cast<Eigen::Index>(prior.terms.size());
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(terms, terms);
  if (uncertainty_k.empty()) return sum;
  double clusters = 0;
  for (const UnitClusters& unit : units) {
    for (const data::Clusters& run : unit.runs) {
      const auto inputs = evaluate(prior.terms, run);
      if (!inputs) return failure(inputs.error());
      const data::Clusters known = pick_clusters(run, data::finite_rows(*inputs));
      const auto covariance = data::input_covariance(prior.terms, known, uncertainty_k);
      if (!covariance) return failure(covariance.error());
      const auto rows = static_cast<double>(known.start_s.size());
      sum += rows * *covariance;
      clusters += rows;
    }
  }
  const auto inverse = prior.scaling.std.cwiseInverse().asDiagonal();
  return Eigen::MatrixXd(inverse * (sum / clusters) * inverse);
}

Result<void> check_own(const TypePrior& prior, const data::Clusters& clusters) {
  if (clusters.length_s == prior.cluster_length_s) return {};
  return refuse_units(fmt::format("the cluster length is {} s, but the prior was learnt with {} s", clusters.length_s,
                                  prior.cluster_length_s));
}

}  // namespace

Result<TypePrior> learn_type_prior(std::span<const UnitClusters> units, const TypePriorOptions& options) {
  if (const auto checked = check_units(units); !checked) return failure(checked.error());
  TypePrior prior;
  prior.type = options.type;
  prior.simulated = options.simulated;
  prior.cluster_length_s = units.front().runs.front().length_s;
  prior.terms = terms_or_default(options, units.front().runs.front());
  for (const UnitClusters& unit : units) prior.units.push_back(unit.unit);
  const auto values = all_values(units, prior.terms);
  if (!values) return failure(values.error());
  const auto inputs = all_inputs(*values, static_cast<Eigen::Index>(prior.terms.size()));
  auto scaling = fit_scaling(inputs, prior.terms);
  if (!scaling) return failure(scaling.error());
  prior.scaling = std::move(*scaling);
  prior.input_min = inputs.colwise().minCoeff();
  prior.input_max = inputs.colwise().maxCoeff();
  const auto scaled = apply(prior.scaling, inputs);
  prior.term_spread = spread_within_runs(*values, prior.scaling);
  auto errors = term_error_covariance(units, prior, options.thermometer_uncertainty_k);
  if (!errors) return failure(errors.error());
  prior.error_covariance = std::move(*errors);
  const Eigen::MatrixXd components = find_components(scaled);
  const auto learnt = learn(make_designs(*values, prior.scaling, components), prior.cluster_length_s, options);
  if (!learnt) return failure(learnt.error());
  prior.noise = learnt->noise;
  prior.correlations_worth_units = learnt->chosen.worth_units;
  prior.next_unit = term_coefficients(next_unit(learnt->chosen.fit.population), components);
  return prior;
}

Result<LearntUnit> learn_unit(const TypePrior& prior, std::span<const data::Clusters> own) {
  UnitInformation all = no_information(prior.next_unit.mean.size());
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(prior.scaling.std.size());
  for (const data::Clusters& run : own) {
    if (const auto checked = check_own(prior, run); !checked) return failure(checked.error());
    const auto values = run_values(run, prior.terms);
    if (!values) return failure(values.error());
    const auto scaled = apply(prior.scaling, values->inputs);
    const auto identity = Eigen::MatrixXd::Identity(scaled.cols(), scaled.cols());
    Eigen::MatrixXd design_and_bias(scaled.rows(), scaled.cols() + 2);
    design_and_bias << make_design(scaled, identity), values->bias_deg_per_h;
    all = all + whitened_information(prior.noise, {values->time_s, std::move(design_and_bias)});
    sum += scaled.colwise().sum();
  }
  Coefficients known = posterior(prior.next_unit, all);
  // The trace of VA; both matrices are symmetric.
  const double decided = known.covariance.cwiseProduct(all.precision).sum();
  return LearntUnit{std::move(known), sum / std::max(1.0, all.rows), decided};
}

Eigen::VectorXd noise_aware_coefficients(const TypePrior& prior, const LearntUnit& unit) {
  assert(unit.coefficients.mean.size() == prior.next_unit.mean.size());
  Eigen::VectorXd coefficients = unit.coefficients.mean;
  if (prior.error_covariance.isZero(0)) return coefficients;
  const Eigen::MatrixXd& spread = prior.term_spread;
  const Eigen::VectorXd likeliest = coefficients.tail(spread.rows());
  const Eigen::VectorXd slopes = (spread + prior.error_covariance).ldlt().solve(spread * likeliest);
  coefficients.tail(spread.rows()) = slopes;
  coefficients(0) += unit.centre.dot(likeliest - slopes);
  return coefficients;
}

Result<UnitPrediction> predict(const TypePrior& prior, const LearntUnit& unit, const data::Clusters& clusters,
                               std::span<const double> drift_k) {
  if (const auto checked = check_own(prior, clusters); !checked) return failure(checked.error());
  const auto inputs = evaluate(prior.terms, clusters);
  if (!inputs) return failure(inputs.error());
  const auto scaled = apply(prior.scaling, *inputs);
  const Eigen::MatrixXd design = make_design(scaled, Eigen::MatrixXd::Identity(scaled.cols(), scaled.cols()));
  const Eigen::VectorXd coefficients = noise_aware_coefficients(prior, unit);
  double same = std::pow(prior.noise.wander_deg_per_h, 2) + std::pow(prior.noise.turn_on_deg_per_h, 2);
  const data::Clusters known = pick_clusters(clusters, data::finite_rows(*inputs));
  if (!drift_k.empty() && known.start_s.size() > 0) {
    const auto errors = data::input_covariance(prior.terms, known, {drift_k.begin(), drift_k.end()});
    if (!errors) return failure(errors.error());
    const Eigen::VectorXd slopes = coefficients.tail(scaled.cols()).cwiseQuotient(prior.scaling.std.transpose());
    same += slopes.dot(*errors * slopes);
  }
  const Eigen::VectorXd variance = (design * unit.coefficients.covariance).cwiseProduct(design).rowwise().sum() +
                                   (design * (unit.coefficients.mean - coefficients)).cwiseAbs2();
  const auto expanded = [&](double of_cluster) { return kUnitCoverageFactor * std::sqrt(of_cluster + same); };
  return UnitPrediction{design * coefficients, variance.unaryExpr(expanded)};
}

}  // namespace gyrotherm::population
