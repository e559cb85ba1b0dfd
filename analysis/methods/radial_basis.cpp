// SPDX-License-Identifier: Apache-2.0
#include "analysis/methods/radial_basis.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <limits>

#include "analysis/methods/held_out.hpp"
#include "analysis/methods/linear.hpp"
#include "core/random.hpp"

namespace gyrotherm::methods {
namespace {

/// Computes squared distances column by column; the distances to one centre then take one pass.
Eigen::VectorXd squared_distances_to(const Eigen::MatrixXd& samples, const Eigen::RowVectorXd& centre) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(samples.rows());
  for (Eigen::Index j = 0; j < samples.cols(); ++j) sum.array() += (samples.col(j).array() - centre(j)).square();
  return sum;
}

/// Draws start centres. Each next centre is a sample, drawn with a probability proportional to its squared distance
/// from the previous centres.
Result<data::SampleMatrix> draw_centres(const Eigen::MatrixXd& samples, int count, std::mt19937_64& generator) {
  data::SampleMatrix centres(count, samples.cols());
  Eigen::VectorXd nearest = Eigen::VectorXd::Constant(samples.rows(), std::numeric_limits<double>::infinity());
  Eigen::Index chosen = draw_index(samples.rows(), generator);
  for (int k = 0; k < count; ++k) {
    centres.row(k) = samples.row(chosen);
    nearest = nearest.cwiseMin(squared_distances_to(samples, centres.row(k)));
    if (k + 1 == count) break;
    double remainder = uniform(generator) * nearest.sum();
    if (!(nearest.maxCoeff() > 0)) {
      return failure(FaultKind::usage, "k-means",
                     fmt::format("{} centres need as many distinct samples, got {}", count, k + 1));
    }
    for (chosen = 0; chosen + 1 < nearest.size() && (remainder -= nearest(chosen)) >= 0;) ++chosen;
    while (!(nearest(chosen) > 0)) chosen = chosen > 0 ? chosen - 1 : nearest.size() - 1;  // rounding at the end
  }
  return centres;
}

/// Assigns each sample to its nearest centre; among equally near centres, to the first. Stores the squared distances in
/// `nearest`.
std::vector<Eigen::Index> assign(const Eigen::MatrixXd& samples, const data::SampleMatrix& centres,
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

/// Moves each centre to the mean of its samples. A centre without samples does not move.
void move_to_means(const data::SampleMatrix& samples, const std::vector<Eigen::Index>& owner,
                   data::SampleMatrix& centres) {
  data::SampleMatrix sums = data::SampleMatrix::Zero(centres.rows(), centres.cols());
  Eigen::VectorXd counts = Eigen::VectorXd::Zero(centres.rows());
  for (Eigen::Index i = 0; i < samples.rows(); ++i) {
    sums.row(owner[i]) += samples.row(i);
    counts(owner[i]) += 1;
  }
  for (Eigen::Index k = 0; k < centres.rows(); ++k) {
    if (counts(k) > 0) centres.row(k) = sums.row(k) / counts(k);
  }
}

constexpr std::array kCentres = {10, 20, 40, 80};
constexpr std::array kUnitWidthFactors = {1.0, 2.0, 4.0, 8.0, 16.0};
constexpr std::array kLambdas = {1e-2, 1e-4, 1e-6, 1e-8, 1e-10};

/// Centres, and the mean distance of each from its neighbours.
struct Units {
  data::SampleMatrix centres;
  Eigen::VectorXd distances;
};

Result<Units> place_units(const data::SampleMatrix& x, int count, std::uint64_t seed) {
  return k_means(x, count, seed).map([](KMeans&& found) {
    Eigen::VectorXd distances = neighbour_distances(found.centres);
    return Units{std::move(found.centres), std::move(distances)};
  });
}

/// Predicts the held-out rows of the fold with units of this width factor, one column per λ.
Eigen::MatrixXd predict_path(const Units& units, double factor, const Fold& fold) {
  const Eigen::VectorXd widths = factor * units.distances;
  const RidgePath path(gaussian_units(fold.train_x, units.centres, widths), fold.train_y);
  const Eigen::MatrixXd held_out = gaussian_units(fold.test_x, units.centres, widths);
  Eigen::MatrixXd predicted(fold.test_x.rows(), static_cast<Eigen::Index>(kLambdas.size()));
  for (Eigen::Index i = 0; i < predicted.cols(); ++i) {
    const Eigen::VectorXd weights = path.weights(kLambdas[static_cast<std::size_t>(i)]);
    predicted.col(i) = (held_out * weights).array() + path.offset(weights);
  }
  return predicted;
}

}  // namespace

Result<KMeans> k_means(const data::SampleMatrix& samples, int count, std::uint64_t seed) {
  assert(count > 0);
  constexpr int kMostRounds = 200;
  std::mt19937_64 generator(seed);
  const Eigen::MatrixXd columns = samples;
  if (samples.rows() < count) {
    return failure(FaultKind::usage, "k-means",
                   fmt::format("{} centres need as many samples, got {}", count, samples.rows()));
  }
  auto centres = draw_centres(columns, count, generator);
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

Eigen::VectorXd neighbour_distances(const data::SampleMatrix& centres) {
  assert(centres.rows() >= 3);
  Eigen::VectorXd means(centres.rows());
  for (Eigen::Index k = 0; k < centres.rows(); ++k) {
    Eigen::VectorXd distances = (centres.rowwise() - centres.row(k)).rowwise().norm();
    std::nth_element(distances.begin(), distances.begin() + 2, distances.end());  // the least is its own, 0
    means(k) = (std::max(distances(0), distances(1)) + distances(2)) / 2;
  }
  return means;
}

Eigen::MatrixXd gaussian_units(const data::SampleMatrix& samples, const data::SampleMatrix& centres,
                               const Eigen::VectorXd& widths) {
  const Eigen::MatrixXd columns = samples;
  Eigen::MatrixXd units(samples.rows(), centres.rows());
  for (Eigen::Index k = 0; k < centres.rows(); ++k) {
    const double scale = -0.5 / (widths(k) * widths(k));
    units.col(k) = (scale * squared_distances_to(columns, centres.row(k)).array()).exp();
  }
  return units;
}

Result<Choice> choose_radial_basis(std::span<const Fold> folds, const MethodOptions& options,
                                   const ProgressSink& progress) {
  constexpr auto kPaths = static_cast<Eigen::Index>(kLambdas.size());
  const Trial predict_widths = [&](const Fold& fold, std::size_t trial) -> Result<Eigen::MatrixXd> {
    const auto units = place_units(fold.train_x, kCentres[trial], options.seed);
    if (!units) return failure(units.error());
    Eigen::MatrixXd predicted(fold.test_x.rows(), kPaths * static_cast<Eigen::Index>(kUnitWidthFactors.size()));
    for (std::size_t i = 0; i < kUnitWidthFactors.size(); ++i) {
      predicted.middleCols(static_cast<Eigen::Index>(i) * kPaths, kPaths) =
          predict_path(*units, kUnitWidthFactors[i], fold);
    }
    return predicted;
  };
  const auto errors = held_out_errors(folds, kCentres.size(), predict_widths, options, progress);
  if (!errors) return failure(errors.error());
  const LowestError least = find_least(*errors);
  Choice choice;
  choice.parameters = {{"centres", static_cast<double>(kCentres[least.trial])},
                       {"width factor", kUnitWidthFactors[static_cast<std::size_t>(least.candidate / kPaths)]},
                       {"lambda", kLambdas[static_cast<std::size_t>(least.candidate % kPaths)]}};
  return choice;
}

Result<Fit> fit_radial_basis(const FitInput& set, const HyperParameters& parameters, const MethodOptions& options) {
  if (const auto sound = check_set(set, 2); !sound) return failure(sound.error());
  auto units = place_units(set.x, static_cast<int>(parameter_value(parameters, "centres")), options.seed);
  if (!units) return failure(units.error());
  const Eigen::VectorXd widths = parameter_value(parameters, "width factor") * units->distances;
  const double lambda = parameter_value(parameters, "lambda");
  const RidgePath path(gaussian_units(set.x, units->centres, widths), set.y);
  const Eigen::VectorXd weights = path.weights(lambda);
  return Fit{.function = ExpansionModel{.centres = std::move(units->centres),
                                        .lengths = Eigen::RowVectorXd::Ones(set.x.cols()),
                                        .widths = widths,
                                        .weights = weights,
                                        .b = path.offset(weights)},
             .effective_parameters = path.effective_parameters(lambda)};
}

}  // namespace gyrotherm::methods
