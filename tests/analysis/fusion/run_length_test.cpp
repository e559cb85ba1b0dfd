// SPDX-License-Identifier: Apache-2.0
#include "analysis/fusion/run_length.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "tests/analysis/fusion/fixtures.hpp"

namespace gyrotherm::fusion {
namespace {

/// Steps until the sum of drawn vectors alarms, in the mean of many runs. The runs are nearly exponential: their mean
/// is known to its own size over the root of their number.
double drawn_run_length(int dimension, double slack, double limit, int runs) {
  double steps = 0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    Draws draws(static_cast<std::uint64_t>(seed));
    for (int run = 0; run < runs / kSeeds; ++run) {
      Eigen::VectorXd sum = Eigen::VectorXd::Zero(dimension);
      while (sum.norm() <= limit) {
        sum += draws.normal(dimension);
        sum *= std::max(0.0, 1 - slack / sum.norm());
        ++steps;
      }
    }
  }
  return steps / runs;
}

TEST(RunLength, IsThatOfVectorsThatAreDrawn) {
  constexpr int kRuns = 4000;
  struct Chart {
    int dimension;
    double slack, limit;
  };
  for (const Chart& chart : {Chart{1, 0.5, 4}, {2, 0.5, 5.5}, {3, 0.2, 12}, {10, 0.5, 15}}) {
    const double expected = average_run_length(chart.dimension, chart.slack, chart.limit);
    EXPECT_NEAR(drawn_run_length(chart.dimension, chart.slack, chart.limit, kRuns) / expected, 1, 4 / std::sqrt(kRuns))
        << chart.dimension;
  }
}

/// With one number a step the chain on −h … h is cut into small intervals (Brook and Evans, Biometrika 59 (1972) 539),
/// the normal distribution's own probability in each: nothing in it is noncentral or squared.
TEST(RunLength, OfOneNumberIsThatOfAFineMarkovChain) {
  const double slack = 0.25, limit = 6;
  constexpr int kHalf = 300, kStates = 2 * kHalf + 1;  // the middle one is 0 alone, made by the slack
  const double width = limit / kHalf;
  const auto below = [](double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); };
  Eigen::VectorXd centres = Eigen::VectorXd::Zero(kStates);
  for (int i = 1; i <= kHalf; ++i) {
    centres(kHalf + i) = (i - 0.5) * width;
    centres(kHalf - i) = -centres(kHalf + i);
  }
  Eigen::MatrixXd left = Eigen::MatrixXd::Identity(kStates, kStates);
  for (int i = 0; i < kStates; ++i) {
    for (int j = 0; j < kStates; ++j) {
      const double before = j == kHalf ? 0 : centres(j) + std::copysign(slack, centres(j));
      const double half = j == kHalf ? slack : width / 2;
      left(i, j) -= below(before + half - centres(i)) - below(before - half - centres(i));
    }
  }
  const Eigen::VectorXd lengths = left.partialPivLu().solve(Eigen::VectorXd::Ones(kStates));
  EXPECT_NEAR(average_run_length(1, slack, limit) / lengths(kHalf), 1, 1e-3);
}

TEST(RunLength, GrowsAndIsMetByItsLimit) {
  for (const int dimension : {1, 3, 8}) {
    for (const double slack : {0.1, 0.5}) {
      double before = 0;
      for (const double run_length : {50.0, 3600.0, 1e6}) {
        const double limit = limit_for_run_length(dimension, slack, run_length);
        EXPECT_GT(limit, before);
        EXPECT_NEAR(average_run_length(dimension, slack, limit) / run_length, 1, 1e-4) << dimension << ", " << slack;
        before = limit;
      }
    }
  }
}

/// Of one number and in a long run each further unit of h multiplies it by exp(2k): exp(2 k S) is Wald's martingale.
TEST(RunLength, GrowsByTheExponentOfTwiceTheSlack) {
  const double slack = 0.2, first = average_run_length(1, slack, 25), second = average_run_length(1, slack, 26);
  EXPECT_NEAR(std::log(second / first), 2 * slack, 1e-3);
}

}  // namespace
}  // namespace gyrotherm::fusion
