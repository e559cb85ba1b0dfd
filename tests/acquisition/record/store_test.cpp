// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/store.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>

#include "acquisition/record/alarms.hpp"
#include "acquisition/record/chain.hpp"
#include "acquisition/record/csv.hpp"
#include "acquisition/record/record_files.hpp"
#include "acquisition/record/run_file.hpp"
#include "acquisition/record/status.hpp"
#include "core/file.hpp"
#include "tests/acquisition/record/runs.hpp"

namespace gyrotherm::record {
namespace {

TEST(Store, NeverOverwritesFile) {
  const Folder folder;
  std::ofstream(folder / "run.db") << "precious";
  const auto store = Store::create(folder / "run.db", two_thermometers());
  ASSERT_FALSE(store);
  EXPECT_EQ(store.error().kind, FaultKind::storage);
  EXPECT_EQ(read_text_file(folder / "run.db").value(), "precious");
}

/// The earlier record was moved away without its manifest.
TEST(Store, RemovesManifestOfEarlierRecord) {
  const Folder folder;
  const auto path = folder / "run.db";
  ASSERT_TRUE(store_with(path, 3)->finish());
  ASSERT_TRUE(path_exists(manifest_path(path)));
  EXPECT_FALSE(Store::create(path, two_thermometers()));
  EXPECT_TRUE(path_exists(manifest_path(path))) << "that record still exists";
  std::filesystem::rename(path, folder / "moved.db");
  store_with(path, 5).reset();
  EXPECT_FALSE(path_exists(manifest_path(path)));
  const auto verified = verify_record(path);
  ASSERT_TRUE(verified) << text(verified.error());
  EXPECT_FALSE(verified->manifest);
  auto again = Store::reopen(path);
  ASSERT_TRUE(again) << text(again.error());
  ASSERT_TRUE((*again)->finish());
  again->reset();
  EXPECT_TRUE(verify_record(path)->manifest);
}

TEST(Store, ReopenedRecordHasNoCauseOfItsEarlierEnd) {
  for (const bool background : {false, true}) {
    const Folder folder;
    const auto path = folder / "run.db";
    auto store = Store::create(path, two_thermometers(), {.background = background});
    ASSERT_TRUE(store) << text(store.error());
    ASSERT_TRUE((*store)->append(sample_at(0), {}));
    ASSERT_TRUE((*store)->append_event({sample_at(0).at, EventKind::interrupted, "stopped by a signal"}));
    ASSERT_TRUE((*store)->settle(std::chrono::seconds(10)));
    store->reset();
    EXPECT_EQ(read_status(path)->ended_by, "stopped by a signal");
    auto again = Store::reopen(path, {.background = background});
    ASSERT_TRUE(again) << text(again.error());
    ASSERT_TRUE((*again)->append(sample_at(1), {}));
    ASSERT_TRUE((*again)->settle(std::chrono::seconds(10)));
    ASSERT_TRUE((*again)->sync());
    EXPECT_EQ(read_status_file(path)->ended_by, "") << background;
  }
}

TEST(Store, StatusOfDeadRunQuotesOnlyEventThatEndsRun) {
  const auto cause_after = [](EventKind kind, const std::string& text, const std::string& reaction) {
    const Folder folder;
    const auto path = folder / "run.db";
    auto store = store_with(path, 3);
    Event event{sample_at(2).at, kind, text};
    event.about.reaction = reaction;
    EXPECT_TRUE(store->append_event(event));
    EXPECT_TRUE(store->sync());
    store.reset();
    return read_status(path)->ended_by;
  };
  EXPECT_EQ(cause_after(EventKind::state, "execute: the profile continues", ""), "");
  EXPECT_EQ(cause_after(EventKind::state, "suspended: chamber silent", ""), "");
  EXPECT_EQ(cause_after(EventKind::state, "held by Ada: lunch", ""), "");
  EXPECT_EQ(cause_after(EventKind::interlock, "following (suspend): the air does not follow", "suspend"), "");
  EXPECT_EQ(cause_after(EventKind::interlock, "air_high (abort): 91 °C", "abort"), "air_high (abort): 91 °C");
  EXPECT_EQ(cause_after(EventKind::state, "aborted: air_high", ""), "aborted: air_high");
  EXPECT_EQ(cause_after(EventKind::state, "aborting: air_high", ""), "aborting: air_high");
  EXPECT_EQ(cause_after(EventKind::state, "stopped by Ada", ""), "stopped by Ada");
}

/// A stopped run ends with a note if its unit is too cold to be touched, and may warn while it ends.
TEST(Store, StatusOfEndedRunQuotesCauseBeforeNotesAndWarnings) {
  using Events = std::vector<std::pair<EventKind, std::string>>;
  const auto status_after = [](const Events& events) {
    const Folder folder;
    const auto path = folder / "run.db";
    const auto store = store_with(path, 3);
    for (const auto& [kind, text] : events) {
      Event event{sample_at(2).at, kind, text};
      if (kind == EventKind::interlock) event.about.reaction = "warn";
      EXPECT_TRUE(store->append_event(event));
    }
    EXPECT_TRUE(store->finish());
    return *read_status(path);
  };
  const std::pair stopped{EventKind::state, std::string("stopped by Ada")};
  for (const auto kind : {EventKind::note, EventKind::interlock, EventKind::acknowledged, EventKind::told,
                          EventKind::fault, EventKind::recovered, EventKind::command}) {
    const auto status = status_after({stopped, {kind, "later"}, {kind, "still later"}});
    EXPECT_EQ(status.ended_by, "stopped by Ada") << name(kind);
    EXPECT_EQ(status.overview.state, RunState::stopped) << name(kind);
  }
  EXPECT_EQ(status_after({stopped, {EventKind::resumed, "continues"}, {EventKind::note, "n"}}).ended_by, "");
  const auto complete = status_after({{EventKind::note, "the unit is too cold"}});
  EXPECT_EQ(complete.ended_by, "");
  EXPECT_EQ(complete.overview.state, RunState::complete);
}

TEST(Store, ContinuesWithoutStatusFile) {
  for (const bool background : {false, true}) {
    const Folder folder;
    const auto path = folder / "run.db";
    std::filesystem::create_directories(status_path(path));
    auto store = Store::create(path, two_thermometers(), {.background = background});
    ASSERT_TRUE(store) << text(store.error());
    ASSERT_TRUE((*store)->append(sample_at(0), {}));
    ASSERT_TRUE((*store)->finish());
    store->reset();
    EXPECT_TRUE(read_record(path)->finished);
  }
}

TEST(Store, RefusesSlotsThatDoNotIncrease) {
  const Folder folder;
  const auto store = store_with(folder / "run.db", 3);
  for (const std::int64_t slot : {2, 0}) {
    const auto again = store->append(sample_at(slot), {});
    ASSERT_FALSE(again);
    EXPECT_EQ(again.error().kind, FaultKind::storage);
  }
  EXPECT_TRUE(store->append(sample_at(3), {})) << "a refused sample has no effect";
}

TEST(Store, RefusesSkippedSlots) {
  const Folder folder;
  const auto store = store_with(folder / "run.db", 3);
  const auto jump = store->append(sample_at(5), {});
  ASSERT_FALSE(jump);
  EXPECT_EQ(text(jump.error()), "slot 5: slots 3 to 4 have neither a sample nor a gap");
  EXPECT_FALSE(store->append_gap(2, 4, "overlaps"));
  EXPECT_TRUE(store->append_gap(3, 4, "late"));
  EXPECT_TRUE(store->append(sample_at(5), {}));
  EXPECT_FALSE(store->append_gap(6, 2'000'000'000, "the clock was wrong")) << "a record of it would be unreadable";
  EXPECT_TRUE(store->append(sample_at(6), {}));
  EXPECT_EQ(store->sync().value(), 6);
}

TEST(Store, AcknowledgesNothingBeforeSync) {
  const Folder folder;
  auto store = store_with(folder / "run.db", 2);
  ASSERT_TRUE(store->append(sample_at(2), {}));
  store.reset();
  EXPECT_EQ(read_record(folder / "run.db").value().slot.back(), 1);
}

TEST(Store, AcknowledgesMinusOneWithoutSample) {
  const Folder folder;
  const auto store = store_with(folder / "run.db", 0);
  EXPECT_EQ(store->sync().value(), -1);
}

TEST(Store, IsSingleFileWhenFinished) {
  const Folder folder;
  auto store = store_with(folder / "run.db", 100);
  ASSERT_TRUE(store->finish());
  store.reset();
  EXPECT_FALSE(std::filesystem::exists(folder / "run.db-wal"));
  EXPECT_FALSE(std::filesystem::exists(folder / "run.db-shm"));
  EXPECT_FALSE(std::filesystem::exists(folder / "run.db-journal"));
  EXPECT_TRUE(read_record(folder / "run.db").value().finished);
}

TEST(Store, HasNoSharedMemoryFileWhileWriting) {
  const Folder folder;
  const auto store = store_with(folder / "run.db", 10);
  EXPECT_TRUE(std::filesystem::exists(folder / "run.db-wal"));
  EXPECT_FALSE(std::filesystem::exists(folder / "run.db-shm"));
}

TEST(Store, RefusesRowsAfterFinish) {
  const Folder folder;
  const auto store = store_with(folder / "run.db", 1);
  ASSERT_TRUE(store->finish());
  EXPECT_FALSE(store->append(sample_at(1), {}));
  EXPECT_FALSE(store->sync());
}

TEST(Store, ContinuesUnfinishedRun) {
  const Folder folder;
  store_with(folder / "run.db", 3).reset();
  auto store = Store::reopen(folder / "run.db");
  ASSERT_TRUE(store) << text(store.error());
  EXPECT_EQ((*store)->info().seed, two_thermometers().seed);
  EXPECT_FALSE((*store)->append(sample_at(2), {}));
  ASSERT_TRUE((*store)->append_gap(3, 9, "power cut"));
  ASSERT_TRUE((*store)->append(sample_at(10), {}));
  ASSERT_TRUE((*store)->finish());
  store->reset();
  const auto record = read_record(folder / "run.db").value();
  EXPECT_EQ(record.slot, (std::vector<std::int64_t>{0, 1, 2, 10}));
  ASSERT_EQ(record.gaps.size(), 1u);
  EXPECT_EQ(record.gaps[0].cause, "power cut");
}

TEST(Store, DistinguishesReaderFromWriterOfRecord) {
  const Folder folder;
  const auto path = folder / "run.db";
  store_with(path, 3).reset();
  EXPECT_FALSE(is_being_read(path));
  {
    const auto one = open_record(path), other = open_record(path);
    ASSERT_TRUE(one && other);
    EXPECT_TRUE(is_being_read(path));
    const auto store = Store::reopen(path);
    ASSERT_FALSE(store);
    EXPECT_EQ(store.error().kind, FaultKind::timeout);
    EXPECT_EQ(store.error().what, "being read by another program");
  }
  EXPECT_FALSE(is_being_read(path));
  int ready[2], done[2];
  ASSERT_TRUE(::pipe(ready) == 0 && ::pipe(done) == 0);
  const auto child = ::fork();
  if (child == 0) {
    const auto store = Store::reopen(path);
    char byte = store ? 1 : 0;
    (void)!::write(ready[1], &byte, 1);
    (void)!::read(done[0], &byte, 1);
    ::_exit(0);
  }
  char is_open = 0;
  ASSERT_EQ(::read(ready[0], &is_open, 1), 1);
  EXPECT_EQ(is_open, 1);
  EXPECT_FALSE(is_being_read(path)) << "it is written";
  EXPECT_TRUE(is_being_written(path));
  const auto store = Store::reopen(path);
  EXPECT_TRUE(!store && is_locked(store.error()));
  EXPECT_EQ(::write(done[1], "!", 1), 1);
  ::waitpid(child, nullptr, 0);
  for (const int end : {ready[0], ready[1], done[0], done[1]}) ::close(end);
  EXPECT_TRUE(Store::reopen(path));
}

TEST(Store, RefusesToContinueFinishedRun) {
  const Folder folder;
  auto store = store_with(folder / "run.db", 1);
  ASSERT_TRUE(store->finish());
  store.reset();
  const auto again = Store::reopen(folder / "run.db");
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().kind, FaultKind::bad_file);
}

TEST(Store, RefusesOtherFileAndLeavesItUnchanged) {
  const Folder folder;
  const std::string bytes(5000, 'x');
  std::ofstream(folder / "text") << bytes;
  std::ofstream(folder / "empty");
  for (const char* file : {"text", "empty", "missing"}) {
    const auto store = Store::reopen(folder / file);
    ASSERT_FALSE(store) << file;
    EXPECT_EQ(store.error().kind, FaultKind::bad_file) << file << ": " << store.error().what;
  }
  EXPECT_EQ(std::filesystem::file_size(folder / "text"), bytes.size());
  EXPECT_EQ(std::filesystem::file_size(folder / "empty"), 0u);
  EXPECT_FALSE(std::filesystem::exists(folder / "missing"));
}

TEST(Store, StopsAcknowledgingWhenLogIsRemoved) {
  const Folder folder;
  const auto store = store_with(folder / "run.db", 5);
  std::filesystem::remove(folder / "run.db-wal");
  const auto lost = store->append(sample_at(5), {});
  ASSERT_FALSE(lost);
  EXPECT_EQ(lost.error().kind, FaultKind::storage);
  EXPECT_EQ(lost.error().what, "run.db-wal was removed or moved by another program while it was being written");
  EXPECT_FALSE(store->append(sample_at(6), {})) << "the first failure is kept";
  EXPECT_FALSE(store->sync());
}

TEST(Store, DetectsOtherLogOfSameName) {
  const Folder folder;
  const auto store = store_with(folder / "run.db", 5);
  std::filesystem::rename(folder / "run.db-wal", folder / "stolen");
  std::filesystem::copy_file(folder / "stolen", folder / "run.db-wal");
  EXPECT_FALSE(store->append(sample_at(5), {}));
  EXPECT_FALSE(store->sync());
}

TEST(Store, RefusesInvalidColumnNames) {
  const Folder folder;
  for (const char* name : {"", "a\"b", "A", "a", "Slot", "phase", "über", "x;y"}) {
    RunInfo info = two_thermometers();
    info.thermometers[1].name = name;
    const auto store = Store::create(folder / "run.db", info);
    ASSERT_FALSE(store) << name;
    EXPECT_EQ(store.error().kind, FaultKind::bad_file) << name;
    EXPECT_FALSE(std::filesystem::exists(folder / "run.db")) << name;
  }
}

TEST(Store, RestoresAppendedRowsFromMemory) {
  auto store = store_with(kInMemory, 5);
  ASSERT_TRUE(store->append(sample_at(5), {}));
  const auto record = store->read_back();
  ASSERT_TRUE(record) << text(record.error());
  EXPECT_EQ(record->slot.size(), 6u);
  ASSERT_TRUE(store->finish());
  EXPECT_FALSE(std::filesystem::exists(kInMemory));
  EXPECT_FALSE(std::filesystem::exists(status_path(kInMemory)));
}

/// Changes the working directory to a folder until destruction.
class WorkingFolder {
 public:
  explicit WorkingFolder(const std::filesystem::path& folder) : before_(std::filesystem::current_path()) {
    std::filesystem::current_path(folder);
  }
  ~WorkingFolder() { std::filesystem::current_path(before_); }
  WorkingFolder(const WorkingFolder&) = delete;
  WorkingFolder& operator=(const WorkingFolder&) = delete;

 private:
  std::filesystem::path before_;
};

TEST(Store, TreatsSqliteUriAsFileName) {
  const Folder folder;
  const WorkingFolder inside(folder / "");
  ASSERT_TRUE(store_with("run.db", 3)->finish());
  for (const std::string name : {"file:run.db", "file:new.db?mode=memory", "./:memory:"}) {
    {
      auto store = Store::create(name, two_thermometers(), {.live_copy = LiveCopyOptions{}});
      ASSERT_TRUE(store) << name << ": " << text(store.error());
      for (int slot = 0; slot < 5; ++slot) ASSERT_TRUE((*store)->append(sample_at(slot), {}));
      ASSERT_TRUE((*store)->finish()) << name;
    }
    EXPECT_EQ(read_record(name)->slot.size(), 5u) << name;
    EXPECT_TRUE(verify_record(name)) << name;
    EXPECT_GT(std::filesystem::file_size(name), 0u) << name;
  }
  EXPECT_EQ(read_record(kInMemory)->slot.size(), 5u) << "readers also treat it as a file name";
  EXPECT_EQ(read_record("run.db")->slot.size(), 3u);
  EXPECT_TRUE(verify_record("run.db"));
  EXPECT_FALSE(std::filesystem::exists("new.db"));
}

TEST(Store, LeavesFileUnchangedWhenLogIsRemoved) {
  const Folder folder;
  auto store = store_with(folder / "run.db", 5);
  std::filesystem::remove(folder / "run.db-wal");
  const auto before = std::filesystem::last_write_time(folder / "run.db");
  EXPECT_FALSE(store->append(sample_at(5), {}));
  ASSERT_FALSE(store->sync());
  store.reset();
  EXPECT_EQ(std::filesystem::last_write_time(folder / "run.db"), before);
  EXPECT_FALSE(std::filesystem::exists(folder / "run.db-wal"));
}

}  // namespace

namespace {

StoreOptions background_options() { return {.background = true, .retry = std::chrono::milliseconds(20)}; }

/// Reads the status file. The process that writes a record does not open the record for it.
RunStatus status_in_file(const std::string& path) {
  std::ifstream file(status_path(path));
  return parse_status(std::string(std::istreambuf_iterator<char>(file), {}), "status").value();
}

std::unique_ptr<Store> background_store(const std::string& path, std::int64_t count) {
  auto store = Store::create(path, two_thermometers(), background_options());
  EXPECT_TRUE(store) << text(store.error());
  for (std::int64_t slot = 0; slot < count; ++slot) EXPECT_TRUE((*store)->append(sample_at(slot), {}));
  EXPECT_TRUE((*store)->settle(kLong));
  return std::move(*store);
}

TEST(BackgroundStore, AcknowledgesOnlyRowsOnDisk) {
  const Folder folder;
  auto store = background_store(folder / "run.db", 5);
  EXPECT_EQ(store->health().backlog_s, 0);
  ASSERT_TRUE(store->append(sample_at(5), {}));
  EXPECT_EQ(store->health().backlog_s, 1);
  store.reset();
  EXPECT_EQ(read_record(folder / "run.db").value().slot.back(), 4) << "not synced";
}

TEST(BackgroundStore, DoesNotCountUnmeasuredSecondsAsBacklog) {
  const Folder folder;
  const auto store = background_store(folder / "run.db", 3);
  ASSERT_TRUE(store->append_gap(3, 3602, "the program was not running"));
  ASSERT_TRUE(store->append(sample_at(3603), {}));
  EXPECT_LE(store->health().backlog_s, 1);
  EXPECT_TRUE(store->settle(kLong));
  EXPECT_EQ(store->health().backlog_s, 0);
}

TEST(BackgroundStore, KeepsInvariantOfSlots) {
  const Folder folder;
  const auto store = background_store(folder / "run.db", 3);
  EXPECT_FALSE(store->append(sample_at(2), {}));
  EXPECT_FALSE(store->append(sample_at(5), {}));
  EXPECT_TRUE(store->append_gap(3, 4, "late"));
  EXPECT_TRUE(store->append(sample_at(5), {}));
}

TEST(BackgroundStore, WritesSameRecordAsInlineStore) {
  const Folder folder;
  for (const bool background : {false, true}) {
    auto store =
        Store::create(folder / (background ? "b.db" : "a.db"), two_thermometers(), {.background = background}).value();
    const Event event{sample_at(0).at, EventKind::started, "a profile"};
    ASSERT_TRUE(store->append_event(event));
    for (int slot = 0; slot < 50; ++slot) {
      Sample sample = sample_at(slot);
      if (slot % 7 == 0) sample.thermometers[0].value = failure(FaultKind::timeout, "A", "silent");
      ASSERT_TRUE(store->append(sample, std::span(&event, slot % 5 == 0 ? 1 : 0)));
      ASSERT_TRUE(store->sync());
    }
    ASSERT_TRUE(store->append_gap(50, 59, "late"));
    ASSERT_TRUE(store->finish());
  }
  const auto a = read_record(folder / "a.db").value();
  const auto b = read_record(folder / "b.db").value();
  EXPECT_EQ(a.slot.size(), 50u);
  EXPECT_EQ(to_csv(a), to_csv(b)) << "slots, readings, set points";
  const auto describe = [](const Record& record) {
    std::string text;
    for (const auto& gap : record.gaps) text += fmt::format("gap {} to {}: {}\n", gap.first, gap.last, gap.cause);
    for (const auto& [slot, event] : record.events)
      text += fmt::format("{} {} {}\n", slot, name(event.kind), event.text);
    return text;
  };
  EXPECT_EQ(describe(a), describe(b));
  EXPECT_EQ(read_status(folder / "a.db")->faults, 8);
  EXPECT_EQ(read_status(folder / "b.db")->faults, 8);
  EXPECT_TRUE(b.finished);
  EXPECT_FALSE(std::filesystem::exists(folder / "b.db-wal"));
}

TEST(BackgroundStore, RefusesRowsAfterFinish) {
  const Folder folder;
  const auto store = background_store(folder / "run.db", 1);
  ASSERT_TRUE(store->finish());
  EXPECT_FALSE(store->append(sample_at(1), {}));
  EXPECT_FALSE(store->sync());
  EXPECT_FALSE(store->finish());
}

TEST(BackgroundStore, ContinuesInNewFileWithoutLossWhenLogIsRemoved) {
  const Folder folder;
  const auto path = folder / "run.db";
  auto store = background_store(path, 100);
  std::filesystem::remove(path + "-wal");
  for (int slot = 100; slot < 110; ++slot) ASSERT_TRUE(store->append(sample_at(slot), {}));
  ASSERT_TRUE(store->settle(kLong));
  EXPECT_EQ(store->sync().value(), 109);
  EXPECT_EQ(store->health().parts, 2);
  EXPECT_EQ(store->health().trouble, "");
  const auto status = status_in_file(path);
  EXPECT_TRUE(status.being_written);
  EXPECT_EQ(status.acknowledged, 109);
  EXPECT_EQ(status.parts, (std::vector<std::string>{folder / "run.2.db"}));
  ASSERT_TRUE(store->finish());
  store.reset();

  const auto record = read_record(path);
  ASSERT_TRUE(record) << text(record.error());
  ASSERT_EQ(record->slot.size(), 110u);
  EXPECT_TRUE(record->finished);
  EXPECT_TRUE(record->gaps.empty());
  ASSERT_EQ(record->events.size(), 1u);
  EXPECT_EQ(record->events[0].slot, 99);
  EXPECT_NE(record->events[0].event.text.find("continues in run.2.db"), std::string::npos)
      << record->events[0].event.text;
  EXPECT_EQ(read_status(path)->slot, 109);
}

TEST(BackgroundStore, ResumesInLastPart) {
  const Folder folder;
  const auto path = folder / "run.db";
  auto store = background_store(path, 10);
  std::filesystem::remove(path + "-wal");
  ASSERT_TRUE(store->append(sample_at(10), {}));
  ASSERT_TRUE(store->settle(kLong));
  store.reset();
  auto again = Store::reopen(path, background_options());
  ASSERT_TRUE(again) << text(again.error());
  ASSERT_TRUE((*again)->append_gap(11, 40, "power cut"));
  ASSERT_TRUE((*again)->append(sample_at(41), {}));
  ASSERT_TRUE((*again)->finish());
  again->reset();
  const auto record = read_record(path).value();
  EXPECT_EQ(record.slot.back(), 41);
  EXPECT_EQ(record.slot.size(), 12u);
  EXPECT_TRUE(record.finished);
}

/// Each program after the first begins with no rows in memory.
TEST(BackgroundStore, NumbersEventsAcrossAllFiles) {
  const Folder folder;
  const auto path = folder / "run.db";
  const std::vector<Event> three(3, Event{sample_at(0).at, EventKind::note, "a note"});
  {
    auto store = Store::create(path, two_thermometers(), background_options()).value();
    ASSERT_TRUE(store->append(sample_at(0), three));
    ASSERT_TRUE(store->settle(kLong));
  }
  const auto highest = read_last_event_number(find_record_files(path).value()).value();
  EXPECT_GE(highest, 3);
  {
    auto store = Store::reopen(path, background_options()).value();
    ASSERT_TRUE(store->append(sample_at(1), {}));
    ASSERT_TRUE(store->settle(kLong));
    std::filesystem::remove(path + "-wal");
    ASSERT_TRUE(store->append(sample_at(2), {}));
    ASSERT_TRUE(store->settle(kLong));
    EXPECT_EQ(store->health().parts, 2);
  }
  EXPECT_EQ(read_last_event_number(find_record_files(path).value()).value(), highest + 1)
      << "that it continues in another file";
  for (const bool background : {true, false}) {
    const auto before = read_last_event_number(find_record_files(path).value()).value();
    auto store = Store::reopen(path, {.background = background}).value();
    const Event alarm{sample_at(0).at, EventKind::interlock, "door (suspend)", {.interlock = "door"}};
    ASSERT_TRUE(store->append_event(alarm));
    ASSERT_TRUE(store->settle(kLong));
    const auto told = store->alarms().list().front().last_number;
    EXPECT_GT(told, before);
    store.reset();
    EXPECT_EQ(read_last_event_number(find_record_files(path).value()).value(), told) << "as in the record";
  }
}

TEST(BackgroundStore, CountsFaultyReadingsOfAllFiles) {
  const Folder folder;
  const auto path = folder / "run.db";
  const auto silent = [](int slot) {
    Sample sample = sample_at(slot);
    sample.thermometers[0].value = failure(FaultKind::timeout, "A", "silent");
    return sample;
  };
  {
    auto store = background_store(path, 2);
    for (int slot = 2; slot < 5; ++slot) ASSERT_TRUE(store->append(silent(slot), {}));
    ASSERT_TRUE(store->settle(kLong));
  }
  {
    auto store = Store::reopen(path, background_options()).value();
    ASSERT_TRUE(store->append(silent(5), {}));
    ASSERT_TRUE(store->settle(kLong));
    std::filesystem::remove(path + "-wal");
    ASSERT_TRUE(store->append(silent(6), {}));
    ASSERT_TRUE(store->settle(kLong));
    EXPECT_EQ(store->health().parts, 2);
    EXPECT_EQ(status_in_file(path).faults, 5);
  }
  EXPECT_EQ(read_status(path)->faults, 5) << "rows in both files count once";
  auto store = Store::reopen(path, background_options()).value();
  ASSERT_TRUE(store->append(silent(7), {}));
  ASSERT_TRUE(store->settle(kLong));
  EXPECT_EQ(status_in_file(path).faults, 6);
}

/// The writer died between creating and filling the part; its rows are still in the file before.
TEST(BackgroundStore, LosesNothingWhenNewPartIsEmpty) {
  const Folder folder;
  const auto path = folder / "run.db";
  background_store(path, 10).reset();
  const Continuation continuation{.part = 2, .before = "run.db", .from = 0, .cause = "an I/O error"};
  ASSERT_TRUE(RunFile::create(part_path(path, 2), two_thermometers(), continuation));
  EXPECT_EQ(read_record(path).value().slot.size(), 10u);
  EXPECT_TRUE(verify_record(path));
  auto store = Store::reopen(path, background_options()).value();
  ASSERT_TRUE(store->append(sample_at(10), {}));
  ASSERT_TRUE(store->settle(kLong));
  std::filesystem::remove(path + "-wal");
  ASSERT_TRUE(store->append(sample_at(11), {}));
  ASSERT_TRUE(store->finish());
  store.reset();
  const auto record = read_record(path).value();
  EXPECT_EQ(record.slot.size(), 12u);
  EXPECT_TRUE(record.finished);
  EXPECT_EQ(last_part(path), 3);
}

TEST(BackgroundStore, ExcludesFileOfOtherRun) {
  const Folder folder;
  RunInfo other = two_thermometers();
  other.id[0] = 'f';
  ASSERT_TRUE(Store::create(folder / "run.2.db", other));
  const auto path = folder / "run.db";
  auto store = background_store(path, 10);
  std::filesystem::remove(path + "-wal");
  ASSERT_TRUE(store->append(sample_at(10), {}));
  ASSERT_TRUE(store->finish());
  store.reset();
  EXPECT_EQ(read_record(path).value().slot.size(), 11u);
  EXPECT_EQ(last_part(path), 3);
}

TEST(BackgroundStore, WritesPublishedStandingToStatusFile) {
  const Folder folder;
  const auto store = background_store(folder / "run.db", 3);
  store->publish({.state = RunState::suspended,
                  .cause = "the door is open",
                  .time_left = std::chrono::seconds(90),
                  .behind_plan = std::chrono::seconds(12),
                  .missed_set_points = 2,
                  .faults_now = {"chamber: door"}});
  ASSERT_TRUE(store->settle(kLong));
  const auto status = status_in_file(folder / "run.db");
  EXPECT_EQ(status.overview.state, RunState::suspended);
  EXPECT_EQ(status.overview.cause, "the door is open");
  EXPECT_EQ(status.overview.time_left, std::chrono::seconds(90));
  EXPECT_EQ(status.overview.behind_plan, std::chrono::seconds(12));
  EXPECT_EQ(status.overview.missed_set_points, 2);
  EXPECT_EQ(status.overview.faults_now, (std::vector<std::string>{"chamber: door"}));
}

}  // namespace

}  // namespace gyrotherm::record
