#include <fmt/format.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "analysis/data/features.hpp"
#include "analysis/data/statistics.hpp"
#include "analysis/model/response_surface.hpp"
#include "analysis/model/selection.hpp"

namespace gyrotherm {
namespace {

using Columns = std::vector<Eigen::Index>;

/// One input more, and how the surface of all so far does.
struct Step {
  Eigen::Index column{};
  SurfaceTrial trial;
};

/// Fixed inputs first, then the candidates.
struct Field {
  SampleMatrix x;
  const TrainingSet& training_set;
  std::size_t fixed;

  [[nodiscard]] SurfaceTrial trial_of(const Columns& columns) const {
    return try_surface(x(Eigen::all, columns), training_set.clusters.bias_deg_per_h, training_set.folds);
  }
};

/// Of the candidates not yet taken; the first of equals.
Step best_next(const Field& field, const Columns& taken) {
  std::vector<Step> steps;
  for (Eigen::Index column = static_cast<Eigen::Index>(field.fixed); column < field.x.cols(); ++column) {
    if (std::ranges::count(taken, column) == 0) steps.push_back({column, {}});
  }
  tbb::parallel_for(std::size_t{0}, steps.size(), [&](std::size_t i) {
    Columns columns = taken;
    columns.push_back(steps[i].column);
    steps[i].trial = field.trial_of(columns);
  });
  return *std::ranges::min_element(steps, {}, [](const Step& step) { return step.trial.mean_square; });
}

/// Grows while the held-out error falls. Without fixed inputs the first one is taken whatever it gains.
std::vector<Step> grow(const Field& field, const SurfaceTrial& start, std::size_t most) {
  Columns taken(field.fixed);
  std::iota(taken.begin(), taken.end(), Eigen::Index{0});
  std::vector<Step> path;
  double error = start.mean_square;
  while (path.size() < most && taken.size() < static_cast<std::size_t>(field.x.cols())) {
    Step step = best_next(field, taken);
    if (!(step.trial.mean_square < error) && !taken.empty()) break;
    error = step.trial.mean_square;
    taken.push_back(step.column);
    path.push_back(std::move(step));
  }
  return path;
}

/// Standard error of the mean squared error, with the effective number of the squared residuals.
double error_of_mean_square(const SurfaceTrial& trial, const Clusters& clusters) {
  std::vector<Eigen::Index> rows;
  for (Eigen::Index k = 0; k < trial.residual.size(); ++k) {
    if (std::isfinite(trial.residual(k))) rows.push_back(k);
  }
  return mean_error(figures_of(trial.residual(rows).array().square().matrix(), clusters, rows));
}

/// How many steps of the path to keep. The last has the least error.
std::size_t one_standard_error(const std::vector<Step>& path, const SurfaceTrial& start, const Field& field) {
  if (path.empty()) return 0;
  const SurfaceTrial& best = path.back().trial;
  const double enough = best.mean_square + error_of_mean_square(best, field.training_set.clusters);
  if (field.fixed > 0 && start.mean_square <= enough) return 0;
  std::size_t kept = 1;
  while (path[kept - 1].trial.mean_square > enough) ++kept;
  return kept;
}

}  // namespace

Result<Selection> select_forward(const std::vector<Term>& fixed, const std::vector<Term>& candidates,
                                 const TrainingSet& training_set, int most) {
  const auto divided = with_two_folds(training_set);
  if (!divided) return failure(divided.error());
  std::vector<Term> terms = fixed;
  terms.insert(terms.end(), candidates.begin(), candidates.end());
  auto x = evaluate(terms, training_set.clusters);
  if (!x) return failure(x.error());
  const Field field{.x = std::move(*x), .training_set = *divided, .fixed = fixed.size()};
  Columns at_first(fixed.size());
  std::iota(at_first.begin(), at_first.end(), Eigen::Index{0});
  const SurfaceTrial start = field.trial_of(at_first);
  const std::vector<Step> path = grow(field, start, static_cast<std::size_t>(most));
  const std::size_t kept = one_standard_error(path, start, field);

  Selection selection;
  selection.threshold = 0;
  std::vector<std::string> names;
  for (std::size_t k = 0; k < kept; ++k) {
    selection.terms.push_back(terms[path[k].column]);
    names.push_back(text(terms[path[k].column]));
  }
  selection.rank = rank_of(selection.terms);
  const double error = std::sqrt(kept > 0 ? path[kept - 1].trial.mean_square : start.mean_square);
  selection.statement = fmt::format(
      "forward by held-out gain, {} of {} inputs: {} (rank {}); a response surface of {} has RMSE {:.4g} "
      "°/h held out",
      kept, candidates.size(), kept > 0 ? fmt::format("{}", fmt::join(names, ", ")) : "none", selection.rank,
      fixed.empty() ? "them" : "them and the inputs always taken", error);
  return selection;
}

}  // namespace gyrotherm
