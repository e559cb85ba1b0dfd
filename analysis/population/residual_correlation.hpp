// SPDX-License-Identifier: Apache-2.0
/// Whether the unexplained parts of several axes correlate at all: the question before anything is learnt together.
/// Where they do not, an axis tells nothing of another that the thermometers have not told already.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "core/result.hpp"

namespace gyrotherm::population {

/// What models leave of the bias of several axes, side by side in time. Residuals are of clusters that no part of the
/// model has seen: those in-sample are made orthogonal to the inputs, and say less than they seem to.
struct AxisResiduals {
  std::vector<std::string> axes;
  Eigen::VectorXi places;              ///< of each row, in whole clusters since the run started, rising
  Eigen::MatrixXd residual_deg_per_h;  ///< places × axes; NaN where an axis has none
};

/// One axis' residual, a value per cluster of its own.
struct AxisResidual {
  std::string axis;
  const data::Clusters& clusters;
  Eigen::VectorXd residual_deg_per_h;
};

/// Puts the residuals of one run side by side, by the time since that run started. Fails with usage: fewer than two
/// axes, cluster lengths that differ, not one residual per cluster, clusters of more than one run, two axes of one
/// name.
[[nodiscard]] Result<AxisResiduals> side_by_side(std::span<const AxisResidual> axes);

/// The correlations of each pair of axes, axes × axes, and what chance would make of them.
struct ResidualCorrelation {
  std::vector<std::string> axes;
  Eigen::MatrixXd correlation;     ///< Pearson's r, over the places that both axes have
  Eigen::MatrixXd effective;       ///< as many independent pairs would tell as much of r; on the diagonal 0
  Eigen::MatrixXd probability;     ///< that |r| is so large by chance; on the diagonal 0
  double all_probability = 1;      ///< that all of them together are so large by chance
  double largest_probability = 1;  ///< that the most surprising of them is so by chance
};

/// Pearson's r of each pair, with the number of independent pairs that would scatter as much,
/// n_eff = n²/(n + 2 Σ_k n_k ρ_x(k) ρ_y(k)), n_k pairs k places apart, k up to n/4: the variance of r of two
/// independent series with the autocorrelations ρ_x and ρ_y (Bartlett, J. R. Stat. Soc. 98 (1935) 536; Bayley and
/// Hammersley, Suppl. J. R. Stat. Soc. 8 (1946) 184; tried by simulation by Pyper and Peterman, Can. J. Fish. Aquat.
/// Sci. 55 (1998) 2127). n_eff is at most n. A pair's probability is Student's of r√((n_eff − 2)/(1 − r²)) with n_eff −
/// 2 degrees of freedom.
///
/// Two joint tests look at all pairs: the sum of (n_eff − 3) atanh² r is χ² with a degree of freedom per pair if
/// nothing correlates (Steiger, Psychol. Bull. 87 (1980) 245: Bartlett's sphericity to first order, but each pair has
/// its own n_eff), which sees many small correlations; the smallest probability times the number of pairs (Bonferroni)
/// sees one large one. Residuals of a few dozen n_eff alarm falsely somewhat more often than asked, for their
/// autocorrelations are estimated too small: the tests say how often.
///
/// Pairs with an n_eff below 5, or of which one does not vary, say nothing: probability 1, and they are in no joint
/// test.
[[nodiscard]] ResidualCorrelation correlation_of(const AxisResiduals& residuals);

}  // namespace gyrotherm::population
