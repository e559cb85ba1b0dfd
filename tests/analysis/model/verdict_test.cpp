// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/verdict.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

namespace gyrotherm::model {
namespace {

/// Clusters of 100 s without a gap.
data::Clusters clusters_of(Eigen::Index count) {
  data::Clusters clusters;
  clusters.start_s = Eigen::VectorXd::LinSpaced(count, 0, 100.0 * static_cast<double>(count - 1));
  clusters.bias_deg_per_h.setZero(count);
  return clusters;
}

std::vector<Eigen::Index> all_rows(const data::Clusters& clusters) {
  std::vector<Eigen::Index> rows(static_cast<std::size_t>(clusters.start_s.size()));
  std::iota(rows.begin(), rows.end(), 0);
  return rows;
}

Verdict judge(const Eigen::VectorXd& bias, const Eigen::VectorXd& predicted, BiasZero zero = BiasZero::known) {
  constexpr int kFewest = 8;
  const data::Clusters clusters = clusters_of(bias.size());
  return judge_gain(bias, bias - predicted, clusters, all_rows(clusters), zero, kFewest);
}

Eigen::VectorXd white_noise(Eigen::Index count, std::mt19937_64& random, double std = 1) {
  std::normal_distribution<double> normal(0, std);
  return Eigen::VectorXd::NullaryExpr(count, [&] { return normal(random); });
}

/// Temperature of a record with several cycles, from −1 to 1.
Eigen::VectorXd cycles(Eigen::Index count, double periods) {
  return Eigen::VectorXd::NullaryExpr(count, [&](Eigen::Index k) {
    return std::sin(2 * std::numbers::pi * periods * static_cast<double>(k) / static_cast<double>(count));
  });
}

/// The model has learnt a small slope from the noise of another record. Truth: it cannot improve this record.
TEST(Verdict, RarelyCallsPureNoiseAnImprovement) {
  constexpr int kSeeds = 400;
  std::mt19937_64 random(79);
  std::normal_distribution<double> normal;
  int improved = 0, undecided = 0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const Eigen::VectorXd predicted = 0.15 * normal(random) * cycles(216, 2);
    const Gain gain = judge(white_noise(216, random), predicted).gain;
    improved += gain == Gain::improves ? 1 : 0;
    undecided += gain == Gain::undecided ? 1 : 0;
  }
  EXPECT_LE(improved, kSeeds / 20);
  EXPECT_GT(undecided, kSeeds / 2);
}

/// A gyro with a random walk of its bias, and a model that predicts a slow change with temperature. The walk follows
/// the temperature by chance in some records, where the model does reduce it. A comparison of the two STDs would call
/// half of the records an improvement.
TEST(Verdict, RarelyCallsDriftAnImprovement) {
  constexpr int kSeeds = 200;
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  int improved = 0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    Eigen::VectorXd bias = white_noise(216, random, 0.1);
    double walk = 0;
    for (double& value : bias) value += walk += 0.1 * normal(random);
    improved += judge(bias, 0.3 * normal(random) * cycles(216, 1)).gain == Gain::improves ? 1 : 0;
  }
  EXPECT_LE(improved, kSeeds * 3 / 20);
}

TEST(Verdict, FindsImprovementThatExceedsNoise) {
  std::mt19937_64 random(1);
  for (const double periods : {0.5, 1.0, 4.0}) {
    const Eigen::VectorXd effect = cycles(216, periods);
    const Verdict verdict = judge(effect + white_noise(216, random, 0.1), 0.95 * effect);
    EXPECT_EQ(verdict.gain, Gain::improves) << periods << " periods: " << verdict.statement;
    EXPECT_GT(verdict.std_deg_per_h.value, 10 * verdict.std_deg_per_h.error);
    EXPECT_NEAR(verdict.rmse_deg_per_h.value, std::sqrt(0.5 + 0.01) - std::sqrt(0.01 + 0.05 * 0.05 / 2), 0.05);
  }
}

