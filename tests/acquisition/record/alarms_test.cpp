// SPDX-License-Identifier: Apache-2.0
/// Tests that alarms remain until they are acknowledged, even if the program that recorded them ends.
#include "acquisition/record/alarms.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "acquisition/record/record.hpp"
#include "acquisition/record/status.hpp"
#include "acquisition/record/store.hpp"
#include "tests/acquisition/record/runs.hpp"

namespace gyrotherm::record {
namespace {

using std::chrono_literals::operator""s;

Event interlock(const std::string& id, const std::string& text) {
  return {sample_at(0).at, EventKind::interlock, text, {.interlock = id, .reaction = "suspend"}};
}

std::vector<std::int64_t> numbers(const std::vector<Alarm>& alarms) {
  std::vector<std::int64_t> all;
  for (const auto& alarm : alarms) all.push_back(alarm.number);
  return all;
}

RecordedEvent numbered(std::int64_t number, Event event) {
  event.number = number;
  return {.slot = number, .event = std::move(event)};
}

Event acknowledge_event(const Alarm& alarm) {
  return acknowledgement_event(alarm, sample_at(0).at, {}, "ada (uid 1000)", "seen");
}

Event occurrence(const std::string& id, const std::string& subject, const std::string& reaction, int at_s,
                 const std::string& root = "") {
  const auto kind = reaction == "warn" ? EventKind::fault : EventKind::interlock;
  const auto text = id + " (" + reaction + ")" + (root.empty() ? "" : consequence_suffix(root));
  return {{.since_start = std::chrono::seconds(at_s), .utc = std::chrono::seconds(at_s)},
          kind,
          text,
          {.interlock = id, .reaction = reaction, .channel = subject}};
}

Event clear_event(const std::string& id, const std::string& subject, int at_s) {
  return {{.since_start = std::chrono::seconds(at_s), .utc = std::chrono::seconds(at_s)},
          EventKind::recovered,
          id + " is over",
          {.interlock = id, .reaction = "go_on", .channel = subject}};
}

/// Numbers events as a record does.
class AlarmList : public testing::Test {
 protected:
  void add(Event event) { alarms_.update(numbered(++last_, std::move(event))); }
  void acknowledge(std::int64_t number) {
    for (const auto& row : alarms_.rows_for(number)) add(acknowledge_event(row));
  }
  [[nodiscard]] std::vector<std::string> tags() const {
    std::vector<std::string> all;
    for (const auto& alarm : alarms_.list()) all.push_back(alarm.tag());
    return all;
  }
  Alarms alarms_;
  std::int64_t last_ = 0;
};

using Tags = std::vector<std::string>;

TEST_F(AlarmList, HasOneRowPerInterlockAndSubject) {
  for (int i = 0; i < 50; ++i) {
    add(occurrence("disagreement", "A", "warn", 10 * i));
    add(occurrence("disagreement", "B", "warn", 10 * i + 1));
    add(occurrence("door", "", "suspend", 10 * i + 2));
    add(clear_event("door", "", 10 * i + 5));
    add(clear_event("disagreement", "A", 10 * i + 6));
  }
  const auto list = alarms_.list();
  ASSERT_EQ(tags(), (Tags{"door", "disagreement B", "disagreement A"})) << "the newest first";
  const auto& door = list[0];
  EXPECT_EQ(door.count, 50);
  EXPECT_EQ(door.number, 3) << "of the first unacknowledged occurrence; later ones do not change it";
  EXPECT_EQ(door.last_number, 5 * 49 + 3);
  EXPECT_EQ(door.first_utc, 2s);
  EXPECT_EQ(door.utc, 492s);
  EXPECT_EQ(door.returned_utc, 495s);
  EXPECT_FALSE(door.active);
  EXPECT_EQ(describe_alarm_state(door), "returned");
  EXPECT_EQ(door.priority, AlarmPriority::medium);
  EXPECT_TRUE(list[1].active) << "B has not cleared";
  EXPECT_EQ(list[1].priority, AlarmPriority::low);
}

/// The states A to D of ISA-18.2, clause 5.3, and each transition between them.
TEST_F(AlarmList, FollowsStatesOfIsa18) {
  add(occurrence("door", "", "suspend", 1));
  EXPECT_EQ(describe_alarm_state(alarms_.list().at(0)), "active");
  acknowledge(1);
  EXPECT_EQ(describe_alarm_state(alarms_.list().at(0)), "active, acknowledged") << "it remains until it clears";
  EXPECT_EQ(count_unacknowledged(alarms_.list()), 0u);
  add(clear_event("door", "", 5));
  EXPECT_TRUE(alarms_.list().empty());
  add(occurrence("door", "", "suspend", 6));
  EXPECT_EQ(alarms_.list().at(0).count, 2);
  EXPECT_EQ(alarms_.list().at(0).number, 4) << "a new number after an acknowledgement";
  add(clear_event("door", "", 7));
  EXPECT_EQ(describe_alarm_state(alarms_.list().at(0)), "returned");
  add(occurrence("door", "", "suspend", 8));
  EXPECT_EQ(describe_alarm_state(alarms_.list().at(0)), "active");
  add(clear_event("door", "", 9));
  EXPECT_EQ(alarms_.list().at(0).number, 4);
  acknowledge(4);
  EXPECT_TRUE(alarms_.list().empty());
  EXPECT_EQ(alarms_.refusal_reason(6), "alarm 6 is acknowledged already") << "the row's later occurrence";
}

TEST_F(AlarmList, AwaitsAcknowledgementWhenAlarmRecursWhileActive) {
  add(occurrence("disagreement", "A", "warn", 1));
  acknowledge(1);
  add(occurrence("disagreement", "A", "warn", 100));
  EXPECT_EQ(count_unacknowledged(alarms_.list()), 1u);
}

TEST_F(AlarmList, AcknowledgesOnlyEarlierOccurrences) {
  add(occurrence("door", "", "suspend", 1));
  add(occurrence("door", "", "suspend", 2));
  const auto shown = alarms_.list().at(0);
  add(occurrence("door", "", "suspend", 3));
  add(acknowledge_event(shown));
  const auto list = alarms_.list();
  ASSERT_EQ(list.size(), 1u);
  EXPECT_FALSE(list[0].acknowledged);
  EXPECT_EQ(list[0].number, 3);
  EXPECT_EQ(list[0].comment, "seen");
  EXPECT_EQ(list[0].acknowledged_by, "ada (uid 1000)");
}

TEST_F(AlarmList, SuppressesConsequencesUnderRoot) {
  add(occurrence("host_late", "", "warn", 1));
  for (const auto* id : {"gyro_silent", "chamber_silent", "channel_lost", "needed_channel_lost", "thermometers_lost"})
    add(occurrence(id, "", id == std::string("channel_lost") ? "warn" : "suspend", 2, "host_late"));
  add(occurrence("door", "", "suspend", 3));
  const auto list = alarms_.list();
  ASSERT_EQ(list.size(), 7u);
  EXPECT_EQ(tags()[0], "door");
  EXPECT_EQ(tags()[1], "host_late") << "its consequences follow it";
  EXPECT_EQ(list[1].priority, AlarmPriority::medium) << "the highest of its consequences";
  for (std::size_t i = 2; i < list.size(); ++i) {
    EXPECT_EQ(list[i].suppressed_by, "host_late");
    EXPECT_EQ(list[i].text.find("consequence"), std::string::npos) << list[i].text;
  }
  EXPECT_EQ(count_unacknowledged(list), 2u);
  acknowledge(1);
  acknowledge(7);
  EXPECT_EQ(count_unacknowledged(alarms_.list()), 0u);
  EXPECT_EQ(alarms_.refusal_reason(2), "alarm 2 is acknowledged already") << "a consequence, with its root";
}

TEST_F(AlarmList, ShowsConsequenceThatOutlivesRoot) {
  for (const auto* root : {"host_late", "line_lost tcp://10.0.0.5:502", "line_lost thermometer 1"}) {
    Alarms alarms;
    const std::string tag = root, id = tag.substr(0, tag.find(' ')),
                      subject = tag.find(' ') == std::string::npos ? "" : tag.substr(tag.find(' ') + 1);
    alarms.update(numbered(1, occurrence(id, subject, "warn", 1)));
    alarms.update(numbered(2, occurrence("gyro_silent", "", "suspend", 2, root)));
    ASSERT_EQ(count_unacknowledged(alarms.list()), 1u) << root;
    alarms.update(numbered(3, clear_event(id, subject, 60)));
    EXPECT_EQ(count_unacknowledged(alarms.list()), 2u) << root;
    EXPECT_EQ(alarms.list()[0].tag(), "gyro_silent");
    EXPECT_TRUE(alarms.list()[0].active);
  }
}

TEST_F(AlarmList, NeverSuppressesAlarmsThatHoldOrAbort) {
  add(occurrence("host_late", "", "warn", 1));
  for (const auto* reaction : {"hold", "abort"}) add(occurrence(reaction, "", reaction, 2, "host_late"));
  EXPECT_EQ(tags(), (Tags{"abort", "hold", "host_late"}));
  EXPECT_EQ(count_unacknowledged(alarms_.list()), 3u);
}

TEST_F(AlarmList, DoesNotSuppressHigherPriorityThanAcknowledgedRoot) {
  add(occurrence("line_lost", "T", "warn", 1));
  add(occurrence("channel_lost", "", "warn", 1, "line_lost T"));
  acknowledge(1);
  add(occurrence("channel_lost", "B", "warn", 2, "line_lost T"));
  EXPECT_EQ(count_unacknowledged(alarms_.list()), 0u);
  add(occurrence("thermometers_lost", "", "suspend", 6, "line_lost T"));
  EXPECT_EQ(count_unacknowledged(alarms_.list()), 1u);
  EXPECT_EQ(tags()[0], "thermometers_lost");
}

TEST_F(AlarmList, IgnoresMissingRoot) {
  for (const auto* root : {"host_late", "line_lost T", "gyro_silent"}) {
    Alarms alarms;
    alarms.update(numbered(1, occurrence("gyro_silent", "", "suspend", 1, root)));
    EXPECT_EQ(count_unacknowledged(alarms.list()), 1u) << root;
  }
}

TEST_F(AlarmList, HasNoActiveRowWhenRunIsResumed) {
  add(occurrence("door", "", "suspend", 1));
  add(occurrence("stuck", "A", "warn", 1));
  acknowledge(2);
  add({sample_at(0).at, EventKind::resumed, "resumed after 3 s"});
  ASSERT_EQ(tags(), Tags{"door"});
  EXPECT_EQ(describe_alarm_state(alarms_.list()[0]), "returned");
}

/// Version 0.1.0 acknowledged each occurrence separately and recorded no subject.
TEST_F(AlarmList, ReadsRecordOf010) {
  add(interlock("door", "door (suspend): open"));
  add(clear_event("door", "", 9));
  add(interlock("door", "door (suspend): open"));
  add({sample_at(0).at, EventKind::acknowledged, "alarm 3 acknowledged by ada (uid 1000): the later one"});
  auto list = alarms_.list();
  ASSERT_EQ(list.size(), 1u);
  EXPECT_EQ(list[0].number, 1);
  EXPECT_EQ(list[0].count, 2);
  EXPECT_FALSE(list[0].acknowledged) << "its first occurrence is not";
  add({sample_at(0).at, EventKind::acknowledged, "alarm 1 acknowledged by ada (uid 1000): and the first"});
  EXPECT_TRUE(alarms_.list()[0].acknowledged);
}

TEST(Alarms, ListInterlocksUntilAcknowledged) {
  Alarms alarms;
  alarms.update(numbered(3, interlock("door", "door (suspend): open")));
  alarms.update(numbered(4, {sample_at(0).at, EventKind::fault, "A: no reply", {.channel = "A"}}));
  alarms.update(
      numbered(5, {sample_at(0).at, EventKind::fault, "lag (warn)", {.interlock = "lag", .reaction = "warn"}}));
  alarms.update(numbered(6, {sample_at(0).at, EventKind::recovered, "door is over", {.interlock = "door"}}));
  EXPECT_EQ(numbers(alarms.list()), (std::vector<std::int64_t>{5, 3})) << "a cleared alarm is still listed";
  EXPECT_EQ(alarms.refusal_reason(3), "");
  alarms.update(numbered(7, acknowledge_event(alarms.list()[1])));
  EXPECT_EQ(numbers(alarms.list()), std::vector<std::int64_t>{5});
  EXPECT_EQ(alarms.refusal_reason(3), "alarm 3 is acknowledged already");
  EXPECT_TRUE(alarms.refusal_reason(4).starts_with("there is no alarm 4;")) << alarms.refusal_reason(4);
}

TEST(Alarms, RemainUntilAcknowledged) {
  Alarms alarms;
  alarms.update(numbered(1, interlock("door", "door (suspend): open")));
  alarms.update(numbered(2, {sample_at(0).at, EventKind::note, "alarm 1 acknowledged by ada: forged"}));
  for (const auto* text : {"alarm 1", "alarm 12 acknowledged by ada: x", "alarm  1 acknowledged by ada: x", "alarm x",
                           "", "alarm 1 to 0 acknowledged by ada: x", "alarm 1 to acknowledged by ada: x",
                           "alarm 0 to 9 acknowledged by ada: x"})
    alarms.update(numbered(3, {sample_at(0).at, EventKind::acknowledged, text}));
  EXPECT_EQ(count_unacknowledged(alarms.list()), 1u);
}

TEST(Alarms, AreBounded) {
  Alarms alarms;
  for (int i = 1; i <= 300; ++i) alarms.update(numbered(i, occurrence("stuck", std::to_string(i), "suspend", i)));
  ASSERT_EQ(alarms.list().size(), Alarms::kMaxRows);
  EXPECT_EQ(alarms.list().front().number, 300);
}

TEST(Alarms, KeepHigherPriorityWhenFull) {
  Alarms alarms;
  alarms.update(numbered(1, interlock("door", "door (suspend): open")));
  for (int i = 2; i <= 300; ++i) alarms.update(numbered(i, occurrence("lost", std::to_string(i), "warn", i)));
  ASSERT_EQ(alarms.list().size(), Alarms::kMaxRows);
  EXPECT_EQ(alarms.list().back().number, 1);
  EXPECT_EQ(alarms.list().front().number, 300);
  EXPECT_EQ(alarms.refusal_reason(2), "alarm 2 is no longer in the list, which has 256 rows at most")
      << "it is not acknowledged";
}

/// A late host makes every channel of a large rig silent.
TEST(Alarms, ListEveryActiveRowWhenFullOfConsequences) {
  Alarms alarms;
  alarms.update(numbered(1, occurrence("host_late", "", "warn", 1)));
  for (int i = 2; i <= 300; ++i)
    alarms.update(numbered(i, occurrence("channel_lost", std::to_string(i), "warn", i, "host_late")));
  ASSERT_EQ(alarms.list().size(), Alarms::kMaxRows);
  EXPECT_EQ(alarms.list().front().tag(), "host_late") << "the root is removed after its consequences";
  EXPECT_EQ(alarms.count().unacknowledged, 1);
  for (int i = 301; i <= 600; ++i) alarms.update(numbered(i, occurrence("stuck", std::to_string(i), "suspend", i)));
  ASSERT_EQ(alarms.list().size(), Alarms::kMaxRows);
  for (const auto& alarm : alarms.list()) EXPECT_EQ(alarm.suppressed_by, "") << alarm.tag();
}

TEST(Alarms, ConsequenceOfRemovedRootIsRowOfItsOwn) {
  Alarms alarms;
  alarms.update(numbered(1, occurrence("host_late", "", "warn", 1)));
  for (int i = 2; i <= 256; ++i) alarms.update(numbered(i, occurrence("stuck", std::to_string(i), "suspend", i)));
  alarms.update(numbered(257, occurrence("channel_lost", "A", "warn", 257, "host_late")));
  ASSERT_EQ(alarms.list().size(), Alarms::kMaxRows);
  EXPECT_EQ(alarms.list().front().tag(), "channel_lost A");
  EXPECT_TRUE(alarms.list().front().awaits_acknowledgement());
}

TEST(Alarms, CountRowsThatWereRemoved) {
  Alarms alarms;
  for (int i = 1; i <= 600; ++i) alarms.update(numbered(i, occurrence("lost", std::to_string(i % 300), "warn", i)));
  EXPECT_EQ(alarms.count().occurrences, 600);
  EXPECT_EQ(alarms.count().tags, 300);
  EXPECT_EQ(alarms.list().front().count, 2);
}

TEST(Alarms, OutliveProgramThatRecordedThem) {
  for (const bool background : {false, true}) {
    const Folder folder;
    const auto path = folder / "run.db";
    std::vector<Alarm> before;
    {
      auto store = Store::create(path, two_thermometers(), {.background = background});
      ASSERT_TRUE(store) << text(store.error());
      const std::vector<Event> events{interlock("door", "door (suspend): open"), interlock("lag", "lag (suspend): 9 K"),
                                      clear_event("door", "", 1), occurrence("channel_lost", "A", "warn", 1, "lag")};
      ASSERT_TRUE((*store)->append(sample_at(0), events));
      ASSERT_TRUE((*store)->append(sample_at(1), {}));
      before = (*store)->alarms().list();
      ASSERT_EQ(before.size(), 3u);
      ASSERT_EQ(before[2].tag(), "door");
      ASSERT_TRUE((*store)->append_event(acknowledge_event(before[2])));
      ASSERT_EQ((*store)->alarms().list().size(), 2u);
      ASSERT_TRUE((*store)->settle(5s));
    }
    const auto told = read_status(path);
    ASSERT_TRUE(told) << text(told.error());
    ASSERT_EQ(told->alarms.size(), 2u);
    EXPECT_EQ(told->alarms[0], before[0]) << "its number is that of the event in the record";
    EXPECT_EQ(told->alarms[1], before[1]) << "suppressed under the first";
    auto again = Store::reopen(path, {.background = background});
    ASSERT_TRUE(again) << text(again.error());
    EXPECT_EQ((*again)->alarms().list(), told->alarms);
    EXPECT_EQ((*again)->alarms().refusal_reason(before[2].number),
              fmt::format("alarm {} is acknowledged already", before[2].number));
    ASSERT_TRUE((*again)->append_event(interlock("door", "door (suspend): open again")));
    EXPECT_GT((*again)->alarms().list().front().number, before[1].number);
  }
}

TEST(Alarms, AreInStatusFileOfThisVersion) {
  RunStatus status = make_first_status("run.db", two_thermometers());
  status.alarms = {{.number = 12,
                    .last_number = 40,
                    .slot = 9,
                    .utc = 5s,
                    .first_utc = 2s,
                    .returned_utc = 7s,
                    .interlock = "door",
                    .subject = "left",
                    .reaction = "suspend",
                    .text = "open",
                    .priority = AlarmPriority::medium,
                    .count = 3,
                    .active = false,
                    .suppressed_by = "host_late",
                    .comment = "seen",
                    .acknowledged_by = "ada"}};
  const auto json = to_json(status);
  EXPECT_NE(json.find("\"alarms\":[{\"number\":12,\"slot\":9,\"utc\":\"1970-01-01"), std::string::npos) << json;
  const auto read = parse_status(json, "run.db.status");
  ASSERT_TRUE(read) << text(read.error());
  EXPECT_EQ(read->alarms, status.alarms);
  auto older = json;
  const auto from = older.find(",\"alarms\":");
  older.erase(from, older.find(']', from) - from + 1);
  const auto old = parse_status(older, "run.db.status");
  ASSERT_TRUE(old) << text(old.error());
  EXPECT_TRUE(old->alarms.empty());
}

/// An alarm in a status file of version 0.1.0 is unacknowledged, and may be active.
TEST(Alarms, AreReadFromStatusOf010) {
  auto json = to_json(make_first_status("run.db", two_thermometers()));
  const std::string none = "\"alarms\":[]";
  ASSERT_NE(json.find(none), std::string::npos) << json;
  json.replace(json.find(none), none.size(),
               "\"alarms\":[{\"number\":12,\"slot\":9,\"utc\":\"1970-01-01T00:00:05Z\",\"utc_ns\":5000000000,"
               "\"interlock\":\"door\",\"reaction\":\"suspend\",\"text\":\"door (suspend): open\"}]");
  const auto read = parse_status(json, "run.db.status");
  ASSERT_TRUE(read) << text(read.error());
  ASSERT_EQ(read->alarms.size(), 1u);
  EXPECT_TRUE(read->alarms[0].awaits_acknowledgement());
  EXPECT_TRUE(read->alarms[0].active);
  EXPECT_EQ(read->alarms[0].count, 1);
}

}  // namespace
}  // namespace gyrotherm::record
