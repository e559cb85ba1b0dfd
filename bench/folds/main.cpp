// SPDX-License-Identifier: Apache-2.0
/// Compares methods of holding out data: random clusters (which gyrotherm does not offer), blocks with and without a
/// guard, cycles, and nested cycles. The better its error agrees with the error on unseen data, the better the method.
/// Each method chooses the hyper-parameters again. The ten random folds come from a seeded shuffle.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <numeric>
#include <random>

#include "analysis/model/training.hpp"
#include "analysis/model/verification.hpp"

namespace gyrotherm::bench {
namespace {

struct Options {
  std::string run, unseen, inputs = "multi-point-t", method = "svr";
  int blocks = data::kDefaultBlocks;
  /// Number of clusters to use; the remaining ones become unseen data. 0: all clusters.
  Eigen::Index first = 0;
  bool quick = false;
  std::uint64_t seed = 1;
};

struct Record {
  data::Dataset dataset;
  data::Clusters clusters;
};

Result<Record> load(const std::string& path) {
  auto dataset = data::load_dataset(path);
  if (!dataset) return failure(dataset.error());
  auto clusters = data::make_clusters(*dataset);
  if (!clusters) return failure(clusters.error());
  return Record{std::move(*dataset), std::move(*clusters)};
}

/// Returns the record with only the clusters in the rows `from` … `end` − 1.
Record select_clusters(const Record& record, Eigen::Index from, Eigen::Index end) {
  std::vector<Eigen::Index> rows(static_cast<std::size_t>(end - from));
  std::iota(rows.begin(), rows.end(), from);
  return {record.dataset, pick_clusters(record.clusters, rows)};
}

data::FoldPlan random_folds(Eigen::Index rows, std::uint64_t seed) {
  constexpr int kFolds = 10;
  std::vector<Eigen::Index> order(static_cast<std::size_t>(rows));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::ranges::shuffle(order, std::mt19937_64(seed));
  std::vector<int> fold(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) fold[order[i]] = static_cast<int>(i % kFolds);
  data::FoldPlan plan{.folds = std::vector<data::Fold>(kFolds), .statement = "10 folds at random"};
  for (Eigen::Index k = 0; k < rows; ++k) {
    for (int f = 0; f < kFolds; ++f) (fold[k] == f ? plan.folds[f].held_out : plan.folds[f].training).push_back(k);
  }
  return plan;
}

Result<void> print_row(const Record& record, const std::vector<Record>& unseen, model::TrainingOptions options) {
  const auto began = std::chrono::steady_clock::now();
  const auto model = train({record.dataset}, {record.clusters}, options);
  if (!model) return failure(model.error());
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
  const auto show = [&](std::string_view what, const data::Figures& held_out, double unseen_rmse) {
    fmt::print("{:<52} {:>9.5g} {:>9.5g} {:>9.5g} {:>9.5g}", what, model->in_sample.rmse, held_out.std, held_out.rmse,
               unseen_rmse);
  };
  double unseen_rmse = std::nan("");
  for (const Record& other : unseen) {
    const auto verified = verify(*model, other.dataset, other.clusters);
    if (!verified) return failure(verified.error());
    unseen_rmse = verified->compensated.rmse;
  }
  show(model->folds, model->leave_cycle_out, unseen_rmse);
  for (const methods::HyperParameter& chosen : model->hyper_parameters)
    fmt::print("  {} {:.4g}", chosen.name, chosen.value);
  fmt::print("  {:.1f} s\n", took.count());
  if (!model->nested_leave_cycle_out) return {};
  show("  nested", *model->nested_leave_cycle_out, unseen_rmse);
  fmt::print("\n");
  return {};
}

Result<void> compare(const Options& options) {
  auto record = load(options.run);
  if (!record) return failure(record.error());
  std::vector<Record> unseen;
  if (const Eigen::Index all = record->clusters.start_s.size(); options.first > 0 && options.first < all) {
    unseen.push_back(select_clusters(*record, options.first, all));
    *record = select_clusters(*record, 0, options.first);
  }
  if (!options.unseen.empty()) {
    auto other = load(options.unseen);
    if (!other) return failure(other.error());
    unseen.push_back(std::move(*other));
  }
  model::TrainingOptions training;
  training.inputs = options.inputs;
  training.method = options.method;
  training.quick = options.quick;
  training.tuning.swarm.seed = options.seed;
  const double raw = data::compute_figures(record->clusters.bias_deg_per_h).std;
  fmt::print("{}{}, {} on {}; raw STD {:.5g} °/h over {} clusters\n", record->dataset.simulated ? "SIMULATED " : "",
             options.run, options.method, options.inputs, raw, record->clusters.start_s.size());
  fmt::print("{:<52} {:>9} {:>9} {:>9} {:>9}  chosen\n", "°/h", "in-sample", "held STD", "held RMSE", "unseen");

  model::TrainingOptions shuffled = training;
  shuffled.fold_plan = random_folds(record->clusters.start_s.size(), options.seed);
  if (const auto shown = print_row(*record, unseen, shuffled); !shown) return shown;
  training.nested = true;
  training.folds = {.kind = data::FoldKind::blocks, .blocks = options.blocks, .guard_minutes = 0};
  if (const auto shown = print_row(*record, unseen, training); !shown) return shown;
  training.folds.guard_minutes.reset();
  if (const auto shown = print_row(*record, unseen, training); !shown) return shown;
  if ((record->clusters.cycle.array() < 0).all()) return {};
  training.folds = {};
  if (const auto shown = print_row(*record, unseen, training); !shown) return shown;
  training.folds.guard_minutes = data::kDefaultGuardMinutes;
  return print_row(*record, unseen, training);
}

}  // namespace
}  // namespace gyrotherm::bench

int main(int argc, char** argv) {
  gyrotherm::bench::Options options;
  CLI::App cli("Compares methods of holding out data on one record.");
  cli.add_option("run", options.run)->required();
  cli.add_option("--verify", options.unseen, "a run for the error on unseen data");
  cli.add_option("--first", options.first, "use only the first N clusters; the remaining ones are unseen");
  cli.add_option("--inputs", options.inputs);
  cli.add_option("--method", options.method);
  cli.add_option("--blocks", options.blocks)->check(CLI::Range(2, 1000));
  cli.add_option("--seed", options.seed);
  cli.add_flag("--quick", options.quick, "use a small swarm");
  CLI11_PARSE(cli, argc, argv);
  const auto compared = gyrotherm::bench::compare(options);
  if (compared) return 0;
  fmt::print(stderr, "{}\n", gyrotherm::text(compared.error()));
  return 1;
}
