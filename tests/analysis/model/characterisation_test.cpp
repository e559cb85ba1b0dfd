// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/characterisation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include "tests/analysis/synthetic_run.hpp"

namespace gyrotherm::model {
namespace {

/// Run with holds of two hours between −20 and 50 °C. Each test supplies its bias.
struct RunWithGivenBias {
  data::Dataset dataset = data::make_synthetic_run({.cycle_rates_c_per_min = {1, 2}, .hold_s = 7200});
  data::Clusters clusters = *make_clusters(dataset);
  Eigen::VectorXd temperature_c = clusters.temperature_c.rowwise().mean();
  Eigen::VectorXd rate_k_per_min = clusters.rate_c_per_min.rowwise().mean();

  /// Characterises the run for this bias before compensation and a bias of 0 after it.
  [[nodiscard]] Characterisation characterise(const Eigen::VectorXd& bias) {
    clusters.bias_deg_per_h = bias;
    return model::characterise(dataset, clusters, Eigen::VectorXd::Zero(bias.size()));
  }
};

/// Returns the rate of the first thermometer, with 0 instead of NaN in the first cluster.
Eigen::VectorXd known_rate(const RunWithGivenBias& run) {
  return run.rate_k_per_min.unaryExpr([](double rate) { return std::isfinite(rate) ? rate : 0; });
}

TEST(Characterisation, RecoversSensitivitiesOfSyntheticBias) {
  RunWithGivenBias run;
  const Eigen::VectorXd linear = 0.01 + 3e-4 * (run.temperature_c.array() - 20);
  const Characterisation result = run.characterise(linear + 2e-3 * known_rate(run));
  EXPECT_NEAR(result.ramp.before.value, 2e-3, 1e-8);
  EXPECT_LT(result.ramp.before.u, 1e-6);
  EXPECT_NEAR(result.temperature.before.value, 3e-4, 1e-5) << "residual warming during a hold is excluded";
  EXPECT_NEAR(result.ramp.after.value, 0, 1e-12);
  EXPECT_NEAR(result.temperature.after.value, 0, 1e-12);

  const Eigen::VectorXd gradient = run.clusters.temperature_c.col(0) - run.clusters.temperature_c.col(6);
  const Characterisation of_gradient = run.characterise(4e-3 * gradient);
  EXPECT_EQ(of_gradient.gradient, "A-G");
  EXPECT_NEAR(of_gradient.of_gradient.before.value, 4e-3, 1e-8);
}

Eigen::VectorXd noise_of(const Eigen::VectorXd& like, unsigned seed) {
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal(0, 0.0019);
  return Eigen::VectorXd::NullaryExpr(like.size(), [&] { return normal(generator); });
}

/// The bias warms up by 0.05 °/h with a time constant of 10 min. After 32 min it is within 0.002 °/h of its final
/// value.
TEST(Characterisation, ReportsWarmUpTime) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    RunWithGivenBias run;
    const Eigen::VectorXd warm_up = 0.05 * (-(run.clusters.start_s.array() - run.clusters.start_s(0)) / 600).exp();
    const Characterisation result = run.characterise(warm_up + noise_of(warm_up, seed));
    ASSERT_EQ(result.warm_ups.size(), 1u);
    EXPECT_EQ(result.warm_ups[0].set_point_c, 20);
    EXPECT_NEAR(result.warm_ups[0].within.before.value, 0.002, 0.0004);
    EXPECT_NEAR(result.warm_ups[0].seconds.before.value, 1900 + 500, 700)
        << "half of the 1000 s averaging time is added";
  }
}

TEST(Characterisation, ReportsUnknownWarmUpTimeWhileGyroSettles) {
  RunWithGivenBias run;
  const Eigen::VectorXd warm_up = 0.05 * (-(run.clusters.start_s.array() - run.clusters.start_s(0)) / 7200).exp();
  const Characterisation result = run.characterise(warm_up + noise_of(warm_up, 1));
  ASSERT_EQ(result.warm_ups.size(), 1u);
  EXPECT_TRUE(std::isnan(result.warm_ups[0].seconds.before.value));
}

