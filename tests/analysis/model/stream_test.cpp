// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/stream.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "tests/analysis/small_model.hpp"

namespace gyrotherm::model {
namespace {

/// Returns a record in which both thermometers are on ramps. A is faster.
data::Dataset two_ramps(Eigen::Index rows) {
  data::Dataset dataset;
  dataset.thermometers = {"A", "B"};
  dataset.time_s = Eigen::VectorXd::LinSpaced(rows, 0, static_cast<double>(rows - 1));
  dataset.temperature_c.resize(rows, 2);
  dataset.temperature_c << 20 + 2e-3 * dataset.time_s.array(), 20 + 1e-3 * dataset.time_s.array();
  dataset.bias_deg_per_h = Eigen::VectorXd::Constant(rows, 0.5);
  dataset.set_point_c = dataset.temperature_c.col(0);
  dataset.segment.setConstant(rows, -1);
  dataset.cycle.setConstant(rows, -1);
  return dataset;
}

data::SampleMatrix random_temperatures(Eigen::Index rows, std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal(20, 0.3);
  return data::SampleMatrix::NullaryExpr(rows, 2, [&] { return normal(generator); });
}

CompensationStream open(std::vector<std::string> columns = {"A", "B"}, Outside outside = Outside::continued) {
  auto stream = CompensationStream::open(data::small_svr_model(), std::move(columns), outside);
  EXPECT_TRUE(stream);
  return std::move(*stream);
}

Eigen::VectorXd zeros(Eigen::Index rows) { return Eigen::VectorXd::Zero(rows); }

/// Requires equal values. NaN equals NaN.
void expect_equal(const Eigen::VectorXd& one, const Eigen::VectorXd& other) {
  ASSERT_EQ(one.size(), other.size());
  for (Eigen::Index i = 0; i < one.size(); ++i) {
    EXPECT_TRUE(one(i) == other(i) || (std::isnan(one(i)) && std::isnan(other(i)))) << "row " << i;
  }
}

TEST(CompensationStream, EqualsClusterPredictionAtClusterEnds) {
  const data::Dataset dataset = two_ramps(1000);
  const Eigen::VectorXd predicted = *predict(data::small_svr_model(), *make_clusters(dataset));
  const Eigen::VectorXd compensated = open().push(dataset.temperature_c, dataset.bias_deg_per_h);
  for (Eigen::Index i = 0; i < 1000; ++i) {
    EXPECT_EQ(std::isnan(compensated(i)), i < 199) << "a rate requires two means, row " << i;
    if (i >= 199 && i % 100 == 99) {
      EXPECT_NEAR(compensated(i), 0.5 - predicted(i / 100), 1e-12);
    }
  }
}

TEST(CompensationStream, DoesNotDependOnDivisionIntoCalls) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(seed);
    data::SampleMatrix temperatures = random_temperatures(1500, seed);
    temperatures(700, 1) = std::nan("");
    const Eigen::VectorXd bias = temperatures.col(0);
    const Eigen::VectorXd whole = open().push(temperatures, bias);
    CompensationStream stream = open();
    std::mt19937_64 generator(seed);
    Eigen::VectorXd pieces(1500);
    for (Eigen::Index from = 0; from < 1500;) {
      const Eigen::Index rows = std::min<Eigen::Index>(1500 - from, static_cast<Eigen::Index>(generator() % 80));
      pieces.segment(from, rows) = stream.push(temperatures.middleRows(from, rows), bias.segment(from, rows));
      from += rows;
    }
    expect_equal(pieces, whole);
  }
}

TEST(CompensationStream, AcceptsColumnsInAnyOrder) {
  const data::SampleMatrix temperatures = random_temperatures(300, 1);
  data::SampleMatrix turned(300, 3);
  turned << Eigen::VectorXd::Random(300), temperatures.col(1), temperatures.col(0);
  expect_equal(open({"shell", "B", "A"}).push(turned, zeros(300)), open().push(temperatures, zeros(300)));
}

TEST(CompensationStream, RecoversAfterMissingReading) {
  const data::SampleMatrix temperatures = random_temperatures(900, 2);
  data::SampleMatrix missing = temperatures;
  missing(330, 0) = std::nan("");
  const Eigen::VectorXd whole = open().push(temperatures, zeros(900)), gap = open().push(missing, zeros(900));
  expect_equal(gap.head(330), whole.head(330));
  EXPECT_TRUE(gap.segment(330, 200).array().isNaN().all()) << "two means contain the missing reading";
  expect_equal(gap.tail(370), whole.tail(370));
}

