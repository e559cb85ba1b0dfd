// SPDX-License-Identifier: Apache-2.0
#include "analysis/data/dataset.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "acquisition/record/record.hpp"
#include "analysis/data/clusters.hpp"

namespace gyrotherm::data {
namespace {

/// Returns a record of four seconds with one thermometer. The first two seconds are a hold, the others a ramp. The gyro
/// counts 10, 12, 20 and 20 pulses of 0.5".
record::Record four_seconds() {
  record::Record record;
  record.info.id = "r";
  record.info.thermometers = {{"A", "probe", {0.25}}};
  record.info.units = {{.axes = {{.kind = record::GyroKind::pulse_count, .scale = 0.5}}}};
  record.info.cycles = {"first"};
  record.info.segments = {{"rest", true, {20}, {}, 0}, {"up", false, {30}, {1}, 0}};
  record.finished = true;
  record.slot = {0, 1, 2, 3};
  record.time_s = {0.003, 1.001, 2.002, 3.004};
  record.set_point_c = {20, 20, 20, 21};
  record.thermometers_c = {{20, 20.5, std::nan(""), 21}};
  record.units = {{.rotation = {{10, 12, 20, 20}},
                   .interval_s = {1, 1, 1, 0.5},
                   .values = {},
                   .true_bias_deg_per_h = {std::vector<double>(4, std::nan(""))}}};
  record.progress.resize(4);
  for (int i = 0; i < 4; ++i) {
    record.progress[i].segment = i / 2;
    record.progress[i].cycle = 0;
  }
  return record;
}

Dataset to_dataset(const record::Record& record) {
  return make_dataset(record, "run.db", choose_axis(record.info, {}, "run.db").value());
}

TEST(Dataset, CalibratesTemperaturesAndKeepsMissingReadings) {
  const Dataset dataset = to_dataset(four_seconds());
  EXPECT_DOUBLE_EQ(dataset.temperature_c(0, 0), 20.25);
  EXPECT_TRUE(std::isnan(dataset.temperature_c(2, 0)));
}

TEST(Dataset, DividesPulsesByExactIntervalAndRemovesEarthRate) {
  record::Record record = four_seconds();
  record.info.units[0].axes[0].earth_rate = DegreesPerHour{4};
  const Dataset dataset = to_dataset(record);
  EXPECT_EQ(dataset.bias_zero, "earth rate removed");
  EXPECT_FALSE(dataset.has_own_reference);
  EXPECT_DOUBLE_EQ(dataset.bias_deg_per_h(0), 0.5 * 10 - 4);
  EXPECT_DOUBLE_EQ(dataset.bias_deg_per_h(3), 0.5 * 20 / 0.5 - 4);
}

TEST(Dataset, DetectsPulseCountsFromWholeNumbers) {
  record::Record record = four_seconds();
  EXPECT_EQ(to_dataset(record).step_deg_per_h, 0.5);
  record.info.units[0].axes[0].scale = -0.5;
  record.units[0].rotation[0][1] = std::nan("");
  EXPECT_EQ(to_dataset(record).step_deg_per_h, 0.5) << "also for a negative scale and a missing second";
  record.units[0].rotation[0][1] = 11.5;
  EXPECT_EQ(to_dataset(record).step_deg_per_h, 0) << "angles are not pulse counts";
  record.info.units[0].axes[0].kind = record::GyroKind::rate;
  record.units[0].rotation[0][1] = 12;
  EXPECT_EQ(to_dataset(record).step_deg_per_h, 0) << "a rate";
}

TEST(Dataset, RemovesMeanOfFirstHoldWhenEarthRateIsUnknown) {
  const Dataset dataset = to_dataset(four_seconds());
  EXPECT_EQ(dataset.bias_zero, "mean of the first hold removed");
  EXPECT_TRUE(dataset.has_own_reference);
  EXPECT_DOUBLE_EQ(dataset.bias_deg_per_h(0), -0.5);
  EXPECT_DOUBLE_EQ(dataset.bias_deg_per_h(1), 0.5);
}

TEST(Dataset, HasOwnZeroIfReferenceIsMeanOfRecord) {
  EXPECT_TRUE(have_same_zero("earth rate removed", "earth rate removed"));
  EXPECT_TRUE(have_same_zero(kNothingRemoved, kNothingRemoved));
  EXPECT_FALSE(have_same_zero("earth rate removed", kNothingRemoved));
  EXPECT_FALSE(have_same_zero(kOwnReference, kNothingRemoved));
  EXPECT_FALSE(have_same_zero(kOwnReference, kOwnReference)) << "each record has another mean";
}

TEST(Dataset, AddsEarthRateWhenUnitIsTurnedAround) {
  record::Record record = four_seconds();
  record.info.units[0].axes[0].earth_rate = DegreesPerHour{4};
  record.info.segments[1].unit.turned = true;
  const Dataset dataset = to_dataset(record);
  EXPECT_DOUBLE_EQ(dataset.bias_deg_per_h(0), 0.5 * 10 - 4);
  EXPECT_DOUBLE_EQ(dataset.bias_deg_per_h(2), 0.5 * 20 + 4);
  record.info.units[0].axes[0].earth_rate.reset();
  const Dataset unknown = to_dataset(record);
  EXPECT_EQ(unknown.bias_zero, "nothing removed")
      << "the mean of one position would be wrong by twice the Earth rate in the other";
  EXPECT_DOUBLE_EQ(unknown.bias_deg_per_h(0), 5);
}

TEST(Dataset, OmitsBiasWhileOperatorHandlesUnit) {
  record::Record record = four_seconds();
  record.info.units[0].axes[0].earth_rate = DegreesPerHour{4};
  record.info.segments[1].prompt = "turn the unit around";
  record.progress[3].in_segment = std::chrono::seconds(1);
  const Dataset dataset = to_dataset(record);
  EXPECT_FALSE(std::isnan(dataset.bias_deg_per_h(1))) << "there was no operator request";
  EXPECT_TRUE(std::isnan(dataset.bias_deg_per_h(2)));
  EXPECT_FALSE(std::isnan(dataset.bias_deg_per_h(3)));
}

TEST(Dataset, OmitsRowsAfterStopInHotHold) {
  record::Record record = four_seconds();
  record.info.units[0].axes[0].earth_rate = DegreesPerHour{4};
  record.info.segments = {{"up", false, {50}, {1}, 0}, {"hold 50", true, {50}, {}, 0}};
  record.set_point_c = {49, 50, 50, 50};
  record.state = {RunState::execute, RunState::execute, RunState::aborting, RunState::stopped};
  const Dataset dataset = to_dataset(record);
  EXPECT_FALSE(std::isnan(dataset.bias_deg_per_h(1)));
  for (const Eigen::Index row : {2, 3}) {
    EXPECT_TRUE(std::isnan(dataset.bias_deg_per_h(row))) << row;
    EXPECT_TRUE(std::isnan(dataset.set_point_c(row))) << row;
    EXPECT_EQ(dataset.segment(row), -1) << row;
    EXPECT_EQ(dataset.cycle(row), -1) << row;
  }
  EXPECT_EQ(dataset.temperature_c(3, 0), 21.25) << "temperatures remain";
  EXPECT_EQ(dataset.stopped_in, 1);
}

TEST(Dataset, ContinuesAfterAbortOfResumedRun) {
  record::Record record = four_seconds();
  record.state = {RunState::execute, RunState::aborted, RunState::suspended, RunState::execute};
  const Dataset dataset = to_dataset(record);
  EXPECT_TRUE(std::isnan(dataset.bias_deg_per_h(1)));
  EXPECT_TRUE(std::isnan(dataset.bias_deg_per_h(2))) << "the run returns to its profile";
  EXPECT_EQ(dataset.segment(2), -1);
  EXPECT_FALSE(std::isnan(dataset.bias_deg_per_h(3)));
  EXPECT_EQ(dataset.bias_deg_per_h(0), 0) << "the aborted second is not part of the reference";
  EXPECT_FALSE(dataset.stopped_in);
  record.state.back() = RunState::complete;
  EXPECT_FALSE(to_dataset(record).stopped_in);
  record.state = {RunState::execute, RunState::execute, RunState::execute, RunState::aborting};
  EXPECT_EQ(to_dataset(record).stopped_in, 1);
  record.progress[3].segment = record.progress[2].segment = -1;
  EXPECT_EQ(to_dataset(record).stopped_in, 0) << "the last known segment";
}

TEST(Dataset, KeepsRowsOfOrdinarySuspension) {
  record::Record record = four_seconds();
  record.state = {RunState::execute, RunState::suspended, RunState::suspended, RunState::execute};
  const Dataset dataset = to_dataset(record);
  for (const Eigen::Index row : {0, 1, 2, 3}) EXPECT_FALSE(std::isnan(dataset.bias_deg_per_h(row))) << row;
}

TEST(Dataset, TakesReferenceFromFirstHoldWithBias) {
  record::Record record = four_seconds();
  record.info.segments[1].hold = true;
  record.units[0].rotation[0][0] = record.units[0].rotation[0][1] = std::nan("");
  const Dataset dataset = to_dataset(record);
  EXPECT_EQ(dataset.bias_zero, "mean of the first hold removed");
  EXPECT_DOUBLE_EQ(dataset.bias_deg_per_h(2) + dataset.bias_deg_per_h(3), 0);
}

TEST(Dataset, ProvidesTrueBiasOnlyForVirtualGyro) {
  record::Record record = four_seconds();
  EXPECT_TRUE(to_dataset(record).true_bias_deg_per_h.array().isNaN().all());
  EXPECT_TRUE(to_dataset(record).has_own_reference);
  record.units[0].true_bias_deg_per_h[0] = {1, 2, 3, 4};
  record.info.units[0].axes[0].earth_rate = DegreesPerHour{4};
  const Dataset dataset = to_dataset(record);
  EXPECT_EQ(dataset.true_bias_deg_per_h(3), 4) << "the true bias excludes the Earth rate";
  EXPECT_FALSE(dataset.has_own_reference);
}

TEST(Dataset, KeepsBiasAndTimesOfImportedRecord) {
  record::Record record = four_seconds();
  record.info.imported = true;
  record.info.units = {{.axes = {{.kind = record::GyroKind::rate, .scale = 2}}}};
  record.info.segments.clear();
  record.progress.clear();
  const Dataset dataset = to_dataset(record);
  EXPECT_EQ(dataset.bias_zero, "nothing removed");
  EXPECT_DOUBLE_EQ(dataset.bias_deg_per_h(1), 24);
  EXPECT_DOUBLE_EQ(dataset.time_s(1), 1.001);
  EXPECT_EQ(dataset.segment(3), -1);
  EXPECT_TRUE(std::isnan(dataset.set_point_c(0)));
}

TEST(Dataset, UsesSlotsAsTimeOfNativeRecord) {
  const Dataset dataset = to_dataset(four_seconds());
  EXPECT_EQ(dataset.time_s(3), 3);
  EXPECT_EQ(dataset.segment(3), 1);
}

TEST(Dataset, UsesGWhenShellIsMissing) {
  record::Record record = four_seconds();
  record.info.thermometers = {{"A", "", {}}, {"D", "", {}}, {"G", "", {}}};
  record.thermometers_c.resize(3, {1, 2, 3, 4});
  const Dataset dataset = to_dataset(record);
  EXPECT_EQ(dataset.three_point, (std::vector<std::string>{"A", "D", "G"}));
  EXPECT_TRUE(dataset.three_point_stand_in);
  EXPECT_EQ(dataset.gradients, dataset.thermometers);

  record.info.units[0].three_point = {"A", "D", "shell"};
  EXPECT_FALSE(to_dataset(record).three_point_stand_in);
}

TEST(Dataset, ListsGaps) {
  record::Record record = four_seconds();
  record.gaps = {{10, 19, "power cut"}};
  EXPECT_EQ(to_dataset(record).gaps_s.front(), (std::pair{10.0, 20.0}));
}

/// Returns a record of two units: the one of four_seconds(), and one that has two axes and measures its own temperature
/// and a current.
record::Record two_units() {
  record::Record record = four_seconds();
  record.info.thermometers = {{"A", "probe", {0.25}}, {"B", "probe", {}}, {"air", "probe", {}}};
  record.info.thermometers[0].unit_under_test = "u1";
  record.info.thermometers[1].unit_under_test = "u2";
  record.info.thermometers[2].unit_under_test = "";
  record.thermometers_c = {{20, 20.5, 20, 21}, {1, 2, 3, 4}, {5, 5, 5, 5}};
  record.info.units[0].name = "u1";
  record.info.units.push_back(
      {.name = "u2",
       .axes = {{.name = "x", .scale = 1}, {.name = "y", .scale = 2, .earth_rate = DegreesPerHour{3}}},
       .values = {{"current", "mA", false}, {"inside", "°C", true}, {"outside", "°C", true}},
       .gradients = {"B"}});
  record.units.push_back({.rotation = {{1, 2, 3, 4}, {5, 6, 7, 8}},
                          .interval_s = {1, 1, 1, 1},
                          .values = {{7, 7, std::nan(""), 7}, {30, 31, 32, 33}, {40, 41, 42, 43}},
                          .true_bias_deg_per_h = {{0, 0, 0, 0}, {1, 1, 1, 1}}});
  return record;
}

TEST(Dataset, ContainsOneAxisOfOneUnit) {
  const record::Record record = two_units();
  const Dataset dataset = make_dataset(record, "run.db", {"u2", "y"});
  EXPECT_EQ(dataset.of, (AxisChoice{"u2", "y"}));
  EXPECT_DOUBLE_EQ(dataset.bias_deg_per_h(3), 2 * 8 - 3);
  EXPECT_EQ(dataset.true_bias_deg_per_h(0), 1);
  EXPECT_EQ(dataset.thermometers, (std::vector<std::string>{"B", "air", "aux:current", "self", "aux:outside"}))
      << "thermometers of the unit and of the rig, and values measured by the gyro";
  EXPECT_EQ(dataset.input_units, (std::vector<std::string>{"°C", "°C", "mA", "°C", "°C"}));
  EXPECT_EQ(dataset.temperature_c.col(3), Eigen::Vector4d(30, 31, 32, 33));
  EXPECT_EQ(dataset.gradients, std::vector<std::string>{"B"});
  EXPECT_EQ(make_dataset(record, "run.db", {"u1", ""}).thermometers, (std::vector<std::string>{"A", "air"}));
}

TEST(Dataset, RequiresChoiceAmongSeveralAxes) {
  const auto info = two_units().info;
  const auto chosen = [&](const AxisChoice& requested) { return choose_axis(info, requested, "run.db"); };
  EXPECT_EQ(chosen({.unit = "u1"}), (AxisChoice{"u1", ""})) << "the unit has only one axis";
  EXPECT_EQ(chosen({.axis = "y"}), (AxisChoice{"u2", "y"})) << "only this unit has the axis";
  EXPECT_EQ(text(chosen({}).error()), "run.db: has 3 axes, u1, u2.x, u2.y: choose one with --unit and --axis");
  EXPECT_EQ(text(chosen({.unit = "u2"}).error()), "run.db: has 2 axes, u2.x, u2.y: choose one with --unit and --axis");
  EXPECT_EQ(chosen({.unit = "u3"}).error().kind, FaultKind::usage);
  EXPECT_EQ(text(chosen({.unit = "u3"}).error()), "run.db: has no unit \"u3\"; it has u1, u2.x, u2.y");
  EXPECT_EQ(text(chosen({.axis = "z"}).error()), "run.db: has no axis \"z\"; it has u1, u2.x, u2.y");
  EXPECT_EQ(text(chosen({.unit = "u1", .axis = "x"}).error()),
            "run.db: has no axis \"x\" of a unit \"u1\"; it has u1, u2.x, u2.y");
}

TEST(Dataset, KeepsClusterWhenOwnValueIsMissing) {
  record::Record record = two_units();
  const auto clusters = make_clusters(make_dataset(record, "run.db", {"u2", "x"}), 4).value();
  ASSERT_EQ(clusters.start_s.size(), 1);
  EXPECT_TRUE(std::isnan(clusters.temperature_c(0, 2))) << "one current reading is missing";
  EXPECT_DOUBLE_EQ(clusters.temperature_c(0, 3), 31.5);
  record.thermometers_c[0][1] = std::nan("");
  EXPECT_EQ(make_clusters(make_dataset(record, "run.db", {"u2", "x"}), 4)->start_s.size(), 1)
      << "the missing reading belongs to another unit";
  record.thermometers_c[1][1] = std::nan("");
  EXPECT_FALSE(make_clusters(make_dataset(record, "run.db", {"u2", "x"}), 4));
}

TEST(BlockThermometers, ExcludeThoseOfShell) {
  using Names = std::vector<std::string>;
  const auto block = [](Names gradients, Names three_point, bool stand_in = false) {
    Dataset dataset;
    dataset.thermometers = {"A", "B", "shell", "self", "aux:current"};
    dataset.gradients = std::move(gradients);
    dataset.three_point = std::move(three_point);
    dataset.three_point_stand_in = stand_in;
    return block_thermometers(dataset);
  };
  EXPECT_EQ(block({"u1.x.B", "u1.x.F", "u1.x.shell", "u1.y.B", "u1.y.shell"}, {"u1.x.B", "u1.x.F", "u1.x.shell"}),
            (Names{"u1.x.B", "u1.x.F", "u1.y.B"}));
  EXPECT_EQ(block({"A", "B"}, {"A", "B", "shell"}), (Names{"A", "B"})) << "the shell is not a gradient thermometer";
  EXPECT_EQ(block({"A", "D", "G"}, {"A", "D", "G"}, true), (Names{"A", "D", "G"})) << "G only stands in for a shell";
  EXPECT_EQ(block({"A", "B"}, {}), (Names{"A", "B"}));
  EXPECT_EQ(block({"a.shell", "b.shell"}, {"a.shell", "b.shell", "c.shell"}), (Names{"a.shell", "b.shell"}))
      << "a block without a thermometer is not possible";
  EXPECT_EQ(block({}, {}), (Names{"A", "B", "shell", "self"}));
  EXPECT_EQ(block({"x.bshell", "x.shell"}, {"A", "B", "shell"}), Names{"x.bshell"});
}

}  // namespace
}  // namespace gyrotherm::data
