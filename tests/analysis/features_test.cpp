#include "analysis/features.hpp"

#include <gtest/gtest.h>

namespace gyrotherm {
namespace {

const std::vector<std::string> kNames = {"A", "B", "die", "die-cap"};

Clusters two_clusters() {
  Clusters clusters;
  clusters.thermometers = {"A", "B"};
  clusters.temperature_c.resize(2, 2);
  clusters.temperature_c << 1, 4, 3, 7;
  clusters.rate_c_per_min.resize(2, 2);
  clusters.rate_c_per_min << 0, 0, 1.2, 1.8;
  return clusters;
}

TEST(Term, IsReadAsItIsWritten) {
  for (const char* word : {"A", "A-B", "rate:A", "A^2", "die-cap", "die-cap-A", "A-die-cap", "rate:die-cap"}) {
    const auto term = parse_term(word, kNames);
    ASSERT_TRUE(term) << word;
    EXPECT_EQ(text(*term), word);
  }
  EXPECT_EQ(parse_term("die-cap", kNames)->kind, TermKind::temperature) << "a whole name comes first";
  EXPECT_EQ(*parse_term("die-cap-A", kNames), (Term{TermKind::gradient, "die-cap", "A"}));
}

TEST(Term, OfAnUnknownThermometerNamesTheNearest) {
  const auto term = parse_term("A-dye", kNames);
  ASSERT_FALSE(term);
  EXPECT_EQ(term.error().kind, FaultKind::usage);
  EXPECT_NE(term.error().what.find("did you mean \"die\"?"), std::string::npos) << term.error().what;
  for (const char* word : {"", "-", "rate:", "^2", "A-A", "rate:A-B"}) EXPECT_FALSE(parse_term(word, kNames)) << word;
}

TEST(Features, AreEvaluatedPerCluster) {
  const auto values = evaluate({{TermKind::temperature, "B", ""},
                                {TermKind::gradient, "A", "B"},
                                {TermKind::rate, "B", ""},
                                {TermKind::squared, "A", ""}},
                               two_clusters());
  ASSERT_TRUE(values);
  SampleMatrix expected(2, 4);
  expected << 4, -3, 0, 1, 7, -4, 1.8, 9;
  EXPECT_EQ(*values, expected);
  EXPECT_FALSE(evaluate({{TermKind::gradient, "A", "C"}}, two_clusters()));
}

TEST(Features, OfEightThermometersHaveTwentyEightGradientsOfRankSeven) {
  const auto gradients = all_gradients({"A", "B", "C", "D", "E", "F", "G", "H"});
  EXPECT_EQ(gradients.size(), 28u);
  EXPECT_EQ(rank_of(gradients), 7);
  EXPECT_EQ(rank_of({}), 0);
  EXPECT_EQ(rank_of({{TermKind::temperature, "A", ""}, {TermKind::squared, "A", ""}, {TermKind::rate, "A", ""}}), 3);
  EXPECT_EQ(
      rank_of({{TermKind::temperature, "A", ""}, {TermKind::temperature, "B", ""}, {TermKind::gradient, "A", "B"}}), 2);
}

TEST(Scaling, MakesZeroMeanAndUnitStd) {
  const std::vector<Term> terms = {{TermKind::temperature, "A", ""}, {TermKind::temperature, "B", ""}};
  const auto values = evaluate(terms, two_clusters());
  const auto scaling = fit_scaling(*values, terms);
  ASSERT_TRUE(scaling);
  const SampleMatrix scaled = apply(*scaling, *values);
  EXPECT_NEAR(scaled.colwise().mean().norm(), 0, 1e-15);
  EXPECT_NEAR(scaled.col(0).squaredNorm(), 1, 1e-15);
}

TEST(Scaling, NamesTheInputThatDoesNotVary) {
  SampleMatrix values = SampleMatrix::Constant(3, 1, 20.1);
  const auto scaling = fit_scaling(values, {{TermKind::gradient, "A", "B"}});
  ASSERT_FALSE(scaling);
  EXPECT_EQ(scaling.error().where, "input \"A-B\"");
}

}  // namespace
}  // namespace gyrotherm
