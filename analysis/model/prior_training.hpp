// SPDX-License-Identifier: Apache-2.0
/// Training with a type prior: a prior learnt from n units of a type, and a few hours of data from a further unit, give
/// an ordinary model of that unit (docs/shared-learning.md).
#pragma once

#include <string>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "analysis/data/dataset.hpp"
#include "analysis/data/folds.hpp"
#include "analysis/model/model.hpp"
#include "analysis/population/type_prior.hpp"
#include "core/result.hpp"

namespace gyrotherm::model {

struct PriorOptions {
  std::string type = {};
  /// Keywords and terms of inputs.hpp without selection; empty: seven-point and the first gradient thermometer.
  std::string inputs = {};
  /// Skips learning the correlations of the coefficients, for a quick trial.
  bool quick = false;
  /// True if at least one record is of a virtual gyro.
  bool simulated = false;
};

/// Learns the prior of a type. `first` is a record of one of the units; the inputs, the thermometers' uncertainty after
/// a year of use and the turn-on repeatability (0.001 °/h if not stated) are taken from it. Fails with usage if the
/// inputs require selection or are missing in the record, or like learn_type_prior().
[[nodiscard]] Result<population::TypePrior> learn_prior(const data::Dataset& first,
                                                        const std::vector<population::UnitClusters>& units,
                                                        const PriorOptions& options = {});

struct PriorTrainingOptions {
  data::FoldOptions folds;
  std::string program_version;
};

/// Trains a model of one unit from its type and at least one record of its own; any part of a run is sufficient. The
/// function is linear in the scaled terms of the prior, with the coefficients of population::noise_aware_coefficients,
/// in °/h. The training differs from train() in four points:
/// - a fold is predicted by coefficients that are learnt from the type and all other clusters; records that are too
///   short for folds (data::FoldKind::automatic) are held out together and predicted only from the type;
/// - the trained range is the union of the type's and the unit's own, so an hour at −40 °C does not restrict it;
/// - the variance is the uncertainty of the coefficients, given the type and the unit's own clusters, and the distance
///   of the noise-aware coefficients from the most likely ones;
/// - the budget has a row for this variance: its root mean square over the conditions of the type's units, with one
///   degree of freedom less than the number of units. The model form is at least the part of the type's noise that
///   hysteresis, flicker and random walk do not explain, since a few hours of the unit's own data reveal little of it.
/// The particulars name the type and its units. Warns if the prior was learnt from the same gyro, whose data would then
/// be used twice, and if virtual and real gyros are mixed. Fails with usage for no record, a run given twice, another
/// bias reference, or clusters without the prior's thermometers or of another length, or like plan_folds().
[[nodiscard]] Result<Model> train_with_prior(const population::TypePrior& prior,
                                             const std::vector<data::Dataset>& datasets,
                                             const std::vector<data::Clusters>& clusters,
                                             const PriorTrainingOptions& options);

}  // namespace gyrotherm::model
