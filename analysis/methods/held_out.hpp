// SPDX-License-Identifier: Apache-2.0
/// Choice of the hyper-parameters of the comparison methods by the mean squared error on held-out folds, and parallel
/// execution of independent tasks.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "analysis/methods/method.hpp"
#include "core/result.hpp"

namespace gyrotherm::methods {

/// Calls `work(i)` for each i below `count`, in any order, on at most `threads` threads (0: all). Only the calling
/// thread calls the progress sink. Returns false if the sink requested a stop; part of the work is then skipped.
[[nodiscard]] bool in_parallel(std::size_t count, int threads, std::string_view stage, const ProgressSink& progress,
                               const std::function<void(std::size_t)>& work);

/// Checks a training set. Fails with usage if there are fewer than `fewest` samples, if shapes differ, if there are no
/// inputs, or if a value is not finite.
[[nodiscard]] Result<void> check_set(const FitInput& set, Eigen::Index fewest);

/// Trains the candidates of one trial on the training rows of a fold and predicts its held-out rows: rows × candidates.
/// Candidates that can share a decomposition, as along a regularisation path, form one trial.
using Trial = std::function<Result<Eigen::MatrixXd>(const Fold& fold, std::size_t trial)>;

/// Computes the mean squared error over all held-out rows, (°/h)², for each candidate of each trial. The error of a
/// candidate is infinite if the candidate could not be trained on every fold. Trials × folds run in parallel. Fails as
/// check_folds does, with interrupted, with the fault of the first trial if no candidate could be trained, or with
/// numeric if no error is finite.
[[nodiscard]] Result<std::vector<Eigen::VectorXd>> held_out_errors(std::span<const Fold> folds, std::size_t trials,
                                                                   const Trial& trial, const MethodOptions& options,
                                                                   const ProgressSink& progress);

/// Indices of the candidate with the lowest error. Among equal errors the first is chosen, so simple candidates should
/// come first.
struct LowestError {
  std::size_t trial{};
  Eigen::Index candidate{};
};
[[nodiscard]] LowestError find_least(const std::vector<Eigen::VectorXd>& errors);

/// Chooses the candidate with the lowest held-out error. Each candidate is fitted on each fold. Fails as
/// held_out_errors does.
[[nodiscard]] Result<Choice> choose_among(std::span<const HyperParameters> candidates, FitFunction* fit,
                                          std::span<const Fold> folds, const MethodOptions& options,
                                          const ProgressSink& progress);

}  // namespace gyrotherm::methods
