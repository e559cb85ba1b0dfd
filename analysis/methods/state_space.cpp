// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

#include "analysis/methods/held_out.hpp"
#include "analysis/methods/ridge_u.hpp"

namespace gyrotherm::methods {
namespace {

using TimeConstants = std::vector<int>;

TimeConstants time_constants_in(const std::vector<data::Term>& terms) {
  std::set<int> all;
  for (const data::Factor& lag : lags_in(terms)) all.insert(lag.time_constant_s);
  return {all.begin(), all.end()};
}

HyperParameters to_hyper_parameters(const TimeConstants& chosen) {
  HyperParameters parameters;
  for (std::size_t i = 0; i < chosen.size(); ++i)
    parameters.push_back({fmt::format("tau_{}_s", i + 1), static_cast<double>(chosen[i])});
  return parameters;
}

/// Appends every subset of the bank with `states` elements to `sets`.
void add_sets(const TimeConstants& bank, std::size_t states, std::size_t from, TimeConstants& partial,
              std::vector<HyperParameters>& sets) {
  if (partial.size() == states) return sets.push_back(to_hyper_parameters(partial));
  for (std::size_t i = from; i < bank.size(); ++i) {
    partial.push_back(bank[i]);
    add_sets(bank, states, i + 1, partial, sets);
    partial.pop_back();
  }
}

/// Returns the columns of terms in which every lag has one of the chosen time constants.
std::vector<Eigen::Index> select_columns(const std::vector<data::Term>& terms, const HyperParameters& chosen) {
  const auto is_chosen = [&](const data::Factor& factor) {
    return factor.kind != data::FactorKind::lag ||
           std::ranges::any_of(chosen, [&](const HyperParameter& tau) { return tau.value == factor.time_constant_s; });
  };
  std::vector<Eigen::Index> columns;
  for (std::size_t j = 0; j < terms.size(); ++j)
    if (std::ranges::all_of(terms[j].factors, is_chosen)) columns.push_back(static_cast<Eigen::Index>(j));
  return columns;
}

}  // namespace

Result<Choice> choose_state_space(std::span<const Fold> folds, const MethodOptions& options,
                                  const ProgressSink& progress) {
  if (folds.empty()) return failure(FaultKind::usage, "tuning", "no fold");
  const TimeConstants bank = time_constants_in(folds.front().terms);
  if (bank.empty())
    return Choice{.parameters = {}, .tuning = {}, .warnings = {"no input is a lag, so the model has no state"}};
  std::vector<HyperParameters> sets;
  TimeConstants partial;
  for (std::size_t states = 1; states <= std::min(kMostStates, bank.size()); ++states)
    add_sets(bank, states, 0, partial, sets);
  return choose_among(sets, fit_state_space, folds, options, progress);
}

Result<Fit> fit_state_space(const FitInput& set, const HyperParameters& parameters, const MethodOptions&) {
  if (const auto sound = check_set(set, 2); !sound) return failure(sound.error());
  const auto columns = select_columns(set.terms, parameters);
  const data::SampleMatrix x = set.x(Eigen::all, columns);
  Eigen::MatrixXd covariance;
  if (set.input_covariance.size() > 0) covariance = set.input_covariance(columns, columns);
  const PenalisedPlane plane = fit_plane({x, set.y, set.terms, std::move(covariance)});
  LinearModel linear{.weights = Eigen::VectorXd::Zero(set.x.cols()), .b = plane.b};
  for (std::size_t k = 0; k < columns.size(); ++k)
    linear.weights(columns[k]) = plane.weights[static_cast<Eigen::Index>(k)];
  return Fit{.function = std::move(linear),
             .effective_parameters = plane.effective_parameters + static_cast<double>(parameters.size())};
}

}  // namespace gyrotherm::methods
