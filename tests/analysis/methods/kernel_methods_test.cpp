// SPDX-License-Identifier: Apache-2.0
#include "analysis/methods/kernel_methods.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <numeric>

#include "analysis/methods/ridge_u.hpp"
#include "tests/analysis/random_samples.hpp"

namespace gyrotherm::methods {
namespace {

TEST(LeastSquaresSvm, SatisfiesOptimalityConditions) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const data::Samples samples = data::bent_samples(70, 3, 0.2, seed);
    const Eigen::MatrixXd kernel = svm::gaussian_kernel(samples.x, samples.x, 2);
    for (const double gamma : {1.0, 100.0, 1e4}) {
      const auto machine = solve_ls_svm(kernel, samples.y, gamma);
      ASSERT_TRUE(machine);
      EXPECT_NEAR(machine->alpha.sum(), 0, 1e-10 * machine->alpha.cwiseAbs().sum());
      const Eigen::VectorXd residual = samples.y - ((kernel * machine->alpha).array() + machine->b).matrix();
      EXPECT_LT((residual - machine->alpha / gamma).cwiseAbs().maxCoeff(), 1e-9);
    }
  }
}

TEST(LeastSquaresSvm, ComputesLeaveOneOutResidualInClosedForm) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const data::Samples samples = data::bent_samples(60, 3, 0.2, seed);
    const double gamma = 50, sigma = 1.5;
    const auto machine = solve_ls_svm(svm::gaussian_kernel(samples.x, samples.x, sigma), samples.y, gamma);
    const Eigen::VectorXd diagonal = bordered_inverse_diagonal(*machine);
    for (const Eigen::Index left_out : {0, 20, 59}) {
      std::vector<Eigen::Index> others(60);
      std::iota(others.begin(), others.end(), 0);
      others.erase(others.begin() + left_out);
      const data::SampleMatrix outside = samples.x(others, Eigen::all);
      const auto without = solve_ls_svm(svm::gaussian_kernel(outside, outside, sigma), samples.y(others), gamma);
      const Eigen::VectorXd kernel = svm::gaussian_kernel(samples.x.row(left_out), outside, sigma).transpose();
      const double residual = samples.y(left_out) - kernel.dot(without->alpha) - without->b;
      EXPECT_NEAR(machine->alpha(left_out) / diagonal(left_out), residual, 1e-10);
    }
  }
}

TEST(LeastSquaresSvm, CountsTraceOfHatMatrix) {
  const data::Samples samples = data::bent_samples(25, 2, 0.2, 1);
  const HyperParameters parameters = {{"gamma", 20}, {"sigma", 1.2}};
  double trace = 0;
  for (Eigen::Index i = 0; i < 25; ++i) {
    const Eigen::VectorXd unit = Eigen::VectorXd::Unit(25, i);
    trace += evaluate_function(fit_ls_svm({samples.x, unit, samples.terms}, parameters, {})->function, samples.x)(i);
  }
  EXPECT_NEAR(fit_ls_svm(samples.set(), parameters, {})->effective_parameters, trace, 1e-9);
}

TEST(LeastSquaresSvm, ChoosesLocalMinimumOfHeldOutError) {
  const data::Samples samples = data::bent_samples(120, 2, 0.1, 2);
  const auto folds = folds_of(samples, 4);
  const auto choice = choose_ls_svm(folds, {}, {});
  ASSERT_TRUE(choice);
  const auto error_at = [&](double gamma, double sigma) {
    double sum = 0;
    for (const Fold& fold : folds) {
      const auto fit = fit_ls_svm({fold.train_x, fold.train_y, fold.terms}, {{"gamma", gamma}, {"sigma", sigma}}, {});
      sum += (evaluate_function(fit->function, fold.test_x) - fold.test_y).squaredNorm();
    }
    return sum;
  };
  const double gamma = parameter_value(choice->parameters, "gamma"),
               sigma = parameter_value(choice->parameters, "sigma");
  const double least = error_at(gamma, sigma);
  EXPECT_LT(least / 120, 0.05);
  for (const double other : {0.5, 2.0}) EXPECT_LE(least, error_at(gamma * other, sigma) + 1e-9);
  for (const double other : {std::exp2(-0.375), std::exp2(0.375)})
    EXPECT_LE(least, error_at(gamma, sigma * other) + 1e-9);
}

