#include "analysis/methods/kohonen.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "analysis/methods/centres.hpp"
#include "analysis/methods/held_out.hpp"
#include "analysis/methods/orthogonal_least_squares.hpp"

namespace gyrotherm {
namespace {

constexpr std::array kWidthFactors = {1.0, 2.0, 4.0, 8.0, 16.0};
constexpr int kToleranceSteps = 12;  // quarter decades from 10⁻¹ to 10⁻⁴

double tolerance_at(Eigen::Index step) { return std::pow(10.0, -1 - 0.25 * static_cast<double>(step)); }

/// The nodes and how far they lie from their neighbours.
struct Map {
  SampleMatrix nodes;
  double apart{};
  [[nodiscard]] Eigen::VectorXd widths(double factor) const {
    return Eigen::VectorXd::Constant(nodes.rows(), factor * apart);
  }
};

Result<Map> make_map(const SampleMatrix& x, std::uint64_t seed) {
  Map map{.nodes = self_organising_map(x, seed), .apart = 0};
  map.apart = neighbour_distances(map.nodes).mean();
  if (map.apart > 0) return map;
  return failure(FaultKind::usage, "self-organising map", "the samples do not differ");
}

ExpansionModel expansion_of(const Map& map, double factor, const OrthogonalPath& path, Eigen::Index count) {
  const std::vector<Eigen::Index> taken(path.order.begin(), path.order.begin() + count);
  const Eigen::VectorXd weights = weights_of(path, count);
  return {.centres = map.nodes(taken, Eigen::all),
          .lengths = Eigen::RowVectorXd::Ones(map.nodes.cols()),
          .widths = map.widths(factor).head(count),
          .weights = weights,
          .b = offset_of(path, weights)};
}

OrthogonalPath path_of(const Map& map, double factor, const SampleMatrix& x, const Eigen::VectorXd& y,
                       double tolerance) {
  return orthogonal_least_squares(gaussian_units(x, map.nodes, map.widths(factor)), y, tolerance, map.nodes.rows());
}

}  // namespace

Result<Choice> choose_kohonen(std::span<const Fold> folds, const MethodOptions& options, const ProgressSink& progress) {
  constexpr Eigen::Index kSteps = kToleranceSteps + 1;
  const Trial along_the_paths = [&](const Fold& fold, std::size_t) -> Result<Eigen::MatrixXd> {
    const auto map = make_map(fold.train_x, options.seed);
    if (!map) return failure(map.error());
    Eigen::MatrixXd predicted(fold.test_x.rows(), kSteps * static_cast<Eigen::Index>(kWidthFactors.size()));
    for (std::size_t i = 0; i < kWidthFactors.size(); ++i) {
      const auto path = path_of(*map, kWidthFactors[i], fold.train_x, fold.train_y, tolerance_at(kToleranceSteps));
      for (Eigen::Index step = 0; step < kSteps; ++step) {
        const auto function = expansion_of(*map, kWidthFactors[i], path, taken_at(path, tolerance_at(step)));
        predicted.col(static_cast<Eigen::Index>(i) * kSteps + step) = value_of(function, fold.test_x);
      }
    }
    return predicted;
  };
  const auto errors = held_out_errors(folds, 1, along_the_paths, options, progress);
  if (!errors) return failure(errors.error());
  const Eigen::Index least = least_of(*errors).candidate;
  Choice choice;
  choice.parameters = {{"width factor", kWidthFactors[least / kSteps]}, {"tolerance", tolerance_at(least % kSteps)}};
  return choice;
}

Result<Fit> fit_kohonen(const FitInput& set, const HyperParameters& parameters, const MethodOptions& options) {
  if (const auto sound = check_set(set, 2); !sound) return failure(sound.error());
  const auto map = make_map(set.x, options.seed);
  if (!map) return failure(map.error());
  const double factor = value_of(parameters, "width factor");
  const auto path = path_of(*map, factor, set.x, set.y, value_of(parameters, "tolerance"));
  const auto count = static_cast<Eigen::Index>(path.order.size());
  return Fit{.function = expansion_of(*map, factor, path, count),
             .effective_parameters = static_cast<double>(count) + 1,
             .particulars = fmt::format("{} of {} nodes taken as centres", count, map->nodes.rows())};
}

}  // namespace gyrotherm
