#include <cassert>
#include <cstddef>

#include "analysis/svm/lanes.hpp"
#include "analysis/svm/svr.hpp"
#include "analysis/svm/vector_exp.hpp"

namespace gyrotherm {
namespace {

GYROTHERM_CLONES
void add_squared_differences(const double* values, double value, Eigen::Index count, double* sum) {
  for (Eigen::Index i = 0; i < count; ++i) sum[i] += (values[i] - value) * (values[i] - value);
}

// ‖a_i − b_j‖² from the differences themselves, so that equal rows are exactly 0 apart.
Eigen::MatrixXd squared_distances(const Eigen::Ref<const SampleMatrix>& a, const Eigen::Ref<const SampleMatrix>& b) {
  const Eigen::MatrixXd columns = a;
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(a.rows(), b.rows());
  for (Eigen::Index j = 0; j < b.rows(); ++j) {
    for (Eigen::Index k = 0; k < b.cols(); ++k) {
      add_squared_differences(columns.col(k).data(), b(j, k), a.rows(), sum.col(j).data());
    }
  }
  return sum;
}

void to_kernel(const Eigen::MatrixXd& squared, double sigma, Eigen::MatrixXd& out) {
  out.resizeLike(squared);
  exponentiate(squared.data(), squared.size(), -0.5 / (sigma * sigma), out.data());
}

}  // namespace

SquaredDistances::SquaredDistances(const Eigen::Ref<const SampleMatrix>& x) : SquaredDistances(x, x) {}

SquaredDistances::SquaredDistances(const Eigen::Ref<const SampleMatrix>& a, const Eigen::Ref<const SampleMatrix>& b)
    : d2_(squared_distances(a, b)) {}

void SquaredDistances::kernel(double sigma, Eigen::MatrixXd& out) const { to_kernel(d2_, sigma, out); }

Eigen::MatrixXd SquaredDistances::kernel(double sigma) const {
  Eigen::MatrixXd out;
  kernel(sigma, out);
  return out;
}

Eigen::MatrixXd gaussian_kernel(const Eigen::Ref<const SampleMatrix>& a, const Eigen::Ref<const SampleMatrix>& b,
                                double sigma) {
  assert(a.cols() == b.cols());
  Eigen::MatrixXd out = squared_distances(a, b);
  to_kernel(out, sigma, out);
  return out;
}

}  // namespace gyrotherm
