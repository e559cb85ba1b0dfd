// SPDX-License-Identifier: Apache-2.0
/// Tests that reading a record from an untrusted source changes nothing, executes nothing, and terminates.
#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <ctime>
#include <fstream>
#include <map>

#include "acquisition/record/chain.hpp"
#include "acquisition/record/row.hpp"
#include "acquisition/record/status.hpp"
#include "tests/acquisition/record/runs.hpp"
#include "tests/support/slept.hpp"

namespace gyrotherm::record {
namespace {

std::string read_bytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Returns the names in a folder with the content and the modification time of each file.
std::map<std::string, std::string> listing(const std::string& folder) {
  std::map<std::string, std::string> found;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    struct stat facts {};
    ::lstat(entry.path().c_str(), &facts);
    found[entry.path().filename()] = std::to_string(facts.st_mode) + " " + std::to_string(facts.st_mtim.tv_sec) + "." +
                                     std::to_string(facts.st_mtim.tv_nsec) + " " +
                                     (S_ISREG(facts.st_mode) ? read_bytes(entry.path()) : "");
  }
  return found;
}

/// Returns the result of reading a record in all ways. Fails the test if one of them takes too much work, sleeps, or
/// touches a file.
std::string read_every_way(const std::string& path) {
  const auto folder = std::filesystem::path(path).parent_path().string();
  const auto before = listing(folder);
  const tests::SleepMeter meter;
  const auto worked = std::clock();
  const auto record = read_record(path);
  (void)read_status(path);
  (void)verify_record(path);
  EXPECT_LT(std::clock() - worked, 5 * CLOCKS_PER_SEC) << path;
  EXPECT_LT(meter.slept(), std::chrono::seconds(5)) << path;
  EXPECT_EQ(listing(folder), before) << path;
  if (record) return "read";
  EXPECT_EQ(record.error().kind, FaultKind::bad_file) << text(record.error());
  return record.error().what;
}

/// Creates an unfinished run of a dead writer, with a log next to it.
void leave_unfinished(const std::string& path, int rows) {
  if (const auto child = ::fork(); child != 0) {
    ASSERT_EQ(::waitpid(child, nullptr, 0), child);
  } else {
    auto store = Store::create(path, two_thermometers());
    for (int slot = 0; store && slot < rows; ++slot) (void)(*store)->append(sample_at(slot), {});
    if (store) (void)(*store)->sync();
    ::_exit(0);
  }
  ASSERT_TRUE(std::filesystem::exists(path + "-wal"));
}

void execute(const std::string& path, const std::string& sql) {
  auto database = Database::open(path, Access::read_write, 0).value();
  const auto done = database.execute(sql);
  ASSERT_TRUE(done) << sql << ": " << text(done.error());
}

TEST(ForeignRecord, IsReadWithLogWithoutChangingFiles) {
  const Folder folder;
  leave_unfinished(folder / "run.db", 300);
  EXPECT_EQ(read_every_way(folder / "run.db"), "read");
  EXPECT_EQ(read_record(folder / "run.db")->slot.size(), 300u);
  EXPECT_EQ(verify_record(folder / "run.db")->rows, 300);
}

TEST(ForeignRecord, IsReadUnderAnyNameAndThroughLink) {
  const Folder folder;
  for (const std::string name : {"a b.db", "what?.db", "50%.db", "#1.db", "file:x?mode=rwc", "a&vfs=unix.db", "é.db"}) {
    leave_unfinished(folder / name, 5);
    EXPECT_EQ(read_every_way(folder / name), "read") << name;
  }
  for (const auto* log : {"", "-wal"})  // a record cannot have these names
    std::filesystem::rename(folder / "é.db" + log, folder / "é\n.db" + log);
  EXPECT_EQ(read_every_way(folder / "é\n.db"), "read");
  std::filesystem::create_directory(folder / "elsewhere");
  std::filesystem::create_symlink(folder / "a b.db", folder / "elsewhere/link.db");
  EXPECT_EQ(read_every_way(folder / "elsewhere/link.db"), "read");
}

TEST(ForeignRecord, IsReadFromReadOnlyFolder) {
  const Folder folder;
  leave_unfinished(folder / "run.db", 5);
  ASSERT_EQ(::chmod((folder / "run.db").c_str(), 0444), 0);
  ASSERT_EQ(::chmod((folder / "run.db-wal").c_str(), 0444), 0);
  ASSERT_EQ(::chmod((folder / "").c_str(), 0555), 0);
  EXPECT_EQ(read_every_way(folder / "run.db"), "read");
  ASSERT_EQ(::chmod((folder / "").c_str(), 0755), 0);
}

TEST(ForeignRecord, IsReadWithoutLogWhenUnfinished) {
  const Folder folder;
  leave_unfinished(folder / "run.db", 300);
  std::filesystem::remove(folder / "run.db-wal");
  EXPECT_EQ(read_every_way(folder / "run.db"), "read") << "the checkpointed rows";
}

TEST(ForeignRecord, IsRefusedWithoutRollbackWhenJournalExists) {
  const Folder folder;
  const auto path = folder / "run.db";
  store_with(path, 3000).reset();
  if (const auto child = ::fork(); child != 0) {
    ASSERT_EQ(::waitpid(child, nullptr, 0), child);
  } else {
    auto database = Database::open(path, Access::read_write, 0).value();
    (void)database.query_text("PRAGMA journal_mode = DELETE");
    (void)database.query_text("PRAGMA cache_size = 2");
    (void)database.execute("BEGIN IMMEDIATE");
    (void)database.execute("UPDATE sample SET set_point_c = 0");
    ::_exit(0);
  }
  ASSERT_TRUE(std::filesystem::exists(path + "-journal"));
  constexpr const char* kRefusal =
      "there is a journal next to it (run.db-journal): another program was interrupted while it changed the record, "
      "and the journal is not applied here";
  EXPECT_EQ(read_every_way(path), kRefusal);
  const auto before = listing(folder / "");
  const auto again = Store::reopen(path);
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().what, kRefusal);
  EXPECT_EQ(listing(folder / ""), before);
  std::filesystem::create_directory(folder / "other");
  store_with(folder / "other/run.db", 3).reset();
  std::filesystem::create_symlink("nowhere", folder / "other/run.db-journal");
  EXPECT_EQ(read_every_way(folder / "other/run.db"), kRefusal);
}

