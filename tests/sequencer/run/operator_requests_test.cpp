// SPDX-License-Identifier: Apache-2.0
#include "sequencer/run/operator_requests.hpp"

#include <gtest/gtest.h>

#include <array>

namespace gyrotherm::run {
namespace {

constexpr std::array kAll{OperatorCommand::resume, OperatorCommand::pause, OperatorCommand::stop,
                          OperatorCommand::abort};

/// Returns the command that the tick carries out after these requests, each made in that state if it had no objection.
std::optional<OperatorCommand> command_after(RunState state, const std::vector<OperatorCommand>& commands) {
  OperatorRequests requests;
  for (const auto command : commands)
    if (requests.refusal_reason(state, command).empty()) requests.add({command, name(command)});
  const auto taken = requests.take();
  return taken.carried_out ? std::optional(taken.carried_out->command) : std::nullopt;
}

TEST(OperatorRequests, CarryOutAcknowledgedAbortDespiteOtherRequests) {
  for (const auto state : {RunState::execute, RunState::suspended, RunState::held, RunState::aborting})
    for (const auto other : kAll) {
      EXPECT_EQ(command_after(state, {OperatorCommand::abort, other}), OperatorCommand::abort) << name(other);
      EXPECT_EQ(command_after(state, {other, OperatorCommand::abort}), OperatorCommand::abort) << name(other);
    }
}

TEST(OperatorRequests, CarryOutMostSevereRequestInAnyOrder) {
  EXPECT_EQ(command_after(RunState::execute, {OperatorCommand::stop, OperatorCommand::pause}), OperatorCommand::stop);
  EXPECT_EQ(command_after(RunState::execute, {OperatorCommand::pause, OperatorCommand::stop}), OperatorCommand::stop);
  EXPECT_EQ(command_after(RunState::execute, {OperatorCommand::pause, OperatorCommand::resume}),
            OperatorCommand::pause);
  EXPECT_EQ(command_after(RunState::held, {OperatorCommand::resume, OperatorCommand::pause}), OperatorCommand::pause);
  EXPECT_EQ(command_after(RunState::held, {OperatorCommand::resume}), OperatorCommand::resume);
}

TEST(OperatorRequests, RefuseMilderRequestAndNamePrecedingOne) {
  OperatorRequests requests;
  requests.add({OperatorCommand::abort, "ada (uid 1000)"});
  for (const auto milder : {OperatorCommand::resume, OperatorCommand::pause, OperatorCommand::stop})
    EXPECT_EQ(requests.refusal_reason(RunState::execute, milder),
              "abort by ada (uid 1000) has priority in the same second");
  EXPECT_EQ(requests.refusal_reason(RunState::execute, OperatorCommand::abort), "") << "the promise is kept";
}

TEST(OperatorRequests, CarryOutFirstOfEquallySevereRequests) {
  OperatorRequests requests;
  requests.add({OperatorCommand::resume, "ada"});
  requests.add({OperatorCommand::pause, "bob"});
  requests.add({OperatorCommand::pause, "eve"});
  const auto taken = requests.take();
  ASSERT_TRUE(taken.carried_out);
  EXPECT_EQ(taken.carried_out->who, "bob");
  ASSERT_EQ(taken.dropped.size(), 2u);
  EXPECT_EQ(taken.dropped[0].who, "ada");
  EXPECT_EQ(taken.dropped[1].who, "eve");
  EXPECT_EQ(requests.find_next(), nullptr);
}

TEST(OperatorRequests, RefuseRequestsThatStateForbids) {
  const OperatorRequests none;
  EXPECT_EQ(none.refusal_reason(RunState::execute, OperatorCommand::resume), "the run is not held: execute");
  EXPECT_EQ(none.refusal_reason(RunState::held, OperatorCommand::pause), "the run is held already");
  EXPECT_EQ(none.refusal_reason(RunState::aborting, OperatorCommand::stop), "the chamber is being made safe");
  for (const auto state : {RunState::aborted, RunState::stopped, RunState::complete})
    for (const auto command : kAll) EXPECT_FALSE(none.refusal_reason(state, command).empty()) << name(state);
}

TEST(OperatorRequests, EndRunOnlyByStopOrAbort) {
  for (const auto command : kAll) {
    OperatorRequests requests;
    requests.add({command, "ada"});
    EXPECT_EQ(requests.has_end_request(), command >= OperatorCommand::stop) << name(command);
  }
  EXPECT_FALSE(OperatorRequests().has_end_request());
}

}  // namespace
}  // namespace gyrotherm::run
