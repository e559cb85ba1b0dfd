/// What a model takes in, from the word the user said to the terms of one training set.
#pragma once

#include <string>
#include <vector>

#include "analysis/clusters.hpp"
#include "analysis/correlation.hpp"
#include "analysis/dataset.hpp"
#include "analysis/features.hpp"
#include "core/result.hpp"

namespace gyrotherm {

/// Terms that are known beforehand, or that are selected by correlation on each training set.
struct InputPlan {
  std::vector<Term> fixed;              ///< always taken; after the selected ones
  std::vector<std::string> candidates;  ///< thermometers among whose gradients to select; empty: nothing is selected
  double threshold = 0.90;              ///< of |r|
};

/// multi-point: gradients by correlation (paper §4.3); multi-point-t: the same and the temperature of the first
/// gradient thermometer (errata 3.2); three-point: the three differences of cathode, anode and shell; seven-point: the
/// differences of the first gradient thermometer with the others; else terms, comma separated. Fails with usage: a
/// record that lacks the thermometers, an unknown or repeated term.
[[nodiscard]] Result<InputPlan> plan_inputs(const std::string& inputs, const Dataset& dataset, double threshold);

struct ChosenInputs {
  std::vector<Term> terms;
  Selection selection;  ///< empty if nothing was selected
};

/// The terms for one training set. A selection of fewer than two independent gradients (one, of two thermometers) falls
/// back to the differences with the first thermometer.
[[nodiscard]] ChosenInputs choose_inputs(const InputPlan& plan, const Clusters& training);

}  // namespace gyrotherm