/// The standard error of the reduction is the scatter of the reduction between records.
TEST(Verdict, StatesErrorOfReduction) {
  constexpr int kSeeds = 200;
  std::mt19937_64 random(5);
  double squares = 0, error_squares = 0, mean = 0;
  std::vector<double> reductions;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const Verdict verdict = judge(0.5 * cycles(216, 3) + white_noise(216, random), 0.4 * cycles(216, 3));
    reductions.push_back(verdict.std_deg_per_h.value);
    mean += verdict.std_deg_per_h.value / kSeeds;
    error_squares += std::pow(verdict.std_deg_per_h.error, 2) / kSeeds;
  }
  for (const double reduction : reductions) squares += std::pow(reduction - mean, 2) / kSeeds;
  EXPECT_NEAR(std::sqrt(error_squares / squares), 1, 0.2);
}

/// A model of a unit of 12 °/h on a unit of 0 °/h.
TEST(Verdict, RefusesOffsetOfAnotherUnit) {
  std::mt19937_64 random(2);
  const Eigen::VectorXd effect = 2 * cycles(216, 2), bias = effect + white_noise(216, random, 0.1);
  const Eigen::VectorXd predicted = effect.array() + 12;
  const Verdict verdict = judge(bias, predicted);
  EXPECT_EQ(verdict.gain, Gain::does_not_improve) << verdict.statement;
  EXPECT_NEAR(verdict.rmse_deg_per_h.value, std::sqrt(2.01) - 12, 0.05);
  EXPECT_NE(verdict.statement.find("the offset decides"), std::string::npos) << verdict.statement;
  EXPECT_TRUE(make_no_gain_warning("compensated bias", verdict));
  const Verdict own_zero = judge(bias, predicted, BiasZero::mean_of_first_hold);
  EXPECT_EQ(own_zero.gain, Gain::improves) << "the offset has no meaning";
  EXPECT_TRUE(std::isnan(own_zero.rmse_deg_per_h.value));
  EXPECT_NE(own_zero.statement.find("the rmse does not count"), std::string::npos) << own_zero.statement;
  EXPECT_FALSE(make_no_gain_warning("compensated bias", own_zero));
}

/// The model removes a large wave and adds an offset that is larger still. The offset is known, so it is not noise.
TEST(Verdict, RefusesOffsetThatExceedsRemovedWave) {
  std::mt19937_64 random(9);
  const Eigen::VectorXd wave = 0.06 * cycles(288, 3), bias = wave + white_noise(288, random, 0.005);
  for (const double offset : {0.2, -0.2}) {
    const Verdict verdict = judge(bias, wave.array() + offset);
    EXPECT_EQ(verdict.gain, Gain::does_not_improve) << verdict.statement;
    EXPECT_TRUE(make_no_gain_warning("compensated bias", verdict));
    EXPECT_LT(verdict.rmse_deg_per_h.error, 0.01) << verdict.statement;
  }
  EXPECT_EQ(judge(bias, wave.array() + 0.005).gain, Gain::improves);
}

/// The scatter of the reduction of the RMSE between records, with an offset that the model removes in part.
TEST(Verdict, StatesErrorOfReductionOfRmse) {
  constexpr int kSeeds = 200;
  std::mt19937_64 random(10);
  double error_squares = 0;
  std::vector<double> reductions;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const Eigen::VectorXd bias = (0.5 * cycles(216, 3) + white_noise(216, random)).array() + 0.7;
    const Verdict verdict = judge(bias, (0.4 * cycles(216, 3)).array() + 0.5);
    reductions.push_back(verdict.rmse_deg_per_h.value);
    error_squares += std::pow(verdict.rmse_deg_per_h.error, 2) / kSeeds;
  }
  const double mean = std::accumulate(reductions.begin(), reductions.end(), 0.0) / kSeeds;
  double squares = 0;
  for (const double reduction : reductions) squares += std::pow(reduction - mean, 2) / kSeeds;
  const double ratio = std::sqrt(error_squares / squares);
  EXPECT_GT(ratio, 0.8);
  EXPECT_LT(ratio, 1.7) << "a short record cannot exclude slow noise of the mean";
}

TEST(Verdict, DoesNotCallRemovedConstantAnImprovement) {
  std::mt19937_64 random(4);
  const Eigen::VectorXd bias = white_noise(216, random).array() - 4.2;
  const Verdict verdict = judge(bias, Eigen::VectorXd::Constant(216, -4.2));
  EXPECT_EQ(verdict.gain, Gain::undecided);
  EXPECT_TRUE(verdict.only_offset);
  EXPECT_NE(verdict.statement.find("only a constant offset"), std::string::npos) << verdict.statement;
  EXPECT_EQ(verdict.std_deg_per_h.value, 0);
}

