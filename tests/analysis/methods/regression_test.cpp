// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "analysis/methods/held_out.hpp"
#include "analysis/methods/linear.hpp"
#include "tests/analysis/random_samples.hpp"

namespace gyrotherm::methods {
namespace {

const LinearModel& linear_model(const Fit& fit) { return std::get<LinearModel>(fit.function); }

/// Returns the five terms of a polynomial in A and its rate, from raw temperatures between −1 and 1.
data::Samples polynomial_samples(Eigen::Index rows, std::uint64_t seed) {
  const data::Term t = data::temperature_term("A"), rate = data::rate_term("A");
  data::Samples samples{data::SampleMatrix(rows, 5), {}, {t, t * t, t * t * t, rate, t * rate}};
  const Eigen::ArrayXd temperature = data::normal_vector(rows, seed).array().tanh(),
                       change = data::normal_vector(rows, seed + 1);
  samples.x << temperature, temperature.square(), temperature.cube(), change, temperature * change;
  return samples;
}

TEST(Polynomial, IsRecoveredWithOrder) {
  for (int order = 1; order <= 3; ++order) {
    for (const bool rates : {false, true}) {
      SCOPED_TRACE(testing::Message() << "order " << order << (rates ? " with rates" : ""));
      data::Samples samples = polynomial_samples(120, 7);
      Eigen::VectorXd weights = Eigen::VectorXd::Zero(5);
      weights.head(order) = Eigen::Vector3d{0.5, -0.25, 0.75}.head(order);
      if (rates) weights.tail(2) << 0.3, -0.4;
      samples.y = ((samples.x * weights).array() + 0.125).matrix() + 1e-3 * data::normal_vector(120, 8);
      const auto choice = choose_polynomial(folds_of(samples, 4), {}, {});
      ASSERT_TRUE(choice);
      EXPECT_GE(parameter_value(choice->parameters, "order"), order);
      EXPECT_GE(parameter_value(choice->parameters, "rate terms"), rates ? 1 : 0);
      const auto fit = fit_polynomial(samples.set(), {{"order", double(order)}, {"rate terms", rates ? 1.0 : 0.0}}, {});
      ASSERT_TRUE(fit);
      EXPECT_LT((linear_model(*fit).weights - weights).cwiseAbs().maxCoeff(), 2e-3);
      EXPECT_EQ(fit->effective_parameters, 1 + order + (rates ? 2 : 0));
      EXPECT_EQ(count_stored_numbers(fit->function), 1 + order + (rates ? 2 : 0)) << "omitted terms have a weight of 0";
    }
  }
}

TEST(Polynomial, IsLimitedToOrderOfInputs) {
  const data::Samples samples = data::bent_samples(60, 2, 0.1, 1);
  const auto choice = choose_polynomial(folds_of(samples, 3), {}, {});
  ASSERT_TRUE(choice);
  EXPECT_EQ(parameter_value(choice->parameters, "order"), 1);
  EXPECT_EQ(parameter_value(choice->parameters, "rate terms"), 0);
}

/// Computes the partial F of an added input from two ordinary regressions.
double partial_f(const data::Samples& samples, std::vector<Eigen::Index> columns, Eigen::Index input) {
  const auto rss = [&](const std::vector<Eigen::Index>& taken) {
    Eigen::MatrixXd design(samples.x.rows(), static_cast<Eigen::Index>(taken.size()) + 1);
    design << samples.x(Eigen::all, taken), Eigen::VectorXd::Ones(samples.x.rows());
    return (samples.y - design * design.householderQr().solve(samples.y)).squaredNorm();
  };
  const double before = rss(columns);
  columns.push_back(input);
  const double after = rss(columns),
               freedom = static_cast<double>(samples.x.rows()) - static_cast<double>(columns.size()) - 1;
  return (before - after) / (after / freedom);
}

std::vector<Eigen::Index> taken_inputs(const LinearModel& model) {
  std::vector<Eigen::Index> taken;
  for (Eigen::Index j = 0; j < model.weights.size(); ++j) {
    if (model.weights(j) != 0) taken.push_back(j);
  }
  return taken;
}

TEST(Stepwise, EndsWhenNoInputEntersOrLeaves) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    data::Samples samples{data::normal_matrix(50, 7, seed), {}, data::letters(7)};
    samples.x.col(3) = samples.x.col(0) + samples.x.col(1) + 0.3 * data::normal_vector(50, seed + 100);
    samples.y = samples.x.col(0) + samples.x.col(1) + 0.2 * samples.x.col(5) + data::normal_vector(50, seed + 200);
    const auto fit = fit_stepwise(samples.set(), {}, {});
    ASSERT_TRUE(fit);
    const auto taken = taken_inputs(linear_model(*fit));
    for (Eigen::Index input = 0; input < 7; ++input) {
      if (std::ranges::count(taken, input) > 0) {
        auto others = taken;
        std::erase(others, input);
        EXPECT_GE(partial_f(samples, others, input), kFToRemove) << input;
      } else {
        EXPECT_LE(partial_f(samples, taken, input), kFToEnter) << input;
      }
    }
    EXPECT_EQ(fit->effective_parameters, static_cast<double>(taken.size() + 1));
    const Eigen::VectorXd residual = samples.y - evaluate_function(fit->function, samples.x);
    EXPECT_NEAR(residual.mean(), 0, 1e-12);
    for (const Eigen::Index input : taken) EXPECT_NEAR(residual.dot(samples.x.col(input)), 0, 1e-10);
  }
}

