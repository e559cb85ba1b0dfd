// SPDX-License-Identifier: Apache-2.0
#include "analysis/planning/program_path.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace gyrotherm::planning {
namespace {

ProgramPath path_of(std::initializer_list<double> set_points_c, std::initializer_list<int> starts) {
  ProgramPath path;
  path.set_point_c = Eigen::Map<const Eigen::VectorXd>(set_points_c.begin(), std::ssize(set_points_c));
  path.start = Eigen::Map<const Eigen::VectorXi>(starts.begin(), std::ssize(starts));
  return path;
}

TEST(ProgramPath, ContinuesAPowerOnWhenJoined) {
  const ProgramPath joined = join(path_of({20, 20}, {0, 0}), path_of({20, 30, 30}, {0, -1, 1}));
  EXPECT_EQ(joined.set_point_c, (Eigen::VectorXd(5) << 20, 20, 20, 30, 30).finished());
  EXPECT_EQ(joined.start, (Eigen::VectorXi(5) << 0, 0, 0, -1, 1).finished());
  EXPECT_EQ(count_starts(joined), 2);
}

TEST(ProgramPath, BeginsAPowerOnAfterAnEndWithTheUnitOff) {
  const ProgramPath joined = join(path_of({20, 20}, {0, -1}), path_of({20}, {0}));
  EXPECT_EQ(joined.start, Eigen::Vector3i(0, -1, 1));
}

TEST(ProgramPath, IsTheOtherWhenJoinedToNothing) {
  const ProgramPath path = path_of({20, 30}, {0, 0});
  EXPECT_EQ(join({}, path).start, path.start);
  EXPECT_EQ(join(path, {}).set_point_c, path.set_point_c);
  EXPECT_EQ(count_starts({}), 0);
}

TEST(ProgramPath, OfARecordHasItsSetPointsAndPowerOns) {
  data::Dataset dataset;
  dataset.segments.resize(3);
  dataset.segments[1].unit.off = true;
  const Eigen::Index rows = 350;
  dataset.time_s = Eigen::VectorXd::LinSpaced(rows, 0, 349);
  dataset.set_point_c.setConstant(rows, 20);
  dataset.set_point_c.segment(100, 100).setConstant(-40);
  dataset.segment.setZero(rows);
  dataset.segment.segment(100, 100).setOnes();
  dataset.segment.tail(150).setConstant(2);
  const ProgramPath path = recorded_path(dataset);
  EXPECT_EQ(path.set_point_c, (Eigen::VectorXd(4) << 20, -40, 20, 20).finished());
  EXPECT_EQ(path.start, (Eigen::VectorXi(4) << 0, -1, 1, 1).finished());
}

TEST(ProgramPath, BridgesAGapOfTheRecord) {
  data::Dataset dataset;
  dataset.time_s.resize(200);
  dataset.time_s << Eigen::VectorXd::LinSpaced(100, 0, 99), Eigen::VectorXd::LinSpaced(100, 400, 499);
  dataset.set_point_c.setConstant(200, 20);
  dataset.set_point_c.tail(100).setConstant(30);
  dataset.segment.setZero(200);
  const ProgramPath path = recorded_path(dataset);
  EXPECT_EQ(path.set_point_c, (Eigen::VectorXd(5) << 20, 20, 20, 20, 30).finished());
  EXPECT_EQ(path.start, Eigen::VectorXi::Zero(5));
  EXPECT_EQ(recorded_path({}).set_point_c.size(), 0);
}

}  // namespace
}  // namespace gyrotherm::planning
