// SPDX-License-Identifier: Apache-2.0
#include "analysis/assurance/record_state.hpp"

#include <gtest/gtest.h>

#include <string>

#include "tests/support/check_study.hpp"

namespace gyrotherm::assurance {
namespace {

/// Returns ten runs; a thermometer is changed by 0.5 K from the run `from` on, counted from 0.
History changed_history(int from) {
  return tests::make_history(
      {.golden = tests::GoldenGyro::single, .injected = tests::Injected::thermometer, .runs = 10, .thermometer_k = 0.5},
      3, from);
}

/// Returns a time after the start of a check run and before that of the next one.
std::string soon_after(const History& history, std::size_t run) { return history.checks[run].started_utc + "+"; }

TEST(RecordState, FindsRunsBesideRecord) {
  const auto history = changed_history(10);
  const auto assessment = assess(history);
  const auto early = find_state(history, assessment, "2000-01-01T00:00:00Z");
  EXPECT_EQ(early.state, CheckState::unknown);
  EXPECT_FALSE(early.before);
  EXPECT_EQ(early.after, std::size_t{0});
  const auto late = find_state(history, assessment, "2999-01-01T00:00:00Z");
  EXPECT_EQ(late.state, CheckState::in_control);
  EXPECT_EQ(late.before, std::size_t{9});
  EXPECT_FALSE(late.after);
  const auto same = find_state(history, assessment, history.checks[6].started_utc);
  EXPECT_EQ(same.before, std::size_t{6}) << "the record of the check run itself";
  EXPECT_EQ(same.after, std::size_t{7});
  EXPECT_EQ(find_state(history, assessment, history.checks[1].started_utc).state, CheckState::unknown)
      << "the fifth run is the first that is judged";
}

TEST(RecordState, IsOutOfControlFromLastRunInControlOn) {
  const auto history = changed_history(7);
  const auto assessment = assess(history);
  ASSERT_TRUE(assessment.runs[7].is_open());
  const auto state_at = [&](const std::string& utc) { return find_state(history, assessment, utc).state; };
  EXPECT_EQ(state_at(history.checks[6].started_utc), CheckState::in_control);
  EXPECT_EQ(state_at(soon_after(history, 6)), CheckState::out_of_control)
      << "between the last good run and the open one";
  EXPECT_EQ(state_at(history.checks[7].started_utc), CheckState::out_of_control);
  EXPECT_EQ(state_at("2999-01-01T00:00:00Z"), CheckState::out_of_control);
}

TEST(RecordState, IsExplainedBesideExplainedRun) {
  auto history = changed_history(7);
  Explanation explanation{
      .cause = "thermometer", .part = "D", .by = "A", .utc = "2026-11-25T14:03:07Z", .new_level = true};
  for (std::size_t run = 7; run < 10; ++run) explanation.run_ids.push_back(history.checks[run].run_id);
  history.explanations.push_back(explanation);
  const auto assessment = assess(history);
  EXPECT_EQ(find_state(history, assessment, history.checks[5].started_utc).state, CheckState::in_control);
  EXPECT_EQ(find_state(history, assessment, history.checks[6].started_utc).state, CheckState::explained);
  EXPECT_EQ(find_state(history, assessment, "2999-01-01T00:00:00Z").state, CheckState::explained);
}

TEST(RecordState, IsUnknownForEmptyHistory) {
  const auto state = find_state({}, {}, "2026-11-25T14:03:07Z");
  EXPECT_EQ(state.state, CheckState::unknown);
  EXPECT_FALSE(state.before || state.after);
}

}  // namespace
}  // namespace gyrotherm::assurance
