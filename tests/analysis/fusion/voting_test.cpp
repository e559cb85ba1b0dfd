// SPDX-License-Identifier: Apache-2.0
#include "analysis/fusion/voting.hpp"

#include "analysis/fusion/rate_fusion.hpp"
#include "analysis/fusion/rest.hpp"
#include "tests/analysis/fusion/thermal_body.hpp"

namespace gyrotherm::fusion {
namespace {

TEST(ThermometerParity, HasStatedFalseAlarmProbability) {
  const ThermometerParity parity = learnt_thermometer_parity();
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
  // The spread is learnt from 4000 rows with a standard error of 1.1 %. Thermometer noise is 15 % of the spread.
  EXPECT_NEAR(alarms / (kEach * 1.0 * kSeeds), 0.01, 4 * relative_frequency_std(0.01, kEach * kSeeds) + 1e-4);
}

TEST(ThermometerParity, IdentifiesFaultyThermometer) {
  const ThermometerParity parity = learnt_thermometer_parity();
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

TEST(ThermometerParity, IgnoresCommonModesOutsideRecord) {
  const ThermometerParity parity = learnt_thermometer_parity();
  Draws draws(7);
  const Eigen::RowVectorXd warm = temperatures(draws, 0) + Eigen::RowVectorXd::Constant(kThermometers, 100);
  EXPECT_FALSE(examine(parity.test(), parity.vector(warm)).fault) << "outside the range of the record";
}

TEST(ThermometerParity, RejectsInsufficientRecord) {
  Draws draws(1);
  Eigen::MatrixXd record(200, 4);
  for (Eigen::Index i = 0; i < 200; ++i) record.row(i) = draws.normal(4);
  const std::vector<std::string> names = {"A", "B", "C", "D"};
  const Eigen::VectorXd uncertainty = Eigen::VectorXd::Constant(4, 0.01);
  const auto refuses = [&](const auto& parity, const char* reason) {
    return !parity && parity.error().kind == FaultKind::usage && text(parity.error()).find(reason) != std::string::npos;
  };
  EXPECT_TRUE(learn_thermometer_parity(record, names, uncertainty, 2));
  EXPECT_TRUE(
      refuses(learn_thermometer_parity(record, names, uncertainty, 3), "at least 2 more thermometers than modes"));
  EXPECT_TRUE(refuses(learn_thermometer_parity(record, names, uncertainty, 0), "0 common modes"));
  EXPECT_TRUE(refuses(learn_thermometer_parity(record, {"A"}, uncertainty, 2), "1 names"));
  EXPECT_TRUE(refuses(learn_thermometer_parity(record, names, 0 * uncertainty, 2), "not above 0"));
  record.topRows(170).col(1).setConstant(std::nan(""));
  EXPECT_TRUE(refuses(learn_thermometer_parity(record, names, uncertainty, 2), "30 rows are complete"));
}

constexpr double kMean_deg_per_h = 0.002;  ///< noise of a 100 s mean

/// Four axes with random sensitivities to eight thermometers. Their expected root sum of squares per axis is 0.33 °/h
/// per K.
struct Fixture {
  explicit Fixture(bool at_rest) {
    geometry = valid_geometry(tetrad_axes(kMean_deg_per_h));
    voters.axes = geometry.names;
    voters.thermometers = learnt_thermometer_parity();
    Draws draws(55);
    voters.sensitivity_deg_per_h_per_k = Eigen::MatrixXd(4, kThermometers);
    for (Eigen::Index j = 0; j < kThermometers; ++j)
      voters.sensitivity_deg_per_h_per_k.col(j) = 0.33 / std::sqrt(kThermometers) * draws.normal(4);
    const Attitude attitude{.tilt_std_deg = 0.002, .azimuth_std_deg = 0.005, .latitude_deg = 48};
    const BiasPrior prior{Eigen::Vector4d::Zero(), 4e-6 * Eigen::Matrix4d::Identity()};
    spread = geometry.covariance;
    voters.whitening = compute_gains(geometry).parity;
    if (!at_rest) return;
    const RestTest rest = *rest_test(geometry, attitude, prior);
    voters.whitening = rest.whitening;
    spread = (rest.whitening.transpose() * rest.whitening).inverse();
  }
  /// Returns the verdict for a fault of `size` (°/h or K) in one candidate. Candidates 0 … 3 are axes, the following
  /// ones thermometers, and −1 means no fault.
  [[nodiscard]] Verdict verdict_for(Draws& draws, Eigen::Index candidate, double size) const {
    Eigen::VectorXd departures = draws.correlated_normal(spread);
    Eigen::RowVectorXd row = temperatures(draws, kOwn_k);
    if (candidate >= 4) {
      departures -= size * voters.sensitivity_deg_per_h_per_k.col(candidate - 4);
      row(candidate - 4) += size;
    } else if (candidate >= 0) {
      departures(candidate) += size;
    }
    return vote(voters, departures, row);
  }
  Geometry geometry;
  Voters voters;
  Eigen::MatrixXd spread;
};

constexpr int kVotes = 50;

struct Tally {
  /// Verdicts of the expected kind.
  int kind{};
  /// Verdicts of the expected kind that name the faulty candidate.
  int who{};
  /// All verdicts.
  int count{};
};

Tally tally(const Fixture& fixture, Eigen::Index candidate, double size, VerdictKind kind) {
  Tally tally;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    Draws draws(static_cast<std::uint64_t>(seed));
    for (int n = 0; n < kVotes; ++n) {
      const Verdict verdict = fixture.verdict_for(draws, candidate, size);
      ++tally.count;
      tally.kind += verdict.kind == kind ? 1 : 0;
      tally.who += verdict.kind == kind && candidate >= 0 &&
                           verdict.who == joint_test(fixture.voters).candidates[static_cast<std::size_t>(candidate)]
                       ? 1
                       : 0;
    }
  }
  return tally;
}

TEST(Voting, AgreesWithoutFault) {
  for (const bool at_rest : {true, false}) {
    const Tally accord = tally(Fixture(at_rest), -1, 0, VerdictKind::accord);
    EXPECT_EQ(accord.kind, accord.count);
  }
}

TEST(Voting, DistinguishesHopsFromBrokenThermometersAtRest) {
  const Fixture fixture(true);
  for (Eigen::Index axis = 0; axis < 4; ++axis) {
    const Tally hop = tally(fixture, axis, -0.05, VerdictKind::gyro_hop);
    EXPECT_GE(hop.who, 0.99 * hop.count) << axis;
  }
  for (Eigen::Index thermometer = 4; thermometer < 4 + kThermometers; ++thermometer) {
    const Tally broken = tally(fixture, thermometer, 0.3, VerdictKind::broken_thermometer);
    EXPECT_GE(broken.who, 0.99 * broken.count) << thermometer;
  }
}

TEST(Voting, DetectsHopWithoutAxisForFourMovingAxes) {
  const Fixture fixture(false);
  for (Eigen::Index axis = 0; axis < 4; ++axis) {
    const double size =
        detectable_size(joint_test(fixture.voters), axis, 0.9999, TestOptions{}.false_alarm_probability);
    EXPECT_LT(size, 0.07);
    const Tally hop = tally(fixture, axis, size, VerdictKind::gyro_hop);
    EXPECT_GE(hop.kind, 0.98 * hop.count) << axis;
    EXPECT_EQ(hop.who, 0);
    EXPECT_EQ(tally(fixture, axis, size, VerdictKind::broken_thermometer).kind, 0) << "other verdicts are undecided";
  }
  const Tally broken = tally(fixture, 6, 0.3, VerdictKind::broken_thermometer);
  EXPECT_GE(broken.who, 0.99 * broken.count);
}

TEST(Voting, StatesReason) {
  Draws draws(3);
  const Fixture resting(true), moving(false);
  const Verdict hop = resting.verdict_for(draws, 1, 0.05);
  EXPECT_EQ(hop.who, "y");
  EXPECT_NEAR(hop.size, 0.05, 5 * hop.size_std);
  EXPECT_NE(hop.reason.find("y is off by"), std::string::npos) << hop.reason;
  EXPECT_NE(hop.reason.find("°/h (k = 1)"), std::string::npos) << hop.reason;
  EXPECT_NE(hop.reason.find("axes inconsistent"), std::string::npos) << hop.reason;
  EXPECT_NE(hop.reason.find("thermometers consistent"), std::string::npos) << hop.reason;
  const Verdict broken = resting.verdict_for(draws, 6, 0.3);
  EXPECT_NE(broken.reason.find("C is off by"), std::string::npos) << broken.reason;
  EXPECT_NE(broken.reason.find("thermometers inconsistent"), std::string::npos) << broken.reason;
  const Verdict ambiguous = moving.verdict_for(draws, 1, 0.05);
  EXPECT_EQ(ambiguous.who, "");
  EXPECT_NE(ambiguous.reason.find("not distinguishable"), std::string::npos) << ambiguous.reason;
  const Verdict accord = resting.verdict_for(draws, -1, 0);
  EXPECT_EQ(accord.reason.find("axes consistent"), 0u) << accord.reason;
}

TEST(Voting, IsUndecidedForSimultaneousHopAndBrokenThermometer) {
  const Fixture fixture(true);
  Draws draws(4);
  Eigen::VectorXd departures =
      draws.correlated_normal(fixture.spread) - 0.3 * fixture.voters.sensitivity_deg_per_h_per_k.col(2);
  departures(0) += 0.08;
  Eigen::RowVectorXd row = temperatures(draws, kOwn_k);
  row(2) += 0.3;
  const Verdict verdict = vote(fixture.voters, departures, row);
  EXPECT_EQ(verdict.kind, VerdictKind::undecided);
  EXPECT_NE(verdict.reason.find("no single fault explains it"), std::string::npos) << verdict.reason;
}

TEST(Voting, IdentifiesBrokenThermometerThatAffectsNoPrediction) {
  Fixture fixture(true);
  fixture.voters.sensitivity_deg_per_h_per_k.col(3).setZero();
  Draws draws(5);
  const Verdict verdict = fixture.verdict_for(draws, 7, 0.3);
  EXPECT_EQ(verdict.kind, VerdictKind::broken_thermometer);
  EXPECT_EQ(verdict.who, "D");
  EXPECT_FALSE(verdict.of_axes.fault);
}

}  // namespace
}  // namespace gyrotherm::fusion
