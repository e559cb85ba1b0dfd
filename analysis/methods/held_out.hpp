// SPDX-License-Identifier: Apache-2.0
/// How the comparison methods choose: by the mean squared error on held-out folds, and by nothing else; and how their
/// independent pieces of work share the threads.
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

/// Calls `work(i)` for each i below `count`, in any order, on at most `threads` threads (0: all there are). The sink is
/// asked from the calling thread alone; false if it asked to stop, and some of the work was then left out.
[[nodiscard]] bool in_parallel(std::size_t count, int threads, std::string_view stage, const ProgressSink& progress,
                               const std::function<void(std::size_t)>& work);

/// Checks what a method is to learn from. Fails with usage: fewer than `fewest` samples, shapes that differ, no input,
/// a value that is not finite.
[[nodiscard]] Result<void> check_set(const FitInput& set, Eigen::Index fewest);

/// What several candidates, learnt together from the fold's training rows, say of its held-out rows: rows × candidates.
/// Candidates are many where one decomposition serves many, as along a regularisation path.
using Trial = std::function<Result<Eigen::MatrixXd>(const Fold& fold, std::size_t trial)>;

/// The mean squared error over all held-out rows, (°/h)², of each candidate of each trial; infinite where it could not
/// be learnt on every fold. Trials × folds run in parallel. Fails as check_folds does, with interrupted, or with the
/// first trial's fault if nothing at all could be learnt.
[[nodiscard]] Result<std::vector<Eigen::VectorXd>> held_out_errors(std::span<const Fold> folds, std::size_t trials,
                                                                   const Trial& trial, const MethodOptions& options,
                                                                   const ProgressSink& progress);

/// Where the least of the errors stands; the first of equals, so list the simple before the complex.
struct Least {
  std::size_t trial{};
  Eigen::Index candidate{};
};
[[nodiscard]] Least least_of(const std::vector<Eigen::VectorXd>& errors);

/// Chooses the candidate with the least held-out error; each is fitted anew on each fold. Fails as held_out_errors
/// does.
[[nodiscard]] Result<Choice> choose_among(std::span<const HyperParameters> candidates, FitFunction* fit,
                                          std::span<const Fold> folds, const MethodOptions& options,
                                          const ProgressSink& progress);

}  // namespace gyrotherm::methods
