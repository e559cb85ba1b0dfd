// SPDX-License-Identifier: Apache-2.0
/// Judges what a navigation computer gets second by second as a record's means are judged. compensate and the C export
/// see the past alone, and lag.
#pragma once

#include <optional>

#include "analysis/data/clusters.hpp"
#include "analysis/data/dataset.hpp"
#include "analysis/data/statistics.hpp"
#include "analysis/model/model.hpp"
#include "analysis/model/verification.hpp"
#include "core/form.hpp"
#include "core/result.hpp"

namespace gyrotherm::model {

/// Computes what the lag of half a cluster length costs, from means that follow each other: with p the predictions,
/// half the root mean square of p_k − p_{k−1} where nothing is done, and of p_k − 2 p_{k−1} + p_{k−2} where the
/// prediction is led, p + ½(p − p before). Noise of the thermometers is in both, so that a model whose lead would cost
/// more noise than it gains is not led. Nothing of fewer than three means in a row.
[[nodiscard]] std::optional<Latency> latency_of(const Model& model, const data::Clusters& clusters,
                                                const Eigen::VectorXd& predicted_deg_per_h);

/// Streams the record through the model. `aligned_residual_deg_per_h` is that of verify(). Fails with usage if rows are
/// not one a second, the model needs a thermometer that the record lacks, or no cluster has a value in every second.
[[nodiscard]] Result<Streamed> as_streamed(const Model& model, const data::Dataset& dataset,
                                           const data::Clusters& clusters,
                                           const Eigen::VectorXd& aligned_residual_deg_per_h,
                                           Outside outside = Outside::continued);

}  // namespace gyrotherm::model
