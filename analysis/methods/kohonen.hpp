// SPDX-License-Identifier: Apache-2.0
/// The modified radial basis network of Ding et al., Sensors 14 (2014) 18711, ref. 12 of the paper: a self-organising
/// map offers its nodes as centres, orthogonal least squares takes the few that explain the bias.
///
/// All units share one width, a multiple of the mean distance between a node and its two nearest.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "analysis/methods/method.hpp"

namespace gyrotherm::methods {

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
[[nodiscard]] Result<Choice> choose_kohonen(std::span<const Fold> folds, const MethodOptions& options,
                                            const ProgressSink& progress);

/// Fits with a map of 10 × 10 nodes. The effective parameters are the units taken and the constant; that they were
/// picked is not counted. Fails with usage if the samples do not differ.
[[nodiscard]] Result<Fit> fit_kohonen(const FitInput& set, const HyperParameters& parameters,
                                      const MethodOptions& options);

}  // namespace gyrotherm::methods