TEST(Verdict, FindsModelThatMakesBiasWorse) {
  std::mt19937_64 random(6);
  const Verdict verdict = judge(white_noise(216, random, 0.1), cycles(216, 3));
  EXPECT_EQ(verdict.gain, Gain::does_not_improve) << verdict.statement;
  EXPECT_FALSE(verdict.only_offset);
  EXPECT_LT(verdict.std_deg_per_h.value, 0);
}

/// Most of both series is one slow excursion, so only few clusters are independent.
TEST(Verdict, NamesTooFewEffectiveClusters) {
  std::mt19937_64 random(8);
  const Eigen::VectorXd bias = cycles(40, 0.7) + white_noise(40, random, 0.02);
  const Verdict verdict = judge(bias, 0.4 * cycles(40, 0.5));
  EXPECT_EQ(verdict.gain, Gain::not_enough_data) << verdict.statement;
  EXPECT_LT(verdict.effective, 5);
}

TEST(Verdict, RequiresClusters) {
  for (const Eigen::Index count : {0, 1, 7}) {
    const Eigen::VectorXd bias = Eigen::VectorXd::LinSpaced(count, 0, 1);
    const data::Clusters clusters = clusters_of(std::max<Eigen::Index>(count, 1));
    std::vector<Eigen::Index> rows = all_rows(clusters_of(std::max<Eigen::Index>(count, 1)));
    rows.resize(static_cast<std::size_t>(count));
    const Verdict verdict = judge_gain(bias, 0.5 * bias, clusters, rows, BiasZero::known, 8);
    EXPECT_EQ(verdict.gain, Gain::not_enough_data) << count;
    EXPECT_FALSE(make_no_gain_warning("compensated bias", verdict)) << "nothing is known";
  }
}

TEST(Verdict, RequiresClustersPerParameterOfTraining) {
  std::mt19937_64 random(9);
  data::Clusters clusters = clusters_of(60);
  clusters.bias_deg_per_h = (cycles(60, 2) + white_noise(60, random, 0.02)).array() + 7;
  Eigen::VectorXd residual = white_noise(60, random, 0.02);
  residual(0) = std::nan("");
  EXPECT_EQ(judge_held_out(residual, clusters, 3).gain, Gain::improves) << "the constant of 7 °/h is not a gain";
  EXPECT_LT(judge_held_out(residual, clusters, 3).rmse_deg_per_h.value, 1);
  EXPECT_EQ(judge_held_out(residual, clusters, 12).gain, Gain::not_enough_data);
  EXPECT_EQ(judge_held_out(residual, clusters, 0).gain, Gain::improves) << "unknown";
  residual.tail(41).setConstant(std::nan(""));
  EXPECT_EQ(judge_held_out(residual, clusters, 3).gain, Gain::not_enough_data);
}

TEST(Verdict, JudgesCoverageByEffectiveNumber) {
  EXPECT_FALSE(is_below_nominal(0.95, 0.95, 1000));
  EXPECT_FALSE(is_below_nominal(1, 0.95, 1000));
  EXPECT_FALSE(is_below_nominal(0.93, 0.95, 100));
  EXPECT_TRUE(is_below_nominal(0.93, 0.95, 1000));
  EXPECT_TRUE(is_below_nominal(0.12, 0.95, 216));
  EXPECT_TRUE(is_below_nominal(0, 0.95, 216));
  EXPECT_FALSE(is_below_nominal(0.6, 0.95, 2)) << "two independent means say little";
  EXPECT_TRUE(is_below_nominal(0, 0.95, 3));
}

TEST(Verdict, IsOneLine) {
  Verdict verdict{.gain = Gain::improves, .statement = "std 2 → 1 °/h"};
  EXPECT_EQ(describe_verdict(verdict), "verdict: improves; std 2 → 1 °/h");
  verdict.intervals_hold = false;
  EXPECT_EQ(describe_verdict(verdict), "verdict: improves; std 2 → 1 °/h; the intervals do not hold");
}

}  // namespace
}  // namespace gyrotherm::model