/// The first hold of a partial record is not a start of the gyro. This applies to later holds, and to the real first
/// hold if the record begins too late in it.
TEST(Characterisation, FindsNoStartInPartialRecord) {
  RunWithGivenBias run;
  const data::Clusters whole = run.clusters;
  const auto starts_from = [&](Eigen::Index first) {
    std::vector<Eigen::Index> rows(static_cast<std::size_t>(whole.start_s.size() - first));
    std::iota(rows.begin(), rows.end(), first);
    run.clusters = pick_clusters(whole, rows);
    return run.characterise(noise_of(run.clusters.start_s, 7)).warm_ups.size();
  };
  EXPECT_EQ(starts_from(0), 1u);
  EXPECT_EQ(starts_from(1), 1u) << "the first cluster of a record may lack a reading";
  EXPECT_EQ(starts_from(12), 0u) << "starts 20 min after the beginning of the hold";
  constexpr int kSecondHold = 2;
  Eigen::Index second = 0;
  while (whole.segment(second) != kSecondHold) ++second;
  EXPECT_EQ(starts_from(second), 0u);
  run.dataset.segments[kSecondHold - 1].unit.off = true;
  EXPECT_EQ(starts_from(second), 1u);
  EXPECT_EQ(starts_from(second + 12), 0u) << "starts 20 min after the unit was switched on";
  EXPECT_EQ(starts_from(0), 2u);
}

TEST(Characterisation, ComputesTurnOnScatterOfThreeStarts) {
  RunWithGivenBias run;
  std::vector<Characterisation> starts;
  for (const double turn_on : {-0.002, 0.0, 0.002})
    starts.push_back(run.characterise(noise_of(run.temperature_c, 7).array() + turn_on));
  EXPECT_TRUE(turn_on_scatter({starts[0], starts[1]}).empty()) << "two starts are too few";
  const auto found = turn_on_scatter(starts);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found.front().set_point_c, 20);
  EXPECT_EQ(found.front().starts, 3);
  EXPECT_NEAR(found.front().std_before_deg_per_h, 0.002, 1e-12);
  EXPECT_NEAR(found.front().std_after_deg_per_h, 0, 1e-12);
}

/// Biases of two records are comparable only if both have the same reference. They are not if a reference is the mean
/// of the record's own first hold, or if only one of the references includes the Earth rate.
TEST(Characterisation, IgnoresStartsWithDifferentBiasReferences) {
  RunWithGivenBias run;
  const auto starts_of = [&](const std::vector<std::string>& zeros, bool own) {
    std::vector<Characterisation> starts;
    for (const std::string& zero : zeros) {
      run.dataset.bias_zero = zero;
      run.dataset.has_own_reference = own;
      run.dataset.run_id = "run " + std::to_string(starts.size());
      starts.push_back(run.characterise(noise_of(run.temperature_c, 7)));
    }
    return turn_on_scatter(starts);
  };
  EXPECT_TRUE(starts_of({"earth rate removed", "earth rate removed", "nothing removed"}, false).empty());
  EXPECT_TRUE(starts_of({"mean", "mean", "mean"}, true).empty());
  EXPECT_EQ(starts_of({"nothing removed", "nothing removed", "nothing removed"}, false).size(), 1U);
}

/// A boundary of rounding to 0.5 K is between 19.74 and 19.76 °C.
TEST(Characterisation, PoolsNearlyEqualSetPoints) {
  RunWithGivenBias run;
  std::vector<Characterisation> starts;
  for (const double set_point_c : {19.74, 19.76, 19.8}) {
    run.dataset.segments.front().target = Celsius{set_point_c};
    starts.push_back(run.characterise(noise_of(run.temperature_c, 7)));
  }
  const auto found = turn_on_scatter(starts);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found.front().set_point_c, 19.74) << "the first requested set point";
}

/// The slope is 0.01 °/h per K. Pooled starts at −40 and −39.5 °C would therefore show a scatter of 0.003 °/h.
TEST(Characterisation, SeparatesSetPointsHalfAKelvinApart) {
  RunWithGivenBias run;
  std::vector<Characterisation> starts;
  for (const double set_point_c : {-40.0, -40.0, -39.5, -39.5}) {
    run.dataset.segments.front().target = Celsius{set_point_c};
    run.dataset.run_id = "run " + std::to_string(starts.size());
    starts.push_back(run.characterise(noise_of(run.temperature_c, 7)));
  }
  EXPECT_TRUE(turn_on_scatter(starts).empty()) << "each set point has two starts, and three are required";
}