TEST(CompensationStream, ContinuesOutsideTrainedRangeAndCountsRows) {
  data::SampleMatrix temperatures = random_temperatures(400, 3);
  temperatures.col(1).array() -= 5;  // trained up to 1 °C
  CompensationStream continued = open();
  const Eigen::VectorXd held = continued.push(temperatures, zeros(400));
  EXPECT_TRUE(held.tail(201).allFinite());
  EXPECT_EQ(continued.outside(), 201);
  EXPECT_GT(continued.excess().tail(201).minCoeff(), 1) << "at least 4 °C outside a range of 2 °C";
  EXPECT_EQ(continued.excess().head(199), zeros(199));
  const Eigen::VectorXd refused = open({"A", "B"}, Outside::refuse).push(temperatures, zeros(400));
  EXPECT_TRUE(refused.array().isNaN().all());
  temperatures.col(1) = temperatures.col(0).array() - 0.25;
  CompensationStream inside = open();
  EXPECT_TRUE(inside.push(temperatures, zeros(400)).tail(201).allFinite());
  EXPECT_EQ(inside.outside(), 0);
}

/// On a ramp of 0.01 K/s, a mean over 100 s lags by 49.5 s. The extrapolation adds half of the change over the last 100
/// s, which is 50 s of the ramp.
TEST(CompensationStream, ExtrapolatesByHalfAClusterIfModelIsLed) {
  Model model = data::small_slope_model();
  const data::SampleMatrix ramp = 20 + 0.01 * Eigen::ArrayXd::LinSpaced(500, 0, 499);
  const auto lagging = CompensationStream::open(model, {"A"})->push(ramp, zeros(500));
  model.latency = {.lag_s = 50, .is_led = true};
  const auto led = CompensationStream::open(model, {"A"})->push(ramp, zeros(500));
  EXPECT_NEAR(lagging(499), -0.1 * 0.01 * (499 - 49.5), 1e-12);
  EXPECT_NEAR(led(499), -0.1 * 0.01 * (499 + 0.5), 1e-12);
  expect_equal(led.head(199), lagging.head(199));
  CompensationStream in_pieces = *CompensationStream::open(model, {"A"});
  Eigen::VectorXd pieces(500);
  for (const Eigen::Index from : {0, 70, 250, 260}) {
    const Eigen::Index count = (from == 0 ? 70 : from == 70 ? 180 : from == 250 ? 10 : 240);
    pieces.segment(from, count) = in_pieces.push(ramp.middleRows(from, count), zeros(count));
  }
  expect_equal(pieces, led);
}

/// The bias follows a sine with a period of 2 h. The error from the lag of 50 s is proportional to its slope, and the
/// error of the extrapolation to its curvature.
TEST(Latency, UsesConsecutiveMeans) {
  data::Clusters clusters;
  clusters.length_s = 100;
  clusters.start_s = Eigen::VectorXd::LinSpaced(720, 0, 71900);
  const Eigen::VectorXd predicted = (clusters.start_s.array() * (2 * std::numbers::pi / 7200)).sin();
  const auto latency = measure_latency(data::small_slope_model(), clusters, predicted);
  ASSERT_TRUE(latency);
  const double turn = 2 * std::numbers::pi * 100 / 7200;
  EXPECT_NEAR(latency->lagging_rms_deg_per_h, turn / 2 / std::numbers::sqrt2, 1e-3 * turn);
  EXPECT_NEAR(latency->led_rms_deg_per_h, turn * turn / 2 / std::numbers::sqrt2, 1e-2 * turn * turn);
  EXPECT_TRUE(latency->is_led);
  EXPECT_EQ(latency->lag_s, 50);
  std::mt19937_64 random(3);
  std::normal_distribution<double> noise(0, 1);
  const Eigen::VectorXd white = Eigen::VectorXd::NullaryExpr(720, [&] { return noise(random); });
  EXPECT_FALSE(measure_latency(data::small_slope_model(), clusters, white)->is_led)
      << "extrapolation would amplify the noise";
  clusters.start_s = Eigen::Vector4d(0, 100, 500, 600);
  EXPECT_FALSE(measure_latency(data::small_slope_model(), clusters, predicted.head(4)))
      << "there are no three consecutive clusters";
}

