// SPDX-License-Identifier: Apache-2.0
/// The value of each thermometer: the loss of accuracy without it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "analysis/data/features.hpp"
#include "analysis/data/folds.hpp"
#include "analysis/data/statistics.hpp"
#include "core/result.hpp"

namespace gyrotherm::model {

/// Accuracy of a learner without some of the thermometers.
struct SubsetAccuracy {
  /// Thermometers left out, in record order or in the order of elimination.
  std::vector<std::string> left_out;
  /// Thermometers kept, in the order of the record.
  std::vector<std::string> kept;
  data::Figures held_out;  ///< °/h, held-out folds
  /// Price of leaving them out: held-out STD without them minus held-out STD with all thermometers.
  double price_deg_per_h{};
  /// Standard error of the price, from the squared errors of the clusters.
  double price_error_deg_per_h{};
  std::optional<data::Figures> unseen;  ///< unseen records
};

/// The price of leaving out thermometers, singly and in combination.
struct Placement {
  SubsetAccuracy all;
  /// Results with one thermometer left out, the lowest price first.
  std::vector<SubsetAccuracy> alone;
  /// Stepwise elimination: each step leaves out one more thermometer, the one with the lowest price, until one is kept.
  std::vector<SubsetAccuracy> elimination;
  /// The pair and the triple that can be left out at the lowest price. No value if too few thermometers would remain,
  /// or, to limit the computing time, if there are more than twelve.
  std::optional<SubsetAccuracy> best_pair;
  std::optional<SubsetAccuracy> best_three;
  /// Number of elimination steps before the price first exceeds its standard error.
  int spared{};
  std::string folds;
};

/// Eliminates the thermometers of the records one by one, the one with the lowest price first. The learner is a
/// response surface of second order (selection.hpp) in the temperature of the first kept thermometer and its
/// differences with the others: absolute temperature and gradients. The folds choose λ for each set. The unit's own
/// values are not treated as thermometers. The criterion is the STD on held-out clusters; `unseen` records are only
/// reported. Fails with usage for fewer than two thermometers, records with different thermometers, no record or a STD
/// that is not finite, or like plan_folds(). Fails with interrupted on request.
[[nodiscard]] Result<Placement> study_placement(const std::vector<data::Clusters>& records,
                                                const std::vector<data::Clusters>& unseen,
                                                const data::FoldOptions& folds = {}, const ProgressSink& progress = {});

/// Returns the learner's inputs for these thermometers: the first one and its differences with the others.
[[nodiscard]] std::vector<data::Term> placement_terms(const std::vector<std::string>& thermometers);

}  // namespace gyrotherm::model
