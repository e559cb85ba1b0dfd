// SPDX-License-Identifier: Apache-2.0
/// A model, and the fusion of a fixture's axes, as others can run them: as C99 for a navigation computer (no
/// allocation, no state of its own, nothing but <math.h>), and a model as LIBSVM's model file.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "analysis/fusion/fault_test.hpp"
#include "analysis/fusion/geometry.hpp"
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

/// Writes the fusion of a fixture's axes as C, its gains as constants. A second of N axes takes N² multiplications. The
/// program has
///   NAME_fuse           the rate vector of one compensated reading per axis, and pᵀp of their parity vector;
///   NAME_suspect        the axis that explains a contradiction, as fusion::examine() finds it, or −1;
///   NAME_fuse_without   the rate vector without one axis, as fusion::fused_without() has it;
///   NAME_covariance     that of the rate vector of all axes;
///   NAME_self_test      0 if what this program computed for a few readings comes out again.
/// What a call returns says whether the axes contradict each other by more than the limit, or a reading is not finite.
/// With three axes there is no parity: NAME_fuse finds no contradiction, and the rest is not there. The limit is for
/// one reading by itself; a hop that is smaller than the noise of a second is for fusion::ChangeDetector to find. Fails
/// with usage if `name` cannot begin the names of a C program.
/// `weights`, where given: what the axes are weighed by (fusion::gains_weighed_by).
[[nodiscard]] Result<CProgram> fusion_to_c(const fusion::Geometry& geometry, std::string_view name,
                                           const fusion::TestOptions& options = {},
                                           const std::optional<fusion::Geometry>& weights = {});

/// The model file of LIBSVM's svm-predict. Its predictions are f(z), in units of target_std from target_mean. Fails
/// with usage for a model that is not an SVR.
[[nodiscard]] Result<std::string> to_libsvm(const Model& model);

/// The data file of svm-predict: one row "target index:value …" per cluster that has every input, inputs and target
/// scaled as the model scales them. Fails like predict.
[[nodiscard]] Result<std::string> to_libsvm_data(const Model& model, const data::Clusters& clusters);

}  // namespace gyrotherm::model
