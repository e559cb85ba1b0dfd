// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/selection.hpp"

#include <gtest/gtest.h>
#include <oneapi/tbb/task_arena.h>

#include <Eigen/QR>
#include <algorithm>
#include <random>

#include "analysis/data/features.hpp"
#include "tests/analysis/synthetic_run.hpp"

namespace gyrotherm::model {
namespace {

const std::vector<std::string> kEightNames = {"A", "B", "C", "D", "E", "F", "G", "H"};

/// Returns the upper triangle of Table 3 of the paper: A-B, A-C … G-H.
std::vector<double> table_3() {
  return {.939, .938, .913, .938, .912, .935, .942,  //
          .781, .888, .898, .902, .913, .739,        //
          .876, .633, .242, .824, .916,              //
          .924, .831, .904, .647,                    //
          .733, .412, .231,                          //
          .647, .750,                                //
          .932};
}

std::vector<std::string> texts(const std::vector<data::Term>& terms) {
  std::vector<std::string> words;
  for (const data::Term& term : terms) words.push_back(to_string(term));
  return words;
}

/// Selects pairs by the correlations of Table 3.
Selection select_from_table_3(double threshold, int least_rank = 1) {
  return select_by_correlation(data::all_gradients(kEightNames), table_3(), threshold, least_rank);
}

std::vector<data::Term> temperatures() {
  std::vector<data::Term> terms;
  for (const std::string& name : kEightNames) terms.push_back(data::temperature_term(name));
  return terms;
}

data::TrainingSet training_set_of(data::Clusters clusters) {
  data::FoldPlan folds = *data::plan_folds({clusters});
  return {std::move(clusters), std::move(folds)};
}

/// Returns independent temperatures, and a bias that depends on one gradient and on the square of another, plus white
/// noise.
data::TrainingSet bias_from_two_gradients(std::uint64_t seed) {
  data::Clusters clusters = data::wandering(*data::make_clusters(data::make_synthetic_run({.hold_s = 1000})), seed);
  const data::SampleMatrix x = *evaluate({data::gradient_term("A", "D"), data::gradient_term("C", "F")}, clusters);
  // A random stream that is independent of the temperatures.
  std::mt19937_64 random(1000 + seed);
  std::normal_distribution<double> noise(0, 1e-3);
  clusters.bias_deg_per_h = 2e-3 * x.col(0) + 1e-4 * x.col(1).cwiseAbs2();
  for (double& bias : clusters.bias_deg_per_h) bias += noise(random);
  return training_set_of(std::move(clusters));
}

TEST(Selection, ReproducesThirteenPairsOfPaper) {
  const Selection selection = select_from_table_3(0.90);
  EXPECT_EQ(texts(selection.terms), (std::vector<std::string>{"A-B", "A-C", "A-D", "A-E", "A-F", "A-G", "A-H", "B-F",
                                                              "B-G", "C-H", "D-E", "D-G", "G-H"}));
  EXPECT_EQ(selection.rank, 7);
  EXPECT_FALSE(selection.fallback);
}

TEST(Selection, FallsBackToDifferencesWithFirstThermometer) {
  const Selection selection = select_from_table_3(0.95);
  EXPECT_EQ(texts(selection.terms), (std::vector<std::string>{"A-B", "A-C", "A-D", "A-E", "A-F", "A-G", "A-H"}));
  EXPECT_TRUE(selection.fallback);
  EXPECT_NE(selection.statement.find("0 of 28"), std::string::npos) << selection.statement;
  EXPECT_NE(selection.statement.find("too few"), std::string::npos);
}

TEST(Selection, FallsBackIfTooFewDimensionsRemain) {
  EXPECT_FALSE(select_from_table_3(0.941).fallback) << "only A-H exceeds the limit";
  EXPECT_TRUE(select_from_table_3(0.941, 2).fallback);
}

TEST(Selection, IgnoresSignOfCorrelation) {
  EXPECT_FALSE(select_by_correlation({data::gradient_term("A", "B")}, {-0.95}, 0.9, 1).fallback);
}

TEST(Selection, SelectsAnyKindOfInputByCorrelation) {
  data::Clusters clusters = *data::make_clusters(data::make_synthetic_run({}));
  clusters.bias_deg_per_h = 3 * clusters.temperature_c.col(2);
  const auto selection = select_inputs({.threshold = 0.999999}, {}, temperatures(), training_set_of(clusters));
  ASSERT_TRUE(selection);
  EXPECT_TRUE(selection->fallback) << "a single input is not sufficient: " << selection->statement;
  EXPECT_FALSE(select_inputs({}, {}, {}, training_set_of(clusters)));
}

TEST(ForwardSelection, FindsInputsOfBias) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const auto selection = select_forward({}, data::all_gradients(kEightNames), bias_from_two_gradients(seed), 12);
    ASSERT_TRUE(selection);
    std::vector<std::string> taken = texts(selection->terms);
    std::ranges::sort(taken);
    EXPECT_EQ(taken, (std::vector<std::string>{"A-D", "C-F"})) << selection->statement;
  }
}

