// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "analysis/model/prior_training.hpp"
#include "analysis/model/training.hpp"
#include "analysis/model/uncertainty.hpp"
#include "analysis/model/verification.hpp"
#include "apps/console/command.hpp"
#include "apps/console/interrupt.hpp"
#include "apps/gyrotherm/output_file.hpp"
#include "apps/gyrotherm/recorded_run.hpp"
#include "core/count_text.hpp"

namespace gyrotherm::app {
namespace {

struct TrainArguments {
  std::vector<std::string> runs;
  std::string out, clusters, folds = "auto", select, choose = "best", prior, outliers = "name";
  double guard_minutes = -1, threshold = -1;  ///< negative: not given
  double cluster_length_s = 100;
  bool force = false, unverified = false;
  data::AxisChoice axis;
  model::TrainingOptions training;
};

std::string describe_figures(const data::Figures& f) {
  return fmt::format("{} °/h over {}", data::format_figures(f), format_count(f.count, "cluster"));
}

/// Returns the statistics of the raw bias over the clusters of all records.
data::Figures raw_figures(const RecordedRuns& records) {
  std::vector<double> bias;
  for (const data::Clusters& clusters : records.clusters)
    bias.insert(bias.end(), clusters.bias_deg_per_h.begin(), clusters.bias_deg_per_h.end());
  return data::compute_figures(Eigen::Map<const Eigen::VectorXd>(bias.data(), static_cast<Eigen::Index>(bias.size())));
}

/// Adds warnings to the model: findings of imports, outliers of the records, an unusual cluster length.
void add_warnings(model::Model& model, const RecordedRuns& records, double cluster_length_s) {
  constexpr double kUsual_s = 100;
  for (std::size_t i = 0; i < records.datasets.size(); ++i)
    for (std::string& warning : import_warnings(records.datasets[i], records.clusters[i]))
      model.warnings.push_back(std::move(warning));
  model.warnings.insert(model.warnings.end(), records.outliers.begin(), records.outliers.end());
  if (cluster_length_s != kUsual_s)
    model.warnings.push_back(fmt::format(
        "clusters are means over {:g} s, not {:g} s: their gyro noise is {:.2g} times as large, and temperature "
        "rates, lags and uncertainties refer to this cluster length",
        cluster_length_s, kUsual_s, std::sqrt(kUsual_s / cluster_length_s)));
}

std::string describe_trained(const model::Model& model, const data::Figures& raw) {
  std::string text;
  for (const auto& run : model.trained_on)
    text += fmt::format("{}trained on {}{}\n", run.simulated ? "SIMULATED: " : "",
                        is_named(run.of) ? qualified_name(run.of) + " of " : "", run.path);
  text += fmt::format("{} on {} ({})\n", model.method, model.inputs, format_count(model.terms.size(), "input"));
  if (const auto block = trained_block(model.trained_on))
    text += fmt::format("  trained range: {}\n", describe(*block));
  if (model.method == model::kTypePriorMethod) text += "  " + model.particulars + "\n";
  if (!model.selection.statement.empty()) text += "  selection: " + model.selection.statement + "\n";
  if (std::isfinite(model.residual_std_deg_per_h))
    text += fmt::format("  residual std (n − p): {:.5g} °/h, p = {:.4g}\n", model.residual_std_deg_per_h,
                        model.effective_parameters);
  if (const auto* svr = std::get_if<methods::SvrModel>(&model.function))
    text += fmt::format("  C {:.6g}, sigma {:.6g}, epsilon {:.6g}, {} support vectors, certified gap {:.2g}\n",
                        svr->parameters.C, svr->parameters.sigma, svr->parameters.epsilon, svr->beta.size(),
                        svr->relative_gap);
  if (const auto& rule = model.tuning.one_standard_error)
    text += fmt::format(
        "  the simplest of {} parameter sets within one standard error of the best (C {:.6g}, sigma {:.6g}, epsilon "
        "{:.6g})\n",
        rule->within, rule->best.C, rule->best.sigma, rule->best.epsilon);
  text += "  raw bias, without a model: " + describe_figures(raw) + "\n";
  text += "  in-sample (fitted to these data): " + describe_figures(model.in_sample) + "\n";
  text += fmt::format("  held out, {}: {}\n", model.folds, describe_figures(model.leave_cycle_out));
  if (model.nested_leave_cycle_out)
    text +=
        "    held out, choices repeated for each fold (nested): " + describe_figures(*model.nested_leave_cycle_out) +
        "\n";
  if (model.uncertainty) {
    constexpr double kHour_s = 3600;
    const auto combined = mean_uncertainty(*model.uncertainty, kHour_s);
    const bool without_holds = std::ranges::any_of(model.uncertainty->budget.rows, &model::BudgetRow::without_holds);
    text +=
        fmt::format("  uncertainty of a mean over 1 h: U = {:.5f} °/h (k = {:.2f}{})\n", combined.expanded_deg_per_h,
                    combined.coverage_factor, without_holds ? "; white noise from the residual, no holds" : "");
  }
  if (model.verdict) text += "  " + describe_verdict(*model.verdict) + "\n";
  for (const auto& warning : model.warnings) text += "  warning: " + warning + "\n";
  return text;
}

std::string method_names() {
  std::vector<std::string_view> names;
  for (const methods::Method& method : methods::methods()) names.push_back(method.name);
  return fmt::format("{}", fmt::join(names, ","));
}

Result<model::TrainingOptions> training_options(const TrainArguments& options) {
  model::TrainingOptions training = options.training;
  const auto folds = data::parse_folds(options.folds);
  if (!folds) return failure(folds.error());
  training.folds = *folds;
  if (options.guard_minutes >= 0) training.folds.guard_minutes = options.guard_minutes;
  if (!options.select.empty()) {
    const auto rule = model::parse_selection(options.select);
    if (!rule) return failure(rule.error());
    training.select = *rule;
  }
  const auto choice = svm::parse_choice(options.choose);
  if (!choice) return failure(choice.error());
  training.tuning.choice = *choice;
  if (options.threshold >= 0) training.select = model::SelectionRule{.threshold = options.threshold};
  return training;
}

/// Trains from the records; with --prior, also from the type prior.
Result<model::Model> train_model(Console& console, const TrainArguments& options, const RecordedRuns& records,
                                 const model::TrainingOptions& training) {
  if (options.prior.empty()) return train(records.datasets, records.clusters, training, console.sink());
  const auto prior = load_type_prior(options.prior);
  if (!prior) return failure(prior.error());
  return model::train_with_prior(*prior, records.datasets, records.clusters,
                                 {.folds = training.folds, .program_version = training.program_version});
}

Result<Exit> train_and_write(Console& console, const TrainArguments& options) {
  if (auto free = check_is_free(options.out, options.force); !free) return failure(free.error());
  const auto training = training_options(options);
  if (!training) return failure(training.error());
  const auto records = load_recorded_runs(
      console, options.runs,
      {options.clusters, options.unverified, options.axis, options.cluster_length_s, options.outliers == "leave-out"});
  if (!records) return failure(records.error());
  watch_for_interrupts(SecondInterrupt::ends);
  auto model = train_model(console, options, *records, *training);
  if (!model && model.error().where == "folds" && !options.clusters.empty())
    return failure(FaultKind::usage, "--clusters", model.error().what);
  if (!model) return failure(model.error());
  const data::Figures raw = raw_figures(*records);
  add_warnings(*model, *records, options.cluster_length_s);
  if (auto written = write_model(options.out, *model); !written) return failure(written.error());
  console.print_report(console.json ? to_json(*model) : describe_trained(*model, raw));
  return Exit::done;
}

/// Adds --prior, which excludes all options that choose a method or inputs: the type prior determines both.
void add_prior(CLI::App& command, TrainArguments& options) {
  auto* prior = command
                    .add_option("--prior", options.prior,
                                "a type prior written by type-prior; it determines method and inputs, and a few hours "
                                "of the unit's records suffice")
                    ->type_name(value::kModel);
  for (const auto* own : {"--inputs", "--select", "--threshold", "--method", "--choose", "--nested", "--quick"})
    prior->excludes(command.get_option(own));
}

}  // namespace

void add_train(Program& program) {
  auto [command, options] =
      add_command(program, "train", "Trains a compensation model on one or more records.",
                  "gyrotherm train ramp.db --inputs multi-point-t --out model.json", train_and_write);
  options.training.program_version = GYROTHERM_VERSION;
  command.add_option("runs", options.runs, "the records")->type_name(value::kRecord)->required();
  command.add_option("--out", options.out, "the model")->check(reject_dash())->type_name(value::kModel)->required();
  add_force_flag(command, options.force);
  command
      .add_option("--inputs", options.training.inputs,
                  "keywords and terms, joined by commas or +: multi-point, multi-point-t, three-point, three-point-t, "
                  "seven-point, gradients, temperatures, rates, polynomial, temperature-gradient-rate, physics, "
                  "thermal-history, lag-bank, or terms like A-B,A,rate:A,lag:600:A,A^2,A*A-B, self (the unit's own "
                  "temperature), aux:NAME (default: the inputs that the method was published with)")
      ->type_name("TERMS");
  auto* select =
      command
          .add_option("--select", options.select,
                      "selection among the inputs of a keyword, made inside each fold: correlation[:R] (|r| above R, "
                      "default 0.90; multi-point uses it), forward[:N] (at most N, by held-out gain), "
                      "redundancy[:PART] (inputs that do not depend on others); terms given one by one are always used")
          ->type_name("RULE");
  command.add_option("--threshold", options.threshold, "short for --select correlation:R")
      ->check(CLI::Range(0.0, 1.0))
      ->excludes(select);
  command.add_option("--method", options.training.method, "regression method (docs/methods.md; default: svr)")
      ->type_name("METHOD:{" + method_names() + "}");
  command
      .add_option("--folds", options.folds,
                  "kind of fold: cycles, starts (power-ons), records (whole records), programs (all records of a "
                  "profile), blocks[:N] (N consecutive blocks, default 4) or auto (default). auto uses records if "
                  "there are three or more and none has cycles; otherwise cycles, with a record without cycles divided "
                  "into blocks: 4, or blocks of 45 min if it has several power-ons")
      ->type_name("FOLDS");
  command
      .add_option("--choose", options.choose,
                  "rule for C, sigma and epsilon by held-out error: best (default; as in the paper) or one-se, the "
                  "simplest within one standard error of the best")
      ->type_name("RULE:{best,one-se}");
  command
      .add_option("--guard", options.guard_minutes,
                  "guard interval around each fold, in minutes, that is also excluded from training (default: 0 for "
                  "cycles; 45 for blocks, at most half a block)")
      ->check(not_negative());
  command.add_flag("--nested", options.training.nested,
                   "nested cross-validation: repeat all choices without each held-out fold; takes about twice as long");
  command.add_option("--clusters", options.clusters, "only these clusters of each record, like 0:14")
      ->type_name("FIRST:END");
  add_axis_options(command, options.axis);
  command
      .add_option(
          "--cluster-length", options.cluster_length_s,
          "length of a cluster in seconds (default: 100). Shorter clusters resolve a short warm-up but have more noise")
      ->check(CLI::Range(1.0, 3600.0))
      ->type_name("SECONDS");
  command
      .add_option("--outliers", options.outliers,
                  "treatment of outliers of the bias: name (default) reports their number, size and time; leave-out "
                  "excludes their clusters")
      ->check(CLI::IsMember({"name", "leave-out"}));
  add_unverified_flag(command, options.unverified);
  command.add_flag("--quick", options.training.quick, "small swarm, for a trial; the model states it");
  command.add_option("--seed", options.training.tuning.swarm.seed, "seed of the swarm")->check(not_negative());
  command
      .add_option("--threads", options.training.tuning.swarm.threads,
                  "threads of the swarm; 0: all; the result is the same")
      ->check(not_negative());
  add_prior(command, options);
}

}  // namespace gyrotherm::app
