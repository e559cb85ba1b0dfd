// SPDX-License-Identifier: Apache-2.0
/// The expanded uncertainty of a model on a mission, and its expected decrease by further clusters.
#pragma once

#include "analysis/data/clusters.hpp"
#include "analysis/model/model.hpp"
#include "core/result.hpp"

namespace gyrotherm::planning {

/// Computes the expanded uncertainty of a mean over 1 h of the compensated bias, °/h, as the root mean square over the
/// clusters of a mission. It combines the rows of the model's budget with the excess of the predictive variance and the
/// extrapolation_factor() of each cluster; infinite if an input did not vary in the training and has another value on
/// the mission. The model must have an uncertainty. Fails with usage if the clusters lack a thermometer.
[[nodiscard]] Result<double> mission_uncertainty(const model::Model& model, const data::Clusters& mission);

/// Computes the mean predictive variance of the function over the clusters, (°/h)²; 0 without a cluster. Fails with
/// usage if the clusters lack a thermometer.
[[nodiscard]] Result<double> mean_variance(const model::Model& model, const data::Clusters& clusters);

/// Multiplies the half of the variance of the model form that depends on the training by the ratio of the mean
/// predictive variances on the mission. The other half is an error of the form itself.
void scale_form(model::Model& model, double variance_ratio);

/// Adds clusters to the trained range of a model and to the covariance of its coefficients, as if they had been
/// recorded. The function must be linear and have a predictive variance. Fails with usage if the clusters lack a
/// thermometer.
[[nodiscard]] Result<void> add_clusters(model::Model& model, const data::Clusters& clusters);

/// Returns the model as it is expected to be after `further` clusters with `further_power_ons` new power-ons, for
/// mission_uncertainty(); see assess(). Only range, variance and budget change. The function must be linear. Fails with
/// usage if the clusters lack a thermometer.
[[nodiscard]] Result<model::Model> expected_after(const model::Model& model, const data::Clusters& mission,
                                                  const data::Clusters& further, int further_power_ons);

}  // namespace gyrotherm::planning
