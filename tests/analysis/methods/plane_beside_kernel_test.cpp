// SPDX-License-Identifier: Apache-2.0
/// A plane beside support vectors: svr-linear's.
#include <gtest/gtest.h>

#include "analysis/methods/svr.hpp"
#include "analysis/methods/svr_linear.hpp"
#include "tests/analysis/random_samples.hpp"

namespace gyrotherm::methods {
namespace {

const HyperParameters kBesidePlane = {{"C", 10}, {"sigma", 1.5}, {"epsilon", 0.1}};

TEST(PlaneBesideKernel, GoesOnAsAPlaneWhereSupportVectorsStop) {
  const data::Samples samples = data::bent_plane(200, 3);
  const auto beside = fit_svr_linear(samples.set(), kBesidePlane, {}), alone = fit_svr(samples.set(), kBesidePlane, {});
  ASSERT_TRUE(beside && alone);
  const data::SampleMatrix far = Eigen::RowVector3d(0, 0, 8);
  EXPECT_NEAR(value_of(beside->function, far)(0), 32, 2);
  EXPECT_LT(value_of(alone->function, far)(0), 16) << "a Gaussian kernel has forgotten the slope";
}

TEST(PlaneBesideKernel, WithALargerUncertaintyDependsLessOnThatInput) {
  const data::Samples samples = data::bent_plane(150, 4);
  const auto slope_of = [&](double variance) {
    const Eigen::MatrixXd covariance = Eigen::Vector3d(0, 0, variance).asDiagonal();
    const auto fit = fit_svr_linear({samples.x, samples.y, samples.terms, covariance}, kBesidePlane, {});
    return std::get<ExpansionModel>(fit->function).slope(2);
  };
  EXPECT_GT(slope_of(0), slope_of(0.1));
  EXPECT_GT(slope_of(0.1), slope_of(1));
}

}  // namespace
}  // namespace gyrotherm::methods
