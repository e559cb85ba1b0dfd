// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/recommendation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace gyrotherm::model {
namespace {

TEST(Recommendation, SelectsSimplestWithinOneStandardError) {
  // The MSE of "small" exceeds that of the best model by 1, 0 and −0.5: 0.17 ± 0.44. That of "tiny" exceeds it by 3 on
  // each record.
  const Recommendation found =
      recommend({{"large", 9000, {4, 5, 6}}, {"small", 20, {5, 5, 5.5}}, {"tiny", 5, {7, 8, 9}}});
  EXPECT_EQ(found.lowest, "large");
  EXPECT_EQ(found.recommended, "small");
  EXPECT_EQ(found.records, 3);
  ASSERT_EQ(found.candidates.size(), 3U);
  EXPECT_DOUBLE_EQ(found.candidates[0].rmse_deg_per_h, std::sqrt(5.0));
  EXPECT_DOUBLE_EQ(found.candidates[0].expanded_deg_per_h, 2 * std::sqrt(5.0));
  EXPECT_NEAR(found.candidates[1].behind_mse, 0.5 / 3, 1e-15);
  EXPECT_NEAR(found.candidates[1].behind_error_mse, std::sqrt((25.0 / 36 + 1.0 / 36 + 16.0 / 36) / 2 / 3), 1e-12);
  EXPECT_FALSE(found.candidates[2].within);
}

/// An error that all models of a record share, such as the turn-on bias, does not hide that one model is always worse.
TEST(Recommendation, ComparesRecordByRecord) {
  const Recommendation found = recommend({{"large", 9000, {1, 100, 10000}}, {"small", 20, {1.1, 100.1, 10000.1}}});
  EXPECT_EQ(found.recommended, "large");
}

TEST(Recommendation, SelectsLowestForSingleRecord) {
  EXPECT_EQ(recommend({{"large", 9000, {1}}, {"small", 20, {1.01}}}).recommended, "large");
  EXPECT_EQ(recommend({{"large", 9000, {1}}, {"small", 20, {1}}}).recommended, "small")
      << "the simpler model is preferred if errors are equal";
}

TEST(Recommendation, SelectsNoneWithoutRecord) {
  for (const auto& candidates : {std::vector<Candidate>{}, {{"svr", 10, {}}, {"linear", 5, {}}}}) {
    const Recommendation found = recommend(candidates);
    EXPECT_TRUE(found.recommended.empty());
    EXPECT_NE(found.statement.find("no independent record for the choice"), std::string::npos);
  }
}

TEST(Recommendation, NeverSelectsNonFiniteError) {
  const Recommendation found = recommend({{"refuses", 1, {std::nan(""), 1}}, {"answers", 20, {5, 5}}});
  EXPECT_EQ(found.recommended, "answers");
  EXPECT_EQ(found.candidates.size(), 1U);
}

TEST(Recommendation, SatisfiesRuleForRandomErrors) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> error(1, 2);
  for (int trial = 0; trial < 100; ++trial) {
    SCOPED_TRACE(trial);
    std::vector<Candidate> candidates;
    for (int k = 0; k < 12; ++k)
      candidates.push_back(
          {std::to_string(k), static_cast<int>(random() % 1000), {error(random), error(random), error(random)}});
    const Recommendation found = recommend(candidates);
    EXPECT_TRUE(std::ranges::is_sorted(found.candidates, {}, &CandidateResult::expanded_deg_per_h));
    const auto taken = std::ranges::find(found.candidates, found.recommended, &CandidateResult::name);
    ASSERT_NE(taken, found.candidates.end());
    EXPECT_TRUE(taken->within);
    for (const CandidateResult& judged : found.candidates) {
      EXPECT_GE(judged.behind_mse, 0);
      if (judged.within) {
        EXPECT_GE(judged.stored_numbers, taken->stored_numbers);
      }
    }
    std::ranges::shuffle(candidates, random);
    EXPECT_EQ(recommend(candidates).recommended, found.recommended);
  }
}

}  // namespace
}  // namespace gyrotherm::model
