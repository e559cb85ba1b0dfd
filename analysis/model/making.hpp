// SPDX-License-Identifier: Apache-2.0
/// The description of a model's training, common to all ways of fitting: its records, its in-sample residual, the
/// trained range and the noise of its held-out residual.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "analysis/data/dataset.hpp"
#include "analysis/data/rate_trace.hpp"
#include "analysis/model/model.hpp"
#include "analysis/tracking/bias_noise.hpp"
#include "core/result.hpp"

namespace gyrotherm::model {

/// Readings of an imported record by which another record of the same measurement is recognised.
struct ReadingsSample {
  std::string path;
  /// Nothing for a record that was not imported.
  std::optional<data::RateTrace> trace;
};
[[nodiscard]] ReadingsSample sample_readings(const data::Dataset& dataset, const data::Clusters& clusters);
/// Returns whether an imported record has readings of the sample, at whatever time, also in another unit, rounded or
/// averaged.
[[nodiscard]] bool has_readings_of(const data::Dataset& dataset, const data::Clusters& clusters,
                                   const ReadingsSample& sample);
/// Fails with usage if a record has readings of one of the others.
[[nodiscard]] Result<void> check_distinct(const data::Dataset& dataset, const data::Clusters& clusters,
                                          const std::vector<ReadingsSample>& others);

/// Fails with usage if a run is given twice or imported records have common rows (such rows would be held out and used
/// for training at the same time), if records are of different gyros or have different bias references, or if a bias
/// jumps because the unit was turned around.
[[nodiscard]] Result<void> check_records(const std::vector<data::Dataset>& datasets,
                                         const std::vector<data::Clusters>& records);

/// Stores each record with the part of its clusters that was used in training. Omits a record without such clusters.
/// Warns if a three-point model has a record without a shell thermometer.
void record_sources(Model& model, const std::vector<data::Dataset>& datasets,
                    const std::vector<data::Clusters>& records);

/// Stores the in-sample residual, the trained range of the inputs and the latency of a stream in `model`. Fails with
/// usage if the clusters lack a thermometer.
[[nodiscard]] Result<void> evaluate_in_sample(Model& model, const data::Clusters& clusters);

/// Warns if the in-sample residual is below a record's noise floor by more than two standard errors.
void warn_about_over_fit(Model& model, const std::vector<data::Dataset>& datasets,
                         const std::vector<data::Clusters>& records);

/// Estimates the noise of the model's held-out residual. Returns no value if there are too few clusters. `records`
/// holds the training clusters by record; `all` holds the same clusters, concatenated.
[[nodiscard]] std::optional<tracking::BiasNoise> held_out_noise(const Model& model,
                                                                const std::vector<data::Dataset>& datasets,
                                                                const std::vector<data::Clusters>& records,
                                                                const data::Clusters& all);

}  // namespace gyrotherm::model
