/// LIBSVM as an oracle where it converges: its objective is ours.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <regex>
#include <string>

#include "analysis/svm/svr.hpp"

namespace gyrotherm {
namespace {

std::string output_of(const std::string& command) {
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

TEST(Svr, ReachesTheObjectiveOfLibsvmWhereThatConverges) {
  if (std::system("command -v svm-train > /dev/null") != 0) GTEST_SKIP() << "svm-train is not installed";
  const auto folder = std::filesystem::temp_directory_path() / "gyrotherm-libsvm-objective";
  std::filesystem::create_directories(folder);
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    std::mt19937_64 generator(seed);
    std::normal_distribution<double> normal;
    const Eigen::Index n = seed % 3 == 0 ? 700 : 150;  // the larger ones go through working sets
    const auto x = SampleMatrix::NullaryExpr(n, 3, [&] { return normal(generator); }).eval();
    Eigen::VectorXd y(n);
    for (Eigen::Index i = 0; i < n; ++i) y[i] = std::sin(x(i, 0)) + 0.5 * x(i, 1) + 0.05 * normal(generator);
    const SvrParameters p{.C = std::exp2(static_cast<double>(seed % 7)), .sigma = 1.5, .epsilon = 0.02};
    const std::string data = folder / "data", model = folder / "model";
    write_data(data, x, y);
    const std::string said = output_of(fmt::format("svm-train -s 3 -t 2 -e 1e-6 -g {} -c {} -p {} {} {}",
                                                   0.5 / (p.sigma * p.sigma), p.C, p.epsilon, data, model));
    std::smatch match;
    ASSERT_TRUE(std::regex_search(said, match, std::regex("obj = (-?[0-9.]+)"))) << said;
    const double theirs = std::stod(match[1]);
    const auto ours = solve_svr(x, y, p, {.relative_gap = 1e-6});
    ASSERT_TRUE(ours) << "seed " << seed << ": " << text(ours.error());
    // Theirs is of a kernel in single precision, and printed to six decimals.
    EXPECT_NEAR(ours->objective, theirs, 2e-5 * std::abs(theirs) + 1e-5) << "seed " << seed;
  }
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace gyrotherm