TEST(ForeignRecord, KeepsLogWhenFileIsEmpty) {
  const Folder folder;
  leave_unfinished(folder / "run.db", 300);
  std::filesystem::resize_file(folder / "run.db", 0);
  EXPECT_EQ(read_every_way(folder / "run.db"), "not a gyrotherm record");
}

TEST(ForeignRecord, IsRefusedWhenTablesDiffer) {
  const Folder folder;
  const auto path = folder / "run.db";
  auto store = store_with(path, 3);
  ASSERT_TRUE(store->finish());
  store.reset();
  const auto whole = read_bytes(path);
  const std::vector<std::pair<std::string, std::string>> edits{
      {"DROP TABLE sample; CREATE VIEW sample AS WITH RECURSIVE x(slot) AS (SELECT 0 UNION ALL SELECT slot + 1 FROM x) "
       "SELECT * FROM x",
       "it has a view \"sample\""},
      {"DROP TABLE meta; CREATE VIEW meta AS WITH RECURSIVE x(n) AS (SELECT 0 UNION ALL SELECT n + 1 FROM x) SELECT "
       "'schema' AS key, 'gyrotherm-run/1' AS value FROM x",
       "it has a view \"meta\""},
      {"CREATE TRIGGER t AFTER INSERT ON event BEGIN DELETE FROM sample; END", "it has a trigger \"t\""},
      {"CREATE INDEX i ON sample(pulses)", "it has a index \"i\""},
      {"CREATE TABLE more(x)", "its table \"more\" differs"},
      {"DROP TABLE gap", "it has no table \"gap\""},
      {"ALTER TABLE sample ADD COLUMN more REAL", "its table \"sample\" differs"},
      {"ALTER TABLE sample RENAME COLUMN \"shell-1.b\" TO other", "its table \"sample\" differs"},
      {"ALTER TABLE gap ADD COLUMN more AS (first + 1)", "its table \"gap\" differs"},
      {"ALTER TABLE channel ADD COLUMN more TEXT", "its table \"channel\" differs"},
      {"DROP TABLE list; CREATE VIRTUAL TABLE list USING fts5(name, position, value)", "it has a table \"list\""},
      {"ANALYZE", "its table \"sqlite_stat1\" differs"},
      {"CREATE VIEW v2_sample AS SELECT 1", "it has a view \"v2_sample\""},
      {"DROP VIEW v1_gap; CREATE VIEW v1_gap AS WITH RECURSIVE x(n) AS (SELECT 0 UNION ALL SELECT n + 1 FROM x) SELECT "
       "n "
       "FROM x",
       "its view \"v1_gap\" differs"},
      {"DROP VIEW v1_sample", "its view \"v1_sample\" is missing"},
      {"UPDATE channel SET polynomial = '1 2'", "its view \"v1_sample\" differs"}};
  for (const auto& [edit, why] : edits) {
    std::ofstream(path, std::ios::binary) << whole;
    execute(path, edit);
    EXPECT_EQ(read_every_way(path), why + ", expected the tables of a record and nothing else") << edit;
    EXPECT_FALSE(Store::reopen(path)) << edit;
  }
}