/// The unit is off during the holds at −20 °C and is switched on again in the holds at 50 °C.
TEST(Characterisation, ComputesTurnOnScatterWithinOneRecord) {
  RunWithGivenBias run;
  run.dataset = data::make_synthetic_run({.cycle_rates_c_per_min = {1, 2, 2}, .hold_s = 7200});
  run.clusters = *make_clusters(run.dataset);
  Eigen::VectorXd bias(run.clusters.start_s.size());
  for (Eigen::Index k = 0; k < bias.size(); ++k) bias(k) = 1e-3 * run.clusters.cycle(k);
  auto& segments = run.dataset.segments;
  for (std::size_t s = 1; s < segments.size(); ++s)
    segments[s - 1].unit.off = segments[s].hold && segments[s].target == Celsius{50};
  const Characterisation result = run.characterise(bias + 1e-6 * noise_of(bias, 3));
  ASSERT_EQ(result.warm_ups.size(), 4u) << "one at the start of the run and three later ones";
  EXPECT_EQ(result.warm_ups[0].segment, 0);
  EXPECT_EQ(result.warm_ups[1].set_point_c, 50);
  const auto found = turn_on_scatter({result});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].set_point_c, 50);
  EXPECT_NEAR(found[0].std_before_deg_per_h, 1e-3, 1e-8) << "0, 1, 2";
}

/// The rig file states an Earth rate of 10 °/h, but the axis has 10.002 °/h. After subtraction ±0.002 °/h remain.
TEST(Characterisation, SeparatesBiasFromEarthRateByTurning) {
  RunWithGivenBias run;
  run.dataset.earth_rate_deg_per_h = 10;
  auto& segments = run.dataset.segments;
  for (std::size_t s = segments.size() / 2; s < segments.size(); ++s) segments[s].unit.turned = true;
  Eigen::VectorXd bias(run.clusters.start_s.size());
  for (Eigen::Index k = 0; k < bias.size(); ++k)
    bias(k) = 0.05 + (segments[static_cast<std::size_t>(run.clusters.segment(k))].unit.turned ? -0.002 : 0.002);
  const Characterisation result = run.characterise(bias);
  ASSERT_EQ(result.two_position.size(), 3u) << "one each at -20, 20 and 50 °C";
  EXPECT_TRUE(result.stabilised.back().turned);
  EXPECT_FALSE(result.stabilised.front().turned);
  for (const Retrace& retrace : result.retrace) EXPECT_NEAR(retrace.change.before.value, 0, 1e-3) << retrace.segment;
  for (const TwoPosition& found : result.two_position) {
    EXPECT_NEAR(found.bias.before.value, 0.05, 1e-12);
    EXPECT_NEAR(found.earth_rate.before.value, 10.002, 1e-12);
    EXPECT_EQ(found.bias.after.value, 0);
    EXPECT_EQ(found.earth_rate.after.value, 10) << "compensation removes the whole bias";
    EXPECT_EQ(found.stated_earth_rate_deg_per_h, 10);
  }
  EXPECT_EQ(result.two_position[1].set_point_c, 20);
  EXPECT_EQ(result.two_position[1].as_mounted, 2);
  EXPECT_EQ(result.two_position[1].turned, 2);
}

/// Compares the stated u with the scatter over many draws. u is half of the root sum of squares of the uncertainties in
/// both positions. The uncertainty of a position is the greater of the noise and the scatter of its two holds. Its mean
/// square is 1.48 times that of the noise.
TEST(Characterisation, StatesUncertaintyOfTwoPositionBias) {
  RunWithGivenBias run;
  auto& segments = run.dataset.segments;
  for (std::size_t s = segments.size() / 2; s < segments.size(); ++s) segments[s].unit.turned = true;
  double squares = 0, variance = 0;
  constexpr int kDraws = 200;
  for (int draw = 0; draw < kDraws; ++draw) {
    const Characterisation result = run.characterise(noise_of(run.temperature_c, static_cast<unsigned>(draw)));
    squares += std::pow(result.two_position[1].earth_rate.before.value, 2);
    variance += std::pow(result.two_position[1].earth_rate.before.u, 2);
  }
  EXPECT_NEAR(std::sqrt(squares / variance), std::sqrt(1 / 1.48), 0.12);
  EXPECT_TRUE(std::isnan(run.characterise(run.temperature_c).two_position[1].stated_earth_rate_deg_per_h));
}

