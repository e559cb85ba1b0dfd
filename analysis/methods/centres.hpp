/// Centres of Gaussian units, found from the inputs alone, and their widths.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "analysis/svm/svr.hpp"
#include "core/result.hpp"

namespace gyrotherm {

struct KMeans {
  SampleMatrix centres;
  std::vector<double> costs;  ///< Σ of squared distances to the nearest centre, per round of Lloyd
};

/// k-means++ (Arthur and Vassilvitskii 2007), then Lloyd until no sample changes its centre, or 200 rounds. Fails with
/// usage if there are fewer than `count` different samples.
[[nodiscard]] Result<KMeans> k_means(const SampleMatrix& samples, int count, std::uint64_t seed);

struct MapOptions {
  int side = 10;                               ///< side × side nodes
  int rounds = 20;                             ///< each sample is shown so often, in a new order each round
  double first_rate = 0.5, last_rate = 0.01;   ///< α, falling linearly
  double first_radius = 5, last_radius = 0.5;  ///< ρ, in nodes, falling linearly
};

/// Kohonen's self-organising map: for a sample z and its nearest node c each node j moves by
/// α exp(−d_jc²/(2ρ²)) (z − w_j), d_jc their distance on the map (Kohonen, Biol. Cybern. 43 (1982) 59). Nodes × inputs;
/// they start at samples drawn at random.
[[nodiscard]] SampleMatrix self_organising_map(const SampleMatrix& samples, std::uint64_t seed,
                                               const MapOptions& options = {});

/// Mean distance of each centre to its two nearest others; there are three at least.
[[nodiscard]] Eigen::VectorXd neighbour_distances(const SampleMatrix& centres);

/// exp(−‖z_i − c_k‖²/(2 s_k²)), samples × centres.
[[nodiscard]] Eigen::MatrixXd gaussian_units(const SampleMatrix& samples, const SampleMatrix& centres,
                                             const Eigen::VectorXd& widths);

}  // namespace gyrotherm