TEST(ForeignRecord, IsReadWithoutViews) {
  const Folder folder;
  store_with(folder / "run.db", 3).reset();
  execute(folder / "run.db", "DROP VIEW v1_channel; DROP VIEW v1_event; DROP VIEW v1_gap; DROP VIEW v1_sample");
  EXPECT_EQ(read_every_way(folder / "run.db"), "read");
  EXPECT_TRUE(Store::reopen(folder / "run.db"));
}

TEST(ForeignRecord, IsRefusedWhenTimesAreImpossible) {
  const Folder folder;
  const auto path = folder / "run.db";
  auto store = store_with(path, 3);
  ASSERT_TRUE(store->finish());
  store.reset();
  const auto whole = read_bytes(path);
  constexpr const char* kSeconds = "a second of the run is not between 0 and 100000000";
  const std::string sample =
      "INSERT INTO sample SELECT {}, monotonic_ns, utc_ns, set_point_c, chamber_air_c, chamber_set_point_c, A, "
      "\"shell-1.b\", pulses, interval_ns, segment, cycle, phase, in_segment_ns, soaked_ns, state, "
      "true_bias_deg_per_h, chain FROM sample "
      "WHERE slot = 2";
  const auto sample_of = [&](const std::string& slot) {
    auto sql = sample;
    return sql.replace(sql.find("{}"), 2, slot);
  };
  const std::vector<std::pair<std::string, std::string>> edits{
      {sample_of("-1"), kSeconds},
      {sample_of("100000001"), kSeconds},
      {sample_of("9223372036854775807"), kSeconds},
      {"INSERT INTO gap VALUES(3, 1000000000000000000, 'x', 0)", kSeconds},
      {"INSERT INTO gap VALUES(-5, 2, 'x', 0)", kSeconds},
      {"INSERT INTO gap VALUES(5, 4, 'x', 0)", kSeconds},
      {"INSERT INTO event VALUES(9, -2, 0, 0, 'note', NULL, NULL, NULL, NULL, 'x', 0)", kSeconds},
      {"UPDATE sample SET utc_ns = -9223372036854775807 WHERE slot = 1", "second 1 has impossible times"},
      {"UPDATE sample SET soaked_ns = 9223372036854775807 WHERE slot = 1", "second 1 has impossible times"},
      {"INSERT INTO event VALUES(9, 2, 0, 9223372036854775807, 'note', NULL, NULL, NULL, NULL, 'x', 0)",
       "an event has impossible times"},
      {"UPDATE meta SET value = -1 WHERE key = 'started_utc_ns'", "the run started at an impossible time"}};
  for (const auto& [edit, why] : edits) {
    std::ofstream(path, std::ios::binary) << whole;
    execute(path, edit);
    EXPECT_EQ(read_every_way(path), why) << edit;
  }
  std::ofstream(path, std::ios::binary) << whole;
  execute(path, sample_of("100000000"));
  EXPECT_EQ(read_every_way(path), "read");
}

TEST(ForeignRecord, ProposesNameWithItsEnding) {
  const Folder folder;
  store_with(folder / "run.db", 3).reset();
  EXPECT_EQ(open_record(folder / "run").error().what,
            fmt::format("no such file. Did you mean \"{}\"?", folder / "run.db"));
  EXPECT_EQ(open_record(folder / "ran").error().what, "no such file, expected a gyrotherm record");
}

TEST(ForeignRecord, IsRefusedWithSchemaNameWhenNewer) {
  const Folder folder;
  store_with(folder / "run.db", 3).reset();
  execute(folder / "run.db", "PRAGMA user_version = 2; CREATE TABLE more(x)");
  EXPECT_EQ(read_every_way(folder / "run.db"), "schema \"gyrotherm-run/2\", expected \"gyrotherm-run/1\"");
}