/// D is nearly the sum of A and B. It enters first and becomes redundant when both have entered.
TEST(Stepwise, DropsInputReplacedByLaterOnes) {
  data::Samples samples{data::normal_matrix(200, 4, 3), {}, data::letters(4)};
  samples.x.col(3) = samples.x.col(0) + samples.x.col(1) + 0.5 * data::normal_vector(200, 4);
  samples.y = samples.x.col(0) + samples.x.col(1) + 0.01 * data::normal_vector(200, 5);
  const auto fit = fit_stepwise(samples.set(), {}, {});
  ASSERT_TRUE(fit);
  EXPECT_EQ(linear_model(*fit).weights(3), 0);
  EXPECT_NEAR(linear_model(*fit).weights(0), 1, 0.01);
}

TEST(Stepwise, SelectsNoInputForUncorrelatedTarget) {
  data::Samples samples{data::normal_matrix(40, 2, 1), {}, data::letters(2)};
  const Eigen::MatrixXd basis = (Eigen::MatrixXd(40, 3) << samples.x, Eigen::VectorXd::Ones(40)).finished();
  const Eigen::VectorXd y = data::normal_vector(40, 2);
  samples.y = y - basis * basis.householderQr().solve(y) + Eigen::VectorXd::Constant(40, 0.5);
  const auto fit = fit_stepwise(samples.set(), {}, {});
  ASSERT_TRUE(fit);
  EXPECT_EQ(count_stored_numbers(fit->function), 1);
  EXPECT_NEAR(linear_model(*fit).b, 0.5, 1e-12);
}

TEST(Stepwise, SkipsCopiedInput) {
  data::Samples samples{data::normal_matrix(80, 3, 6), {}, data::letters(3)};
  samples.x.col(2) = samples.x.col(0);
  samples.y = samples.x.col(0) + 0.1 * data::normal_vector(80, 7);
  const auto fit = fit_stepwise(samples.set(), {}, {});
  ASSERT_TRUE(fit);
  const auto taken = taken_inputs(linear_model(*fit));
  ASSERT_EQ(taken.size(), 1u);
  EXPECT_NE(taken.front(), 1);
}

TEST(Ridge, SatisfiesNormalEquations) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const data::Samples samples =
        // Includes cases with fewer samples than inputs.
        data::bent_samples(seed % 2 == 0 ? 60 : 4, 6, 0.3, seed);
    for (const double lambda : {1e-6, 1e-2, 1e2}) {
      const auto fit = fit_ridge(samples.set(), {{"lambda", lambda}}, {});
      ASSERT_TRUE(fit);
      const Eigen::VectorXd residual = samples.y - evaluate_function(fit->function, samples.x);
      const Eigen::VectorXd gradient = samples.x.transpose() * residual -
                                       lambda * static_cast<double>(samples.y.size()) * linear_model(*fit).weights;
      EXPECT_LT(gradient.cwiseAbs().maxCoeff(), 1e-10);
      EXPECT_NEAR(residual.mean(), 0, 1e-12);
    }
  }
}

TEST(Ridge, CountsTraceOfHatMatrix) {
  const data::Samples samples = data::bent_samples(30, 4, 0.3, 1);
  const double lambda = 0.05;
  double trace = 0;
  for (Eigen::Index i = 0; i < 30; ++i) {
    const Eigen::VectorXd unit = Eigen::VectorXd::Unit(30, i);
    const auto fit = fit_ridge({samples.x, unit, samples.terms}, {{"lambda", lambda}}, {});
    trace += evaluate_function(fit->function, samples.x)(i);
  }
  EXPECT_NEAR(RidgePath(samples.x, samples.y).effective_parameters(lambda), trace, 1e-10);
}

