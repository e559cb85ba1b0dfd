// SPDX-License-Identifier: Apache-2.0
#include "analysis/tracking/assessment.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "analysis/tracking/baselines.hpp"
#include "tests/analysis/tracking/known_bias.hpp"

namespace gyrotherm::tracking {
namespace {

const DenoiserFigures& of(const Assessment& assessment, const std::string& name) {
  const auto found = std::ranges::find(assessment.denoisers, name, &DenoiserFigures::name);
  EXPECT_NE(found, assessment.denoisers.end()) << name;
  return *found;
}

constexpr const char* kAlone = "thermal model alone";

/// Returns assessments of ten known biases over 40 h.
const std::vector<Assessment>& assessments() {
  static const std::vector<Assessment> all = [] {
    std::vector<Assessment> assessed;
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      const DrawnBias known = known_bias(1440, seed);
      assessed.push_back(assess(virtual_noise(), known.measured_deg_per_h, kInterval_s, known.bias_deg_per_h));
    }
    return assessed;
  }();
  return all;
}

/// Returns the root mean square of a result over the ten assessments.
double rms_over_assessments(const std::string& name, double DenoiserFigures::*figure) {
  double sum = 0;
  for (const Assessment& assessment : assessments()) sum += std::pow(of(assessment, name).*figure, 2);
  return std::sqrt(sum / static_cast<double>(assessments().size()));
}

TEST(Assessment, RanksKalmanFilterFirstWithoutDelay) {
  const double kalman = rms_over_assessments("Kalman", &DenoiserFigures::rmse_to_truth);
  const double hour = rms_over_assessments("Kalman", &DenoiserFigures::next_hour_rmse_to_truth);
  EXPECT_LT(kalman, 5.5e-4) << "no tracker can follow the fastest flicker";
  EXPECT_LT(hour, 4.5e-4);
  for (const DenoiserFigures& figures : assessments().front().denoisers) {
    if (figures.name == "Kalman" || figures.latency_s > 0) continue;
    EXPECT_GT(rms_over_assessments(figures.name, &DenoiserFigures::rmse_to_truth), 1.05 * kalman) << figures.name;
    EXPECT_GT(rms_over_assessments(figures.name, &DenoiserFigures::next_hour_rmse_to_truth), 1.03 * hour)
        << figures.name;
  }
}

TEST(Assessment, RanksKalmanFilterFirstOneHourLate) {
  const double kalman = rms_over_assessments("Kalman, an hour late", &DenoiserFigures::rmse_to_truth);
  EXPECT_LT(kalman, 0.95 * rms_over_assessments("Kalman", &DenoiserFigures::rmse_to_truth))
      << "gain from one more hour";
  EXPECT_LT(kalman, 0.95 * rms_over_assessments("wavelet, an hour late", &DenoiserFigures::rmse_to_truth));
}

TEST(Assessment, FindsGainOnEverySeedButNotOnShuffledResidual) {
  for (const Assessment& assessment : assessments()) {
    const DenoiserFigures &alone = of(assessment, kAlone), &kalman = of(assessment, "Kalman");
    EXPECT_EQ(alone.shuffled_gain, 0);
    EXPECT_LT(kalman.next_hour_rmse, alone.next_hour_rmse);
    for (const DenoiserFigures& figures : assessment.denoisers) {
      EXPECT_EQ(std::isnan(figures.shuffled_gain), figures.latency_s > 0) << figures.name;
      EXPECT_FALSE(figures.shuffled_gain > 0.02) << figures.name;
    }
  }
}

TEST(Assessment, IncludesNoiseOfMeasuredHour) {
  const double measured = rms_over_assessments("Kalman", &DenoiserFigures::next_hour_rmse);
  const double truly = rms_over_assessments("Kalman", &DenoiserFigures::next_hour_rmse_to_truth);
  EXPECT_NEAR(measured, std::hypot(truly, 3e-4), 3e-5) << "the angle random walk of 3e-4 °/h over one hour";
}

TEST(Assessment, FindsThatNoDenoiserLowersAngleRandomWalk) {
  for (const Assessment& assessment : assessments()) {
    const double none = of(assessment, kAlone).allan_interval;
    for (const DenoiserFigures& figures : assessment.denoisers) {
      EXPECT_FALSE(figures.allan_interval < 0.99 * none) << figures.name;
    }
    EXPECT_LT(of(assessment, "Kalman").allan_interval, 1.04 * none) << "the filter hardly increases it";
  }
}

TEST(Assessment, FindsInnovationsConsistentForCorrectNoise) {
  int inside = 0, white = 0;
  for (const Assessment& assessment : assessments()) {
    const Consistency& consistency = assessment.consistency;
    EXPECT_EQ(consistency.innovations, 1440 - 72);
    inside += consistency.mean_square > consistency.low && consistency.mean_square < consistency.high ? 1 : 0;
    white += consistency.whiteness.probability > 0.01 ? 1 : 0;
  }
  EXPECT_GE(inside, 9);
  EXPECT_GE(white, 9);
}

TEST(Assessment, OmitsResultsWithoutDataOrTruth) {
  const Eigen::VectorXd few = known_bias(80, 1).measured_deg_per_h;
  const Assessment assessment = assess(virtual_noise(), few, kInterval_s);
  EXPECT_EQ(assessment.hours, 0);
  for (const DenoiserFigures& figures : assessment.denoisers) {
    EXPECT_TRUE(std::isnan(figures.next_hour_rmse)) << figures.name;
    EXPECT_TRUE(std::isnan(figures.rmse_to_truth)) << "no true bias was given";
    EXPECT_TRUE(std::isnan(figures.shuffled_gain));
  }
}

TEST(Assessment, CountsOnlyHoursWithoutGap) {
  DrawnBias known = known_bias(600, 3);
  const int whole = assess(virtual_noise(), known.measured_deg_per_h, kInterval_s).hours;
  EXPECT_EQ(whole, (600 - 72 - 36) / 36);
  known.measured_deg_per_h.segment(300, 36).setConstant(kMissing);
  EXPECT_EQ(assess(virtual_noise(), known.measured_deg_per_h, kInterval_s).hours, (600 - 72 - 36 - 71) / 36);
}

Response named_response(const std::string& name) {
  const StateSpace space = virtual_space();
  const auto all = denoisers(space);
  return measure_response(*std::ranges::find(all, name, &Denoiser::name), space);
}

TEST(Response, IsHalfAnHourLateForHourlyMean) {
  const Response response = named_response("mean of the last hour");
  EXPECT_EQ(response.step_delay_s, 1800);
  EXPECT_NEAR(response.ramp_delay_s, 1750, 1e-6) << "mean delay of 0 … 35 intervals";
  EXPECT_NEAR(response.step_overshoot, 0, 1e-12);
  EXPECT_NEAR(response.ramp_overshoot_deg_per_h, 0, 1e-12);
}

TEST(Response, IsMissingWithoutDenoiser) {
  const Response response = named_response(kAlone);
  EXPECT_TRUE(std::isnan(response.step_delay_s));
  EXPECT_NEAR(response.ramp_delay_s, 6 * 3600, 51);
}

TEST(Response, IsLinearForKalmanFilter) {
  const Response response = named_response("Kalman");
  EXPECT_GT(response.step_delay_s, 0.5 * 3600);
  EXPECT_LT(response.step_delay_s, 3600);
  EXPECT_LT(response.step_overshoot, 0.05);
  EXPECT_GT(response.ramp_delay_s, 3600);
  EXPECT_LT(response.ramp_delay_s, 4 * 3600);
  EXPECT_LT(response.ramp_overshoot_deg_per_h, 0.1);
}

TEST(EvenlySpaced, PutsEachClusterAtItsIndex) {
  data::Clusters clusters;
  clusters.start_s = Eigen::Vector4d{300, 400, 700, 800};
  const Eigen::VectorXd spaced = space_evenly(Eigen::Vector4d{1, 2, 3, 4}, clusters);
  ASSERT_EQ(spaced.size(), 6);
  EXPECT_EQ(spaced(0), 1);
  EXPECT_EQ(spaced(1), 2);
  EXPECT_TRUE(std::isnan(spaced(2)) && std::isnan(spaced(3)));
  EXPECT_EQ(spaced(4), 3);
  EXPECT_EQ(spaced(5), 4);
}

TEST(Whiteness, HasUniformProbabilityForWhiteValues) {
  std::vector<double> probabilities;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    Eigen::VectorXd values = white_noise(600, seed);
    values.segment(100, 40).setConstant(kMissing);
    probabilities.push_back(test_whiteness(values, 20).probability);
  }
  std::ranges::sort(probabilities);
  double farthest = 0;  // Kolmogorov-Smirnov statistic
  for (std::size_t i = 0; i < probabilities.size(); ++i) {
    farthest = std::max(farthest, std::abs(probabilities[i] - (static_cast<double>(i) + 0.5) / 400));
  }
  EXPECT_LT(farthest, 1.63 / std::sqrt(400)) << "1 %";
}