/// The first position has two holds, one before and one after the holds of the other position, with a bias of 0 and
/// 0.004 °/h. Their mean has u = 0.002 °/h, of which half contributes to the Earth rate.
TEST(Characterisation, IncreasesUncertaintyForDriftBetweenTurns) {
  RunWithGivenBias run;
  auto& segments = run.dataset.segments;
  int holds_at_20 = 0;
  Eigen::VectorXd bias = Eigen::VectorXd::Zero(run.clusters.start_s.size());
  for (std::size_t s = 0; s < segments.size(); ++s) {
    if (!segments[s].hold || segments[s].target != Celsius{20}) continue;
    ++holds_at_20;
    segments[s].unit.turned = holds_at_20 > 2;
    for (Eigen::Index k = 0; k < bias.size(); ++k)
      if (run.clusters.segment(k) == static_cast<int>(s) && holds_at_20 == 2) bias(k) = 0.004;
  }
  ASSERT_EQ(holds_at_20, 4);
  const Characterisation result = run.characterise(bias);
  ASSERT_EQ(result.two_position.size(), 1u);
  EXPECT_NEAR(result.two_position[0].earth_rate.before.value, 0.001, 1e-12);
  EXPECT_NEAR(result.two_position[0].earth_rate.before.u, 0.001, 1e-12);
}

TEST(Characterisation, ExcludesResidualEarthRateFromSlope) {
  RunWithGivenBias run;
  auto& segments = run.dataset.segments;
  for (std::size_t s = segments.size() / 2; s < segments.size(); ++s) segments[s].unit.turned = true;
  Eigen::VectorXd bias = 1e-4 * run.temperature_c;
  for (Eigen::Index k = 0; k < bias.size(); ++k)
    bias(k) += segments[static_cast<std::size_t>(run.clusters.segment(k))].unit.turned ? -10 : 10;
  const Characterisation result = run.characterise(bias);
  EXPECT_NEAR(result.temperature.before.value, 1e-4, 1e-9);
  EXPECT_EQ(result.temperature.before.degrees_of_freedom, static_cast<double>(result.stabilised.size()) - 3);
  EXPECT_NEAR(run.characterise(bias + 2e-3 * known_rate(run)).ramp.before.value, 2e-3, 1e-8);
}

TEST(Characterisation, ReportsBiasAtEachStabilisedTemperature) {
  RunWithGivenBias run;
  const Characterisation result = run.characterise(1e-3 * run.temperature_c);
  ASSERT_EQ(result.stabilised.size(), 8U) << "one for each of the four set points in a cycle";
  EXPECT_EQ(result.statement, "last hour of 8 holds of 1.5 h or more");
  const double set_points_c[] = {20, -20, 50, 20};
  for (std::size_t k = 0; k < 8; ++k) {
    const StabilisedBias& point = result.stabilised[k];
    EXPECT_EQ(point.set_point_c, set_points_c[k % 4]);
    EXPECT_NEAR(point.temperature_c, point.set_point_c, 6);
    EXPECT_NEAR(point.bias.before.value, 1e-3 * point.temperature_c, 1e-9);
    EXPECT_EQ(point.bias.after.value, 0);
    EXPECT_GE(point.clusters, 35);
  }
}

/// The bias has a hysteresis component: +h while the block heats and −h while it cools.
TEST(Characterisation, FindsHysteresisWidth) {
  RunWithGivenBias run;
  const Eigen::VectorXd loop = known_rate(run).unaryExpr([](double rate) { return rate > 0 ? 8e-4 : -8e-4; });
  const Characterisation result = run.characterise(loop);
  ASSERT_FALSE(result.hysteresis.empty());
  for (const HysteresisPoint& point : result.hysteresis) {
    EXPECT_NEAR(point.width.before.value, 1.6e-3, 1e-12) << point.temperature_c;
    EXPECT_EQ(point.width.after.value, 0);
  }
  EXPECT_TRUE(std::ranges::is_sorted(result.hysteresis, {}, &HysteresisPoint::temperature_c));
  ASSERT_NE(find_widest(result.hysteresis, &BeforeAfter::before), nullptr);
  EXPECT_EQ(find_widest({}, &BeforeAfter::before), nullptr);
}

