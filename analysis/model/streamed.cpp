// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/streamed.hpp"

#include <cmath>
#include <limits>
#include <vector>

#include "analysis/model/stream.hpp"

namespace gyrotherm::model {
namespace {

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

/// The means of what the stream leaves, °/h; NaN where a second of the cluster has no value.
Eigen::VectorXd means_of(const Eigen::VectorXd& compensated, const data::Dataset& dataset,
                         const data::Clusters& clusters) {
  Eigen::VectorXd means = Eigen::VectorXd::Constant(clusters.start_s.size(), kMissing);
  Eigen::Index row = 0;
  for (Eigen::Index k = 0; k < means.size(); ++k) {
    const double start = clusters.start_s(k), end = start + clusters.length_s;
    while (row < compensated.size() && dataset.time_s(row) < start) ++row;
    double sum = 0, count = 0;
    for (; row < compensated.size() && dataset.time_s(row) < end; ++row, ++count) sum += compensated(row);
    if (count > 0) means(k) = sum / count;
  }
  return means;
}

}  // namespace

std::optional<Latency> latency_of(const Model& model, const data::Clusters& clusters,
                                  const Eigen::VectorXd& predicted_deg_per_h) {
  const Eigen::VectorXd& p = predicted_deg_per_h;
  const auto follows = [&](Eigen::Index k) {
    return std::abs(clusters.start_s(k) - clusters.start_s(k - 1) - clusters.length_s) < clusters.length_s / 2;
  };
  double first = 0, second = 0, count = 0;
  for (Eigen::Index k = 2; k < p.size(); ++k) {
    if (!follows(k) || !follows(k - 1) || !p.segment(k - 2, 3).allFinite()) continue;
    first += std::pow(p(k) - p(k - 1), 2);
    second += std::pow(p(k) - 2 * p(k - 1) + p(k - 2), 2);
    ++count;
  }
  if (count == 0) return std::nullopt;
  return Latency{.lag_s = model.cluster_length_s / 2,
                 .lagging_rms_deg_per_h = std::sqrt(first / count) / 2,
                 .led_rms_deg_per_h = std::sqrt(second / count) / 2,
                 .is_led = second < first};
}

Result<Streamed> as_streamed(const Model& model, const data::Dataset& dataset, const data::Clusters& clusters,
                             const Eigen::VectorXd& aligned_residual_deg_per_h, Outside outside) {
  constexpr double kOff = 0.01;
  if (std::abs(data::sample_interval_s(dataset) - 1) > kOff)
    return failure(FaultKind::usage, dataset.path, "rows are not one a second: there is nothing to be streamed");
  auto stream = CompensationStream::open(model, dataset.thermometers, outside);
  if (!stream) return failure(stream.error());
  const data::SampleMatrix temperatures = dataset.temperature_c;
  Eigen::VectorXd residual =
      means_of(stream->push_at(dataset.time_s, temperatures, dataset.bias_deg_per_h), dataset, clusters);
  Eigen::VectorXd aligned = aligned_residual_deg_per_h;
  for (Eigen::Index k = 0; k < residual.size(); ++k)
    if (!std::isfinite(residual(k)) || !std::isfinite(aligned(k))) residual(k) = aligned(k) = kMissing;
  const std::vector<Eigen::Index> rows = data::finite_rows(residual);
  if (rows.empty()) return failure(FaultKind::usage, dataset.path, "no cluster has a streamed value in every second");
  return Streamed{.residual = figures_of(residual(rows), clusters, rows),
                  .aligned = figures_of(aligned(rows), clusters, rows),
                  .to_truth = error_to_truth(dataset, clusters, residual),
                  .aligned_to_truth = error_to_truth(dataset, clusters, aligned)};
}

}  // namespace gyrotherm::model
