// SPDX-License-Identifier: Apache-2.0
#include "analysis/assurance/history.hpp"

#include <gtest/gtest.h>

#include <string>

#include "tests/support/check_study.hpp"

namespace gyrotherm::assurance {
namespace {

History made_history(int runs) {
  return tests::make_history({.golden = tests::GoldenGyro::single, .runs = runs}, 2, runs);
}

std::string text_of(const History& history) {
  std::string text = start_history(history.head);
  for (const CheckEntry& check : history.checks) text = append(std::move(text), check);
  for (const Explanation& explanation : history.explanations) text = append(std::move(text), explanation);
  return text;
}

TEST(CheckHistory, ReadsWhatItWrote) {
  History history = made_history(6);
  history.explanations.push_back({.run_ids = {history.checks[3].run_id},
                                  .cause = "mount",
                                  .part = "",
                                  .by = "A. Metrologist",
                                  .utc = "2026-11-25T14:03:07Z",
                                  .note = "levelled; \"again\"\nnext line",
                                  .new_level = true});
  const auto text = text_of(history);
  const auto read = parse_history(text, "h.jsonl");
  ASSERT_TRUE(read) << read.error().what;
  EXPECT_EQ(read->head, history.head);
  ASSERT_EQ(read->checks.size(), 6u);
  EXPECT_EQ(text_of(*read), text);
  EXPECT_EQ(read->explanations.front().note, history.explanations.front().note);
  EXPECT_EQ(assess(*read).charts.size(), 32u);
}

TEST(CheckHistory, RefusesChangedRemovedAndSwappedLines) {
  const auto text = text_of(made_history(5));
  auto changed = text;
  const auto at = changed.find("\"value\":0.0");
  ASSERT_NE(at, std::string::npos);
  changed[at + 11] = changed[at + 11] == '9' ? '8' : '9';
  const auto read = parse_history(changed, "h.jsonl");
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().kind, FaultKind::bad_file);
  EXPECT_EQ(read.error().where, "h.jsonl:3") << "the line after the changed one does not follow from it";
  const auto second = text.find('\n') + 1, third = text.find('\n', second) + 1;
  EXPECT_FALSE(parse_history(text.substr(0, second) + text.substr(third), "h.jsonl"));
}

TEST(CheckHistory, RefusesIncompleteLastLineAndEmptyFile) {
  const auto text = text_of(made_history(3));
  for (const std::size_t bytes : {text.size() - 1, text.size() - 30, std::size_t{10}, std::size_t{0}}) {
    const auto read = parse_history(std::string_view(text).substr(0, bytes), "h.jsonl");
    ASSERT_FALSE(read) << bytes;
    EXPECT_EQ(read.error().kind, FaultKind::bad_file);
  }
}

TEST(CheckHistory, RefusesOtherKindsOfFiles) {
  for (const std::string text : {"SQLite format 3\n", "{\n \"schema\": \"gyrotherm-model/1\"\n}\n", "slot,A\n", "\n"}) {
    const auto read = parse_history(text, "h.jsonl");
    ASSERT_FALSE(read) << text;
    EXPECT_EQ(read.error().kind, FaultKind::bad_file);
    EXPECT_TRUE(read.error().what.starts_with("is not a history of check runs")) << read.error().what;
  }
}

TEST(CheckHistory, RefusesOtherSchemaRepeatedRunAndWrongOrder) {
  History history = made_history(3);
  auto text = text_of(history);
  auto other = text;
  other.replace(other.find("standard/1"), 10, "standard/9");
  EXPECT_FALSE(parse_history(other, "h.jsonl"));
  EXPECT_FALSE(parse_history(append(text, history.checks[2]), "h.jsonl")) << "the same run twice";
  CheckEntry earlier = history.checks[0];
  earlier.run_id = std::string(32, 'f');
  EXPECT_FALSE(parse_history(append(text, earlier), "h.jsonl")) << "older than the last run";
  EXPECT_FALSE(parse_history(append(text, Explanation{.run_ids = {"unknown"}, .cause = "mount"}), "h.jsonl"));
  EXPECT_FALSE(parse_history(append(text, Explanation{.run_ids = {}, .cause = "the weather"}), "h.jsonl"));
}

TEST(CheckHistory, IsOpenUntilExplained) {
  History history = made_history(20);
  for (CheckResult& result : history.checks[19].results)
    if (result.kind == CheckKind::bias) result.value += 0.05;
  const auto open = assess(history);
  ASSERT_TRUE(open.is_open());
  EXPECT_TRUE(open.runs[19].is_open());
  EXPECT_EQ(open.charts[open.runs[19].charts.front()].of.kind, CheckKind::bias);
  history.explanations.push_back({.run_ids = {history.checks[19].run_id}, .cause = "mount"});
  EXPECT_FALSE(assess(history).is_open());
  EXPECT_TRUE(assess(history).runs[19].is_out()) << "explained, but still out of control";
}

TEST(CheckHistory, NewLevelComparesLaterRunsWithEachOther) {
  History history = made_history(30);
  for (std::size_t r = 18; r < 30; ++r)
    for (CheckResult& result : history.checks[r].results)
      if (result.kind == CheckKind::bias) result.value += 0.05;
  history.explanations.push_back({.run_ids = {history.checks[18].run_id}, .cause = "mount", .new_level = false});
  EXPECT_TRUE(assess(history).runs[19].is_open()) << "the old level still holds";
  history.explanations.back().new_level = true;
  const auto assessment = assess(history);
  for (std::size_t r = 19; r < 30; ++r) EXPECT_FALSE(assessment.runs[r].is_open()) << r;
}

TEST(CheckHistory, MissingResultOfOneRunIsNotJudged) {
  History history = made_history(12);
  history.checks[9].results.erase(history.checks[9].results.begin());
  const auto assessment = assess(history);
  EXPECT_FALSE(assessment.charts.front().points[9].is_judged);
  EXPECT_TRUE(assessment.charts.front().points[10].is_judged);
  EXPECT_TRUE(assessment.charts[1].points[9].is_judged);
}

}  // namespace
}  // namespace gyrotherm::assurance
