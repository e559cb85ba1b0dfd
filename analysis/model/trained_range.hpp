/// The range of inputs in which a model was trained, and what is done with inputs beyond it.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/model/model.hpp"
#include "core/result.hpp"

namespace gyrotherm {

/// clamp, the default: an input beyond the range of its term is moved to the nearer end, so that the compensation goes
/// on from its last trained value, bounded and without a step. refuse: nothing is predicted. extrapolate: the function
/// is used as it is; Gaussians then die away towards the training mean within a few widths, straight lines run on.
enum class Outside { clamp, refuse, extrapolate };

[[nodiscard]] const char* name(Outside outside);
/// Fails with usage, naming the three.
[[nodiscard]] Result<Outside> parse_outside(std::string_view text);

/// Inputs of a model after the policy.
struct RangedInputs {
  SampleMatrix inputs;             ///< unscaled; with refuse, NaN in every row that is outside
  std::vector<Eigen::Index> rows;  ///< those with an input outside, in order
  Eigen::Index worst_term = -1;    ///< the term that is farthest outside, as a part of its own range; −1: none is
  double worst_excess{};           ///< how far: 0.1 is a tenth of the term's trained range
};

/// `inputs` is rows × terms of the model, unscaled. A row that holds a NaN is not outside and stays NaN.
[[nodiscard]] RangedInputs within_range(const Model& model, SampleMatrix inputs, Outside outside);

/// Predicted bias of each row under the policy, °/h; NaN where it is refused or an input is not finite.
[[nodiscard]] Eigen::VectorXd predict(const Model& model, const SampleMatrix& inputs, Outside outside);

}  // namespace gyrotherm
