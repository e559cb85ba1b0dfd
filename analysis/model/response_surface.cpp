// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/response_surface.hpp"

#include <Eigen/Eigenvalues>
#include <cassert>
#include <cmath>
#include <limits>

namespace gyrotherm::model {
namespace {

/// Mean and 1/STD of each column; 0 in place of 1/STD where a column does not vary.
struct Standard {
  explicit Standard(const svm::SampleMatrix& values)
      : mean(values.colwise().mean()), inverse_std(Eigen::RowVectorXd::Zero(values.cols())) {
    constexpr double kRounding = 1e-12;
    for (Eigen::Index j = 0; j < values.cols(); ++j) {
      const double std =
          std::sqrt((values.col(j).array() - mean(j)).square().sum() / static_cast<double>(values.rows()));
      if (std > kRounding * values.col(j).cwiseAbs().maxCoeff()) inverse_std(j) = 1 / std;
    }
  }
  [[nodiscard]] svm::SampleMatrix of(const svm::SampleMatrix& values) const {
    return ((values.rowwise() - mean).array().rowwise() * inverse_std.array()).matrix();
  }
  Eigen::RowVectorXd mean, inverse_std;
};

/// z_i, then z_i z_j for i ≤ j.
svm::SampleMatrix second_order(const svm::SampleMatrix& z) {
  const Eigen::Index inputs = z.cols();
  svm::SampleMatrix all(z.rows(), inputs + inputs * (inputs + 1) / 2);
  all.leftCols(inputs) = z;
  Eigen::Index column = inputs;
  for (Eigen::Index i = 0; i < inputs; ++i) {
    const Eigen::Index products = inputs - i;
    all.middleCols(column, products) = z.rightCols(products).array().colwise() * z.col(i).array();
    column += products;
  }
  return all;
}

}  // namespace

Eigen::MatrixXd surface_predictions(const svm::SampleMatrix& train_x, const Eigen::VectorXd& train_y,
                                    const svm::SampleMatrix& test_x, std::span<const double> lambdas) {
  assert(train_x.rows() == train_y.size() && train_x.rows() > 0 && train_x.cols() == test_x.cols());
  const auto count = static_cast<Eigen::Index>(lambdas.size());
  const double mean = train_y.mean();
  Eigen::MatrixXd predicted = Eigen::MatrixXd::Constant(test_x.rows(), count, mean);
  if (train_x.cols() == 0) return predicted;

  const Standard inputs(train_x);
  const svm::SampleMatrix raw = second_order(inputs.of(train_x));
  const Standard products(raw);
  const svm::SampleMatrix train = products.of(raw);
  const svm::SampleMatrix test = products.of(second_order(inputs.of(test_x)));
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(train.cols(), train.cols());
  gram.selfadjointView<Eigen::Lower>().rankUpdate(train.transpose());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(gram);  // reads the lower triangle
  const Eigen::VectorXd pull =
      modes.eigenvectors().transpose() * (train.transpose() * (train_y.array() - mean).matrix());
  const Eigen::MatrixXd along = test * modes.eigenvectors();
  const Eigen::ArrayXd strength = modes.eigenvalues().array().max(0);
  for (Eigen::Index l = 0; l < count; ++l) {
    const double penalty = lambdas[l] * static_cast<double>(train.rows());
    predicted.col(l) += along * (pull.array() / (strength + penalty)).matrix();
  }
  return predicted;
}

SurfaceTrial try_surface(const svm::SampleMatrix& x, const Eigen::VectorXd& y, const data::FoldPlan& folds) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  constexpr auto kLambdas = static_cast<Eigen::Index>(kSurfaceLambdas.size());
  Eigen::MatrixXd residual = Eigen::MatrixXd::Constant(y.size(), kLambdas, kNone);
  Eigen::RowVectorXd squares = Eigen::RowVectorXd::Zero(kLambdas);
  Eigen::Index held_out = 0;
  for (const data::Fold& fold : folds.folds) {
    const Eigen::MatrixXd predicted = surface_predictions(x(fold.training, Eigen::all), y(fold.training),
                                                          x(fold.held_out, Eigen::all), kSurfaceLambdas);
    const Eigen::VectorXd truth = y(fold.held_out);
    const Eigen::MatrixXd left = truth.replicate(1, kLambdas) - predicted;
    squares += left.colwise().squaredNorm();
    held_out += left.rows();
    residual(fold.held_out, Eigen::all) = left;
  }
  assert(held_out > 0);
  Eigen::Index best = 0;
  squares.minCoeff(&best);
  return {.residual = residual.col(best),
          .lambda = kSurfaceLambdas[best],
          .mean_square = squares(best) / static_cast<double>(held_out)};
}

}  // namespace gyrotherm::model
