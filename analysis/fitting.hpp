/// One training set made ready, and one function fitted to it: what the final model and every fold have in common.
#pragma once

#include <Eigen/Core>
#include <variant>
#include <vector>

#include "analysis/clusters.hpp"
#include "analysis/inputs.hpp"
#include "analysis/model.hpp"
#include "analysis/svr.hpp"
#include "core/result.hpp"

namespace gyrotherm {

/// Selection, scaling and target units, all learnt from the training clusters alone.
struct Preparation {
  std::vector<Term> terms;
  Selection selection;
  Scaling scaling;
  double target_mean_deg_per_h{};
  double target_std_deg_per_h{};
};

/// Fails with usage if an input or the bias does not vary over the training clusters.
[[nodiscard]] Result<Preparation> prepare(const InputPlan& plan, const Clusters& training);

/// Scaled inputs of any clusters.
[[nodiscard]] Result<SampleMatrix> scaled_inputs(const Preparation& preparation, const Clusters& clusters);
/// Bias in units of the target's training STD from its training mean.
[[nodiscard]] Eigen::VectorXd scaled_target(const Preparation& preparation, const Clusters& clusters);

/// Fails like solve_svr.
[[nodiscard]] Result<SvrModel> fit_svr(const SampleMatrix& x, const Eigen::VectorXd& y, const SvrParameters& parameters,
                                       const SvrOptions& options);

/// Least squares with a constant. `target_std_deg_per_h` turns the residual into °/h. Scaled inputs that depend on the
/// others to one part in 10⁹ count as dependent. Fails with usage if there are not more clusters than coefficients.
[[nodiscard]] Result<LinearModel> fit_linear(const SampleMatrix& x, const Eigen::VectorXd& y,
                                             double target_std_deg_per_h);

/// The model that preparation and function make, without what is known of its making.
[[nodiscard]] Model assemble(const Preparation& preparation, std::variant<SvrModel, LinearModel> function);

}  // namespace gyrotherm
