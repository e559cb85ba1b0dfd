// SPDX-License-Identifier: Apache-2.0
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cassert>
#include <cmath>

#include "analysis/methods/held_out.hpp"
#include "analysis/methods/linear.hpp"

namespace gyrotherm::methods {
namespace {

constexpr int kFirstDecade = -8, kLastDecade = 2;

}  // namespace

RidgePath::RidgePath(const Eigen::Ref<const Eigen::MatrixXd>& z, const Eigen::Ref<const Eigen::VectorXd>& y)
    : z_mean_(z.colwise().mean()), y_mean_(y.mean()), samples_(static_cast<double>(z.rows())) {
  assert(z.rows() > 0 && z.cols() > 0 && z.rows() == y.size());
  // The triangle of a QR decomposition has the same singular values as the whole matrix and is much smaller.
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

Result<Choice> choose_ridge(std::span<const Fold> folds, const MethodOptions& options, const ProgressSink& progress) {
  std::vector<double> lambdas;
  for (int decade = kLastDecade; decade >= kFirstDecade; --decade) lambdas.push_back(std::pow(10.0, decade));
  const Trial predict_path = [&](const Fold& fold, std::size_t) -> Result<Eigen::MatrixXd> {
    const RidgePath path(fold.train_x, fold.train_y);
    Eigen::MatrixXd predicted(fold.test_x.rows(), static_cast<Eigen::Index>(lambdas.size()));
    for (Eigen::Index i = 0; i < predicted.cols(); ++i) {
      const Eigen::VectorXd weights = path.weights(lambdas[i]);
      predicted.col(i) = (fold.test_x * weights).array() + path.offset(weights);
    }
    return predicted;
  };
  const auto errors = held_out_errors(folds, 1, predict_path, options, progress);
  if (!errors) return failure(errors.error());
  Choice choice;
  choice.parameters = {{"lambda", lambdas[find_least(*errors).candidate]}};
  return choice;
}

Result<Fit> fit_ridge(const FitInput& set, const HyperParameters& parameters, const MethodOptions&) {
  if (const auto sound = check_set(set, 2); !sound) return failure(sound.error());
  const double lambda = parameter_value(parameters, "lambda");
  const RidgePath path(set.x, set.y);
  const Eigen::VectorXd weights = path.weights(lambda);
  const Eigen::MatrixXd penalty =
      std::sqrt(lambda * static_cast<double>(set.x.rows())) * Eigen::MatrixXd::Identity(set.x.cols(), set.x.cols());
  return make_plane_fit(set, {.weights = weights, .b = path.offset(weights)}, path.effective_parameters(lambda),
                        penalty);
}

}  // namespace gyrotherm::methods
