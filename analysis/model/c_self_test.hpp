/// Known answers for an exported model: a few temperatures inside its trained range and beyond, and what it predicts.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "analysis/model/model.hpp"

namespace gyrotherm {

struct KnownAnswers {
  SampleMatrix mean_c, before_c;   ///< means of the last cluster length and of the one before; columns are thermometers
  Eigen::VectorXd bias_deg_per_h;  ///< predicted, inputs outside the trained range clamped
  std::vector<bool> outside;       ///< an input was
};

/// Names of the thermometers that a model needs, sorted.
[[nodiscard]] std::vector<std::string> thermometers_of(const Model& model);

/// Six answers near what the model was trained on and two farther out; the same each time.
[[nodiscard]] KnownAnswers known_answers(const Model& model);

}  // namespace gyrotherm
