#include "analysis/correlation.hpp"

#include <gtest/gtest.h>

#include "freeimu.hpp"
#include "synthetic_run.hpp"

namespace gyrotherm {
namespace {

const std::vector<std::string> kNames = {"A", "B", "C", "D", "E", "F", "G", "H"};

/// As printed in Table 3 of the paper.
Eigen::MatrixXd table_3() {
  Eigen::MatrixXd r(8, 8);
  r << 0, .939, .938, .913, .938, .912, .935, .942,  //
      .939, 0, .781, .888, .898, .902, .913, .739,   //
      .938, .781, 0, .876, .633, .242, .824, .916,   //
      .913, .888, .876, 0, .924, .831, .904, .647,   //
      .938, .898, .633, .924, 0, .733, .412, .231,   //
      .912, .902, .242, .831, .733, 0, .647, .750,   //
      .935, .913, .824, .904, .412, .647, 0, .932,   //
      .942, .739, .916, .647, .231, .750, .932, 0;
  return r;
}

std::vector<std::string> texts(const std::vector<Term>& terms) {
  std::vector<std::string> words;
  for (const Term& term : terms) words.push_back(text(term));
  return words;
}

TEST(Selection, OfThePapersTableIsItsThirteenPairsOfRankSeven) {
  const Selection selection = select_pairs(kNames, table_3());
  EXPECT_EQ(texts(selection.terms), (std::vector<std::string>{"A-B", "A-C", "A-D", "A-E", "A-F", "A-G", "A-H", "B-F",
                                                              "B-G", "C-H", "D-E", "D-G", "G-H"}));
  EXPECT_EQ(selection.rank, 7);
  EXPECT_FALSE(selection.fallback);
}

TEST(Selection, FallsBackToTheDifferencesWithTheFirstAndSaysSo) {
  const Selection selection = select_pairs(kNames, table_3(), 0.95);
  EXPECT_EQ(texts(selection.terms), (std::vector<std::string>{"A-B", "A-C", "A-D", "A-E", "A-F", "A-G", "A-H"}));
  EXPECT_TRUE(selection.fallback);
  EXPECT_NE(selection.statement.find("0 of 28"), std::string::npos) << selection.statement;
  EXPECT_NE(selection.statement.find("too few"), std::string::npos);
}

TEST(Selection, FallsBackWhereTooFewDimensionsRemain) {
  EXPECT_FALSE(select_pairs(kNames, table_3(), 0.941).fallback) << "A-H alone passes";
  EXPECT_TRUE(select_pairs(kNames, table_3(), 0.941, 2).fallback);
}

TEST(Selection, DoesNotMindTheSign) {
  const Selection selection = select_pairs({"A", "B"}, (Eigen::MatrixXd(2, 2) << 0, -0.95, 0.95, 0).finished());
  EXPECT_FALSE(selection.fallback);
}

TEST(Correlation, IsSignedAntisymmetricAndOneForAGradientThatIsTheBias) {
  auto clusters = make_clusters(make_synthetic_run({}));
  ASSERT_TRUE(clusters);
  clusters->bias_deg_per_h = 3 * (clusters->temperature_c.col(1) - clusters->temperature_c.col(0));
  const Correlation r = correlate(*clusters, kNames);
  EXPECT_NEAR(r.gradient(0, 1), -1, 1e-12);
  EXPECT_EQ(r.gradient, -r.gradient.transpose());
  EXPECT_LE(r.gradient.cwiseAbs().maxCoeff(), 1);
}

TEST(Correlation, OfARealRecordIsTheReferences) {
  const double with_die[] = {-0.9148, 0.9996, -0.9534}, with_difference[] = {0.9456, -0.8873, 0.8487};
  for (const FreeImuAxis axis : {FreeImuAxis::x, FreeImuAxis::y, FreeImuAxis::z}) {
    const auto dataset = load_freeimu(axis);
    if (!dataset) GTEST_SKIP() << "GYROTHERM_SHARED is not set";
    const Correlation r = correlate(*make_clusters(*dataset), dataset->gradients);
    EXPECT_NEAR(r.temperature(0), with_die[static_cast<int>(axis)], 5e-5);
    EXPECT_NEAR(r.gradient(0, 1), with_difference[static_cast<int>(axis)], 5e-5);
  }
}

}  // namespace
}  // namespace gyrotherm
