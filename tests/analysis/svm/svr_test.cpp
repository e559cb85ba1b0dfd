// SPDX-License-Identifier: Apache-2.0
#include "analysis/svm/svr.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <regex>
#include <string>

#include "analysis/svm/svr_problem.hpp"

namespace gyrotherm::svm {
namespace {

struct Data {
  SampleMatrix x;
  Eigen::VectorXd y;
};

/// Returns samples of a smooth function of d inputs with 2 % noise. The targets have unit STD.
Data smooth_data(Eigen::Index n, Eigen::Index d, std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal;
  Data data{SampleMatrix::NullaryExpr(n, d, [&] { return normal(generator); }), Eigen::VectorXd(n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto x = data.x.row(i);
    data.y[i] = 0.8 * x[0] + 0.6 * std::tanh(1.3 * x[1]) - 0.3 * x[2] * x[2] + 0.02 * normal(generator);
  }
  data.y.array() -= data.y.mean();
  data.y /= std::max(std::sqrt(data.y.squaredNorm() / static_cast<double>(n)), 1e-3);
  return data;
}

/// Computes the kernel matrix by its definition, with one std::exp per element.
Eigen::MatrixXd kernel_by_definition(const SampleMatrix& x, double sigma) {
  Eigen::MatrixXd kernel(x.rows(), x.rows());
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    for (Eigen::Index j = 0; j < x.rows(); ++j) {
      kernel(i, j) = std::exp(-(x.row(i) - x.row(j)).squaredNorm() / (2 * sigma * sigma));
    }
  }
  return kernel;
}

double uniform(std::mt19937_64& generator, double from, double to) {
  return std::uniform_real_distribution<double>(from, to)(generator);
}

// Returns a random position in the search box.
SvrParameters random_parameters(std::mt19937_64& generator) {
  return {.C = std::exp2(uniform(generator, -2, 12)),
          .sigma = std::exp2(uniform(generator, -2, 3.5)),
          .epsilon = std::exp2(uniform(generator, -8, -1))};
}

/// Requires an optimal solution. With r = y − Kβ − b, the duality gap is the sum of the terms
/// C max(0, |r_i| − ε) + ε|β_i| − r_iβ_i ≥ 0. A term is 0 if and only if point i satisfies its optimality condition:
/// β_i = 0 and |r_i| ≤ ε, or 0 < |β_i| < C and r_i = ε sign β_i, or |β_i| = C and r_i sign β_i ≥ ε.
void expect_optimal(const Data& data, const SvrParameters& p, const SvrSolution& solution, double relative_gap) {
  const Eigen::MatrixXd kernel = kernel_by_definition(data.x, p.sigma);
  const Eigen::ArrayXd beta = solution.beta;
  const Eigen::ArrayXd r = data.y - kernel * solution.beta - Eigen::VectorXd::Constant(data.y.size(), solution.b);
  const double n = static_cast<double>(data.y.size());
  EXPECT_NEAR(beta.sum(), 0, 1e-9 * p.C * n);
  EXPECT_LE(beta.abs().maxCoeff(), p.C);
  const Eigen::ArrayXd terms = p.C * (r.abs() - p.epsilon).max(0.0) + p.epsilon * beta.abs() - r * beta;
  const double rounding = 1e-12 * p.C * n;
  EXPECT_GE(terms.minCoeff(), -rounding);
  EXPECT_LE(terms.sum(), relative_gap * std::abs(solution.objective) + rounding);
}

TEST(Svr, MeetsOptimalityConditionsInWholeBox) {
  for (std::uint64_t seed = 1; seed <= 250; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 generator(seed);
    const Data data = smooth_data(2 + static_cast<Eigen::Index>(generator() % 120), 3 + seed % 12, seed);
    const SvrParameters parameters = random_parameters(generator);
    const auto solution = solve_svr(data.x, data.y, parameters, {.relative_gap = 1e-6});
    ASSERT_TRUE(solution) << text(solution.error());
    EXPECT_LE(solution->relative_gap, 1e-6);
    expect_optimal(data, parameters, *solution, 1e-6);
  }
}

TEST(Svr, CertifiesLargeTrainingsInCornersOfBox) {
  const Data data = smooth_data(400, 7, 3);
  for (const double C : {-2.0, 12.0}) {
    for (const double sigma : {-2.0, 0.0, 3.5}) {
      for (const double epsilon : {-8.0, -1.0}) {
        SCOPED_TRACE(testing::Message() << "log2 C " << C << ", sigma " << sigma << ", epsilon " << epsilon);
        const SvrParameters parameters{std::exp2(C), std::exp2(sigma), std::exp2(epsilon)};
        const auto solution = solve_svr(data.x, data.y, parameters, {.relative_gap = 1e-6});
        ASSERT_TRUE(solution) << text(solution.error());
        expect_optimal(data, parameters, *solution, 1e-6);
      }
    }
  }
}

TEST(Svr, ImprovesObjectiveWithTighterCertificate) {
  const Data data = smooth_data(150, 5, 9);
  const SvrParameters parameters{.C = 100, .sigma = 2, .epsilon = 0.01};
  const auto loose = solve_svr(data.x, data.y, parameters, {.relative_gap = 1e-2});
  const auto tight = solve_svr(data.x, data.y, parameters, {.relative_gap = 1e-8});
  ASSERT_TRUE(loose && tight);
  EXPECT_LE(tight->objective, loose->objective);
  EXPECT_GE(tight->objective, loose->objective - loose->relative_gap * std::abs(loose->objective));
}

/// Two points with the kernel value k have the targets ±a. The solution β = (t, −t) minimises (1 − k)t² − 2(a − ε)t
/// over 0 ≤ t ≤ C.
TEST(Svr, MatchesClosedFormForTwoPoints) {
  SampleMatrix x(2, 1);
  x << 0, 1;
  const double sigma = 0.8;
  const double k = std::exp(-1 / (2 * sigma * sigma));
  Eigen::VectorXd y(2);
  y << 1, -1;
  for (const double epsilon : {0.0, 0.3, 0.999, 1.0, 2.0}) {
    for (const double C : {0.25, 1.0, 100.0}) {
      const auto solution = solve_svr(x, y, {C, sigma, epsilon}, {.relative_gap = 1e-10});
      ASSERT_TRUE(solution) << text(solution.error());
      const double t = std::clamp((1 - epsilon) / (1 - k), 0.0, C);
      EXPECT_NEAR(solution->beta[0], t, 1e-9);
      EXPECT_NEAR(solution->beta[1], -t, 1e-9);
      EXPECT_NEAR(solution->b, 0, 1e-9);
    }
  }
}

TEST(Svr, UsesSinglePointAsOffset) {
  const auto solution = solve_svr(SampleMatrix::Zero(1, 3), Eigen::VectorXd::Constant(1, 0.7), {1, 1, 0.1});
  ASSERT_TRUE(solution);
  EXPECT_EQ(solution->beta[0], 0);
  EXPECT_DOUBLE_EQ(solution->b, 0.7);
  EXPECT_EQ(solution->support_vectors, 0);
}

TEST(Svr, NeedsNoSupportVectorForConstantTarget) {
  const Data data = smooth_data(50, 4, 5);
  for (const double epsilon : {0.0, 0.01}) {
    const auto solution = solve_svr(data.x, Eigen::VectorXd::Constant(50, 0.3), {4096, 1, epsilon});
    ASSERT_TRUE(solution) << text(solution.error());
    EXPECT_EQ(solution->support_vectors, 0);
    EXPECT_DOUBLE_EQ(solution->b, 0.3);
  }
}

TEST(Svr, NeedsNoSupportVectorForWideTube) {
  const Data data = smooth_data(60, 4, 6);
  const double middle = 0.5 * (data.y.maxCoeff() + data.y.minCoeff());
  const double reach = 0.5 * (data.y.maxCoeff() - data.y.minCoeff());
  const auto solution = solve_svr(data.x, data.y, {100, 1, 1.01 * reach}, {.relative_gap = 1e-6});
  ASSERT_TRUE(solution) << text(solution.error());
  EXPECT_EQ(solution->support_vectors, 0);
  EXPECT_EQ(solution->relative_gap, 0);
  EXPECT_NEAR(solution->b, middle, 0.01 * reach);
}

TEST(Svr, CertifiesDuplicatedPoints) {
  Data data = smooth_data(80, 4, 7);
  data.x.bottomRows(40) = data.x.topRows(40);
  for (const double C : {0.25, 64.0, 4096.0}) {
    const SvrParameters parameters{C, 1.5, 0.01};
    const auto solution = solve_svr(data.x, data.y, parameters, {.relative_gap = 1e-6});
    ASSERT_TRUE(solution) << text(solution.error());
    expect_optimal(data, parameters, *solution, 1e-6);
  }
}

/// All points are equal, so Kβ = 0 for every feasible β. The best function is a constant: a median of the targets.
TEST(Svr, ReturnsMedianForEqualPoints) {
  Eigen::VectorXd y(5);
  y << 1, 2, 3, 10, 100;
  const auto solution = solve_svr(SampleMatrix::Zero(5, 2), y, {1, 1, 0}, {.relative_gap = 1e-9});
  ASSERT_TRUE(solution) << text(solution.error());
  EXPECT_NEAR(solution->b, 3, 1e-9);
}

TEST(Svr, RecoversLineWithinTube) {
  SampleMatrix x(41, 1);
  Eigen::VectorXd y(41);
  for (int i = 0; i <= 40; ++i) {
    x(i, 0) = -2 + 0.1 * i;
    y[i] = 0.7 * x(i, 0) + 0.1;
  }
  const SvrParameters parameters{.C = 4096, .sigma = 4, .epsilon = 0.01};
  const auto solution = solve_svr(x, y, parameters, {.relative_gap = 1e-6});
  ASSERT_TRUE(solution) << text(solution.error());
  SampleMatrix between(2, 1);
  between << -1.05, 0.77;
  const Eigen::VectorXd f = gaussian_kernel(between, x, parameters.sigma) * solution->beta;
  for (int i = 0; i < 2; ++i) EXPECT_NEAR(f[i] + solution->b, 0.7 * between(i, 0) + 0.1, 0.011);
}

TEST(Svr, ReturnsExactZerosAndBounds) {
  const Data data = smooth_data(200, 4, 8);
  const auto solution = solve_svr(data.x, data.y, {0.25, 1.5, 0.1}, {.relative_gap = 1e-6});
  ASSERT_TRUE(solution);
  EXPECT_GT((solution->beta.array() == 0).count(), 20);
  EXPECT_GT((solution->beta.array().abs() == 0.25).count(), 20);
  EXPECT_EQ(solution->support_vectors, (solution->beta.array() != 0).count());
}

TEST(Svr, ReportsIndependentlyComputedGap) {
  const Data data = smooth_data(100, 4, 10);
  const auto solution = solve_svr(data.x, data.y, {50, 2, 0.02});
  ASSERT_TRUE(solution);
  const Eigen::MatrixXd kernel = kernel_by_definition(data.x, 2);
  const double objective = 0.5 * solution->beta.dot(kernel * solution->beta) - data.y.dot(solution->beta) +
                           0.02 * solution->beta.lpNorm<1>();
  EXPECT_NEAR(solution->objective, objective, 1e-9 * std::abs(objective));
  const Eigen::ArrayXd residual = (data.y - kernel * solution->beta).array() - solution->b;
  const double primal = 0.5 * solution->beta.dot(kernel * solution->beta) + 50 * (residual.abs() - 0.02).max(0.0).sum();
  EXPECT_NEAR(solution->relative_gap, (primal + objective) / std::abs(objective), 1e-9);
}

TEST(Svr, RejectsCertificateOfInfeasiblePoint) {
  const Data data = smooth_data(10, 3, 11);
  const GaussianSamples samples(data.x);
  KernelMemory memory;
  Kernel kernel(samples, 1, memory, 0);
  const Eigen::Ref<const Eigen::VectorXd> y(data.y);
  const SvrProblem problem{kernel, y, 1, 0.1};
  const auto certified_gap = [&](const Eigen::VectorXd& beta) {
    return certify(problem, {beta, 0}, problem.kernel.response(beta)).relative_gap;
  };
  Eigen::VectorXd beta = Eigen::VectorXd::Zero(10);
  EXPECT_TRUE(std::isfinite(certified_gap(beta)));
  beta[0] = 0.5;
  EXPECT_EQ(certified_gap(beta), std::numeric_limits<double>::infinity());
  beta[0] = 2;
  beta[1] = -2;
  EXPECT_EQ(certified_gap(beta), std::numeric_limits<double>::infinity());
}

TEST(Svr, FailsWhenCertificateIsMissed) {
  const Data data = smooth_data(100, 4, 12);
  const auto solution = solve_svr(data.x, data.y, {4096, 2, 0.004}, {.relative_gap = 1e-6, .max_newton_steps = 0});
  ASSERT_FALSE(solution);
  EXPECT_EQ(solution.error().kind, FaultKind::numeric);
}

TEST(Svr, NamesInvalidParameter) {
  const Data data = smooth_data(10, 3, 13);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto fault_of = [&](const SvrParameters& parameters) {
    const auto solution = solve_svr(data.x, data.y, parameters);
    EXPECT_FALSE(solution);
    EXPECT_EQ(solution.error().kind, FaultKind::usage);
    return solution.error().what;
  };
  EXPECT_EQ(fault_of({0, 1, 0.1}), "C = 0, must be positive and finite");
  EXPECT_EQ(fault_of({nan, 1, 0.1}), "C = nan, must be positive and finite");
  EXPECT_EQ(fault_of({1, -1, 0.1}), "sigma = -1, must be positive and finite");
  EXPECT_EQ(fault_of({1, 1, -0.1}), "epsilon = -0.1, must be at least 0 and finite");
}

TEST(Svr, NamesInvalidData) {
  Data data = smooth_data(10, 3, 14);
  const SvrParameters parameters{1, 1, 0.1};
  EXPECT_EQ(solve_svr(data.x, data.y.head(9), parameters).error().what, "9 targets for 10 samples");
  EXPECT_EQ(solve_svr(SampleMatrix(0, 3), Eigen::VectorXd(0), parameters).error().what, "no sample");
  data.y[4] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(solve_svr(data.x, data.y, parameters).error().what, "target 4 = nan, must be finite");
  data.y[4] = 0;
  data.x(2, 1) = std::numeric_limits<double>::infinity();
  EXPECT_EQ(solve_svr(data.x, data.y, parameters).error().what, "a sample has a value that is not finite");
}

TEST(Kernel, IsSymmetricAndPositiveSemidefinite) {
  for (const double sigma : {0.25, 1.0, 11.3}) {
    const Data data = smooth_data(120, 6, 15);
    const Eigen::MatrixXd kernel = gaussian_kernel(data.x, data.x, sigma);
    EXPECT_EQ(kernel, kernel.transpose());
    EXPECT_TRUE((kernel.diagonal().array() == 1).all());
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(kernel, Eigen::EigenvaluesOnly);
    EXPECT_GT(eigen.eigenvalues().minCoeff(), -1e-12);
  }
}

TEST(Kernel, MatchesDefinition) {
  const Data data = smooth_data(50, 6, 16);
  const Eigen::MatrixXd expected = kernel_by_definition(data.x, 1.7);
  EXPECT_LT((gaussian_kernel(data.x, data.x, 1.7) - expected).cwiseAbs().maxCoeff(), 1e-15);
  const SampleMatrix some = data.x.topRows(7);
  EXPECT_LT((gaussian_kernel(some, data.x, 1.7) - expected.topRows(7)).cwiseAbs().maxCoeff(), 1e-15);
}

std::string command_output(const std::string& command) {
  std::string text;
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return text;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) text.push_back(static_cast<char>(c));
  pclose(pipe);
  return text;
}

void write_data(const std::string& path, const SampleMatrix& x, const Eigen::VectorXd& y) {
  std::ofstream file(path);
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    file << fmt::format("{}", y[i]);
    for (Eigen::Index k = 0; k < x.cols(); ++k) file << fmt::format(" {}:{}", k + 1, x(i, k));
    file << '\n';
  }
}

