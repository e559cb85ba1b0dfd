// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/fused_run.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "analysis/data/distributions.hpp"
#include "tests/analysis/fusion/thermal_body.hpp"

namespace gyrotherm::model {
namespace {

using fusion::Draws;

constexpr double kAngleRandomWalk = 3e-4;                    // °/√h
constexpr double kSecond_deg_per_h = 60 * kAngleRandomWalk;  // standard uncertainty over one second
constexpr double kTurnOn_deg_per_h = 0.001;
constexpr double kLatitude_deg = 45;

/// Returns a model whose budget contains only white noise and the turn-on scatter.
Model quiet_model() {
  Model model;
  model.inputs = "A";
  model.method = "linear";
  model.residual_noise = {.angle_random_walk_deg_per_sqrt_h = kAngleRandomWalk, .start_deg_per_h = kTurnOn_deg_per_h};
  model.uncertainty = {
      .budget = {.averaging_s = 3600,
                 .rows = {{.source = Source::angle_random_walk, .standard_uncertainty = kAngleRandomWalk},
                          {.source = Source::turn_on, .standard_uncertainty = kTurnOn_deg_per_h}}},
      .sensitivities = {}};
  return model;
}

/// Returns the rates of a level fixture that heads north and rests during one hold.
FusedAxes make_resting_axes(const std::vector<fusion::InputAxis>& axes, Eigen::Index seconds, std::uint64_t seed) {
  FusedAxes fused{.simulated = true, .profile_name = "rest", .segments = {{}}};
  fused.segments.front().name = "hold";
  fused.segments.front().hold = true;
  fused.time_s = Eigen::VectorXd::LinSpaced(seconds, 0, static_cast<double>(seconds - 1));
  fused.segment = Eigen::VectorXi::Zero(seconds);
  const auto count = std::ssize(axes);
  fused.directions.resize(count, 3);
  for (Eigen::Index a = 0; a < count; ++a) {
    fused.directions.row(a) = axes[static_cast<std::size_t>(a)].direction.transpose();
    fused.names.push_back(axes[static_cast<std::size_t>(a)].name);
    fused.models.push_back(quiet_model());
  }
  fused.step_deg_per_h.assign(axes.size(), 0);
  fused.outside.assign(static_cast<std::size_t>(seconds), 0);
  fused.added_variance = Eigen::MatrixXd::Zero(seconds, count);
  fused.thermometer_drift_covariance = fused.learnt = Eigen::MatrixXd::Zero(count, count);
  fused.sensitivity_deg_per_h_per_k = Eigen::MatrixXd::Zero(count, 0);
  fused.temperature_c.resize(seconds, 0);
  fused.attitude = fusion::Attitude{.to_local = Eigen::Vector3d(1, -1, -1).asDiagonal(),
                                    .tilt_std_deg = 0.01,
                                    .azimuth_std_deg = 0.02,
                                    .latitude_deg = kLatitude_deg};
  Draws draws(seed);
  const Eigen::VectorXd mean =
      fused.directions * earth_in_fixture(*fused.attitude) + kTurnOn_deg_per_h * draws.normal(count);
  fused.rate_deg_per_h.resize(seconds, count);
  for (Eigen::Index row = 0; row < seconds; ++row)
    fused.rate_deg_per_h.row(row) = (mean + kSecond_deg_per_h * draws.normal(count)).transpose();
  return fused;
}

FusedRun fused_run(const FusedAxes& axes, const FusionOptions& options = {}) {
  auto run = fuse(axes, std::nullopt, options);
  EXPECT_TRUE(run) << text(run.error());
  return std::move(*run);
}

std::vector<fusion::InputAxis> regular_tetrad() {
  return {fusion::axis("a", 1, 1, 1, 1), fusion::axis("b", 1, -1, -1, 1), fusion::axis("c", -1, 1, -1, 1),
          fusion::axis("d", -1, -1, 1, 1)};
}

TEST(FusedRun, EqualsEarthRateWithinUncertainty) {
  for (int seed = 1; seed <= fusion::kSeeds; ++seed) {
    const FusedRun run = fused_run(make_resting_axes(regular_tetrad(), 4000, static_cast<std::uint64_t>(seed)));
    ASSERT_TRUE(run.summary.rest);
    const RestStretch& rest = *run.summary.rest;
    EXPECT_EQ(rest.end_s - rest.start_s, 3600) << "the last hour";
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_LT(std::abs(rest.residual_deg_per_h[k]), 2.5 * rest.rate.expanded_deg_per_h[k]) << "seed " << seed;
    ASSERT_TRUE(rest.heading_deg) << rest.no_heading;
    EXPECT_LT(std::abs(*rest.heading_deg), 2.5 * *rest.heading_expanded_deg) << "seed " << seed;
    EXPECT_EQ(run.summary.fused, 4000);
  }
}

TEST(FusedRun, HasRequestedFalseAlarmProbability) {
  FusionOptions options;
  options.watch.false_alarm_probability = 0.01;
  options.leave_out = false;
  const double seconds = 20000;
  for (const auto& axes : {regular_tetrad(), fusion::dodecahedron_axes(1)}) {
    FusedAxes fused = make_resting_axes(axes, static_cast<Eigen::Index>(seconds), 3);
    const FusedRun run = fused_run(fused, options);
    // The readings do not get a new turn-on bias each second, so contradictions are slightly rarer than nominal.
    EXPECT_NEAR(static_cast<double>(run.summary.contradictions) / seconds, 0.01,
                5 * fusion::relative_frequency_std(0.01, seconds));
  }
}

TEST(FusedRun, OmitsAxisInSecondOfItsFault) {
  FusedAxes axes = make_resting_axes(fusion::dodecahedron_axes(1), 1000, 1);
  axes.rate_deg_per_h(500, 2) += 0.5;
  const FusedRun run = fused_run(axes);
  EXPECT_TRUE(run.contradicts[500]);
  EXPECT_EQ(run.used[500], 0b111011u);
  EXPECT_EQ(run.used[501], 0b111111u);
  ASSERT_EQ(run.summary.alarms.size(), 1u);
  EXPECT_EQ(run.summary.alarms[0].who, "c");
  EXPECT_NEAR(run.summary.alarms[0].size, 0.5, 0.1);
}

TEST(FusedRun, TestsMeanThatEndsWithRecord) {
  FusedAxes axes = make_resting_axes(regular_tetrad(), 2000, 1);
  axes.rate_deg_per_h.col(1).tail(100).array() += 0.05;
  const FusedRun run = fused_run(axes);
  EXPECT_EQ(run.summary.contradictions, 0) << "the fault is too small for one second";
  EXPECT_TRUE(std::ranges::any_of(run.summary.alarms, [](const Alarm& alarm) {
    return alarm.kind == AlarmKind::rest_hop && alarm.who == "b" && alarm.at_s == 2000;
  }));
}

TEST(FusedRun, IdentifiesHopAtRestAndOmitsAxisForFourAxes) {
  int named = 0, wrongly = 0;
  for (int seed = 1; seed <= fusion::kSeeds; ++seed) {
    FusedAxes axes = make_resting_axes(regular_tetrad(), 40000, static_cast<std::uint64_t>(seed));
    axes.rate_deg_per_h.col(1).tail(20000).array() += 0.01;
    const FusedRun run = fused_run(axes);
    const bool without_b = run.used.back() == 0b1101u;
    named += without_b ? 1 : 0;
    wrongly += !without_b && run.used.back() != 0b1111u ? 1 : 0;
    if (without_b) {
      EXPECT_LT(run.summary.error->rms_deg_per_h, run.summary.of_all_axes->rms_deg_per_h);
    }
    for (const Alarm& alarm : run.summary.alarms) EXPECT_GT(alarm.at_s, 20000) << "seed " << seed;
  }
  EXPECT_GE(named, fusion::kSeeds - 2);
  EXPECT_LE(wrongly, 1);
}

/// Returns four axes at rest with model errors of 0.001 °/h (standard deviation) that change every 20 min.
FusedAxes axes_with_persistent_errors(Eigen::Index seconds, std::uint64_t seed) {
  FusedAxes axes = make_resting_axes(regular_tetrad(), seconds, seed);
  Draws draws(seed + 50);
  constexpr Eigen::Index kPeriod = 1200;
  for (Eigen::Index row = 0; row < seconds; row += kPeriod) {
    const Eigen::Index count = std::min(kPeriod, seconds - row);
    axes.rate_deg_per_h.middleRows(row, count).rowwise() += 0.001 * draws.normal(4).transpose();
  }
  return axes;
}

/// Learns from a healthy record of 20 h and fuses another one of 22 h. The stated rate is 0.2 false alarms per hour.
TEST(FusedRun, LearnsSumLimitsFromHealthyRecord) {
  FusionOptions options;
  options.leave_out = false;
  options.watch.false_alarms_per_h = 0.2;
  FusionOptions learnt = options;
  learnt.healthy = healthy_rates(axes_with_persistent_errors(72000, 1), options.cluster_s);
  ASSERT_EQ(learnt.healthy->departures_deg_per_h.rows(), 720);
  EXPECT_LT(learnt.healthy->departures_deg_per_h.cwiseAbs().maxCoeff(), 0.02) << "without the Earth rate";
  const FusedAxes other = axes_with_persistent_errors(80000, 2);
  const FusedRun before = fused_run(other, options), after = fused_run(other, learnt);
  ASSERT_EQ(before.summary.sum_limits.size(), 2u);
  ASSERT_EQ(after.summary.sum_limits.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_FALSE(before.summary.sum_limits[i].learnt);
    EXPECT_EQ(before.summary.sum_limits[i].limit, before.summary.sum_limits[i].white_limit);
    EXPECT_TRUE(after.summary.sum_limits[i].learnt);
    EXPECT_EQ(after.summary.sum_limits[i].white_limit, before.summary.sum_limits[i].limit);
    EXPECT_GT(after.summary.sum_limits[i].limit, 1.1 * before.summary.sum_limits[i].limit);
  }
  EXPECT_LT(after.summary.alarms.size(), before.summary.alarms.size());
  EXPECT_NE(to_json(after.summary).find("\"learnt\": true"), std::string::npos);
}

TEST(FusedRun, KeepsWhiteLimitsWhenHealthyRecordIsUnsuitable) {
  const FusedAxes axes = make_resting_axes(regular_tetrad(), 1000, 1);
  FusionOptions options;
  const auto limits_with = [&](const FusedAxes& healthy) {
    options.healthy = healthy_rates(healthy, options.cluster_s);
    return fused_run(axes, options).summary.sum_limits;
  };
  FusedAxes healthy = axes_with_persistent_errors(40000, 1);
  ASSERT_EQ(limits_with(healthy).size(), 2u);
  for (const SumLimit& sum : limits_with(healthy)) EXPECT_TRUE(sum.learnt) << sum.kind;
  for (const SumLimit& sum : limits_with(axes_with_persistent_errors(30000, 1))) EXPECT_FALSE(sum.learnt) << sum.kind;
  healthy.attitude.reset();
  const auto limits = limits_with(healthy);
  ASSERT_EQ(limits.size(), 2u);
  EXPECT_EQ(limits[0].kind, "parity_hop");
  EXPECT_TRUE(limits[0].learnt) << "the parity does not depend on the Earth rate";
  EXPECT_FALSE(limits[1].learnt);
  healthy.names[0] = "e";
  for (const SumLimit& sum : limits_with(healthy)) EXPECT_FALSE(sum.learnt) << sum.kind;
}

/// Returns four axes with models that depend on eight thermometers of a body. In the second half of the record, one
/// thermometer has an error of `off_k`.
FusedAxes axes_on_body(Eigen::Index seconds, Eigen::Index thermometer, double off_k) {
  FusedAxes axes = make_resting_axes(regular_tetrad(), seconds, 2);
  axes.thermometers = {"A", "B", "C", "D", "E", "F", "G", "H"};
  axes.thermometer_in_a_year_k.assign(fusion::kThermometers, fusion::kOwn_k);
  axes.temperature_c.resize(seconds, fusion::kThermometers);
  Draws draws(7);
  axes.sensitivity_deg_per_h_per_k.resize(4, fusion::kThermometers);
  for (Eigen::Index j = 0; j < fusion::kThermometers; ++j)
    axes.sensitivity_deg_per_h_per_k.col(j) = 0.02 * draws.normal(4);
  constexpr Eigen::Index kCluster = 100;
  for (Eigen::Index row = 0; row < seconds; row += kCluster)
    axes.temperature_c.middleRows(row, kCluster).rowwise() = fusion::temperatures(draws, fusion::kOwn_k);
  const Eigen::Index half = seconds / 2;
  axes.temperature_c.col(thermometer).tail(half).array() += off_k;
  axes.rate_deg_per_h.bottomRows(half).rowwise() -=
      off_k * axes.sensitivity_deg_per_h_per_k.col(thermometer).transpose();
  return axes;
}

TEST(FusedRun, IdentifiesBrokenThermometerInsteadOfGyro) {
  const auto run = fuse(axes_on_body(20000, 3, 0.5), fusion::learnt_thermometer_parity(), {});
  ASSERT_TRUE(run) << text(run.error());
  const auto& alarms = run->summary.alarms;
  ASSERT_FALSE(alarms.empty());
  EXPECT_EQ(alarms[0].kind, AlarmKind::thermometer);
  EXPECT_EQ(alarms[0].who, "D");
  EXPECT_NEAR(alarms[0].size, 0.5, 0.1);
  EXPECT_EQ(alarms[0].at_s, 10100) << "end of the first mean with the error";
  for (const Alarm& alarm : alarms)
    if (alarm.kind != AlarmKind::thermometer) {
      EXPECT_EQ(alarm.who, "") << alarm.statement;
    }
}

TEST(FusedRun, RaisesNoAlarmWhenThermometersAgree) {
  const auto run = fuse(axes_on_body(20000, 3, 0), fusion::learnt_thermometer_parity(), {});
  ASSERT_TRUE(run) << text(run.error());
  EXPECT_TRUE(run->summary.alarms.empty()) << run->summary.alarms[0].statement;
  EXPECT_TRUE(run->summary.thermometers_vote);
}

TEST(FusedRun, FusesThreeAxesWhileFourthIsSilent) {
  FusedAxes axes = make_resting_axes(regular_tetrad(), 300, 1);
  axes.rate_deg_per_h.col(3).segment(100, 50).setConstant(std::numeric_limits<double>::quiet_NaN());
  const FusedRun run = fused_run(axes);
  EXPECT_EQ(run.used[120], 0b0111u);
  EXPECT_TRUE(std::isnan(run.statistic(120))) << "three axes have no parity";
  EXPECT_TRUE(run.rate_deg_per_h.row(120).allFinite());
  EXPECT_GT(run.expanded_deg_per_h(120, 0), run.expanded_deg_per_h(99, 0));
  EXPECT_EQ(run.used[150], 0b1111u);
}

TEST(FusedRun, HasNoRateInSecondWithTwoAxes) {
  FusedAxes axes = make_resting_axes(fusion::triad_axes(1), 10, 1);
  axes.rate_deg_per_h(4, 0) = std::numeric_limits<double>::quiet_NaN();
  const FusedRun run = fused_run(axes);
  EXPECT_EQ(run.used[4], 0u);
  EXPECT_TRUE(std::isnan(run.rate_deg_per_h(4, 1)));
  EXPECT_EQ(run.summary.fused, 9);
}

/// Two axes along x with the uncertainties u₁ and u₂ have the weights u₂²/(u₁² + u₂²) and u₁²/(u₁² + u₂²). One of them
/// has a five times larger bias uncertainty. Over one second noise dominates and the weights are nearly equal; over
/// 100 s the worse axis has a much smaller weight.
TEST(FusedRun, WeightsAxesForAveragingTime) {
  auto along_x_twice = fusion::triad_axes(1);
  along_x_twice.push_back(fusion::axis("x2", 1, 0, 0, 1));
  FusedAxes axes = make_resting_axes(along_x_twice, 300, 1);
  constexpr double kWorse = 5 * kTurnOn_deg_per_h;
  axes.models[3].uncertainty->budget.rows[1].standard_uncertainty = kWorse;
  const auto weight_of_worse_axis = [&](double averaging_s) {
    FusionOptions options;
    options.averaging_s = averaging_s;
    const FusedRun run = fused_run(axes, options);
    EXPECT_EQ(run.summary.averaging_s, averaging_s);
    const Eigen::RowVectorXd readings = axes.rate_deg_per_h.row(10);
    return (run.rate_deg_per_h(10, 0) - readings(0)) / (readings(3) - readings(0));
  };
  const auto expected = [&](double averaging_s) {
    const double noise = std::pow(kSecond_deg_per_h, 2) / averaging_s;
    const double good = noise + std::pow(kTurnOn_deg_per_h, 2), worse = noise + std::pow(kWorse, 2);
    return good / (good + worse);
  };
  EXPECT_NEAR(weight_of_worse_axis(1), expected(1), 1e-9);
  EXPECT_NEAR(weight_of_worse_axis(100), expected(100), 1e-9);
  EXPECT_GT(expected(1), 0.48);
  EXPECT_LT(expected(100), 0.14);
}

TEST(FusedRun, WidensUncertaintyWithoutAlarmOutsideTrainedRange) {
  FusedAxes axes = make_resting_axes(regular_tetrad(), 20000, 1);
  for (std::size_t row = 10000; row < 10500; ++row) {
    axes.rate_deg_per_h(static_cast<Eigen::Index>(row), 1) += 0.02;
    axes.outside[row] = 0b0010;
    axes.added_variance(static_cast<Eigen::Index>(row), 1) = 0.04;
  }
  const FusedRun run = fused_run(axes);
  EXPECT_TRUE(run.rate_deg_per_h.row(10100).allFinite());
  // An axis of a regular tetrad contributes √3/4 of its reading to each component, so 0.04 (°/h)² add 0.0075 (°/h)².
  const double inside = run.expanded_deg_per_h(10600, 0), outside = run.expanded_deg_per_h(10100, 0);
  EXPECT_NEAR(outside * outside - inside * inside, 4 * 0.04 * 3 / 16, 1e-12);
  EXPECT_TRUE(run.summary.alarms.empty());
  EXPECT_EQ(run.summary.axes[1].outside_s, 500);
}

/// Each axis is off by more than its budget explains, but within the variance that is added outside its trained range.
TEST(FusedRun, HasSameUncertaintyInShareWithinAsInSeconds) {
  constexpr double kOff_deg_per_h = 0.05, kAdded = 0.01;
  for (const Eigen::Index outside : {0, 10000, 20000}) {
    SCOPED_TRACE(outside);
    FusedAxes axes = make_resting_axes(regular_tetrad(), 20000, 1);
    axes.rate_deg_per_h.topRows(outside).col(1).array() += kOff_deg_per_h;
    axes.added_variance.topRows(outside).setConstant(kAdded);
    for (Eigen::Index row = 0; row < outside; ++row) axes.outside[static_cast<std::size_t>(row)] = 0b1111;
    const FusedRun run = fused_run(axes);
    ASSERT_TRUE(run.summary.within_expanded);
    EXPECT_GT(*run.summary.within_expanded, 0.9);
    const FusedAxes untouched = make_resting_axes(regular_tetrad(), 20000, 1);
    FusedAxes without = axes;
    without.added_variance.setZero();
    if (outside > 0) {
      EXPECT_LT(*fused_run(without).summary.within_expanded, 0.75);
    } else {
      EXPECT_EQ(*run.summary.within_expanded, *fused_run(untouched).summary.within_expanded);
    }
  }
}

/// In a hold outside the trained range, U of its mean and the prior of the biases include the added variance.
TEST(FusedRun, WidensMeanOfHoldOutsideTrainedRange) {
  FusedAxes axes = make_resting_axes(regular_tetrad(), 4000, 1);
  const RestStretch inside = *fused_run(axes).summary.rest;
  axes.added_variance.setConstant(0.04);
  axes.outside.assign(4000, 0b1111);
  const RestStretch outside = *fused_run(axes).summary.rest;
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_NEAR(std::pow(outside.rate.expanded_deg_per_h[k], 2) - std::pow(inside.rate.expanded_deg_per_h[k], 2),
                4 * 0.04 * 3 / 4, 1e-9)
        << "the four axes of a tetrad contribute √3/4 each";
  ASSERT_FALSE(inside.bias_std_deg_per_h.empty());
  EXPECT_LT(outside.statistic, inside.statistic);
}

TEST(FusedRun, RejectsTwoAxes) {
  auto axes = fusion::triad_axes(1);
  axes.pop_back();
  EXPECT_FALSE(fuse(make_resting_axes(axes, 10, 1), std::nullopt, {}));
}

TEST(FusedRun, OmitsEarthRateWithoutAttitude) {
  FusedAxes axes = make_resting_axes(regular_tetrad(), 1000, 1);
  axes.attitude.reset();
  const FusedRun run = fused_run(axes);
  EXPECT_EQ(run.summary.fused, 1000);
  EXPECT_FALSE(run.summary.rest);
  EXPECT_FALSE(run.summary.error);
  EXPECT_NE(to_json(run.summary).find("\"latitude_deg\": null"), std::string::npos);
}

/// During a gap of 25 h the biases drift as far as their models predict.
TEST(FusedRun, PermitsBiasDriftDuringGap) {
  FusedAxes axes = make_resting_axes(regular_tetrad(), 40000, 1);
  for (Model& model : axes.models) model.residual_noise->rate_random_walk_deg_per_h_per_sqrt_h = 0.01;
  axes.time_s.tail(20000).array() += 90000;
  const Eigen::RowVector4d drift = (axes.directions * Eigen::Vector3d(0.05, 0, 0)).transpose();
  axes.rate_deg_per_h.bottomRows(20000).rowwise() += drift;
  const FusedRun run = fused_run(axes);
  EXPECT_GT(run.summary.fused, 39000);
  for (const Alarm& alarm : run.summary.alarms)
    EXPECT_NE(alarm.kind, AlarmKind::rest_hop) << alarm.at_s << ": " << alarm.statement;
}

TEST(FusedRun, DatesHopBeforeGap) {
  FusedAxes axes = make_resting_axes(regular_tetrad(), 40000, 1);
  axes.rate_deg_per_h.col(1).tail(20000).array() += 0.004;
  axes.time_s.tail(19800).array() += 7200;
  const FusedRun run = fused_run(axes);
  const auto hop = std::ranges::find(run.summary.alarms, AlarmKind::rest_hop, &Alarm::kind);
  ASSERT_NE(hop, run.summary.alarms.end());
  EXPECT_GT(hop->at_s, 27400) << "the hop was detected after the gap";
  EXPECT_NEAR(hop->since_s, 20000, 300);
}

TEST(FusedRun, ReportsStretchThatContradictsEarthRate) {
  FusedAxes axes = make_resting_axes(regular_tetrad(), 4000, 1);
  axes.rate_deg_per_h.rowwise() += (axes.directions * Eigen::Vector3d(0.05, 0, 0)).transpose();
  const FusedRun run = fused_run(axes);
  ASSERT_TRUE(run.summary.rest);
  EXPECT_GT(run.summary.rest->statistic, run.summary.rest->limit);
  const auto rest = std::ranges::find(run.summary.alarms, AlarmKind::rest, &Alarm::kind);
  ASSERT_NE(rest, run.summary.alarms.end());
  EXPECT_EQ(rest->who, "") << "a rotation of the fixture is another explanation";
  EXPECT_EQ(rest->since_s, 400);
  EXPECT_EQ(rest->at_s, 4000);
  EXPECT_NE(rest->statement.find("at rest (hold)"), std::string::npos) << rest->statement;
}

TEST(UncertaintyOfMeans, ReducesQuantisationWithTimeAndNoiseWithItsRoot) {
  FusedAxes axes = make_resting_axes(fusion::triad_axes(1), 10, 1);
  axes.step_deg_per_h.assign(3, 0.1);
  for (Model& model : axes.models)
    model.uncertainty->budget.rows.push_back({.source = Source::counting, .standard_uncertainty = 1});
  const double noise = std::pow(kSecond_deg_per_h, 2), step = 0.01 / 6;
  EXPECT_NEAR(uncertainty_of_means(axes, 1).noise(0), noise + step, 1e-12);
  EXPECT_NEAR(uncertainty_of_means(axes, 100).noise(0), noise / 100 + step / 1e4, 1e-12);
  EXPECT_NEAR(uncertainty_of_means(axes, 100).bias(0, 0), std::pow(kTurnOn_deg_per_h, 2), 1e-12);
}

/// Returns two axes whose models use the same thermometer with slopes of opposite sign, and a third axis with another
/// thermometer.
std::vector<CompensatedAxis> axes_with_shared_thermometer() {
  std::vector<CompensatedAxis> axes;
  const std::array<std::array<double, 3>, 3> directions = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  for (std::size_t a = 0; a < 3; ++a) {
    data::Dataset dataset;
    dataset.of = {.unit = std::string(1, static_cast<char>('x' + a))};
    dataset.thermometers = {a < 2 ? "A" : "B"};
    dataset.direction = directions[a];
    dataset.earth_rate_deg_per_h = 0;
    dataset.time_s = Eigen::VectorXd::LinSpaced(1000, 0, 999);
    dataset.temperature_c = 20 + Eigen::ArrayXd::LinSpaced(1000, -5, 5);
    dataset.bias_deg_per_h = Eigen::VectorXd::Zero(1000);
    dataset.segment = dataset.cycle = Eigen::VectorXi::Constant(1000, -1);
    dataset.set_point_c = Eigen::VectorXd::Constant(1000, 20);
    Model model = quiet_model();
    const double slope = a == 1 ? -0.2 : 0.1;
    model.terms = {data::temperature_term(dataset.thermometers.front())};
    model.scaling = {Eigen::RowVectorXd::Constant(1, 20), Eigen::RowVectorXd::Constant(1, 1)};
    model.target_std_deg_per_h = 1;
    model.function = methods::LinearModel{.weights = Eigen::VectorXd::Constant(1, slope), .b = 0};
    model.input_min = Eigen::RowVectorXd::Constant(1, -50);
    model.input_max = Eigen::RowVectorXd::Constant(1, 70);
    model.uncertainty->budget.rows.push_back({.source = Source::thermometer_drift,
                                              .of = dataset.thermometers.front(),
                                              .standard_uncertainty = 0.05,
                                              .sensitivity = std::abs(slope),
                                              .assumed = true});
    axes.push_back({std::move(dataset), std::move(model)});
  }
  return axes;
}

TEST(FusedAxes, CorrelateErrorsOfSharedThermometerBySignOfSlope) {
  const auto fused = compensate_axes(axes_with_shared_thermometer());
  ASSERT_TRUE(fused) << text(fused.error());
  const Eigen::MatrixXd& shared = fused->thermometer_drift_covariance;
  EXPECT_NEAR(shared(0, 0), std::pow(0.05 * 0.1, 2), 1e-10);
  EXPECT_NEAR(shared(0, 1), -0.05 * 0.05 * 0.1 * 0.2, 1e-10);
  EXPECT_NEAR(shared(0, 2), 0, 1e-12) << "another thermometer";
  EXPECT_NEAR(fused->sensitivity_deg_per_h_per_k(1, 0), -0.2, 1e-6);
  EXPECT_FALSE(fused->attitude) << "the record contains no azimuth";
}

TEST(FusedAxes, UseTrailingMeansForCompensation) {
  const auto fused = compensate_axes(axes_with_shared_thermometer());
  ASSERT_TRUE(fused);
  EXPECT_TRUE(std::isnan(fused->rate_deg_per_h(98, 0))) << "the first mean is complete after 100 s";
  // Mean of the last 100 s of a ramp from −5 to 5 K, times a slope of 0.1.
  EXPECT_NEAR(fused->rate_deg_per_h(999, 0), -0.1 * (5 - 49.5 * 10 / 999), 1e-9);
}

TEST(FusedAxes, HaveNoRateAfterGapUntilMeanIsComplete) {
  auto axes = axes_with_shared_thermometer();
  for (CompensatedAxis& axis : axes) axis.dataset.time_s.tail(400).array() += 50;
  const auto fused = compensate_axes(axes);
  ASSERT_TRUE(fused) << text(fused.error());
  EXPECT_TRUE(fused->rate_deg_per_h.middleRows(99, 501).allFinite());
  EXPECT_TRUE(fused->rate_deg_per_h.middleRows(600, 99).array().isNaN().all());
  EXPECT_TRUE(fused->rate_deg_per_h.bottomRows(301).allFinite());
}

TEST(FusedAxes, RejectModelOfOtherAxisAndWarnOfOtherGyro) {
  auto axes = axes_with_shared_thermometer();
  for (CompensatedAxis& axis : axes) {
    axis.dataset.of = {.unit = "triad", .axis = axis.dataset.of.unit};
    axis.dataset.identity = "0042";
    axis.model.trained_on.resize(1);
    axis.model.trained_on[0].of = axis.dataset.of;
    axis.model.trained_on[0].identity = "0042";
  }
  EXPECT_TRUE(compensate_axes(axes)->warnings.empty());
  axes[1].model.trained_on[0].identity = "0043";
  const auto other = compensate_axes(axes);
  ASSERT_TRUE(other) << text(other.error());
  ASSERT_EQ(other->warnings.size(), 1u);
  EXPECT_EQ(other->warnings[0],
            "triad.y: the model belongs to another gyro: it was trained on 0043, this record is of 0042");
  axes[2].model.trained_on[0].of.axis = "x";
  const auto refused = compensate_axes(axes);
  ASSERT_FALSE(refused);
  EXPECT_NE(text(refused.error()).find("axis triad.z: its model belongs to another axis: it was trained on triad.x"),
            std::string::npos)
      << text(refused.error());
}

TEST(FusedAxes, RejectMissingDirectionOrBudget) {
  auto axes = axes_with_shared_thermometer();
  axes[1].dataset.direction.reset();
  const auto refused = compensate_axes(axes);
  ASSERT_FALSE(refused);
  EXPECT_NE(text(refused.error()).find("axis y"), std::string::npos) << text(refused.error());
  axes = axes_with_shared_thermometer();
  axes[0].model.uncertainty.reset();
  EXPECT_FALSE(compensate_axes(axes));
}

TEST(ClusterMeans, OmitClusterWithMissingSecond) {
  Eigen::VectorXd time = Eigen::VectorXd::LinSpaced(300, 0, 299);
  Eigen::VectorXd values = Eigen::VectorXd::Constant(300, 1);
  const auto complete = cluster_means(time, values, 100);
  EXPECT_EQ(complete.end_s.size(), 3);
  time.tail(150).array() += 1;
  const auto with_gap = cluster_means(time, values, 100);
  EXPECT_EQ(with_gap.end_s.size(), 2) << "149 s is followed by 151 s";
}

}  // namespace
}  // namespace gyrotherm::model
