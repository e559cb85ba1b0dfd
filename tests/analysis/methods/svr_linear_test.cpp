// SPDX-License-Identifier: Apache-2.0
#include "analysis/methods/svr_linear.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "analysis/methods/ridge_u.hpp"
#include "analysis/methods/svr.hpp"
#include "tests/analysis/random_samples.hpp"

namespace gyrotherm::methods {
namespace {

const HyperParameters kParameters = {{"C", 10}, {"sigma", 1.5}, {"epsilon", 0.1}};

TEST(SvrLinear, IsAPlaneAndTheSupportVectorsOfWhatItLeaves) {
  const data::Samples samples = data::bent_plane(150, 1), elsewhere = data::bent_plane(50, 2);
  const Eigen::MatrixXd covariance = Eigen::Vector3d(0.1, 0.02, 0.05).asDiagonal();
  const auto fit = fit_svr_linear({samples.x, samples.y, samples.terms, covariance}, kParameters, {});
  ASSERT_TRUE(fit);
  const PenalisedPlane plane = penalised_plane(samples.x, samples.y, covariance);
  const Eigen::VectorXd left = (samples.y - samples.x * plane.weights).array() - plane.b;
  const double unit = std::sqrt(left.squaredNorm() / 150);
  const Eigen::VectorXd y = left / unit;
  const auto support = fit_svr({samples.x, y, samples.terms}, kParameters, {});
  ASSERT_TRUE(support);
  const Eigen::VectorXd expected =
      (elsewhere.x * plane.weights).array() + plane.b + unit * value_of(support->function, elsewhere.x).array();
  EXPECT_LT((value_of(fit->function, elsewhere.x) - expected).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_NEAR(fit->effective_parameters, plane.effective_parameters + support->effective_parameters, 1e-12);
}

TEST(SvrLinear, OfAnExactPlaneIsThePlane) {
  data::Samples samples{data::normal_matrix(60, 2, 5), {}, data::letters(2)};
  samples.y = (2 * samples.x.col(0) - samples.x.col(1)).array() + 0.5;
  const auto fit = fit_svr_linear(samples.set(), kParameters, {});
  ASSERT_TRUE(fit);
  EXPECT_LT((value_of(fit->function, samples.x) - samples.y).cwiseAbs().maxCoeff(), 1e-10);
}

TEST(SvrLinear, TunesOnWhatThePlaneLeaves) {
  const data::Samples samples = data::bent_plane(120, 6);
  MethodOptions options;
  options.tuning.swarm.particles = 6;
  options.tuning.swarm.iterations = 4;
  const auto choice = choose_svr_linear(folds_of(samples, 3), options, {});
  ASSERT_TRUE(choice && choice->tuning);
  EXPECT_LT(choice->tuning->cross_validation_mse, 0.2);
  const auto fit = fit_svr_linear(samples.set(), choice->parameters, options);
  ASSERT_TRUE(fit);
  const data::Samples unseen = data::bent_plane(200, 7);
  EXPECT_LT((value_of(fit->function, unseen.x) - unseen.y).norm(), 0.15 * unseen.y.norm());
}

}  // namespace
}  // namespace gyrotherm::methods