TEST(Whiteness, FindsWeakCorrelation) {
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    Eigen::VectorXd values = white_noise(1440, seed);
    for (Eigen::Index k = 1; k < values.size(); ++k) values(k) += 0.2 * values(k - 1);
    found += test_whiteness(values, 20).probability < 0.01 ? 1 : 0;
  }
  EXPECT_EQ(found, 50);
}

TEST(Whiteness, IsUnknownForTooFewValues) {
  EXPECT_TRUE(std::isnan(test_whiteness(white_noise(40, 1), 20).probability));
  EXPECT_TRUE(std::isnan(test_whiteness(Eigen::VectorXd::Zero(100), 20).probability));
}

TEST(Whiteness, DoesNotDependOnScale) {
  Eigen::VectorXd values = white_noise(200, 1);
  values(7) = kMissing;
  const Whiteness expected = test_whiteness(values, 20);
  for (const int exponent : {1000, 500, -500, -900}) {
    const Whiteness found = test_whiteness(values * std::exp2(exponent), 20);
    EXPECT_EQ(found.statistic, expected.statistic) << exponent;
    EXPECT_EQ(found.probability, expected.probability) << exponent;
  }
  EXPECT_LT(test_whiteness(Eigen::VectorXd::Constant(200, -1e308), 20).probability, 1e-6);
}

TEST(Consistency, DetectsWrongNoiseModel) {
  const Eigen::VectorXd rates = known_bias(1440, 1).measured_deg_per_h;
  BiasNoise quiet = virtual_noise(), lazy = virtual_noise();
  quiet.angle_random_walk_deg_per_sqrt_h /= 1.1;
  lazy.instability_deg_per_h = lazy.rate_random_walk_deg_per_h_per_sqrt_h = 0;
  const auto assessed = [&](const BiasNoise& noise) {
    return test_consistency(track(state_space(noise, kInterval_s), rates), 72);
  };
  EXPECT_GT(assessed(quiet).mean_square, assessed(quiet).high);
  const Consistency right = assessed(virtual_noise());
  EXPECT_GT(right.mean_square, right.low);
  EXPECT_LT(right.mean_square, right.high);
  EXPECT_GT(right.whiteness.probability, 0.05);
  EXPECT_GT(assessed(lazy).whiteness.statistic, right.whiteness.statistic);
  EXPECT_EQ(right.innovations, 1440 - 72);
}

}  // namespace
}  // namespace gyrotherm::tracking
