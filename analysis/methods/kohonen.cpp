// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numeric>
#include <random>
#include <utility>

#include "analysis/methods/held_out.hpp"
#include "analysis/methods/radial_basis.hpp"
#include "core/random.hpp"

namespace gyrotherm::methods {
namespace {

/// Returns 0 … count − 1 in random order.
std::vector<Eigen::Index> random_order(Eigen::Index count, std::mt19937_64& generator) {
  std::vector<Eigen::Index> order(count);
  std::iota(order.begin(), order.end(), 0);
  for (Eigen::Index i = count - 1; i > 0; --i) std::swap(order[i], order[draw_index(i + 1, generator)]);
  return order;
}

/// Moves the nodes of the map towards one sample.
void present_sample(const Eigen::RowVectorXd& sample, double rate, double radius, Eigen::Index side,
                    data::SampleMatrix& nodes) {
  Eigen::Index winner = 0;
  (nodes.rowwise() - sample).rowwise().squaredNorm().minCoeff(&winner);
  const Eigen::Index row = winner / side, column = winner % side;
  for (Eigen::Index j = 0; j < nodes.rows(); ++j) {
    const auto down = static_cast<double>(j / side - row), across = static_cast<double>(j % side - column);
    const double pull = rate * std::exp(-(down * down + across * across) / (2 * radius * radius));
    nodes.row(j) += pull * (sample - nodes.row(j));
  }
}

constexpr std::array kWidthFactors = {1.0, 2.0, 4.0, 8.0, 16.0};
constexpr int kToleranceSteps = 12;  // quarter decades from 10⁻¹ to 10⁻⁴

double tolerance_at(Eigen::Index step) { return std::pow(10.0, -1 - 0.25 * static_cast<double>(step)); }

/// Nodes of a map, and the mean distance of each node from its neighbours.
struct Map {
  data::SampleMatrix nodes;
  double spacing{};
  [[nodiscard]] Eigen::VectorXd widths(double factor) const {
    return Eigen::VectorXd::Constant(nodes.rows(), factor * spacing);
  }
};

Result<Map> make_map(const data::SampleMatrix& x, std::uint64_t seed) {
  Map map{.nodes = self_organising_map(x, seed), .spacing = 0};
  map.spacing = neighbour_distances(map.nodes).mean();
  if (map.spacing > 0) return map;
  return failure(FaultKind::usage, "self-organising map", "all samples are equal");
}

ExpansionModel make_expansion(const Map& map, double factor, const OrthogonalPath& path, Eigen::Index count) {
  const std::vector<Eigen::Index> taken(path.order.begin(), path.order.begin() + count);
  const Eigen::VectorXd weights = path_weights(path, count);
  return {.centres = map.nodes(taken, Eigen::all),
          .lengths = Eigen::RowVectorXd::Ones(map.nodes.cols()),
          .widths = map.widths(factor).head(count),
          .weights = weights,
          .b = path_offset(path, weights)};
}

OrthogonalPath compute_path(const Map& map, double factor, const data::SampleMatrix& x, const Eigen::VectorXd& y,
                            double tolerance) {
  return orthogonal_least_squares(gaussian_units(x, map.nodes, map.widths(factor)), y, tolerance, map.nodes.rows());
}

}  // namespace

data::SampleMatrix self_organising_map(const data::SampleMatrix& samples, std::uint64_t seed,
                                       const MapOptions& options) {
  assert(samples.rows() > 0 && options.side > 0 && options.rounds > 0);
  std::mt19937_64 generator(seed);
  data::SampleMatrix nodes(options.side * options.side, samples.cols());
  for (Eigen::Index j = 0; j < nodes.rows(); ++j) nodes.row(j) = samples.row(draw_index(samples.rows(), generator));
  const double last = std::max(1.0, static_cast<double>(options.rounds) * static_cast<double>(samples.rows()) - 1);
  double presented = 0;
  for (int round = 0; round < options.rounds; ++round) {
    for (const Eigen::Index i : random_order(samples.rows(), generator)) {
      const double progress_made = presented++ / last;
      present_sample(samples.row(i), std::lerp(options.first_rate, options.last_rate, progress_made),
                     std::lerp(options.first_radius, options.last_radius, progress_made), options.side, nodes);
    }
  }
  return nodes;
}

OrthogonalPath orthogonal_least_squares(const Eigen::Ref<const Eigen::MatrixXd>& candidates,
                                        const Eigen::Ref<const Eigen::VectorXd>& y, double tolerance,
                                        Eigen::Index most) {
  assert(candidates.rows() == y.size() && candidates.cols() > 0);
  // Residual of a candidate, relative to its squared norm, that is only rounding error.
  constexpr double kRoundingShare = 1e-12;
  OrthogonalPath path;
  path.means = candidates.colwise().mean();
  path.target_mean = y.mean();
  // Remainders of the candidates, orthogonal to all selected candidates.
  Eigen::MatrixXd remainder = candidates.rowwise() - path.means;
  const Eigen::VectorXd target = y.array() - path.target_mean;
  const Eigen::ArrayXd whole = remainder.colwise().squaredNorm().transpose();
  const double spread = target.squaredNorm();
  most = std::min({most, candidates.cols(), candidates.rows() - 1});
  path.triangle = Eigen::MatrixXd::Identity(most, most);
  path.orthogonal.setZero(most);
  // Coefficient of each selected direction in each candidate.
  Eigen::MatrixXd shares = Eigen::MatrixXd::Zero(most, candidates.cols());
  Eigen::ArrayXd open = Eigen::ArrayXd::Ones(candidates.cols());
  double unexplained = 1;
  while (static_cast<Eigen::Index>(path.order.size()) < most && spread > 0 && unexplained >= tolerance) {
    const Eigen::ArrayXd squares = remainder.colwise().squaredNorm().transpose();
    open = (squares > kRoundingShare * whole).select(open, 0.0);
    const Eigen::ArrayXd products = remainder.transpose() * target;
    const Eigen::ArrayXd ratios = (open > 0).select(products.square() / (squares * spread), 0.0);
    Eigen::Index best = 0;
    if (!(ratios.maxCoeff(&best) > 0)) break;
    const auto k = static_cast<Eigen::Index>(path.order.size());
    const Eigen::VectorXd direction = remainder.col(best);
    path.triangle.col(k).head(k) = shares.col(best).head(k);
    path.orthogonal(k) = products(best) / squares(best);
    path.order.push_back(best);
    path.ratios.push_back(ratios(best));
    unexplained -= ratios(best);
    shares.row(k) = (direction.transpose() * remainder) / squares(best);
    remainder -= direction * shares.row(k);
    open(best) = 0;
  }
  return path;
}

Eigen::Index count_selected(const OrthogonalPath& path, double tolerance) {
  double unexplained = 1;
  Eigen::Index count = 0;
  for (const double ratio : path.ratios) {
    if (unexplained < tolerance) break;
    unexplained -= ratio;
    ++count;
  }
  return count;
}

Eigen::VectorXd path_weights(const OrthogonalPath& path, Eigen::Index count) {
  assert(count <= static_cast<Eigen::Index>(path.order.size()));
  return path.triangle.topLeftCorner(count, count)
      .triangularView<Eigen::UnitUpper>()
      .solve(path.orthogonal.head(count));
}

double path_offset(const OrthogonalPath& path, const Eigen::VectorXd& weights) {
  double offset = path.target_mean;
  for (Eigen::Index k = 0; k < weights.size(); ++k) offset -= path.means(path.order[k]) * weights(k);
  return offset;
}

Result<Choice> choose_kohonen(std::span<const Fold> folds, const MethodOptions& options, const ProgressSink& progress) {
  constexpr Eigen::Index kSteps = kToleranceSteps + 1;
  const Trial predict_paths = [&](const Fold& fold, std::size_t) -> Result<Eigen::MatrixXd> {
    const auto map = make_map(fold.train_x, options.seed);
    if (!map) return failure(map.error());
    Eigen::MatrixXd predicted(fold.test_x.rows(), kSteps * static_cast<Eigen::Index>(kWidthFactors.size()));
    for (std::size_t i = 0; i < kWidthFactors.size(); ++i) {
      const auto path = compute_path(*map, kWidthFactors[i], fold.train_x, fold.train_y, tolerance_at(kToleranceSteps));
      for (Eigen::Index step = 0; step < kSteps; ++step) {
        const auto function = make_expansion(*map, kWidthFactors[i], path, count_selected(path, tolerance_at(step)));
        predicted.col(static_cast<Eigen::Index>(i) * kSteps + step) = evaluate_function(function, fold.test_x);
      }
    }
    return predicted;
  };
  const auto errors = held_out_errors(folds, 1, predict_paths, options, progress);
  if (!errors) return failure(errors.error());
  const Eigen::Index least = find_least(*errors).candidate;
  Choice choice;
  choice.parameters = {{"width factor", kWidthFactors[least / kSteps]}, {"tolerance", tolerance_at(least % kSteps)}};
  return choice;
}

Result<Fit> fit_kohonen(const FitInput& set, const HyperParameters& parameters, const MethodOptions& options) {
  if (const auto sound = check_set(set, 2); !sound) return failure(sound.error());
  const auto map = make_map(set.x, options.seed);
  if (!map) return failure(map.error());
  const double factor = parameter_value(parameters, "width factor");
  const auto path = compute_path(*map, factor, set.x, set.y, parameter_value(parameters, "tolerance"));
  const auto count = static_cast<Eigen::Index>(path.order.size());
  return Fit{.function = make_expansion(*map, factor, path, count),
             .effective_parameters = static_cast<double>(count) + 1,
             .particulars = fmt::format("{} of {} nodes used as centres", count, map->nodes.rows())};
}

}  // namespace gyrotherm::methods
