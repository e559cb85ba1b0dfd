// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/placement.hpp"

#include <fmt/format.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

#include "analysis/data/dataset.hpp"
#include "analysis/data/features.hpp"
#include "analysis/model/selection.hpp"

namespace gyrotherm::model {
namespace {

/// Indices of the thermometers that are kept, in ascending order.
using Set = std::vector<std::size_t>;

/// Returns the inputs of a record that are thermometers. Values measured by the gyro itself are excluded: their
/// position cannot be chosen, most are not temperatures, and they may be missing.
Set find_thermometers(const std::vector<std::string>& inputs) {
  Set thermometers;
  for (std::size_t i = 0; i < inputs.size(); ++i)
    if (!data::is_own_value(inputs[i])) thermometers.push_back(i);
  return thermometers;
}

std::vector<std::string> select_names(const Set& set, const std::vector<std::string>& inputs) {
  std::vector<std::string> names;
  for (const std::size_t thermometer : set) names.push_back(inputs[thermometer]);
  return names;
}

/// Returns all subsets of `set` with `count` elements left out.
std::vector<Set> make_subsets(const Set& set, std::size_t count, std::size_t from = 0) {
  if (count == 0) return {set};
  std::vector<Set> sets;
  for (std::size_t i = from; i < set.size(); ++i) {
    Set remainder = set;
    remainder.erase(remainder.begin() + static_cast<std::ptrdiff_t>(i));
    std::ranges::move(make_subsets(remainder, count - 1, i), std::back_inserter(sets));
  }
  return sets;
}

/// Held-out accuracy of a set of thermometers.
struct SetAccuracy {
  SurfaceTrial trial;
  data::Figures held_out;
};

class Study {
 public:
  Study(data::TrainingSet training_set, std::optional<data::Clusters> unseen, const ProgressSink& progress)
      : training_set_(std::move(training_set)),
        unseen_(std::move(unseen)),
        progress_(progress),
        all_thermometers_(find_thermometers(training_set_.clusters.thermometers)) {}

  Result<Placement> run();

 private:
  [[nodiscard]] std::vector<std::string> names(const Set& set) const {
    return select_names(set, training_set_.clusters.thermometers);
  }
  [[nodiscard]] data::SampleMatrix inputs(const Set& set, const data::Clusters& clusters) const {
    return *evaluate(placement_terms(names(set)), clusters);
  }
  [[nodiscard]] SetAccuracy measure(const Set& set) const;
  Result<void> measure_all(const std::vector<Set>& sets);
  [[nodiscard]] const Set& find_most_accurate(const std::vector<Set>& sets) const;
  [[nodiscard]] SubsetAccuracy make_left_out(const Set& kept) const;
  [[nodiscard]] std::size_t count_sets() const;
  Result<std::optional<SubsetAccuracy>> find_best_elimination(std::size_t count);
  Result<void> eliminate(Placement& placement);

  static constexpr std::size_t kManyThermometers = 12;