/// A pass that begins or ends inside a temperature span has a different mean temperature there than one that crosses
/// the span. For a bias with a slope, this must not be mistaken for hysteresis.
TEST(Characterisation, FindsNoHysteresisForSlope) {
  RunWithGivenBias run;
  const Eigen::VectorXd bias = 1e-3 * (run.temperature_c.array() - 20);
  const double noise = 0.0019;
  int points = 0;
  for (const HysteresisPoint& point : run.characterise(bias + noise_of(bias, 5)).hysteresis) {
    const double of_noise = noise * std::sqrt(1.0 / point.heating + 1.0 / point.cooling);
    EXPECT_NEAR(point.width.before.value, 0, 4 * of_noise) << point.temperature_c;
    EXPECT_LT(point.width.before.u, 3 * of_noise) << point.temperature_c;
    ++points;
  }
  EXPECT_GT(points, 5);
}

/// Returns x_k = 0.95 x_{k−1} + white noise of unit STD, with a correlation time of half an hour.
Eigen::VectorXd draw_wander(const Eigen::VectorXd& like, std::uint64_t seed) {
  constexpr double kMemory = 0.95;
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal;
  double value = normal(generator);
  return Eigen::VectorXd::NullaryExpr(
      like.size(), [&] { return value = kMemory * value + std::sqrt(1 - kMemory * kMemory) * normal(generator); });
}

/// A pass through 10 K takes 20 min and has twelve correlated clusters. If they were treated as independent, u of the
/// width would be too small by a factor of three.
TEST(Characterisation, StatesUncertaintyOfHysteresisWidth) {
  RunWithGivenBias run;
  run.dataset = data::make_synthetic_run({.cycle_rates_c_per_min = {0.5, 0.5, 0.5}, .hold_s = 7200});
  run.clusters = *make_clusters(run.dataset);
  double squares = 0, variance = 0, freedom = 0, clusters = 0;
  int points = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    for (const HysteresisPoint& point : run.characterise(draw_wander(run.clusters.start_s, seed)).hysteresis) {
      if (point.heating < 30 || point.cooling < 30) continue;
      squares += std::pow(point.width.before.value, 2);
      variance += std::pow(point.width.before.u, 2);
      freedom += point.width.before.degrees_of_freedom;
      clusters += point.heating + point.cooling;
      ++points;
    }
  }
  ASSERT_GT(points, 300);
  EXPECT_NEAR(std::sqrt(variance / squares), 1, 0.3);
  EXPECT_LT(freedom, 0.5 * clusters);
}

/// If the bias drifts during the last hour of a hold, the effective number of values is little more than one. For white
/// noise all values are independent.
TEST(Characterisation, CountsOnlyIndependentValuesAsDegreesOfFreedom) {
  RunWithGivenBias run;
  const Characterisation drifting = run.characterise(1e-6 * run.clusters.start_s);
  const Characterisation white = run.characterise(noise_of(run.temperature_c, 4));
  for (const StabilisedBias& hold : drifting.stabilised) EXPECT_LT(hold.bias.before.degrees_of_freedom, 5);
  for (std::size_t k = 0; k < white.retrace.size(); ++k) {
    const auto freedom_of = [&](int segment) {
      return std::ranges::find(white.stabilised, segment, &StabilisedBias::segment)->bias.before.degrees_of_freedom;
    };
    const double own = freedom_of(white.retrace[k].segment), first = freedom_of(white.stabilised[0].segment);
    EXPECT_LE(white.retrace[k].change.before.degrees_of_freedom, own + first + 1e-9);
    EXPECT_GE(white.retrace[k].change.before.degrees_of_freedom, std::min(own, first));
  }
  EXPECT_GT(white.stabilised[0].bias.before.degrees_of_freedom, 20);
  EXPECT_EQ(drifting.temperature.before.degrees_of_freedom, static_cast<double>(drifting.stabilised.size()) - 2);
}

TEST(Characterisation, FindsRetraceError) {
  RunWithGivenBias run;
  Eigen::VectorXd bias = Eigen::VectorXd::Zero(run.temperature_c.size());
  for (Eigen::Index k = 0; k < bias.size(); ++k) bias(k) = 1e-3 * run.clusters.segment(k);
  const Characterisation result = run.characterise(bias);
  ASSERT_EQ(result.retrace.size(), 3U) << "20 °C has four holds, and thus three pairs";
  for (const Retrace& retrace : result.retrace) {
    EXPECT_EQ(retrace.set_point_c, 20);
    EXPECT_NEAR(retrace.change.before.value, 1e-3 * retrace.segment, 1e-12);
  }
}

