// SPDX-License-Identifier: Apache-2.0
/// Gaussian kernel matrix of a training set. Its rows are computed when the solvers request them, and are cached.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "analysis/svm/lanes.hpp"
#include "analysis/svm/svr.hpp"

namespace gyrotherm::svm {

/// Returns n rounded up to the length of a row of floats, or of a column of doubles, in the hot loops.
[[nodiscard]] inline int padded_row(Eigen::Index n) {
  constexpr int kStep = 2 * kFloatLanes;
  return (static_cast<int>(n) + kStep - 1) / kStep * kStep;
}
inline constexpr int kColumnStep = 2 * kDoubleLanes;
[[nodiscard]] inline int padded_column(Eigen::Index n) {
  return (static_cast<int>(n) + kColumnStep - 1) / kColumnStep * kColumnStep;
}

/// Computes Σ_i β_i exp(−‖x_i − z_j‖²/(2σ²)) at each position z_j, using only the non-zero β. Samples and positions are
/// in coordinates returned by `project_to_span`.
[[nodiscard]] Eigen::VectorXd gaussians_at(const Eigen::Ref<const SampleMatrix>& positions,
                                           const Eigen::Ref<const SampleMatrix>& samples, double sigma,
                                           const Eigen::VectorXd& beta);

/// Samples in a layout for fast computation of rows of their Gaussian kernel matrix in single or double precision.
class GaussianSamples {
 public:
  /// Lays out a training set, one sample per row.
  explicit GaussianSamples(const Eigen::Ref<const SampleMatrix>& x);
  [[nodiscard]] Eigen::Index size() const { return size_; }

  /// Computes exp(−‖x_i − x_j‖²/(2σ²)) for all j in single precision. Uses the differences x_i − x_j, so the result is
  /// exactly 1 for equal samples. The relative error is a few 1e-7 where the exponent is small. `out` has
  /// padded_row(size()) elements.
  void compute_float_row(Eigen::Index i, double sigma, float* out) const;
  /// Computes the same values in double precision. The relative error is a few 1e-16 if the inputs are independent. If
  /// inputs depend on each other, the error of an exponent is a few 1e-16 of the largest exponent. `out` has
  /// padded_column(size()) elements.
  void compute_double_column(Eigen::Index i, double sigma, double* out) const;
  /// Computes Σ_i β_i exp(−‖x_i − x_j‖²/(2σ²)) for all j, using only the non-zero β, with the accuracy of a
  /// GaussianSum.
  [[nodiscard]] Eigen::VectorXd response(double sigma, const Eigen::VectorXd& beta) const;

 private:
  Eigen::Index size_;
  SampleMatrix coordinates_;
  // One column per direction in which the samples differ, padded with zeros.
  Eigen::MatrixXf singles_;
  Eigen::MatrixXd doubles_;
};

/// Memory that several trainings reuse, which avoids an allocation for each of them. Must not be shared between
/// threads.
class KernelMemory {
 public:
  /// Returns uninitialised memory for a matrix of n points in single precision.
  [[nodiscard]] float* float_buffer(Eigen::Index n);
  /// Returns uninitialised memory for the k-th column of n points in double precision.
  [[nodiscard]] double* column(Eigen::Index n, std::size_t k);

 private:
  std::unique_ptr<float[]> singles_;
  std::size_t singles_size_ = 0;
  std::vector<std::unique_ptr<double[]>> columns_;
  Eigen::Index column_size_ = 0;
};

/// Returns the minimum number of bytes for a training with n points, in which no column is cached.
[[nodiscard]] std::size_t least_kernel_bytes(Eigen::Index n);

/// Kernel matrix K_ij = exp(−‖x_i − x_j‖²/(2σ²)) of one training. Rows in single and columns in double precision are
/// computed on first use and cached.
///
/// Rows take at most 4n² bytes, and cached columns at most `column_bytes`. Columns that do not fit are recomputed on
/// each use.
class Kernel {
 public:
  /// Makes the kernel. The samples and the memory must outlive it.
  Kernel(const GaussianSamples& samples, double sigma, KernelMemory& memory, std::size_t column_bytes);
  [[nodiscard]] Eigen::Index size() const { return samples_.size(); }
  /// Returns row i in single precision.
  [[nodiscard]] const float* row(Eigen::Index i);
  /// Returns column i in double precision. The column is valid until kSpareColumns more columns have been requested.
  [[nodiscard]] const double* column(Eigen::Index i);
  /// Computes the response Kβ of all points in double precision, using only the non-zero β. Does not use the cached
  /// rows and columns.
  [[nodiscard]] Eigen::VectorXd response(const Eigen::VectorXd& beta) const;

  static constexpr int kSpareColumns = 8;

 private:
  const GaussianSamples& samples_;
  double sigma_;
  KernelMemory& memory_;
  int row_stride_;
  float* singles_;
  std::vector<char> has_row_;
  // null: not computed yet
  std::vector<const double*> columns_;
  std::size_t made_ = 0;
  std::size_t most_;
  std::size_t spare_ = 0;
};

}  // namespace gyrotherm::svm
