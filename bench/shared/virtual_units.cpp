// SPDX-License-Identifier: Apache-2.0
#include "bench/shared/virtual_units.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <utility>

#include "acquisition/record/record.hpp"
#include "analysis/data/dataset.hpp"
#include "bench/true_bias.hpp"

namespace gyrotherm::bench {
namespace {

Result<data::RecordedRun> load_run(const std::string& path) {
  auto dataset = data::load_dataset(path);
  if (!dataset) return failure(dataset.error());
  auto clusters = data::make_clusters(*dataset);
  if (!clusters) return failure(clusters.error());
  return data::RecordedRun{std::move(*dataset), std::move(*clusters)};
}

Result<Eigen::VectorXd> simulate_true_bias(const data::RecordedRun& run) {
  const auto record = record::read_record(run.dataset.path);
  if (!record) return failure(record.error());
  const auto bias = true_bias(*record, run.dataset.path);
  if (!bias) return failure(bias.error());
  data::Dataset truth = run.dataset;
  truth.bias_deg_per_h = *bias;
  const auto clusters = data::make_clusters(truth);
  if (!clusters) return failure(clusters.error());
  if (clusters->start_s == run.clusters.start_s) return clusters->bias_deg_per_h;
  return failure(FaultKind::numeric, run.dataset.path,
                 "the clusters of the true bias differ from the clusters of the record");
}

}  // namespace

Result<std::vector<VirtualUnit>> load_units(const std::string& folder, int count) {
  std::vector<VirtualUnit> units;
  for (int seed = 1; seed <= count; ++seed) {
    fmt::print(stderr, "unit {}\n", seed);
    auto rate = load_run(fmt::format("{}/rate-{}.db", folder, seed));
    auto random = load_run(fmt::format("{}/random-{}.db", folder, seed));
    if (!rate || !random) return failure(rate ? random.error() : rate.error());
    auto truth = simulate_true_bias(*random);
    if (!truth) return failure(truth.error());
    units.push_back({fmt::format("seed {}", seed), std::move(*rate), std::move(*random), std::move(*truth)});
  }
  return units;
}

MeanWithError mean_with_error(const std::vector<double>& values) {
  const auto count = static_cast<double>(values.size());
  double sum = 0, squares = 0;
  for (const double value : values) sum += value;
  for (const double value : values) squares += std::pow(value - sum / count, 2);
  return {sum / count, std::sqrt(squares / (count - 1) / count)};
}

double root_mean_square(const Eigen::VectorXd& values) {
  return std::sqrt(values.squaredNorm() / static_cast<double>(values.size()));
}

}  // namespace gyrotherm::bench
