// SPDX-License-Identifier: Apache-2.0
/// Residuals of the experiment's three models on an unseen run, on the default rig at full length, compared with stored
/// values. A loss of a fifth is detected.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <iterator>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/apps/gyrotherm/program.hpp"

namespace gyrotherm::app {
namespace {

struct Oracle {
  const char* inputs;
  double std_deg_per_h, rmse_deg_per_h;
};

/// Results of the small swarm (`--quick`), which tunes in seconds; measured with version 0.1.0.
struct GyroOracle {
  int seed;
  Oracle models[3];
};
constexpr GyroOracle kOracles[] = {
    {1, {{"three-point", 0.00686, 0.00695}, {"multi-point", 0.00206, 0.00217}, {"multi-point-t", 0.00212, 0.00237}}},
    {2, {{"three-point", 0.00656, 0.00680}, {"multi-point", 0.00201, 0.00278}, {"multi-point-t", 0.00200, 0.00266}}}};
constexpr double kLoss = 1.15;

void record(const char* profile, int seed, const std::string& out) {
  const auto ran = gyrotherm_with(
      fmt::format("run profiles/{}.toml --rig profiles/rigs/virtual.toml --seed {} --out {}", profile, seed, out));
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
}

class DefaultRigOracle : public testing::TestWithParam<GyroOracle> {};

TEST_P(DefaultRigOracle, KeepsAccuracyOnUnseenRun) {
  const Folder folder;
  const auto rate = folder / "ramp.db", random = folder / "random.db", model = folder / "model.json";
  ASSERT_NO_FATAL_FAILURE(record("qualification", GetParam().seed, rate));
  ASSERT_NO_FATAL_FAILURE(record("random", GetParam().seed, random));
  for (const Oracle& oracle : GetParam().models) {
    SCOPED_TRACE(oracle.inputs);
    const auto trained =
        gyrotherm_with(fmt::format("train {} --quick --inputs {} --out {} --force", rate, oracle.inputs, model));
    ASSERT_EQ(trained.exit_code, 0) << trained.err;
    const auto verified = gyrotherm_with(fmt::format("verify --json {} {}", model, random));
    ASSERT_EQ(verified.exit_code, 0) << verified.err;
    const auto left = nlohmann::json::parse(verified.out)["compensated"];
    EXPECT_LT(left["std_deg_per_h"].get<double>(), kLoss * oracle.std_deg_per_h);
    EXPECT_LT(left["rmse_deg_per_h"].get<double>(), kLoss * oracle.rmse_deg_per_h);
    EXPECT_GT(left["std_deg_per_h"].get<double>(), oracle.std_deg_per_h / kLoss)
        << "better than the stored value: store the new one";
  }
}

#ifdef GYROTHERM_NIGHTLY
constexpr std::size_t kGyros = std::size(kOracles);
#else
constexpr std::size_t kGyros = 1;
#endif
INSTANTIATE_TEST_SUITE_P(Seeds, DefaultRigOracle, testing::ValuesIn(kOracles, kOracles + kGyros),
                         [](const auto& gyro) { return fmt::format("seed{}", gyro.param.seed); });

}  // namespace
}  // namespace gyrotherm::app
