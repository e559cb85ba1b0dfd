// SPDX-License-Identifier: Apache-2.0
/// Proof tests of the watchdog with a real guard, a virtual chamber and a virtual relay over Modbus TCP.
#include "sequencer/prove/make_safe_proof.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>
#include <thread>
#include <tuple>
#include <utility>

#include "core/tcp_listener.hpp"
#include "sequencer/watchdog/safe_state_file.hpp"
#include "tests/sequencer/prove/prove_bench.hpp"
#include "tests/support/folder.hpp"

namespace gyrotherm::prove {
namespace {

constexpr const char* kRelay =
    "[safe.also]\nline = \"tcp://127.0.0.1:1\"\ncoil = 3\nafter = \"2 s\"\n[safe]\nobserve = \"0 s\"\n\n";
constexpr const char* kTextRelay =
    "[safe.also]\nline = \"tcp://127.0.0.1:1\"\ntell_open = \"OPEN\"\ntell_close = \"CLOSE\"\nask = \"POS?\"\n"
    "is_open = \"O\"\nis_closed = \"C\"\nafter = \"2 s\"\n[safe]\nobserve = \"1 s\"\n\n";

rig::RigFile relay_rig(const std::string& relay = kRelay) {
  auto file = read_limiter_rig(relay);
  return file;
}

/// Kills the guard of a record.
void kill_guards(const std::string& record) {
  for (const auto& process : list_folder("/proc")) {
    std::ifstream file(process / "cmdline");
    std::string program, option, path;
    for (auto* word : {&program, &option, &path}) std::getline(file, *word, '\0');
    if (option == "--guard" && path == record) ::kill(std::stoi(process.filename().string()), SIGKILL);
  }
}

/// Returns a chamber on a line without an instrument.
std::unique_ptr<drivers::Chamber> connect_nowhere() {
  auto rig = relay_rig();
  rig.chamber_line = "tcp://127.0.0.1:1";
  return connect_chamber(rig);
}

/// The guard has left its confirmed trace already.
void expect_confirmed(const std::string& record) {
  const auto trace = watchdog::read_trace(record);
  ASSERT_TRUE(trace && *trace);
  EXPECT_TRUE((*trace)->confirmed) << describe(**trace);
}

TEST(TestSetPoint, IsTheFartherOneWithinTheLimits) {
  auto rig = read_limiter_rig();
  const std::tuple<double, double, double, double> cases[] = {
      {18, 24, 21, 24}, {17, 24, 21, 17}, {-40, 80, 20, 25}, {-40, 22, 20, 15},
      {19, 22, 20, 22}, {20, 80, 20, 25}, {-40, 20, 20, 15}, {20, 21, 20, 21},
  };
  for (const auto& [lowest, highest, safe, expected] : cases) {
    rig.chamber_limits.lowest = {lowest};
    rig.chamber_limits.highest = {highest};
    rig.safe_set_point = {safe};
    const auto found = test_set_point(rig);
    ASSERT_TRUE(found) << text(found.error());
    EXPECT_EQ(*found, Celsius{expected}) << lowest << " " << highest << " " << safe;
  }
}

TEST(TestSetPoint, IsRefusedIfDifferenceCannotBeSeen) {
  auto rig = read_limiter_rig();
  rig.safe_set_point = {20};
  rig.chamber_limits.lowest = {19.99};
  rig.chamber_limits.highest = {20.01};
  const auto found = test_set_point(rig);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().kind, FaultKind::usage);
}

class GuardProof : public ::testing::Test {
 protected:
  void TearDown() override { kill_guards(record); }

  const tests::TestFolder folder;
  const std::string record = folder / "child.db";
  ProveBench bench{relay_rig(), true};
  const GuardTimes quick{.safe = std::chrono::seconds(3),
                         .confirm = std::chrono::seconds(5),
                         .relay = std::chrono::seconds(2),
                         .dead_line = std::chrono::seconds(1)};
};

TEST_F(GuardProof, PassesAndRestoresEveryRegister) {
  const auto before = bench.registers();
  const auto found =
      ChamberSnapshot::take(bench.rig.chamber_map, *connect_registers(bench.rig), *connect_chamber(bench.rig)).value();
  const auto result = prove_make_safe(bench.rig, record, bench.environment());
  EXPECT_EQ(result.verdict, ProofVerdict::passed) << result.cause;
  EXPECT_NE(bench.registers(), before) << "the chamber is on at its safe set point";
  const auto restored = found.restore(*connect_registers(bench.rig), *connect_chamber(bench.rig));
  EXPECT_TRUE(restored) << text(restored.error());
  EXPECT_EQ(bench.registers(), before);
}

TEST_F(GuardProof, IsNotTestedWithoutVisibleSetPoint) {
  bench.rig.chamber_limits.lowest = bench.rig.chamber_limits.highest = bench.rig.safe_set_point;
  EXPECT_EQ(prove_make_safe(bench.rig, record, bench.environment(), quick).verdict, ProofVerdict::not_tested);
  EXPECT_EQ(prove_line(bench.rig, record, bench.environment(), quick).verdict, ProofVerdict::not_tested);
  EXPECT_TRUE(watchdog::was_released(record)) << "no program drove the chamber";
}

/// Kills the first child of this thread that appears.
class ChildKiller {
 public:
  explicit ChildKiller(int signal)
      : thread_([signal, file = "/proc/self/task/" + std::to_string(::gettid()) + "/children"] {
          for (int i = 0; i < 5000; ++i, std::this_thread::sleep_for(std::chrono::milliseconds(1))) {
            pid_t child = 0;
            if (std::ifstream(file) >> child) return void(::kill(child, signal));
          }
        }) {}
  ~ChildKiller() { thread_.join(); }

