// SPDX-License-Identifier: Apache-2.0
/// The proof test of a limiter over Modbus TCP, with every way in which a limiter fails.
#include "sequencer/prove/limiter_proof.hpp"

#include <gtest/gtest.h>

#include <tuple>
#include <utility>

#include "tests/sequencer/prove/prove_bench.hpp"

namespace gyrotherm::prove {
namespace {

class LimiterProof : public ::testing::Test {
 protected:
  ProofResult prove(simulator::LimiterFault fault = simulator::LimiterFault::none) {
    return prove(fault, bench.environment());
  }
  ProofResult prove(simulator::LimiterFault fault, const DrillEnvironment& environment) {
    bench.instruments->change_limiter([&](auto& limiter) { limiter.inject(fault); });
    before = bench.registers();
    const auto plan = plan_limiter_proof(bench.rig, bench.chamber().air);
    EXPECT_TRUE(plan) << text(plan.error());
    EXPECT_EQ(plan->at, Celsius{30});
    return prove_limiter(*plan, bench.guarded(), environment);
  }
  /// Carries out `action` when the test reports `words`.
  DrillEnvironment environment_with(const std::string& words, std::function<void()> action) {
    auto environment = bench.environment();
    environment.say = [words, action = std::move(action)](const std::string& said) {
      if (said.find(words) != std::string::npos) action();
    };
    return environment;
  }
  /// The chamber is at its safe set point, and the guard was released.
  void expect_safe() {
    EXPECT_EQ(bench.chamber().set_point, bench.rig.safe_set_point);
    EXPECT_EQ(bench.guards_begun, 1);
    EXPECT_EQ(bench.guards_ended, 1);
  }

