// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/prior_training.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "analysis/data/statistics.hpp"
#include "analysis/model/inputs.hpp"
#include "analysis/model/making.hpp"
#include "analysis/model/uncertainty.hpp"

namespace gyrotherm::model {
namespace {

using RowNumbers = std::vector<Eigen::Index>;

/// Clusters of the unit itself, only those with a value of every input: by record, and concatenated.
struct OwnClusters {
  std::vector<data::Clusters> records;
  data::Clusters all;
  Eigen::Index omitted_clusters{};  ///< without a value of every input
};

Result<OwnClusters> own_clusters(const population::TypePrior& prior, const std::vector<data::Dataset>& datasets,
                                 const std::vector<data::Clusters>& clusters) {
  OwnClusters own;
  const InputPlan plan{.fixed = prior.terms, .candidates = {}, .rule = {}};
  for (std::size_t i = 0; i < clusters.size(); ++i) {
    const auto whole = rows_with_inputs(plan, clusters[i]);
    if (!whole) return failure(whole.error());
    if (whole->empty()) return failure(FaultKind::usage, datasets[i].path, "no cluster has a value of every input");
    own.omitted_clusters += clusters[i].start_s.size() - std::ssize(*whole);
    own.records.push_back(pick_clusters(clusters[i], *whole));
  }
  return concatenate(own.records).map([&](data::Clusters&& all) {
    own.all = std::move(all);
    return std::move(own);
  });
}

/// Selects these rows of all clusters, by record; omits records without any.
std::vector<data::Clusters> select_records(const OwnClusters& own, const RowNumbers& rows) {
  std::vector<data::Clusters> within;
  auto row = rows.begin();
  Eigen::Index first = 0;
  for (const data::Clusters& record : own.records) {
    const Eigen::Index end = first + record.start_s.size();
    RowNumbers inside;
    for (; row != rows.end() && *row < end; ++row) inside.push_back(*row - first);
    if (!inside.empty()) within.push_back(pick_clusters(record, inside));
    first = end;
  }
  return within;
}

/// Plans the folds. Records that are too short become a single fold, which is predicted only from the type.
Result<data::FoldPlan> plan_own_folds(const OwnClusters& own, const std::vector<data::Dataset>& datasets,
                                      data::FoldOptions options) {
  options.programs = list_programs(datasets);
  auto plan = plan_folds(own.records, options);
  if (plan || options.kind != data::FoldKind::automatic) return plan;
  data::Fold all;
  for (Eigen::Index row = 0; row < own.all.start_s.size(); ++row) all.held_out.push_back(row);
  return data::FoldPlan{{std::move(all)}, "all held out together, predicted from the type only"};
}

/// Returns the plane with these coefficients (constant first) in °/h. The target is not scaled: its mean is 0 and its
/// STD 1.
methods::LinearModel make_plane(const Eigen::VectorXd& coefficients) {
  return {.weights = coefficients.tail(coefficients.size() - 1), .b = coefficients(0)};
}

/// Returns the variance of the noise-aware coefficients: their covariance, and their distance from the most likely
/// ones.
methods::PredictiveVariance noise_aware_variance(const population::TypePrior& prior, const population::LearntUnit& unit,
                                                 const Eigen::VectorXd& coefficients) {
  const Eigen::VectorXd apart = unit.coefficients.mean - coefficients;
  const Eigen::MatrixXd open = unit.coefficients.covariance + apart * apart.transpose();
  RowNumbers slopes_first;
  for (Eigen::Index i = 1; i < coefficients.size(); ++i) slopes_first.push_back(i);
  slopes_first.push_back(0);
  return methods::plane_variance(open(slopes_first, slopes_first), prior.noise.white_deg_per_h);
}

std::string describe_type(const population::TypePrior& prior) {
  constexpr double kSecondsInAnHour = 3600;
  return fmt::format(
      "{}type \"{}\" of {} units ({}); unexplained drift {:.2g} °/h with a time constant of {:.2g} h, white noise "
      "{:.2g} °/h per mean",
      prior.simulated ? "SIMULATED: " : "", prior.type, prior.units.size(), fmt::join(prior.units, "; "),
      prior.noise.wander_deg_per_h, prior.noise.wander_time_s / kSecondsInAnHour, prior.noise.white_deg_per_h);
}

/// Assembles the function, its inputs and all members that do not depend on the unit's residuals.
Model assemble(const population::TypePrior& prior, const population::LearntUnit& unit) {
  const Eigen::VectorXd coefficients = noise_aware_coefficients(prior, unit);
  Model model;
  model.method = kTypePriorMethod;
  std::vector<std::string> names;
  for (const data::Term& term : prior.terms) names.push_back(to_string(term));
  model.inputs = fmt::format("{}", fmt::join(names, ","));
  model.cluster_length_s = prior.cluster_length_s;
  model.terms = prior.terms;
  model.scaling = prior.scaling;
  model.target_std_deg_per_h = 1;
  model.function = make_plane(coefficients);
  model.effective_parameters = unit.effective_parameters;
  model.particulars = describe_type(prior);
  model.variance = noise_aware_variance(prior, unit, coefficients);
  return model;
}

Result<Model> learn_model(const population::TypePrior& prior, const std::vector<data::Clusters>& records) {
  return learn_unit(prior, records).map([&](const population::LearntUnit& unit) { return assemble(prior, unit); });
}

Result<void> evaluate_held_out(Model& model, const population::TypePrior& prior, const OwnClusters& own,
                               const data::FoldPlan& folds) {
  Eigen::VectorXd residual =
      Eigen::VectorXd::Constant(own.all.start_s.size(), std::numeric_limits<double>::quiet_NaN());
  for (const data::Fold& fold : folds.folds) {
    const auto without = learn_model(prior, select_records(own, fold.training));
    if (!without) return failure(without.error());
    const auto predicted = predict(*without, pick_clusters(own.all, fold.held_out));
    if (!predicted) return failure(predicted.error());
    residual(fold.held_out) = own.all.bias_deg_per_h(fold.held_out) - *predicted;
  }
  model.folds = folds.statement;
  model.leave_cycle_out = compute_figures(residual, own.all);
  model.leave_cycle_out_residual = std::move(residual);
  model.verdict = judge_held_out(model.leave_cycle_out_residual, own.all, model.effective_parameters);
  return {};
}

/// Returns √E[(z, 1)ᵀS(z, 1)] over the temperatures in use, with S the covariance of the coefficients. z is assumed to
/// vary as in the type's units, about a mean that the errors of the unit's thermometers cause. Given c, the mean of z
/// over the unit's own clusters, the estimate of this mean is E(M + E)⁻¹c, with M the spread of z and E the covariance
/// of the thermometer errors. The remainder of c is attributed to the part of the profile that the clusters cover.
/// Differences of hundredths of a kelvin matter, because the slopes of nearly equal thermometers can be large and of
/// opposite sign.
double coefficient_uncertainty_deg_per_h(const population::TypePrior& prior, const population::LearntUnit& unit,
                                         const methods::PredictiveVariance& variance) {
  const Eigen::Index inputs = prior.scaling.std.size();
  const Eigen::MatrixXd& errors = prior.error_covariance;
  Eigen::VectorXd mean = Eigen::VectorXd::Ones(inputs + 1);
  mean.head(inputs) = errors * (prior.term_spread + errors).ldlt().solve(unit.centre);
  const auto slopes = variance.posterior.topLeftCorner(inputs, inputs);
  return std::sqrt(mean.dot(variance.posterior * mean) + slopes.cwiseProduct(prior.term_spread).sum());
}

double source_variance(const std::vector<BudgetRow>& rows, Source source) {
  double square = 0;
  for (const BudgetRow& row : rows)
    if (row.source == source) square += std::pow(contribution_deg_per_h(row), 2);
  return square;
}

/// Adds the coefficients row, and raises the model form row to the value that the type's data imply. The type's data
/// determine both better than a few hours of data from one unit.
void add_type_rows(std::vector<BudgetRow>& rows, const population::TypePrior& prior, double coefficients) {
  const double freedom = std::max(1.0, static_cast<double>(prior.units.size()) - 1);
  const double explained = source_variance(rows, Source::hysteresis) + source_variance(rows, Source::flicker) +
                           source_variance(rows, Source::rate_random_walk);
  const double form = std::sqrt(std::max(0.0, std::pow(prior.noise.wander_deg_per_h, 2) - explained));
  auto row = std::ranges::find(rows, Source::model_form, &BudgetRow::source);
  if (row == rows.end()) row = rows.insert(row, {.source = Source::model_form});
  if (row->standard_uncertainty < form) {
    row->standard_uncertainty = form;
    row->degrees_of_freedom = freedom;
  }
  rows.insert(row + 1,
              {.source = Source::coefficients, .standard_uncertainty = coefficients, .degrees_of_freedom = freedom});
}

/// Returns true if the type was learnt from this run, or from another run of the same gyro. Unit names are recorded
/// identities unless the user chose them.
bool is_learnt_from(const population::TypePrior& prior, const data::Dataset& dataset) {
  const auto is_known = [&](const std::string& identity) { return !identity.empty() && identity == dataset.identity; };
  return std::ranges::any_of(prior.units, is_known) ||
         std::ranges::any_of(prior.records, [&](const population::PriorRecord& record) {
           const bool same_run =
               record.run_id == dataset.run_id && record.unit == dataset.of.unit && record.axis == dataset.of.axis;
           return same_run || is_known(record.identity);
         });
}

void add_warnings(Model& model, const population::TypePrior& prior, const std::vector<data::Dataset>& datasets,
                  const OwnClusters& own) {
  if (own.omitted_clusters > 0) {
    model.warnings.push_back(fmt::format("clusters without all inputs were excluded: {} of {}", own.omitted_clusters,
                                         own.omitted_clusters + own.all.start_s.size()));
  }
  for (const data::Dataset& dataset : datasets) {
    if (is_learnt_from(prior, dataset)) {
      model.warnings.push_back(fmt::format("{}: the prior was also learnt from this gyro{}; its data counts twice",
                                           dataset.path,
                                           dataset.identity.empty() ? "" : fmt::format(" ({})", dataset.identity)));
    }
    if (dataset.simulated != prior.simulated) {
      model.warnings.push_back(fmt::format("{}: the record is {}, the prior is {}", dataset.path,
                                           dataset.simulated ? "SIMULATED" : "of a real gyro",
                                           prior.simulated ? "SIMULATED" : "of real gyros"));
    }
  }
}

/// Fails if the record and the prior have different bias references.
Result<void> check_bias_reference(const population::TypePrior& prior, const data::Dataset& dataset) {
  const bool is_known = !prior.records.empty() && !prior.records.front().bias_zero.empty();
  return is_known ? check_same_reference(dataset, prior.records.front().bias_zero, "the prior") : Result<void>{};
}

}  // namespace

Result<population::TypePrior> learn_prior(const data::Dataset& first,
                                          const std::vector<population::UnitClusters>& units,
                                          const PriorOptions& options) {
  const std::string inputs =
      options.inputs.empty() && !first.gradients.empty() ? "seven-point," + first.gradients.front() : options.inputs;
  const auto plan = plan_inputs(inputs, first);
  if (!plan) return failure(plan.error());
  if (!plan->candidates.empty()) {
    return failure(FaultKind::usage, "--inputs",
                   fmt::format("\"{}\" selects inputs by rule; list the inputs of a type explicitly", inputs));
  }
  return learn_type_prior(units, {.type = options.type,
                                  .terms = plan->fixed,
                                  .turn_on_deg_per_h = turn_on_repeatability(first),
                                  .thermometer_uncertainty_k = thermometers_in_use(first).uncertainty_k,
                                  .quick = options.quick,
                                  .simulated = options.simulated});
}

Result<Model> train_with_prior(const population::TypePrior& prior, const std::vector<data::Dataset>& datasets,
                               const std::vector<data::Clusters>& clusters, const PriorTrainingOptions& options) {
  if (datasets.empty() || datasets.size() != clusters.size())
    return failure(FaultKind::usage, "training", "needs at least one record");
  if (const auto sound = check_records(datasets, clusters); !sound) return failure(sound.error());
  if (const auto sound = check_bias_reference(prior, datasets.front()); !sound) return failure(sound.error());
  const auto own = own_clusters(prior, datasets, clusters);
  if (!own) return failure(own.error());
  const auto folds = plan_own_folds(*own, datasets, options.folds);
  if (!folds) return failure(folds.error());
  const auto unit = learn_unit(prior, own->records);
  if (!unit) return failure(unit.error());
  Result<Model> model = assemble(prior, *unit);
  if (const auto judged = evaluate_held_out(*model, prior, *own, *folds); !judged) return failure(judged.error());
  model->program_version = options.program_version;
  model->residual_noise = held_out_noise(*model, datasets, own->records, own->all);
  record_sources(*model, datasets, own->records);
  if (const auto judged = evaluate_in_sample(*model, own->all); !judged) return failure(judged.error());
  model->input_min = model->input_min.cwiseMin(prior.input_min);
  model->input_max = model->input_max.cwiseMax(prior.input_max);
  auto uncertainty = evaluate_uncertainty(*model, {.datasets = datasets,
                                                   .clusters = own->records,
                                                   .held_out_residual_deg_per_h = model->leave_cycle_out_residual,
                                                   .variance_is_a_row = true});
  if (!uncertainty) return failure(uncertainty.error());
  add_type_rows(uncertainty->budget.rows, prior, coefficient_uncertainty_deg_per_h(prior, *unit, *model->variance));
  model->uncertainty = std::move(*uncertainty);
  add_warnings(*model, prior, datasets, *own);
  warn_about_over_fit(*model, datasets, own->records);
  if (auto warning = make_no_gain_warning("held-out residual bias", *model->verdict))
    model->warnings.push_back(std::move(*warning));
  return model;
}

}  // namespace gyrotherm::model
