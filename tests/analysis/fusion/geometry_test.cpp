// SPDX-License-Identifier: Apache-2.0
#include "analysis/fusion/geometry.hpp"

#include <limits>

#include "tests/analysis/fusion/fixtures.hpp"

namespace gyrotherm::fusion {
namespace {

TEST(Geometry, IncludesSharedUncertaintyInCovariance) {
  auto axes = triad_axes(0.1);
  axes[0].shared_deg_per_h = {0.2, 0};
  axes[1].shared_deg_per_h = {-0.3, 0.4};
  axes[2].shared_deg_per_h = {0, 0.5};
  const Geometry geometry = valid_geometry(axes);
  Eigen::Matrix3d expected;
  expected << 0.05, -0.06, 0, -0.06, 0.26, 0.2, 0, 0.2, 0.26;
  EXPECT_TRUE(geometry.covariance.isApprox(expected, 1e-14)) << geometry.covariance;
  EXPECT_EQ(geometry.names, (std::vector<std::string>{"x", "y", "z"}));
}

TEST(Geometry, KeepsSharedUncertaintyInMeans) {
  auto axes = triad_axes(0.1);
  for (auto& one : axes) one.shared_deg_per_h = {0.2};
  const auto means = geometry_of_means(axes, 100);
  ASSERT_TRUE(means);
  EXPECT_NEAR(means->covariance(0, 0), 0.0001 + 0.04, 1e-15);
  EXPECT_NEAR(means->covariance(0, 1), 0.04, 1e-15);
}

struct InvalidFixture {
  /// Part of the expected message.
  std::string message;
  std::vector<InputAxis> axes;
};

std::vector<InvalidFixture> invalid_fixtures() {
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinite = std::numeric_limits<double>::infinity();
  const auto changed = [](auto change) {
    auto axes = tetrad_axes(0.1);
    change(axes);
    return axes;
  };
  return {
      {"at least 3", {}},
      {"at least 3", {axis("x", 1, 0, 0, 1), axis("y", 0, 1, 0, 1)}},
      {"axis y: duplicate name", changed([](auto& axes) { axes[3].name = "y"; })},
      {"number 2 has no name", changed([](auto& axes) { axes[1].name = ""; })},
      {"axis z: its direction is not finite", changed([&](auto& axes) { axes[2].direction(0) = nan; })},
      {"length 1.01", changed([](auto& axes) { axes[0].direction *= 1.01; })},
      {"length 0", changed([](auto& axes) { axes[0].direction.setZero(); })},
      {"uncertainty is 0 °/h", changed([](auto& axes) { axes[1].independent_deg_per_h = 0; })},
      {"uncertainty is nan", changed([&](auto& axes) { axes[1].independent_deg_per_h = nan; })},
      {"uncertainty is inf", changed([&](auto& axes) { axes[1].independent_deg_per_h = infinite; })},
      {"it has 1 shared", changed([](auto& axes) { axes[1].shared_deg_per_h = {0.1}; })},
      {"shared uncertainty is not finite", changed([&](auto& axes) {
         for (auto& one : axes) one.shared_deg_per_h = {nan};
       })},
      {"not positive definite", changed([](auto& axes) {
         for (auto& one : axes) {
           one.shared_deg_per_h = {0.3};
           one.independent_deg_per_h = 1e-9;
         }
       })},
      {"not positive definite", changed([](auto& axes) { axes[2].independent_deg_per_h = 1e-200; })},
      {"not positive definite", changed([](auto& axes) { axes[1].independent_deg_per_h = 1e200; })},
      {"in a plane", {axis("1", 1, 0, 0, 1), axis("2", 0, 1, 0, 1), axis("3", 1, 1, 0, 1), axis("4", 1, -2, 1e-4, 1)}},
      {"in a plane", {axis("1", 1, 1, 1, 1), axis("2", 1, 1, 1, 1), axis("3", -1, -1, -1, 1)}},
  };
}

TEST(Geometry, ReportsErrorOfInvalidFixture) {
  for (const InvalidFixture& fixture : invalid_fixtures()) {
    const auto geometry = make_geometry(fixture.axes);
    ASSERT_FALSE(geometry) << fixture.message;
    EXPECT_EQ(geometry.error().kind, FaultKind::usage);
    EXPECT_NE(text(geometry.error()).find(fixture.message), std::string::npos) << text(geometry.error());
  }
}

TEST(Geometry, KeepsOtherAxesWhenOneIsRemoved) {
  const Geometry geometry = valid_geometry(uneven_axes());
  const auto rest = remove_axis(geometry, 2);
  ASSERT_TRUE(rest);
  auto axes = uneven_axes();
  axes.erase(axes.begin() + 2);
  EXPECT_EQ(rest->names, valid_geometry(axes).names);
  EXPECT_TRUE(rest->covariance.isApprox(valid_geometry(axes).covariance));
  EXPECT_TRUE(rest->directions.isApprox(valid_geometry(axes).directions));
}

TEST(Geometry, RejectsRemovalThatLeavesAxesInPlane) {
  const Geometry geometry =
      valid_geometry({axis("1", 1, 0, 0, 1), axis("2", 0, 1, 0, 1), axis("3", 1, 1, 0, 1), axis("up", 0, 0, 1, 1)});
  EXPECT_TRUE(remove_axis(geometry, 0));
  const auto rest = remove_axis(geometry, 3);
  ASSERT_FALSE(rest);
  EXPECT_EQ(rest.error().where, "axes without up");
  EXPECT_FALSE(remove_axis(valid_geometry(triad_axes(1)), 0)) << "two axes are not sufficient";
}

}  // namespace
}  // namespace gyrotherm::fusion
