// SPDX-License-Identifier: Apache-2.0
/// Run on a real rig: it is guarded, owns the chamber, and accepts requests of other programs.
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>

#include "acquisition/record/record.hpp"
#include "acquisition/record/status_file.hpp"
#include "core/file.hpp"
#include "sequencer/control/control_socket.hpp"
#include "tests/apps/gyrotherm/real_rig.hpp"

namespace gyrotherm::app {
namespace {

constexpr double kSafe = 20;    ///< °C, rig
constexpr double kWarm = 21.5;  ///< °C, profile
constexpr double kLimit = 20;   ///< s until the chamber is safe

/// Finds the guard of a record and its children by their command lines.
std::vector<pid_t> find_guards(const std::string& record) {
  std::vector<pid_t> guards;
  for (const auto& process : list_folder("/proc")) {
    std::ifstream file(process / "cmdline");
    std::string program, option, path;
    for (auto* word : {&program, &option, &path}) std::getline(file, *word, '\0');
    if (option == "--guard" && path == record) guards.push_back(std::stoi(process.filename().string()));
  }
  return guards;
}

/// Kills the guard of a record, so that the test does not wait for it.
void end_guards(const std::string& record) {
  for (const auto pid : find_guards(record)) ::kill(pid, SIGKILL);
}

class GuardedRun : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!installed("mbpoll")) GTEST_SKIP() << "mbpoll is not installed";
    ASSERT_TRUE(laboratory.serves());
  }
  [[nodiscard]] std::vector<std::string> warm_run(const std::string& out) const {
    return {"run", "tests/profiles/ten-minutes-warm.toml", "--rig", laboratory.rig(), "--out", out, "--json"};
  }

  const Folder folder;
  const RealLaboratory laboratory{folder / ""};
  const std::string record = folder / "run.db";
};

TEST_F(GuardedRun, LeavesChamberSafeWithinTwentySecondsWhenKilled) {
  Background run(warm_run(record), folder / "log");
  ASSERT_TRUE(run.wait_for("\"acknowledged\": 1}", 60)) << run.output();
  ASSERT_TRUE(laboratory.wait_for_set_point(kWarm, 60));
  EXPECT_TRUE(std::filesystem::exists(record + ".safe-state"));
  run.signal(SIGKILL);
  EXPECT_TRUE(laboratory.wait_for_set_point(kSafe, kLimit)) << run.output();
  EXPECT_EQ(run.wait(), -SIGKILL);
  for (int i = 0; i < 600 && std::filesystem::exists(record + ".safe-state"); ++i) shell("sleep 0.1");
  EXPECT_FALSE(std::filesystem::exists(record + ".safe-state")) << "the chamber has confirmed it";
  const auto status = gyrotherm_with("status " + record);
  EXPECT_NE(status.out.find("made safe by the guard at "), std::string::npos) << status.out << status.err;
}

/// A folder in the way of the trace refuses the write, as a full disk does.
TEST_F(GuardedRun, KeepsEvidenceUntilDiskAcceptsIt) {
  Background run(warm_run(record), folder / "log");
  ASSERT_TRUE(run.wait_for("\"acknowledged\": 1}", 60)) << run.output();
  std::filesystem::create_directory(record + ".made-safe");
  run.signal(SIGKILL);
  EXPECT_TRUE(laboratory.wait_for_set_point(kSafe, kLimit)) << run.output();
  EXPECT_EQ(run.wait(), -SIGKILL);
  const std::string waits = "no file could be written next to the record: ";
  for (int i = 0; i < 1200 && run.output().find(waits) == std::string::npos; ++i) shell("sleep 0.1");
  EXPECT_NE(run.output().find(waits), std::string::npos) << run.output();
  EXPECT_TRUE(std::filesystem::exists(record + ".safe-state"));
  EXPECT_FALSE(find_guards(record).empty()) << "the guard waits for the disk";
  std::filesystem::remove(record + ".made-safe");
  for (int i = 0; i < 600 && std::filesystem::exists(record + ".safe-state"); ++i) shell("sleep 0.1");
  EXPECT_FALSE(std::filesystem::exists(record + ".safe-state"));
  const auto status = gyrotherm_with("status " + record);
  EXPECT_NE(status.out.find("made safe by the guard at "), std::string::npos) << status.out << status.err;
}

