// SPDX-License-Identifier: Apache-2.0
/// A model as others can run it: as C99 for a navigation computer (no allocation, no state of its own, nothing but
/// <math.h>), and as LIBSVM's model file.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "analysis/model/c_text.hpp"
#include "analysis/model/model.hpp"
#include "core/result.hpp"

namespace gyrotherm::model {

/// Writes the model as C. Names begin with NAME_; the header says what is there, which thermometers in which order,
/// what the model was trained on and how good it was. The program has
///   NAME_predict  from the thermometers' means of the last cluster length and those of the one before (for rates), as
///                 `predict` does it, in double, with inputs outside the trained range as in Outside::continued;
///   NAME_excess   how far the worst input is outside, as a part of its range;
///   NAME_push     the same from a reading a second, in a struct of fixed size, as CompensationStream does it;
///   NAME_self_test  0 if the values that this program predicted for a few means come out again;
/// where the model has a budget,
///   NAME_uncertainty  U of a mean of compensated bias over the cluster length;
///   NAME_uncertainty_outside  the same with an input outside;
/// and, where the noise of what it leaves is given,
///   NAME_track     the bias that is left, from a compensated rate a second while at rest, as RestTracker does it.
/// Each tells in its return value what was outside or missing. They agree with `predict` to c_tolerance_deg_per_h.
/// Fails with usage if `name` cannot begin the names of a C program, or if a constant or a known answer is not finite.
[[nodiscard]] Result<CProgram> to_c(const Model& model, std::string_view name,
                                    const std::optional<tracking::BiasNoise>& noise = {});

/// How far the exported program may lie from `predict`: 1e-12 of the target's STD; where the weights of the function
/// add up to more than 1000, so much more of it, since the rounding of their sum then shows.
[[nodiscard]] double c_tolerance_deg_per_h(const Model& model);

/// The model file of LIBSVM's svm-predict. Its predictions are f(z), in units of target_std from target_mean. Fails
/// with usage for a model that is not an SVR.
[[nodiscard]] Result<std::string> to_libsvm(const Model& model);

/// The data file of svm-predict: one row "target index:value …" per cluster that has every input, inputs and target
/// scaled as the model scales them. Fails like predict.
[[nodiscard]] Result<std::string> to_libsvm_data(const Model& model, const data::Clusters& clusters);

}  // namespace gyrotherm::model
