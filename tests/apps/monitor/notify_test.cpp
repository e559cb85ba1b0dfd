// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "apps/monitor/deliver.hpp"
#include "apps/monitor/due_messages.hpp"
#include "apps/monitor/notifier.hpp"
#include "apps/monitor/site_file.hpp"
#include "core/file.hpp"
#include "tests/support/folder.hpp"

namespace gyrotherm::monitor {
namespace {

using std::chrono_literals::operator""h;
using std::chrono_literals::operator""min;
using std::chrono_literals::operator""s;
using std::chrono_literals::operator""ms;

constexpr const char* kSite = R"(schema = "gyrotherm-site/1"
name = "lab"

[[notify.address]]
name = "day"
command = ["true"]

[[notify.address]]
name = "night"
command = ["true"]

[[notify.rule]]
when = "alarm"
tell = ["day", "night"]
after = "10 min"
simulated = true

[[notify.rule]]
when = "run ended"
tell = ["day"]

[[notify.rule]]
when = "disk low"
tell = ["day"]
free_gb = 2

[[notify.rule]]
when = "silent"
tell = ["night"]
after = "2 min"
monitor = "http://other:8321/"
)";

class DueMessages : public ::testing::Test {
 protected:
  void SetUp() override {
    auto read = parse_site(kSite, "site.toml");
    ASSERT_TRUE(read) << text(read.error());
    site_ = std::move(*read);
    now_.runs = {{.id = "r",
                  .name = "soak",
                  .record = "/r/soak.db",
                  .rig = "one",
                  .simulated = false,
                  .virtual_rig = false,
                  .running = true,
                  .silent = false,
                  .outcome = {},
                  .alarms = {},
                  .free_bytes = 10'000'000'000}};
  }
  /// Returns the due messages as "ADDRESS: SUBJECT" and records them as delivered.
  std::vector<std::string> told() {
    std::vector<std::string> all;
    for (const auto& message : due_messages(site_, now_, utc_, memory_)) {
      all.push_back(message.address + ": " + message.subject);
      memory_.record_delivery(message, utc_);
    }
    return all;
  }
  using Messages = std::vector<std::string>;
  Site site_;
  Situation now_;
  NotificationMemory memory_;
  Duration utc_ = 1000h;
};

TEST_F(DueMessages, EscalatesAlarmUntilAcknowledged) {
  EXPECT_EQ(told(), Messages{});
  now_.runs.front().alarms = {{7, "air above its limit"}};
  EXPECT_EQ(told(), Messages{"day: Alarm: lab: soak on one"});
  EXPECT_EQ(told(), Messages{});
  utc_ += 9min;
  EXPECT_EQ(told(), Messages{});
  utc_ += 2min;
  EXPECT_EQ(told(), Messages{"night: Alarm: lab: soak on one"});
  utc_ += 24h;
  EXPECT_EQ(told(), Messages{}) << "there is nobody left";
}

TEST_F(DueMessages, EndsEscalationWhenAcknowledged) {
  now_.runs.front().alarms = {{7, "air above its limit"}};
  EXPECT_EQ(told().size(), 1u);
  now_.runs.front().alarms.clear();
  utc_ += 1h;
  EXPECT_EQ(told(), Messages{});
  now_.runs.front().alarms = {{9, "again"}};
  EXPECT_EQ(told().size(), 1u) << "another alarm is another matter";
}

TEST_F(DueMessages, KeepsMemoryOverRestart) {
  now_.runs.front().alarms = {{7, "air above its limit"}};
  EXPECT_EQ(told().size(), 1u);
  auto read = NotificationMemory::parse(memory_.to_text(), "told.json");
  ASSERT_TRUE(read) << text(read.error());
  EXPECT_EQ(*read, memory_);
  memory_ = std::move(*read);
  EXPECT_EQ(told(), Messages{});
  utc_ += 11min;
  EXPECT_EQ(told(), Messages{"night: Alarm: lab: soak on one"});
}

TEST_F(DueMessages, TriesAddressThreeTimesBeforeNext) {
  now_.runs.front().alarms = {{7, "air above its limit"}};
  for (int i = 0; i < kMaxAttempts; ++i) {
    const auto due = due_messages(site_, now_, utc_, memory_);
    ASSERT_EQ(due.size(), 1u) << i;
    EXPECT_EQ(due.front().address, "day");
    memory_.record_failure(due.front(), utc_);
    EXPECT_TRUE(i + 1 == kMaxAttempts || due_messages(site_, now_, utc_, memory_).empty()) << "not at once";
    utc_ += 2min;
  }
  utc_ += 10min;
  EXPECT_EQ(told(), Messages{"night: Alarm: lab: soak on one"});
}

TEST_F(DueMessages, ReportsEndOfRunOnceButNotOfOldRun) {
  EXPECT_EQ(told(), Messages{});
  auto& run = now_.runs.front();
  run.running = false;
  run.outcome = "complete";
  now_.runs.push_back(run);
  now_.runs.back().id = "was over before";
  EXPECT_EQ(told(), Messages{"day: Ended: lab: soak on one"});
  utc_ += 24h;
  EXPECT_EQ(told(), Messages{});
}

TEST_F(DueMessages, RepeatsDiskLowOnlyAfterRecovery) {
  EXPECT_EQ(told(), Messages{});
  now_.runs.front().free_bytes = 1'000'000'000;
  EXPECT_EQ(told(), Messages{"day: Disk low: lab: soak on one"});
  EXPECT_EQ(told(), Messages{});
  now_.runs.front().free_bytes = 9'000'000'000;
  EXPECT_EQ(told(), Messages{});
  now_.runs.front().free_bytes = 1'000'000'000;
  EXPECT_EQ(told().size(), 1u);
}

TEST_F(DueMessages, RepeatsNothingWhenRunReappears) {
  EXPECT_EQ(told(), Messages{});
  now_.runs.front().alarms = {{7, "air above its limit"}};
  now_.runs.front().free_bytes = 1'000'000'000;
  EXPECT_EQ(told().size(), 2u);
  const auto run = now_.runs.front();
  now_.runs.front().free_bytes.reset();
  EXPECT_EQ(told(), Messages{}) << "the disk was away first";
  now_.runs.clear();
  EXPECT_EQ(told(), Messages{});
  utc_ += 5min;
  now_.runs = {run};
  EXPECT_EQ(told(), Messages{});
  now_.runs.clear();
  EXPECT_EQ(told(), Messages{});
  utc_ += 6min;
  now_.runs = {run};
  now_.runs.front().running = false;
  now_.runs.front().outcome = "complete";
  EXPECT_EQ(told(), (Messages{"night: Alarm: lab: soak on one", "day: Ended: lab: soak on one"}))
      << "it ended while nobody saw";
}

TEST_F(DueMessages, ForgetsRunAfterDayOfAbsence) {
  now_.runs.front().alarms = {{7, "air above its limit"}};
  EXPECT_EQ(told().size(), 1u);
  now_.runs.clear();
  EXPECT_EQ(told(), Messages{});
  EXPECT_NE(memory_, NotificationMemory{});
  utc_ += 25h;
  EXPECT_EQ(told(), Messages{});
  EXPECT_EQ(memory_, NotificationMemory{});
}

TEST_F(DueMessages, ReportsMissingRunAsSilentAfterRestart) {
  site_.rules.push_back(
      {.name = "a run is silent", .trigger = RuleTrigger::silent, .addresses = {"day"}, .after = 2min});
  const auto run = now_.runs.front();
  EXPECT_EQ(told(), Messages{});
  now_.runs.clear();
  EXPECT_EQ(told(), Messages{});
  utc_ += 1min;
  now_.runs = {run};
  EXPECT_EQ(told(), Messages{}) << "it was away for a moment";
  now_.runs.clear();
  EXPECT_EQ(told(), Messages{});
  auto read = NotificationMemory::parse(memory_.to_text(), "told.json");
  ASSERT_TRUE(read) << text(read.error());
  memory_ = std::move(*read);
  utc_ += 2min;
  EXPECT_EQ(told(), Messages{"day: Silent: lab: soak on one"});
  utc_ += 1h;
  EXPECT_EQ(told(), Messages{}) << "once";
  utc_ += 25h;
  (void)told();
  EXPECT_EQ(told(), Messages{});
  EXPECT_EQ(memory_, NotificationMemory{}) << "after a day it is forgotten";
}

TEST_F(DueMessages, IgnoresRemovalOfEndedRun) {
  site_.rules.push_back(
      {.name = "a run is silent", .trigger = RuleTrigger::silent, .addresses = {"day"}, .after = 2min});
  auto simulated = now_.runs.front();
  simulated.id = "s";
  simulated.simulated = simulated.virtual_rig = true;
  now_.runs.push_back(simulated);
  EXPECT_EQ(told(), Messages{});
  now_.runs.front().running = false;
  now_.runs.front().outcome = "complete";
  EXPECT_EQ(told(), Messages{"day: Ended: lab: soak on one"});
  now_.runs.clear();
  EXPECT_EQ(told(), Messages{});
  utc_ += 1h;
  EXPECT_EQ(told(), Messages{}) << "and of a virtual rig nobody wants to hear";
}

TEST_F(DueMessages, RestartsWaitingTimesWhenClockIsSetBack) {
  now_.runs.front().alarms = {{7, "air above its limit"}};
  const auto due = due_messages(site_, now_, utc_, memory_);
  ASSERT_EQ(due.size(), 1u);
  memory_.record_failure(due.front(), utc_);
  utc_ -= 1h;
  EXPECT_EQ(told(), Messages{}) << "tried a moment ago";
  utc_ += 1min;
  EXPECT_EQ(told(), Messages{"day: Alarm: lab: soak on one"});
  utc_ -= 1h;
  EXPECT_EQ(told(), Messages{});
  utc_ += 10min;
  EXPECT_EQ(told(), Messages{"night: Alarm: lab: soak on one"});
}

TEST_F(DueMessages, ReportsSilentMonitorAfterDelay) {
  now_.responding_monitors["http://other:8321/"] = false;
  EXPECT_EQ(told(), Messages{});
  utc_ += 1min;
  EXPECT_EQ(told(), Messages{});
  now_.responding_monitors["http://other:8321/"] = true;
  EXPECT_EQ(told(), Messages{});
  now_.responding_monitors["http://other:8321/"] = false;
  EXPECT_EQ(told(), Messages{});
  utc_ += 3min;
  EXPECT_EQ(told(), Messages{"night: lab: http://other:8321/ does not respond"});
}

TEST_F(DueMessages, ReportsVirtualRigsOnlyToRulesThatIncludeThem) {
  now_.runs.front().simulated = now_.runs.front().virtual_rig = true;
  now_.runs.front().alarms = {{7, "air above its limit"}};
  now_.runs.front().free_bytes = 0;
  EXPECT_EQ(told(), Messages{"day: Alarm: lab: SIMULATED soak on one"});
}

/// Its other instruments are real, and may be in danger.
TEST_F(DueMessages, ReportsRealRigWithVirtualInstrumentToAllRules) {
  now_.runs.front().simulated = true;
  now_.runs.front().alarms = {{7, "air above its limit"}};
  EXPECT_EQ(told(), Messages{"day: Alarm: lab: SIMULATED soak on one"});
  utc_ += 20min;
  EXPECT_EQ(told(), Messages{"night: Alarm: lab: SIMULATED soak on one"});
}

TEST(Notifier, RepeatsFailedSaveAndReportsItOnce) {
  const tests::TestFolder folder;
  const std::filesystem::path state = folder / "state";
  const RunCatalogue catalogue({folder / ""});
  const VirtualClock clock;
  std::vector<Fault> faults;
  Notifier notifier(Site{}, state / "memory", catalogue, clock, [&](const Fault& fault) { faults.push_back(fault); });
  notifier.notify_due();
  notifier.notify_due();
  EXPECT_EQ(faults.size(), 1u);
  std::filesystem::create_directory(state);
  notifier.notify_due();
  EXPECT_TRUE(std::filesystem::exists(state / "memory"));
  EXPECT_EQ(faults.size(), 1u);
}

TEST(SiteFile, RefusesLiveTableOnce) {
  const auto read = parse_site("schema = \"gyrotherm-site/1\"\n[live]\nbroker = \"mqtts://b\"\n", "site.toml");
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().kind, FaultKind::bad_file);
  EXPECT_EQ(read.error().where, "site.toml:2:1");
  EXPECT_EQ(read.error().what.find('\n'), std::string::npos) << read.error().what;
}

TEST(SiteFile, ReportsEachErrorWithPosition) {
  const auto read = parse_site(R"(schema = "gyrotherm-site/1"
[[notify.address]]
name = "post"
mail = ["ada@example.org"]
[[notify.rule]]
when = "alarms"
tell = ["nobody"]
)",
                               "site.toml");
  ASSERT_FALSE(read);
  EXPECT_NE(text(read.error()).find("did you mean \"alarm\""), std::string::npos) << text(read.error());
  EXPECT_NE(read.error().what.find("[notify.mail] is missing"), std::string::npos) << read.error().what;
  EXPECT_NE(read.error().what.find("\"nobody\""), std::string::npos) << read.error().what;
}

TEST(SiteFile, RefusesAddressesThatReachNobody) {
  const auto refusal_of = [](const std::string& address, const std::string& server) {
    const auto read = parse_site("schema = \"gyrotherm-site/1\"\n[notify.mail]\nserver = \"" + server +
                                     "\"\nfrom = \"rig@example.org\"\n[[notify.address]]\nname = \"post\"\n" + address +
                                     "\n[[notify.rule]]\nwhen = \"alarm\"\ntell = [\"post\"]\n",
                                 "site.toml");
    return read ? std::string() : text(read.error());
  };
  const std::string ada = "mail = [\"ada@example.org\"]", server = "smtp://mail.example.org:587";
  EXPECT_EQ(refusal_of(ada, server), "");
  EXPECT_EQ(refusal_of("command = [\"notify\", \"x\"]", server), "") << "is looked up when it runs";
  for (const auto* wrong : {"mail = [\"ada example.org\"]", "mail = [\"@example.org\"]", "mail = [\"ada@\"]"})
    EXPECT_NE(refusal_of(wrong, server).find("is not a mail address"), std::string::npos) << wrong;
  EXPECT_NE(
      refusal_of("command = [\"/nowhere/notify\"]", server).find("is not a program that can be run: No such file"),
      std::string::npos);
  for (const auto* wrong : {"smtp://mail.example.org:99999", "smtp://mail.example.org:0", "smtps://mail.example.org:"})
    EXPECT_NE(refusal_of(ada, wrong).find("has no valid port"), std::string::npos) << wrong;
}

TEST(Mail, HasNoInjectedHeader) {
  const MailServer server{.url = "smtp://x", .from = "rig@example.org", .user = {}, .password = {}};
  const auto text = mail_text(server, {{"ada@example.org"}},
                              {.subject = "Alarm\r\nBcc: eve@example.org", .text = "20 °C\n.\nend"}, 0s);
  EXPECT_EQ(text.find("\nBcc"), std::string::npos);
  EXPECT_NE(text.find("Subject: Alarm  Bcc: eve@example.org\r\n"), std::string::npos) << text;
  EXPECT_NE(text.find("\r\n\r\n20 °C\r\n.\r\nend\r\n"), std::string::npos) << text;
  EXPECT_NE(text.find("Date: Thu, 01 Jan 1970 00:00:00 +0000"), std::string::npos) << text;
  EXPECT_NE(mail_text(server, {{"ada@example.org"}}, {.subject = "20 °C", .text = ""}, 0s)
                .find("Subject: =?utf-8?Q?20_=C2=B0C?="),
            std::string::npos);
}

TEST(Mail, WrapsLongSubject) {
  const MailServer server{.url = "smtp://x", .from = "rig@example.org", .user = {}, .password = {}};
  for (int letters = 0; letters < 12; ++letters) {
    std::string subject(static_cast<std::size_t>(letters), 'a');
    for (int i = 0; i < 60; ++i) subject += "ü°漢";
    const auto text = mail_text(server, {{"ada@example.org"}}, {.subject = subject, .text = ""}, 0s);
    for (std::size_t begin = text.find("Subject: "), end = 0; end != text.find("\r\nAuto-Submitted"); begin = end + 2) {
      end = text.find("\r\n", begin);
      EXPECT_LE(end - begin, 76u) << text.substr(begin, end - begin);
    }
  }
}

TEST(RunProgram, ReceivesTextAndIsKilledAtTimeout) {
  const tests::TestFolder folder;
  ASSERT_TRUE(run_program({"sh", "-c", "cat > " + (folder / "told")}, "it is warm\n", 10s));
  EXPECT_EQ(*read_text_file(folder / "told"), "it is warm\n");
  EXPECT_EQ(run_program({"false"}, "", 10s).error().kind, FaultKind::refused);
  EXPECT_EQ(run_program({"no-such-program-here"}, "", 10s).error().kind, FaultKind::usage);
  EXPECT_EQ(run_program({"sleep", "60"}, "", 200ms).error().kind, FaultKind::timeout);
}

}  // namespace
}  // namespace gyrotherm::monitor
