// SPDX-License-Identifier: Apache-2.0
#include "analysis/data/features.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/analysis/synthetic_run.hpp"

namespace gyrotherm::data {
namespace {

const std::vector<std::string> kOddNames = {"A", "B", "die", "die-cap"};

Clusters two_clusters() {
  Clusters clusters;
  clusters.thermometers = {"A", "B"};
  clusters.temperature_c.resize(2, 2);
  clusters.temperature_c << 1, 4, 3, 7;
  clusters.rate_c_per_min.resize(2, 2);
  clusters.rate_c_per_min << 0, 0, 1.2, 1.8;
  return clusters;
}

TEST(Term, RoundTripsThroughText) {
  for (const char* input : {"A", "A-B", "rate:A", "A^2", "A^3", "A-B^2", "rate:A^3", "A*rate:A", "A*A-B", "A^2*rate:B",
                            "A*B*A-B", "die-cap", "die-cap-A", "A-die-cap", "rate:die-cap", "die-cap^2*die-cap-A"}) {
    const auto term = parse_term(input, kOddNames);
    ASSERT_TRUE(term) << input;
    EXPECT_EQ(to_string(*term), input);
  }
  EXPECT_EQ(*parse_term("die-cap", kOddNames), temperature_term("die-cap")) << "names take precedence over expressions";
  EXPECT_EQ(*parse_term("die-cap-A", kOddNames), (gradient_term("die-cap", "A")));
}

TEST(Term, SuggestsNearestForUnknownThermometer) {
  const auto term = parse_term("A-dye", kOddNames);
  ASSERT_FALSE(term);
  EXPECT_EQ(term.error().kind, FaultKind::usage);
  EXPECT_NE(term.error().what.find("did you mean \"die\"?"), std::string::npos) << term.error().what;
  for (const char* input : {"", "-", "rate:", "^2", "A-A", "rate:A-B"})
    EXPECT_FALSE(parse_term(input, kOddNames)) << input;
}

TEST(Term, IgnoresOrderOfFactors) {
  EXPECT_EQ(*parse_term("rate:A*A", kOddNames), *parse_term("A*rate:A", kOddNames));
  EXPECT_EQ(*parse_term("A*A*A", kOddNames), *parse_term("A^3", kOddNames));
  EXPECT_EQ(*parse_term("B*A^2", kOddNames), *parse_term("A*B*A", kOddNames));
  EXPECT_EQ(*parse_term("A^2", {"A", "A^2"}), temperature_term("A^2")) << "names take precedence over expressions";
  EXPECT_EQ(*parse_term("A*B*A", {"A", "A*B"}), temperature_term("A") * temperature_term("A*B"));
}

TEST(Term, RejectsTooManyFactorsAndUnknownPowers) {
  for (const char* input : {"A*A*A*A", "A^3*B", "A^2*A^2"}) {
    const auto term = parse_term(input, kOddNames);
    ASSERT_FALSE(term) << input;
    EXPECT_NE(term.error().what.find("more than 3 factors"), std::string::npos) << text(term.error());
    EXPECT_EQ(term.error().where, std::string("input \"") + input + "\"");
  }
  EXPECT_NE(parse_term("A^4", kOddNames).error().what.find("^2 or ^3"), std::string::npos);
  EXPECT_NE(parse_term("A*rate:dye", kOddNames).error().what.find("did you mean \"die\"?"), std::string::npos);
  for (const char* input : {"*", "A*", "*A", "A**A", "A*A-A", "A^2^2"})
    EXPECT_FALSE(parse_term(input, kOddNames)) << input;
}

TEST(Term, NamesUnsupportedPowerAndMissingOwnValue) {
  const std::vector<std::string> names{"A", "shell"}, own{"A", "aux:current", "self"};
  for (const char* power : {"^0", "^9", "^99", "^-2", "^2.5", "^"})
    EXPECT_EQ(parse_term(std::string("A") + power, names).error().what,
              std::string("expected the power ^2 or ^3, got ") + power);
  EXPECT_EQ(parse_term("self", names).error().what, "the record has no such value of the unit");
  EXPECT_EQ(parse_term("A-aux:pressure", own).error().what,
            "the record has no such value of the unit; it has aux:current, self");
  EXPECT_TRUE(parse_term("aux:current", own));
}

TEST(Features, EvaluatePerCluster) {
  const auto values = evaluate(
      {temperature_term("B"), gradient_term("A", "B"), rate_term("B"), temperature_term("A") * temperature_term("A")},
      two_clusters());
  ASSERT_TRUE(values);
  SampleMatrix expected(2, 4);
  expected << 4, -3, 0, 1, 7, -4, 1.8, 9;
  EXPECT_EQ(*values, expected);
  EXPECT_FALSE(evaluate({gradient_term("A", "C")}, two_clusters()));
}

TEST(Features, MultiplyFactorsOfProducts) {
  const auto values = evaluate({*parse_term("A^3", kOddNames), *parse_term("A*rate:B", kOddNames),
                                *parse_term("B*A-B", kOddNames), *parse_term("A-B^2", kOddNames)},
                               two_clusters());
  ASSERT_TRUE(values);
  SampleMatrix expected(2, 4);
  expected << 1, 0, -12, 9, 27, 3 * 1.8, -28, 16;
  EXPECT_EQ(*values, expected);
}

TEST(Features, KeepRankForDependentPolynomials) {
  const auto rank = [](std::initializer_list<const char*> inputs) {
    std::vector<Term> terms;
    for (const char* input : inputs) terms.push_back(*parse_term(input, kOddNames));
    return polynomial_rank(terms);
  };
  EXPECT_EQ(rank({"A*A-B", "A^2", "A*B"}), 2);
  EXPECT_EQ(rank({"A-B^2", "A^2", "A*B", "B^2"}), 3);
  EXPECT_EQ(rank({"A", "A^2", "A^3", "rate:A", "A*rate:A"}), 5);
  EXPECT_EQ(rank({"A-B^3", "A-B^2", "A-B"}), 3);
}

TEST(Features, HaveRankSevenForGradientsOfEightThermometers) {
  const auto gradients = all_gradients({"A", "B", "C", "D", "E", "F", "G", "H"});
  EXPECT_EQ(gradients.size(), 28u);
  EXPECT_EQ(polynomial_rank(gradients), 7);
  EXPECT_EQ(polynomial_rank({}), 0);
  EXPECT_EQ(polynomial_rank({temperature_term("A"), temperature_term("A") * temperature_term("A"), rate_term("A")}), 3);
  EXPECT_EQ(polynomial_rank({temperature_term("A"), temperature_term("B"), gradient_term("A", "B")}), 2);
}

TEST(Scaling, GivesZeroMeanAndUnitStd) {
  const std::vector<Term> terms = {temperature_term("A"), temperature_term("B")};
  const auto values = evaluate(terms, two_clusters());
  const auto scaling = fit_scaling(*values, terms);
  ASSERT_TRUE(scaling);
  const SampleMatrix scaled = apply(*scaling, *values);
  EXPECT_NEAR(scaled.colwise().mean().norm(), 0, 1e-15);
  EXPECT_NEAR(scaled.col(0).squaredNorm(), 1, 1e-15);
}

TEST(Scaling, NamesConstantInput) {
  SampleMatrix values = SampleMatrix::Constant(3, 1, 20.1);
  const auto scaling = fit_scaling(values, {gradient_term("A", "B")});
  ASSERT_FALSE(scaling);
  EXPECT_EQ(scaling.error().where, "input \"A-B\"");
}

constexpr double kNever = std::numeric_limits<double>::infinity();

TEST(Lag, MatchesExactSolutionForStaircase) {
  const double tau = 600, step = 100;
  FirstOrderLag lag(tau);
  EXPECT_EQ(lag.push(20, kNever), 0) << "a run starts in equilibrium";
  for (int k = 1; k <= 40; ++k) EXPECT_NEAR(lag.push(30, step), 10 * std::exp(-k * step / tau), 1e-12);
}

TEST(Lag, EqualsRateTimesTimeConstantForRamp) {
  const double tau = 600, fine_s = 0.5, rate = 1.0 / 60;  // K/s
  FirstOrderLag lag(tau);
  double behind = lag.push(0, kNever);
  for (int k = 1; k <= 20000; ++k) behind = lag.push(rate * fine_s * k, fine_s);
  EXPECT_NEAR(behind, rate * tau, 2 * rate * fine_s) << "within the error of the steps";
}

TEST(Lag, TreatsGapAsOneLongStep) {
  FirstOrderLag whole(2400), gap(2400);
  for (FirstOrderLag* lag : {&whole, &gap}) lag->push(20, kNever);
  double behind = 0;
  for (int k = 0; k < 7; ++k) behind = whole.push(25, 100);
  EXPECT_NEAR(gap.push(25, 700), behind, 1e-12);
  EXPECT_NEAR(gap.push(-40, 1e6), 0, 1e-12) << "in equilibrium again after a long time";
}

std::vector<Term> lags() {
  return {lag_term(600, "A"), lag_term(2400, "H"), lag_term(600, "A") * temperature_term("B")};
}

TEST(Lags, UseHistoryOfWholeRunForSelectedClusters) {
  const Clusters clusters = *make_clusters(make_synthetic_run({}));
  const SampleMatrix whole = *evaluate(lags(), clusters);
  const std::vector<Eigen::Index> rows = {0, 3, 4, 50, 51, 90};
  const Clusters part = pick_clusters(clusters, rows);
  EXPECT_EQ(*evaluate(lags(), part), SampleMatrix(whole(rows, Eigen::all)));
  EXPECT_EQ(*evaluate(lags(), pick_clusters(part, {1, 5})), SampleMatrix(whole(std::vector<int>{3, 90}, Eigen::all)));
  EXPECT_TRUE(whole.row(0).isZero(0)) << "a run starts in equilibrium";
}

TEST(Lags, MatchRecursion) {
  const Clusters clusters = *make_clusters(make_synthetic_run({}));
  const SampleMatrix values = *evaluate(lags(), clusters);
  double followed = clusters.temperature_c(0, 0);
  for (Eigen::Index k = 1; k < values.rows(); ++k) {
    followed += (1 - std::exp(-100.0 / 600)) * (clusters.temperature_c(k, 0) - followed);
    ASSERT_NEAR(values(k, 0), clusters.temperature_c(k, 0) - followed, 1e-11) << k;
    ASSERT_NEAR(values(k, 2), values(k, 0) * clusters.temperature_c(k, 1), 1e-11) << k;
  }
}

TEST(Lags, RestartWithEachRun) {
  const Clusters one = *make_clusters(make_synthetic_run({})),
                 other = *make_clusters(make_synthetic_run({.run_id = "b", .cycle_rates_c_per_min = {2.5, 4.5}}));
  const Clusters both = *concatenate({pick_clusters(one, {7, 8}), other});
  SampleMatrix expected(2 + other.start_s.size(), 3);
  expected << *evaluate(lags(), pick_clusters(one, {7, 8})), *evaluate(lags(), other);
  EXPECT_EQ(*evaluate(lags(), both), expected);
  EXPECT_EQ(*evaluate(lags(), pick_clusters(both, {1, 2})), SampleMatrix(expected.middleRows(1, 2)));
}

TEST(Lags, BridgeDroppedCluster) {
  Dataset dataset = make_synthetic_run({});
  const std::vector<Term> terms = {lag_term(600, "A"), lag_term(600, "D")};
  const SampleMatrix whole = *evaluate(terms, *make_clusters(dataset));
  dataset.temperature_c(1234, 3) = std::nan("");
  const Clusters clusters = *make_clusters(dataset);
  ASSERT_EQ(clusters.dropped_gaps, 1);
  const SampleMatrix values = *evaluate(terms, clusters);
  EXPECT_EQ(SampleMatrix(values.topRows(12)), SampleMatrix(whole.topRows(12)));
  EXPECT_EQ(values(12, 0), whole(13, 0)) << "the cluster was dropped for another thermometer";
  const double followed = clusters.temperature_c(11, 3) - values(11, 1);
  EXPECT_NEAR(values(12, 1), std::exp(-200.0 / 600) * (clusters.temperature_c(12, 3) - followed), 1e-12);
}

TEST(Lags, FailWithoutHistory) {
  Clusters clusters;
  clusters.thermometers = {"A"};
  clusters.temperature_c = Eigen::Vector3d(1, 2, 3);
  const auto values = evaluate({lag_term(600, "A")}, clusters);
  ASSERT_FALSE(values);
  EXPECT_EQ(values.error().where, "input \"lag:600:A\"");
}

TEST(LagTerm, RoundTripsThroughText) {
  const std::vector<std::string> names = {"A", "B", "die-cap", "C:D"};
  for (const char* input :
       {"lag:600:A", "A*lag:600:A", "lag:1:die-cap^2", "rate:A*lag:86400:B", "lag:60:A*lag:600:A", "lag:600:C:D"}) {
    const auto term = parse_term(input, names);
    ASSERT_TRUE(term) << input;
    EXPECT_EQ(to_string(*term), input);
    EXPECT_EQ(lags_in({*term}).empty(), false);
  }
  EXPECT_EQ(*parse_term("lag:600:A", names), lag_term(600, "A"));
  EXPECT_EQ(*parse_term("lag:600:A", {"A", "lag:600:A"}), temperature_term("lag:600:A"))
      << "names take precedence over expressions";
  for (const char* input : {"lag:", "lag:A", "lag:600", "lag:0:A", "lag:-5:A", "lag:6.5:A", "lag:86401:A", "lag::A",
                            "lag:99999999999:A", "lag:600:Z", "lag:600:A-B"})
    EXPECT_EQ(parse_term(input, names).error().kind, FaultKind::usage) << input;
}

TEST(LagTerm, RaisesRank) {
  EXPECT_EQ(polynomial_rank({temperature_term("A"), lag_term(600, "A"), lag_term(2400, "A")}), 3);
  EXPECT_EQ(polynomial_rank({lag_term(600, "A") * temperature_term("A"), temperature_term("A") * lag_term(600, "A")}),
            1);
}

TEST(LagTerm, KeepsProductWhenReplacedByTemperature) {
  const Term term = lag_term(600, "A") * temperature_term("B");
  const Term renamed = replace_lags(term);
  EXPECT_EQ(lags_in({term}), std::vector<Factor>{lag_term(600, "A").factors.front()});
  EXPECT_TRUE(lags_in({renamed}).empty());
  EXPECT_EQ(std::ranges::count(renamed.factors, lag_name(lag_term(600, "A").factors.front()), &Factor::first), 1);
}

}  // namespace
}  // namespace gyrotherm::data