TEST(Ridge, EqualsLeastSquaresWithoutPenalty) {
  const data::Samples samples = data::bent_samples(60, 5, 0.3, 2);
  const auto ridge = fit_ridge(samples.set(), {{"lambda", 1e-14}}, {}), plain = fit_linear(samples.set(), {}, {});
  EXPECT_LT((linear_model(*ridge).weights - linear_model(*plain).weights).cwiseAbs().maxCoeff(), 1e-10);
  EXPECT_NEAR(ridge->effective_parameters, 6, 1e-10);
}

TEST(Ridge, ShrinksWeightsThatDoNotHelpOnHeldOutFolds) {
  data::Samples samples = data::bent_samples(24, 15, 0, 3);
  samples.y = 0.2 * samples.x.col(0) + data::normal_vector(24, 4);
  const auto choice = choose_ridge(folds_of(samples, 4), {}, {});
  ASSERT_TRUE(choice);
  EXPECT_GE(parameter_value(choice->parameters, "lambda"), 0.1);
  samples.y = samples.x * Eigen::VectorXd::Ones(15);
  const auto exact = choose_ridge(folds_of(samples, 4), {}, {});
  EXPECT_EQ(parameter_value(exact->parameters, "lambda"), 1e-8);
}

TEST(HeldOut, AveragesErrorOverHeldOutRowsOnly) {
  data::Samples samples = data::bent_samples(40, 2, 0.1, 5);
  std::vector<Fold> folds = folds_of(samples, 4);
  folds[1].target_scale = 3;
  const Trial trial = [](const Fold& fold, std::size_t) -> Result<Eigen::MatrixXd> {
    Eigen::MatrixXd predicted(fold.test_y.size(), 2);
    predicted << Eigen::VectorXd::Zero(fold.test_y.size()), fold.test_y;
    return predicted;
  };
  const auto errors = held_out_errors(folds, 1, trial, {}, {});
  ASSERT_TRUE(errors);
  double sum = 0;
  for (const Fold& fold : folds) sum += fold.target_scale * fold.target_scale * fold.test_y.squaredNorm();
  EXPECT_NEAR(errors->front()(0), sum / 40, 1e-14);
  EXPECT_EQ(errors->front()(1), 0);
  EXPECT_EQ(find_least(*errors).candidate, 1);
}

TEST(HeldOut, SkipsCandidateThatCannotBeTrained) {
  const data::Samples samples = data::bent_samples(40, 2, 0.1, 5);
  const auto folds = folds_of(samples, 4);
  const Trial second_fails = [&](const Fold& fold, std::size_t trial) -> Result<Eigen::MatrixXd> {
    if (trial == 0) return failure(FaultKind::usage, "a method", "too few");
    return Eigen::MatrixXd::Constant(fold.test_y.size(), 1, trial == 1 ? 0 : std::nan(""));
  };
  const auto errors = held_out_errors(folds, 3, second_fails, {}, {});
  ASSERT_TRUE(errors);
  EXPECT_EQ(find_least(*errors).trial, 1u);
  const Trial all_fail = [](const Fold&, std::size_t) -> Result<Eigen::MatrixXd> {
    return failure(FaultKind::usage, "a method", "too few");
  };
  EXPECT_EQ(held_out_errors(folds, 3, all_fail, {}, {}).error().where, "a method");
}

/// Calibration of a thermometer from GUM, JCGM 100:2008, H.3: corrections in °C as a function of the temperature minus
/// 20 °C.
TEST(CoefficientVariance, MatchesThermometerExampleOfGum) {
  Eigen::MatrixXd temperature(11, 1);
  temperature << 1.521, 2.012, 2.512, 3.003, 3.507, 3.999, 4.513, 5.002, 5.503, 6.010, 6.511;
  Eigen::VectorXd correction(11);
  correction << -0.171, -0.169, -0.166, -0.159, -0.164, -0.165, -0.156, -0.157, -0.159, -0.161, -0.160;
  const data::SampleMatrix x = temperature;
  const auto fit = fit_linear({x, correction, {data::temperature_term("A")}}, {}, {});
  ASSERT_TRUE(fit);
  EXPECT_NEAR(linear_model(*fit).b, -0.1712, 5e-5);
  EXPECT_NEAR(linear_model(*fit).weights(0), 0.00218, 5e-6);
  const Eigen::MatrixXd& open = fit->variance->posterior;
  EXPECT_NEAR(std::sqrt(open(1, 1)), 0.0029, 5e-5);
  EXPECT_NEAR(std::sqrt(open(0, 0)), 0.00067, 5e-6);
  EXPECT_NEAR(open(0, 1) / std::sqrt(open(0, 0) * open(1, 1)), -0.930, 5e-4);
  EXPECT_NEAR(fit->variance->noise, 0.0035, 5e-5);
  const data::SampleMatrix at_30 = data::SampleMatrix::Constant(1, 1, 10);
  EXPECT_NEAR(std::sqrt(evaluate_variance(*fit->variance, at_30)(0)), 0.0041, 5e-5);
}

