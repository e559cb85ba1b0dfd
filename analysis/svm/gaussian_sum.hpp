// SPDX-License-Identifier: Apache-2.0
/// Sums of Gaussians at many points, which are the predictions of a support vector machine or a radial network, and
/// sums at their own centres, which are the response of a training set to its β.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "analysis/svm/gaussian_loops.hpp"
#include "analysis/svm/svr.hpp"

namespace gyrotherm::svm {

/// Limit of ½log₂e (‖z‖ + ‖c‖)²/s² up to which exponents are computed from products. Rounding errors are then at most
/// 1e-12 of a term.
inline constexpr double kLargestProduct = 256;

/// Sum of Gaussians f(z) = Σ_j w_j exp(−‖z − c_j‖²/(2 s_j²)), prepared for evaluation at many z.
///
/// Centres are transformed to coordinates of the space they span. The transformation is exact and saves time if inputs
/// depend on each other: thirteen gradients of eight thermometers span seven dimensions. The distance of a point from
/// that space is one more coordinate.
///
/// Exponents are computed from products, ‖z‖² + ‖c‖² − 2zc, if cancellation is small, and otherwise from the
/// differences z − c. The error relative to the formula is below 1e-11 Σ|w_j| and usually about 1e-16 Σ|w_j|.
class GaussianSum {
 public:
  /// Coordinates used for the centres: those of the space that they span, or all inputs. Both give a correct sum.
  enum class Space { spanned, whole };

  /// Prepares the sum. `centres` has one row per centre; `widths` s (> 0) and `weights` w have one number per centre.
  /// All must be finite.
  GaussianSum(const Eigen::Ref<const SampleMatrix>& centres, const Eigen::Ref<const Eigen::VectorXd>& widths,
              const Eigen::Ref<const Eigen::VectorXd>& weights, Space space = Space::spanned);

  /// Computes f at each row of `points` with the given loops. The result for a row is bit-identical regardless of the
  /// other rows. NaN if the row is not finite. Uses a few kB of scratch memory for any number of rows.
  [[nodiscard]] Eigen::VectorXd at(const Eigen::Ref<const SampleMatrix>& points,
                                   const GaussianLoops& loops = gaussian_loops()) const;

  /// Returns the number of dimensions that the centres span.
  [[nodiscard]] Eigen::Index dimensions() const { return rank_; }

 private:
  struct PointState;
  /// Centres in the layouts of both loops.
  struct Blocks {
    std::vector<double> by_products, by_differences;
    /// One flag per block: its weights are negative.
    std::unique_ptr<bool[]> negative;
    Eigen::Index count{};
  };
  void span(const Eigen::MatrixXd& centred);
  void pack(const Eigen::MatrixXd& coordinates, const Eigen::VectorXd& scales, const Eigen::VectorXd& weights);
  void pack_centre(Eigen::Index slot, const Eigen::Ref<const Eigen::RowVectorXd>& coordinates, double a,
                   double logarithm);
  void pack_nothing(Eigen::Index slot);
  void project(const Eigen::Ref<const SampleMatrix>& points, PointState& state) const;
  void add(const GaussianLoops& loops, PointState& state) const;
  [[nodiscard]] Eigen::Index product_dimensions() const { return one_width_ ? rank_ : rank_ + 1; }
  [[nodiscard]] Eigen::Index product_block() const { return (1 + product_dimensions()) * kGaussianBlock; }
  [[nodiscard]] Eigen::Index difference_block() const { return (2 + rank_ + 1) * kGaussianBlock; }

  Eigen::Index inputs_;
  Eigen::Index rank_{};
  Eigen::RowVectorXd mean_;
  /// inputs × rank, orthonormal. Empty if the centres span the whole space.
  Eigen::MatrixXd basis_;
  bool one_width_{};
  /// −log₂e/(2s²) with the largest magnitude.
  double scale_{};
  /// Distance of the farthest centre from the mean.
  double radius_{};
  /// Largest |w|.
  double weight_unit_{};
  Blocks blocks_;
};

/// Computes Σ_j β_j exp(−‖x_i − x_j‖²/(2σ²)) at each sample x_i, using only the non-zero β. Samples are the rows of
/// `x`, in coordinates returned by `project_to_span`. The Gaussian of each pair is computed once. The error relative to
/// the formula is below 1e-11 Σ|β_j|, as for a GaussianSum. If samples are too far apart for exponents by products, the
/// function evaluates a GaussianSum.
[[nodiscard]] Eigen::VectorXd gaussian_response(const Eigen::Ref<const SampleMatrix>& x, double sigma,
                                                const Eigen::VectorXd& beta,
                                                const GaussianLoops& loops = gaussian_loops());

}  // namespace gyrotherm::svm