TEST(CompensationStream, RefusesMissingThermometers) {
  EXPECT_EQ(CompensationStream::open(data::small_svr_model(), {"A", "C"}).error().kind, FaultKind::usage);
}

Model lag_model() {
  Model model = data::small_svr_model();
  model.terms = {data::lag_term(600, "A") * data::temperature_term("B"), data::lag_term(250, "B")};
  model.input_min = Eigen::RowVector2d{-100, -100};
  model.input_max = Eigen::RowVector2d{100, 100};
  return model;
}

/// The temperatures follow a random walk. One missing reading drops one cluster.
TEST(CompensationStream, EqualsClusterLagsAtClusterEnds) {
  data::Dataset dataset = two_ramps(3000);
  data::SampleMatrix steps = random_temperatures(3000, 5);
  for (Eigen::Index i = 1; i < 3000; ++i)
    dataset.temperature_c.row(i) = dataset.temperature_c.row(i - 1) + 0.2 * (steps.row(i).array() - 20).matrix();
  dataset.temperature_c(1234, 1) = std::nan("");
  const data::Clusters clusters = *make_clusters(dataset);
  ASSERT_EQ(clusters.dropped_gaps, 1);
  const Eigen::VectorXd predicted = *predict(lag_model(), clusters);
  const Eigen::VectorXd compensated = CompensationStream::open(lag_model(), {"A", "B"}, Outside::extrapolate)
                                          ->push(dataset.temperature_c, dataset.bias_deg_per_h);
  for (Eigen::Index i = 0; i < 99; ++i)
    EXPECT_TRUE(std::isnan(compensated(i))) << "the first mean is incomplete, row " << i;
  for (Eigen::Index k = 0; k < predicted.size(); ++k) {
    const auto end = static_cast<Eigen::Index>(clusters.start_s(k)) + 99;
    EXPECT_NEAR(compensated(end), 0.5 - predicted(k), 1e-12) << k;
  }
  EXPECT_EQ(compensated.array().isNaN().count(), 99 + 100) << "includes the means with the missing reading";
}

TEST(CompensationStream, DoesNotDependOnDivisionIntoCallsWithLags) {
  const data::SampleMatrix temperatures = random_temperatures(900, 6);
  const auto open_lags = [] { return *CompensationStream::open(lag_model(), {"shell", "B", "A"}); };
  data::SampleMatrix turned(900, 3);
  turned << zeros(900), temperatures;
  const Eigen::VectorXd whole = open_lags().push(turned, zeros(900));
  CompensationStream stream = open_lags();
  Eigen::VectorXd pieces(900);
  for (const Eigen::Index from : {0, 300, 600})
    pieces.segment(from, 300) = stream.push(turned.middleRows(from, 300), zeros(300));
  expect_equal(pieces, whole);
  EXPECT_EQ(CompensationStream::open(lag_model(), {"A", "C"}).error().where, "input \"lag:250:B\"");
}

/// Stream of rows with a pause of some seconds.
struct InterruptedStream {
  data::SampleMatrix before = random_temperatures(457, 7), after = random_temperatures(700, 8);
  [[nodiscard]] Eigen::VectorXd rows_without_readings(CompensationStream stream, Eigen::Index seconds) const {
    (void)stream.push(before, zeros(before.rows()));
    (void)stream.push(data::SampleMatrix::Constant(seconds, 2, std::nan("")), zeros(seconds));
    return stream.push(after, zeros(after.rows()));
  }
  [[nodiscard]] Eigen::VectorXd passed(CompensationStream stream, Eigen::Index seconds) const {
    (void)stream.push(before, zeros(before.rows()));
    stream.skip_seconds(seconds);
    return stream.push(after, zeros(after.rows()));
  }
};

