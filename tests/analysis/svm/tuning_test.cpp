// SPDX-License-Identifier: Apache-2.0
#include "analysis/svm/tuning.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "analysis/svm/kernel.hpp"

namespace gyrotherm::svm {
namespace {

constexpr double kNoLimit = std::numeric_limits<double>::infinity();

/// Returns four folds of a smooth function of three inputs. `noise` is the standard deviation of the added noise.
std::vector<TuningFold> four_folds(Eigen::Index rows, double noise) {
  std::mt19937_64 generator(4);
  std::normal_distribution<double> normal;
  const SampleMatrix x = SampleMatrix::NullaryExpr(rows, 3, [&] { return normal(generator); });
  Eigen::VectorXd y(rows);
  for (Eigen::Index i = 0; i < rows; ++i)
    y[i] = std::sin(x(i, 0)) + 0.3 * x(i, 1) * x(i, 2) + noise * normal(generator);
  std::vector<TuningFold> folds;
  const Eigen::Index part = rows / 4;
  for (Eigen::Index f = 0; f < 4; ++f) {
    TuningFold fold;
    const Eigen::Index after = rows - (f + 1) * part;
    fold.train_x.resize(rows - part, 3);
    fold.train_x << x.topRows(f * part), x.bottomRows(after);
    fold.train_y.resize(rows - part);
    fold.train_y << y.head(f * part), y.tail(after);
    fold.test_x = x.middleRows(f * part, part);
    fold.test_y = y.segment(f * part, part);
    fold.target_scale = 0.5;
    folds.push_back(std::move(fold));
  }
  return folds;
}

/// Adds the row numbers to the folds. Each fold then starts from the solution of the first one.
std::vector<TuningFold> with_rows(std::vector<TuningFold> folds) {
  Eigen::Index first = 0;
  for (TuningFold& fold : folds) {
    const Eigen::Index part = fold.test_y.size();
    for (Eigen::Index i = 0; i < fold.train_y.size(); ++i) fold.train_rows.push_back(i < first ? i : i + part);
    first += part;
  }
  return folds;
}

TuningOptions quick() {
  TuningOptions options;
  options.swarm.particles = 6;
  options.swarm.iterations = 5;
  return options;
}

TEST(CrossValidation, EqualsMeanSquaredErrorOverHeldOutRows) {
  const std::vector<TuningFold> folds = four_folds(60, 0.1);
  const SvrParameters parameters{.C = 10, .sigma = 1.5, .epsilon = 0.05};
  double sum = 0;
  for (const TuningFold& fold : folds) {
    const auto model = solve_svr(fold.train_x, fold.train_y, parameters);
    ASSERT_TRUE(model);
    const Eigen::VectorXd f = gaussian_kernel(fold.test_x, fold.train_x, parameters.sigma) * model->beta;
    sum += 0.25 * (f - fold.test_y + Eigen::VectorXd::Constant(f.size(), model->b)).squaredNorm();
  }
  const auto error = cross_validation_error(folds, parameters, {}, kNoLimit);
  ASSERT_TRUE(error);
  EXPECT_NEAR(*error, sum / 60, 1e-12);
}

TEST(CrossValidation, StopsAfterFoldThatExceedsLimit) {
  const std::vector<TuningFold> folds = four_folds(60, 0.1);
  const SvrParameters parameters{.C = 10, .sigma = 1.5, .epsilon = 0.05};
  const double whole = *cross_validation_error(folds, parameters, {}, kNoLimit);
  const double partial = *cross_validation_error(folds, parameters, {}, 0.1 * whole);
  EXPECT_GT(partial, 0.1 * whole);
  EXPECT_LT(partial, whole);
  EXPECT_EQ(*cross_validation_error(folds, parameters, {}, whole), whole);
}

TEST(CrossValidation, NamesInvalidFold) {
  EXPECT_EQ(cross_validation_error({}, {1, 1, 0.1}, {}, kNoLimit).error().what, "no fold");
  std::vector<TuningFold> folds = four_folds(40, 0.1);
  folds[2].test_x.resize(0, 3);
  EXPECT_EQ(cross_validation_error(folds, {1, 1, 0.1}, {}, kNoLimit).error().what,
            "fold 2 has 30 training and 0 held-out rows, must have both");
  folds = four_folds(40, 0.1);
  folds[1].test_y[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(cross_validation_error(folds, {1, 1, 0.1}, {}, kNoLimit).error().what,
            "fold 1 has a value that is not finite");
}

TEST(Tuning, ReportsErrorOfBestPosition) {
  const std::vector<TuningFold> folds = four_folds(80, 0.1);
  const auto summary = tune_svr(folds, quick());
  ASSERT_TRUE(summary) << text(summary.error());
  EXPECT_EQ(summary->uncertified, 0);
  EXPECT_EQ(summary->cross_validation_mse, *cross_validation_error(folds, summary->best, {}, kNoLimit));
  EXPECT_LT(summary->cross_validation_mse, 0.25 * 0.15);
}

TEST(Tuning, DoesNotDependOnThreadCount) {
  const std::vector<TuningFold> folds = four_folds(80, 0.1);
  TuningOptions options = quick();
  options.swarm.threads = 1;
  const auto one = tune_svr(folds, options);
  options.swarm.threads = 2;
  const auto two = tune_svr(folds, options);
  ASSERT_TRUE(one && two);
  EXPECT_EQ(one->swarm.best, two->swarm.best);
  EXPECT_EQ(one->swarm.history, two->swarm.history);
}

TEST(Tuning, DoesNotDependOnThreadCountWithWarmStarts) {
  const std::vector<TuningFold> folds = with_rows(four_folds(80, 0.1));
  TuningOptions options = quick();
  options.swarm.threads = 1;
  const auto one = tune_svr(folds, options);
  options.swarm.threads = 2;
  const auto two = tune_svr(folds, options);
  options.choice = ChoiceRule::one_standard_error;
  const auto judged = tune_svr(folds, options);
  ASSERT_TRUE(one && two && judged);
  EXPECT_EQ(one->swarm.best, two->swarm.best);
  EXPECT_EQ(one->swarm.history, two->swarm.history);
  EXPECT_EQ(one->swarm.history, judged->swarm.history);
  EXPECT_EQ(one->cross_validation_mse, *cross_validation_error(folds, one->best, {}, kNoLimit));
}

/// The first fold exceeds the limit of most positions, and trainings of the last, larger fold often fail. Only the
/// one-standard-error rule runs both.
TEST(Tuning, HasSamePathForEachRuleWhenTrainingsFail) {
  std::vector<TuningFold> folds = with_rows(four_folds(40, 0.1));
  folds.front().target_scale = 3;
  folds.back() = four_folds(200, 0.1).back();
  int failed = 0, failed_in_all = 0;
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    SCOPED_TRACE(seed);
    TuningOptions options = quick();
    options.swarm.seed = seed;
    options.swarm.iterations = 15;
    options.svr = {.relative_gap = 1e-4, .max_newton_steps = 6};
    const auto best = tune_svr(folds, options);
    options.choice = ChoiceRule::one_standard_error;
    const auto judged = tune_svr(folds, options);
    ASSERT_TRUE(best && judged);
    failed += best->uncertified;
    failed_in_all += judged->uncertified;
    EXPECT_EQ(best->swarm.history, judged->swarm.history);
    EXPECT_EQ(best->swarm.best, judged->swarm.best);
  }
  EXPECT_GT(failed, 0);
  EXPECT_GT(failed_in_all, failed);
}

TEST(CrossValidation, AgreesForWarmAndColdStarts) {
  const std::vector<TuningFold> folds = four_folds(200, 0.1);
  for (const double C : {0.5, 20.0, 900.0}) {
    SCOPED_TRACE(C);
    const SvrParameters parameters{.C = C, .sigma = 1.5, .epsilon = 0.05};
    const SvrOptions tight{.relative_gap = 1e-8};
    const double cold = *cross_validation_error(folds, parameters, tight, kNoLimit);
    EXPECT_NEAR(*cross_validation_error(with_rows(folds), parameters, tight, kNoLimit), cold, 1e-3 * cold);
  }
}

TEST(Tuning, SearchesTwoDimensionsAtFixedEpsilon) {
  TuningOptions options = quick();
  options.fixed_epsilon = 0.05;
  const auto summary = tune_svr(four_folds(60, 0.1), options);
  ASSERT_TRUE(summary);
  EXPECT_EQ(summary->swarm.best.size(), 2u);
  EXPECT_EQ(summary->best.epsilon, 0.05);
}

TEST(Tuning, RejectsFixedEpsilonThatIsNotFinite) {
  TuningOptions options = quick();
  for (const double epsilon : {std::numeric_limits<double>::quiet_NaN(), kNoLimit, -kNoLimit}) {
    options.fixed_epsilon = epsilon;
    const auto summary = tune_svr(four_folds(40, 0.1), options);
    ASSERT_FALSE(summary) << epsilon;
    EXPECT_EQ(summary.error().kind, FaultKind::usage);
    EXPECT_EQ(summary.error().where, "tuning");
  }
}

TEST(Tuning, WarnsWhenBestIsOnEdgeOfBox) {
  TuningOptions options = quick();
  options.log2_c.first = options.log2_c.second = -1;
  const auto summary = tune_svr(four_folds(60, 0.1), options);
  ASSERT_TRUE(summary);
  ASSERT_FALSE(summary->warnings.empty());
  EXPECT_EQ(summary->warnings.front(), "log2 C = -1 is at a bound of its search range");
}

TEST(Tuning, CountsPositionsThatMissCertificate) {
  TuningOptions options = quick();
  options.svr.max_newton_steps = 0;
  const auto summary = tune_svr(four_folds(160, 0.1), options);
  ASSERT_TRUE(summary) << text(summary.error());
  EXPECT_GT(summary->uncertified, 0);
  EXPECT_TRUE(std::isfinite(summary->cross_validation_mse));
  ASSERT_FALSE(summary->warnings.empty());
  EXPECT_NE(summary->warnings.back().find("missed the certificate"), std::string::npos);
}

TEST(Tuning, FailsWhenNoPositionIsCertified) {
  TuningOptions options = quick();
  options.svr = {.relative_gap = 1e-14, .max_newton_steps = 0};
  const auto summary = tune_svr(four_folds(60, 0.1), options);
  ASSERT_FALSE(summary);
  EXPECT_EQ(summary.error().kind, FaultKind::numeric);
}

TEST(Tuning, StopsWhenInterrupted) {
  const auto summary = tune_svr(four_folds(60, 0.1), quick(), [](std::string_view, double) { return false; });
  ASSERT_FALSE(summary);
  EXPECT_EQ(summary.error().kind, FaultKind::interrupted);
}

/// The final evaluation reports progress before each of its positions: one, or two with the one-standard-error rule.
TEST(Tuning, StopsInFinalEvaluationWhenInterrupted) {
  const std::vector<TuningFold> folds = four_folds(60, 0.1);
  for (const ChoiceRule rule : {ChoiceRule::best, ChoiceRule::one_standard_error}) {
    TuningOptions options = quick();
    options.swarm.threads = 1;
    options.choice = rule;
    int reports = 0;
    ASSERT_TRUE(tune_svr(folds, options, [&](std::string_view, double) { return ++reports > 0; }));
    for (int stop = reports; stop > reports - (rule == ChoiceRule::best ? 1 : 2); --stop) {
      int seen = 0;
      const auto summary = tune_svr(folds, options, [&](std::string_view, double done) {
        if (seen + 1 == stop) EXPECT_EQ(done, 1);
        return ++seen < stop;
      });
      ASSERT_FALSE(summary);
      EXPECT_EQ(summary.error().kind, FaultKind::interrupted);
      EXPECT_EQ(summary.error().where, "tuning");
      EXPECT_EQ(seen, stop);
    }
  }
}

TEST(Tuning, RejectsMissingFolds) {
  const auto summary = tune_svr({}, {});
  ASSERT_FALSE(summary);
  EXPECT_EQ(summary.error().kind, FaultKind::usage);
}

}  // namespace
}  // namespace gyrotherm::svm
