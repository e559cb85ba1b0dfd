// SPDX-License-Identifier: Apache-2.0
/// What support vectors beside a plane have in common, whether the plane is taken off first or solved with them.
#include <gtest/gtest.h>

#include "analysis/methods/svr.hpp"
#include "analysis/methods/svr_joint.hpp"
#include "analysis/methods/svr_linear.hpp"
#include "tests/analysis/random_samples.hpp"

namespace gyrotherm::methods {
namespace {

/// svr-linear has no plane penalty, and passes it over.
const HyperParameters kBesidePlane = {{"C", 10}, {"sigma", 1.5}, {"epsilon", 0.1}, {"plane penalty", 1}};

struct FitBesidePlane {
  const char* name;
  FitFunction* fit;
};

class PlaneBesideKernel : public testing::TestWithParam<FitBesidePlane> {};

TEST_P(PlaneBesideKernel, GoesOnAsAPlaneWhereSupportVectorsStop) {
  const data::Samples samples = data::bent_plane(200, 3);
  const auto beside = GetParam().fit(samples.set(), kBesidePlane, {}), alone = fit_svr(samples.set(), kBesidePlane, {});
  ASSERT_TRUE(beside && alone);
  const data::SampleMatrix far = Eigen::RowVector3d(0, 0, 8);
  EXPECT_NEAR(value_of(beside->function, far)(0), 32, 2);
  EXPECT_LT(value_of(alone->function, far)(0), 16) << "a Gaussian kernel has forgotten the slope";
}

TEST_P(PlaneBesideKernel, WithALargerUncertaintyDependsLessOnThatInput) {
  const data::Samples samples = data::bent_plane(150, 4);
  const auto slope_of = [&](double variance) {
    const Eigen::MatrixXd covariance = Eigen::Vector3d(0, 0, variance).asDiagonal();
    const auto fit = GetParam().fit({samples.x, samples.y, samples.terms, covariance}, kBesidePlane, {});
    return std::get<ExpansionModel>(fit->function).slope(2);
  };
  EXPECT_GT(slope_of(0), slope_of(0.1));
  EXPECT_GT(slope_of(0.1), slope_of(1));
}

INSTANTIATE_TEST_SUITE_P(Methods, PlaneBesideKernel,
                         testing::Values(FitBesidePlane{"SvrLinear", fit_svr_linear},
                                         FitBesidePlane{"SvrJoint", fit_svr_joint}),
                         [](const auto& one) { return std::string(one.param.name); });

}  // namespace
}  // namespace gyrotherm::methods
