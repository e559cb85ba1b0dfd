#include "analysis/methods/centres.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/random.hpp"

namespace gyrotherm {
namespace {

/// Lloyd's rounds work on columns, so that distances to one centre are one pass.
Eigen::VectorXd squared_distances_to(const Eigen::MatrixXd& samples, const Eigen::RowVectorXd& centre) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(samples.rows());
  for (Eigen::Index j = 0; j < samples.cols(); ++j) sum.array() += (samples.col(j).array() - centre(j)).square();
  return sum;
}

/// Each next centre is a sample drawn with a probability in proportion to its squared distance from those before.
Result<SampleMatrix> spread_out(const Eigen::MatrixXd& samples, int count, std::mt19937_64& generator) {
  SampleMatrix centres(count, samples.cols());
  Eigen::VectorXd nearest = Eigen::VectorXd::Constant(samples.rows(), std::numeric_limits<double>::infinity());
  Eigen::Index chosen = index_below(samples.rows(), generator);
  for (int k = 0; k < count; ++k) {
    centres.row(k) = samples.row(chosen);
    nearest = nearest.cwiseMin(squared_distances_to(samples, centres.row(k)));
    if (k + 1 == count) break;
    double left = uniform(generator) * nearest.sum();
    if (!(nearest.maxCoeff() > 0)) {
      return failure(FaultKind::usage, "k-means",
                     fmt::format("{} centres of {} different samples cannot be told apart", count, k + 1));
    }
    for (chosen = 0; chosen + 1 < nearest.size() && (left -= nearest(chosen)) >= 0;) ++chosen;
    while (!(nearest(chosen) > 0)) chosen = chosen > 0 ? chosen - 1 : nearest.size() - 1;  // rounding at the end
  }
  return centres;
}

/// The nearest centre of each sample, the first of equals; their squared distances into `nearest`.
std::vector<Eigen::Index> assign(const Eigen::MatrixXd& samples, const SampleMatrix& centres,
                                 Eigen::VectorXd& nearest) {
  std::vector<Eigen::Index> owner(samples.rows(), 0);
  nearest = squared_distances_to(samples, centres.row(0));
  for (Eigen::Index k = 1; k < centres.rows(); ++k) {
    const Eigen::VectorXd distances = squared_distances_to(samples, centres.row(k));
    for (Eigen::Index i = 0; i < samples.rows(); ++i) {
      if (!(distances(i) < nearest(i))) continue;
      nearest(i) = distances(i);
      owner[i] = k;
    }
  }
  return owner;
}

/// A centre that owns nothing stays where it is.
void move_to_means(const SampleMatrix& samples, const std::vector<Eigen::Index>& owner, SampleMatrix& centres) {
  SampleMatrix sums = SampleMatrix::Zero(centres.rows(), centres.cols());
  Eigen::VectorXd counts = Eigen::VectorXd::Zero(centres.rows());
  for (Eigen::Index i = 0; i < samples.rows(); ++i) {
    sums.row(owner[i]) += samples.row(i);
    counts(owner[i]) += 1;
  }
  for (Eigen::Index k = 0; k < centres.rows(); ++k) {
    if (counts(k) > 0) centres.row(k) = sums.row(k) / counts(k);
  }
}

/// 0 … count − 1 in an order drawn at random.
std::vector<Eigen::Index> shuffled(Eigen::Index count, std::mt19937_64& generator) {
  std::vector<Eigen::Index> order(count);
  std::iota(order.begin(), order.end(), 0);
  for (Eigen::Index i = count - 1; i > 0; --i) std::swap(order[i], order[index_below(i + 1, generator)]);
  return order;
}

/// One sample is shown to the map.
void show(const Eigen::RowVectorXd& sample, double rate, double radius, Eigen::Index side, SampleMatrix& nodes) {
  Eigen::Index winner = 0;
  (nodes.rowwise() - sample).rowwise().squaredNorm().minCoeff(&winner);
  const Eigen::Index row = winner / side, column = winner % side;
  for (Eigen::Index j = 0; j < nodes.rows(); ++j) {
    const auto down = static_cast<double>(j / side - row), across = static_cast<double>(j % side - column);
    const double pull = rate * std::exp(-(down * down + across * across) / (2 * radius * radius));
    nodes.row(j) += pull * (sample - nodes.row(j));
  }
}

}  // namespace

Result<KMeans> k_means(const SampleMatrix& samples, int count, std::uint64_t seed) {
  assert(count > 0);
  constexpr int kMostRounds = 200;
  std::mt19937_64 generator(seed);
  const Eigen::MatrixXd columns = samples;
  if (samples.rows() < count) {
    return failure(FaultKind::usage, "k-means", fmt::format("{} centres of {} samples", count, samples.rows()));
  }
  auto centres = spread_out(columns, count, generator);
  if (!centres) return failure(centres.error());
  KMeans result{.centres = std::move(*centres), .costs = {}};
  Eigen::VectorXd nearest;
  std::vector<Eigen::Index> owner;
  for (int round = 0; round < kMostRounds; ++round) {
    auto now = assign(columns, result.centres, nearest);
    result.costs.push_back(nearest.sum());
    if (now == owner) break;
    owner = std::move(now);
    move_to_means(samples, owner, result.centres);
  }
  return result;
}

SampleMatrix self_organising_map(const SampleMatrix& samples, std::uint64_t seed, const MapOptions& options) {
  assert(samples.rows() > 0 && options.side > 0 && options.rounds > 0);
  std::mt19937_64 generator(seed);
  SampleMatrix nodes(options.side * options.side, samples.cols());
  for (Eigen::Index j = 0; j < nodes.rows(); ++j) nodes.row(j) = samples.row(index_below(samples.rows(), generator));
  const double last = std::max(1.0, static_cast<double>(options.rounds) * static_cast<double>(samples.rows()) - 1);
  double shown = 0;
  for (int round = 0; round < options.rounds; ++round) {
    for (const Eigen::Index i : shuffled(samples.rows(), generator)) {
      const double way = shown++ / last;
      show(samples.row(i), std::lerp(options.first_rate, options.last_rate, way),
           std::lerp(options.first_radius, options.last_radius, way), options.side, nodes);
    }
  }
  return nodes;
}

Eigen::VectorXd neighbour_distances(const SampleMatrix& centres) {
  assert(centres.rows() >= 3);
  Eigen::VectorXd means(centres.rows());
  for (Eigen::Index k = 0; k < centres.rows(); ++k) {
    Eigen::VectorXd distances = (centres.rowwise() - centres.row(k)).rowwise().norm();
    std::nth_element(distances.begin(), distances.begin() + 2, distances.end());  // the least is its own, 0
    means(k) = (std::max(distances(0), distances(1)) + distances(2)) / 2;
  }
  return means;
}

Eigen::MatrixXd gaussian_units(const SampleMatrix& samples, const SampleMatrix& centres,
                               const Eigen::VectorXd& widths) {
  const Eigen::MatrixXd columns = samples;
  Eigen::MatrixXd units(samples.rows(), centres.rows());
  for (Eigen::Index k = 0; k < centres.rows(); ++k) {
    const double scale = -0.5 / (widths(k) * widths(k));
    units.col(k) = (scale * squared_distances_to(columns, centres.row(k)).array()).exp();
  }
  return units;
}

}  // namespace gyrotherm
