// SPDX-License-Identifier: Apache-2.0
#include "analysis/planning/program_path.hpp"

#include <gtest/gtest.h>

#include <array>
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

TEST(ProgramPath, BeginsAPowerOnBeforeABlockThatBeginsOff) {
  const ProgramPath joined = join(path_of({20, 20}, {0, 0}), path_of({20, 20, 20, 20}, {-1, 0, -1, 1}));
  EXPECT_EQ(joined.start, (Eigen::VectorXi(6) << 0, 0, -1, 1, -1, 2).finished());
  EXPECT_EQ(count_starts(joined), 3);
  const ProgramPath off = join(path_of({20, 20}, {0, 0}), path_of({20}, {-1}));
  EXPECT_EQ(off.start, Eigen::Vector3i(0, 0, -1)) << "a block without the unit adds no power-on";
}

TEST(ProgramPath, KeepsFirstPowerOnAfterABeginningWithTheUnitOff) {
  const ProgramPath off = path_of({20}, {-1});
  EXPECT_EQ(count_starts(off), 0);
  EXPECT_EQ(join(off, path_of({20, 20}, {0, 0})).start, Eigen::Vector3i(-1, 0, 0));
  EXPECT_EQ(join(off, path_of({20, 20}, {-1, 0})).start, Eigen::Vector3i(-1, -1, 0));
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

TEST(ProgramPath, OfARecordThatBeginsOffHasOnePowerOn) {
  data::Dataset dataset;
  dataset.segments.resize(4);
  dataset.segments[0].unit.off = dataset.segments[2].unit.off = true;
  const Eigen::Index rows = 600;
  dataset.time_s = Eigen::VectorXd::LinSpaced(rows, 0, 599);
  dataset.set_point_c.setConstant(rows, 20);
  dataset.segment.resize(rows);
  for (Eigen::Index i = 0; i < rows; ++i) dataset.segment(i) = std::array{0, 0, 1, 1, 2, 3}[i / 100];
  const ProgramPath path = recorded_path(dataset);
  EXPECT_EQ(path.start, (Eigen::VectorXi(6) << -1, -1, 0, 0, -1, 1).finished());
  EXPECT_EQ(count_starts(path), 2);
  dataset.segment.setZero();
  EXPECT_EQ(count_starts(recorded_path(dataset)), 0) << "the unit is never on";
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
