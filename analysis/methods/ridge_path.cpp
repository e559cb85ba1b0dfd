#include "analysis/methods/ridge_path.hpp"

#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cassert>

namespace gyrotherm {

RidgePath::RidgePath(const Eigen::Ref<const Eigen::MatrixXd>& z, const Eigen::Ref<const Eigen::VectorXd>& y)
    : z_mean_(z.colwise().mean()), y_mean_(y.mean()), samples_(static_cast<double>(z.rows())) {
  assert(z.rows() > 0 && z.cols() > 0 && z.rows() == y.size());
  // The triangle of a QR has the singular values of the whole and is far smaller.
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(z.rowwise() - z_mean_);
  const Eigen::Index rank = std::min(z.rows(), z.cols());
  const Eigen::MatrixXd triangle = qr.matrixQR().topRows(rank).triangularView<Eigen::Upper>();
  const Eigen::VectorXd rotated = qr.householderQ().transpose() * (y.array() - y_mean_).matrix();
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(triangle, Eigen::ComputeThinU | Eigen::ComputeThinV);
  singular_ = svd.singularValues();
  right_ = svd.matrixV();
  target_ = svd.matrixU().transpose() * rotated.head(rank);
}

Eigen::VectorXd RidgePath::weights(double lambda) const {
  assert(lambda > 0);
  return right_ * (singular_.array() / (singular_.array().square() + lambda * samples_) * target_.array()).matrix();
}

double RidgePath::offset(const Eigen::VectorXd& weights) const { return y_mean_ - z_mean_ * weights; }

double RidgePath::effective_parameters(double lambda) const {
  const Eigen::ArrayXd squares = singular_.array().square();
  return 1 + (squares / (squares + lambda * samples_)).sum();
}

}  // namespace gyrotherm
