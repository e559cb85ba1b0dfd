// SPDX-License-Identifier: Apache-2.0
/// The description of a model's training, common to all ways of fitting: its records, its in-sample residual, the
/// trained range and the noise of its held-out residual.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "analysis/data/dataset.hpp"
#include "analysis/model/model.hpp"
#include "analysis/tracking/bias_noise.hpp"
#include "core/result.hpp"

namespace gyrotherm::model {

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

/// Warns if the in-sample residual is further below a record's noise floor than the number of parameters explains.
void warn_about_over_fit(Model& model, const std::vector<data::Dataset>& datasets,
                         const std::vector<data::Clusters>& records);

/// Estimates the noise of the model's held-out residual. Returns no value if there are too few clusters. `records`
/// holds the training clusters by record; `all` holds the same clusters, concatenated.
[[nodiscard]] std::optional<tracking::BiasNoise> held_out_noise(const Model& model,
                                                                const std::vector<data::Dataset>& datasets,
                                                                const std::vector<data::Clusters>& records,
                                                                const data::Clusters& all);

}  // namespace gyrotherm::model
