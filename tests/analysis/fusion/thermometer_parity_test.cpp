// SPDX-License-Identifier: Apache-2.0
#include "analysis/fusion/thermometer_parity.hpp"

#include "tests/analysis/fusion/thermal_body.hpp"

namespace gyrotherm::fusion {
namespace {

TEST(ThermometerParity, IsInAccordAsOftenAsItSays) {
  const ThermometerParity parity = learnt_accord();
  constexpr int kEach = 2000;
  int alarms = 0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    Draws draws(static_cast<std::uint64_t>(seed));
    for (int n = 0; n < kEach; ++n)
      alarms +=
          examine(parity.test(), parity.vector(temperatures(draws, kOwn_k)), {.false_alarm_probability = 0.01}).fault
              ? 1
              : 0;
  }
  // The spread was learnt from 4000 rows: known to 1.1 %, of 15 % of which it is made.
  EXPECT_NEAR(alarms / (kEach * 1.0 * kSeeds), 0.01, 4 * spread_of_share(0.01, kEach * kSeeds) + 1e-4);
}

TEST(ThermometerParity, NamesTheThermometerThatIsOff) {
  const ThermometerParity parity = learnt_accord();
  int named = 0;
  double squares = 0;
  constexpr int kEach = 200;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    Draws draws(static_cast<std::uint64_t>(seed));
    for (int n = 0; n < kEach; ++n) {
      Eigen::RowVectorXd row = temperatures(draws, kOwn_k);
      row(n % kThermometers) += 0.3;
      const Finding finding = examine(parity.test(), parity.vector(row));
      if (!finding.isolation || finding.isolation->candidate != n % kThermometers) continue;
      ++named;
      squares += std::pow((finding.isolation->size - 0.3) / finding.isolation->size_std, 2);
    }
  }
  EXPECT_GT(named, 0.99 * kEach * kSeeds);
  EXPECT_NEAR(squares / named, 1, 0.1);
}

TEST(ThermometerParity, DoesNotMindHowTheBodyMoves) {
  const ThermometerParity parity = learnt_accord();
  Draws draws(7);
  const Eigen::RowVectorXd warm = temperatures(draws, 0) + Eigen::RowVectorXd::Constant(kThermometers, 100);
  EXPECT_FALSE(examine(parity.test(), parity.vector(warm)).fault) << "further than the record";
}

TEST(ThermometerParity, RefusesWhatIsNotEnough) {
  Draws draws(1);
  Eigen::MatrixXd record(200, 4);
  for (Eigen::Index i = 0; i < 200; ++i) record.row(i) = draws.normal(4);
  const std::vector<std::string> names = {"A", "B", "C", "D"};
  const Eigen::VectorXd uncertainty = Eigen::VectorXd::Constant(4, 0.01);
  const auto says = [&](const auto& parity, const char* what) {
    return !parity && parity.error().kind == FaultKind::usage && text(parity.error()).find(what) != std::string::npos;
  };
  EXPECT_TRUE(thermometer_parity_of(record, names, uncertainty, 2));
  EXPECT_TRUE(says(thermometer_parity_of(record, names, uncertainty, 3), "2 more are needed"));
  EXPECT_TRUE(says(thermometer_parity_of(record, names, uncertainty, 0), "0 ways"));
  EXPECT_TRUE(says(thermometer_parity_of(record, {"A"}, uncertainty, 2), "1 names"));
  EXPECT_TRUE(says(thermometer_parity_of(record, names, 0 * uncertainty, 2), "not above 0"));
  record.topRows(170).col(1).setConstant(std::nan(""));
  EXPECT_TRUE(says(thermometer_parity_of(record, names, uncertainty, 2), "30 rows are known"));
}

}  // namespace
}  // namespace gyrotherm::fusion
