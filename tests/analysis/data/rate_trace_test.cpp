// SPDX-License-Identifier: Apache-2.0
#include "analysis/data/rate_trace.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace gyrotherm::data {
namespace {

constexpr double kForever_s = 1e9;

Dataset make_rate_dataset(Eigen::Index rows, double spacing_s) {
  Dataset dataset;
  dataset.imported = true;
  dataset.bias_zero = kNothingRemoved;
  dataset.time_s = Eigen::VectorXd::LinSpaced(rows, 0, spacing_s * static_cast<double>(rows - 1));
  dataset.bias_deg_per_h.resize(rows);
  return dataset;
}

/// Returns a run of one profile: temperature cycles of 2 h and a thermostat of 4 min that every run has, and the noise
/// of one run with `noise` °/h per row.
Dataset run_profile(std::uint64_t seed, Eigen::Index rows = 4000, double spacing_s = 10, double noise = 0.3) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Dataset dataset = make_rate_dataset(rows, spacing_s);
  for (Eigen::Index row = 0; row < rows; ++row) {
    const double t = dataset.time_s(row);
    const double ramp = std::abs(std::fmod(t / 7200, 2.0) - 1);
    dataset.bias_deg_per_h(row) = 3 + 2 * ramp + 0.1 * std::sin(t * 6.283 / 240) + noise * normal(random);
  }
  return dataset;
}

/// Returns means of `count` consecutive rows, at the time of the first one plus `delay_s`.
Dataset average_rates(const Dataset& rows, Eigen::Index count, double delay_s = 0) {
  Dataset means = make_rate_dataset(rows.time_s.size() / count, 1);
  for (Eigen::Index i = 0; i < means.time_s.size(); ++i) {
    means.time_s(i) = rows.time_s(i * count) + delay_s;
    means.bias_deg_per_h(i) = rows.bias_deg_per_h.segment(i * count, count).mean();
  }
  return means;
}

Dataset cut_rates(const Dataset& rows, Eigen::Index first, Eigen::Index count) {
  Dataset part = make_rate_dataset(count, 1);
  part.time_s = rows.time_s.segment(first, count).array() - rows.time_s(first);
  part.bias_deg_per_h = rows.bias_deg_per_h.segment(first, count);
  return part;
}

Dataset convert_rates(Dataset rows, double factor, double step) {
  for (double& rate : rows.bias_deg_per_h) rate = step * std::round(rate * factor / step) / factor;
  return rows;
}

TEST(RateTrace, RecognisesOtherUnitsAndFewerDecimals) {
  const Dataset run = run_profile(1);
  const auto trace = trace_rates(run, 0, kForever_s);
  EXPECT_EQ(trace.interval_s, 10);
  EXPECT_EQ(trace.means.size(), 8000u);
  EXPECT_TRUE(has_rates_of(run, trace, 0, kForever_s));
  EXPECT_TRUE(has_rates_of(convert_rates(run, 1 / 3600.0, 1e-9), trace, 0, kForever_s)) << "°/s";
  for (const double step : {0.01, 0.1, 0.25})
    EXPECT_TRUE(has_rates_of(convert_rates(run, 1, step), trace, 0, kForever_s)) << step;
  Dataset reduced = run;
  reduced.bias_zero = "earth rate removed";
  reduced.earth_rate_deg_per_h = 10.6;
  reduced.bias_deg_per_h.array() -= 10.6;
  EXPECT_TRUE(has_rates_of(reduced, trace, 0, kForever_s));
  Dataset drifting = run;
  drifting.bias_deg_per_h -= 0.05 * drifting.time_s;
  EXPECT_TRUE(has_rates_of(drifting, trace_rates(drifting, 0, kForever_s), 0, kForever_s)) << "codes wrap around";
}

