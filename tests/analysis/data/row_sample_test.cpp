// SPDX-License-Identifier: Apache-2.0
#include "analysis/data/row_sample.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace gyrotherm::data {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Returns rates of normal noise, rounded to a step.
Dataset noise_record(std::uint64_t seed, Eigen::Index rows, double step) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(12, 0.8);
  Dataset dataset;
  dataset.imported = true;
  dataset.bias_zero = kNothingRemoved;
  dataset.time_s = Eigen::VectorXd::LinSpaced(rows, 0, static_cast<double>(rows - 1));
  dataset.bias_deg_per_h.resize(rows);
  for (double& rate : dataset.bias_deg_per_h) rate = step * std::round(normal(random) / step);
  return dataset;
}

/// Returns the rows from `first` on, with times that begin at 0.
Dataset cut_rows(const Dataset& whole, Eigen::Index first, Eigen::Index count) {
  Dataset part = whole;
  part.time_s = Eigen::VectorXd::LinSpaced(count, 0, static_cast<double>(count - 1));
  part.bias_deg_per_h = whole.bias_deg_per_h.segment(first, count);
  return part;
}

constexpr double kAll = 1e9;

TEST(RowSample, RecognisesAnyPieceOfRecord) {
  const Dataset whole = noise_record(1, 20'000, 1e-4);
  const auto sample = sample_rows(whole, 0, kAll);
  ASSERT_EQ(sample.size(), 256u);
  EXPECT_TRUE(has_rows_of(whole, sample, 0, kAll));
  int found = 0;
  for (Eigen::Index first = 0; first + 1000 <= 20'000; first += 997) {
    EXPECT_TRUE(has_rows_of(cut_rows(whole, first, 1000), sample, 0, kAll)) << first;
    ++found;
  }
  EXPECT_EQ(found, 20);
}

TEST(RowSample, DoesNotDependOnEarthRateUnitOrMissingRows) {
  const Dataset whole = noise_record(2, 5000, 1e-4);
  const auto sample = sample_rows(whole, 0, kAll);
  Dataset other = whole;
  other.bias_zero = "earth rate removed";
  other.earth_rate_deg_per_h = 10.6;
  other.bias_deg_per_h.array() -= 10.6;
  EXPECT_TRUE(has_rows_of(other, sample, 0, kAll));
  Dataset in_degrees_per_second = whole;
  for (double& rate : in_degrees_per_second.bias_deg_per_h) rate = rate / 3600 * 3600;
  EXPECT_TRUE(has_rows_of(in_degrees_per_second, sample, 0, kAll));
  Dataset torn = whole;
  for (Eigen::Index row = 0; row < 5000; row += 100) torn.bias_deg_per_h(row) = kNan;
  EXPECT_TRUE(has_rows_of(torn, sample, 0, kAll));
}

TEST(RowSample, DoesNotAccuseOtherRecords) {
  for (const double step : {1e-4, 0.1, 0.8}) {
    const auto sample = sample_rows(noise_record(3, 20'000, step), 0, kAll);
    EXPECT_FALSE(sample.empty());
    for (std::uint64_t seed = 10; seed < 30; ++seed)
      EXPECT_FALSE(has_rows_of(noise_record(seed, 20'000, step), sample, 0, kAll)) << step << " " << seed;
  }
}

TEST(RowSample, IgnoresSequencesThatOccurByChance) {
  Dataset frozen = noise_record(4, 2000, 1e-4);
  frozen.bias_deg_per_h.setConstant(12);
  EXPECT_TRUE(sample_rows(frozen, 0, kAll).empty());
  EXPECT_FALSE(has_rows_of(frozen, {}, 0, kAll));
  EXPECT_TRUE(sample_rows(noise_record(5, 15, 1e-4), 0, kAll).empty()) << "shorter than a sequence";
  EXPECT_TRUE(sample_rows(Dataset{}, 0, kAll).empty());
}

TEST(RowSample, ComparesOnlyGivenPeriod) {
  const Dataset whole = noise_record(6, 10'000, 1e-4);
  const auto first_half = sample_rows(whole, 0, 5000);
  EXPECT_FALSE(has_rows_of(whole, first_half, 5000, kAll));
  EXPECT_TRUE(has_rows_of(whole, first_half, 4000, kAll));
}

}  // namespace
}  // namespace gyrotherm::data
