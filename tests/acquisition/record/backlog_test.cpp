// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/backlog.hpp"

#include <gtest/gtest.h>

#include <numeric>
#include <random>

#include "tests/acquisition/record/runs.hpp"

namespace gyrotherm::record {
namespace {

Entry row(std::int64_t slot, std::vector<Event> events = {}) {
  return sample_entry(sample_at(slot), events, two_thermometers());
}

Event make_event(EventKind kind) { return {{}, kind, "an event"}; }

/// Returns the content as "0 1 [2–4] 5": rows, and gaps in brackets.
std::string describe(Backlog& backlog) {
  std::string all;
  for (const auto& entry : backlog.take(backlog.size())) {
    if (entry->slots() == 0) continue;
    if (!all.empty()) all += ' ';
    all += entry->is_gap() ? "[" + std::to_string(entry->first) + "-" + std::to_string(entry->last) + "]"
                           : std::to_string(entry->first);
  }
  backlog.put_back();
  return all;
}

TEST(Backlog, ReturnsEntriesUntilAcknowledged) {
  Backlog backlog(10);
  for (int slot = 0; slot < 4; ++slot) backlog.push(row(slot));
  EXPECT_EQ(backlog.take(3).size(), 3u);
  backlog.put_back();
  EXPECT_EQ(backlog.take(3).front()->first, 0);
  backlog.acknowledge();
  EXPECT_EQ(backlog.take(3).front()->first, 3);
}

TEST(Backlog, ReplacesOldestRowsByOneGapWhenFull) {
  Backlog backlog(4);
  for (int slot = 0; slot < 10; ++slot) backlog.push(row(slot));
  EXPECT_EQ(describe(backlog), "[0-6] 7 8 9");
  EXPECT_EQ(backlog.dropped(), 7u);
  EXPECT_EQ(backlog.take(1).front()->gap_cause, kDropped);
}

TEST(Backlog, KeepsRowsWithSafetyEvent) {
  Backlog backlog(4);
  for (int slot = 0; slot < 10; ++slot)
    backlog.push(slot == 1 ? row(slot, {make_event(EventKind::interlock)}) : row(slot, {make_event(EventKind::note)}));
  EXPECT_EQ(describe(backlog), "[0-0] 1 [2-8] 9");
}

TEST(Backlog, DropsOldestRowWhenAllHaveSafetyEvents) {
  Backlog backlog(4);
  for (int slot = 0; slot < 8; ++slot) backlog.push(row(slot, {make_event(EventKind::command)}));
  EXPECT_EQ(describe(backlog), "[0-4] 5 6 7");
}

TEST(Backlog, NeverDropsEntriesInFlight) {
  Backlog backlog(3);
  for (int slot = 0; slot < 3; ++slot) backlog.push(row(slot));
  ASSERT_EQ(backlog.take(2).size(), 2u);
  for (int slot = 3; slot < 9; ++slot) backlog.push(row(slot));
  backlog.acknowledge();
  EXPECT_EQ(describe(backlog), "[2-6] 7 8");
}

TEST(Backlog, KeepsEverySlotWithinBound) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    std::mt19937 random(seed);
    const std::size_t most = 2 + random() % 20;
    Backlog backlog(most);
    std::int64_t next = 0;
    std::int64_t acknowledged = 0;
    std::size_t in_flight = 0;
    for (int step = 0; step < 300; ++step) {
      const auto what = random() % 20;
      if (what < 12) backlog.push(row(next++));
      if (what == 12) backlog.push(row(next++, {make_event(EventKind::state)}));
      if (what == 13) backlog.push(event_entry(next - 1, make_event(EventKind::note)));
      if (what == 14) backlog.push(gap_entry(next, next + 2, "late")), next += 3;
      if (what == 15 || what == 16) in_flight = backlog.take(random() % 10).size();
      if (what == 17) backlog.put_back(), in_flight = 0;
      if (what == 18) {
        for (const auto& entry : backlog.take(in_flight)) acknowledged += entry->slots();
        backlog.acknowledge();
        in_flight = 0;
      }
    }
    backlog.put_back();
    std::int64_t expected = acknowledged;
    for (const auto& entry : backlog.take(backlog.size())) {
      ASSERT_EQ(entry->first, entry->slots() == 0 ? entry->first : expected) << "seed " << seed;
      expected += entry->slots();
    }
    EXPECT_EQ(expected, next) << "seed " << seed;
  }
}

}  // namespace
}  // namespace gyrotherm::record
