// SPDX-License-Identifier: Apache-2.0
#include "analysis/data/dataset.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "acquisition/record/record.hpp"

namespace gyrotherm::data {
namespace {

/// Four seconds: two in a hold, two in a ramp; one thermometer; the gyro counts 10, 12, 20, 20 pulses of 0.5".
record::Record four_seconds() {
  record::Record record;
  record.info.id = "r";
  record.info.thermometers = {{"A", "probe", {0.25}}};
  record.info.gyro = {record::GyroKind::pulse_count, 0.5, std::nullopt};
  record.info.cycles = {"first"};
  record.info.segments = {{"rest", true, {20}, {}, 0}, {"up", false, {30}, {1}, 0}};
  record.finished = true;
  record.slot = {0, 1, 2, 3};
  record.time_s = {0.003, 1.001, 2.002, 3.004};
  record.set_point_c = {20, 20, 20, 21};
  record.thermometers_c = {{20, 20.5, std::nan(""), 21}};
  record.gyro = {10, 12, 20, 20};
  record.gyro_interval_s = {1, 1, 1, 0.5};
  record.progress.resize(4);
  for (int i = 0; i < 4; ++i) {
    record.progress[i].segment = i / 2;
    record.progress[i].cycle = 0;
  }
  return record;
}

TEST(Dataset, CalibratesTemperaturesAndKeepsWhatIsMissing) {
  const Dataset dataset = make_dataset(four_seconds(), "run.db");
  EXPECT_DOUBLE_EQ(dataset.temperature_c(0, 0), 20.25);
  EXPECT_TRUE(std::isnan(dataset.temperature_c(2, 0)));
}

TEST(Dataset, ReadsPulsesOverTheirExactIntervalLessTheEarthRate) {
  record::Record record = four_seconds();
  record.info.gyro.earth_rate = DegreesPerHour{4};
  const Dataset dataset = make_dataset(record, "run.db");
  EXPECT_EQ(dataset.bias_zero, "earth rate removed");
  EXPECT_FALSE(dataset.zero_is_its_own);
  EXPECT_DOUBLE_EQ(dataset.bias_deg_per_h(0), 0.5 * 10 - 4);
  EXPECT_DOUBLE_EQ(dataset.bias_deg_per_h(3), 0.5 * 20 / 0.5 - 4);
}

TEST(Dataset, RemovesTheMeanOfTheFirstHoldWhereTheEarthRateIsUnknown) {
  const Dataset dataset = make_dataset(four_seconds(), "run.db");
  EXPECT_EQ(dataset.bias_zero, "mean of the first hold removed");
  EXPECT_TRUE(dataset.zero_is_its_own);
  EXPECT_DOUBLE_EQ(dataset.bias_deg_per_h(0), -0.5);
  EXPECT_DOUBLE_EQ(dataset.bias_deg_per_h(1), 0.5);
}

TEST(Dataset, AddsTheEarthRateWhereTheUnitIsTurnedAround) {
  record::Record record = four_seconds();
  record.info.gyro.earth_rate = DegreesPerHour{4};
  record.info.segments[1].unit.turned = true;
  const Dataset dataset = make_dataset(record, "run.db");
  EXPECT_DOUBLE_EQ(dataset.bias_deg_per_h(0), 0.5 * 10 - 4);
  EXPECT_DOUBLE_EQ(dataset.bias_deg_per_h(2), 0.5 * 20 + 4);
  record.info.gyro.earth_rate.reset();
  const Dataset unknown = make_dataset(record, "run.db");
  EXPECT_EQ(unknown.bias_zero, "nothing removed") << "a mean of one position would be wrong twofold in the other";
  EXPECT_DOUBLE_EQ(unknown.bias_deg_per_h(0), 5);
}

TEST(Dataset, HasNoBiasWhileTheUnitIsInPeoplesHands) {
  record::Record record = four_seconds();
  record.info.gyro.earth_rate = DegreesPerHour{4};
  record.info.segments[1].prompt = "turn the unit around";
  record.progress[3].in_segment = std::chrono::seconds(1);
  const Dataset dataset = make_dataset(record, "run.db");
  EXPECT_FALSE(std::isnan(dataset.bias_deg_per_h(1))) << "nobody was asked for anything";
  EXPECT_TRUE(std::isnan(dataset.bias_deg_per_h(2)));
  EXPECT_FALSE(std::isnan(dataset.bias_deg_per_h(3)));
}

TEST(Dataset, TakesItsZeroFromTheFirstHoldThatHasABias) {
  record::Record record = four_seconds();
  record.info.segments[1].hold = true;
  record.gyro[0] = record.gyro[1] = std::nan("");
  const Dataset dataset = make_dataset(record, "run.db");
  EXPECT_EQ(dataset.bias_zero, "mean of the first hold removed");
  EXPECT_DOUBLE_EQ(dataset.bias_deg_per_h(2) + dataset.bias_deg_per_h(3), 0);
}

TEST(Dataset, KnowsTheTrueBiasOfAVirtualGyroAlone) {
  record::Record record = four_seconds();
  EXPECT_TRUE(make_dataset(record, "run.db").true_bias_deg_per_h.array().isNaN().all());
  EXPECT_TRUE(make_dataset(record, "run.db").zero_is_its_own);
  record.true_bias_deg_per_h = {1, 2, 3, 4};
  record.info.gyro.earth_rate = DegreesPerHour{4};
  const Dataset dataset = make_dataset(record, "run.db");
  EXPECT_EQ(dataset.true_bias_deg_per_h(3), 4) << "Earth's rate is not in it";
  EXPECT_FALSE(dataset.zero_is_its_own);
}

TEST(Dataset, RemovesNothingFromAnImportedRecordAndKeepsItsTimes) {
  record::Record record = four_seconds();
  record.info.imported = true;
  record.info.gyro = {record::GyroKind::rate, 2, std::nullopt};
  record.info.segments.clear();
  record.progress.clear();
  const Dataset dataset = make_dataset(record, "run.db");
  EXPECT_EQ(dataset.bias_zero, "nothing removed");
  EXPECT_DOUBLE_EQ(dataset.bias_deg_per_h(1), 24);
  EXPECT_DOUBLE_EQ(dataset.time_s(1), 1.001);
  EXPECT_EQ(dataset.segment(3), -1);
  EXPECT_TRUE(std::isnan(dataset.set_point_c(0)));
}

TEST(Dataset, CountsOurOwnTimeInSlots) {
  const Dataset dataset = make_dataset(four_seconds(), "run.db");
  EXPECT_EQ(dataset.time_s(3), 3);
  EXPECT_EQ(dataset.segment(3), 1);
}

TEST(Dataset, LetsGStandInForTheShell) {
  record::Record record = four_seconds();
  record.info.thermometers = {{"A", "", {}}, {"D", "", {}}, {"G", "", {}}};
  record.thermometers_c.resize(3, {1, 2, 3, 4});
  const Dataset dataset = make_dataset(record, "run.db");
  EXPECT_EQ(dataset.three_point, (std::vector<std::string>{"A", "D", "G"}));
  EXPECT_TRUE(dataset.three_point_stand_in);
  EXPECT_EQ(dataset.gradients, dataset.thermometers);

  record.info.three_point = {"A", "D", "shell"};
  EXPECT_FALSE(make_dataset(record, "run.db").three_point_stand_in);
}

TEST(Dataset, SaysWhereItsGapsAre) {
  record::Record record = four_seconds();
  record.gaps = {{10, 19, "power cut"}};
  EXPECT_EQ(make_dataset(record, "run.db").gaps_s.front(), (std::pair{10.0, 20.0}));
}

}  // namespace
}  // namespace gyrotherm::data
