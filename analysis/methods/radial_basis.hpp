// SPDX-License-Identifier: Apache-2.0
/// The radial basis networks: centres by k-means, and by a Kohonen map and orthogonal least squares.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "analysis/methods/method.hpp"
#include "analysis/svm/svr.hpp"
#include "core/result.hpp"

namespace gyrotherm::methods {

// Radial basis function network with k-means centres (Moody and Darken, Neural Comput. 1 (1989) 281): the network of
// Jin et al. 2008 and Yu et al. 2012 (refs. 8 and 10 of the paper) and what Ding et al., Sensors 14 (2014) 18711,
// compare theirs with.
//
// ŷ = w_0 + Σ_{k=1}^{K} w_k exp(−‖z − c_k‖²/(2 s_k²)); c_k by k-means++ and Lloyd, s_k a factor times the mean
// distance to the two nearest centres, w by ridge regression. Where a bias follows a plane, units as narrow as their
// distances only step from centre to centre; wide ones lie in each other and bend little.

/// Centres of clusters of samples.
struct KMeans {
  data::SampleMatrix centres;
  std::vector<double> costs;  ///< Σ of squared distances to the nearest centre, per round of Lloyd
};

/// Finds centres by k-means++ (Arthur and Vassilvitskii 2007), then Lloyd's rounds until no sample changes its centre,
/// or 200 rounds. Fails with usage if there are fewer than `count` different samples.
[[nodiscard]] Result<KMeans> k_means(const data::SampleMatrix& samples, int count, std::uint64_t seed);

/// The mean distance of each centre to its two nearest others; there are three at least.
[[nodiscard]] Eigen::VectorXd neighbour_distances(const data::SampleMatrix& centres);

/// What units at these centres with these widths make of samples: exp(−‖z_i − c_k‖²/(2 s_k²)), samples × centres.
[[nodiscard]] Eigen::MatrixXd gaussian_units(const data::SampleMatrix& samples, const data::SampleMatrix& centres,
                                             const Eigen::VectorXd& widths);

/// Chooses "centres", K of 10, 20, 40, 80, "width factor" of 1, 2, 4, 8, 16, and "lambda" of 10⁻¹⁰ … 10⁻² in steps of
/// two decades, by held-out error.
[[nodiscard]] ChooseFunction choose_radial_basis;

/// The effective parameters are the trace for these centres; that they were placed is not counted. Fails with usage if
/// there are fewer different samples than centres.
[[nodiscard]] FitFunction fit_radial_basis;

// The modified radial basis network of Ding et al., Sensors 14 (2014) 18711, ref. 12 of the paper: a self-organising
// map offers its nodes as centres, orthogonal least squares takes the few that explain the bias.
//
// All units share one width, a multiple of the mean distance between a node and its two nearest.

/// How a self-organising map is made.
struct MapOptions {
  int side = 10;                               ///< side × side nodes
  int rounds = 20;                             ///< each sample is shown so often, in a new order each round
  double first_rate = 0.5, last_rate = 0.01;   ///< α, falling linearly
  double first_radius = 5, last_radius = 0.5;  ///< ρ, in nodes, falling linearly
};

/// Makes Kohonen's self-organising map: for a sample z and its nearest node c each node j moves by
/// α exp(−d_jc²/(2ρ²)) (z − w_j), d_jc their distance on the map (Kohonen, Biol. Cybern. 43 (1982) 59). The result is
/// nodes × inputs; they start at samples drawn at random.
[[nodiscard]] data::SampleMatrix self_organising_map(const data::SampleMatrix& samples, std::uint64_t seed,
                                                     const MapOptions& options = {});

/// Candidates of orthogonal least squares (Chen, Cowan and Grant, IEEE Trans. Neural Networks 2 (1991) 302) in the
/// order in which they were taken, each the one that then explained most of the target's spread.
struct OrthogonalPath {
  std::vector<Eigen::Index> order;
  std::vector<double> ratios;  ///< error-reduction ratio g_k² q_kᵀq_k / yᵀy of each; they sum to at most 1
  Eigen::MatrixXd triangle;    ///< unit upper triangle A of the orthogonalisation: columns taken = QA
  Eigen::VectorXd orthogonal;  ///< g_k = q_kᵀy / q_kᵀq_k
  Eigen::RowVectorXd means;    ///< of the candidates
  double target_mean{};
};

/// Selects regressors by modified Gram–Schmidt on the centred candidates (columns) and target: takes the largest ratio
/// until 1 − Σ of the ratios is below `tolerance`, `most` are taken, or no candidate has a part of its own left.
[[nodiscard]] OrthogonalPath orthogonal_least_squares(const Eigen::Ref<const Eigen::MatrixXd>& candidates,
                                                      const Eigen::Ref<const Eigen::VectorXd>& y, double tolerance,
                                                      Eigen::Index most);

/// How many of the path's candidates are taken until 1 − Σ is below the tolerance; all if it never is.
[[nodiscard]] Eigen::Index taken_at(const OrthogonalPath& path, double tolerance);

/// The weights of the first `count` candidates taken, in the path's order, by back substitution.
[[nodiscard]] Eigen::VectorXd weights_of(const OrthogonalPath& path, Eigen::Index count);
/// The constant that belongs to these weights.
[[nodiscard]] double offset_of(const OrthogonalPath& path, const Eigen::VectorXd& weights);

/// Chooses "width factor" of 1, 2, 4, 8, 16, and "tolerance", the part of the spread that may stay unexplained, of
/// 10⁻¹ … 10⁻⁴ in quarter decades, by held-out error.
[[nodiscard]] ChooseFunction choose_kohonen;

/// Fits with a map of 10 × 10 nodes. The effective parameters are the units taken and the constant; that they were
/// picked is not counted. Fails with usage if the samples do not differ.
[[nodiscard]] FitFunction fit_kohonen;

}  // namespace gyrotherm::methods
