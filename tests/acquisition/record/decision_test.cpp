// SPDX-License-Identifier: Apache-2.0
/// Tests the decisions of runs that end by themselves, and the segments that they add to a record.
#include "acquisition/record/decision.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <thread>

#include "acquisition/record/backlog.hpp"
#include "acquisition/record/chain.hpp"
#include "acquisition/record/live_copy.hpp"
#include "acquisition/record/sqlite.hpp"
#include "acquisition/record/status.hpp"
#include "tests/acquisition/record/runs.hpp"

namespace gyrotherm::record {
namespace {

using Segments = std::vector<RunInfo::SegmentInfo>;

Decision make_decision(int number) {
  return {.number = number,
          .block = "cold, fast; U 3 now",
          .target_deg_per_h = 0.012,
          .u_now_deg_per_h = 0.0153,
          .u_expected_deg_per_h = 0.0131,
          .hours_used = 8.42,
          .hours_left = 31.58,
          .blocks = {
              {"cold, fast; U 3 now", 2.1, 0.0131, true}, {"°/h", 5, std::nullopt, true}, {"long", 40, 0.01, false}}};
}

Decision make_end(int number) {
  auto decision = make_decision(number);
  decision.block.clear();
  decision.end = "U is met";
  decision.u_expected_deg_per_h.reset();
  return decision;
}

Event event_of(const Decision& decision, int first) { return decision_event(decision, sample_at(0).at, first); }

const Segments kColdSegments{{"ramp to -40 °C", false, {-40}, {5}, -1}, {"hold -40 °C", true, {-40}, {}, -1}};
const Segments kHome{{"ramp to 20 °C", false, {20}, {2}, -1, "switch the unit off", {.off = true}}};

RunInfo self_ending() {
  auto info = two_thermometers();
  info.goal = {.u_deg_per_h = 0.012, .mission_name = "ship", .mission_text = "a = \"°\"\n", .prior_text = "{}"};
  return info;
}

/// Returns the sample of a slot in a segment.
Sample sample_in(std::int64_t slot, int segment) {
  auto sample = sample_at(slot);
  sample.progress.segment = segment;
  return sample;
}

/// Writes a run with two decisions after its two segments; the second one ends it.
std::unique_ptr<Store> make_grown(const std::string& path, const StoreOptions& options = {}) {
  auto store = Store::create(path, self_ending(), options).value();
  for (int slot = 0; slot < 5; ++slot) EXPECT_TRUE(store->append(sample_in(slot, 1), {}));
  EXPECT_TRUE(store->append_decision(event_of(make_decision(1), 2), kColdSegments));
  for (int slot = 5; slot < 10; ++slot) EXPECT_TRUE(store->append(sample_in(slot, 3), {}));
  EXPECT_TRUE(store->append_decision(event_of(make_end(2), 4), kHome));
  EXPECT_TRUE(store->append(sample_in(10, 4), {}));
  EXPECT_TRUE(store->sync());
  return store;
}

std::vector<std::string> names(const RunInfo& info) {
  std::vector<std::string> all;
  for (const auto& segment : info.segments) all.push_back(segment.name);
  return all;
}

const std::vector<std::string> kAllNames{"warm up", "hold", "ramp to -40 °C", "hold -40 °C", "ramp to 20 °C"};
const std::vector<std::string> kBothBlocks{"cold, fast; U 3 now", ""};

TEST(Decision, TextIsParsedBack) {
  for (auto decision : {make_decision(1), make_end(123)}) {
    EXPECT_EQ(parse_decision(event_of(decision, 0).text), decision) << event_of(decision, 0).text;
    decision.u_now_deg_per_h.reset();
    decision.blocks.clear();
    EXPECT_EQ(parse_decision(event_of(decision, 0).text), decision);
  }
  EXPECT_EQ(event_of(make_decision(3), 7).text,
            "decision 3: continue with \"cold, fast; U 3 now\"; U 0.0153 °/h now, 0.0131 °/h expected, 0.012 °/h "
            "wanted; 8.42 h used, 31.58 h left; \"cold, fast; U 3 now\" 2.1 h 0.0131 °/h; \"°/h\" 5 h unknown; "
            "\"long\" 40 h 0.01 °/h (too long)");
}

TEST(Decision, EveryOtherTextIsRefused) {
  const auto text = event_of(make_decision(1), 0).text;
  int refused = 0;
  for (std::size_t size = 0; size < text.size(); ++size)
    refused += parse_decision(text.substr(0, size)).has_value() ? 0 : 1;
  // Only the ends of whole lists of blocks are complete texts.
  EXPECT_EQ(refused, static_cast<int>(text.size()) - 4) << text;
  for (const auto* other :
       {"", "decision", "decision x: end, ; U ", "decision 1: end, a; U 1e999 °/h now, 1 °/h wanted"})
    EXPECT_FALSE(parse_decision(other)) << other;
  EXPECT_FALSE(parse_decision(text + ";"));
}

TEST(Decision, HoursLeftCountFromDecision) {
  EXPECT_NEAR(hours_left(make_decision(1), 36'000), 30, 1e-9);
  EXPECT_EQ(hours_left(make_decision(1), 1'000'000), 0);
  EXPECT_EQ(describe_progress(make_decision(1), 36'000),
            "U 0.0153 °/h now, 0.0131 °/h expected after \"cold, fast; U 3 now\", 0.012 °/h wanted; at most 30.0 h "
            "left");
  EXPECT_EQ(describe_progress(make_end(2), 0), "U 0.0153 °/h now, 0.012 °/h wanted; the run ends: U is met");
}

TEST(GrownRecord, ContainsAllSegmentsAndBlocks) {
  const Folder folder;
  auto store = make_grown(folder / "run.db");
  EXPECT_EQ(names(store->info()), kAllNames) << "of the open store";
  ASSERT_TRUE(store->finish());
  const auto record = read_record(folder / "run.db").value();
  EXPECT_EQ(names(record.info), kAllNames);
  EXPECT_EQ(record.info.added_blocks, kBothBlocks);
  EXPECT_TRUE(has_ended(record.info));
  EXPECT_EQ(record.info.goal, self_ending().goal);
  EXPECT_TRUE(record.info.segments[4].unit.off);
  EXPECT_EQ(segment_at(record, 10)->prompt, "switch the unit off");
  const auto status = read_status(folder / "run.db").value();
  EXPECT_EQ(status.segment_count, 5);
  EXPECT_EQ(status.decision, make_end(2));
  const auto verified = verify_record(folder / "run.db");
  ASSERT_TRUE(verified) << text(verified.error());
  EXPECT_EQ(verified->rows, 11 + 2);
}

TEST(GrownRecord, IsContinuedByResume) {
  const Folder folder;
  {
    auto store = Store::create(folder / "run.db", self_ending()).value();
    ASSERT_TRUE(store->append(sample_in(0, 1), {}));
    ASSERT_TRUE(store->append_decision(event_of(make_decision(1), 2), kColdSegments));
    ASSERT_TRUE(store->sync());
  }
  EXPECT_EQ(read_info(folder / "run.db").value().added_blocks, std::vector<std::string>{kBothBlocks[0]});
  {
    auto store = Store::reopen(folder / "run.db").value();
    ASSERT_EQ(names(store->info()).size(), 4u);
    ASSERT_TRUE(store->append(sample_in(1, 3), {}));
    ASSERT_TRUE(store->append_decision(event_of(make_end(2), 4), kHome));
    ASSERT_TRUE(store->finish());
  }
  EXPECT_EQ(names(read_info(folder / "run.db").value()), kAllNames);
  EXPECT_TRUE(verify_record(folder / "run.db"));
}

TEST(GrownRecord, LosesDecisionWhoseTransactionWasLost) {
  const Folder folder;
  {
    auto store = Store::create(folder / "run.db", self_ending()).value();
    ASSERT_TRUE(store->append(sample_in(0, 1), {}));
    ASSERT_TRUE(store->sync());
    ASSERT_TRUE(store->append_decision(event_of(make_decision(1), 2), kColdSegments));
  }
  const auto info = read_info(folder / "run.db").value();
  EXPECT_EQ(info.segments.size(), 2u) << "no segment without its decision";
  EXPECT_TRUE(info.added_blocks.empty());
  EXPECT_TRUE(verify_record(folder / "run.db"));
  auto store = Store::reopen(folder / "run.db").value();
  ASSERT_TRUE(store->append_decision(event_of(make_decision(1), 2), kColdSegments)) << "it is made again";
  ASSERT_TRUE(store->finish());
  EXPECT_EQ(read_info(folder / "run.db").value().segments.size(), 4u);
}

TEST(GrownRecord, EndsWithoutClosingSegments) {
  const Folder folder;
  {
    auto store = Store::create(folder / "run.db", self_ending()).value();
    ASSERT_TRUE(store->append(sample_in(0, 1), {}));
    ASSERT_TRUE(store->append_decision(event_of(make_end(1), 2), {}));
    ASSERT_TRUE(store->sync());
  }
  for (int i = 0; i < 2; ++i) {
    const auto info = read_info(folder / "run.db").value();
    EXPECT_EQ(info.added_blocks, std::vector<std::string>{""});
    EXPECT_EQ(info.segments.size(), 2u);
    ASSERT_TRUE(verify_record(folder / "run.db"));
    auto store = Store::reopen(folder / "run.db").value();
    ASSERT_TRUE(store->append(sample_in(1 + i, 1), {}));
    ASSERT_TRUE(store->sync());
  }
}

/// Each edit changes an added segment or a decision; the description itself is unchanged.
TEST(GrownRecord, EveryEditIsDetected) {
  int detected = 0;
  for (const auto* edit :
       {"UPDATE segment SET target_c = 60 WHERE position = 2", "UPDATE segment SET prompt = '' WHERE position = 4",
        "UPDATE segment SET name = 'x' WHERE position = 3", "DELETE FROM segment WHERE position = 4",
        "INSERT INTO segment VALUES(5, 'x', 1, 20, 0, -1, '', 0, 0)", "UPDATE event SET segment = 3 WHERE segment = 4",
        "UPDATE event SET channel = 'hot' WHERE segment = 2", "UPDATE event SET reaction = '' WHERE segment = 4",
        "UPDATE list SET value = '4' WHERE name = 'goal' AND of = 'segments'",
        "UPDATE list SET value = '0.02' WHERE name = 'goal' AND of = 'u_deg_per_h'",
        "DELETE FROM list WHERE name = 'goal' AND of = 'segments'",
        "UPDATE segment SET position = 9 WHERE position = 4"}) {
    const Folder folder;
    ASSERT_TRUE(make_grown(folder / "run.db")->finish());
    std::filesystem::remove(manifest_path(folder / "run.db"));
    {
      auto database = Database::open(folder / "run.db", Access::read_write, 0).value();
      ASSERT_TRUE(database.execute(edit));
    }
    const auto verified = verify_record(folder / "run.db");
    EXPECT_FALSE(verified) << edit;
    detected += verified ? 0 : 1;
  }
  EXPECT_EQ(detected, 12);
}

TEST(GrownRecord, ContinuesInSecondPart) {
  const Folder folder;
  const auto path = folder / "run.db";
  {
    auto store =
        Store::create(path, self_ending(), {.background = true, .retry = std::chrono::milliseconds(20)}).value();
    ASSERT_TRUE(store->append(sample_in(0, 1), {}));
    ASSERT_TRUE(store->append_decision(event_of(make_decision(1), 2), kColdSegments));
    ASSERT_TRUE(store->settle(kLong));
    std::filesystem::remove(path + "-wal");
    ASSERT_TRUE(store->append(sample_in(1, 3), {}));
    ASSERT_TRUE(store->append_decision(event_of(make_end(2), 4), kHome));
    ASSERT_TRUE(store->append(sample_in(2, 4), {}));
    ASSERT_TRUE(store->settle(kLong));
  }
  ASSERT_EQ(last_part(path), 2);
  for (const bool first_is_lost : {false, true}) {
    if (first_is_lost) std::filesystem::resize_file(path, 100);
    const auto record = read_record(path);
    ASSERT_TRUE(record) << text(record.error());
    EXPECT_EQ(names(record->info), kAllNames);
    EXPECT_EQ(record->info.added_blocks, kBothBlocks);
    EXPECT_EQ(names(read_info(path).value()), kAllNames);
    EXPECT_EQ(read_status(path).value().decision, make_end(2));
    EXPECT_EQ(record->progress.back().segment, 4);
  }
}

/// Writes the live copy of a resumed run to a file of its own once it has a slot. Returns false if it never has.
bool saves_live_copy(const std::string& path, std::int64_t slot, const std::string& saved) {
  auto copy = Database::open(live_copy_path(path), Access::read_write, 1000);
  for (int attempt = 0; copy && attempt < 3000; ++attempt) {
    if (copy->query_integer("SELECT max(slot) FROM sample", 0).value_or(-1) >= slot)
      return copy->execute("VACUUM INTO '" + saved + "'").has_value();
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

TEST(GrownRecord, IsInLiveCopyOfResumedRun) {
  const Folder folder;
  const auto path = folder / "run.db";
  make_grown(path).reset();
  auto reopened = Store::reopen(path, {.background = true, .live_copy = LiveCopyOptions{}});
  ASSERT_TRUE(reopened) << text(reopened.error());
  ASSERT_TRUE((*reopened)->append(sample_in(11, 4), {}));
  ASSERT_TRUE((*reopened)->settle(kLong));
  const auto seen = folder / "seen.db";
  ASSERT_TRUE(saves_live_copy(path, 11, seen));
  auto database = Database::open(seen, Access::read_write, 1000);
  ASSERT_TRUE(database) << text(database.error());
  const auto info = read_run_info(*database);
  ASSERT_TRUE(info) << text(info.error());
  EXPECT_EQ(names(*info), kAllNames);
  EXPECT_EQ(info->added_blocks, kBothBlocks);
  const auto checked = check_chain(*database, seen);
  EXPECT_TRUE(checked) << text(checked.error());
}

TEST(GrownRecord, KeepsDecisionWhenMemoryIsFull) {
  Backlog backlog(3);
  auto entry = event_entry(0, event_of(make_decision(1), 2));
  entry.segments = kColdSegments;
  backlog.push(sample_entry(sample_at(0), {}, two_thermometers()));
  backlog.push(std::move(entry));
  for (int slot = 1; slot < 20; ++slot)
    backlog.push(sample_entry(sample_at(slot), std::vector{Event{{}, EventKind::state, "s"}}, two_thermometers()));
  int kept = 0;
  for (const auto& one : backlog.take(backlog.size())) kept += one->segments.size() == 2 ? 1 : 0;
  EXPECT_EQ(kept, 1);
}

TEST(GrownRecord, MemoryHasSameRowsAsFile) {
  const Folder folder;
  Record memory;
  memory.info = self_ending();
  auto store = Store::create(folder / "run.db", self_ending()).value();
  for (int slot = 0; slot < 20; ++slot) {
    if (slot == 7) {
      ASSERT_TRUE(store->append_gap(7, 9, "late"));
    }
    if (slot >= 7 && slot < 10) continue;
    auto sample = sample_at(slot);
    if (slot == 3) sample.thermometers[0].value = failure(FaultKind::timeout, "A", "silent");
    if (slot == 4) sample.units[0].count.value = failure(FaultKind::timeout, "gyro", "silent");
    append_sample(memory, sample);
    ASSERT_TRUE(store->append(sample, {}));
  }
  const auto file = store->read_back().value();
  EXPECT_EQ(memory.slot, file.slot);
  EXPECT_EQ(memory.time_s, file.time_s);
  EXPECT_EQ(memory.chamber_air_c, file.chamber_air_c);
  ASSERT_EQ(memory.gaps.size(), 1u);
  EXPECT_EQ(memory.gaps[0].first, file.gaps[0].first);
  EXPECT_EQ(memory.gaps[0].last, file.gaps[0].last);
  EXPECT_TRUE(memory.progress == file.progress);
  for (std::size_t i = 0; i < file.slot.size(); ++i) {
    for (std::size_t c = 0; c < 2; ++c) {
      const auto a = memory.thermometers_c[c][i], b = file.thermometers_c[c][i];
      EXPECT_TRUE(a == b || (std::isnan(a) && std::isnan(b))) << i;
    }
    const auto a = memory.units[0].rotation[0][i], b = file.units[0].rotation[0][i];
    EXPECT_TRUE(a == b || (std::isnan(a) && std::isnan(b))) << i;
    const auto t = memory.units[0].interval_s[i], u = file.units[0].interval_s[i];
    EXPECT_TRUE(t == u || (std::isnan(t) && std::isnan(u))) << i;
  }
}

}  // namespace
}  // namespace gyrotherm::record
