/// Where the solvers take the kernel matrix from, and the memory that they keep of it.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "analysis/svm/gaussian_samples.hpp"

namespace gyrotherm {

/// A symmetric kernel matrix that gives its rows in single precision and its columns in double.
class KernelSource {
 public:
  virtual ~KernelSource() = default;
  [[nodiscard]] virtual Eigen::Index size() const = 0;
  /// `out` holds padded_row(size()) floats; what lies beyond size() becomes finite, and means nothing.
  virtual void single_row(Eigen::Index i, float* out) const = 0;
  /// `out` holds padded_column(size()) doubles, likewise; those before `from`, a multiple of kColumnStep, are left.
  virtual void double_column(Eigen::Index i, Eigen::Index from, double* out) const = 0;
  /// A column that lies in memory already, or null.
  [[nodiscard]] virtual const double* stored_column(Eigen::Index) const { return nullptr; }
};

/// exp(−‖x_i − x_j‖²/(2σ²)) of a training set that outlives it.
class GaussianSource final : public KernelSource {
 public:
  GaussianSource(const GaussianSamples& samples, double sigma) : samples_(samples), sigma_(sigma) {}
  [[nodiscard]] Eigen::Index size() const override { return samples_.size(); }
  void single_row(Eigen::Index i, float* out) const override { samples_.single_row(i, sigma_, out); }
  void double_column(Eigen::Index i, Eigen::Index from, double* out) const override {
    samples_.double_column(i, sigma_, out, from);
  }

 private:
  const GaussianSamples& samples_;
  double sigma_;
};

/// A matrix that is there already, and outlives it.
class MatrixSource final : public KernelSource {
 public:
  explicit MatrixSource(const Eigen::Ref<const Eigen::MatrixXd>& matrix) : matrix_(matrix) {}
  [[nodiscard]] Eigen::Index size() const override { return matrix_.cols(); }
  void single_row(Eigen::Index i, float* out) const override;
  void double_column(Eigen::Index i, Eigen::Index from, double* out) const override;
  [[nodiscard]] const double* stored_column(Eigen::Index i) const override { return matrix_.col(i).data(); }

 private:
  const Eigen::Ref<const Eigen::MatrixXd>& matrix_;
};

/// Memory that trainings hand on to each other, so that none of it is asked of the system anew. Not shared by threads.
class KernelMemory {
 public:
  /// Room for a matrix of n points in single precision, uninitialised.
  [[nodiscard]] float* singles(Eigen::Index n);
  /// The k-th column of n points in double precision, uninitialised.
  [[nodiscard]] double* column(Eigen::Index n, std::size_t k);

 private:
  std::unique_ptr<float[]> singles_;
  std::size_t singles_size_ = 0;
  std::vector<std::unique_ptr<double[]>> columns_;
  Eigen::Index column_size_ = 0;
};

/// Of n points, without any column kept.
[[nodiscard]] std::size_t least_kernel_bytes(Eigen::Index n);

/// Rows and columns made when they are first asked for, and kept.
///
/// Memory: 4n² bytes of rows at most, and columns up to `column_bytes`; a column beyond that is made anew each time it
/// is asked for.
class Kernel {
 public:
  Kernel(const KernelSource& source, KernelMemory& memory, std::size_t column_bytes);
  [[nodiscard]] Eigen::Index size() const { return source_.size(); }
  [[nodiscard]] int row_stride() const { return row_stride_; }
  /// Row i in single precision.
  [[nodiscard]] const float* row(Eigen::Index i);
  /// Column i in double precision; valid until kSpare more columns have been asked for.
  [[nodiscard]] const double* column(Eigen::Index i);
  /// Column i from place `from`, a multiple of kColumnStep, on; made for this call alone, with its first places left
  /// undefined. The caller may write to it. Valid until kSpare more columns have been asked for.
  [[nodiscard]] double* passing_column(Eigen::Index i, Eigen::Index from);

  static constexpr int kSpare = 8;

 private:
  const KernelSource& source_;
  KernelMemory& memory_;
  int row_stride_;
  float* singles_;
  std::vector<char> has_row_;
  std::vector<const double*> columns_;  // null: not made yet
  std::size_t made_ = 0;
  std::size_t most_;
  std::size_t spare_ = 0;
};

}  // namespace gyrotherm
