// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/status.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <optional>
#include <random>

#include "acquisition/record/chain.hpp"
#include "tests/acquisition/record/runs.hpp"

/// A truncated log contains a record that is consistent; only the acknowledged second shows the loss.
namespace gyrotherm::record {
namespace {

TEST(Status, SurvivesJsonUnchanged) {
  RunStatus status;
  status.path = "a \"quoted\" run.db";
  status.pid = 42;
  status.being_written = true;
  status.slot = 7;
  status.acknowledged = 7;
  status.segment = "hold at −40 °C";
  status.segment_index = 3;
  status.segment_count = 9;
  status.phase = Phase::overdue;
  status.set_point = Celsius{-40};
  status.thermometers = {{"B", Celsius{1.5}}, {"A", std::nullopt}};
  status.faults = 2;
  status.frames = FrameCount{.seen = 1000, .lost = 3, .bad = 1};
  status.overview.stopped_by_operator = true;
  const auto back = parse_status(to_json(status), "here");
  ASSERT_TRUE(back) << text(back.error());
  EXPECT_EQ(to_json(*back), to_json(status));
  EXPECT_EQ(back->thermometers[0].first, "B") << "the order of the rig";
  EXPECT_FALSE(back->chamber_air);
  EXPECT_EQ(back->phase, Phase::overdue);
  EXPECT_EQ(back->frames, status.frames);
}

TEST(Status, MarksRunWithVirtualInstrumentsInRealTime) {
  RunInfo info = two_thermometers();
  EXPECT_TRUE(is_in_virtual_time(make_first_status("run.db", info)));
  info.virtual_rig = false;
  EXPECT_FALSE(make_first_status("run.db", info).simulated);
  EXPECT_FALSE(is_in_virtual_time(make_first_status("run.db", info)));
  info.virtual_instruments = {"chamber", "gyro"};
  const auto json = to_json(make_first_status("run.db", info));
  const auto back = parse_status(json, "here").value();
  EXPECT_TRUE(back.simulated);
  EXPECT_FALSE(is_in_virtual_time(back));
  EXPECT_EQ(back.virtual_instruments, info.virtual_instruments);
  // The status file of an earlier version
  auto old = json;
  const std::string member = R"("virtual_instruments":["chamber","gyro"])";
  const auto at = old.find(member);
  ASSERT_NE(at, std::string::npos) << old;
  old.replace(at, member.size(), R"("former":0)");
  const auto read = parse_status(old, "here");
  ASSERT_TRUE(read) << text(read.error());
  EXPECT_TRUE(is_in_virtual_time(*read)) << "earlier versions marked only virtual rigs";
}

TEST(Status, StatesWhetherOperatorStoppedRun) {
  RunStatus status;
  status.overview.state = RunState::aborting;
  const auto unknown = to_json(status);
  EXPECT_EQ(unknown.find("stopped_by_operator"), std::string::npos) << "as in a file of an earlier version";
  EXPECT_FALSE(parse_status(unknown, "here").value().overview.stopped_by_operator.has_value());
  for (const bool is_stop : {false, true}) {
    status.overview.stopped_by_operator = is_stop;
    EXPECT_EQ(parse_status(to_json(status), "here").value().overview.stopped_by_operator, is_stop);
  }
}

TEST(Status, RefusesOtherText) {
  for (const char* text :
       {"", "{", "[]", "{}", R"({"schema": 1})", R"({"schema": "gyrotherm-status/1", "pid": "x"})"}) {
    const auto status = parse_status(text, "here");
    ASSERT_FALSE(status) << text;
    EXPECT_EQ(status.error().kind, FaultKind::bad_file);
    EXPECT_TRUE(status.error().where.starts_with("here")) << status.error().where;
  }
}

TEST(Status, FollowsEachSync) {
  const Folder folder;
  const auto store = store_with(folder / "run.db", 3);
  const auto told = [&] {
    std::ifstream file(status_path(folder / "run.db"));
    return parse_status(std::string(std::istreambuf_iterator<char>(file), {}), "status").value();
  };
  EXPECT_EQ(told().acknowledged, 2);
  Sample sample = sample_at(3);
  sample.thermometers[1].value = failure(FaultKind::timeout, "shell-1.b", "silent");
  ASSERT_TRUE(store->append(sample, {}));
  EXPECT_EQ(told().acknowledged, 2) << "not synced yet";
  ASSERT_TRUE(store->sync());
  const RunStatus status = told();
  EXPECT_EQ(status.acknowledged, 3);
  EXPECT_EQ(status.slot, 3);
  EXPECT_EQ(status.pid, ::getpid());
  EXPECT_TRUE(status.being_written && status.simulated && !status.finished);
  EXPECT_EQ(status.segment, "hold");
  EXPECT_EQ(status.segment_index, 1);
  EXPECT_EQ(status.segment_count, 2);
  EXPECT_EQ(status.phase, Phase::waiting_for_soak);
  EXPECT_EQ(status.set_point, Celsius{22.5});
  EXPECT_EQ(status.thermometers[0].second, sample.thermometers[0].value.value());
  EXPECT_FALSE(status.thermometers[1].second);
  EXPECT_EQ(status.faults, 1);
}

/// Segment 1 of the profile switches the unit off.
TEST(Status, CountsFaultsOfSwitchedOffUnitsApart) {
  const Folder folder;
  auto info = two_thermometers();
  info.segments[1].unit.off = true;
  auto store = Store::create(folder / "run.db", info).value();
  for (std::int64_t slot = 0; slot < 6; ++slot) {
    Sample sample = sample_at(slot);
    sample.progress.segment = slot < 2 ? 0 : 1;
    if (slot > 0) sample.units[0].count.value = failure(FaultKind::timeout, "gyro", "silent");
    if (slot == 5) sample.thermometers[0].value = failure(FaultKind::timeout, "A", "silent");
    ASSERT_TRUE(store->append(sample, {}));
  }
  ASSERT_TRUE(store->sync());
  std::ifstream file(status_path(folder / "run.db"));
  const auto live = parse_status(std::string(std::istreambuf_iterator<char>(file), {}), "status").value();
  EXPECT_EQ(live.faults, 6);
  EXPECT_EQ(live.faults_while_off, 4) << "one is before the segment, one is of a thermometer";
  ASSERT_TRUE(store->finish());
  store.reset();
  std::filesystem::remove(status_path(folder / "run.db"));
  const auto stored = read_status(folder / "run.db").value();
  EXPECT_EQ(stored.faults, 6);
  EXPECT_EQ(stored.faults_while_off, 4);
}

TEST(Status, ComesFromRecordWhenRunIsFinished) {
  const Folder folder;
  auto store = store_with(folder / "run.db", 4);
  ASSERT_TRUE(store->finish());
  store.reset();
  std::filesystem::remove(status_path(folder / "run.db"));
  const auto status = read_status(folder / "run.db");
  ASSERT_TRUE(status) << text(status.error());
  EXPECT_TRUE(status->finished && !status->being_written);
  EXPECT_EQ(status->overview.state, RunState::complete);
  EXPECT_EQ(status->slot, 3);
  EXPECT_EQ(status->acknowledged, 3);
  EXPECT_EQ(status->segment, "hold");
  EXPECT_EQ(status->thermometers[1].second, Celsius{-0.1});
  EXPECT_EQ(status->chamber_air, sample_at(3).chamber.value->air);
}

TEST(Status, IsCompleteWhenRunFinishedBeforeFirstSample) {
  const Folder folder;
  auto store = store_with(folder / "run.db", 0);
  EXPECT_EQ(read_status(folder / "run.db")->overview.state, RunState::execute);
  ASSERT_TRUE(store->finish());
  store.reset();
  std::filesystem::remove(status_path(folder / "run.db"));
  const auto status = read_status(folder / "run.db");
  ASSERT_TRUE(status) << text(status.error());
  EXPECT_TRUE(status->finished);
  EXPECT_EQ(status->overview.state, RunState::complete);
}

TEST(Status, AddsFramesOfAllProgramsOfRun) {
  const Folder folder;
  auto store = store_with(folder / "run.db", 2);
  Sample sample = sample_at(2);
  sample.units[0].frames = {.seen = 3000, .lost = 2, .bad = 1};
  ASSERT_TRUE(store->append(sample, {}) && store->sync());
  store.reset();
  store = Store::reopen(folder / "run.db").value();
  sample = sample_at(3);
  sample.units[0].frames = {.seen = 1000, .lost = 5, .bad = 0};
  ASSERT_TRUE(store->append(sample, {}) && store->sync());
  ASSERT_TRUE(store->finish());
  store.reset();
  const FrameCount all{.seen = 4000, .lost = 7, .bad = 1};
  EXPECT_EQ(read_status(folder / "run.db")->frames, all);
}

TEST(Status, FileReportsFinishedRun) {
  const Folder folder;
  const auto store = store_with(folder / "run.db", 1);
  ASSERT_TRUE(store->finish());
  std::ifstream file(status_path(folder / "run.db"));
  const auto status = parse_status(std::string(std::istreambuf_iterator<char>(file), {}), "status").value();
  EXPECT_TRUE(status.finished && !status.being_written);
}

TEST(Status, ReportsMissingRecordAsBadFile) {
  const Folder folder;
  EXPECT_EQ(read_status(folder / "missing").error().kind, FaultKind::bad_file);
}

}  // namespace

namespace {

constexpr int kUnfoldedSeconds = 40;  ///< too few for a checkpoint

/// Leaves an unfinished run of a dead writer, with one transaction per second.
void leave_unfinished_run(const std::string& path) {
  if (const auto child = ::fork(); child != 0) {
    ASSERT_EQ(::waitpid(child, nullptr, 0), child);
    return;
  }
  auto store = Store::create(path, two_thermometers());
  for (int slot = 0; store && slot < kUnfoldedSeconds; ++slot) {
    (void)(*store)->append(sample_at(slot), {});
    (void)(*store)->sync();
  }
  ::_exit(0);
}

std::string find_lost_end(const std::string& path) {
  const auto lost = find_record_files(path).and_then(lost_end);
  if (!lost) return text(lost.error());
  return *lost ? describe(**lost) : "nothing";
}

TEST(LostEnd, IsFoundWhereverLogIsTruncated) {
  const Folder folder;
  const auto path = folder / "run.db";
  leave_unfinished_run(path);
  ASSERT_EQ(find_lost_end(path), "nothing");
  const auto whole = std::filesystem::file_size(path + "-wal");
  std::filesystem::copy_file(path + "-wal", folder / "log");
  std::mt19937_64 random(16);
  for (int i = 0; i < 100; ++i) {
    std::filesystem::copy_file(folder / "log", path + "-wal", std::filesystem::copy_options::overwrite_existing);
    std::filesystem::resize_file(path + "-wal", random() % whole);
    const auto last = read_record(path)->slot.size();
    ASSERT_LT(last, static_cast<std::size_t>(kUnfoldedSeconds));
    const auto words = "ends at second " + std::to_string(static_cast<int>(last) - 1) +
                       ", but second 39 was acknowledged: its end is lost";
    EXPECT_EQ(find_lost_end(path), words);
    const auto verified = verify_record(path);
    ASSERT_FALSE(verified);
    EXPECT_EQ(verified.error().kind, FaultKind::bad_file);
    EXPECT_EQ(verified.error().what, words);
  }
}

TEST(LostEnd, IsReportedOnlyByStatusOfSameRun) {
  const Folder folder;
  const auto path = folder / "run.db";
  leave_unfinished_run(path);
  std::filesystem::remove(path + "-wal");
  const auto status = parse_status(
                          [&] {
                            std::ifstream file(status_path(path));
                            return std::string(std::istreambuf_iterator<char>(file), {});
                          }(),
                          "status")
                          .value();
  EXPECT_NE(find_lost_end(path), "nothing");
  auto other = status;
  other.id = "another";
  ASSERT_TRUE(write_status(other));
  EXPECT_EQ(find_lost_end(path), "nothing");
  std::ofstream(status_path(path)) << "[[[[";
  EXPECT_EQ(find_lost_end(path), "nothing");
  std::filesystem::remove(status_path(path));
  EXPECT_EQ(find_lost_end(path), "nothing");
  ASSERT_TRUE(write_status(status));
  auto store = Store::reopen(path).value();
  ASSERT_TRUE(store->finish());
  store.reset();
  ASSERT_TRUE(write_status(status));
  EXPECT_EQ(find_lost_end(path), "nothing") << "a finished run states its end";
}

namespace fs = std::filesystem;

/// Leaves an unfinished run whose writer noted `last` in its last second. A dead writer leaves its log.
void leave_run(const std::string& path, std::optional<EventKind> last, bool is_dead) {
  const auto child = ::fork();
  if (child != 0) {
    ASSERT_EQ(::waitpid(child, nullptr, 0), child);
    return;
  }
  {
    auto store = Store::create(path, two_thermometers());
    if (!store) ::_exit(1);
    for (int slot = 0; slot < 5; ++slot) {
      std::vector<Event> events;
      if (slot == 0) events.push_back({{}, EventKind::started, "begun"});
      if (slot == 4 && last) events.push_back({{}, *last, "ended"});
      (void)(*store)->append(sample_at(slot), events);
      (void)(*store)->sync();
    }
    if (is_dead) ::_exit(0);
  }
  ::_exit(0);
}

std::string find_missing(const std::string& path) {
  const auto missing = find_record_files(path).and_then(missing_files);
  if (!missing) return text(missing.error());
  return missing->empty() ? "nothing" : describe_missing(*missing);
}

TEST(MissingFiles, AreNamedWhenRecordWasMovedAlone) {
  const Folder folder;
  const auto path = folder / "run.db", moved = folder / "v/run.db";
  fs::create_directory(folder / "v");
  leave_run(path, std::nullopt, true);
  EXPECT_EQ(find_missing(path), "nothing");
  fs::copy_file(path, moved);
  EXPECT_EQ(find_missing(moved), "run.db-wal and run.db.status are missing; move all files of a record together");
  fs::copy_file(status_path(path), status_path(moved));
  EXPECT_EQ(find_missing(moved), "run.db-wal is missing; move all files of a record together");
  fs::copy_file(path + "-wal", moved + "-wal");
  EXPECT_EQ(find_missing(moved), "nothing");
  fs::remove(status_path(moved));
  EXPECT_EQ(find_missing(moved), "nothing") << "the log has every second";
  fs::create_symlink(path, folder / "link.db");
  EXPECT_EQ(find_missing(folder / "link.db"), "nothing") << "the log is beside the target";
}

TEST(MissingFiles, AreNamedWhenOtherProgramReplacedStatusFile) {
  const Folder folder;
  const auto path = folder / "run.db";
  leave_run(path, EventKind::resumed, true);
  fs::remove(path + "-wal");
  auto other = read_status_file(path).value();
  other.id = "another";
  ASSERT_TRUE(write_status(other));
  EXPECT_NE(find_missing(path).find("run.db-wal and run.db.status"), std::string::npos);
}

TEST(MissingFiles, AreNoneInFilesThatWereClosedInOrder) {
  const Folder folder;
  for (const auto kind : {EventKind::interrupted, EventKind::finished}) {
    const auto path = folder / name(kind);
    leave_run(path, kind, false);
    ASSERT_FALSE(fs::exists(path + "-wal")) << "was copied into the record";
    EXPECT_EQ(find_missing(path), "nothing") << name(kind);
    fs::remove(status_path(path));
    EXPECT_EQ(find_missing(path), "nothing") << name(kind);
    fs::permissions(path, fs::perms::owner_read);
    EXPECT_EQ(find_missing(path), "nothing") << name(kind);
  }
}

TEST(MissingFiles, ReportsNoneWhenOtherProgramCopiedLog) {
  const Folder folder;
  const auto path = folder / "run.db";
  leave_run(path, std::nullopt, true);
  ASSERT_TRUE(Database::open(path, Access::read_write, 0).value().query_text("PRAGMA wal_checkpoint(TRUNCATE)"));
  ASSERT_FALSE(fs::exists(path + "-wal"));
  EXPECT_EQ(find_missing(path), "nothing") << "the status file acknowledges no later second";
}

TEST(MissingFiles, AreNoneInRecordWithoutEvents) {
  const Folder folder;
  const auto path = folder / "run.db";
  store_with(path, 4).reset();
  fs::remove(status_path(path));
  EXPECT_EQ(find_missing(path), "nothing");
}

}  // namespace

}  // namespace gyrotherm::record
