// SPDX-License-Identifier: Apache-2.0
#include "apps/site/run_text.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>

#include "acquisition/record/row.hpp"
#include "acquisition/record/run_file.hpp"
#include "acquisition/record/status.hpp"
#include "core/json.hpp"
#include "tests/support/folder.hpp"

namespace gyrotherm::site {
namespace {

record::RunInfo thermometer_run() {
  record::RunInfo info;
  info.id = "0123456789abcdef0123456789abcdef";
  info.profile_name = "a profile";
  info.rig_name = "a rig";
  info.virtual_rig = true;
  info.started_utc = kVirtualEpoch;
  info.thermometers = {{"A", "a bridge", Kelvins{0}}};
  info.segments = {{"hold", true, Celsius{20}, {}, -1}};
  return info;
}

/// The rows of a file of the record: the seconds `from` to `end` − 1, the last of which has another state.
struct FileRows {
  std::int64_t from{}, end{};
  RunState last_state{};
  std::string last_event;
};

std::int64_t utc_ns(std::int64_t slot) { return (kVirtualEpoch + std::chrono::seconds(slot)).count(); }

/// Writes the file `part` of a record.
void write_part(const std::string& path, int part, const FileRows& rows, bool is_last) {
  const auto info = thermometer_run();
  std::optional<record::Continuation> continuation;
  if (part > 1)
    continuation = {.part = part,
                    .before = record::name_in_folder(record::part_path(path, part - 1)),
                    .from = rows.from,
                    .cause = "an I/O error"};
  auto file = record::RunFile::create(record::part_path(path, part), info, continuation);
  ASSERT_TRUE(file) << text(file.error());
  auto done = file->begin();
  for (auto slot = rows.from; done && slot < rows.end; ++slot) {
    auto row = record::empty_row(info);
    row.slot = slot;
    row.utc = Duration(utc_ns(slot));
    row.state = slot + 1 == rows.end ? rows.last_state : RunState::execute;
    done = file->insert(row);
  }
  const Event last{.at = {}, .kind = EventKind::finished, .text = rows.last_event};
  done = done.and_then([&] { return file->insert_event(rows.end - 1, last); })
             .and_then([&] { return file->replace_frames({}); })
             .and_then([&] { return file->commit(); });
  if (done && is_last) done = file->finish();
  ASSERT_TRUE(done) << text(done.error());
}

Result<RunEnd> end_of_two_files(const std::string& path, const FileRows& first, const FileRows& second) {
  write_part(path, 1, first, false);
  write_part(path, 2, second, true);
  return record::find_record_files(path).and_then(
      [](const record::RecordFiles& files) { return read_end(thermometer_run(), files); });
}

TEST(RunEnd, IsThatOfLastSampleIfLastFileHasOnlyEvents) {
  for (const auto state : {RunState::stopped, RunState::aborted, RunState::complete}) {
    const tests::TestFolder folder;
    const auto cause = std::string(name(state)) + " by a test";
    const auto end =
        end_of_two_files(folder / "run.db", {.from = 0, .end = 10, .last_state = state, .last_event = "none"},
                         {.from = 10, .end = 10, .last_state = {}, .last_event = cause});
    ASSERT_TRUE(end) << text(end.error());
    EXPECT_TRUE(end->finished);
    EXPECT_EQ(end->state, name(state));
    EXPECT_EQ(end->cause, cause);
    EXPECT_EQ(end->ended_ns, utc_ns(9));
    EXPECT_EQ(end->rows, 10);
    EXPECT_EQ(end->events, 2);
    EXPECT_EQ(end->chain_head.size(), 64u);
  }
}

TEST(RunEnd, IsThatOfLastFileIfItRepeatsSeconds) {
  const tests::TestFolder folder;
  const auto end =
      end_of_two_files(folder / "run.db", {.from = 0, .end = 10, .last_state = RunState::aborted, .last_event = ""},
                       {.from = 5, .end = 8, .last_state = RunState::execute, .last_event = "complete"});
  ASSERT_TRUE(end) << text(end.error());
  EXPECT_EQ(end->state, name(RunState::complete));
  EXPECT_EQ(end->ended_ns, utc_ns(7));
  EXPECT_EQ(end->rows, 8);
}

/// The state of a closed record is that of `gyrotherm status`.
TEST(RunEnd, HasStateOfStatus) {
  for (const auto state : kRunStates) {
    const tests::TestFolder folder;
    const auto path = folder / "run.db";
    write_part(path, 1, {.from = 0, .end = 3, .last_state = state, .last_event = ""}, true);
    const auto status = record::read_status(path);
    const auto end = record::find_record_files(path).and_then(
        [](const record::RecordFiles& files) { return read_end(thermometer_run(), files); });
    ASSERT_TRUE(status && end);
    EXPECT_EQ(end->state, name(status->overview.state));
    EXPECT_EQ(end->state, name(state == RunState::execute ? RunState::complete : state));
  }
}

TEST(RunEnd, IsStartOfRunWithoutSamples) {
  const tests::TestFolder folder;
  write_part(folder / "run.db", 1, {.from = 0, .end = 0, .last_state = {}, .last_event = "aborted"}, true);
  const auto end = record::find_record_files(folder / "run.db").and_then([](const record::RecordFiles& files) {
    return read_end(thermometer_run(), files);
  });
  ASSERT_TRUE(end) << text(end.error());
  EXPECT_EQ(end->ended_ns, kVirtualEpoch.count());
  EXPECT_EQ(end->rows, 0);
}

TEST(RunEnd, FailsWhileRecordIsWritten) {
  const tests::TestFolder folder;
  const auto path = folder / "run.db";
  write_part(path, 1, {.from = 0, .end = 3, .last_state = RunState::execute, .last_event = ""}, false);
  const auto files = record::find_record_files(path);
  ASSERT_TRUE(files);
  const auto writer = record::RunFile::reopen(path);
  ASSERT_TRUE(writer);
  const auto end = read_end(thermometer_run(), *files);
  ASSERT_FALSE(end);
  EXPECT_EQ(end.error().kind, FaultKind::storage);
}

TEST(Rows, HaveNullForUnknownKeyword) {
  const tests::TestFolder folder;
  const auto path = folder / "run.db";
  write_part(path, 1, {.from = 0, .end = 4, .last_state = RunState::complete, .last_event = ""}, true);
  {
    auto database = record::Database::open(path, record::Access::read_write, 0);
    ASSERT_TRUE(database);
    ASSERT_TRUE(
        database->execute("UPDATE sample SET state = 'melting' WHERE slot = 1; "
                          "UPDATE sample SET state = NULL, phase = 'cooking' WHERE slot = 2"));
  }
  const std::vector<StoredChannel> channels{{.name = "state", .keywords = {"execute", "suspended", "complete"}},
                                            {.name = "phase", .keywords = {"ramp", "hold"}}};
  const auto files = record::find_record_files(path);
  ASSERT_TRUE(files);
  const auto rows = read_rows(*files, channels, -1);
  ASSERT_TRUE(rows) << text(rows.error());
  EXPECT_EQ(rows->slots, "{0,1,2,3}");
  EXPECT_EQ(rows->numbers, R"({"{0,NULL}","{NULL,NULL}","{NULL,NULL}","{2,NULL}"})");
}

TEST(Rows, HavePositionOfEveryState) {
  const auto channels = stored_channels(thermometer_run());
  const auto state = std::ranges::find(channels, "state", &StoredChannel::name);
  ASSERT_NE(state, channels.end());
  for (const auto one : kRunStates) {
    const tests::TestFolder folder;
    const auto path = folder / "run.db";
    write_part(path, 1, {.from = 0, .end = 1, .last_state = one, .last_event = ""}, true);
    const auto files = record::find_record_files(path);
    ASSERT_TRUE(files);
    const auto rows = read_rows(*files, {*state}, -1);
    ASSERT_TRUE(rows);
    EXPECT_EQ(rows->numbers, "{\"{" + std::to_string(static_cast<int>(one)) + "}\"}");
  }
}

}  // namespace
}  // namespace gyrotherm::site
