// SPDX-License-Identifier: Apache-2.0
/// Tests that readers of a running record use its copy, and that they cannot affect the record.
#include "acquisition/record/live_copy.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sqlite3.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

#include "acquisition/record/chain.hpp"
#include "acquisition/record/record.hpp"
#include "acquisition/record/record_files.hpp"
#include "acquisition/record/run_file.hpp"
#include "acquisition/record/status.hpp"
#include "acquisition/record/store.hpp"
#include "tests/acquisition/record/runs.hpp"
#include "tests/support/slept.hpp"

namespace gyrotherm::record {
namespace {

using std::chrono_literals::operator""ms;
using std::chrono_literals::operator""s;
using std::chrono::steady_clock;

#ifdef GYROTHERM_NIGHTLY
constexpr int kReaders = 10, kSeconds = 300;
#else
constexpr int kReaders = 4, kSeconds = 40;
#endif
/// The duration of one second in these tests.
constexpr auto kShort = 5ms;

StoreOptions live_copy_options(bool background, LiveCopyOptions copy = {.pause = 2ms}) {
  return {.background = background, .live_copy = copy};
}

/// Returns the present content of the status file.
Result<RunStatus> read_present_status(const std::string& path) {
  return parse_status((std::stringstream() << std::ifstream(status_path(path)).rdbuf()).str(), "");
}

/// A connection that any program could open.
class Reader {
 public:
  explicit Reader(const std::string& path, int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE) {
    opened_ = sqlite3_open_v2(path.c_str(), &connection_, flags, nullptr) == SQLITE_OK;
    sqlite3_busy_timeout(connection_, 5000);
  }
  ~Reader() { sqlite3_close(connection_); }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;
  bool run(const std::string& sql) {
    return opened_ && sqlite3_exec(connection_, sql.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK;
  }
  /// Returns the result of a query; −1 if it fails.
  std::int64_t number(const std::string& sql) {
    sqlite3_stmt* query = nullptr;
    if (!opened_ || sqlite3_prepare_v2(connection_, sql.c_str(), -1, &query, nullptr) != SQLITE_OK) return -1;
    const auto found = sqlite3_step(query) == SQLITE_ROW ? sqlite3_column_int64(query, 0) : -1;
    sqlite3_finalize(query);
    return found;
  }
  std::string table(const std::string& sql) {
    std::string rows;
    const auto add = [](void* to, int columns, char** values, char**) {
      for (int i = 0; i < columns; ++i)
        *static_cast<std::string*>(to) += (values[i] ? values[i] : "NULL") + std::string("|");
      *static_cast<std::string*>(to) += "\n";
      return 0;
    };
    EXPECT_EQ(sqlite3_exec(connection_, sql.c_str(), add, &rows, nullptr), SQLITE_OK) << sqlite3_errmsg(connection_);
    return rows;
  }

 private:
  sqlite3* connection_ = nullptr;
  bool opened_{};
};

std::int64_t last_slot_of_copy(const std::string& copy) {
  return std::filesystem::exists(copy)
             ? Reader(copy, SQLITE_OPEN_READONLY).number("SELECT coalesce(max(slot), -1) FROM sample")
             : -1;
}

bool reaches_slot(const std::string& copy, std::int64_t slot, std::chrono::milliseconds within = 60s) {
  for (const auto end = steady_clock::now() + within; steady_clock::now() < end; std::this_thread::sleep_for(2ms))
    if (last_slot_of_copy(copy) >= slot) return true;
  return false;
}

/// Appends until the copy reports a reason for its delay and returns it; "" if it never does.
std::string append_until_delayed(Store& store, const std::string& path) {
  std::string trouble;
  for (int i = 0; i < 2000 && trouble.empty(); ++i) {
    std::this_thread::sleep_for(5ms);
    EXPECT_TRUE(store.sync());
    if (const auto status = read_present_status(path)) trouble = status->live_copy_trouble;
  }
  return trouble;
}

bool has_copy_files(const Folder& folder) {
  for (const auto& entry : std::filesystem::directory_iterator(folder / ""))
    if (entry.path().string().find(".live.") != std::string::npos) return true;
  return false;
}

bool wait_until_copy_is_removed(const Folder& folder) {
  for (const auto end = steady_clock::now() + 60s; steady_clock::now() < end; std::this_thread::sleep_for(5ms))
    if (!has_copy_files(folder)) return true;
  return false;
}

void append(Store& store, std::int64_t slot) {
  std::vector<Event> events;
  if (slot % 7 == 3) events.push_back({sample_at(slot).at, EventKind::note, fmt::format("at {}", slot)});
  auto sample = sample_at(slot);
  if (slot % 5 == 2) sample.thermometers[1].value = failure(FaultKind::timeout, "an instrument", "no reply");
  ASSERT_TRUE(store.append(sample, events));
  ASSERT_TRUE(store.sync());
}

/// Returns all rows of a file, in order.
std::string all_rows(const std::string& path) {
  Reader reader(path, SQLITE_OPEN_READONLY);
  std::string all;
  for (const auto* table : {"channel", "segment", "sample", "fault", "event", "gap"})
    all += reader.table(fmt::format("SELECT * FROM {} ORDER BY 1", table));
  return all;
}

TEST(LiveCopy, IsNextToRecord) {
  EXPECT_EQ(live_copy_path("a/RUN.db"), "a/RUN.live.db");
  EXPECT_EQ(live_copy_path("run"), "run.live.db");
}

TEST(LiveCopy, HasRowsOfRecordAndEndsWithRun) {
  for (const bool background : {false, true}) {
    const Folder folder;
    const auto path = folder / "run.db", copy = live_copy_path(path);
    auto store = Store::create(path, two_thermometers(), live_copy_options(background));
    ASSERT_TRUE(store) << text(store.error());
    for (std::int64_t slot = 0; slot < 40; ++slot) append(**store, slot);
    ASSERT_TRUE((*store)->append_gap(40, 44, "the program was late"));
    append(**store, 45);
    ASSERT_TRUE((*store)->settle(kLong));
    ASSERT_TRUE(reaches_slot(copy, 45));
    const auto seen = all_rows(copy);
    ASSERT_TRUE((*store)->finish());
    EXPECT_TRUE(all_rows(path) == seen) << "including its hash chain";
    for (const auto& entry : std::filesystem::directory_iterator(folder / ""))
      EXPECT_EQ(entry.path().string().find(".live."), std::string::npos) << entry.path();
  }
}

TEST(LiveCopy, ReplacesStaleCopyWithAllRowsOfRecord) {
  for (const bool background : {false, true}) {
    const Folder folder;
    const auto path = folder / "run.db", copy = live_copy_path(path);
    {
      auto store = Store::create(path, two_thermometers());
      ASSERT_TRUE(store);
      for (std::int64_t slot = 0; slot < 20; ++slot) append(**store, slot);
    }
    std::ofstream(copy + ".3") << "the file of a dead program";
    std::ofstream(copy + ".3-wal") << "its log";
    std::filesystem::create_symlink("run.live.db.3", copy);
    auto store = Store::reopen(path, live_copy_options(background));
    ASSERT_TRUE(store) << text(store.error());
    EXPECT_EQ(last_slot_of_copy(copy), 19) << "before the first tick";
    for (std::int64_t slot = 20; slot < 30; ++slot) append(**store, slot);
    ASSERT_TRUE((*store)->settle(kLong));
    EXPECT_TRUE(reaches_slot(copy, 29));
    EXPECT_EQ(Reader(copy).number("SELECT count(*) FROM sample"), 30);
    EXPECT_FALSE(std::filesystem::exists(copy + ".3"));
    const auto seen = all_rows(copy);
    ASSERT_TRUE((*store)->finish());
    EXPECT_TRUE(all_rows(path) == seen);
  }
}

TEST(LiveCopy, RemovesCopyOfOtherRunBeforeFirstRow) {
  for (const bool background : {false, true}) {
    const Folder folder;
    const auto path = folder / "run.db", copy = live_copy_path(path);
    std::ofstream(copy + ".3") << "of another run";
    std::ofstream(copy + ".3-wal") << "its log";
    std::filesystem::create_symlink("run.live.db.3", copy);
    auto store = Store::create(path, two_thermometers(), live_copy_options(background));
    ASSERT_TRUE(store) << text(store.error());
    EXPECT_FALSE(has_copy_files(folder));
    append(**store, 0);
    EXPECT_TRUE(reaches_slot(copy, 0));
    EXPECT_EQ(std::filesystem::read_symlink(copy), "run.live.db.4") << "a reader detects that it is another file";
    ASSERT_TRUE((*store)->finish());
  }
}

TEST(LiveCopy, KeepsFilesWithOtherNumbers) {
  const Folder folder;
  const auto path = folder / "run.db", copy = live_copy_path(path);
  const std::vector<std::string> others{"20261127", "2147483647", "10000", "007", "0", "-3", "3-journal"};
  for (const auto& other : others) std::ofstream(copy + "." + other) << "precious";
  std::ofstream(copy + ".9999") << "the file of a dead program";
  auto store = Store::create(path, two_thermometers(), live_copy_options(false));
  ASSERT_TRUE(store);
  append(**store, 0);
  EXPECT_TRUE(reaches_slot(copy, 0));
  EXPECT_EQ(std::filesystem::read_symlink(copy), "run.live.db.1") << "after the last number comes the first";
  ASSERT_TRUE((*store)->finish());
  for (const auto& other : others) EXPECT_TRUE(std::filesystem::exists(copy + "." + other)) << other;
  EXPECT_FALSE(std::filesystem::exists(copy + ".9999"));
}

TEST(LiveCopy, HasFaultsAndEventsOfAllParts) {
  const Folder folder;
  const auto path = folder / "run.db", copy = live_copy_path(path), whole = folder / "whole.db";
  const auto fill = [](RunFile file, std::int64_t first, std::int64_t last) {
    ASSERT_TRUE(file.begin());
    for (auto slot = first; slot <= last; ++slot) {
      auto sample = sample_at(slot);
      sample.thermometers[1].value = failure(FaultKind::timeout, "an instrument", "no reply");
      const std::vector<Event> events{{sample.at, EventKind::note, fmt::format("at {}", slot)}};
      ASSERT_TRUE(file.insert(sample_entry(sample, events, two_thermometers())));
    }
    ASSERT_TRUE(file.replace_frames({}) && file.commit());
  };
  const Continuation continuation{.part = 2, .before = "run.db", .from = 10, .cause = "a failure"};
  fill(RunFile::create(path, two_thermometers()).value(), 0, 9);
  fill(RunFile::create(part_path(path, 2), two_thermometers(), continuation).value(), 10, 19);
  auto store = Store::reopen(path, live_copy_options(false));
  ASSERT_TRUE(store) << text(store.error());
  append(**store, 20);
  EXPECT_TRUE(reaches_slot(copy, 20));
  {
    Reader reader(copy);
    EXPECT_EQ(reader.table("SELECT count(*), count(DISTINCT slot) FROM fault"), "20|20|\n");
    EXPECT_EQ(reader.table("SELECT count(*), count(DISTINCT slot) FROM event"), "20|20|\n");
    ASSERT_TRUE(reader.run("VACUUM INTO '" + whole + "'"));
  }
  EXPECT_TRUE(verify_record(whole)) << "its hash chain matches its rows";
  ASSERT_TRUE((*store)->finish());
}

TEST(LiveCopy, KeepsOtherFileOfThatName) {
  const Folder folder;
  const auto path = folder / "run.db", copy = live_copy_path(path);
  std::ofstream(copy) << "precious";
  auto store = Store::create(path, two_thermometers(), live_copy_options(false));
  ASSERT_TRUE(store);
  for (std::int64_t slot = 0; slot < 5; ++slot) append(**store, slot);
  const auto trouble = [&] { return read_present_status(path).value().live_copy_trouble; };
  for (int i = 0; i < 500 && trouble().empty(); ++i) {
    std::this_thread::sleep_for(5ms);
    ASSERT_TRUE((*store)->sync());
  }
  EXPECT_NE(trouble().find("is not a live copy"), std::string::npos) << trouble();
  ASSERT_TRUE((*store)->finish());
  EXPECT_EQ((std::stringstream() << std::ifstream(copy).rdbuf()).str(), "precious");
}

TEST(LiveCopy, FullDiskStopsOnlyCopy) {
  for (const bool background : {false, true}) {
    const Folder folder;
    const auto path = folder / "run.db";
    auto store =
        Store::create(path, two_thermometers(), live_copy_options(background, {.pause = 2ms, .most_pages = 22}));
    ASSERT_TRUE(store);
    std::string trouble;
    for (std::int64_t slot = 0; slot < 600; ++slot) append(**store, slot);
    for (int i = 0; i < 1000 && trouble.empty(); ++i) {
      std::this_thread::sleep_for(5ms);
      ASSERT_TRUE((*store)->sync());
      const auto status = read_present_status(path);
      if (status) trouble = status->live_copy_trouble;
    }
    EXPECT_NE(trouble.find(kDiskFull), std::string::npos) << trouble;
    EXPECT_EQ((*store)->health().trouble, "") << "the record has another one";
    ASSERT_TRUE((*store)->finish());
    const auto record = read_record(path);
    ASSERT_TRUE(record);
    EXPECT_EQ(record->slot.size(), 600u);
    EXPECT_FALSE(std::filesystem::exists(live_copy_path(path)));
  }
}

/// A copy waits when it begins to use the space reserved for the record, and is removed when that is nearly used up.
TEST(LiveCopy, LeavesReservedSpaceForRecord) {
  for (const bool goes : {false, true}) {
    const Folder folder;
    const auto path = folder / "run.db";
    const auto free = std::filesystem::space(folder / "").available;
    const LiveCopyOptions options{.pause = 2ms, .left_free = goes ? 100 * free : 2 * free};
    auto store = Store::create(path, two_thermometers(), live_copy_options(false, options));
    ASSERT_TRUE(store);
    for (std::int64_t slot = 0; slot < 5; ++slot) append(**store, slot);
    const auto trouble = append_until_delayed(**store, path);
    EXPECT_NE(trouble.find("are reserved for the record"), std::string::npos) << trouble;
    EXPECT_EQ(trouble.find("the live copy has ended") != std::string::npos, goes) << trouble;
    EXPECT_FALSE(has_copy_files(folder));
    EXPECT_EQ((*store)->health().trouble, "");
    store->reset();
    store = Store::reopen(path, live_copy_options(false, options));
    ASSERT_TRUE(store) << text(store.error());
    EXPECT_NE(append_until_delayed(**store, path).find("are reserved for the record"), std::string::npos);
    EXPECT_FALSE(has_copy_files(folder));
    append(**store, 5);
    ASSERT_TRUE((*store)->finish());
    EXPECT_EQ(read_record(path)->slot.size(), 6u);
  }
}

TEST(LiveCopy, RemovesDamagedCopy) {
  const Folder folder;
  const auto path = folder / "run.db", copy = live_copy_path(path);
  constexpr std::int64_t kManySeconds = 30'000;  // more than SQLite caches
  constexpr auto kPatience = 60s;
  auto store = Store::create(path, two_thermometers(), live_copy_options(false, {.pause = 1ms, .longest_log = 0}));
  ASSERT_TRUE(store);
  for (std::int64_t slot = 0; slot < kManySeconds; ++slot) ASSERT_TRUE((*store)->append(sample_at(slot), {}));
  ASSERT_TRUE((*store)->sync());
  ASSERT_TRUE(reaches_slot(copy, kManySeconds - 1, kPatience));
  append(**store, kManySeconds);
  ASSERT_TRUE(reaches_slot(copy, kManySeconds, kPatience)) << "it restarts with each transaction";
  const auto file = std::filesystem::canonical(copy);
  constexpr std::uintmax_t kPage = 4096;
  const auto size = std::filesystem::file_size(file);
  ASSERT_GT(size, 2'500'000u);
  std::fstream(file, std::ios::in | std::ios::out | std::ios::binary).seekp(kPage) << std::string(size - kPage, '\0');
  append(**store, kManySeconds + 1);
  const auto trouble = append_until_delayed(**store, path);
  EXPECT_NE(trouble.find("the live copy has ended"), std::string::npos) << trouble;
  EXPECT_TRUE(wait_until_copy_is_removed(folder));
  ASSERT_TRUE((*store)->finish());
  EXPECT_EQ(read_record(path)->slot.size(), static_cast<std::size_t>(kManySeconds + 2));
}

/// Starts a process that reads the copy repeatedly until it is killed.
pid_t start_reader(const std::string& copy, bool only_reads) {
  const auto pid = ::fork();
  if (pid != 0) return pid;
  const auto uri = "file:" + copy + "?mode=ro";
  const std::string script = fmt::format(
      "import sqlite3\nwhile True:\n  c = sqlite3.connect({}, uri={})\n  c.execute('SELECT count(*), max(slot) FROM "
      "sample').fetchall()\n",
      only_reads ? "'" + uri + "'" : "'" + copy + "'", only_reads ? "True" : "False");
  const int nothing = ::open("/dev/null", O_WRONLY);
  ::dup2(nothing, 2);
  ::execlp("python3", "python3", "-c", script.c_str(), nullptr);
  ::_exit(127);
}

void end(pid_t pid) {
  ::kill(pid, SIGKILL);
  ::waitpid(pid, nullptr, 0);
}

TEST(LiveCopy, ReadersDoNotAffectRecord) {
  const Folder folder;
  const auto path = folder / "run.db", copy = live_copy_path(path);
  auto store = Store::create(path, two_thermometers(), live_copy_options(true));
  ASSERT_TRUE(store);
  append(**store, 0);
  ASSERT_TRUE(reaches_slot(copy, 0));
  Reader open_for_long(copy);
  ASSERT_TRUE(open_for_long.run("BEGIN; SELECT count(*) FROM sample"));
  std::vector<pid_t> readers;
  for (int i = 0; i < kReaders; ++i) readers.push_back(start_reader(copy, i % 2 == 0));
  for (std::int64_t slot = 1; slot < kSeconds * 10; ++slot) {
    const tests::SleepMeter meter;
    append(**store, slot);
    EXPECT_LT(meter.slept(), 250ms) << "a tick does not wait for a reader";
    std::this_thread::sleep_for(kShort);
    if (slot % 20 != 0) continue;
    auto& victim = readers[static_cast<std::size_t>(slot / 20) % readers.size()];
    end(victim);
    victim = start_reader(copy, slot % 40 == 0);
  }
  ASSERT_TRUE((*store)->settle(kLong));
  EXPECT_TRUE(reaches_slot(copy, kSeconds * 10 - 1));
  EXPECT_EQ(open_for_long.number("SELECT max(slot) FROM sample"), 0) << "its snapshot is unchanged";
  for (const auto reader : readers) end(reader);
  const auto seen = all_rows(copy);
  ASSERT_TRUE((*store)->finish());
  EXPECT_TRUE(all_rows(path) == seen);
}

std::uintmax_t longest_log(const std::string& folder) {
  std::uintmax_t longest = 0;
  std::error_code gone;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.path().string().ends_with("-wal") && entry.path().string().find(".live.") != std::string::npos)
      if (const auto size = entry.file_size(gone); !gone) longest = std::max(longest, size);
  return longest;
}

TEST(LiveCopy, LimitsLogWhileReaderHoldsTransaction) {
  const Folder folder;
  const auto path = folder / "run.db", copy = live_copy_path(path);
  constexpr std::int64_t kBound = 400'000;
  auto store = Store::create(path, two_thermometers(), live_copy_options(true, {.pause = 1ms, .longest_log = kBound}));
  ASSERT_TRUE(store);
  append(**store, 0);
  ASSERT_TRUE(reaches_slot(copy, 0));
  Reader pinned(copy);
  ASSERT_TRUE(pinned.run("BEGIN; SELECT count(*) FROM sample"));
  std::uintmax_t longest = 0;
  for (std::int64_t slot = 1; slot < 600; ++slot) {
    append(**store, slot);
    ASSERT_TRUE(reaches_slot(copy, slot));
    longest = std::max(longest, longest_log(folder / ""));
  }
  EXPECT_LT(longest, kBound * 3 / 2);
  EXPECT_NE(std::filesystem::read_symlink(copy), "run.live.db.1") << "it was restarted";
  EXPECT_EQ(Reader(copy).number("SELECT count(*) FROM sample"), 600);
  EXPECT_EQ(pinned.number("SELECT count(*) FROM sample"), 1);
  const auto seen = all_rows(copy);
  ASSERT_TRUE((*store)->finish());
  EXPECT_TRUE(all_rows(path) == seen);
}

TEST(LiveCopy, ContinuesInNewFileWhenLocked) {
  const Folder folder;
  const auto path = folder / "run.db", copy = live_copy_path(path);
  auto store = Store::create(path, two_thermometers(),
                             live_copy_options(true, {.pause = 1ms, .longest_locked = 100ms, .rest = 0ms}));
  ASSERT_TRUE(store);
  append(**store, 0);
  ASSERT_TRUE(reaches_slot(copy, 0));
  Reader greedy(copy);
  ASSERT_TRUE(greedy.run("BEGIN IMMEDIATE"));
  for (std::int64_t slot = 1; slot < 20; ++slot) append(**store, slot);
  EXPECT_TRUE(reaches_slot(copy, 19));
  ASSERT_TRUE((*store)->finish());
}

TEST(LiveCopy, RestoresRemovedCopy) {
  const Folder folder;
  const auto path = folder / "run.db", copy = live_copy_path(path);
  auto store = Store::create(path, two_thermometers(), live_copy_options(true, {.pause = 1ms, .rest = 0ms}));
  ASSERT_TRUE(store);
  append(**store, 0);
  ASSERT_TRUE(reaches_slot(copy, 0));
  std::filesystem::remove(copy);
  append(**store, 1);
  EXPECT_TRUE(reaches_slot(copy, 1));
  std::filesystem::remove(std::filesystem::canonical(copy));
  append(**store, 2);
  EXPECT_TRUE(reaches_slot(copy, 2));
  EXPECT_EQ(Reader(copy).number("SELECT count(*) FROM sample"), 3);
  ASSERT_TRUE((*store)->finish());
}

TEST(LiveCopy, IsReadableByOwnerAndGroupOnly) {
  const Folder folder;
  const auto path = folder / "run.db", copy = live_copy_path(path);
  auto store = Store::create(path, two_thermometers(), live_copy_options(true));
  ASSERT_TRUE(store);
  append(**store, 0);
  ASSERT_TRUE(reaches_slot(copy, 0));
  for (const auto* suffix : {"", "-wal", "-shm"}) {
    struct stat found {};
    ASSERT_EQ(::stat((std::filesystem::canonical(copy).string() + suffix).c_str(), &found), 0) << suffix;
    EXPECT_EQ(found.st_mode & 0777, 0640u) << suffix;
  }
}

}  // namespace
}  // namespace gyrotherm::record