TEST(Svr, MatchesObjectiveOfLibsvm) {
  if (std::system("command -v svm-train > /dev/null") != 0) GTEST_SKIP() << "svm-train is not installed";
  const auto folder = std::filesystem::temp_directory_path() / "gyrotherm-libsvm-objective";
  std::filesystem::create_directories(folder);
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    std::mt19937_64 generator(seed);
    std::normal_distribution<double> normal;
    // The solver uses working sets for the larger problems.
    const Eigen::Index n = seed % 3 == 0 ? 700 : 150;
    const auto x = SampleMatrix::NullaryExpr(n, 3, [&] { return normal(generator); }).eval();
    Eigen::VectorXd y(n);
    for (Eigen::Index i = 0; i < n; ++i) y[i] = std::sin(x(i, 0)) + 0.5 * x(i, 1) + 0.05 * normal(generator);
    const SvrParameters p{.C = std::exp2(static_cast<double>(seed % 7)), .sigma = 1.5, .epsilon = 0.02};
    const std::string data = folder / "data", model = folder / "model";
    write_data(data, x, y);
    const std::string output = command_output(fmt::format("svm-train -s 3 -t 2 -e 1e-6 -g {} -c {} -p {} {} {}",
                                                          0.5 / (p.sigma * p.sigma), p.C, p.epsilon, data, model));
    std::smatch match;
    ASSERT_TRUE(std::regex_search(output, match, std::regex("obj = (-?[0-9.]+)"))) << output;
    const double libsvm = std::stod(match[1]);
    const auto own = solve_svr(x, y, p, {.relative_gap = 1e-6});
    ASSERT_TRUE(own) << "seed " << seed << ": " << text(own.error());
    // LIBSVM computes its kernel in single precision and prints six decimals.
    EXPECT_NEAR(own->objective, libsvm, 2e-5 * std::abs(libsvm) + 1e-5) << "seed " << seed;
  }
  std::filesystem::remove_all(folder);
}

}  // namespace

}  // namespace gyrotherm::svm
