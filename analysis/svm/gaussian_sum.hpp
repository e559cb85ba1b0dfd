// SPDX-License-Identifier: Apache-2.0
/// Sums of Gaussians: at many points, which is what a support vector machine or a radial network predicts, and at their
/// own centres, which is the response of a training set to its β.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "analysis/svm/gaussian_loops.hpp"
#include "analysis/svm/svr.hpp"

namespace gyrotherm::svm {

/// Exponents of Gaussians come from products while ½log₂e (‖z‖ + ‖c‖)²/s² is at most this: rounding then leaves 1e-12
/// of a term in the worst case.
inline constexpr double kLargestProduct = 256;

/// f(z) = Σ_j w_j exp(−‖z − c_j‖²/(2 s_j²)), made ready for many z.
///
/// Centres are turned into the coordinates of the space that they span, which is exact and pays where inputs depend on
/// each other: thirteen gradients of eight thermometers span seven dimensions. A point's distance from that space is
/// one coordinate more.
///
/// Exponents come from products, ‖z‖² + ‖c‖² − 2zc, while that cancels little, else from the differences z − c. Against
/// the formula the error is below 1e-11 Σ|w_j|; about 1e-16 Σ|w_j| is usual.
class GaussianSum {
 public:
  /// Whether to look for the space that the centres span, or to take all inputs for it, which is right as well.
  enum class Space { spanned, whole };

  /// `centres` has one row per centre; `widths` s (> 0) and `weights` w one number each. All finite.
  GaussianSum(const Eigen::Ref<const SampleMatrix>& centres, const Eigen::Ref<const Eigen::VectorXd>& widths,
              const Eigen::Ref<const Eigen::VectorXd>& weights, Space space = Space::spanned);

  /// f at each row of `points`, by these loops, to the bit the same whatever rows stand beside it; NaN where the row is
  /// not finite. Takes a few kB of scratch, however many rows.
  [[nodiscard]] Eigen::VectorXd at(const Eigen::Ref<const SampleMatrix>& points,
                                   const GaussianLoops& loops = gaussian_loops()) const;

  /// The dimensions that the centres span.
  [[nodiscard]] Eigen::Index dimensions() const { return rank_; }

 private:
  struct Places;
  /// The centres as both loops want them.
  struct Blocks {
    std::vector<double> by_products, by_differences;
    std::unique_ptr<bool[]> negative;  ///< one for each block: its weights are
    Eigen::Index count{};
  };
  void span(const Eigen::MatrixXd& centred);
  void pack(const Eigen::MatrixXd& places, const Eigen::VectorXd& scales, const Eigen::VectorXd& weights);
  void pack_centre(Eigen::Index slot, const Eigen::Ref<const Eigen::RowVectorXd>& place, double a, double logarithm);
  void pack_nothing(Eigen::Index slot);
  void place(const Eigen::Ref<const SampleMatrix>& points, Places& places) const;
  void add(const GaussianLoops& loops, Places& places) const;
  [[nodiscard]] Eigen::Index product_dimensions() const { return one_width_ ? rank_ : rank_ + 1; }
  [[nodiscard]] Eigen::Index product_block() const { return (1 + product_dimensions()) * kGaussianBlock; }
  [[nodiscard]] Eigen::Index difference_block() const { return (2 + rank_ + 1) * kGaussianBlock; }

  Eigen::Index inputs_;
  Eigen::Index rank_{};
  Eigen::RowVectorXd mean_;
  Eigen::MatrixXd basis_;  ///< inputs × rank, orthonormal; empty if the centres span the whole space
  bool one_width_{};
  double scale_{};        ///< −log₂e/(2s²), the largest in size
  double radius_{};       ///< of the farthest centre from the mean
  double weight_unit_{};  ///< the largest |w|
  Blocks blocks_;
};

/// Σ_j β_j exp(−‖x_i − x_j‖²/(2σ²)) at each sample x_i, a row of `x` in coordinates that are `spanned`, from the
/// non-zero β alone. Against the formula the error is below 1e-11 Σ|β_j|, as of a GaussianSum, which takes its place
/// where samples lie too far apart for products. Each pair's Gaussian is computed once.
[[nodiscard]] Eigen::VectorXd gaussian_response(const Eigen::Ref<const SampleMatrix>& x, double sigma,
                                                const Eigen::VectorXd& beta,
                                                const GaussianLoops& loops = gaussian_loops());

}  // namespace gyrotherm::svm
