// SPDX-License-Identifier: Apache-2.0
/// Compares tuning by the gradient of the held-out error with the particle swarm, on the folds of `gyrotherm train`.
/// Prints one tab-separated line for each record and inputs: clusters; evaluations, seconds of processor time and ln of
/// the error for swarm and descents; the error of the descents relative to that of the swarm, %.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <limits>

#include "analysis/model/training.hpp"
#include "bench/measurement.hpp"
#include "bench/tuning/descent.hpp"

namespace gyrotherm::bench {
namespace {

struct Options {
  std::vector<std::string> records, inputs = {"three-point", "multi-point", "thermal-history"};
  double cluster_length_s = 600, relative_gap = 1e-3;
  DescentOptions descent;
};

Result<std::vector<svm::TuningFold>> load_folds(const std::string& path, const std::string& inputs, double length_s) {
  const auto dataset = data::load_dataset(path);
  if (!dataset) return failure(dataset.error());
  const auto clusters = data::make_clusters(*dataset, length_s);
  if (!clusters) return failure(clusters.error());
  const auto plan = model::plan_inputs(inputs, *dataset, {});
  if (!plan) return failure(plan.error());
  const auto rows = model::rows_with_inputs(*plan, *clusters);
  if (!rows) return failure(rows.error());
  const auto folds = data::plan_folds({*clusters}, {.programs = data::list_programs({*dataset})});
  if (!folds) return failure(folds.error());
  const auto splits = model::split_at_folds(data::restrict_rows({.clusters = *clusters, .folds = *folds}, *rows), *plan,
                                            **methods::find_method("svr"), {});
  if (!splits) return failure(splits.error());
  std::vector<svm::TuningFold> tuning;
  for (const model::FoldData& split : *splits) {
    const model::Preparation& learnt = split.preparation;
    const auto scaled_target = [&](const data::Clusters& part) -> Eigen::VectorXd {
      return (part.bias_deg_per_h.array() - learnt.target_mean_deg_per_h) / learnt.target_std_deg_per_h;
    };
    const auto training = data::evaluate(learnt.terms, split.training.clusters);
    const auto held_out = data::evaluate(learnt.terms, split.held_out);
    if (!training || !held_out) return failure(training ? held_out.error() : training.error());
    tuning.push_back({.train_x = data::apply(learnt.scaling, *training),
                      .train_y = scaled_target(split.training.clusters),
                      .test_x = data::apply(learnt.scaling, *held_out),
                      .test_y = scaled_target(split.held_out),
                      .target_scale = learnt.target_std_deg_per_h,
                      .train_rows = split.training_rows});
  }
  return tuning;
}

Result<void> compare(const std::string& record, const std::string& inputs, const Options& options) {
  auto folds = load_folds(record, inputs, options.cluster_length_s);
  if (!folds) return failure(folds.error());
  Eigen::Index clusters = 0;
  for (const svm::TuningFold& fold : *folds) clusters += fold.test_y.size();
  svm::TuningOptions tuning;
  tuning.swarm.threads = 1;
  double began = thread_seconds();
  const auto swarm = svm::tune_svr(*folds, tuning);
  if (!swarm) return failure(swarm.error());
  const double swarm_s = thread_seconds() - began;
  began = thread_seconds();
  FoldErrors errors(*folds, options.relative_gap);
  const DescentResult found = descend(errors, options.descent);
  const double descent_s = thread_seconds() - began;
  // Both errors are computed again, without starts from other positions.
  const auto error =
      svm::cross_validation_error(*folds, parameters_at(found.best), {}, std::numeric_limits<double>::infinity());
  if (!error) return failure(error.error());
  fmt::print("{}\t{}\t{}\t{}\t{:.2f}\t{:.5f}\t{}\t{:.2f}\t{:.5f}\t{:+.2f}\n", record, inputs, clusters,
             swarm->swarm.evaluations, swarm_s, std::log(swarm->cross_validation_mse), errors.evaluations(), descent_s,
             std::log(*error), 100 * (*error / swarm->cross_validation_mse - 1));
  std::fflush(stdout);
  return {};
}

}  // namespace
}  // namespace gyrotherm::bench

int main(int argc, char** argv) {
  gyrotherm::bench::Options options;
  CLI::App cli("Compares tuning by the gradient of the held-out error with the particle swarm.");
  cli.add_option("records", options.records)->required();
  cli.add_option("--inputs", options.inputs)->delimiter(',');
  cli.add_option("--cluster-length", options.cluster_length_s, "s");
  cli.add_option("--gap", options.relative_gap, "relative gap of the trainings along a descent");
  cli.add_option("--screened", options.descent.screened);
  cli.add_option("--descents", options.descent.descents);
  cli.add_option("--evaluations", options.descent.most_evaluations);
  CLI11_PARSE(cli, argc, argv);
  for (const std::string& record : options.records)
    for (const std::string& inputs : options.inputs)
      if (const auto compared = gyrotherm::bench::compare(record, inputs, options); !compared) {
        fmt::print(stderr, "{}\n", gyrotherm::text(compared.error()));
        return 1;
      }
  return 0;
}
