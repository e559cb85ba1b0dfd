// SPDX-License-Identifier: Apache-2.0
/// Fusion as C: the gains of a fixture as constants, for a navigation computer.
#pragma once

#include <optional>
#include <string_view>

#include "analysis/fusion/fault_test.hpp"
#include "analysis/fusion/geometry.hpp"
#include "analysis/model/c_text.hpp"
#include "core/result.hpp"

namespace gyrotherm::model {

/// Writes NAME.h and NAME.c of C99, without allocation or state, and nothing but <math.h>. A second of N axes takes N²
/// multiplications. The program has
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

}  // namespace gyrotherm::model