 private:
  std::thread thread_;
};

TEST(DrivenChildProcess, ReportsHowItEnded) {
  const auto listener = listen_on_tcp("127.0.0.1", 0, 16).value();  // accepts connections and stays silent
  auto rig = read_limiter_rig();
  rig.simulated = false;
  rig.chamber_line = "tcp://127.0.0.1:" + std::to_string(listening_port(listener));
  const tests::TestFolder folder;
  for (const auto& [signal, words] :
       {std::pair(SIGKILL, "was ended by signal 9"), {SIGSEGV, "was ended by signal 11"}}) {
    const ChildKiller killer(signal);
    const auto child = DrivenChild::start(rig, folder / "child.db", {25});
    ASSERT_FALSE(child);
    EXPECT_NE(child.error().what.find(words), std::string::npos) << child.error().what;
  }
}

TEST_F(GuardProof, FindsGuardThatDoesNotAct) {
  auto environment = bench.environment();
  environment.say = [&](const std::string& words) {
    if (words.find("program drives the chamber") != std::string::npos) kill_guards(record);
  };
  const auto result = prove_make_safe(bench.rig, record, environment, quick);
  EXPECT_EQ(result.verdict, ProofVerdict::failed);
  EXPECT_NE(result.cause.find("was not safe 3 s after the program was killed: set point 25 °C"), std::string::npos)
      << result.cause;
  EXPECT_NE(result.cause.find("the guard left no trace: it did not act"), std::string::npos) << result.cause;
}

TEST_F(GuardProof, OpensRelayOnDeadLineAndClosesIt) {
  const auto result = prove_line(bench.rig, record, bench.environment());
  EXPECT_EQ(result.verdict, ProofVerdict::passed) << result.cause;
  EXPECT_EQ(relay_refusal_reason(bench.rig, "rig.toml"), "");
  const auto trace = watchdog::read_trace(record);
  ASSERT_TRUE(trace && *trace);
  EXPECT_NE((*trace)->relay.find("was opened at "), std::string::npos) << describe(**trace);
  EXPECT_NE(describe(**trace).find("--close-relay"), std::string::npos) << describe(**trace);
}

/// The guard reaches the chamber through the forwarder, which must not end before the guard has done its work.
TEST_F(GuardProof, WaitsForGuardWhenProgramIsNotSeenToDrive) {
  auto environment = bench.environment();
  environment.connect = [&] { return connect_nowhere(); };
  auto times = quick;
  times.show = std::chrono::seconds(1);
  const auto result = prove_line(bench.rig, record, environment, times);
  EXPECT_EQ(result.verdict, ProofVerdict::failed);
  EXPECT_NE(result.cause.find("the chamber did not show its set point"), std::string::npos) << result.cause;
  expect_confirmed(record);
  EXPECT_EQ(bench.chamber().set_point, bench.rig.safe_set_point);
  EXPECT_EQ(relay_refusal_reason(bench.rig, "rig.toml"), "") << "the relay of a healthy chamber stays closed";
}

TEST_F(GuardProof, WaitsForGuardWhenChamberIsNotSeenSafe) {
  ProveBench other(relay_rig("[safe]\nobserve = \"6 s\"\n\n"), true);
  auto environment = other.environment();
  bool is_cut = false;
  environment.say = [&](const std::string& words) { is_cut = is_cut || words.find("line cut") != std::string::npos; };
  environment.connect = [&] { return is_cut ? connect_nowhere() : connect_chamber(other.rig); };
  auto times = quick;
  times.confirm = std::chrono::seconds(20);
  const auto result = prove_line(other.rig, record, environment, times);
  EXPECT_EQ(result.verdict, ProofVerdict::failed);
  EXPECT_NE(result.cause, "");
  expect_confirmed(record);
  EXPECT_EQ(other.chamber().set_point, other.rig.safe_set_point);
}

TEST_F(GuardProof, WaitsForNoGuardWhenNoneWasArmed) {
  auto unreachable = bench.rig;
  unreachable.chamber_line = "tcp://127.0.0.1:1";
  EXPECT_EQ(prove_line(unreachable, record, bench.environment(), quick).verdict, ProofVerdict::failed);
  EXPECT_TRUE(watchdog::was_released(record));
}

TEST_F(GuardProof, FindsRelayThatSticks) {
  bench.instruments->stick_relay(true);
  const auto relay = prove_relay(bench.rig, bench.environment());
  EXPECT_EQ(relay.verdict, ProofVerdict::failed);
  EXPECT_NE(relay.cause.find("did not open"), std::string::npos) << relay.cause;
  EXPECT_NE(relay.cause.find("it sticks"), std::string::npos) << relay.cause;
  const auto times = GuardTimes{.relay = std::chrono::seconds(4)};
  const auto line = prove_line(bench.rig, record, bench.environment(), times);
  EXPECT_EQ(line.verdict, ProofVerdict::failed);
  EXPECT_NE(line.cause.find("the guard did not open the relay: it reads closed"), std::string::npos) << line.cause;
  EXPECT_NE(line.cause.find("it sticks"), std::string::npos) << line.cause;
  EXPECT_EQ(bench.chamber().set_point, bench.rig.safe_set_point) << "the guard still made the chamber safe";
}

/// Chambers whose set point can only be written.
class UnreadableSetPoint : public ::testing::TestWithParam<const char*> {
 protected:
  void TearDown() override { kill_guards(record); }

