// SPDX-License-Identifier: Apache-2.0
/// Export of a model and of the fusion of a fixture's axes as C99 for a navigation computer (no allocation, no static
/// state, only <math.h>), and of a model as LIBSVM's model file.
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

/// Writes the model as C. Names begin with NAME_; the header lists its contents, the order of the thermometers, the
/// training records and the accuracy. The program contains
///   NAME_predict  predicts like `predict`, in double and as with Outside::continued, from the thermometers' means
///                 over the last cluster length and over the one before it (for rates);
///   NAME_excess   returns the distance of the worst input from its trained range, as a fraction of the range;
///   NAME_push     predicts from one reading per second, in a struct of fixed size, like CompensationStream;
///   NAME_self_test  returns 0 if known predictions are reproduced;
/// for a model with a budget
///   NAME_uncertainty  U of a mean of compensated bias over the cluster length;
///   NAME_uncertainty_outside  U with an input outside the trained range;
/// and, given the noise of the residual bias,
///   NAME_track     estimates the residual bias at rest from one compensated rate per second, like RestTracker.
/// Return values report inputs that are outside the trained range or missing. Results agree with `predict` within
/// c_tolerance_deg_per_h(). Fails with usage if `name` is not a valid beginning of C identifiers, or if a constant or a
/// known answer is not finite.
[[nodiscard]] Result<CProgram> to_c(const Model& model, std::string_view name,
                                    const std::optional<tracking::BiasNoise>& noise = {});

/// Returns the permitted difference of the exported program from `predict`: 1e-12 of the target's STD, multiplied by
/// the sum of the function's weights in thousands if that is above 1, because the rounding of their sum then dominates.
[[nodiscard]] double c_tolerance_deg_per_h(const Model& model);

/// Writes the fusion of a fixture's axes as C, with its gains as constants. One second of N axes costs N²
/// multiplications. The program contains
///   NAME_fuse           the rate vector from one compensated reading per axis, and pᵀp of their parity vector;
///   NAME_suspect        the axis that explains a contradiction, like fusion::examine(), or −1;
///   NAME_fuse_without   the rate vector without one axis, like fusion::fuse_without_axis();
///   NAME_covariance     the covariance of the rate vector of all axes;
///   NAME_self_test      returns 0 if known results are reproduced.
/// Return values report a contradiction of the axes above the limit, or a reading that is not finite. Three axes have
/// no parity: NAME_fuse then finds no contradiction, and the parity functions are omitted. The limit applies to single
/// readings; fusion::ChangeDetector finds hops below the noise of a second. `weights`, if given, is the geometry that
/// determines the weights of the axes (fusion::weighted_gains). NAME_fuse_without is then unbiased and independent of
/// the omitted reading, but differs from the fusion of the remaining axes with these weights. Fails with usage if
/// `name` is not a valid beginning of C identifiers.
[[nodiscard]] Result<CProgram> fusion_to_c(const fusion::Geometry& geometry, std::string_view name,
                                           const fusion::TestOptions& options = {},
                                           const std::optional<fusion::Geometry>& weights = {});

/// Formats the model file of LIBSVM's svm-predict. Its predictions are f(z), in units of target_std from target_mean.
/// Fails with usage for a model other than an SVR.
[[nodiscard]] Result<std::string> to_libsvm(const Model& model);

/// Formats the data file of svm-predict: one row "target index:value …" per cluster that has every input, with inputs
/// and target scaled by the model's scaling. Fails like predict.
[[nodiscard]] Result<std::string> to_libsvm_data(const Model& model, const data::Clusters& clusters);

}  // namespace gyrotherm::model