TEST_F(GuardedRun, EndsManualModeAndObservesAirWhenKilled) {
  Background run(warm_run(record), folder / "log");
  ASSERT_TRUE(run.wait_for("\"acknowledged\": 1}", 60)) << run.output();
  ASSERT_TRUE(laboratory.wait_for_set_point(kWarm, 60));
  const auto mode = [&](const std::string& write) {
    return shell("mbpoll -m tcp -a 1 -0 -1 -q -t 4 -r 105 -c 1 -p " + laboratory.chamber_port() + " 127.0.0.1 " + write)
        .out;
  };
  const std::string manual = "2", on = "[105]: \t1";
  (void)shell("mbpoll -m tcp -a 1 -0 -q -t 4 -r 105 -p " + laboratory.chamber_port() + " 127.0.0.1 " + manual);
  EXPECT_NE(mode("").find("[105]: \t2"), std::string::npos) << mode("");
  run.signal(SIGKILL);
  EXPECT_TRUE(laboratory.wait_for_set_point(kSafe, kLimit)) << run.output();
  for (int i = 0; i < 600 && std::filesystem::exists(record + ".safe-state"); ++i) shell("sleep 0.1");
  EXPECT_FALSE(std::filesystem::exists(record + ".safe-state")) << "set point, mode and air are shown";
  EXPECT_NE(mode("").find(on), std::string::npos) << mode("");
  const auto status = gyrotherm_with("status " + record);
  EXPECT_NE(status.out.find("set point read back; mode running; air "), std::string::npos) << status.out << status.err;
}

/// A full disk may lose the last rows of an abort. Then the record looks like that of a killed program, but the chamber
/// was released.
TEST_F(GuardedRun, AsksBeforeResumeIfRecordLacksEnd) {
  Background run(warm_run(record), folder / "log");
  ASSERT_TRUE(run.wait_for("\"acknowledged\": 1}", 60)) << run.output();
  end_guards(record);
  run.signal(SIGKILL);
  EXPECT_EQ(run.wait(), -SIGKILL);
  end_guards(record);
  ASSERT_TRUE(std::filesystem::exists(record + ".safe-state"));
  auto last = record::read_status_file(record).value();
  last.overview.faults_now = {"the relay of [safe.also] was opened"};
  ASSERT_TRUE(record::write_status(last));
  const auto killed = gyrotherm_with("status " + record);
  EXPECT_NE(killed.out.find("  last fault: the relay of [safe.also] was opened\n"), std::string::npos) << killed.out;
  EXPECT_NE(killed.out.find("WARNING: no guard is left"), std::string::npos) << killed.out << killed.err;
  EXPECT_NE(killed.out.find("\"gyrotherm resume\" continues the run"), std::string::npos) << killed.out;
  EXPECT_EQ(killed.out.find("ended by"), std::string::npos) << killed.out;
  std::filesystem::remove(record + ".safe-state");
  const auto released = gyrotherm_with("status " + record);
  EXPECT_NE(released.out.find("resume " + record + " --accept\""), std::string::npos) << released.out << released.err;
  EXPECT_EQ(released.out.find("WARNING"), std::string::npos) << released.out;
  const auto resumed = gyrotherm_with("resume " + record);
  EXPECT_EQ(resumed.exit_code, 5) << resumed.out << resumed.err;
  EXPECT_NE(resumed.err.find("the record does not state how the run ended"), std::string::npos) << resumed.err;
}

TEST_F(GuardedRun, MarksHeldRunForOperator) {
  const auto mark = record + ".ask-operator";
  const auto exists = [&](bool wanted) {
    for (int i = 0; i < 100 && std::filesystem::exists(mark) != wanted; ++i) shell("sleep 0.1");
    return std::filesystem::exists(mark);
  };
  Background run(warm_run(record), folder / "log");
  ASSERT_TRUE(run.wait_for("\"acknowledged\": 1}", 60)) << run.output();
  EXPECT_FALSE(exists(false));
  EXPECT_EQ(gyrotherm_with("tell " + record + " pause").exit_code, 0);
  EXPECT_TRUE(exists(true));
  EXPECT_EQ(gyrotherm_with("tell " + record + " resume").exit_code, 0);
  EXPECT_FALSE(exists(false));
  end_guards(record);
  run.signal(SIGKILL);
  EXPECT_EQ(run.wait(), -SIGKILL);
  end_guards(record);
  std::ofstream(mark).close();  // as if the last rows, which state a pause, had not been written
  const auto status = gyrotherm_with("status " + record);
  EXPECT_NE(status.out.find("\"gyrotherm resume " + record + " --accept\""), std::string::npos) << status.out;
  const auto resumed = gyrotherm_with("resume " + record);
  EXPECT_EQ(resumed.exit_code, 5) << resumed.out << resumed.err;
}