TEST(ForeignRecord, RefusesPipeWithoutWaiting) {
  const Folder folder;
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  EXPECT_EQ(read_every_way(folder / "pipe"), "is not a regular file, expected a gyrotherm record");
  leave_unfinished(folder / "run.db", 3);
  std::filesystem::remove(folder / "run.db-wal");
  ASSERT_EQ(::mkfifo((folder / "run.db-wal").c_str(), 0600), 0);
  EXPECT_NE(read_every_way(folder / "run.db"), "read");
}

/// While the record is read, no program can begin to write it; afterwards any program can.
TEST(ForeignRecord, LocksOutWritersWhileRead) {
  const Folder folder;
  store_with(folder / "run.db", 3).reset();
  auto closed = store_with(folder / "closed.db", 3);
  ASSERT_TRUE(closed->finish());
  closed.reset();
  const auto write = [&] {
    auto database = Database::open(folder / "closed.db", Access::read_write, 0);
    return database ? database->execute("DELETE FROM sample") : Result<void>(failure(database.error()));
  };
  {
    const auto reading = open_record(folder / "run.db");
    const auto reading_too = open_record(folder / "closed.db");
    ASSERT_TRUE(reading && reading_too);
    EXPECT_TRUE(open_record(folder / "run.db")) << "others may read";
    const auto written = write();
    ASSERT_FALSE(written);
    EXPECT_TRUE(is_locked(written.error()));
    EXPECT_FALSE(Store::reopen(folder / "run.db"));
  }
  EXPECT_TRUE(write());
}

TEST(ForeignRecord, IsNotOpenedByItsWriter) {
  const Folder folder;
  auto store = store_with(folder / "run.db", 3);
  std::filesystem::create_hard_link(folder / "run.db", folder / "same.db");
  for (const char* name : {"run.db", "same.db"}) {
    const auto record = read_record(folder / name);
    ASSERT_FALSE(record);
    EXPECT_EQ(record.error().kind, FaultKind::storage);
  }
  if (const auto child = ::fork(); child != 0) {
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    EXPECT_EQ(status, 0) << "the lock still exists";
  } else {
    auto other = Database::open(folder / "run.db", Access::read_write, 0).value();
    ::_exit(other.execute("DELETE FROM sample") ? 1 : 0);
  }
  EXPECT_TRUE(store->append(sample_at(3), {}) && store->sync());
  store.reset();
  EXPECT_EQ(read_record(folder / "run.db")->slot.size(), 4u);
}

TEST(ForeignRecord, IsCreatedForOwnerAndGroupOnly) {
  const Folder folder;
  const auto before = ::umask(0);
  auto store = store_with(folder / "run.db", 3);
  for (const char* name : {"run.db", "run.db-wal", "run.db.status"}) {
    struct stat facts {};
    EXPECT_EQ(::stat((folder / name).c_str(), &facts), 0);
    EXPECT_EQ(facts.st_mode & 07777, 0640u) << name;
  }
  EXPECT_TRUE(store->finish());
  ::umask(before);
  struct stat facts {};
  EXPECT_EQ(::stat((folder / "run.db.sha256").c_str(), &facts), 0);
  EXPECT_EQ(facts.st_mode & 07777, 0640u);
}

TEST(ForeignRecord, DoesNotFollowLinksOfItsFiles) {
  const Folder folder;
  std::ofstream(folder / "precious") << "precious";
  for (const char* name : {"run.db.status", "run.db.sha256", "run.db.status.part", "run.db.sha256.part"})
    std::filesystem::create_symlink("precious", folder / name);
  std::filesystem::create_symlink("precious", folder / "link.db");
  auto store = store_with(folder / "run.db", 3);
  ASSERT_TRUE(store->finish());
  store.reset();
  EXPECT_EQ(read_bytes(folder / "precious"), "precious");
  EXPECT_TRUE(verify_record(folder / "run.db")->manifest);
  EXPECT_FALSE(Store::create(folder / "link.db", two_thermometers()));
  std::filesystem::create_symlink("nowhere", folder / "dangling.db");
  EXPECT_FALSE(Store::create(folder / "dangling.db", two_thermometers()));
  EXPECT_FALSE(std::filesystem::exists(folder / "nowhere"));
}

}  // namespace
}  // namespace gyrotherm::record
