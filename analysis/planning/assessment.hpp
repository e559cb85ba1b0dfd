// SPDX-License-Identifier: Apache-2.0
/// The uncertainty that a model of a unit's record has on a mission, now and after each block that a run could add.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "analysis/planning/program_path.hpp"
#include "core/result.hpp"

namespace gyrotherm::planning {

struct Assessment {
  /// Expanded uncertainty of a mean of the compensated bias over 1 h on the mission, °/h; infinite if no model can be
  /// fitted yet.
  double u_now_deg_per_h{};
  /// Uncertainty expected after each block, in the order of the blocks; infinite if no model can be fitted yet.
  std::vector<double> u_after_deg_per_h{};
  /// Share of U that each block removes, for the choice of a block: as above, but with a model form of three times the
  /// turn-on repeatability, and without other rows. It follows from the temperatures, so the noise of the record has no
  /// influence on it. 0 if no model can be fitted yet.
  std::vector<double> gains{};
  /// The model was trained with the type prior.
  bool uses_prior{};
};

struct AssessmentOptions {
  /// Text of a type prior (population/type_prior.hpp); empty: none.
  std::string prior{};
};

/// Fits the recommended model to the recorded clusters, and with a type prior also the model of train_with_prior(), and
/// computes the expanded uncertainty on the mission of the better one. Held-out residuals of the unit's own record
/// enter both models, so a prior of another type has a large uncertainty and is not used. The temperatures of the
/// mission and of the blocks are predicted by fit_response().
///
/// After a block, the function has the covariance (Σ⁻¹ + ΦᵀΦ/s²)⁻¹, with Φ the features of the block and s² the
/// residual variance, enlarged for correlation (Rasmussen and Williams, Gaussian Processes for Machine Learning (2006),
/// eq. 2.8). Half of the variance of the model form is expected to decrease with the mean of φᵀΣφ over the mission,
/// since an error of the form itself stays. The trained range grows by that of the block, and each new power-on lowers
/// the turn-on row.
///
/// The same inputs give the same numbers on every machine. Fails with usage if the record lacks an input or the prior
/// cannot be read, or with interrupted.
[[nodiscard]] Result<Assessment> assess(const data::RecordedRun& recorded, const ProgramPath& mission,
                                        std::span<const ProgramPath> blocks, const AssessmentOptions& options = {},
                                        const ProgressSink& progress = {});

}  // namespace gyrotherm::planning
