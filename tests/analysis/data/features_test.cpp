// SPDX-License-Identifier: Apache-2.0
#include "analysis/data/features.hpp"

#include <gtest/gtest.h>

namespace gyrotherm::data {
namespace {

const std::vector<std::string> kOddNames = {"A", "B", "die", "die-cap"};

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
  for (const char* word : {"A", "A-B", "rate:A", "A^2", "A^3", "A-B^2", "rate:A^3", "A*rate:A", "A*A-B", "A^2*rate:B",
                           "A*B*A-B", "die-cap", "die-cap-A", "A-die-cap", "rate:die-cap", "die-cap^2*die-cap-A"}) {
    const auto term = parse_term(word, kOddNames);
    ASSERT_TRUE(term) << word;
    EXPECT_EQ(to_string(*term), word);
  }
  EXPECT_EQ(*parse_term("die-cap", kOddNames), temperature_term("die-cap")) << "a whole name comes first";
  EXPECT_EQ(*parse_term("die-cap-A", kOddNames), (gradient_term("die-cap", "A")));
}

TEST(Term, OfAnUnknownThermometerNamesTheNearest) {
  const auto term = parse_term("A-dye", kOddNames);
  ASSERT_FALSE(term);
  EXPECT_EQ(term.error().kind, FaultKind::usage);
  EXPECT_NE(term.error().what.find("did you mean \"die\"?"), std::string::npos) << term.error().what;
  for (const char* word : {"", "-", "rate:", "^2", "A-A", "rate:A-B"})
    EXPECT_FALSE(parse_term(word, kOddNames)) << word;
}

TEST(Term, IsTheSameHoweverItsFactorsAreOrdered) {
  EXPECT_EQ(*parse_term("rate:A*A", kOddNames), *parse_term("A*rate:A", kOddNames));
  EXPECT_EQ(*parse_term("A*A*A", kOddNames), *parse_term("A^3", kOddNames));
  EXPECT_EQ(*parse_term("B*A^2", kOddNames), *parse_term("A*B*A", kOddNames));
  EXPECT_EQ(*parse_term("A^2", {"A", "A^2"}), temperature_term("A^2")) << "a whole name comes first";
  EXPECT_EQ(*parse_term("A*B*A", {"A", "A*B"}), temperature_term("A") * temperature_term("A*B"));
}

TEST(Term, OfTooManyFactorsOrAnUnknownPowerIsRefused) {
  for (const char* word : {"A*A*A*A", "A^3*B", "A^2*A^2"}) {
    const auto term = parse_term(word, kOddNames);
    ASSERT_FALSE(term) << word;
    EXPECT_NE(term.error().what.find("more than 3 factors"), std::string::npos) << text(term.error());
    EXPECT_EQ(term.error().where, std::string("input \"") + word + "\"");
  }
  EXPECT_NE(parse_term("A^4", kOddNames).error().what.find("^2 or ^3"), std::string::npos);
  EXPECT_NE(parse_term("A*rate:dye", kOddNames).error().what.find("did you mean \"die\"?"), std::string::npos);
  for (const char* word : {"*", "A*", "*A", "A**A", "A*A-A", "A^2^2"})
    EXPECT_FALSE(parse_term(word, kOddNames)) << word;
}

TEST(Features, AreEvaluatedPerCluster) {
  const auto values = evaluate(
      {temperature_term("B"), gradient_term("A", "B"), rate_term("B"), temperature_term("A") * temperature_term("A")},
      two_clusters());
  ASSERT_TRUE(values);
  SampleMatrix expected(2, 4);
  expected << 4, -3, 0, 1, 7, -4, 1.8, 9;
  EXPECT_EQ(*values, expected);
  EXPECT_FALSE(evaluate({gradient_term("A", "C")}, two_clusters()));
}

TEST(Features, OfProductsAreTheProductsOfTheirFactors) {
  const auto values = evaluate({*parse_term("A^3", kOddNames), *parse_term("A*rate:B", kOddNames),
                                *parse_term("B*A-B", kOddNames), *parse_term("A-B^2", kOddNames)},
                               two_clusters());
  ASSERT_TRUE(values);
  SampleMatrix expected(2, 4);
  expected << 1, 0, -12, 9, 27, 3 * 1.8, -28, 16;
  EXPECT_EQ(*values, expected);
}

TEST(Features, ThatAreTheSamePolynomialDoNotRaiseTheRank) {
  const auto rank = [](std::initializer_list<const char*> words) {
    std::vector<Term> terms;
    for (const char* word : words) terms.push_back(*parse_term(word, kOddNames));
    return rank_of(terms);
  };
  EXPECT_EQ(rank({"A*A-B", "A^2", "A*B"}), 2);
  EXPECT_EQ(rank({"A-B^2", "A^2", "A*B", "B^2"}), 3);
  EXPECT_EQ(rank({"A", "A^2", "A^3", "rate:A", "A*rate:A"}), 5);
  EXPECT_EQ(rank({"A-B^3", "A-B^2", "A-B"}), 3);
}

TEST(Features, OfEightThermometersHaveTwentyEightGradientsOfRankSeven) {
  const auto gradients = all_gradients({"A", "B", "C", "D", "E", "F", "G", "H"});
  EXPECT_EQ(gradients.size(), 28u);
  EXPECT_EQ(rank_of(gradients), 7);
  EXPECT_EQ(rank_of({}), 0);
  EXPECT_EQ(rank_of({temperature_term("A"), temperature_term("A") * temperature_term("A"), rate_term("A")}), 3);
  EXPECT_EQ(rank_of({temperature_term("A"), temperature_term("B"), gradient_term("A", "B")}), 2);
}

TEST(Scaling, MakesZeroMeanAndUnitStd) {
  const std::vector<Term> terms = {temperature_term("A"), temperature_term("B")};
  const auto values = evaluate(terms, two_clusters());
  const auto scaling = fit_scaling(*values, terms);
  ASSERT_TRUE(scaling);
  const SampleMatrix scaled = apply(*scaling, *values);
  EXPECT_NEAR(scaled.colwise().mean().norm(), 0, 1e-15);
  EXPECT_NEAR(scaled.col(0).squaredNorm(), 1, 1e-15);
}

TEST(Scaling, NamesTheInputThatDoesNotVary) {
  SampleMatrix values = SampleMatrix::Constant(3, 1, 20.1);
  const auto scaling = fit_scaling(values, {gradient_term("A", "B")});
  ASSERT_FALSE(scaling);
  EXPECT_EQ(scaling.error().where, "input \"A-B\"");
}

}  // namespace
}  // namespace gyrotherm::data
