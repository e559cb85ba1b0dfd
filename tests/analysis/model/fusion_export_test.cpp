// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "analysis/fusion/rate_fusion.hpp"
#include "analysis/model/model_export.hpp"
#include "tests/analysis/c_program.hpp"
#include "tests/analysis/fusion/fixtures.hpp"

namespace gyrotherm::model {
namespace {

/// Driver: reads one reading per axis and prints the results of the exported program.
constexpr const char* kFusionDriver = R"(#include <stdio.h>
#include "rig.h"

int main(void) {
  double reading[rig_AXES];
  if (rig_self_test() != 0) return 1;
  for (;;) {
    double rate[3], statistic;
    int i, result;
    for (i = 0; i < rig_AXES; ++i) if (scanf("%lf", &reading[i]) != 1) return 0;
    result = rig_fuse(reading, rate, &statistic);
    printf("%d %.17g %.17g %.17g %.17g", result, rate[0], rate[1], rate[2], statistic);
#ifdef rig_PARITIES
    {
      double bias;
      const int suspect = rig_suspect(reading, &bias);
      result = rig_fuse_without(reading, 1, rate);
      printf(" %d %.17g %d %.17g %.17g %.17g", suspect, bias, result, rate[0], rate[1], rate[2]);
    }
#endif
    printf("\n");
  }
}
)";

std::ifstream answers_of(const Workplace& place, const fusion::Geometry& geometry, const Eigen::MatrixXd& readings,
                         const fusion::TestOptions& options) {
  const auto program = fusion_to_c(geometry, "rig", options);
  EXPECT_TRUE(program);
  place.write("rig.h", program->header);
  place.write("rig.c", program->source);
  place.write("main.c", kFusionDriver);
  std::string lines;
  for (Eigen::Index n = 0; n < readings.rows(); ++n)
    for (Eigen::Index i = 0; i < readings.cols(); ++i) lines += fmt::format("{:.17g}\n", readings(n, i));
  place.write("in", lines);
  EXPECT_EQ(place.run(std::string(kCompile) + " -O1 rig.c main.c -o program -lm"), 0);
  EXPECT_EQ(place.run("./program < in > out"), 0) << "1: the self-test fails";
  return place.read("out");
}

/// Draws readings for rates of tens of °/h. Every third reading has a hop of one axis, and every 17th lacks an axis.
Eigen::MatrixXd drawn_readings(const fusion::Geometry& geometry) {
  constexpr int kCount = 300;
  fusion::Draws draws(5);
  Eigen::MatrixXd readings(kCount, geometry.axes());
  for (Eigen::Index n = 0; n < kCount; ++n) {
    readings.row(n) = geometry.directions * (20 * draws.normal(3)) + draws.correlated_normal(geometry.covariance);
    if (n % 3 == 0) readings(n, n / 3 % geometry.axes()) += 0.3;
    if (n % 17 == 0) readings(n, 1) = n % 2 == 0 ? std::nan("") : HUGE_VAL;
  }
  return readings;
}

TEST(FusionExport, FusesLikeLibrary) {
  if (!has_gcc()) GTEST_SKIP() << "gcc is not installed";
  const fusion::TestOptions options{.false_alarm_probability = 1e-4};
  for (const auto& axes :
       {fusion::triad_axes(0.02), fusion::tetrad_axes(0.02), fusion::dodecahedron_axes(0.02), fusion::uneven_axes()}) {
    const Workplace place;
    const fusion::Geometry geometry = fusion::valid_geometry(axes);
    const fusion::Gains gains = compute_gains(geometry);
    const Eigen::MatrixXd readings = drawn_readings(geometry);
    std::ifstream out = answers_of(place, geometry, readings, options);
    int suspects = 0;
    for (Eigen::Index n = 0; n < readings.rows(); ++n) {
      const Eigen::VectorXd reading = readings.row(n);
      int result{}, suspect{}, without{};
      Eigen::Vector3d rate, rest;
      double statistic{}, bias{};
      ASSERT_TRUE(out >> result >> rate(0) >> rate(1) >> rate(2) >> statistic) << n;
      if (axes.size() > 3) {
        ASSERT_TRUE(out >> suspect >> bias >> without >> rest(0) >> rest(1) >> rest(2)) << n;
      }
      if (!reading.allFinite()) {
        EXPECT_EQ(result, 2);
        EXPECT_EQ(rate.norm() + statistic, 0);
        continue;
      }
      const fusion::Finding finding = examine(parity_test(gains, geometry), gains.parity * reading, options);
      EXPECT_EQ(result, finding.fault ? 1 : 0) << n;
      EXPECT_LT((rate - fuse_readings(gains, reading).deg_per_h).norm(), 1e-12 * 60) << n;
      EXPECT_NEAR(statistic, finding.statistic, 1e-9 * (1 + finding.statistic)) << n;
      if (axes.size() == 3) continue;
      const auto named = finding.isolation ? finding.isolation->candidate : std::nullopt;
      EXPECT_EQ(suspect, named ? static_cast<int>(*named) : -1) << n;
      EXPECT_NEAR(bias, named ? finding.isolation->size : 0, 1e-11) << n;
      EXPECT_EQ(without, 0);
      EXPECT_LT((rest - fuse_without_axis(gains, reading, 1)->deg_per_h).norm(), 1e-11 * 60) << n;
      suspects += named ? 1 : 0;
    }
    EXPECT_EQ(suspects > 0, axes.size() > 4) << "no axis can be isolated with four axes";
  }
}

TEST(FusionExport, RefusesToLeaveOutAxisWithoutRedundancy) {
  if (!has_gcc()) GTEST_SKIP() << "gcc is not installed";
  const Workplace place;
  const fusion::Geometry geometry =
      fusion::valid_geometry({fusion::axis("1", 1, 0, 0, 1), fusion::axis("up", 0, 0, 1, 1),
                              fusion::axis("2", 0, 1, 0, 1), fusion::axis("3", 1, 1, 0, 1)});
  std::ifstream out = answers_of(place, geometry, Eigen::RowVector4d(1, 5, 2, 3 / std::sqrt(2.0)), {});
  std::string answer;
  std::getline(out, answer);
  EXPECT_NE(answer.find(" -1 0 4 0 0 0"), std::string::npos) << answer;
}

TEST(FusionExport, RefusesInvalidCName) {
  const auto program = fusion_to_c(fusion::valid_geometry(fusion::triad_axes(1)), "7-B");
  ASSERT_FALSE(program);
  EXPECT_EQ(program.error().kind, FaultKind::usage);
}

}  // namespace
}  // namespace gyrotherm::model
