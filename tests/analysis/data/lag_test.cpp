// SPDX-License-Identifier: Apache-2.0
#include "analysis/data/lag.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "analysis/data/clusters.hpp"
#include "analysis/data/features.hpp"
#include "tests/analysis/synthetic_run.hpp"

namespace gyrotherm::data {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

TEST(Lag, IsTheExactSolutionForAStaircase) {
  const double tau = 600, step = 100;
  FirstOrderLag lag(tau);
  EXPECT_EQ(lag.push(20, kNever), 0) << "a run starts in balance";
  for (int k = 1; k <= 40; ++k) EXPECT_NEAR(lag.push(30, step), 10 * std::exp(-k * step / tau), 1e-12);
}

TEST(Lag, BehindARampIsItsRateTimesTheTimeConstant) {
  const double tau = 600, fine_s = 0.5, rate = 1.0 / 60;  // K/s
  FirstOrderLag lag(tau);
  double behind = lag.push(0, kNever);
  for (int k = 1; k <= 20000; ++k) behind = lag.push(rate * fine_s * k, fine_s);
  EXPECT_NEAR(behind, rate * tau, 2 * rate * fine_s) << "but for the width of a stair";
}

TEST(Lag, OverAGapIsOneLongStep) {
  FirstOrderLag whole(2400), gap(2400);
  for (FirstOrderLag* lag : {&whole, &gap}) lag->push(20, kNever);
  double behind = 0;
  for (int k = 0; k < 7; ++k) behind = whole.push(25, 100);
  EXPECT_NEAR(gap.push(25, 700), behind, 1e-12);
  EXPECT_NEAR(gap.push(-40, 1e6), 0, 1e-12) << "long after, the body is in balance again";
}

std::vector<Term> lags() {
  return {lag_term(600, "A"), lag_term(2400, "H"), lag_term(600, "A") * temperature_term("B")};
}

TEST(Lags, OfAPartAreThoseOfTheWholeRun) {
  const Clusters clusters = *make_clusters(make_synthetic_run({}));
  const SampleMatrix whole = *evaluate(lags(), clusters);
  const std::vector<Eigen::Index> rows = {0, 3, 4, 50, 51, 90};
  const Clusters part = pick(clusters, rows);
  EXPECT_EQ(*evaluate(lags(), part), SampleMatrix(whole(rows, Eigen::all)));
  EXPECT_EQ(*evaluate(lags(), pick(part, {1, 5})), SampleMatrix(whole(std::vector<int>{3, 90}, Eigen::all)));
  EXPECT_TRUE(whole.row(0).isZero(0)) << "a run starts in balance";
}

TEST(Lags, AreTheRecursionByHand) {
  const Clusters clusters = *make_clusters(make_synthetic_run({}));
  const SampleMatrix values = *evaluate(lags(), clusters);
  double followed = clusters.temperature_c(0, 0);
  for (Eigen::Index k = 1; k < values.rows(); ++k) {
    followed += (1 - std::exp(-100.0 / 600)) * (clusters.temperature_c(k, 0) - followed);
    ASSERT_NEAR(values(k, 0), clusters.temperature_c(k, 0) - followed, 1e-11) << k;
    ASSERT_NEAR(values(k, 2), values(k, 0) * clusters.temperature_c(k, 1), 1e-11) << k;
  }
}

TEST(Lags, StartAnewWithEachRun) {
  const Clusters one = *make_clusters(make_synthetic_run({})),
                 other = *make_clusters(make_synthetic_run({.run_id = "b", .cycle_rates_c_per_min = {2.5, 4.5}}));
  const Clusters both = *concatenate({pick(one, {7, 8}), other});
  SampleMatrix expected(2 + other.start_s.size(), 3);
  expected << *evaluate(lags(), pick(one, {7, 8})), *evaluate(lags(), other);
  EXPECT_EQ(*evaluate(lags(), both), expected);
  EXPECT_EQ(*evaluate(lags(), pick(both, {1, 2})), SampleMatrix(expected.middleRows(1, 2)));
}

TEST(Lags, BridgeADroppedCluster) {
  Dataset dataset = make_synthetic_run({});
  const std::vector<Term> terms = {lag_term(600, "A"), lag_term(600, "D")};
  const SampleMatrix whole = *evaluate(terms, *make_clusters(dataset));
  dataset.temperature_c(1234, 3) = std::nan("");
  const Clusters clusters = *make_clusters(dataset);
  ASSERT_EQ(clusters.dropped_gaps, 1);
  const SampleMatrix values = *evaluate(terms, clusters);
  EXPECT_EQ(SampleMatrix(values.topRows(12)), SampleMatrix(whole.topRows(12)));
  EXPECT_EQ(values(12, 0), whole(13, 0)) << "A was known all the time";
  const double followed = clusters.temperature_c(11, 3) - values(11, 1);
  EXPECT_NEAR(values(12, 1), std::exp(-200.0 / 600) * (clusters.temperature_c(12, 3) - followed), 1e-12);
}

TEST(Lags, NeedTheWholeRun) {
  Clusters clusters;
  clusters.thermometers = {"A"};
  clusters.temperature_c = Eigen::Vector3d(1, 2, 3);
  const auto values = evaluate({lag_term(600, "A")}, clusters);
  ASSERT_FALSE(values);
  EXPECT_EQ(values.error().where, "input \"lag:600:A\"");
}

TEST(LagTerm, IsReadAsItIsWritten) {
  const std::vector<std::string> names = {"A", "B", "die-cap", "C:D"};
  for (const char* word :
       {"lag:600:A", "A*lag:600:A", "lag:1:die-cap^2", "rate:A*lag:86400:B", "lag:60:A*lag:600:A", "lag:600:C:D"}) {
    const auto term = parse_term(word, names);
    ASSERT_TRUE(term) << word;
    EXPECT_EQ(to_string(*term), word);
    EXPECT_EQ(lags_in({*term}).empty(), false);
  }
  EXPECT_EQ(*parse_term("lag:600:A", names), lag_term(600, "A"));
  EXPECT_EQ(*parse_term("lag:600:A", {"A", "lag:600:A"}), temperature_term("lag:600:A")) << "a whole name comes first";
  for (const char* word : {"lag:", "lag:A", "lag:600", "lag:0:A", "lag:-5:A", "lag:6.5:A", "lag:86401:A", "lag::A",
                           "lag:99999999999:A", "lag:600:Z", "lag:600:A-B"})
    EXPECT_EQ(parse_term(word, names).error().kind, FaultKind::usage) << word;
}

TEST(LagTerm, RaisesTheRank) {
  EXPECT_EQ(rank_of({temperature_term("A"), lag_term(600, "A"), lag_term(2400, "A")}), 3);
  EXPECT_EQ(rank_of({lag_term(600, "A") * temperature_term("A"), temperature_term("A") * lag_term(600, "A")}), 1);
}

TEST(LagTerm, AsATemperatureIsTheSameProduct) {
  const Term term = lag_term(600, "A") * temperature_term("B");
  const Term renamed = with_lags_as_temperatures(term);
  EXPECT_EQ(lags_in({term}), std::vector<Factor>{lag_term(600, "A").factors.front()});
  EXPECT_TRUE(lags_in({renamed}).empty());
  EXPECT_EQ(std::ranges::count(renamed.factors, lag_name(lag_term(600, "A").factors.front()), &Factor::first), 1);
}

}  // namespace
}  // namespace gyrotherm::data