TEST(CompensationStream, TreatsPassedSecondsAsMissingReadings) {
  const InterruptedStream interrupted;
  const auto with_lags = [] { return *CompensationStream::open(lag_model(), {"A", "B"}); };
  for (const Eigen::Index seconds : {1, 30, 99, 100, 150, 200, 299, 300, 301, 517, 2043}) {
    SCOPED_TRACE(seconds);
    expect_equal(interrupted.passed(open(), seconds), interrupted.rows_without_readings(open(), seconds));
    expect_equal(interrupted.passed(with_lags(), seconds), interrupted.rows_without_readings(with_lags(), seconds));
  }
  const Eigen::VectorXd after_an_age = interrupted.passed(with_lags(), 1'000'000'000'000);
  EXPECT_EQ(after_an_age.array().isNaN().count(), 99);
}

TEST(CompensationStream, FindsMissingSecondsFromRowTimes) {
  const data::SampleMatrix temperatures = random_temperatures(1100, 9);
  Eigen::VectorXd times(1000);
  data::SampleMatrix rows(1000, 2), with_gap = temperatures;
  with_gap.middleRows(400, 100).setConstant(std::nan(""));
  for (Eigen::Index i = 0; i < 1000; ++i) {
    const Eigen::Index second = i < 400 ? i : i + 100;
    times(i) = 7 + static_cast<double>(second) + (i % 2 == 0 ? 0.1 : 0);  // deviations of a logger
    rows.row(i) = temperatures.row(second);
  }
  const Eigen::VectorXd whole = open().push(with_gap, zeros(1100));
  for (const Eigen::Index piece : {1000, 400, 250}) {
    SCOPED_TRACE(piece);
    CompensationStream stream = open();
    Eigen::VectorXd compensated(1000);
    for (Eigen::Index from = 0; from < 1000; from += piece) {
      const Eigen::Index count = std::min<Eigen::Index>(piece, 1000 - from);
      compensated.segment(from, count) =
          stream.push_at(times.segment(from, count), rows.middleRows(from, count), zeros(count));
      const bool has_gap = from <= 400 && 400 < from + count;
      ASSERT_EQ(stream.gaps().size(), has_gap ? 1u : 0u);
      if (has_gap) {
        EXPECT_EQ(stream.gaps()[0].row, 400 - from);
        EXPECT_EQ(stream.gaps()[0].seconds, 100);
      }
    }
    expect_equal(compensated.head(400), whole.head(400));
    expect_equal(compensated.tail(600), whole.tail(600));
  }
}

TEST(CompensationStream, ReportsRowsOutsideAroundGap) {
  data::SampleMatrix temperatures = random_temperatures(600, 3);
  temperatures.col(1).array() -= 5;  // trained up to 1 °C
  Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(600, 0, 599);
  times.tail(300).array() += 50;
  CompensationStream stream = open();
  const Eigen::VectorXd compensated = stream.push_at(times, temperatures, zeros(600));
  ASSERT_EQ(stream.rows_outside().size(), 202u);
  EXPECT_EQ(stream.rows_outside().front(), 199);
  EXPECT_EQ(stream.rows_outside()[101], 499);
  EXPECT_TRUE(compensated.segment(300, 199).array().isNaN().all());
  EXPECT_TRUE(std::isfinite(compensated(499)));
}

TEST(SlidingMeans, EqualMeansOfLastRows) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE(seed);
    const auto length = static_cast<Eigen::Index>(1 + seed % 17);
    const data::SampleMatrix rows = random_temperatures(200, seed);
    SlidingMeans sliding(length, 2);
    for (Eigen::Index i = 0; i < rows.rows(); ++i) {
      const Eigen::RowVectorXd& means = sliding.push(rows.row(i));
      if (i + 1 < length) {
        EXPECT_TRUE(means.array().isNaN().all());
      } else {
        EXPECT_LT((means - rows.middleRows(i + 1 - length, length).colwise().mean()).cwiseAbs().maxCoeff(), 1e-13);
      }
    }
  }
}

TEST(SlidingMeans, DoNotDrift) {
  constexpr Eigen::Index kRows = 300000;
  data::SampleMatrix rows = random_temperatures(kRows, 1);
  // A running sum would retain the rounding errors of these large values.
  rows.topRows(kRows / 2) *= 1e12;
  SlidingMeans sliding(100, 2);
  Eigen::RowVectorXd means;
  for (Eigen::Index i = 0; i < kRows; ++i) means = sliding.push(rows.row(i));
  EXPECT_LT((means - rows.bottomRows(100).colwise().mean()).cwiseAbs().maxCoeff(), 1e-13);
}

}  // namespace
}  // namespace gyrotherm::model
