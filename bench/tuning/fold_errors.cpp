// SPDX-License-Identifier: Apache-2.0
#include "bench/tuning/fold_errors.hpp"

#include <cmath>

#include "analysis/svm/spanned.hpp"

namespace gyrotherm::bench {

FoldErrors::FoldErrors(std::vector<svm::TuningFold> folds, double relative_gap)
    : folds_(std::move(folds)), options_{.relative_gap = relative_gap} {
  for (const svm::TuningFold& fold : folds_) {
    svm::SampleMatrix both(fold.train_x.rows() + fold.test_x.rows(), fold.train_x.cols());
    both << fold.train_x, fold.test_x;
    const svm::SampleMatrix spanned = svm::project_to_span(both);
    training_.emplace_back(spanned.topRows(fold.train_x.rows()));
    held_out_.emplace_back(spanned.bottomRows(fold.test_x.rows()));
    samples_.emplace_back(training_.back());
    seeds_.push_back(svm::FoldSeed::between(folds_.front(), fold));
    rows_ += static_cast<double>(fold.test_y.size());
  }
}

std::optional<SquaredError> FoldErrors::evaluate_fold(std::size_t fold, const svm::SvrParameters& parameters,
                                                      DescentHistory& history) {
  constexpr double kMaxStartDistance_octaves = 2;  // as in svm::tune_svr()
  std::optional<svm::SvrStart> start;
  const auto& last = history[fold];
  if (last && octaves_between(last->first, parameters) <= kMaxStartDistance_octaves)
    start = last->second;
  else if (fold > 0 && seeds_[fold])
    start = seeds_[fold]->start(history.front()->second);
  auto solution =
      solve_svr(samples_[fold], memory_, folds_[fold].train_y, parameters, options_, start ? &*start : nullptr);
  if (!solution) return {};
  SquaredError error = differentiate({training_[fold], held_out_[fold], folds_[fold].test_y}, *solution, parameters);
  const double unit = folds_[fold].target_scale * folds_[fold].target_scale;
  history[fold] = {parameters, {std::move(solution->beta), parameters.C}};
  return SquaredError{unit * error.sum, unit * error.slope};
}

std::optional<LogError> FoldErrors::evaluate(const Position& position, DescentHistory& history) {
  ++evaluations_;
  history.resize(folds_.size());
  SquaredError all;
  for (std::size_t fold = 0; fold < folds_.size(); ++fold) {
    const auto error = evaluate_fold(fold, parameters_at(position), history);
    if (!error) return {};
    all.sum += error->sum;
    all.slope += error->slope;
  }
  return LogError{std::log(all.sum / rows_), all.slope / all.sum};
}

}  // namespace gyrotherm::bench