double log_density(const Covariance& covariance, const data::Samples& samples) {
  Eigen::MatrixXd k = covariance_matrix(covariance, samples.x, samples.x);
  k.diagonal().array() += covariance.noise * covariance.noise;
  const Eigen::LDLT<Eigen::MatrixXd> factor(k);
  const double log_determinant = factor.vectorD().array().log().sum();
  return -0.5 * (samples.y.dot(factor.solve(samples.y)) + log_determinant +
                 static_cast<double>(samples.y.size()) * std::log(2 * std::acos(-1.0)));
}

TEST(MarginalLikelihood, MatchesDensityAndDifferences) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const data::Samples samples = data::bent_samples(30, 3, 0.2, seed);
    const Covariance at{.lengths = Eigen::RowVector3d{0.8, 1.5, 3} * (1 + 0.05 * static_cast<double>(seed)),
                        .signal = 1.3,
                        .noise = 0.25};
    const auto likelihood = marginal_likelihood(at, samples.x, samples.y);
    ASSERT_TRUE(likelihood);
    EXPECT_NEAR(likelihood->log_value, log_density(at, samples), 1e-8);
    const Eigen::VectorXd logarithms = to_logarithms(at);
    for (Eigen::Index k = 0; k < logarithms.size(); ++k) {
      constexpr double kStep = 1e-5;
      const Eigen::VectorXd shift = kStep * Eigen::VectorXd::Unit(logarithms.size(), k);
      const double slope = (log_density(from_logarithms(logarithms + shift), samples) -
                            log_density(from_logarithms(logarithms - shift), samples)) /
                           (2 * kStep);
      EXPECT_NEAR(likelihood->gradient(k), slope, 1e-5 * (1 + std::abs(slope))) << k;
    }
  }
}

TEST(MarginalLikelihood, IsClimbedToStationaryPoint) {
  const data::Samples samples = data::bent_samples(80, 2, 0.1, 3);
  const Covariance start{.lengths = Eigen::RowVector2d{1, 1}, .signal = 1, .noise = 0.3};
  const auto ascent = climb_likelihood(start, samples.x, samples.y, 300);
  ASSERT_TRUE(ascent);
  EXPECT_GT(ascent->log_likelihood, marginal_likelihood(start, samples.x, samples.y)->log_value);
  const auto there = marginal_likelihood(ascent->covariance, samples.x, samples.y);
  EXPECT_LT(there->gradient.cwiseAbs().maxCoeff(), 0.2);
  EXPECT_NEAR(ascent->covariance.noise, 0.1, 0.03);
}

TEST(GaussianProcess, GivesIrrelevantInputLongLength) {
  // C has no effect on y.
  const data::Samples samples = data::bent_samples(250, 3, 0.05, 4);
  const auto fit = fit_gaussian_process(samples.set(), {}, {});
  ASSERT_TRUE(fit);
  const auto& lengths = std::get<ExpansionModel>(fit->function).lengths;
  EXPECT_GT(lengths(2), 5 * lengths(0));
  EXPECT_GT(lengths(2), 5 * lengths(1));
  EXPECT_NE(fit->particulars.find("predictive STD"), std::string::npos);
}

/// Returns the samples as fit input with thermometer uncertainties. That of A is the largest.
FitInput uncertain_input(const data::Samples& samples) {
  Eigen::MatrixXd covariance = Eigen::VectorXd::LinSpaced(samples.x.cols(), 0.05, 0.01).asDiagonal();
  return {samples.x, samples.y, samples.terms, covariance};
}

/// Posterior of the process (plane and Gaussians) from the full covariance matrix of all samples.
struct DensePosterior {
  Eigen::VectorXd mean, variance;
};
DensePosterior dense(const FitInput& set, const PredictiveVariance& of, const data::SampleMatrix& at) {
  const Covariance covariance{.lengths = of.lengths, .signal = of.signal, .noise = of.noise};
  const Eigen::Index inputs = set.x.cols();
  Eigen::MatrixXd precision = Eigen::MatrixXd::Identity(inputs, inputs) / (kWidestSlope * kWidestSlope);
  precision += static_cast<double>(set.x.rows()) / (of.noise * of.noise) * set.input_covariance;
  const Eigen::MatrixXd prior = precision.inverse();
  Eigen::MatrixXd whole = covariance_matrix(covariance, set.x, set.x) + set.x * prior * set.x.transpose();
  whole.diagonal().array() += of.noise * of.noise;
  const Eigen::MatrixXd across = covariance_matrix(covariance, at, set.x) + at * prior * set.x.transpose();
  const Eigen::MatrixXd own = covariance_matrix(covariance, at, at) + at * prior * at.transpose();
  const Eigen::LDLT<Eigen::MatrixXd> factor(whole);
  const double mean = set.y.mean();
  return {(across * factor.solve((set.y.array() - mean).matrix())).array() + mean,
          (own - across * factor.solve(across.transpose())).diagonal()};
}

