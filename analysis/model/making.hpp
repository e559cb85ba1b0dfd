// SPDX-License-Identifier: Apache-2.0
/// What a model says of its own making, whichever way it was fitted: its records, what it leaves of them, the range in
/// which it was made, and how what it leaves of held-out clusters wanders.
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

/// Fails with usage if a run is given twice, which would be held out and learnt from at once, if records say that they
/// are of different gyros, if their biases are counted from different zeros, or if one jumps by turning the unit
/// around.
[[nodiscard]] Result<void> check_records(const std::vector<data::Dataset>& datasets,
                                         const std::vector<data::Clusters>& records);

/// Writes down each record with those of its clusters that were learnt from; a record without any is left out. A
/// three-point model of a record without a shell thermometer gets a warning.
void record_sources(Model& model, const std::vector<data::Dataset>& datasets,
                    const std::vector<data::Clusters>& records);

/// Writes down what the fit does on its own training clusters, the range of its inputs there, and what a stream lags.
/// Fails with usage if the clusters lack a thermometer.
[[nodiscard]] Result<void> judge_in_sample(Model& model, const data::Clusters& clusters);

/// Warns where the in-sample residual lies further below a record's noise floor than its parameters account for.
void warn_of_over_fit(Model& model, const std::vector<data::Dataset>& datasets,
                      const std::vector<data::Clusters>& records);

/// How the held-out residual of the model wanders, `records` being its training clusters record by record; nothing if
/// they are too few.
[[nodiscard]] std::optional<tracking::BiasNoise> wander_of(const Model& model,
                                                           const std::vector<data::Dataset>& datasets,
                                                           const std::vector<data::Clusters>& records,
                                                           const data::Clusters& all);

}  // namespace gyrotherm::model
