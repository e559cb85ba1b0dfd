// SPDX-License-Identifier: Apache-2.0
/// The inputs of a model, from the keywords of the user to the terms of one training set.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "analysis/data/dataset.hpp"
#include "analysis/data/features.hpp"
#include "analysis/model/power_on_constants.hpp"
#include "analysis/model/selection.hpp"
#include "core/result.hpp"

namespace gyrotherm::model {

/// Terms that are fixed, and candidate terms to select from on each training set.
struct InputPlan {
  /// Terms that are always used, after the selected ones.
  std::vector<data::Term> fixed;
  /// Terms to select from; empty if there is no selection.
  std::vector<data::Term> candidates;
  SelectionRule rule;
  /// Constants of the power-ons, which are subtracted from the bias of each training set before anything is learnt from
  /// it; without terms none are subtracted.
  PowerOnRule power_ons = {};
};

/// Parses requested inputs: keywords and terms, joined by commas or '+'. A keyword denotes several terms:
///   gradients      every difference of two gradient thermometers (28 for eight)
///   temperatures   the gradient thermometers themselves
///   rates          their causal rates
///   seven-point    the differences of the first gradient thermometer with the others
///   three-point    the three differences of cathode, anode and shell
///   three-point-t  three-point, and the temperature of the first gradient thermometer
///   polynomial     T, T², T³, dT/dt and T·dT/dt, T the temperature of the first gradient thermometer
///   temperature-gradient-rate  T, seven-point and dT/dt; only T and dT/dt with a single thermometer
///   physics        T, T², seven-point, T times seven-point, and dT/dt; only T, T² and dT/dt with a single thermometer
///   thermal-history  the temperatures, their lags with time constants of 600 s and 2400 s, and T times all of these
///   lag-bank       the temperatures, and their lags with seven time constants from 300 s to 19200 s
///   multi-point    gradients, selected by correlation (paper §4.3)
///   multi-point-t  multi-point, and the temperature of the first gradient thermometer (errata 3.2)
/// With a `rule`, the rule selects from the terms of all keywords, and individually requested terms are always used.
/// Without a rule, only the multi-point keywords select. Fails with usage: a record without the thermometers, an
/// unknown or repeated term, a rule without a keyword.
[[nodiscard]] Result<InputPlan> plan_inputs(const std::string& inputs, const data::Dataset& dataset,
                                            const std::optional<SelectionRule>& rule = {});

/// Returns the indices of the clusters that have a value for every fixed and candidate term, in ascending order. If
/// rates are among the terms, the first cluster of a run is omitted, because it has no rate. Fails with usage if a
/// thermometer is missing.
[[nodiscard]] Result<std::vector<Eigen::Index>> rows_with_inputs(const InputPlan& plan, const data::Clusters& clusters);

/// Result of choose_inputs().
struct ChosenInputs {
  std::vector<data::Term> terms;
  /// Empty if there are no candidates.
  Selection selection;
};

/// Chooses the terms for one training set. Fails with usage if no term is left, or like select_inputs().
[[nodiscard]] Result<ChosenInputs> choose_inputs(const InputPlan& plan, const data::TrainingSet& training_set);

}  // namespace gyrotherm::model