TEST_F(GuardedRun, KeepsSetPointWithoutGuardAfterOrderlyStop) {
  Background run(warm_run(record), folder / "log");
  ASSERT_TRUE(run.wait_for("\"acknowledged\": 1}", 60)) << run.output();
  ASSERT_TRUE(laboratory.wait_for_set_point(kWarm, 60));
  Background second(warm_run(folder / "second.db"), folder / "second.log");
  EXPECT_EQ(second.wait(), 3) << "one program drives a chamber";
  EXPECT_NE(second.output().find("driven by another program: process "), std::string::npos) << second.output();
  EXPECT_FALSE(std::filesystem::exists(folder / "second.db"));
  run.signal(SIGINT);
  EXPECT_EQ(run.wait(), 5) << run.output();
  EXPECT_FALSE(std::filesystem::exists(record + ".safe-state"));
  EXPECT_EQ(shell("sleep 2").exit_code, 0);
  EXPECT_EQ(laboratory.set_point(), kWarm);
  EXPECT_FALSE(std::filesystem::exists(record + ".made-safe"));
}

/// The guard of a dead run still watches the air when a later run drives the chamber for some seconds and ends.
TEST_F(GuardedRun, LeavesChamberToLaterRunThatEndedInOrder) {
  const auto observing = folder / "observing.toml";
  const auto text_of_rig = read_text_file(laboratory.rig()).value();
  std::ofstream(observing) << std::regex_replace(text_of_rig, std::regex("observe = \"[^\"]*\""),
                                                 "observe = \"10 min\"");
  ASSERT_NE(read_text_file(observing).value().find("10 min"), std::string::npos) << "the guard remains for a while";
  Background run({"run", "tests/profiles/ten-minutes-warm.toml", "--rig", observing, "--out", record, "--json"},
                 folder / "log");
  ASSERT_TRUE(run.wait_for("\"acknowledged\": 1}", 60)) << run.output();
  ASSERT_TRUE(laboratory.wait_for_set_point(kWarm, 60));
  run.signal(SIGKILL);
  ASSERT_TRUE(laboratory.wait_for_set_point(kSafe, kLimit)) << run.output();
  ASSERT_FALSE(find_guards(record).empty());
  const auto guarded = gyrotherm_with("status " + record);
  EXPECT_NE(guarded.out.find("guard: process "), std::string::npos) << guarded.out << guarded.err;
  const auto later = folder / "later.db";
  const auto refused = gyrotherm_with("go " + observing + " 500 --out " + later);
  EXPECT_NE(refused.exit_code, 0);
  EXPECT_FALSE(find_guards(record).empty()) << "a run that did not begin relieves no guard";
  const auto went = gyrotherm_with("go " + observing + " 21 --for '3 s' --out " + later);
  EXPECT_EQ(went.exit_code, 0) << went.err;
  EXPECT_NE(went.err.find("which guards the chamber for " + record), std::string::npos) << went.err;
  for (int i = 0; i < 100 && !find_guards(record).empty(); ++i) shell("sleep 0.1");
  EXPECT_TRUE(find_guards(record).empty());
  EXPECT_EQ(laboratory.set_point(), 21);
  EXPECT_FALSE(std::filesystem::exists(record + ".safe-state"));
  const auto status = gyrotherm_with("status " + record);
  EXPECT_NE(status.out.find("has taken the chamber over"), std::string::npos) << status.out << status.err;
  EXPECT_EQ(status.out.find("guard: process "), std::string::npos) << status.out;
  const auto kept = record::read_record(later);
  ASSERT_TRUE(kept) << text(kept.error());
  std::string events;
  for (const auto& stored : kept->events) events += stored.event.text + "\n";
  EXPECT_NE(events.find("takes the chamber over from process "), std::string::npos) << events;
}

