// SPDX-License-Identifier: Apache-2.0
#include "analysis/methods/svr.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "analysis/methods/ridge_u.hpp"
#include "tests/analysis/random_samples.hpp"

namespace gyrotherm::methods {
namespace {

data::Clusters clusters_with(const Eigen::VectorXd& start_s, const Eigen::VectorXd& bias) {
  data::Clusters clusters;
  clusters.start_s = start_s;
  clusters.bias_deg_per_h = bias;
  return clusters;
}

TEST(ForwardPrediction, KeepsConstantAndFirstValues) {
  EXPECT_LT((forward_prediction(Eigen::VectorXd::Constant(50, 3.5)).array() - 3.5).abs().maxCoeff(), 1e-12);
  const Eigen::VectorXd values = data::normal_vector(50, 1);
  EXPECT_EQ(forward_prediction(values, {.order = 6, .step = 0.1}).head(6), values.head(6));
}

TEST(ForwardPrediction, MatchesFormula) {
  const Eigen::VectorXd values = (Eigen::VectorXd(4) << 1, 2, 4, 3).finished();
  const Eigen::VectorXd predicted = forward_prediction(values, {.order = 2, .step = 0.5});
  // For this input a = (½, ½), e = 2.5 and Σy² = 5, so µ e/Σy² = 0.25.
  EXPECT_DOUBLE_EQ(predicted(2), 1.5);
  const double a1 = 0.5 + 0.25 * 2, a2 = 0.5 + 0.25 * 1;
  EXPECT_DOUBLE_EQ(predicted(3), a1 * 4 + a2 * 2);
}

TEST(ForwardPrediction, LearnsRecurrence) {
  Eigen::VectorXd wave(4000);
  for (Eigen::Index n = 0; n < wave.size(); ++n) wave(n) = std::sin(0.3 * static_cast<double>(n));
  const Eigen::VectorXd predicted = forward_prediction(wave, {.order = 2, .step = 0.5});
  EXPECT_LT((predicted - wave).tail(100).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(ForwardPrediction, StaysBoundedForAnyBias) {
  for (const double size : {1e-6, 1.0, 1e6}) {
    const Eigen::VectorXd values = size * data::normal_vector(2000, 3);
    EXPECT_LT(forward_prediction(values).cwiseAbs().maxCoeff(), 10 * size);
  }
}

TEST(ForwardPrediction, RemovesNoiseFromConstantBias) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Eigen::VectorXd noise = data::normal_vector(500, seed);
    const data::Clusters clusters = clusters_with(Eigen::VectorXd::LinSpaced(500, 0, 49900), noise.array() + 7);
    EXPECT_LT((filter_bias(clusters).array() - 7).square().mean(), 0.7 * noise.squaredNorm() / 500) << "seed " << seed;
  }
}

/// Returns two folds of a smooth function with noise. Each has 2100 training rows.
std::vector<Fold> large_folds() {
  std::vector<Fold> folds(2);
  for (Fold& fold : folds) {
    const bool second = &fold == &folds.back();
    const auto inputs = [&](Eigen::Index rows, std::uint64_t seed) {
      svm::SampleMatrix x(rows, 2);
      x << data::normal_vector(rows, seed), data::normal_vector(rows, seed + 1);
      return x;
    };
    const auto target = [](const svm::SampleMatrix& x, std::uint64_t seed) -> Eigen::VectorXd {
      return x.col(0).array().sin() + 0.2 * x.col(1).array() + 0.1 * data::normal_vector(x.rows(), seed).array();
    };
    fold.train_x = inputs(2100, second ? 10 : 20);
    fold.train_y = target(fold.train_x, 31);
    fold.test_x = inputs(200, second ? 40 : 50);
    fold.test_y = target(fold.test_x, 61);
    fold.target_scale = 1;
  }
  return folds;
}

TEST(ChooseSvr, ThinsRowsInQuickSearch) {
  std::vector<Fold> folds = large_folds();
  MethodOptions options;
  options.tuning.swarm.particles = 3;
  options.tuning.swarm.iterations = 1;
  options.tuning.log2_c = {-2, 4};
  options.tuning.choice = svm::ChoiceRule::one_standard_error;
  options.quick = true;
  const auto quick = choose_svr(folds, options, {});
  for (Fold& fold : folds) {
    const auto every_third = Eigen::seq(0, Eigen::last, 3);
    fold.train_x = fold.train_x(every_third, Eigen::all).eval();
    fold.train_y = fold.train_y(every_third).eval();
  }
  options.quick = false;
  const auto thinned = choose_svr(folds, options, {});
  ASSERT_TRUE(quick && thinned);
  EXPECT_EQ(parameter_value(quick->parameters, "C"), parameter_value(thinned->parameters, "C") / 3);
  EXPECT_EQ(parameter_value(quick->parameters, "sigma"), parameter_value(thinned->parameters, "sigma"));
  EXPECT_EQ(parameter_value(quick->parameters, "epsilon"), parameter_value(thinned->parameters, "epsilon"));
  EXPECT_EQ(quick->tuning->one_standard_error->best.C, thinned->tuning->one_standard_error->best.C / 3);
  EXPECT_FALSE(quick->warnings.empty());
}

TEST(BiasFilter, RestartsAfterGapAndInAnotherRecord) {
  const Eigen::VectorXd bias = data::normal_vector(30, 2);
  Eigen::VectorXd start = Eigen::VectorXd::LinSpaced(30, 0, 2900);
  start.segment(10, 10).array() += 500;                     // a gap
  start.tail(10) = Eigen::VectorXd::LinSpaced(10, 0, 900);  // another record
  const Eigen::VectorXd filtered = filter_bias(clusters_with(start, bias));
  for (const Eigen::Index first : {0, 10, 20}) {
    const Eigen::VectorXd part = bias.segment(first, 10);
    const Eigen::VectorXd alone = filter_bias(clusters_with(Eigen::VectorXd::LinSpaced(10, 0, 900), part));
    EXPECT_EQ(filtered.segment(first, 10), alone) << first;
  }
}

const HyperParameters kParameters = {{"C", 10}, {"sigma", 1.5}, {"epsilon", 0.1}};

TEST(SvrLinear, AddsSupportVectorsOfResidualToPlane) {
  const data::Samples samples = data::bent_plane(150, 1), elsewhere = data::bent_plane(50, 2);
  const Eigen::MatrixXd covariance = Eigen::Vector3d(0.1, 0.02, 0.05).asDiagonal();
  const auto fit = fit_svr_linear({samples.x, samples.y, samples.terms, covariance}, kParameters, {});
  ASSERT_TRUE(fit);
  const PenalisedPlane plane = penalised_plane(samples.x, samples.y, covariance);
  const Eigen::VectorXd residual = (samples.y - samples.x * plane.weights).array() - plane.b;
  const double unit = std::sqrt(residual.squaredNorm() / 150);
  const Eigen::VectorXd y = residual / unit;
  const auto support = fit_svr({samples.x, y, samples.terms}, kParameters, {});
  ASSERT_TRUE(support);
  const Eigen::VectorXd expected = (elsewhere.x * plane.weights).array() + plane.b +
                                   unit * evaluate_function(support->function, elsewhere.x).array();
  EXPECT_LT((evaluate_function(fit->function, elsewhere.x) - expected).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_NEAR(fit->effective_parameters, plane.effective_parameters + support->effective_parameters, 1e-12);
}

TEST(SvrLinear, ReturnsPlaneForExactPlane) {
  data::Samples samples{data::normal_matrix(60, 2, 5), {}, data::letters(2)};
  samples.y = (2 * samples.x.col(0) - samples.x.col(1)).array() + 0.5;
  const auto fit = fit_svr_linear(samples.set(), kParameters, {});
  ASSERT_TRUE(fit);
  EXPECT_LT((evaluate_function(fit->function, samples.x) - samples.y).cwiseAbs().maxCoeff(), 1e-10);
}

TEST(SvrLinear, TunesOnResidualOfPlane) {
  const data::Samples samples = data::bent_plane(120, 6);
  MethodOptions options;
  options.tuning.swarm.particles = 6;
  options.tuning.swarm.iterations = 4;
  const auto choice = choose_svr_linear(folds_of(samples, 3), options, {});
  ASSERT_TRUE(choice && choice->tuning);
  EXPECT_LT(choice->tuning->cross_validation_mse, 0.2);
  const auto fit = fit_svr_linear(samples.set(), choice->parameters, options);
  ASSERT_TRUE(fit);
  const data::Samples unseen = data::bent_plane(200, 7);
  EXPECT_LT((evaluate_function(fit->function, unseen.x) - unseen.y).norm(), 0.15 * unseen.y.norm());
}

TEST(PlaneWithKernel, ExtrapolatesAsPlane) {
  const data::Samples samples = data::bent_plane(200, 3);
  const auto beside = fit_svr_linear(samples.set(), kParameters, {}), alone = fit_svr(samples.set(), kParameters, {});
  ASSERT_TRUE(beside && alone);
  const data::SampleMatrix far = Eigen::RowVector3d(0, 0, 8);
  EXPECT_NEAR(evaluate_function(beside->function, far)(0), 32, 2);
  EXPECT_LT(evaluate_function(alone->function, far)(0), 16) << "a Gaussian kernel does not extrapolate the slope";
}

TEST(PlaneWithKernel, DependsLessOnUncertainInput) {
  const data::Samples samples = data::bent_plane(150, 4);
  const auto fitted_slope = [&](double variance) {
    const Eigen::MatrixXd covariance = Eigen::Vector3d(0, 0, variance).asDiagonal();
    const auto fit = fit_svr_linear({samples.x, samples.y, samples.terms, covariance}, kParameters, {});
    return std::get<ExpansionModel>(fit->function).slope(2);
  };
  EXPECT_GT(fitted_slope(0), fitted_slope(0.1));
  EXPECT_GT(fitted_slope(0.1), fitted_slope(1));
}

}  // namespace
}  // namespace gyrotherm::methods