TEST(RateTrace, RecognisesMeans) {
  for (const double spacing_s : {1.0, 10.0}) {
    const Dataset run = run_profile(2, 9000, spacing_s);
    const auto trace = trace_rates(run, 0, kForever_s);
    for (const int count : {2, 3, 5, 6, 10, 20}) {
      EXPECT_TRUE(has_rates_of(average_rates(run, count), trace, 0, kForever_s)) << spacing_s << " " << count;
      const double middle = spacing_s * (count - 1) / 2;
      EXPECT_TRUE(has_rates_of(average_rates(run, count, middle), trace, 0, kForever_s))
          << "middle " << spacing_s << " " << count;
    }
    EXPECT_TRUE(
        has_rates_of(convert_rates(average_rates(cut_rates(run, 1237, 4000), 2), 1, 0.05), trace, 0, kForever_s))
        << spacing_s;
  }
  const Dataset run = run_profile(3, 9000, 1);
  EXPECT_TRUE(has_rates_of(run, trace_rates(average_rates(run, 20), 0, kForever_s), 0, kForever_s))
      << "trained on means of these rows";
}

TEST(RateTrace, RecognisesPiecesWithMissingRows) {
  const Dataset run = run_profile(4, 6000);
  const auto trace = trace_rates(run, 0, kForever_s);
  int pieces = 0;
  for (Eigen::Index first = 3; first + 150 <= 6000; first += 853, ++pieces) {
    Dataset piece = convert_rates(cut_rates(run, first, 150), 1, 0.01);
    EXPECT_TRUE(has_rates_of(piece, trace, 0, kForever_s)) << first;
    piece.bias_deg_per_h(70) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_TRUE(has_rates_of(piece, trace, 0, kForever_s)) << first;
  }
  EXPECT_EQ(pieces, 7);
  Dataset mixed = run_profile(5, 3000);
  mixed.bias_deg_per_h.tail(1000) = run.bias_deg_per_h.segment(411, 1000);
  EXPECT_TRUE(has_rates_of(mixed, trace, 0, kForever_s));
  EXPECT_FALSE(has_rates_of(mixed, trace, 0, 20'000)) << "before the common rows";
}

/// Equal noise at another level belongs to a constructed record, not to an export.
TEST(RateTrace, DistinguishesLevelAndScale) {
  const Dataset run = run_profile(9);
  const auto trace = trace_rates(run, 0, kForever_s);
  Dataset other = run;
  other.bias_deg_per_h.array() += 12;
  EXPECT_FALSE(has_rates_of(other, trace, 0, kForever_s));
  other.bias_deg_per_h = -5 * run.bias_deg_per_h;
  EXPECT_FALSE(has_rates_of(other, trace, 0, kForever_s));
}

/// A thermostat that turns the phase of its cycle makes two runs similar, but not their noise.
TEST(RateTrace, DoesNotAccuseOtherRunsOfProfile) {
  for (const double noise : {0.02, 0.3}) {
    const auto trace = trace_rates(run_profile(10, 3000, 10, noise), 0, kForever_s);
    ASSERT_FALSE(trace.means.empty());
    for (std::uint64_t seed = 11; seed < 31; ++seed) {
      const Dataset other = run_profile(seed, 3000, 10, noise);
      EXPECT_FALSE(has_rates_of(other, trace, 0, kForever_s)) << noise << " " << seed;
      EXPECT_FALSE(has_rates_of(average_rates(other, 2), trace, 0, kForever_s)) << noise << " " << seed;
      EXPECT_FALSE(has_rates_of(convert_rates(other, 1, 0.5), trace, 0, kForever_s)) << noise << " " << seed;
    }
  }
}

/// Returns the counts of a gyro that gives few pulses in a second, as a rate in pulses. It carries the part of a pulse
/// to the next second.
Dataset count_pulses(std::uint64_t seed, Eigen::Index rows, double rate, double noise) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Dataset dataset = make_rate_dataset(rows, 1);
  double angle = 0.37 * static_cast<double>(seed % 7), counted = std::floor(angle);
  for (Eigen::Index row = 0; row < rows; ++row) {
    angle += rate + 0.1 * std::sin(static_cast<double>(row) / 1500) + noise * normal(random);
    dataset.bias_deg_per_h(row) = std::floor(angle) - counted;
    counted = std::floor(angle);
  }
  return dataset;
}

TEST(RateTrace, DistinguishesRunsOfGyroWithFewPulses) {
  for (const double rate : {106.5, 106.33, 106.9, 106.0})
    for (const double noise : {0.0, 0.02, 0.3}) {
      const auto run = count_pulses(1, 4000, rate, noise);
      const auto trace = trace_rates(run, 0, kForever_s);
      ASSERT_FALSE(trace.means.empty()) << rate << " " << noise;
      EXPECT_TRUE(has_rates_of(run, trace, 0, kForever_s)) << rate << " " << noise;
      if (noise == 0) continue;  // every run is the same
      for (std::uint64_t seed = 2; seed < 8; ++seed)
        EXPECT_FALSE(has_rates_of(count_pulses(seed, 4000, rate, noise), trace, 0, kForever_s))
            << rate << " " << noise << " " << seed;
    }
}

/// Windows with a missing mean are no evidence.
TEST(RateTrace, CountsOnlyWindowsThatAreKnownInBoth) {
  const auto thin_out = [](Dataset dataset, Eigen::Index period, Eigen::Index kept) {
    for (Eigen::Index row = 0; row < dataset.time_s.size(); ++row)
      if (row % period >= kept) dataset.bias_deg_per_h(row) = std::numeric_limits<double>::quiet_NaN();
    return dataset;
  };
  for (const Eigen::Index period : {37, 60, 90}) {
    const auto run = thin_out(run_profile(40), period, 7);
    const auto trace = trace_rates(run, 0, kForever_s);
    for (std::uint64_t seed = 41; seed < 51; ++seed)
      EXPECT_FALSE(has_rates_of(thin_out(run_profile(seed), period, 7), trace, 0, kForever_s)) << period << seed;
    EXPECT_TRUE(
        has_rates_of(run_profile(40), trace_rates(thin_out(run_profile(40), 100, 80), 0, kForever_s), 0, kForever_s));
  }
}

TEST(RateTrace, IgnoresConstantAndShortRecords) {
  Dataset constant = run_profile(6, 500);
  constant.bias_deg_per_h.setConstant(12);
  EXPECT_TRUE(trace_rates(constant, 0, kForever_s).means.empty());
  const auto trace = trace_rates(run_profile(7), 0, kForever_s);
  EXPECT_FALSE(has_rates_of(constant, trace, 0, kForever_s));
  EXPECT_FALSE(has_rates_of(cut_rates(run_profile(7), 0, 30), trace, 0, kForever_s)) << "too short for a decision";
  EXPECT_TRUE(trace_rates(Dataset{}, 0, kForever_s).means.empty());
  EXPECT_FALSE(has_rates_of(Dataset{}, trace, 0, kForever_s));
}

TEST(RateTrace, RefusesTextsThatAreNoTrace) {
  const Dataset run = run_profile(8);
  EXPECT_FALSE(has_rates_of(run, {10, 0, 1, "AAB"}, 0, kForever_s));
  EXPECT_FALSE(has_rates_of(run, {10, 0, 1, std::string(200, '?')}, 0, kForever_s));
  EXPECT_FALSE(has_rates_of(run, {10, 0, 1, std::string(200, '/')}, 0, kForever_s)) << "all missing";
  EXPECT_FALSE(has_rates_of(run, {0, 0, 1, std::string(200, 'A')}, 0, kForever_s));
  EXPECT_FALSE(has_rates_of(run, {1e-300, 0, 1, trace_rates(run, 0, kForever_s).means}, 0, kForever_s));
}

}  // namespace
}  // namespace gyrotherm::data
