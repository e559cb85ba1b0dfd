/// Samples laid out so that rows of their Gaussian kernel matrix are made fast, in single or double precision.
#pragma once

#include <Eigen/Core>

#include "analysis/svm/lanes.hpp"

namespace gyrotherm {

/// n rounded up to what a row of floats, or a column of doubles, takes in the hot loops.
[[nodiscard]] inline int padded_row(Eigen::Index n) {
  constexpr int kStep = 2 * kFloatLanes;
  return (static_cast<int>(n) + kStep - 1) / kStep * kStep;
}
inline constexpr int kColumnStep = 2 * kDoubleLanes;
[[nodiscard]] inline int padded_column(Eigen::Index n) {
  return (static_cast<int>(n) + kColumnStep - 1) / kColumnStep * kColumnStep;
}

class GaussianSamples {
 public:
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  /// Rows are samples.
  explicit GaussianSamples(const Eigen::Ref<const Matrix>& x);
  [[nodiscard]] Eigen::Index size() const { return size_; }

  /// exp(−‖x_i − x_j‖²/(2σ²)) for all j, from the differences themselves: 1 where rows are equal. Relative error of a
  /// few 1e-7 where the exponent is small; `out` has padded_row(size()) places.
  void single_row(Eigen::Index i, double sigma, float* out) const;
  /// The same to a few 1e-16 where inputs are independent, else of the largest exponent; `out` has
  /// padded_column(size()) places, and those before `from`, a multiple of kColumnStep, are left as they are.
  void double_column(Eigen::Index i, double sigma, double* out, Eigen::Index from = 0) const;

 private:
  Eigen::Index size_;
  Eigen::MatrixXf singles_;  // a column per direction in which the samples differ, padded with zeros
  Eigen::MatrixXd doubles_;
};

}  // namespace gyrotherm
