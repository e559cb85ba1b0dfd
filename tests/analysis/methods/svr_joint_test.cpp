// SPDX-License-Identifier: Apache-2.0
#include "analysis/methods/svr_joint.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "analysis/methods/ridge_u.hpp"
#include "analysis/methods/svr.hpp"
#include "analysis/svm/kernel.hpp"
#include "tests/analysis/random_samples.hpp"

namespace gyrotherm::methods {
namespace {

const HyperParameters kJointParameters = {{"C", 10}, {"sigma", 1.5}, {"epsilon", 0.1}, {"plane penalty", 1}};

HyperParameters with(HyperParameters parameters, std::string_view name, double value) {
  for (HyperParameter& parameter : parameters)
    if (parameter.name == name) parameter.value = value;
  return parameters;
}

/// A plane and normal noise, so that what any plane leaves is normal.
data::Samples noisy_plane(Eigen::Index rows, std::uint64_t seed) {
  data::Samples samples{data::normal_matrix(rows, 3, seed), {}, data::letters(3)};
  samples.y = samples.x * Eigen::Vector3d(1, -0.5, 0.25) + 0.3 * data::normal_vector(rows, seed + 1);
  return samples;
}

const ExpansionModel& expansion_of(const Fit& fit) { return std::get<ExpansionModel>(fit.function); }

TEST(SvrJoint, IsOneSolveOfBothInUnitsOfWhatThePlaneOfRidgeULeaves) {
  const data::Samples samples = data::bent_plane(150, 1), elsewhere = data::bent_plane(50, 2);
  const Eigen::MatrixXd covariance = Eigen::Vector3d(0.1, 0.02, 0.05).asDiagonal();
  MethodOptions options;
  options.tight_gap = 1e-9;
  const auto fit = fit_svr_joint({samples.x, samples.y, samples.terms, covariance}, kJointParameters, options);
  ASSERT_TRUE(fit) << text(fit.error());
  const PenalisedPlane rough = penalised_plane(samples.x, samples.y, covariance);
  const double unit = ((samples.y - samples.x * rough.weights).array() - rough.b).matrix().norm() / std::sqrt(150);
  const Eigen::MatrixXd penalty = 150 * covariance + 1e-4 * Eigen::Matrix3d::Identity();
  const svm::GaussianSamples gaussian(samples.x);
  const svm::PlaneSamples plane(samples.x, penalty);
  svm::KernelMemory memory;
  const Eigen::VectorXd y = samples.y / unit;
  const auto solution = solve_svr(gaussian, memory, y, {10, 1.5, 0.1, 1}, {.relative_gap = 1e-9}, &plane);
  ASSERT_TRUE(solution) << text(solution.error());
  const Eigen::MatrixXd kernel = svm::gaussian_kernel(elsewhere.x, samples.x, 1.5);
  const Eigen::VectorXd expected =
      unit * ((elsewhere.x * solution->slope + kernel * solution->beta).array() + solution->b);
  EXPECT_LT((value_of(fit->function, elsewhere.x) - expected).cwiseAbs().maxCoeff(), 1e-9 * expected.norm());
  const auto free = (solution->beta.array() != 0 && solution->beta.array().abs() < solution->bound).count();
  EXPECT_EQ(fit->effective_parameters, static_cast<double>(free));
}

// Gaussians far narrower than the samples are apart are of no height beside inputs so uncertain: the plane is left.
TEST(SvrJoint, ItsPlaneCostsWhatItCostsRidgeU) {
  const HyperParameters narrow = with(with(kJointParameters, "sigma", 1e-3), "epsilon", 1e-3);
  const data::Samples samples = noisy_plane(1500, 3);
  for (const double variance : {0.01, 0.3, 2.0}) {
    const Eigen::MatrixXd covariance = Eigen::Vector3d(variance, 0.2, 0.5).asDiagonal();
    const auto fit = fit_svr_joint({samples.x, samples.y, samples.terms, covariance}, narrow, {});
    ASSERT_TRUE(fit) << text(fit.error());
    const Eigen::VectorXd slope = expansion_of(*fit).slope;
    const Eigen::VectorXd expected = penalised_plane(samples.x, samples.y, covariance).weights;
    const Eigen::VectorXd free = penalised_plane(samples.x, samples.y, 0 * covariance).weights;
    EXPECT_GT((free - expected).norm(), 0.1 * free.norm()) << "the penalty is felt";
    EXPECT_LT((slope - expected).norm(), 0.2 * (free - expected).norm())
        << slope.transpose() << ", " << expected.transpose() << ": to first order, and another loss has other noise";
  }
}

/// Where ridge-u stands whose penalty is `kappa` times as dear and counts in units of what is left with it, not of what
/// is left with κ = 1: the loss of support vectors is flatter where more is left.
Eigen::VectorXd plane_at(const FitInput& set, double kappa) {
  const auto left = [&](const PenalisedPlane& plane) {
    return ((set.y - set.x * plane.weights).array() - plane.b).matrix().norm();
  };
  const double unit = left(penalised_plane(set.x, set.y, set.input_covariance));
  PenalisedPlane plane = penalised_plane(set.x, set.y, kappa * set.input_covariance);
  for (int round = 0; round < 50; ++round)
    plane = penalised_plane(set.x, set.y, kappa * left(plane) / unit * set.input_covariance);
  return plane.weights;
}

TEST(SvrJoint, CostsThePlaneAsManyTimesAsItIsTold) {
  const HyperParameters narrow = with(with(kJointParameters, "sigma", 1e-3), "epsilon", 1e-3);
  const data::Samples samples = noisy_plane(1500, 4);
  const Eigen::MatrixXd covariance = 0.02 * Eigen::Matrix3d::Identity();
  const FitInput set{samples.x, samples.y, samples.terms, covariance};
  for (const double kappa : {1.0, 4.0, 16.0}) {
    const auto fit = fit_svr_joint(set, with(narrow, "plane penalty", kappa), {});
    ASSERT_TRUE(fit) << text(fit.error());
    const Eigen::VectorXd expected = plane_at(set, kappa);
    EXPECT_LT((expansion_of(*fit).slope - expected).norm(), 0.06 * expected.norm()) << kappa;
  }
}

// Not the Gaussians alone: they take over what a dearer plane gives up.
TEST(SvrJoint, WithALargerUncertaintyItIsFlatter) {
  const data::Samples samples = data::bent_plane(150, 5);
  const auto steepness_of = [&](double variance) {
    const Eigen::MatrixXd covariance = variance * Eigen::Matrix3d::Identity();
    const auto fit = fit_svr_joint({samples.x, samples.y, samples.terms, covariance}, kJointParameters, {});
    constexpr double kStep = 1e-4;
    const data::SampleMatrix higher = samples.x.array() + kStep, lower = samples.x.array() - kStep;
    return (value_of(fit->function, higher) - value_of(fit->function, lower)).norm() / (2 * kStep);
  };
  EXPECT_GT(steepness_of(0.001), steepness_of(0.05));
  EXPECT_GT(steepness_of(0.05), 1.2 * steepness_of(1));
}

TEST(SvrJoint, MovesWithItsInputsAsItsDerivativeSays) {
  const data::Samples samples = data::bent_plane(120, 8);
  const auto fit = fit_svr_joint(samples.set(), kJointParameters, {});
  ASSERT_TRUE(fit);
  const ExpansionModel& both = expansion_of(*fit);
  constexpr double kStep = 1e-5;
  for (Eigen::Index input = 0; input < 3; ++input) {
    data::SampleMatrix higher = samples.x, lower = samples.x;
    higher.col(input).array() += kStep;
    lower.col(input).array() -= kStep;
    const Eigen::VectorXd found = (value_of(both, higher) - value_of(both, lower)) / (2 * kStep);
    const Eigen::MatrixXd kernel = svm::gaussian_kernel(samples.x, both.centres, 1.5);
    for (Eigen::Index i = 0; i < 120; ++i) {
      const Eigen::VectorXd apart = both.centres.col(input).array() - samples.x(i, input);
      const double derivative = both.slope(input) + kernel.row(i).dot(both.weights.cwiseProduct(apart)) / (1.5 * 1.5);
      ASSERT_NEAR(found(i), derivative, 1e-6) << i << ", input " << input;
    }
  }
}

TEST(SvrJoint, OfAnExactPlaneIsThePlaneToWithinItsTube) {
  data::Samples samples{data::normal_matrix(60, 2, 5), {}, data::letters(2)};
  samples.y = (2 * samples.x.col(0) - samples.x.col(1)).array() + 0.5;
  const auto fit = fit_svr_joint(samples.set(), kJointParameters, {});
  ASSERT_TRUE(fit) << text(fit.error());
  EXPECT_LT((value_of(fit->function, samples.x) - samples.y).cwiseAbs().maxCoeff(), 2e-4);
}

TEST(SvrJoint, TakesInputsThatDependOnEachOther) {
  data::Samples samples = data::bent_plane(120, 9);
  const data::Samples three = samples;
  samples.x.conservativeResize(Eigen::NoChange, 4);
  samples.x.col(3) = samples.x.col(0) - samples.x.col(2);
  samples.terms = data::letters(4);
  const auto fit = fit_svr_joint(samples.set(), kJointParameters, {});
  ASSERT_TRUE(fit) << text(fit.error());
  EXPECT_LT((value_of(fit->function, samples.x) - samples.y).norm(), 0.1 * samples.y.norm());
}

TEST(SvrJoint, TunesAFourthCoordinateThatIsNoCheaperThanTheCertificate) {
  const data::Samples samples = data::bent_plane(120, 6);
  MethodOptions options;
  options.tuning.swarm.particles = 6;
  options.tuning.swarm.iterations = 4;
  std::vector<Fold> folds = folds_of(samples, 3);
  for (Fold& fold : folds) fold.input_covariance = 1e-4 * Eigen::Matrix3d::Identity();
  const auto choice = choose_svr_joint(folds, options, {});
  ASSERT_TRUE(choice && choice->tuning);
  EXPECT_LT(choice->tuning->cross_validation_mse, 0.2);
  EXPECT_EQ(choice->tuning->swarm.best.size(), 4u);
  EXPECT_GE(value_of(choice->parameters, "plane penalty"), 1);
  EXPECT_EQ(value_of(choice->parameters, "plane penalty"), choice->tuning->best.plane_penalty);
  const auto fit = fit_svr_joint(samples.set(), choice->parameters, options);
  ASSERT_TRUE(fit);
  const data::Samples unseen = data::bent_plane(200, 7);
  EXPECT_LT((value_of(fit->function, unseen.x) - unseen.y).norm(), 0.15 * unseen.y.norm());
}

// What a search over held-out rows of one state of the inputs cannot see.
TEST(SvrJoint, LastsWhereItsInputsAreOffAsTheirUncertaintySays) {
  double known = 0, unknown = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    data::Samples samples{data::normal_matrix(200, 1, seed) * Eigen::RowVector4d::Ones(), {}, data::letters(4)};
    samples.x += 0.03 * data::normal_matrix(200, 4, 10 * seed);
    samples.y = samples.x.rowwise().mean().array().tanh() + 0.1 * data::normal_vector(200, 100 * seed).array();
    const Eigen::MatrixXd covariance = 0.01 * Eigen::Matrix4d::Identity();
    const auto with_it = fit_svr_joint({samples.x, samples.y, samples.terms, covariance}, kJointParameters, {});
    const auto without = fit_svr_joint(samples.set(), kJointParameters, {});
    ASSERT_TRUE(with_it && without);
    for (std::uint64_t draw = 0; draw < 20; ++draw) {
      const Eigen::RowVectorXd off = 0.1 * data::normal_matrix(1, 4, 1000 * seed + draw);
      const data::SampleMatrix moved = samples.x.rowwise() + off;
      known += (value_of(with_it->function, moved) - samples.y).squaredNorm();
      unknown += (value_of(without->function, moved) - samples.y).squaredNorm();
    }
  }
  EXPECT_LT(known, 0.9 * unknown);
}

}  // namespace
}  // namespace gyrotherm::methods
