// SPDX-License-Identifier: Apache-2.0
/// Selection of inputs from one training set, and the fast learner that measures the accuracy of a set of inputs.
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

// A second-order response surface by ridge regression: the fast learner that compares sets of inputs and of
// thermometers. A fit takes milliseconds, and on the virtual gyro its held-out error is the noise floor
// (docs/evaluation.md).
//
// y ≈ b + Σ w_i z_i + Σ_{i≤j} w_ij z_i z_j (Box & Wilson, J. R. Stat. Soc. B 13 (1951) 1), minimising ‖y − ŷ‖² + λ n
// ‖w‖² with b free (Hoerl & Kennard, Technometrics 12 (1970) 55). z are the inputs standardised on the training rows;
// the products are standardised again. Columns that are constant on the training rows are not used.

/// The penalties λ that try_surface() chooses from.
inline constexpr std::array<double, 11> kSurfaceLambdas = {1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1, 10, 100};

/// Predicts the rows of `test_x` by surfaces with these λ, learnt from `train_x` and `train_y`: rows × λ. If x has no
/// column, the prediction is the mean of `train_y`. All values must be finite, λ > 0, and there must be a training row.
[[nodiscard]] Eigen::MatrixXd surface_predictions(const svm::SampleMatrix& train_x, const Eigen::VectorXd& train_y,
                                                  const svm::SampleMatrix& test_x, std::span<const double> lambdas);

/// Held-out accuracy of a surface with the λ that has the least held-out error.
struct SurfaceTrial {
  /// y − ŷ of each row, in the units of y; NaN for a row that is never held out.
  Eigen::VectorXd residual;
  double lambda{};
  /// Mean square of the finite residuals.
  double mean_square{};
};

/// Holds out each fold in turn. `x` and `y` have one row per cluster of the folds.
[[nodiscard]] SurfaceTrial try_surface(const svm::SampleMatrix& x, const Eigen::VectorXd& y,
                                       const data::FoldPlan& folds);

enum class SelectionKind {
  /// |r| with the bias above a threshold (paper §4.3).
  correlation,
  /// Adds inputs one at a time, each time the one that reduces the held-out error most.
  forward,
  redundancy,  ///< all that are linearly independent
};

/// Selection rule: a keyword and an optional number.
struct SelectionRule {
  SelectionKind kind = SelectionKind::correlation;
  double threshold = 0.90;  ///< for |r|
  /// Rule forward: greatest number of inputs.
  int most = 12;
  /// Rule redundancy: an input is redundant if less than this fraction of its STD is linearly independent of the
  /// others.
  double tolerance = 1e-6;
};

/// Parses "correlation", "correlation:0.85", "forward", "forward:6", "redundancy", "redundancy:0.01". Fails with usage.
[[nodiscard]] Result<SelectionRule> parse_selection(std::string_view text);

struct Selection {
  std::vector<data::Term> terms;
  /// Threshold of the rule correlation; 0 for other rules.
  double threshold = 0.90;
  int rank{};
  /// True if too few candidates exceeded the threshold. The candidates that are linearly independent of earlier ones
  /// are then used instead.
  bool fallback{};
  std::string statement;
};

/// Selects from the candidates by the rule, in addition to the fixed terms. Fails with usage if there is no candidate,
/// or if a term needs a thermometer that the clusters lack. All values must be finite.
[[nodiscard]] Result<Selection> select_inputs(const SelectionRule& rule, const std::vector<data::Term>& fixed,
                                              const std::vector<data::Term>& candidates,
                                              const data::TrainingSet& training_set);

/// Applies the rule correlation: selects the candidates with |r| > threshold, given each candidate's r. If they span
/// fewer dimensions than `least_rank`, selects the candidates that do not depend on earlier ones instead and sets
/// `fallback`; for all 28 gradients these are the differences with the first thermometer (errata 3.1).
[[nodiscard]] Selection select_by_correlation(const std::vector<data::Term>& candidates, const std::vector<double>& r,
                                              double threshold, int least_rank);

/// Applies the rule forward: adds the candidate whose response surface has the least held-out squared error, while that
/// error decreases and fewer than `most` are selected. Then keeps the smallest number of inputs with a mean squared
/// error within one standard error of the least (Breiman et al., Classification and Regression Trees, 1984, §3.4.3).
/// The standard error is computed from the effective number of squared residuals. A training set with fewer than two
/// folds is divided into blocks.
[[nodiscard]] Result<Selection> select_forward(const std::vector<data::Term>& fixed,
                                               const std::vector<data::Term>& candidates,
                                               const data::TrainingSet& training_set, int most);

/// Applies the rule redundancy: a QR decomposition with column pivoting of the standardised candidates, after
/// projecting out the fixed terms. Candidates are kept while more than the fraction `tolerance` of their STD is
/// independent. The other candidates are linear combinations of the kept and the fixed terms, within this fraction.
[[nodiscard]] Result<Selection> select_independent(const std::vector<data::Term>& fixed,
                                                   const std::vector<data::Term>& candidates,
                                                   const data::Clusters& training, double tolerance);

}  // namespace gyrotherm::model
