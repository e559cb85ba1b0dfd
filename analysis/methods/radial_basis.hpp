// SPDX-License-Identifier: Apache-2.0
/// Radial basis networks: one takes its centres from k-means, the other from a Kohonen map by orthogonal least squares.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "analysis/methods/method.hpp"
#include "analysis/svm/svr.hpp"
#include "core/result.hpp"

namespace gyrotherm::methods {

// Radial basis function network with k-means centres (Moody and Darken, Neural Comput. 1 (1989) 281). It is the network
// of Jin et al. 2008 and Yu et al. 2012 (refs. 8 and 10 of the paper) and the reference in the comparison of Ding et
// al., Sensors 14 (2014) 18711.
//
// ŷ = w_0 + Σ_{k=1}^{K} w_k exp(−‖z − c_k‖²/(2 s_k²)). c_k is found by k-means++ and Lloyd's algorithm, s_k is a factor
// times the mean distance to the two nearest centres, and w is found by ridge regression. If the bias follows a plane,
// units as narrow as the distances between centres give a staircase; wide overlapping units give a smoother function.

/// Centres of clusters of samples.
struct KMeans {
  data::SampleMatrix centres;
  /// Sum of squared distances to the nearest centre after each round of Lloyd's algorithm.
  std::vector<double> costs;
};

/// Finds centres by k-means++ (Arthur and Vassilvitskii 2007) and Lloyd's algorithm. Ends when no sample changes its
/// centre, or after 200 rounds. Fails with usage if there are fewer than `count` different samples.
[[nodiscard]] Result<KMeans> k_means(const data::SampleMatrix& samples, int count, std::uint64_t seed);

/// Computes the mean distance of each centre to the two nearest others. There must be at least three centres.
[[nodiscard]] Eigen::VectorXd neighbour_distances(const data::SampleMatrix& centres);

/// Computes the outputs of units with these centres and widths: exp(−‖z_i − c_k‖²/(2 s_k²)), samples × centres.
[[nodiscard]] Eigen::MatrixXd gaussian_units(const data::SampleMatrix& samples, const data::SampleMatrix& centres,
                                             const Eigen::VectorXd& widths);

/// Chooses "centres", K = 10, 20, 40 or 80, "width factor" = 1, 2, 4, 8 or 16, and "lambda" = 10⁻¹⁰ … 10⁻² in steps of
/// two decades, by held-out error.
[[nodiscard]] ChooseFunction choose_radial_basis;

/// Fits the network. The number of effective parameters is the trace for the given centres; the choice of the centres
/// is not counted. Fails with usage if there are fewer different samples than centres.
[[nodiscard]] FitFunction fit_radial_basis;

// Modified radial basis network of Ding et al., Sensors 14 (2014) 18711, ref. 12 of the paper. The nodes of a
// self-organising map are candidate centres; orthogonal least squares selects the few that explain the bias.
//
// All units share one width, a multiple of the mean distance between a node and its two nearest nodes.

/// Options of a self-organising map.
struct MapOptions {
  int side = 10;  ///< side × side nodes
  /// Number of presentations of each sample, in a new order each round.
  int rounds = 20;
  double first_rate = 0.5, last_rate = 0.01;   ///< α, decreasing linearly
  double first_radius = 5, last_radius = 0.5;  ///< ρ in nodes, decreasing linearly
};

/// Computes Kohonen's self-organising map. For a sample z and its nearest node c each node j moves by α
/// exp(−d_jc²/(2ρ²)) (z − w_j), where d_jc is their distance on the map (Kohonen, Biol. Cybern. 43 (1982) 59). Nodes
/// start at random samples. Returns nodes × inputs.
[[nodiscard]] data::SampleMatrix self_organising_map(const data::SampleMatrix& samples, std::uint64_t seed,
                                                     const MapOptions& options = {});

/// Candidates selected by orthogonal least squares (Chen, Cowan and Grant, IEEE Trans. Neural Networks 2 (1991) 302),
/// in order of selection. Each candidate was the one that explained the largest part of the remaining spread of the
/// target.
struct OrthogonalPath {
  std::vector<Eigen::Index> order;
  /// Error-reduction ratio g_k² q_kᵀq_k / yᵀy of each selected candidate. The sum of all ratios is at most 1.
  std::vector<double> ratios;
  /// Unit upper triangle A of the orthogonalisation: selected columns = QA.
  Eigen::MatrixXd triangle;
  Eigen::VectorXd orthogonal;  ///< g_k = q_kᵀy / q_kᵀq_k
  Eigen::RowVectorXd means;    ///< means of the candidates
  double target_mean{};
};

/// Selects regressors by modified Gram–Schmidt on the centred candidates (columns) and target. Selects the candidate
/// with the largest ratio until 1 − Σ ratios is below `tolerance`, `most` candidates are selected, or every remaining
/// candidate depends on the selected ones.
[[nodiscard]] OrthogonalPath orthogonal_least_squares(const Eigen::Ref<const Eigen::MatrixXd>& candidates,
                                                      const Eigen::Ref<const Eigen::VectorXd>& y, double tolerance,
                                                      Eigen::Index most);

/// Returns the number of candidates after which 1 − Σ ratios is below the tolerance, or the number of all candidates of
/// the path.
[[nodiscard]] Eigen::Index count_selected(const OrthogonalPath& path, double tolerance);

/// Computes the weights of the first `count` candidates of the path by back substitution.
[[nodiscard]] Eigen::VectorXd path_weights(const OrthogonalPath& path, Eigen::Index count);
/// Returns the constant for these weights.
[[nodiscard]] double path_offset(const OrthogonalPath& path, const Eigen::VectorXd& weights);

/// Chooses "width factor" = 1, 2, 4, 8 or 16, and "tolerance", the fraction of the spread that may remain unexplained,
/// 10⁻¹ … 10⁻⁴ in quarter decades, by held-out error.
[[nodiscard]] ChooseFunction choose_kohonen;

/// Fits with a map of 10 × 10 nodes. The number of effective parameters is the number of selected units plus 1 for the
/// constant; the selection itself is not counted. Fails with usage if all samples are equal.
[[nodiscard]] FitFunction fit_kohonen;

}  // namespace gyrotherm::methods