  const tests::TestFolder folder;
  const std::string record = folder / "child.db";
  ProveBench bench{read_rig_with_map(std::string(GYROTHERM_SOURCE_DIR "/profiles/chambers/") + GetParam() + ".toml"),
                   true};
};

TEST_P(UnreadableSetPoint, PassesMakeSafe) {
  ASSERT_TRUE(std::isnan(bench.chamber().set_point.value));
  const auto result = prove_make_safe(bench.rig, record, bench.environment());
  EXPECT_EQ(result.verdict, ProofVerdict::passed) << result.cause;
  const auto is_stated = [](const auto& one) {
    return one.value.find("set point unreadable, air") != std::string::npos;
  };
  EXPECT_TRUE(std::ranges::any_of(result.readings, is_stated));
}

TEST_P(UnreadableSetPoint, FailsMakeSafeWithoutGuard) {
  auto environment = bench.environment();
  environment.say = [&](const std::string& words) {
    if (words.find("program drives the chamber") != std::string::npos) kill_guards(record);
  };
  const GuardTimes times{.safe = std::chrono::seconds(2), .confirm = std::chrono::seconds(2)};
  EXPECT_EQ(prove_make_safe(bench.rig, record, environment, times).verdict, ProofVerdict::failed);
}

TEST_P(UnreadableSetPoint, IsStatedAsLost) {
  const auto [registers, chamber] = connect_with_registers(bench.rig);
  const auto found = ChamberSnapshot::take(bench.rig.chamber_map, *registers, *chamber).value();
  EXPECT_EQ(refusal_reason(found.state()), "");
  EXPECT_NE(found.describe_lost_state({20}).find("left at the safe set point of 20 °C"), std::string::npos);
  auto running = found.state();
  running.activity = ChamberActivity::running;
  EXPECT_NE(refusal_reason(running).find("switch it off first"), std::string::npos) << refusal_reason(running);
  running.set_point = {20};
  EXPECT_EQ(refusal_reason(running), "");
}

INSTANTIATE_TEST_SUITE_P(Maps, UnreadableSetPoint, ::testing::Values("yinhe", "umc1200"),
                         [](const auto& one) { return std::string(one.param); });

TEST_F(GuardProof, PassesLineWithUnreadableSetPoint) {
  ProveBench other(read_rig_with_map(GYROTHERM_SOURCE_DIR "/profiles/chambers/yinhe.toml"), true);
  const auto result = prove_line(other.rig, record, other.environment(), {.dead_line = std::chrono::seconds(1)});
  EXPECT_EQ(result.verdict, ProofVerdict::passed) << result.cause;
}

TEST_F(GuardProof, ReadableSetPointIsNotLost) {
  const auto [registers, chamber] = connect_with_registers(bench.rig);
  const auto found = ChamberSnapshot::take(bench.rig.chamber_map, *registers, *chamber).value();
  EXPECT_EQ(found.describe_lost_state({20}), "");
}

TEST_F(GuardProof, ProvesTextRelay) {
  ProveBench other(relay_rig(kTextRelay), true);
  const auto result = prove_relay(other.rig, other.environment());
  EXPECT_EQ(result.verdict, ProofVerdict::passed) << result.cause;
  other.instruments->stick_relay(true);
  EXPECT_NE(prove_relay(other.rig, other.environment()).cause.find("it sticks"), std::string::npos);
}

TEST_F(GuardProof, ReportsOpenRelay) {
  const auto relay = drivers::make_safety_relay(*bench.rig.safe_also);
  ASSERT_TRUE(relay->command(drivers::RelayPosition::open));
  const auto open = relay_refusal_reason(bench.rig, "rigs/lab.toml");
  EXPECT_NE(open.find("is OPEN"), std::string::npos) << open;
  EXPECT_NE(open.find("prove rigs/lab.toml --close-relay"), std::string::npos) << open;
  EXPECT_EQ(prove_relay(bench.rig, bench.environment()).cause, "the relay is open already");
  bench.instruments.reset();
  EXPECT_NE(relay_refusal_reason(bench.rig, "rig.toml").find("cannot be read"), std::string::npos);
}

}  // namespace
}  // namespace gyrotherm::prove