  ProveBench bench{read_limiter_rig()};
  std::string before;
};

TEST_F(LimiterProof, PassesWhenLimiterTripsAndStaysTripped) {
  const auto result = prove();
  EXPECT_EQ(result.verdict, ProofVerdict::passed) << result.cause;
  EXPECT_EQ(bench.questions.size(), 2u);
  EXPECT_NE(bench.questions.at(0).find("30 °C"), std::string::npos) << bench.questions[0];
  EXPECT_GT(result.duration_s, 120) << "two minutes of watching";
  EXPECT_GE(result.readings.size(), 5u);
  expect_safe();
}

TEST_F(LimiterProof, FindsLimiterThatDoesNotTrip) {
  const auto result = prove(simulator::LimiterFault::never_trips);
  EXPECT_EQ(result.verdict, ProofVerdict::failed);
  EXPECT_EQ(result.cause.find("the limiter did not trip: it was set to 30 °C and the air reached 36."), 0u)
      << result.cause;
  EXPECT_LT(bench.chamber().air.value, 37) << "the heating ended six kelvins above the setting";
  expect_safe();
}

TEST_F(LimiterProof, FindsLimiterThatTripsLate) {
  const auto result = prove(simulator::LimiterFault::trips_late);
  EXPECT_EQ(result.verdict, ProofVerdict::failed);
  EXPECT_EQ(result.cause.find("the limiter tripped late: at 3"), 0u) << result.cause;
  expect_safe();
}

TEST_F(LimiterProof, FindsLimiterThatTripsEarly) {
  const auto result = prove(simulator::LimiterFault::trips_early);
  EXPECT_EQ(result.verdict, ProofVerdict::failed);
  EXPECT_EQ(result.cause.find("the limiter tripped early: at 2"), 0u) << result.cause;
  expect_safe();
}

TEST_F(LimiterProof, FindsLimiterThatResetsItself) {
  const auto result = prove(simulator::LimiterFault::resets_itself);
  EXPECT_EQ(result.verdict, ProofVerdict::failed);
  EXPECT_EQ(result.cause.find("the limiter reset itself "), 0u) << result.cause;
  expect_safe();
}

TEST_F(LimiterProof, SeesTripByFallingAirWithoutAlarm) {
  const auto result = prove(simulator::LimiterFault::shows_no_alarm);
  EXPECT_EQ(result.verdict, ProofVerdict::passed) << result.cause;
  bool seen = false;
  for (const auto& reading : result.readings)
    seen = seen || reading.what == "trip, seen by air that falls below the set point";
  EXPECT_TRUE(seen);
}

TEST_F(LimiterProof, FindsAlarmThatRemainsAfterReset) {
  bench.resets = false;
  const auto result = prove();
  EXPECT_EQ(result.verdict, ProofVerdict::failed);
  EXPECT_EQ(result.cause, "the alarm remains after the operator reset the limiter");
}

TEST_F(LimiterProof, FindsLimiterThatWasNotSetLow) {
  bench.low_c = 80;
  EXPECT_EQ(prove().verdict, ProofVerdict::failed);
  expect_safe();
}

TEST_F(LimiterProof, SendsNothingWhenPersonRefuses) {
  bench.obeys = false;
  const auto result = prove();
  EXPECT_EQ(result.verdict, ProofVerdict::interrupted);
  EXPECT_EQ(bench.registers(), before);
  EXPECT_EQ(bench.guards_begun, 0);
}

TEST_F(LimiterProof, MakesChamberSafeWhenInterruptedInEachPhase) {
  for (const auto seconds : {1, 30, 100, 150}) {
    ProveBench other(read_limiter_rig());
    other.interrupted_after = std::chrono::seconds(seconds);
    const auto plan = plan_limiter_proof(other.rig, other.chamber().air).value();
    const auto result = prove_limiter(plan, other.guarded(), other.environment());
    EXPECT_EQ(result.verdict, ProofVerdict::interrupted) << seconds << result.cause;
    EXPECT_EQ(other.chamber().set_point, other.rig.safe_set_point) << seconds;
    EXPECT_EQ(other.guards_ended, 1) << seconds;
    EXPECT_EQ(other.questions.size(), 2u) << "the limiter is set back, too";
  }
}

/// An older pass of the limiter must not stay valid because the operator typed stop after the failure.
TEST_F(LimiterProof, KeepsFailureWhenOperatorDoesNotConfirmReset) {
  using simulator::LimiterFault;
  const std::pair<LimiterFault, const char*> cases[] = {{LimiterFault::never_trips, "the limiter did not trip"},
                                                        {LimiterFault::trips_late, "the limiter tripped late"},
                                                        {LimiterFault::trips_early, "the limiter tripped early"},
                                                        {LimiterFault::resets_itself, "the limiter reset itself"}};
  for (const auto& [fault, cause] : cases) {
    ProveBench other(read_limiter_rig());
    other.instruments->change_limiter([&](auto& limiter) { limiter.inject(fault); });
    auto environment = other.environment();
    environment.ask = [&, ask = environment.ask](const std::string& question) {
      other.obeys = other.questions.empty();
      return ask(question);
    };
    const auto plan = plan_limiter_proof(other.rig, other.chamber().air).value();
    const auto result = prove_limiter(plan, other.guarded(), environment);
    EXPECT_EQ(result.verdict, ProofVerdict::failed) << cause;
    EXPECT_EQ(result.cause.find(cause), 0u) << result.cause;
    EXPECT_NE(result.cause.find("did not confirm that the limiter was set back"), std::string::npos) << result.cause;
  }
}

TEST_F(LimiterProof, IsInterruptedWhenOperatorDoesNotConfirmResetAfterGoodTrip) {
  auto environment = bench.environment();
  environment.ask = [&, ask = environment.ask](const std::string& question) {
    bench.obeys = bench.questions.empty();
    return ask(question);
  };
  EXPECT_EQ(prove(simulator::LimiterFault::none, environment).verdict, ProofVerdict::interrupted);
}

TEST_F(LimiterProof, KeepsLateTripWhenInterruptedAfterIt) {
  const auto stop = [&] { bench.interrupted_after = Duration::zero(); };
  const auto late = prove(simulator::LimiterFault::trips_late, environment_with("trip, seen by", stop));
  EXPECT_EQ(late.verdict, ProofVerdict::failed);
  EXPECT_EQ(late.cause.find("the limiter tripped late"), 0u) << late.cause;
  EXPECT_NE(late.cause.find("; the operator stopped the test"), std::string::npos) << late.cause;
}

TEST_F(LimiterProof, IsInterruptedAfterTripInBand) {
  const auto stop = [&] { bench.interrupted_after = Duration::zero(); };
  const auto result = prove(simulator::LimiterFault::none, environment_with("trip, seen by", stop));
  EXPECT_EQ(result.verdict, ProofVerdict::interrupted);
  EXPECT_EQ(result.cause, "the operator stopped the test");
}

TEST_F(LimiterProof, NamesOnlyCauseWhenChamberDiesAfterGoodTrip) {
  auto environment = environment_with("still tripped", [&] {
    bench.rig.chamber_line = "tcp://127.0.0.1:1";
    bench.instruments.reset();
  });
  environment.wait = [&](Duration time) {
    if (bench.instruments) bench.wait(time);
  };
  const auto result = prove(simulator::LimiterFault::none, environment);
  EXPECT_EQ(result.verdict, ProofVerdict::failed);
  EXPECT_EQ(result.cause, "the chamber does not show its safe set point");
}

TEST_F(LimiterProof, DescribesAirThatSettlesNearSetting) {
  const std::tuple<double, const char*> cases[] = {
      {28, "the air did not reach the limiter's setting of 30 °C in 20 min 00 s: 2"},
      {31, "the air did not exceed the limiter's setting of 30 °C by 3 K in 20 min 00 s: 3"},
      {35, "the limiter did not trip: it was set to 30 °C and the air reached 3"}};
  for (const auto& [set_point, cause] : cases) {
    ProveBench other(read_limiter_rig());
    other.instruments->change_limiter([](auto& limiter) { limiter.inject(simulator::LimiterFault::never_trips); });
    auto plan = plan_limiter_proof(other.rig, other.chamber().air).value();
    plan.set_point = {set_point};
    plan.within = std::chrono::minutes(20);
    const auto result = prove_limiter(plan, other.guarded(), other.environment());
    EXPECT_EQ(result.verdict, ProofVerdict::failed);
    EXPECT_EQ(result.cause.find(cause), 0u) << result.cause;
  }
}

TEST_F(LimiterProof, LeavesDeadChamberToItsGuard) {
  const auto plan = plan_limiter_proof(bench.rig, bench.chamber().air).value();
  auto environment = bench.environment();
  int seconds = 0;
  environment.wait = [&](Duration time) {
    if (++seconds < 20) return bench.wait(time);
    bench.rig.chamber_line = "tcp://127.0.0.1:1";
    bench.instruments.reset();
  };
  const auto result = prove_limiter(plan, bench.guarded(), environment);
  EXPECT_EQ(result.verdict, ProofVerdict::failed) << result.cause;
  EXPECT_NE(result.cause.find("does not show its safe set point"), std::string::npos) << result.cause;
  EXPECT_EQ(bench.guards_ended, 0) << "the guard is still armed";
}

TEST(LimiterPlan, RefusesRigWithoutRoomForTest) {
  auto rig = read_limiter_rig();
  EXPECT_TRUE(plan_limiter_proof(rig, {22}));
  rig.proof.limiter_at = Celsius{25};
  EXPECT_FALSE(plan_limiter_proof(rig, {22})) << "too near to the air";
  rig.proof.limiter_at = Celsius{65};
  EXPECT_FALSE(plan_limiter_proof(rig, {22})) << "the set point is above the chamber's limit";
  rig.proof.limiter_at = Celsius{40};
  rig.limits.air_highest = {45};
  EXPECT_FALSE(plan_limiter_proof(rig, {22})) << "an interlock of a run would have acted";
}

}  // namespace
}  // namespace gyrotherm::prove