TEST_F(GuardedRun, IsMadeSafeBySigterm) {
  for (const auto* before : {"", "pause", "note looked"}) {
    const auto path = folder / ("run" + std::to_string(std::string(before).size()) + ".db");
    Background run(warm_run(path), path + ".log");
    ASSERT_TRUE(run.wait_for("\"acknowledged\": 1}", 60)) << run.output();
    ASSERT_TRUE(laboratory.wait_for_set_point(kWarm, 60));
    if (*before != '\0') {
      EXPECT_EQ(gyrotherm_with("tell " + path + " " + before).exit_code, 0);
    }
    run.signal(SIGTERM);
    EXPECT_TRUE(laboratory.wait_for_set_point(kSafe, kLimit)) << run.output();
    EXPECT_EQ(run.wait(), 5) << run.output();
    EXPECT_NE(run.output().find("the guard remains"), std::string::npos) << run.output();
    const auto status = gyrotherm_with("status --json " + path);
    EXPECT_NE(status.out.find("\"finished\":false"), std::string::npos) << status.out << status.err;
    end_guards(path);  // frees the chamber
  }
}

TEST_F(GuardedRun, HoldsSetPointAfterSigtermWhenOnStopIsHold) {
  const auto holding = folder / "holding.toml";
  auto text = read_text_file(laboratory.rig()).value();
  const auto safe = text.find("[safe]");
  if (safe == std::string::npos)
    text += "\n[safe]\non_stop = \"hold\"\n";
  else
    text.insert(text.find('\n', safe) + 1, "on_stop = \"hold\"\n");
  std::ofstream(holding) << text;
  Background run({"run", "tests/profiles/ten-minutes-warm.toml", "--rig", holding, "--out", record, "--json"},
                 folder / "log");
  ASSERT_TRUE(run.wait_for("\"acknowledged\": 1}", 60)) << run.output();
  ASSERT_TRUE(laboratory.wait_for_set_point(kWarm, 60));
  run.signal(SIGTERM);
  EXPECT_EQ(run.wait(), 5) << run.output();
  EXPECT_FALSE(std::filesystem::exists(record + ".safe-state"));
  EXPECT_EQ(laboratory.set_point(), kWarm);
}

TEST_F(GuardedRun, IsMadeSafeBySigtermWithoutGuard) {
  Background run(warm_run(record), folder / "log");
  ASSERT_TRUE(run.wait_for("\"acknowledged\": 1}", 60)) << run.output();
  ASSERT_TRUE(laboratory.wait_for_set_point(kWarm, 60));
  ASSERT_FALSE(find_guards(record).empty());
  end_guards(record);
  run.signal(SIGTERM);
  EXPECT_TRUE(laboratory.wait_for_set_point(kSafe, kLimit)) << run.output();
  const auto ended = run.wait();
  EXPECT_TRUE(ended == 5 || ended == 6) << ended << run.output();
  end_guards(record);
}

TEST_F(GuardedRun, AnswersAndRecordsRequests) {
  const auto tell = [&](const std::string& words) { return gyrotherm_with("tell " + record + " " + words); };
  EXPECT_EQ(tell("pause").exit_code, 4) << "the record does not exist yet";
  Background run(warm_run(record), folder / "log");
  ASSERT_TRUE(run.wait_for("\"acknowledged\": 1}", 60)) << run.output();
  EXPECT_EQ(tell("note 'looked at the cable'").exit_code, 0);
  const auto refused = tell("resume");
  EXPECT_EQ(refused.exit_code, 3);
  EXPECT_NE(refused.err.find("the run is not held"), std::string::npos) << refused.err;
  EXPECT_EQ(tell("pause").exit_code, 0);
  std::string status;
  for (int i = 0; i < 600 && status.find("\"state\":\"held\"") == std::string::npos; ++i)
    status = shell("sleep 0.1; gyrotherm status --json " + record).out;
  EXPECT_NE(status.find("\"state\":\"held\""), std::string::npos) << status;
  EXPECT_EQ(tell("resume").exit_code, 0);
  EXPECT_EQ(tell("abort").exit_code, 0);
  EXPECT_EQ(run.wait(), 6) << run.output();
  EXPECT_EQ(laboratory.set_point(), kSafe);
  EXPECT_FALSE(std::filesystem::exists(record + ".safe-state"));
  EXPECT_EQ(tell("note late").exit_code, 2);
  const auto kept = record::read_record(record);
  ASSERT_TRUE(kept) << text(kept.error());
  std::string events;
  for (const auto& stored : kept->events) events += stored.event.text + "\n";
  for (const auto* part : {"): looked at the cable", "): resume, refused", "pause", "abort", "(uid "})
    EXPECT_NE(events.find(part), std::string::npos) << part << " in\n" << events;
}