TEST(ForwardSelection, AddsNothingToSufficientInputs) {
  const auto selection = select_forward({data::gradient_term("A", "D"), data::gradient_term("C", "F")}, temperatures(),
                                        bias_from_two_gradients(3), 12);
  ASSERT_TRUE(selection);
  EXPECT_TRUE(selection->terms.empty()) << selection->statement;
}

TEST(ForwardSelection, LimitsNumberOfInputs) {
  const auto selection = select_forward({}, data::all_gradients(kEightNames), bias_from_two_gradients(1), 1);
  EXPECT_EQ(selection->terms.size(), 1u);
}

TEST(ForwardSelection, DoesNotDependOnNumberOfThreads) {
  const data::TrainingSet training_set = bias_from_two_gradients(4);
  const auto select = [&] { return *select_forward({}, data::all_gradients(kEightNames), training_set, 4); };
  const Selection all = select();
  const Selection one = oneapi::tbb::task_arena(1).execute(select);
  EXPECT_EQ(all.terms, one.terms);
  EXPECT_EQ(all.statement, one.statement);
}

TEST(Redundancy, KeepsSevenOfTwentyEightGradients) {
  const data::Clusters clusters = *data::make_clusters(data::make_synthetic_run({}));
  const auto gradients = select_independent({}, data::all_gradients(kEightNames), clusters, 1e-6);
  ASSERT_TRUE(gradients);
  EXPECT_EQ(gradients->terms.size(), 7u) << gradients->statement;
  EXPECT_EQ(gradients->rank, 7);
  const auto beside = select_independent({data::temperature_term("A")}, temperatures(), clusters, 1e-6);
  EXPECT_EQ(beside->terms.size(), 7u);
  EXPECT_FALSE(std::ranges::count(beside->terms, data::temperature_term("A"))) << "the term is selected in any case";
}

TEST(Redundancy, DropsOnlyDependentInputs) {
  const data::Clusters clusters = *data::make_clusters(data::make_synthetic_run({}));
  for (const double tolerance : {1e-6, 1e-3, 1e-2, 0.1}) {
    const auto kept = select_independent({}, data::all_gradients(kEightNames), clusters, tolerance);
    ASSERT_TRUE(kept);
    const data::SampleMatrix all = *evaluate(data::all_gradients(kEightNames), clusters),
                             some = *evaluate(kept->terms, clusters);
    Eigen::MatrixXd design(some.rows(), some.cols() + 1);
    design << some, Eigen::VectorXd::Ones(some.rows());
    const Eigen::MatrixXd centred = all.rowwise() - all.colwise().mean();
    const Eigen::MatrixXd left = all - design * design.colPivHouseholderQr().solve(Eigen::MatrixXd(all));
    const double worst = (left.colwise().norm().array() / centred.colwise().norm().array()).maxCoeff();
    EXPECT_LE(worst, tolerance) << kept->statement;
  }
}

TEST(Selection, ParsesRule) {
  EXPECT_EQ(parse_selection("correlation")->threshold, 0.90);
  EXPECT_EQ(parse_selection("correlation:0.85")->threshold, 0.85);
  EXPECT_EQ(parse_selection("forward:6")->most, 6);
  EXPECT_EQ(parse_selection("redundancy:0.01")->tolerance, 0.01);
  EXPECT_EQ(parse_selection("redundancy")->kind, SelectionKind::redundancy);
  for (const char* word : {"", "backward", "correlation:2", "correlation:", "forward:0", "forward:1.5", "redundancy:0",
                           "redundancy:nan", "correlation:nan"}) {
    EXPECT_FALSE(parse_selection(word)) << word;
  }
}

}  // namespace
}  // namespace gyrotherm::model
