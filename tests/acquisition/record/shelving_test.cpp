// SPDX-License-Identifier: Apache-2.0
/// Shelved warnings: the state machine, computed from the events of a record.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "acquisition/record/alarms.hpp"
#include "acquisition/record/status.hpp"
#include "acquisition/record/store.hpp"
#include "tests/acquisition/record/runs.hpp"

namespace gyrotherm::record {
namespace {

using std::chrono_literals::operator""s;
using std::chrono_literals::operator""h;

constexpr Duration kStarted = std::chrono::hours(490'000);  ///< UTC of the start of the run

Instant instant(int at_s) {
  return {.since_start = std::chrono::seconds(at_s), .utc = kStarted + std::chrono::seconds(at_s)};
}

Event warning(const std::string& id, const std::string& subject, int at_s, const std::string& reaction = "warn",
              const std::string& root = "") {
  return {instant(at_s),
          reaction == "warn" ? EventKind::fault : EventKind::interlock,
          id + " (" + reaction + ")" + (root.empty() ? "" : consequence_suffix(root)),
          {.interlock = id, .reaction = reaction, .channel = subject}};
}

Event return_event(const std::string& id, const std::string& subject, int at_s) {
  return {
      instant(at_s), EventKind::recovered, id + " is over", {.interlock = id, .reaction = "go_on", .channel = subject}};
}

/// Numbers events as a record does.
class Shelving : public testing::Test {
 protected:
  std::int64_t add(Event event) {
    event.number = ++last_;
    alarms_.update({.slot = last_, .event = std::move(event)});
    return last_;
  }
  void shelve(std::int64_t number, int at_s, Duration time = 1h) {
    ASSERT_EQ(alarms_.shelving_refusal_reason(number), "");
    add(shelving_event(alarms_.find_row(number).value(), instant(at_s), 2, time, "ada (uid 1000)", "a new fan: soon"));
  }
  std::int64_t unshelve(std::int64_t number, int at_s) {
    EXPECT_EQ(alarms_.unshelving_refusal_reason(number), "");
    return add(unshelving_event(alarms_.find_row(number).value(), instant(at_s), 2, ": the time is over"));
  }
  [[nodiscard]] std::size_t announced() const { return count_unacknowledged(alarms_.list()); }
  Alarms alarms_;
  std::int64_t last_ = 0;
};

TEST_F(Shelving, KeepsRowWithUserReasonAndEnd) {
  const auto number = add(warning("disagreement", "A", 10));
  shelve(number, 20, 2h);
  const auto list = alarms_.list();
  ASSERT_EQ(list.size(), 1u);
  EXPECT_EQ(list[0].shelved_by, "ada (uid 1000)");
  EXPECT_EQ(list[0].shelving_reason, "a new fan: soon");
  EXPECT_EQ(list[0].shelved_until, 2h + 20s);
  EXPECT_EQ(list[0].shelved_until_utc, kStarted + 2h + 20s);
  EXPECT_EQ(describe_alarm_state(list[0]), "active, shelved");
  EXPECT_EQ(describe_shelving(list[0]),
            "shelved until " + civil_time(kStarted + 2h + 20s) + " by ada (uid 1000): a new fan: soon");
  EXPECT_FALSE(list[0].awaits_acknowledgement());
  EXPECT_EQ(alarms_.count().unacknowledged, 0);
  EXPECT_TRUE(alarms_.unacknowledged().empty()) << "\"acknowledge all\" does not concern it";
  EXPECT_EQ(alarms_.refusal_reason(number), "alarm 1 was shelved and needs no acknowledgement");
  EXPECT_EQ(alarms_.shelved(), list);
}

TEST_F(Shelving, CountsRecurrencesWithoutAnnouncingThem) {
  const auto number = add(warning("disagreement", "A", 10));
  shelve(number, 20);
  for (int i = 0; i < 5; ++i) {
    add(return_event("disagreement", "A", 30 + 20 * i));
    EXPECT_EQ(describe_alarm_state(alarms_.list().at(0)), "returned, shelved");
    const auto again = add(warning("disagreement", "A", 40 + 20 * i));
    EXPECT_EQ(announced(), 0u);
    EXPECT_EQ(alarms_.refusal_reason(again), fmt::format("alarm {} was shelved and needs no acknowledgement", again));
  }
  const auto row = alarms_.list().at(0);
  EXPECT_EQ(row.count, 6);
  EXPECT_EQ(row.number, number) << "the number with which it is unshelved does not change";
  EXPECT_EQ(alarms_.find_row(row.last_number)->tag(), "disagreement A");
}

TEST_F(Shelving, AnnouncesActiveAlarmAgainAtItsEnd) {
  for (const bool was_acknowledged : {false, true}) {
    alarms_ = {};
    const auto number = add(warning("disagreement", "A", 10));
    if (was_acknowledged) add(acknowledgement_event(alarms_.list().at(0), instant(11), {}, "eve (uid 1001)", "seen"));
    shelve(number, 20);
    const auto end = unshelve(number, 3620);
    const auto list = alarms_.list();
    ASSERT_EQ(list.size(), 1u);
    EXPECT_FALSE(list[0].is_shelved());
    EXPECT_EQ(list[0].shelving_reason, "");
    EXPECT_EQ(list[0].number, end) << "a new number, which causes a new notification";
    EXPECT_TRUE(list[0].awaits_acknowledgement());
    EXPECT_EQ(list[0].count, 1) << "it is not another occurrence";
    add(warning("disagreement", "A", 3700));
    add(acknowledgement_event(alarms_.list().at(0), instant(3710), {}, "eve (uid 1001)", "seen"));
    EXPECT_EQ(announced(), 0u) << "one acknowledgement covers both";
  }
}

TEST_F(Shelving, EndsAsNormalIfAlarmHasReturned) {
  const auto number = add(warning("disagreement", "A", 10));
  shelve(number, 20);
  add(return_event("disagreement", "A", 30));
  add(warning("disagreement", "A", 40));
  add(return_event("disagreement", "A", 50));
  unshelve(number, 3620);
  EXPECT_TRUE(alarms_.list().empty());
  add(warning("disagreement", "A", 4000));
  EXPECT_EQ(announced(), 1u);
  EXPECT_EQ(alarms_.list().at(0).count, 3);
}

TEST_F(Shelving, ConcernsOneSubject) {
  add(warning("unit_silent", "u1", 10));
  const auto second = add(warning("unit_silent", "u2", 11));
  add(warning("unit_silent", "u3", 12));
  shelve(second, 20);
  EXPECT_EQ(announced(), 2u);
  const auto list = alarms_.list();
  ASSERT_EQ(list.size(), 3u);
  EXPECT_EQ(list[0].subject, "u3") << "the newest first";
  EXPECT_EQ(list[2].subject, "u2") << "the shelved ones last";
  add(warning("unit_silent", "u1", 30));
  EXPECT_EQ(alarms_.list().at(2).subject, "u2");
}

TEST_F(Shelving, EndsWhenAlarmDemandsMoreThanWarning) {
  for (const auto* reaction : {"suspend", "hold", "abort", "another"}) {
    alarms_ = {};
    const auto number = add(warning("disagreement", "A", 10));
    shelve(number, 20);
    const auto again = add(warning("disagreement", "A", 30, reaction));
    const auto list = alarms_.list();
    ASSERT_EQ(list.size(), 1u);
    EXPECT_FALSE(list[0].is_shelved()) << reaction;
    EXPECT_EQ(announced(), 1u);
    EXPECT_EQ(list[0].number, again);
    EXPECT_EQ(alarms_.unshelving_refusal_reason(again), fmt::format("alarm {} is not shelved", again));
    add(unshelving_event(list[0], instant(31), 2, ": it is no longer a warning"));
    EXPECT_EQ(alarms_.list(), list) << "the event that the program adds changes nothing";
  }
}

TEST_F(Shelving, RefusesEverythingButSingleWarnings) {
  for (const auto* reaction : {"suspend", "hold", "abort", "go_on", ""}) {
    alarms_ = {};
    const auto number = add(warning("door", "", 10, reaction));
    EXPECT_NE(alarms_.shelving_refusal_reason(number).find("only a warning can be shelved"), std::string::npos);
    add(shelving_event(alarms_.find_row(number).value(), instant(11), {}, 1h, "ada", "forged"));
    EXPECT_EQ(announced(), 1u) << reaction << ": an event of a forged record is ignored";
  }
  EXPECT_TRUE(alarms_.shelving_refusal_reason(77).starts_with("there is no alarm 77;"));
  EXPECT_TRUE(alarms_.unshelving_refusal_reason(77).starts_with("there is no alarm 77;"));
}

TEST_F(Shelving, RefusesSecondShelving) {
  const auto number = add(warning("disagreement", "A", 10));
  shelve(number, 20, 1h);
  const auto until = alarms_.list().at(0).shelved_until;
  EXPECT_NE(alarms_.shelving_refusal_reason(number).find("unshelve it before you shelve it again"), std::string::npos);
  add(shelving_event(alarms_.list().at(0), instant(30), {}, 24h, "eve", "longer"));
  EXPECT_EQ(alarms_.list().at(0).shelved_until, until) << "a second event does not extend it";
  EXPECT_EQ(alarms_.list().at(0).shelved_by, "ada (uid 1000)");
  const auto end = unshelve(number, 40);
  shelve(end, 50, 24h);
  EXPECT_EQ(alarms_.list().at(0).shelved_until, 24h + 50s);
}

TEST_F(Shelving, HidesNoOtherAlarm) {
  const auto root = add(warning("host_late", "", 10));
  const auto consequence = add(warning("channel_lost", "A", 11, "warn", "host_late"));
  EXPECT_NE(alarms_.shelving_refusal_reason(root).find("consequences"), std::string::npos);
  EXPECT_NE(alarms_.shelving_refusal_reason(consequence).find("is a consequence of host_late"), std::string::npos);
  add(return_event("channel_lost", "A", 20));
  add(acknowledgement_event(alarms_.find_row(consequence).value(), instant(21), {}, "ada", "seen"));
  shelve(root, 30);
  add(warning("channel_lost", "B", 40, "warn", "host_late"));
  EXPECT_EQ(announced(), 1u) << "a shelved root suppresses no alarm";
  const auto b = alarms_.list().at(0);
  EXPECT_EQ(b.tag(), "channel_lost B");
  add(return_event("host_late", "", 50));
  shelve(b.number, 55);
  add(warning("host_late", "", 60));
  add(return_event("channel_lost", "B", 61));
  add(warning("channel_lost", "B", 62, "warn", "host_late"));
  EXPECT_EQ(alarms_.find_row(b.number)->suppressed_by, "") << "a shelved alarm stays in its own group";
}

TEST_F(Shelving, SurvivesResume) {
  const auto number = add(warning("disagreement", "A", 10));
  shelve(number, 20);
  add({instant(100), EventKind::resumed, "resumed after 80 s"});
  ASSERT_EQ(alarms_.list().size(), 1u);
  EXPECT_EQ(describe_alarm_state(alarms_.list()[0]), "returned, shelved");
  add(warning("disagreement", "A", 110));
  EXPECT_EQ(announced(), 0u);
}

TEST_F(Shelving, IgnoresOtherCommandsAndUnreadableTexts) {
  add(warning("disagreement", "A", 10));
  const EventSubject about{.interlock = "disagreement", .reaction = "warn", .segment = 1, .channel = "A"};
  for (const auto* text :
       {"", "alarm", "alarm 1", "alarm 1 shelved", "alarm 1 shelved for  by ada: x",
        "alarm 1 shelved for 0 s by ada: x", "alarm 1 shelved for -1 h by ada: x", "alarm 1 shelved for 25 h by ada: x",
        "alarm 1 shelved for 1 h by : x", "alarm 1 shelved for 1 h", "alarm 0 shelved for 1 h by ada: x",
        "alarm x shelved for 1 h by ada: x", "alarm 1 shelved for 99999999999999999999 h by ada: x",
        "alarm 1 unshelved by ada", "shelved for 1 h by ada: x"})
    add({instant(20), EventKind::command, text, about});
  const std::string valid = "alarm 1 shelved for 1 h by ada: x";
  add({instant(20), EventKind::command, valid, {.segment = 1}});
  add({instant(20), EventKind::note, valid, about});
  add({instant(20), EventKind::acknowledged, valid, about});
  add({instant(20), EventKind::command, valid, {.interlock = "disagreement", .channel = "B"}});
  EXPECT_EQ(announced(), 1u);
  EXPECT_TRUE(alarms_.shelved().empty());
  add({instant(20), EventKind::command, valid, about});
  EXPECT_EQ(announced(), 0u) << "the valid one";
}

TEST(ShelvedAlarms, OutliveProgramThatRecordedThem) {
  for (const bool background : {false, true}) {
    const Folder folder;
    const auto path = folder / "run.db";
    std::vector<Alarm> before;
    {
      auto store = Store::create(path, two_thermometers(), {.background = background});
      ASSERT_TRUE(store) << text(store.error());
      const std::vector<Event> events{warning("unit_silent", "u1", 0), warning("unit_silent", "u2", 0)};
      ASSERT_TRUE((*store)->append(sample_at(0), events));
      const auto row = (*store)->alarms().list().at(0);
      ASSERT_TRUE((*store)->append_event(shelving_event(row, instant(1), 0, 2h, "ada (uid 1000)", "its cable")));
      before = (*store)->alarms().list();
      ASSERT_TRUE(before.at(1).is_shelved());
      ASSERT_TRUE((*store)->settle(5s));
    }
    const auto status = read_status(path);
    ASSERT_TRUE(status) << text(status.error());
    EXPECT_EQ(status->alarms, before);
    auto again = Store::reopen(path, {.background = background});
    ASSERT_TRUE(again) << text(again.error());
    EXPECT_EQ((*again)->alarms().list(), before);
    const auto parsed = parse_status(to_json(*status), "run.db.status");
    ASSERT_TRUE(parsed) << text(parsed.error());
    EXPECT_EQ(parsed->alarms, before) << "through the status file";
  }
}

}  // namespace
}  // namespace gyrotherm::record
