// SPDX-License-Identifier: Apache-2.0
/// Test of the correlation between the residuals of several axes, to be made before the axes are learnt together.
/// Without correlation, an axis provides no information about another axis that the thermometers do not provide.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "core/result.hpp"

namespace gyrotherm::population {

/// Residual bias of several axes on a common time grid. The residuals must be held-out: in-sample residuals are
/// orthogonal to the inputs and would show too little correlation.
struct AxisResiduals {
  std::vector<std::string> axes;
  /// Position of each row in the run, in whole clusters since its start, ascending.
  Eigen::VectorXi positions;
  /// Positions × axes; NaN for a missing value.
  Eigen::MatrixXd residual_deg_per_h;
};

/// Residual of one axis, one value for each of its clusters.
struct AxisResidual {
  std::string axis;
  const data::Clusters& clusters;
  Eigen::VectorXd residual_deg_per_h;
};

/// Aligns the residuals of one run by the time since its start. Fails with usage if there are fewer than two axes, if
/// cluster lengths differ, if an axis has not one residual per cluster or has clusters of several runs, or if two axes
/// have the same name.
[[nodiscard]] Result<AxisResiduals> align_residuals(std::span<const AxisResidual> axes);

/// The correlation of each pair of axes, axes × axes, and the probability that it occurs by chance.
struct ResidualCorrelation {
  std::vector<std::string> axes;
  /// Pearson's r over the positions at which both axes have a value.
  Eigen::MatrixXd correlation;
  /// Number of independent pairs of values that would determine r equally well; 0 on the diagonal.
  Eigen::MatrixXd effective;
  /// Probability that |r| is at least this large by chance; 0 on the diagonal.
  Eigen::MatrixXd probability;
  /// Probability that the correlations of all pairs together are at least this large by chance.
  double all_probability = 1;
  /// Probability that the greatest correlation is at least this large by chance.
  double largest_probability = 1;
};

/// Computes Pearson's r of each pair of axes, and the number of independent pairs of values that would give r the same
/// scatter, n_eff = n²/(n + 2 Σ_k n_k ρ_x(k) ρ_y(k)), with n_k the number of value pairs k positions apart, k up to
/// n/4. This is the variance of r for two independent series with the autocorrelations ρ_x and ρ_y (Bartlett, J. R.
/// Stat. Soc. 98 (1935) 536; Bayley and Hammersley, Suppl. J. R. Stat. Soc. 8 (1946) 184; verified by simulation by
/// Pyper and Peterman, Can. J. Fish. Aquat. Sci. 55 (1998) 2127). n_eff is at most n. A pair's probability follows from
/// Student's t for r√((n_eff − 2)/(1 − r²)) with n_eff − 2 degrees of freedom.
///
/// Two joint tests cover all pairs. Without correlation the sum of (n_eff − 3) atanh² r is χ² with one degree of
/// freedom per pair (Steiger, Psychol. Bull. 87 (1980) 245: Bartlett's sphericity test to first order, with a separate
/// n_eff for each pair); this test detects many small correlations. The smallest probability times the number of pairs
/// (Bonferroni) detects a single large one. With an n_eff of a few dozen, false alarms are somewhat more frequent than
/// nominal, because the autocorrelations are underestimated; the unit tests measure their rate.
///
/// Pairs with an n_eff below 5, or with an axis that does not vary, permit no conclusion: their probability is 1, and
/// they are excluded from the joint tests.
[[nodiscard]] ResidualCorrelation correlate_residuals(const AxisResiduals& residuals);

}  // namespace gyrotherm::population
