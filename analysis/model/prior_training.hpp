// SPDX-License-Identifier: Apache-2.0
/// Training with a type prior: what n units have shown becomes a file, and a few hours of the next unit complete it to
/// a model as any other (docs/shared-learning.md).
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
  std::string type = {};  ///< its name, for people
  /// Words and terms of inputs.hpp that select nothing; empty: seven-point and the first gradient thermometer.
  std::string inputs = {};
  bool quick = false;      ///< a try: the correlations of coefficients are not learnt
  bool simulated = false;  ///< whether any record is of a virtual gyro
};

/// Learns the prior of a type. Inputs, the thermometers' uncertainty in a year of use and the turn-on, 0.001 °/h where
/// it is not said, are those of `first`, a record of one of the units. Fails with usage (inputs that select, or that
/// the record lacks) or as learn_type_prior does.
[[nodiscard]] Result<population::TypePrior> learn_prior(const data::Dataset& first,
                                                        const std::vector<population::UnitClusters>& units,
                                                        const PriorOptions& options = {});

struct PriorTrainingOptions {
  data::FoldOptions folds;
  std::string program_version;
};

/// Trains a model of one unit from its type and its own records, at least one, of which any part will do: a straight
/// line in the terms and the scaling of the prior, of population::careful_coefficients, in °/h. It differs from train()
/// in four things:
/// - a fold is predicted by coefficients that are learnt without it, from the type and all other clusters; records that
///   are too short for folds (data::FoldKind::automatic) are held out together and predicted by the type alone;
/// - its trained range is that of the type's units and its own, so that an hour at −40 °C is no bound;
/// - its variance is what its own clusters and the type leave open of the coefficients, and the careful ones' distance
///   from the likeliest;
/// - its budget has that as a row, the root mean square over what units of the type go through, with as many degrees of
///   freedom as the type has units less one; and the model form is at least what the type's units leave unexplained
///   beyond hysteresis, flicker and walk: few own hours show little of it.
/// Its particulars name the type and its units. It warns of a prior that was learnt from this very gyro, which then
/// counts twice, and of one that mixes virtual and real gyros. Fails with usage (no record, a run given twice, a bias
/// that is counted from another zero, clusters without the prior's thermometers or of another length, or as plan_folds
/// does).
[[nodiscard]] Result<Model> train_with_prior(const population::TypePrior& prior,
                                             const std::vector<data::Dataset>& datasets,
                                             const std::vector<data::Clusters>& clusters,
                                             const PriorTrainingOptions& options);

}  // namespace gyrotherm::model
