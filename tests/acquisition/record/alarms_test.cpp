// SPDX-License-Identifier: Apache-2.0
/// Alarms stand until they are acknowledged, whatever becomes of the programs that saw them.
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

Event seen(const Alarm& alarm) { return acknowledgement_of(alarm, sample_at(0).at, {}, "ada (uid 1000)", "seen"); }

TEST(Alarms, AreWhatInterlocksDidUntilAcknowledged) {
  Alarms alarms;
  alarms.see(numbered(3, interlock("door", "door (suspend): open")));
  alarms.see(numbered(4, {sample_at(0).at, EventKind::fault, "A: no reply", {.channel = "A"}}));
  alarms.see(numbered(5, {sample_at(0).at, EventKind::fault, "lag (warn)", {.interlock = "lag", .reaction = "warn"}}));
  alarms.see(numbered(6, {sample_at(0).at, EventKind::recovered, "door is over", {.interlock = "door"}}));
  EXPECT_EQ(numbers(alarms.standing()), (std::vector<std::int64_t>{3, 5})) << "what is over is still to be seen";
  EXPECT_EQ(alarms.objection(3), "");
  alarms.see(numbered(7, seen(alarms.standing()[0])));
  EXPECT_EQ(numbers(alarms.standing()), std::vector<std::int64_t>{5});
  EXPECT_EQ(alarms.objection(3), "alarm 3 is acknowledged already");
  EXPECT_TRUE(alarms.objection(4).starts_with("there is no alarm 4;")) << alarms.objection(4);
}

TEST(Alarms, NothingButAnAcknowledgementTakesOneAway) {
  Alarms alarms;
  alarms.see(numbered(1, interlock("door", "door (suspend): open")));
  alarms.see(numbered(2, {sample_at(0).at, EventKind::note, "alarm 1 acknowledged by ada: forged"}));
  for (const auto* text :
       {"alarm 1", "alarm 12 acknowledged by ada: x", "alarm  1 acknowledged by ada: x", "alarm x", ""})
    alarms.see(numbered(3, {sample_at(0).at, EventKind::acknowledged, text}));
  EXPECT_EQ(alarms.standing().size(), 1u);
}

TEST(Alarms, AreBounded) {
  Alarms alarms;
  for (int i = 1; i <= 300; ++i) alarms.see(numbered(i, interlock("door", "door (suspend): open")));
  ASSERT_EQ(alarms.standing().size(), Alarms::kMost);
  EXPECT_EQ(alarms.standing().back().number, 300);
}

/// A thermometer that comes and goes warns a hundred times in a night.
TEST(Alarms, ThoseThatOnlyWarnCrowdNoGraverOneOut) {
  Alarms alarms;
  alarms.see(numbered(1, interlock("door", "door (suspend): open")));
  const Event warning{sample_at(0).at, EventKind::fault, "lost (warn)", {.interlock = "lost", .reaction = "warn"}};
  for (int i = 2; i <= 300; ++i) alarms.see(numbered(i, warning));
  ASSERT_EQ(alarms.standing().size(), Alarms::kMost);
  EXPECT_EQ(alarms.standing().front().number, 1);
  EXPECT_EQ(alarms.standing().back().number, 300);
  EXPECT_EQ(alarms.objection(2), "alarm 2 left the list, which holds 256, for later ones")
      << "nobody has acknowledged it";
}

TEST(Alarms, OutliveTheProgramThatSawThem) {
  for (const bool background : {false, true}) {
    const Folder folder;
    const auto path = folder / "run.db";
    std::vector<Alarm> standing;
    {
      auto store = Store::create(path, two_thermometers(), {.background = background});
      ASSERT_TRUE(store) << text(store.error());
      const std::vector<Event> two{interlock("door", "door (suspend): open"), interlock("lag", "lag (suspend): 9 K")};
      ASSERT_TRUE((*store)->append(sample_at(0), two));
      ASSERT_TRUE((*store)->append(sample_at(1), {}));
      standing = (*store)->alarms().standing();
      ASSERT_EQ(standing.size(), 2u);
      ASSERT_TRUE((*store)->append_event(seen(standing[0])));
      ASSERT_EQ((*store)->alarms().standing().size(), 1u);
      ASSERT_TRUE((*store)->settle(5s));
    }
    const auto told = read_status(path);
    ASSERT_TRUE(told) << text(told.error());
    ASSERT_EQ(told->alarms.size(), 1u);
    EXPECT_EQ(told->alarms[0], standing[1]) << "its number is that of the event in the record";
    auto again = Store::reopen(path, {.background = background});
    ASSERT_TRUE(again) << text(again.error());
    EXPECT_EQ((*again)->alarms().standing(), told->alarms);
    EXPECT_EQ((*again)->alarms().objection(standing[0].number),
              fmt::format("alarm {} is acknowledged already", standing[0].number));
    ASSERT_TRUE((*again)->append_event(interlock("door", "door (suspend): open again")));
    EXPECT_GT((*again)->alarms().standing().back().number, standing[1].number);
  }
}

TEST(Alarms, StandInTheStatusFileAndAnOlderOneHasNone) {
  RunStatus status = first_status("run.db", two_thermometers());
  status.alarms = {{.number = 12, .slot = 9, .utc = 5s, .interlock = "door", .reaction = "suspend", .text = "open"}};
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

}  // namespace
}  // namespace gyrotherm::record
