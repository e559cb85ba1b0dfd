#include "analysis/svm/gaussian_samples.hpp"

#include <Eigen/QR>
#include <cassert>

#include "analysis/svm/lanes_exp.hpp"

namespace gyrotherm {
namespace {

// out_j = exp(scale Σ_k (x_jk − x_ik)²) for `count` places; input k of all samples begins at x + k stride.
GYROTHERM_CLONES
void make_row(const float* x, Eigen::Index stride, Eigen::Index inputs, Eigen::Index i, float scale, int count,
              float* out) {
  for (int j = 0; j < count; j += 2 * kFloatLanes) {
    FloatLanes sum = {}, next = {};
    for (Eigen::Index k = 0; k < inputs; ++k) {
      const float* input = x + k * stride;
      const FloatLanes apart = *reinterpret_cast<const UnalignedFloatLanes*>(input + j) - input[i];
      const FloatLanes apart_next = *reinterpret_cast<const UnalignedFloatLanes*>(input + j + kFloatLanes) - input[i];
      sum += apart * apart;
      next += apart_next * apart_next;
    }
    sum *= scale;
    next *= scale;
    exponentiate_lanes(sum);
    exponentiate_lanes(next);
    *reinterpret_cast<UnalignedFloatLanes*>(out + j) = sum;
    *reinterpret_cast<UnalignedFloatLanes*>(out + j + kFloatLanes) = next;
  }
}

GYROTHERM_CLONES
void make_column(const double* x, Eigen::Index stride, Eigen::Index inputs, Eigen::Index i, double scale, int from,
                 int count, double* out) {
  for (int j = from; j < count; j += 2 * kDoubleLanes) {
    DoubleLanes sum = {}, next = {};
    for (Eigen::Index k = 0; k < inputs; ++k) {
      const double* input = x + k * stride;
      const DoubleLanes apart = *reinterpret_cast<const UnalignedDoubleLanes*>(input + j) - input[i];
      const DoubleLanes apart_next =
          *reinterpret_cast<const UnalignedDoubleLanes*>(input + j + kDoubleLanes) - input[i];
      sum += apart * apart;
      next += apart_next * apart_next;
    }
    sum *= scale;
    next *= scale;
    exponentiate_lanes(sum);
    exponentiate_lanes(next);
    *reinterpret_cast<UnalignedDoubleLanes*>(out + j) = sum;
    *reinterpret_cast<UnalignedDoubleLanes*>(out + j + kDoubleLanes) = next;
  }
}

// Directions in which the samples reach less than this part of their greatest reach are not theirs.
constexpr double kFlatSamples = 1e-13;

// The samples in coordinates of the space that they span about their mean: the same distances from fewer numbers where
// inputs depend on each other, as all differences of eight thermometers do.
Eigen::MatrixXd spanned(const Eigen::Ref<const GaussianSamples::Matrix>& x) {
  if (x.rows() == 0) return x;
  const GaussianSamples::Matrix centred = x.rowwise() - x.colwise().mean();
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr;
  qr.setThreshold(kFlatSamples);
  qr.compute(centred.transpose());
  const Eigen::Index rank = qr.rank();
  if (rank == x.cols()) return x;
  Eigen::MatrixXd basis = Eigen::MatrixXd::Identity(x.cols(), rank);
  basis.applyOnTheLeft(qr.householderQ());
  return centred * basis;
}

}  // namespace

GaussianSamples::GaussianSamples(const Eigen::Ref<const Matrix>& x) : size_(x.rows()) {
  const Eigen::MatrixXd coordinates = spanned(x);
  doubles_ = Eigen::MatrixXd::Zero(padded_column(size_), coordinates.cols());
  singles_ = Eigen::MatrixXf::Zero(padded_row(size_), coordinates.cols());
  doubles_.topRows(size_) = coordinates;
  singles_.topRows(size_) = coordinates.cast<float>();
}

void GaussianSamples::single_row(Eigen::Index i, double sigma, float* out) const {
  assert(0 <= i && i < size_);
  make_row(singles_.data(), singles_.rows(), singles_.cols(), i, static_cast<float>(-0.5 / (sigma * sigma)),
           static_cast<int>(singles_.rows()), out);
}

void GaussianSamples::double_column(Eigen::Index i, double sigma, double* out, Eigen::Index from) const {
  assert(0 <= i && i < size_ && from % kColumnStep == 0);
  make_column(doubles_.data(), doubles_.rows(), doubles_.cols(), i, -0.5 / (sigma * sigma), static_cast<int>(from),
              static_cast<int>(doubles_.rows()), out);
}

}  // namespace gyrotherm
