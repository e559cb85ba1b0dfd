// SPDX-License-Identifier: Apache-2.0
/// Which thermometers matter: what it costs to leave each out.
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

/// What a learner does without some of the thermometers.
struct LeftOut {
  std::vector<std::string> left_out;    ///< in the order of the record, or of the elimination
  std::vector<std::string> kept;        ///< in the order of the record
  data::Figures held_out;               ///< °/h, each fold predicted without it
  double price_deg_per_h{};             ///< STD held out, less that with all thermometers
  double price_error_deg_per_h{};       ///< standard error of the price, from the squared errors cluster by cluster
  std::optional<data::Figures> unseen;  ///< of the unseen records
};

/// The price of each thermometer, alone and together with others.
struct Placement {
  LeftOut all;                        ///< nothing left out
  std::vector<LeftOut> alone;         ///< each thermometer left out alone, cheapest first
  std::vector<LeftOut> elimination;   ///< one more each time, the cheapest, until one is kept
  std::optional<LeftOut> best_pair;   ///< cheapest two and three of all; nothing where so many cannot be spared or more
  std::optional<LeftOut> best_three;  ///< than twelve thermometers make it dear
  int spared{};                       ///< steps of the elimination until the price first exceeds its error
  std::string folds;                  ///< as FoldPlan states them
};

/// Eliminates the thermometers of the records backward, the cheapest first. The learner is a response surface of second
/// order (selection.hpp) in the temperature of the first thermometer kept and its differences with the others,
/// so that absolute temperature and gradients are both there; λ is chosen by the folds for each set. The unit's own
/// values are no thermometers. STD on held-out clusters decides; `unseen` records are reported on and decide nothing.
/// Fails with usage: fewer than two thermometers, records that differ in them, no record, a STD that is not finite, or
/// as plan_folds does; with interrupted.
[[nodiscard]] Result<Placement> study_placement(const std::vector<data::Clusters>& records,
                                                const std::vector<data::Clusters>& unseen,
                                                const data::FoldOptions& folds = {}, const ProgressSink& progress = {});

/// The inputs of the learner that judges these thermometers: the first one, and its differences with the others.
[[nodiscard]] std::vector<data::Term> placement_terms(const std::vector<std::string>& thermometers);

}  // namespace gyrotherm::model
