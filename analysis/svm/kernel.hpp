// SPDX-License-Identifier: Apache-2.0
/// Makes the Gaussian kernel matrix of a training set row by row as the solvers ask for it, and keeps what it has made.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "analysis/svm/lanes.hpp"
#include "analysis/svm/svr.hpp"

namespace gyrotherm::svm {

/// n rounded up to what a row of floats, or a column of doubles, takes in the hot loops.
[[nodiscard]] inline int padded_row(Eigen::Index n) {
  constexpr int kStep = 2 * kFloatLanes;
  return (static_cast<int>(n) + kStep - 1) / kStep * kStep;
}
inline constexpr int kColumnStep = 2 * kDoubleLanes;
[[nodiscard]] inline int padded_column(Eigen::Index n) {
  return (static_cast<int>(n) + kColumnStep - 1) / kColumnStep * kColumnStep;
}

/// Σ_i β_i exp(−‖x_i − z_j‖²/(2σ²)) at each place z_j, from the non-zero β alone; both in coordinates that are
/// `spanned`.
[[nodiscard]] Eigen::VectorXd gaussians_at(const Eigen::Ref<const SampleMatrix>& places,
                                           const Eigen::Ref<const SampleMatrix>& samples, double sigma,
                                           const Eigen::VectorXd& beta);

/// Samples laid out so that rows of their Gaussian kernel matrix are made fast, in single or double precision.
class GaussianSamples {
 public:
  /// Lays out a training set; its rows are samples.
  explicit GaussianSamples(const Eigen::Ref<const SampleMatrix>& x);
  [[nodiscard]] Eigen::Index size() const { return size_; }

  /// Makes exp(−‖x_i − x_j‖²/(2σ²)) for all j in single precision, from the differences themselves: 1 where rows are
  /// equal. Relative error of a few 1e-7 where the exponent is small; `out` has padded_row(size()) places.
  void single_row(Eigen::Index i, double sigma, float* out) const;
  /// Makes the same in double precision, to a few 1e-16 where inputs are independent, else of the largest exponent;
  /// `out` has padded_column(size()) places.
  void double_column(Eigen::Index i, double sigma, double* out) const;
  /// Σ_i β_i exp(−‖x_i − x_j‖²/(2σ²)) for all j, from the non-zero β alone, as exact as a GaussianSum.
  [[nodiscard]] Eigen::VectorXd response(double sigma, const Eigen::VectorXd& beta) const;

 private:
  Eigen::Index size_;
  SampleMatrix places_;
  Eigen::MatrixXf singles_;  // a column per direction in which the samples differ, padded with zeros
  Eigen::MatrixXd doubles_;
};

/// Memory that trainings hand on to each other, so that none of it is asked of the system anew. Not shared by threads.
class KernelMemory {
 public:
  /// Gives room for a matrix of n points in single precision, uninitialised.
  [[nodiscard]] float* singles(Eigen::Index n);
  /// Gives room for the k-th column of n points in double precision, uninitialised.
  [[nodiscard]] double* column(Eigen::Index n, std::size_t k);

 private:
  std::unique_ptr<float[]> singles_;
  std::size_t singles_size_ = 0;
  std::vector<std::unique_ptr<double[]>> columns_;
  Eigen::Index column_size_ = 0;
};

/// The bytes that a training of n points needs at least: with no column kept.
[[nodiscard]] std::size_t least_kernel_bytes(Eigen::Index n);

/// The kernel matrix K_ij = exp(−‖x_i − x_j‖²/(2σ²)) of one training: its rows in single and its columns in double
/// precision are made when they are first asked for, and kept.
///
/// Memory: 4n² bytes of rows at most, and columns up to `column_bytes`; a column beyond that is made anew each time it
/// is asked for.
class Kernel {
 public:
  /// The samples and the memory outlive it.
  Kernel(const GaussianSamples& samples, double sigma, KernelMemory& memory, std::size_t column_bytes);
  [[nodiscard]] Eigen::Index size() const { return samples_.size(); }
  /// Row i in single precision.
  [[nodiscard]] const float* row(Eigen::Index i);
  /// Column i in double precision; valid until kSpare more columns have been asked for.
  [[nodiscard]] const double* column(Eigen::Index i);
  /// The response Kβ of all points in double precision, made from the non-zero β alone and from no row or column.
  [[nodiscard]] Eigen::VectorXd response(const Eigen::VectorXd& beta) const;

  static constexpr int kSpare = 8;

 private:
  const GaussianSamples& samples_;
  double sigma_;
  KernelMemory& memory_;
  int row_stride_;
  float* singles_;
  std::vector<char> has_row_;
  std::vector<const double*> columns_;  // null: not made yet
  std::size_t made_ = 0;
  std::size_t most_;
  std::size_t spare_ = 0;
};

}  // namespace gyrotherm::svm