TEST(CoefficientVariance, MatchesSimulatedErrorOfPlane) {
  constexpr int kDraws = 400;
  constexpr Eigen::Index kRows = 40, kInputs = 3;
  const data::SampleMatrix x = data::bent_samples(kRows, kInputs, 0, 1).x,
                           elsewhere = 4 * data::bent_samples(50, kInputs, 0, 2).x;
  const std::vector<data::Term> terms = data::bent_samples(1, kInputs, 0, 1).terms;
  constexpr double kNoise = 0.3;
  // If there is a penalty, the formula is valid for weights that are drawn from the corresponding prior.
  for (const double lambda : {0.0, 0.02}) {
    SCOPED_TRACE(lambda);
    double squares = 0, variances = 0;
    for (int draw = 1; draw <= kDraws; ++draw) {
      const double spread = lambda > 0 ? kNoise / std::sqrt(lambda * kRows) : 1;
      const Eigen::VectorXd weights = spread * data::normal_vector(kInputs, 3 * draw);
      const Eigen::VectorXd y = (x * weights).array() + 0.5 + kNoise * data::normal_vector(kRows, 3 * draw + 1).array();
      const FitInput set{x, y, terms};
      const auto fit = lambda > 0 ? fit_ridge(set, {{"lambda", lambda}}, {}) : fit_linear(set, {}, {});
      ASSERT_TRUE(fit);
      const Eigen::VectorXd truth = (elsewhere * weights).array() + 0.5;
      squares += (evaluate_function(fit->function, elsewhere) - truth).squaredNorm();
      variances += evaluate_variance(*fit->variance, elsewhere).sum();
    }
    EXPECT_NEAR(squares / variances, 1, 4 * std::sqrt(2.0 / (kDraws * kInputs)));
  }
}

TEST(CoefficientVariance, IsUnchangedByDuplicatedInput) {
  const data::Samples samples = data::bent_samples(30, 2, 0.1, 4);
  data::SampleMatrix twice(30, 3);
  twice << samples.x, samples.x.col(1);
  const data::Term term = samples.terms.front();
  const auto once = fit_linear(samples.set(), {}, {}),
             both = fit_linear({twice, samples.y, {term, term, term}}, {}, {});
  ASSERT_TRUE(once && both);
  const Eigen::VectorXd expected = evaluate_variance(*once->variance, 5 * samples.x);
  EXPECT_LT((evaluate_variance(*both->variance, 5 * twice) - expected).cwiseAbs().maxCoeff(),
            1e-3 * expected.maxCoeff());
}

TEST(CoefficientVariance, IsLargeForInputsDependentOnlyInTraining) {
  const data::Samples samples = data::bent_samples(30, 2, 0.1, 4);
  data::SampleMatrix both(30, 2);
  both << samples.x.col(0), samples.x.col(0);
  const data::Term term = samples.terms.front();
  const auto fit = fit_linear({both, samples.y, {term, term}}, {}, {});
  ASSERT_TRUE(fit);
  data::SampleMatrix apart(1, 2);
  apart << 1, -1;
  EXPECT_GT(evaluate_variance(*fit->variance, apart)(0), 1e9);
}

TEST(CoefficientVariance, IsZeroForOmittedTerms) {
  data::Samples samples = polynomial_samples(120, 9);
  samples.y = data::normal_vector(120, 10);
  const auto fit = fit_polynomial(samples.set(), {{"order", 1.0}, {"rate terms", 0.0}}, {});
  ASSERT_TRUE(fit);
  EXPECT_GT(fit->variance->posterior(0, 0), 0);
  EXPECT_TRUE(fit->variance->posterior.middleRows(1, 4).isZero(0));
  data::SampleMatrix moved = samples.x;
  moved.rightCols(4).array() += 7;
  EXPECT_EQ(evaluate_variance(*fit->variance, moved), evaluate_variance(*fit->variance, samples.x));
}

}  // namespace
}  // namespace gyrotherm::methods