TEST(GaussianProcess, MatchesMeanAndVarianceOfFullPosterior) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE(seed);
    const data::Samples samples = data::bent_samples(kVarianceCentres, 3, 0.1, seed);
    const data::SampleMatrix at = 2 * data::normal_matrix(40, 3, seed + 99);
    const auto fit = fit_gaussian_process(uncertain_input(samples), {}, {});
    ASSERT_TRUE(fit && fit->variance);
    const DensePosterior expected = dense(uncertain_input(samples), *fit->variance, at);
    EXPECT_LT((evaluate_function(fit->function, at) - expected.mean).cwiseAbs().maxCoeff(), 1e-6);
    const Eigen::VectorXd variance = evaluate_variance(*fit->variance, at);
    EXPECT_LT(((variance - expected.variance).array() / expected.variance.array()).abs().maxCoeff(), 1e-3);
  }
}

/// The stored variance uses sixty samples. It must be close to the variance from all samples, and not below it.
TEST(GaussianProcess, StoresVarianceNotBelowFullPosterior) {
  const data::Samples samples = data::bent_samples(300, 2, 0.1, 8);
  const auto fit = fit_gaussian_process(uncertain_input(samples), {}, {});
  ASSERT_TRUE(fit && fit->variance);
  EXPECT_LE(fit->variance->centres.rows(), kVarianceCentres);
  const data::SampleMatrix at = data::normal_matrix(100, 2, 9);
  const Eigen::VectorXd whole = dense(uncertain_input(samples), *fit->variance, at).variance,
                        stored = evaluate_variance(*fit->variance, at);
  EXPECT_GT((stored.array() / whole.array()).minCoeff(), 0.9);
  EXPECT_LT(stored.mean(), 4 * whole.mean());
}

TEST(GaussianProcess, ContinuesAsPlane) {
  data::Samples samples{data::normal_matrix(200, 2, 3), {}, data::letters(2)};
  samples.y = samples.x.col(0) - 0.5 * samples.x.col(1) + 0.05 * data::normal_vector(200, 4);
  const auto fit = fit_gaussian_process(samples.set(), {}, {});
  ASSERT_TRUE(fit);
  const data::SampleMatrix far = (data::SampleMatrix(2, 2) << 30, 0, 0, -30).finished();
  const Eigen::VectorXd there = evaluate_function(fit->function, far);
  EXPECT_NEAR(there(0), 30, 1);
  EXPECT_NEAR(there(1), 15, 1);
}

TEST(GaussianProcess, ReturnsPosteriorMeanOfAllSamples) {
  // Uses more samples than the likelihood does (kMostSamples).
  const data::Samples samples = data::bent_samples(450, 2, 0.1, 5);
  const auto fit = fit_gaussian_process(samples.set(), {}, {});
  ASSERT_TRUE(fit);
  const auto& expansion = std::get<ExpansionModel>(fit->function);
  EXPECT_EQ(expansion.centres.rows(), 450);
  // K w + σ_n² w/σ_f² = y − mean, so the residual is proportional to the weights.
  const Eigen::VectorXd residual = samples.y - evaluate_function(fit->function, samples.x);
  const double part = residual.dot(expansion.weights) / expansion.weights.squaredNorm();
  EXPECT_LT((residual - part * expansion.weights).norm(), 1e-6 * residual.norm());
  EXPECT_GT(fit->effective_parameters, 3);
  EXPECT_LT(fit->effective_parameters, 150);
  const data::Samples unseen = data::bent_samples(300, 2, 0, 6);
  EXPECT_LT((evaluate_function(fit->function, unseen.x) - unseen.y).norm(), 0.1 * unseen.y.norm());
}

}  // namespace
}  // namespace gyrotherm::methods
