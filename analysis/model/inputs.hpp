// SPDX-License-Identifier: Apache-2.0
/// What a model takes in, from the words the user said to the terms of one training set.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "analysis/data/dataset.hpp"
#include "analysis/data/features.hpp"
#include "analysis/model/selection.hpp"
#include "core/result.hpp"

namespace gyrotherm::model {

/// Terms that are known beforehand, and terms among which to select on each training set.
struct InputPlan {
  std::vector<data::Term> fixed;       ///< always taken; after the selected ones
  std::vector<data::Term> candidates;  ///< empty: nothing is selected
  SelectionRule rule;                  ///< of the candidates
};

/// Reads what the user asks for: words and terms, joined by commas or '+'. A word stands for several terms:
///   gradients      every difference of two gradient thermometers (28 of eight)
///   temperatures   the gradient thermometers themselves
///   rates          their causal rates
///   seven-point    the differences of the first gradient thermometer with the others
///   three-point    the three differences of cathode, anode and shell
///   three-point-t  the same, and the temperature of the first gradient thermometer
///   polynomial     T, T², T³, dT/dt and T·dT/dt, T the temperature of the first gradient thermometer
///   temperature-gradient-rate  T, seven-point and dT/dt; of a single thermometer without differences
///   physics        T, T², seven-point, T times seven-point, and dT/dt; likewise
///   thermal-history  the temperatures, their lags with time constants of 600 s and 2400 s, and T times all of these
///   multi-point    gradients, selected by correlation (paper §4.3)
///   multi-point-t  the same, and the temperature of the first gradient thermometer (errata 3.2)
/// With a `rule` what the words stand for is selected from by that rule, and terms given one by one are always taken;
/// without one only multi-point selects. Fails with usage: a record that lacks the thermometers, an unknown or repeated
/// term, a rule without a word.
[[nodiscard]] Result<InputPlan> plan_inputs(const std::string& inputs, const data::Dataset& dataset,
                                            const std::optional<SelectionRule>& rule = {});

/// The numbers of the clusters that have a value of every term that may be taken, rising; where rates may be, the first
/// cluster of a run has none. Fails with usage if a thermometer is lacking.
[[nodiscard]] Result<std::vector<Eigen::Index>> rows_with_inputs(const InputPlan& plan, const data::Clusters& clusters);

/// What choose_inputs took.
struct ChosenInputs {
  std::vector<data::Term> terms;
  Selection selection;  ///< empty if nothing was selected
};

/// Chooses the terms for one training set. Fails with usage if none is left or as select_inputs does.
[[nodiscard]] Result<ChosenInputs> choose_inputs(const InputPlan& plan, const data::TrainingSet& training_set);

}  // namespace gyrotherm::model