TEST_F(GuardedRun, WaitsForAnswerWhenProfileAsks) {
  Background run({"run", "tests/profiles/asks.toml", "--rig", laboratory.rig(), "--out", record}, folder / "log");
  std::string status;
  for (int i = 0; i < 600 && status.find("the profile asks: look at the cable") == std::string::npos; ++i)
    status = shell("sleep 0.1; gyrotherm status --json " + record).out;
  EXPECT_NE(status.find("the profile asks: look at the cable"), std::string::npos) << status << run.output();
  const auto answered = gyrotherm_with("tell " + record + " resume 'it hangs free'");
  EXPECT_EQ(answered.exit_code, 0) << answered.err;
  EXPECT_EQ(run.wait(), 0) << run.output();
  const auto kept = record::read_record(record);
  ASSERT_TRUE(kept) << text(kept.error());
  std::string events;
  for (const auto& stored : kept->events) events += stored.event.text + "\n";
  for (const auto* part : {"held: the profile asks: look at the cable", "): it hangs free", "profile complete"})
    EXPECT_NE(events.find(part), std::string::npos) << part << " in\n" << events;
}

TEST_F(GuardedRun, HoldSurvivesInterruptInSameSecond) {
  Background run(warm_run(record), folder / "log");
  ASSERT_TRUE(run.wait_for("\"acknowledged\": 1}", 60)) << run.output();
  const auto answer = gyrotherm_with("tell " + record + " pause");
  run.signal(SIGINT);
  EXPECT_EQ(answer.exit_code, 0) << answer.err;
  EXPECT_EQ(run.wait(), 5) << run.output();
  const auto kept = record::read_record(record);
  ASSERT_TRUE(kept) << text(kept.error());
  EXPECT_EQ(kept->state.back(), RunState::held);
  const auto resumed = gyrotherm_with("resume " + record);
  EXPECT_EQ(resumed.exit_code, 5) << resumed.err;
  EXPECT_NE(resumed.err.find("the run was held"), std::string::npos) << resumed.err;
}

/// The tick for which Ctrl-C waits begins to make the chamber safe. Ctrl-C is then ignored, as in any later second.
TEST_F(GuardedRun, StopSurvivesInterruptInSameSecond) {
  for (int tries = 0; tries < 6; ++tries) {
    const auto path = folder / ("run" + std::to_string(tries) + ".db");
    Background run(warm_run(path), folder / ("log" + std::to_string(tries)));
    ASSERT_TRUE(run.wait_for("\"acknowledged\": 1}", 60)) << run.output();
    const auto send = [&](const std::string& word) {
      const auto answer = control::send_request(path, control::make_request(word, "").value(), std::chrono::seconds(5));
      return answer && answer->done;
    };
    const auto paused =
        control::send_request(path, control::make_request("pause", "").value(), std::chrono::seconds(5));
    ASSERT_TRUE(paused) << text(paused.error());
    EXPECT_TRUE(paused->done) << paused->text;
    run.signal(SIGINT);
    shell("sleep 0.1");  // the signal has been handled
    const bool was_stopped = send("stop");
    const int ended = run.wait();
    if (!was_stopped) continue;  // the second was over
    EXPECT_EQ(ended, 0) << run.output();
    EXPECT_EQ(laboratory.set_point(), kSafe);
    const auto kept = record::read_record(path);
    ASSERT_TRUE(kept) << text(kept.error());
    EXPECT_TRUE(kept->finished);
    const auto status = gyrotherm_with("status " + path).out;
    EXPECT_NE(status.find("  ended in segment 1 of "), std::string::npos) << status;
    return;
  }
  FAIL() << "the signal never arrived within the second";
}

