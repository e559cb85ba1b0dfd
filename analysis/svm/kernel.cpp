// SPDX-License-Identifier: Apache-2.0
#include "analysis/svm/kernel.hpp"

#include <algorithm>
#include <cassert>

#include "analysis/svm/gaussian_sum.hpp"
#include "analysis/svm/spanned.hpp"

namespace gyrotherm::svm {
namespace {

// Computes out_j = exp(scale Σ_k (x_jk − x_ik)²) for `count` samples. The values of input k for all samples begin at x
// + k · stride.
template <class Lanes, class Integers, class Real>
[[gnu::always_inline]] inline void make(const Real* x, Eigen::Index stride, Eigen::Index inputs, Eigen::Index i,
                                        Real scale, int count, Real* out) {
  constexpr int kLanes = sizeof(Lanes) / sizeof(Real);
  for (int j = 0; j < count; j += 2 * kLanes) {
    Lanes sum = {}, next = {};
    for (Eigen::Index k = 0; k < inputs; ++k) {
      const Real* input = x + k * stride;
      const Lanes apart = lanes_at<Lanes>(input + j).value - input[i];
      const Lanes apart_next = lanes_at<Lanes>(input + j + kLanes).value - input[i];
      sum += apart * apart;
      next += apart_next * apart_next;
    }
    sum *= scale;
    next *= scale;
    exponentiate<Real, Integers>(sum);
    exponentiate<Real, Integers>(next);
    lanes_at<Lanes>(out + j).value = sum;
    lanes_at<Lanes>(out + j + kLanes).value = next;
  }
}

template <class Registers>
[[gnu::always_inline]] inline void make_floats(const float* x, Eigen::Index stride, Eigen::Index inputs, Eigen::Index i,
                                               float scale, int count, float* out) {
  make<typename Registers::Floats, typename Registers::Indices>(x, stride, inputs, i, scale, count, out);
}
template <class Registers>
[[gnu::always_inline]] inline void make_doubles(const double* x, Eigen::Index stride, Eigen::Index inputs,
                                                Eigen::Index i, double scale, int count, double* out) {
  make<typename Registers::Doubles, typename Registers::Longs>(x, stride, inputs, i, scale, count, out);
}

#if GYROTHERM_HAS_VERSIONS
GYROTHERM_V4
void make_row(const float* x, Eigen::Index stride, Eigen::Index inputs, Eigen::Index i, float scale, int count,
              float* out) {
  make_floats<Registers64>(x, stride, inputs, i, scale, count, out);
}
GYROTHERM_V3
void make_row(const float* x, Eigen::Index stride, Eigen::Index inputs, Eigen::Index i, float scale, int count,
              float* out) {
  make_floats<Registers32>(x, stride, inputs, i, scale, count, out);
}
GYROTHERM_V4
void make_column(const double* x, Eigen::Index stride, Eigen::Index inputs, Eigen::Index i, double scale, int count,
                 double* out) {
  make_doubles<Registers64>(x, stride, inputs, i, scale, count, out);
}
GYROTHERM_V3
void make_column(const double* x, Eigen::Index stride, Eigen::Index inputs, Eigen::Index i, double scale, int count,
                 double* out) {
  make_doubles<Registers32>(x, stride, inputs, i, scale, count, out);
}
#endif

GYROTHERM_DEFAULT
void make_row(const float* x, Eigen::Index stride, Eigen::Index inputs, Eigen::Index i, float scale, int count,
              float* out) {
  make_floats<Registers16>(x, stride, inputs, i, scale, count, out);
}
GYROTHERM_DEFAULT
void make_column(const double* x, Eigen::Index stride, Eigen::Index inputs, Eigen::Index i, double scale, int count,
                 double* out) {
  make_doubles<Registers16>(x, stride, inputs, i, scale, count, out);
}

// Stores the coordinates in both precisions, padded with zeros to the length used by the hot loops.
void store_padded(const Eigen::MatrixXd& coordinates, Eigen::MatrixXd& doubles, Eigen::MatrixXf& singles) {
  const Eigen::Index size = coordinates.rows(), directions = coordinates.cols();
  doubles = Eigen::MatrixXd::Zero(padded_column(size), directions);
  singles = Eigen::MatrixXf::Zero(padded_row(size), directions);
  doubles.topRows(size) = coordinates;
  singles.topRows(size) = coordinates.cast<float>();
}

}  // namespace

Eigen::VectorXd gaussians_at(const Eigen::Ref<const SampleMatrix>& positions,
                             const Eigen::Ref<const SampleMatrix>& samples, double sigma, const Eigen::VectorXd& beta) {
  const std::vector<Eigen::Index> support = support_rows(beta);
  const auto count = static_cast<Eigen::Index>(support.size());
  const GaussianSum sum(samples(support, Eigen::all), Eigen::VectorXd::Constant(count, sigma), beta(support),
                        GaussianSum::Space::whole);
  return sum.at(positions);
}

GaussianSamples::GaussianSamples(const Eigen::Ref<const SampleMatrix>& x)
    : size_(x.rows()), coordinates_(project_to_span(x)) {
  store_padded(coordinates_, doubles_, singles_);
}

void GaussianSamples::compute_float_row(Eigen::Index i, double sigma, float* out) const {
  assert(0 <= i && i < size_);
  make_row(singles_.data(), singles_.rows(), singles_.cols(), i, static_cast<float>(-0.5 / (sigma * sigma)),
           static_cast<int>(singles_.rows()), out);
}

void GaussianSamples::compute_double_column(Eigen::Index i, double sigma, double* out) const {
  assert(0 <= i && i < size_);
  make_column(doubles_.data(), doubles_.rows(), doubles_.cols(), i, -0.5 / (sigma * sigma),
              static_cast<int>(doubles_.rows()), out);
}

Eigen::VectorXd GaussianSamples::response(double sigma, const Eigen::VectorXd& beta) const {
  return gaussian_response(coordinates_, sigma, beta);
}

float* KernelMemory::float_buffer(Eigen::Index n) {
  const std::size_t size = static_cast<std::size_t>(n) * padded_row(n);
  if (size > singles_size_) {
    singles_.reset();
    singles_ = std::make_unique_for_overwrite<float[]>(size);
    singles_size_ = size;
  }
  return singles_.get();
}

double* KernelMemory::column(Eigen::Index n, std::size_t k) {
  if (padded_column(n) > column_size_) {
    columns_.clear();
    column_size_ = padded_column(n);
  }
  while (columns_.size() <= k) columns_.push_back(std::make_unique_for_overwrite<double[]>(column_size_));
  return columns_[k].get();
}

std::size_t least_kernel_bytes(Eigen::Index n) {
  return static_cast<std::size_t>(n) * padded_row(n) * sizeof(float) +
         Kernel::kSpareColumns * padded_column(n) * sizeof(double);
}

Kernel::Kernel(const GaussianSamples& samples, double sigma, KernelMemory& memory, std::size_t column_bytes)
    : samples_(samples),
      sigma_(sigma),
      memory_(memory),
      row_stride_(padded_row(samples.size())),
      singles_(memory.float_buffer(samples.size())),
      has_row_(static_cast<std::size_t>(samples.size())),
      columns_(static_cast<std::size_t>(samples.size())),
      most_(std::max<std::size_t>(column_bytes / (sizeof(double) * padded_column(samples.size())), 1)) {}

const float* Kernel::row(Eigen::Index i) {
  float* row = singles_ + static_cast<std::size_t>(i) * row_stride_;
  if (has_row_[i] != 0) return row;
  samples_.compute_float_row(i, sigma_, row);
  has_row_[i] = 1;
  return row;
}

const double* Kernel::column(Eigen::Index i) {
  if (columns_[i] != nullptr) return columns_[i];
  if (made_ < most_) {
    double* made = memory_.column(size(), kSpareColumns + made_++);
    samples_.compute_double_column(i, sigma_, made);
    return columns_[i] = made;
  }
  double* spare = memory_.column(size(), spare_++ % kSpareColumns);
  samples_.compute_double_column(i, sigma_, spare);
  return spare;
}

Eigen::VectorXd Kernel::response(const Eigen::VectorXd& beta) const { return samples_.response(sigma_, beta); }

}  // namespace gyrotherm::svm
