// SPDX-License-Identifier: Apache-2.0
#include "analysis/assurance/run_length.hpp"

#include <gtest/gtest.h>

namespace gyrotherm::assurance {
namespace {

TEST(RunLength, OfIndividualsIsThatOfShewhart) {
  // Montgomery, 6th edition, section 5.3: 370 in control at 3 sigma; a shift of 1 sigma takes 43.9 values.
  EXPECT_NEAR(individuals_run_length(3), 370.4, 0.1);
  EXPECT_NEAR(individuals_run_length(3, 1), 43.9, 0.05);
  EXPECT_NEAR(individuals_run_length(3, -1), individuals_run_length(3, 1), 1e-9);
}

TEST(RunLength, OfEwmaIsThatOfLucasAndSaccucci) {
  // Lucas and Saccucci 1990, as in Montgomery's table 9.11: schemes with an in-control length of 500.
  struct {
    double lambda, limit, shift, length;
  } const rows[] = {{0.40, 3.054, 0, 500},    {0.20, 2.962, 0, 500},    {0.10, 2.814, 0, 500},
                    {0.25, 2.998, 0.5, 48.2}, {0.10, 2.814, 0.5, 31.3}, {0.20, 2.962, 1, 10.5},
                    {0.10, 2.814, 1, 10.3},   {0.40, 3.054, 2, 3.5},    {0.20, 2.962, 4, 1.9}};
  for (const auto& row : rows)
    EXPECT_NEAR(ewma_run_length(row.lambda, row.limit, row.shift) / row.length, 1, 0.025)
        << row.lambda << " " << row.shift;
}

TEST(RunLength, OfEwmaWithoutMemoryIsThatOfIndividuals) {
  EXPECT_NEAR(ewma_run_length(1, 3), individuals_run_length(3), 1);
  EXPECT_NEAR(ewma_run_length(1, 3, 2), individuals_run_length(3, 2), 0.1);
}

TEST(RunLength, LimitsHaveTheStatedRate) {
  for (const double rate : {0.2, 0.01, 1e-4, 1e-6}) {
    EXPECT_NEAR(individuals_run_length(individuals_limit(rate)) * rate, 1, 1e-6);
    const double limit = ewma_limit(0.2, rate);
    EXPECT_LE(1 / ewma_run_length(0.2, limit), rate);
    EXPECT_NEAR(ewma_run_length(0.2, limit) * rate, 1, 1e-3);
  }
}

}  // namespace
}  // namespace gyrotherm::assurance
