// SPDX-License-Identifier: Apache-2.0
/// Which of many inputs to take, learnt from one training set alone; and the learner by which sets of inputs are
/// judged.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/data/features.hpp"
#include "analysis/data/folds.hpp"
#include "analysis/svm/svr.hpp"
#include "core/result.hpp"

namespace gyrotherm::model {

// A response surface of second order by ridge regression: the cheap learner by which inputs are chosen and
// thermometers are judged. Its cost is milliseconds, and on the virtual gyro its held-out error is the noise floor
// (docs/evaluation.md).
//
// y ≈ b + Σ w_i z_i + Σ_{i≤j} w_ij z_i z_j (Box & Wilson, J. R. Stat. Soc. B 13 (1951) 1), minimising
// ‖y − ŷ‖² + λ n ‖w‖² with b free (Hoerl & Kennard, Technometrics 12 (1970) 55). z are the inputs standardised on the
// training rows; so are, once more, the products. What does not vary on the training rows has no part.

/// The penalties λ that try_surface chooses from.
inline constexpr std::array<double, 11> kSurfaceLambdas = {1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1, 10, 100};

/// Predicts the rows of `test_x` by surfaces with these λ, learnt from `train_x` and `train_y`: rows × λ. Without a
/// column in x the prediction is the mean of `train_y`. All values are finite, λ > 0, and there is a training row.
[[nodiscard]] Eigen::MatrixXd surface_predictions(const svm::SampleMatrix& train_x, const Eigen::VectorXd& train_y,
                                                  const svm::SampleMatrix& test_x, std::span<const double> lambdas);

/// How well a surface predicts held-out folds, λ chosen by them.
struct SurfaceTrial {
  Eigen::VectorXd residual;  ///< y − ŷ of each row, in the units of y; NaN where a row is never held out
  double lambda{};
  double mean_square{};  ///< of the residuals that are
};

/// Holds each fold out in turn. `x` and `y` have a row per cluster that the folds number.
[[nodiscard]] SurfaceTrial try_surface(const svm::SampleMatrix& x, const Eigen::VectorXd& y,
                                       const data::FoldPlan& folds);

enum class SelectionKind {
  correlation,  ///< |r| with the bias above a threshold: the paper's §4.3
  forward,      ///< one after the other, each the one that gains most on held-out folds
  redundancy,   ///< all that do not depend on the others
};

/// How to select, as the user says it in one word and perhaps a number.
struct SelectionRule {
  SelectionKind kind = SelectionKind::correlation;
  double threshold = 0.90;  ///< of |r|
  int most = 12;            ///< forward: inputs, at most
  double tolerance =
      1e-6;  ///< redundancy: an input of which less than this part of its STD is its own depends on others
};

/// Reads "correlation", "correlation:0.85", "forward", "forward:6", "redundancy", "redundancy:0.01". Fails with usage.
[[nodiscard]] Result<SelectionRule> parse_selection(std::string_view text);

struct Selection {
  std::vector<data::Term> terms;
  double threshold = 0.90;  ///< correlation only, else 0
  int rank{};
  bool fallback{};        ///< too few passed: those that do not depend on the ones before them are used
  std::string statement;  ///< in words, for the report
};

/// Selects from the candidates by the rule, beside the fixed terms that are taken anyway. Fails with usage if there is
/// no candidate, or if a term needs a thermometer that the clusters lack. All values are finite.
[[nodiscard]] Result<Selection> select_inputs(const SelectionRule& rule, const std::vector<data::Term>& fixed,
                                              const std::vector<data::Term>& candidates,
                                              const data::TrainingSet& training_set);

/// The rule correlation, given each candidate's r, takes those with |r| > threshold. Where they span fewer dimensions
/// than `least_rank`, the candidates that do not depend on the ones before them are taken instead, and the selection
/// says so; of all 28 gradients these are the differences with the first thermometer (errata 3.1).
[[nodiscard]] Selection select_by_correlation(const std::vector<data::Term>& candidates, const std::vector<double>& r,
                                              double threshold, int least_rank);

/// The rule forward grows by the candidate whose response surface has the least held-out squared
/// error, while that error falls and fewer than `most` are taken; then keeps the fewest whose mean squared error is
/// within one standard error of the least (Breiman et al., Classification and Regression Trees, 1984, §3.4.3), reckoned
/// with the effective number of the squared residuals. A training set of fewer than two folds is cut into blocks.
[[nodiscard]] Result<Selection> select_forward(const std::vector<data::Term>& fixed,
                                               const std::vector<data::Term>& candidates,
                                               const data::TrainingSet& training_set, int most);

/// The rule redundancy is a QR with column pivoting of the standardised candidates, after the fixed terms have been
/// projected out. Candidates are kept while more than `tolerance` of their STD is their own; what remains is a
/// combination of those and the fixed to that part.
[[nodiscard]] Result<Selection> select_independent(const std::vector<data::Term>& fixed,
                                                   const std::vector<data::Term>& candidates,
                                                   const data::Clusters& training, double tolerance);

}  // namespace gyrotherm::model