TEST(Characterisation, StatesThatRecordHasNoLongHold) {
  const data::Dataset dataset = data::make_synthetic_run({});
  const data::Clusters clusters = *make_clusters(dataset);
  const Characterisation result = characterise(dataset, clusters, clusters.bias_deg_per_h);
  EXPECT_TRUE(result.stabilised.empty());
  EXPECT_TRUE(result.retrace.empty());
  EXPECT_TRUE(std::isnan(result.temperature.before.value));
  EXPECT_NE(result.statement.find("no hold bias"), std::string::npos);
  EXPECT_TRUE(std::isfinite(result.ramp.before.value)) << "the record still has ramps";
}

TEST(Characterisation, ReportsUnknownValuesWhereModelRefuses) {
  RunWithGivenBias run;
  Eigen::VectorXd residual = run.clusters.bias_deg_per_h;
  residual.tail(5).setConstant(std::nan(""));
  const Characterisation result = characterise(run.dataset, run.clusters, residual);
  EXPECT_TRUE(std::isnan(result.stabilised.back().bias.after.value));
  EXPECT_TRUE(std::isfinite(result.stabilised.back().bias.before.value));
  EXPECT_TRUE(std::isfinite(result.ramp.after.value)) << "computed from the compensated clusters";
}

Eigen::VectorXi running(Eigen::Index count) {
  return Eigen::VectorXi::LinSpaced(count, 0, static_cast<int>(count) - 1);
}

TEST(RobustFit, EqualsWhiteEstimatorForReachZero) {
  std::mt19937_64 random(2);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd x(50, 2);
  x << Eigen::VectorXd::Ones(50), Eigen::VectorXd::NullaryExpr(50, [&] { return normal(random); });
  const Eigen::VectorXd y = x.col(1) + Eigen::VectorXd::NullaryExpr(50, [&] { return normal(random); });
  const RobustFit fit = fit_robustly(x, y, running(50), 0);
  const Eigen::VectorXd left = y - x * fit.coefficients;
  EXPECT_LT((x.transpose() * left).cwiseAbs().maxCoeff(), 1e-10) << "the normal equations are satisfied";
  const Eigen::MatrixXd inverse = (x.transpose() * x).inverse();
  const Eigen::MatrixXd middle = x.transpose() * left.cwiseAbs2().asDiagonal() * x;
  const Eigen::VectorXd u = (50.0 / 48 * (inverse * middle * inverse).diagonal()).cwiseSqrt();
  EXPECT_LT((fit.u - u).cwiseAbs().maxCoeff(), 1e-12);
}

/// Both input and noise are correlated in time. Standard errors that assume independent clusters would be several times
/// too small.
TEST(RobustFit, StatesUncertaintyForCorrelatedNeighbours) {
  constexpr Eigen::Index kRows = 1500;
  constexpr int kSeeds = 100;
  constexpr double kMemory = 0.9;
  double squares = 0, variances = 0, naive = 0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    const auto wandering = [&] {
      Eigen::VectorXd values(kRows);
      double value = normal(random);
      for (double& at : values) at = value = kMemory * value + std::sqrt(1 - kMemory * kMemory) * normal(random);
      return values;
    };
    Eigen::MatrixXd x(kRows, 2);
    x << Eigen::VectorXd::Ones(kRows), wandering();
    const RobustFit fit = fit_robustly(x, 2 * x.col(1) + wandering(), running(kRows), 54);
    squares += std::pow(fit.coefficients(1) - 2, 2);
    variances += std::pow(fit.u(1), 2);
    naive += 1.0 / kRows;
  }
  EXPECT_NEAR(std::sqrt(variances / squares), 1, 0.25);
  EXPECT_LT(std::sqrt(naive / squares), 0.5);
}

/// Rows count as independent if they are farther apart than the reach.
TEST(RobustFit, IgnoresProductsAcrossGaps) {
  const Eigen::MatrixXd x = Eigen::MatrixXd::Ones(4, 1);
  const Eigen::Vector4d y{1, 1, -1, -1};
  Eigen::VectorXi places(4);
  places << 0, 100, 200, 300;
  EXPECT_DOUBLE_EQ(fit_robustly(x, y, places, 10).u(0), std::sqrt(4.0 / 3 * 4 / 16));
  places << 0, 1, 200, 201;
  EXPECT_DOUBLE_EQ(fit_robustly(x, y, places, 1).u(0), std::sqrt(4.0 / 3 * (4 + 2 * 0.5 * 2) / 16));
}

}  // namespace
}  // namespace gyrotherm::model
