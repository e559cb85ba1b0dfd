// SPDX-License-Identifier: Apache-2.0
#include "sequencer/run/run_state_machine.hpp"

#include <gtest/gtest.h>

#include <random>
#include <set>

#include "tests/sequencer/profile/profiles.hpp"

namespace gyrotherm::run {
namespace {

using std::chrono::seconds;

const interlocks::RunLimits kLimits{};

RunInputs quiet_inputs() {
  RunInputs now;
  now.elapsed = kSecond;
  return now;
}
RunInputs inputs_with_reaction(interlocks::Reaction reaction, const std::string& cause = "the door is open") {
  auto now = quiet_inputs();
  now.demand = {reaction, cause};
  return now;
}
RunInputs inputs_with_command(OperatorCommand command) {
  auto now = quiet_inputs();
  now.request = OperatorRequest{command, "Ada"};
  return now;
}

RunStateMachine after(RunStateMachine machine, const RunInputs& now, int times = 1,
                      const interlocks::RunLimits& limits = kLimits) {
  for (int i = 0; i < times; ++i) machine = next(limits, machine, now);
  return machine;
}
RunState state_after(const RunStateMachine& machine, const RunInputs& now, int times = 1,
                     const interlocks::RunLimits& limits = kLimits) {
  return run_state(after(machine, now, times, limits));
}

const RunStateMachine kSuspended = Suspended{"the door is open", {}, {}};
const RunStateMachine kHeld = Held{"paused by Ada", {}};
const RunStateMachine kReturning = Returning{"the door is open", {}};

TEST(RunStateMachine, EndsSuspensionSomeTimeAfterCauseEnds) {
  const auto suspended = after(Execute{}, inputs_with_reaction(interlocks::Reaction::suspend));
  ASSERT_EQ(run_state(suspended), RunState::suspended);
  EXPECT_EQ(state_cause(suspended), "the door is open");
  EXPECT_EQ(state_after(suspended, quiet_inputs(), 9), RunState::suspended);
  EXPECT_EQ(state_after(suspended, quiet_inputs(), 10), RunState::execute);
  const auto flapping = after(after(suspended, quiet_inputs(), 9), inputs_with_reaction(interlocks::Reaction::suspend));
  EXPECT_EQ(state_after(flapping, quiet_inputs(), 9), RunState::suspended) << "the delay restarts";
}

TEST(RunStateMachine, EndsHoldOnlyByOperator) {
  const auto held = after(Execute{}, inputs_with_reaction(interlocks::Reaction::hold, "the machine slept"));
  ASSERT_EQ(run_state(held), RunState::held);
  EXPECT_EQ(state_after(held, quiet_inputs(), 10'000), RunState::held);
  EXPECT_EQ(state_after(held, inputs_with_command(OperatorCommand::resume)), RunState::execute);
  auto still = inputs_with_command(OperatorCommand::resume);
  still.demand = {interlocks::Reaction::hold, "the machine slept"};
  EXPECT_EQ(state_after(held, still), RunState::held) << "not while its cause is active";
}

TEST(RunStateMachine, PromptHoldsUnlessSevererCauseExists) {
  auto asked = quiet_inputs();
  asked.prompt = "the profile asks: switch the unit on";
  const auto held = after(Execute{}, asked);
  ASSERT_EQ(run_state(held), RunState::held);
  EXPECT_EQ(state_cause(held), asked.prompt);
  EXPECT_EQ(state_after(held, quiet_inputs(), 100), RunState::held);
  EXPECT_EQ(state_after(held, inputs_with_command(OperatorCommand::resume)), RunState::execute);
  auto grave = inputs_with_reaction(interlocks::Reaction::abort);
  grave.prompt = asked.prompt;
  EXPECT_EQ(state_after(Execute{}, grave), RunState::aborting);
  auto mild = inputs_with_reaction(interlocks::Reaction::suspend);
  mild.prompt = asked.prompt;
  EXPECT_EQ(state_after(Execute{}, mild), RunState::held);
  for (const auto& other : {kSuspended, kHeld}) {
    auto on = inputs_with_command(OperatorCommand::resume);
    on.prompt = asked.prompt;
    EXPECT_EQ(state_cause(after(other, on)), asked.prompt) << "it follows after the other cause has ended";
  }
  EXPECT_EQ(state_cause(after(kReturning, asked)), asked.prompt);
}

TEST(RunStateMachine, TreatsPauseAsNoFailure) {
  const auto paused = after(Execute{}, inputs_with_command(OperatorCommand::pause));
  EXPECT_EQ(run_state(paused), RunState::held);
  EXPECT_EQ(state_cause(paused), "paused by Ada");
  EXPECT_TRUE(std::get<Held>(paused).paused);
  EXPECT_FALSE(std::get<Held>(after(Execute{}, inputs_with_reaction(interlocks::Reaction::hold))).paused);
  EXPECT_EQ(run_state(after(kSuspended, inputs_with_command(OperatorCommand::pause))), RunState::held);
}

TEST(RunStateMachine, LimitsDurationOfWaits) {
  EXPECT_EQ(state_after(kSuspended, inputs_with_reaction(interlocks::Reaction::suspend), 7199), RunState::suspended);
  EXPECT_EQ(state_after(kSuspended, inputs_with_reaction(interlocks::Reaction::suspend), 7200), RunState::aborting);
  EXPECT_EQ(state_cause(after(kSuspended, inputs_with_reaction(interlocks::Reaction::suspend), 7200)),
            "suspended for 2 h 00 min 00 s: the door is open");
  EXPECT_EQ(state_after(kHeld, quiet_inputs(), 43'199), RunState::held);
  EXPECT_EQ(state_after(kHeld, quiet_inputs(), 43'200), RunState::aborting);
  auto away = quiet_inputs();
  away.in_place = false;
  EXPECT_EQ(state_after(kReturning, away, 14'399), RunState::suspended);
  EXPECT_EQ(state_after(kReturning, away, 14'400), RunState::aborting);
}

TEST(RunStateMachine, ReturnsToProfileWhenSetPointDiffers) {
  auto away = quiet_inputs();
  away.in_place = false;
  const auto returning = after(kSuspended, away, 10);
  ASSERT_TRUE(std::holds_alternative<Returning>(returning));
  EXPECT_EQ(run_state(returning), RunState::suspended);
  EXPECT_EQ(state_after(returning, quiet_inputs()), RunState::execute);
  auto resume = inputs_with_command(OperatorCommand::resume);
  resume.in_place = false;
  EXPECT_TRUE(std::holds_alternative<Returning>(after(kHeld, resume)));
}

TEST(RunStateMachine, LatchesAbortAndWaitsForChamber) {
  const auto aborting = after(Execute{}, inputs_with_reaction(interlocks::Reaction::abort, "too hot"));
  ASSERT_EQ(run_state(aborting), RunState::aborting);
  EXPECT_EQ(state_after(aborting, quiet_inputs(), 1'000'000), RunState::aborting) << "without a time limit";
  EXPECT_EQ(state_after(aborting, inputs_with_command(OperatorCommand::resume)), RunState::aborting);
  EXPECT_EQ(state_after(aborting, inputs_with_command(OperatorCommand::stop)), RunState::aborting);
  auto confirmed = quiet_inputs();
  confirmed.safe_confirmed = true;
  const auto aborted = after(aborting, confirmed);
  ASSERT_EQ(run_state(aborted), RunState::aborted);
  EXPECT_TRUE(is_over(aborted));
  EXPECT_EQ(state_cause(aborted), "too hot");
  for (const auto command : {OperatorCommand::resume, OperatorCommand::pause, OperatorCommand::stop})
    EXPECT_EQ(state_after(aborted, inputs_with_command(command)), RunState::aborted);
}

TEST(RunStateMachine, StopLeavesChamberAsRigSpecifies) {
  auto confirmed = quiet_inputs();
  confirmed.safe_confirmed = true;
  const auto stopping = after(Execute{}, inputs_with_command(OperatorCommand::stop));
  EXPECT_EQ(run_state(stopping), RunState::aborting);
  EXPECT_EQ(state_after(stopping, confirmed), RunState::stopped);
  interlocks::RunLimits limits;
  limits.on_stop = interlocks::OnStop::hold;
  for (const auto& from : {RunStateMachine(Execute{}), kSuspended, kHeld, kReturning})
    EXPECT_EQ(state_after(from, inputs_with_command(OperatorCommand::stop), 1, limits), RunState::stopped);
}

TEST(RunStateMachine, AbortsDuringStop) {
  const auto stopping = after(Execute{}, inputs_with_command(OperatorCommand::stop));
  auto confirmed = quiet_inputs();
  confirmed.safe_confirmed = true;
  EXPECT_EQ(state_after(after(stopping, inputs_with_command(OperatorCommand::abort)), confirmed), RunState::aborted);
  EXPECT_EQ(state_after(after(stopping, inputs_with_reaction(interlocks::Reaction::abort)), confirmed),
            RunState::aborted);
}

TEST(RunStateMachine, DistinguishesStopByOperatorFromAbort) {
  auto confirmed = quiet_inputs();
  confirmed.safe_confirmed = true;
  const auto stopping = after(Execute{}, inputs_with_command(OperatorCommand::stop));
  EXPECT_TRUE(is_stopped_by_operator(stopping));
  EXPECT_TRUE(is_stopped_by_operator(after(stopping, confirmed)));
  interlocks::RunLimits limits;
  limits.on_stop = interlocks::OnStop::hold;
  EXPECT_TRUE(is_stopped_by_operator(after(kHeld, inputs_with_command(OperatorCommand::stop), 1, limits)));
  for (const auto& aborting : {after(Execute{}, inputs_with_command(OperatorCommand::abort)),
                               after(Execute{}, inputs_with_reaction(interlocks::Reaction::abort, "too hot")),
                               after(stopping, inputs_with_command(OperatorCommand::abort)),
                               RunStateMachine(Aborting{"stopped by SIGTERM", {}, false})}) {
    EXPECT_FALSE(is_stopped_by_operator(aborting)) << state_cause(aborting);
    EXPECT_FALSE(is_stopped_by_operator(after(aborting, confirmed))) << state_cause(aborting);
  }
  for (const auto& state : {RunStateMachine(Execute{}), kSuspended, kHeld, kReturning, RunStateMachine(Completed{})})
    EXPECT_FALSE(is_stopped_by_operator(state));
}

TEST(RunStateMachine, AppliesMostSevereReaction) {
  auto all = inputs_with_reaction(interlocks::Reaction::abort, "too hot");
  all.request = OperatorRequest{OperatorCommand::pause, "Ada"};
  EXPECT_EQ(state_after(Execute{}, all), RunState::aborting);
  all = inputs_with_reaction(interlocks::Reaction::suspend);
  all.request = OperatorRequest{OperatorCommand::abort, "Ada"};
  EXPECT_EQ(state_after(kHeld, all), RunState::aborting);
  all.request = OperatorRequest{OperatorCommand::pause, "Ada"};
  EXPECT_EQ(state_after(Execute{}, all), RunState::held);
  EXPECT_EQ(state_after(kSuspended, inputs_with_reaction(interlocks::Reaction::hold)), RunState::held);
  EXPECT_EQ(state_after(kHeld, inputs_with_reaction(interlocks::Reaction::suspend)), RunState::held)
      << "a hold is more severe";
}

TEST(RunStateMachine, ContinuesAfterWarning) {
  EXPECT_EQ(state_after(Execute{}, inputs_with_reaction(interlocks::Reaction::warn)), RunState::execute);
}

TEST(RunStateMachine, RemainsComplete) {
  auto end = quiet_inputs();
  end.complete = true;
  const auto complete = after(Execute{}, end);
  EXPECT_EQ(run_state(complete), RunState::complete);
  EXPECT_EQ(state_after(complete, inputs_with_reaction(interlocks::Reaction::abort)), RunState::complete);
}

TEST(RunStateMachine, LimitsAlternateSuspensionsAndReturns) {
  interlocks::RunLimits limits;
  limits.longest_suspended = limits.longest_return = seconds(100);
  limits.resume_delay = seconds(5);
  for (const int period : {20, 50, 90}) {
    RunStateMachine machine = Execute{};
    int second = 0;
    for (; second < 1000 && run_state(machine) != RunState::aborting; ++second) {
      auto now = second % period < 10 ? inputs_with_reaction(interlocks::Reaction::suspend) : quiet_inputs();
      now.in_place = false;
      machine = next(limits, machine, now);
    }
    EXPECT_NEAR(second, 201, 3) << period;
    EXPECT_NE(state_cause(machine).find("away from the profile for "), std::string::npos) << state_cause(machine);
  }
}

/// A supply that must be switched on at the place of return makes the run wait there.
TEST(RunStateMachine, LimitsAlternateSuspensionsReturnsAndWaits) {
  interlocks::RunLimits limits;
  limits.longest_suspended = limits.longest_return = seconds(100);
  limits.resume_delay = seconds(5);
  RunStateMachine machine = Execute{};
  int second = 0, waits = 0;
  for (; second < 1000 && run_state(machine) != RunState::aborting; ++second) {
    const int phase = second % 30;
    auto now = phase < 10 ? inputs_with_reaction(interlocks::Reaction::suspend) : quiet_inputs();
    now.in_place = phase >= 20;
    if (now.in_place) now.wait = "supply off";
    machine = next(limits, machine, now);
    if (const auto* suspended = std::get_if<Suspended>(&machine)) waits += suspended->waits ? 1 : 0;
  }
  EXPECT_GT(waits, 0);
  EXPECT_NEAR(second, 201, 3);
}

TEST(RunStateMachine, CountsTimeAwayFromLastExecute) {
  interlocks::RunLimits limits;
  limits.longest_suspended = limits.longest_return = seconds(100);
  limits.resume_delay = seconds(5);
  RunStateMachine machine = Execute{};
  for (int second = 0; second < 1000; ++second) {
    auto now = second % 50 < 10 ? inputs_with_reaction(interlocks::Reaction::suspend) : quiet_inputs();
    now.in_place = second % 50 > 40;
    machine = next(limits, machine, now);
    ASSERT_NE(run_state(machine), RunState::aborting) << second << " " << state_cause(machine);
  }
}

/// Applies random events. Every transition is in the transition table, and every transition of the table occurs.
TEST(RunStateMachine, FollowsTransitionTableOnly) {
  std::mt19937_64 random(20261122);
  const auto draw = [&](int sides) { return static_cast<int>(random() % static_cast<unsigned>(sides)); };
  std::set<std::pair<RunState, RunState>> walked;
  interlocks::RunLimits limits;
  limits.longest_suspended = limits.longest_held = limits.longest_return = seconds(30);
  for (int run = 0; run < 2000; ++run) {
    limits.on_stop = run % 2 == 0 ? interlocks::OnStop::hold : interlocks::OnStop::safe;
    RunStateMachine machine = Execute{};
    for (int i = 0; i < 60; ++i) {
      auto now = inputs_with_reaction(draw(3) == 0 ? static_cast<interlocks::Reaction>(draw(draw(8) == 0 ? 5 : 4))
                                                   : interlocks::Reaction::go_on);
      if (draw(12) == 0) now.request = OperatorRequest{static_cast<OperatorCommand>(draw(4)), "Ada"};
      now.in_place = draw(3) != 0;
      now.safe_confirmed = draw(6) == 0;
      now.complete = draw(40) == 0;
      const auto from = run_state(machine);
      machine = next(limits, machine, now);
      ASSERT_TRUE(may_follow(from, run_state(machine))) << name(from) << " → " << name(run_state(machine));
      walked.insert({from, run_state(machine)});
    }
  }
  for (int from = 0; from <= static_cast<int>(RunState::complete); ++from)
    for (int to = 0; to <= static_cast<int>(RunState::complete); ++to) {
      const std::pair edge{static_cast<RunState>(from), static_cast<RunState>(to)};
      EXPECT_EQ(walked.contains(edge), may_follow(edge.first, edge.second))
          << name(edge.first) << " → " << name(edge.second);
    }
}

TEST(RunStateMachine, CommandsNothingAfterEnd) {
  for (const auto state : {RunState::aborted, RunState::stopped, RunState::complete}) EXPECT_FALSE(may_command(state));
  for (const auto state : {RunState::execute, RunState::suspended, RunState::held, RunState::aborting})
    EXPECT_TRUE(may_command(state));
}

}  // namespace
}  // namespace gyrotherm::run