/// Socket of systemd's watchdog. The environment names it during the lifetime of the object.
class Watchdog {
 public:
  explicit Watchdog(const std::string& path) : socket_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::copy(path.begin(), path.end(), address.sun_path);
    EXPECT_EQ(::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    ::setenv("NOTIFY_SOCKET", path.c_str(), 1);
    ::setenv("WATCHDOG_USEC", "8000000", 1);
  }
  ~Watchdog() {
    ::unsetenv("NOTIFY_SOCKET");
    ::unsetenv("WATCHDOG_USEC");
    ::close(socket_);
  }
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;
  /// Returns one line for each message so far.
  [[nodiscard]] std::string messages() {
    char message[256];
    for (ssize_t size; (size = ::recv(socket_, message, sizeof message, MSG_DONTWAIT)) > 0;)
      messages_ += std::string(message, static_cast<std::size_t>(size)) + "\n";
    return messages_;
  }

 private:
  int socket_;
  std::string messages_;
};

TEST_F(GuardedRun, IsFoundByMakeSafeThroughAnyFileOfItsRecord) {
  Background run(warm_run(record), folder / "log");
  ASSERT_TRUE(run.wait_for("\"acknowledged\": 1}", 60)) << run.output();
  const std::string make_safe = std::string(GYROTHERM_PROGRAM) + "-make-safe ";
  const auto stem = record.substr(0, record.size() - 3);
  for (const auto& file : {record + ".status", record + "-wal", stem + ".live.db", stem + ".live.db.1"}) {
    const auto other = shell(make_safe + file);
    EXPECT_EQ(other.exit_code, 5) << file << other.err;
    EXPECT_NE(other.err.find("belongs to " + record), std::string::npos) << other.err;
  }
  for (const auto& other : {folder / "", folder / "log"}) {
    const auto refused = shell(make_safe + other);
    EXPECT_EQ(refused.exit_code, 4) << other;
    EXPECT_NE(refused.err.find("is not a record, expected the record of the run"), std::string::npos) << refused.err;
  }
  run.signal(SIGKILL);
  EXPECT_EQ(run.wait(), -SIGKILL);
  auto made = shell(make_safe + "--kill " + stem + ".live.db");
  for (int i = 0; i < 60 && made.exit_code == 5; ++i)  // the guard still makes it safe
    made = shell("sleep 1; " + make_safe + "--kill " + record);
  EXPECT_EQ(made.exit_code, 0) << made.err;
}

TEST_F(GuardedRun, NotifiesSystemdWatchdogEachTick) {
  Watchdog watchdog(folder / "notify");
  Background run(warm_run(record), folder / "log");
  ASSERT_TRUE(run.wait_for("\"acknowledged\": 1}", 60)) << run.output();
  ASSERT_TRUE(laboratory.wait_for_set_point(kWarm, 60));
  const auto messages = watchdog.messages();
  EXPECT_TRUE(messages.starts_with("READY=1\nWATCHDOG_USEC=900000000\n")) << messages;
  EXPECT_NE(messages.find("WATCHDOG_USEC=8000000\nWATCHDOG=1\nWATCHDOG=1\n"), std::string::npos) << messages;
  const std::string make_safe = std::string(GYROTHERM_PROGRAM) + "-make-safe ";
  EXPECT_EQ(shell(make_safe + record).exit_code, 5) << "the program still runs";
  EXPECT_EQ(laboratory.set_point(), kWarm);
  run.signal(SIGKILL);
  EXPECT_EQ(run.wait(), -SIGKILL);
  auto made = shell(make_safe + "--kill " + record);
  for (int i = 0; i < 60 && made.exit_code == 5; ++i)  // the guard still makes it safe
    made = shell("sleep 1; " + make_safe + "--kill " + record);
  EXPECT_EQ(made.exit_code, 0) << made.err;
  EXPECT_EQ(laboratory.set_point(), kSafe);
  const auto again = shell(make_safe + "--kill " + record);
  EXPECT_EQ(again.exit_code, 0);
  EXPECT_NE(again.err.find("nothing to do"), std::string::npos) << again.err;
}

}  // namespace
}  // namespace gyrotherm::app