  data::TrainingSet training_set_;
  std::optional<data::Clusters> unseen_;
  ProgressSink progress_;
  Set all_thermometers_;
  std::map<Set, SetAccuracy> accuracies_;
};

SetAccuracy Study::measure(const Set& set) const {
  SetAccuracy measured{.trial = try_surface(inputs(set, training_set_.clusters), training_set_.clusters.bias_deg_per_h,
                                            training_set_.folds),
                       .held_out = {}};
  measured.held_out = compute_figures(measured.trial.residual, training_set_.clusters);
  return measured;
}

/// Computes the accuracy of the sets for which it is still unknown. Fails if a STD is not finite, since such a value
/// cannot be ordered and would make a recommendation meaningless.
Result<void> Study::measure_all(const std::vector<Set>& sets) {
  constexpr std::size_t kSetsPerReport = 16;  // sets between two progress reports
  std::vector<Set> open;
  std::ranges::copy_if(sets, std::back_inserter(open), [&](const Set& set) { return !accuracies_.contains(set); });
  for (std::size_t first = 0; first < open.size(); first += kSetsPerReport) {
    const double done = static_cast<double>(accuracies_.size()) / static_cast<double>(count_sets());
    if (!should_continue(progress_, "leaving thermometers out", std::min(1.0, done))) {
      return failure(FaultKind::interrupted, "placement", "stopped on request");
    }
    std::vector<SetAccuracy> measured(std::min(kSetsPerReport, open.size() - first));
    oneapi::tbb::parallel_for(std::size_t{0}, measured.size(),
                              [&](std::size_t i) { measured[i] = measure(open[first + i]); });
    for (std::size_t i = 0; i < measured.size(); ++i) {
      if (!std::isfinite(measured[i].held_out.std)) {
        return failure(
            FaultKind::usage, "placement",
            fmt::format("held-out residual of {}: not a finite value", fmt::join(names(open[first + i]), ", ")));
      }
      accuracies_.emplace(open[first + i], std::move(measured[i]));
    }
  }
  return {};
}

/// Returns the set with the least held-out STD; the first of several equal ones.
const Set& Study::find_most_accurate(const std::vector<Set>& sets) const {
  return *std::ranges::min_element(sets, {}, [&](const Set& set) { return accuracies_.at(set).held_out.std; });
}

SubsetAccuracy Study::make_left_out(const Set& kept) const {
  const SetAccuracy &with = accuracies_.at(all_thermometers_), &without = accuracies_.at(kept);
  const auto squares = [](const SetAccuracy& measured) {
    return (measured.trial.residual.array() - measured.held_out.mean).square();
  };
  // s² − s₀² = (s − s₀)(s + s₀), and s² − s₀² is the mean of the differences of the squares.
  const data::Figures excess = compute_figures((squares(without) - squares(with)).matrix(), training_set_.clusters);
  Set removed;
  std::ranges::set_difference(all_thermometers_, kept, std::back_inserter(removed));
  SubsetAccuracy result{
      .left_out = names(removed),
      .kept = names(kept),
      .held_out = without.held_out,
      .price_deg_per_h = without.held_out.std - with.held_out.std,
      .price_error_deg_per_h = standard_error_of_mean(excess) / (without.held_out.std + with.held_out.std),
      .unseen = {}};
  if (unseen_) {
    const std::array lambda = {without.trial.lambda};
    const Eigen::VectorXd predicted = surface_predictions(
        inputs(kept, training_set_.clusters), training_set_.clusters.bias_deg_per_h, inputs(kept, *unseen_), lambda);
    result.unseen = compute_figures(unseen_->bias_deg_per_h - predicted, *unseen_);
  }
  return result;
}

/// Returns the total number of sets whose accuracy is to be computed, for the progress.
std::size_t Study::count_sets() const {
  const std::size_t m = all_thermometers_.size();
  if (m > kManyThermometers) return 1 + m * (m + 1) / 2;
  const std::size_t up_to_three = 1 + m + m * (m - 1) / 2 + m * (m - 1) * (m - 2) / 6;
  return up_to_three + (m > 4 ? (m - 3) * (m - 2) / 2 : 0);
}

Result<std::optional<SubsetAccuracy>> Study::find_best_elimination(std::size_t count) {
  if (all_thermometers_.size() <= count || all_thermometers_.size() > kManyThermometers) return std::nullopt;
  const auto sets = make_subsets(all_thermometers_, count);
  if (const auto measured = measure_all(sets); !measured) return failure(measured.error());
  return make_left_out(find_most_accurate(sets));
}

Result<void> Study::eliminate(Placement& placement) {
  std::vector<std::string> order;
  for (Set kept = all_thermometers_; kept.size() > 1;) {
    const auto sets = make_subsets(kept, 1);
    if (const auto measured = measure_all(sets); !measured) return measured;
    const Set& next = find_most_accurate(sets);
    Set removed;
    std::ranges::set_difference(kept, next, std::back_inserter(removed));
    order.push_back(names(removed).front());
    placement.elimination.push_back(make_left_out(next));
    placement.elimination.back().left_out = order;
    kept = next;
  }
  const auto too_expensive = std::ranges::find_if(placement.elimination, [](const SubsetAccuracy& step) {
    return step.price_deg_per_h > step.price_error_deg_per_h;
  });
  placement.spared = static_cast<int>(too_expensive - placement.elimination.begin());
  return {};
}

Result<Placement> Study::run() {
  Placement placement;
  placement.folds = training_set_.folds.statement;
  if (const auto measured = measure_all({all_thermometers_}); !measured) return failure(measured.error());
  placement.all = make_left_out(all_thermometers_);
  const auto alone = make_subsets(all_thermometers_, 1);
  if (const auto measured = measure_all(alone); !measured) return failure(measured.error());
  for (const Set& set : alone) placement.alone.push_back(make_left_out(set));
  std::ranges::stable_sort(placement.alone, {}, &SubsetAccuracy::price_deg_per_h);
  auto pair = find_best_elimination(2);
  if (!pair) return failure(pair.error());
  placement.best_pair = std::move(*pair);
  auto three = find_best_elimination(3);
  if (!three) return failure(three.error());
  placement.best_three = std::move(*three);
  if (const auto eliminated = eliminate(placement); !eliminated) return failure(eliminated.error());
  return placement;
}

}  // namespace

std::vector<data::Term> placement_terms(const std::vector<std::string>& thermometers) {
  std::vector<data::Term> terms{data::temperature_term(thermometers.front())};
  for (std::size_t j = 1; j < thermometers.size(); ++j) {
    terms.push_back(data::gradient_term(thermometers.front(), thermometers[j]));
  }
  return terms;
}

Result<Placement> study_placement(const std::vector<data::Clusters>& records, const std::vector<data::Clusters>& unseen,
                                  const data::FoldOptions& options, const ProgressSink& progress) {
  auto clusters = concatenate(records);
  if (!clusters) return failure(clusters.error());
  const auto thermometers = select_names(find_thermometers(clusters->thermometers), clusters->thermometers);
  if (thermometers.size() < 2) {
    return failure(FaultKind::usage, "placement",
                   fmt::format("needs at least two thermometers, the record has {}", thermometers.size()));
  }
  auto folds = plan_folds(records, options);
  if (!folds) return failure(folds.error());
  std::optional<data::Clusters> others;
  if (!unseen.empty()) {
    auto joined = concatenate(unseen);
    if (!joined) return failure(joined.error());
    if (const auto known = evaluate(placement_terms(thermometers), *joined); !known) {
      return failure(known.error());
    }
    others = std::move(*joined);
  }
  return Study({.clusters = std::move(*clusters), .folds = std::move(*folds)}, std::move(others), progress).run();
}

}  // namespace gyrotherm::model
