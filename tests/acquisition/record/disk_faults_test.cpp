// SPDX-License-Identifier: Apache-2.0
/// Tests disks that fail, fill up, are locked or lose power at any operation. Nothing acknowledged is lost, and rows in
/// memory are written once a disk is available again.
#include <gtest/gtest.h>

#include <cstdlib>
#include <iostream>
#include <random>

#include "acquisition/record/chain.hpp"
#include "acquisition/record/record_writer.hpp"
#include "tests/acquisition/record/runs.hpp"
#include "tests/support/failing_vfs.hpp"

namespace gyrotherm::record {
namespace {

#ifdef GYROTHERM_NIGHTLY
constexpr int kEachPoint = 1;
constexpr unsigned kCuts = 1000;
#else
/// The tests cover every fifth operation.
constexpr int kEachPoint = 5;
constexpr unsigned kCuts = 100;
#endif

constexpr int kRows = 100;  ///< one transaction each

/// Writes rows as the worker of a store does, and stores the last acknowledged one.
class RetryingWriter {
 public:
  explicit RetryingWriter(const std::string& path) {
    auto file = RunFile::create(path, two_thermometers());
    if (!file) return;
    writer_.emplace(std::move(*file), path,
                    RecordWriterOptions{.most_rows = 14'400, .longest_locked = 3, .last_slot = -1});
  }
  [[nodiscard]] bool has_begun() const { return writer_.has_value(); }
  [[nodiscard]] std::int64_t acknowledged() const { return writer_ ? writer_->acknowledged() : -1; }
  [[nodiscard]] int parts() const { return writer_->part(); }

  /// Writes one second. Returns false if the disk did not accept it.
  bool second() {
    backlog_.push(sample_entry(sample_at(next_++), {}, two_thermometers()));
    return flush();
  }
  bool flush() {
    const auto batch = backlog_.take(1000);
    if (batch.empty()) return true;
    for (int attempt = 0; attempt < 2; ++attempt) {
      const auto written = writer_->write(batch, {});
      if (written) {
        backlog_.acknowledge();
        return true;
      }
      if (RecordWriter::is_temporary(written.error())) break;
    }
    backlog_.put_back();
    return false;
  }
  Result<void> finish() { return writer_->finish(); }

 private:
  std::optional<RecordWriter> writer_;
  Backlog backlog_{14'400};
  std::int64_t next_{};
};

void remove_all_in(const std::string& folder) {
  for (const auto& entry : std::filesystem::directory_iterator(folder)) std::filesystem::remove(entry.path());
}

void expect_record(const std::string& path, std::int64_t acknowledged, const std::string& what) {
  const auto record = read_record(path);
  ASSERT_TRUE(record) << what << ": " << text(record.error());
  ASSERT_GE(static_cast<std::int64_t>(record->slot.size()), acknowledged + 1) << what;
  for (std::size_t i = 0; i < record->slot.size(); ++i)
    ASSERT_EQ(record->slot[i], static_cast<std::int64_t>(i)) << what;
  const auto verified = verify_record(path);
  ASSERT_TRUE(verified) << what << ": " << text(verified.error());
}

void expect_valid_record(const std::string& path, std::int64_t acknowledged, const std::string& what) {
  expect_record(path, acknowledged, what);
  int databases = 0;
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(path).parent_path())) {
    if (entry.path().extension() != ".db") continue;
    auto database = Database::open(entry.path(), Access::read_only, 0).value();
    ASSERT_EQ(database.query_text("PRAGMA integrity_check").value_or("?"), "ok") << what << ": " << entry.path();
    ++databases;
  }
  EXPECT_GE(databases, 1) << what;
}

/// Runs with one fault at one operation. Returns false if the run has fewer operations.
bool run_with_fault(const std::string& folder, std::int64_t operation, bool sticky, tests::FailingVfs::Kind kind) {
  const std::string path = folder + "/run.db";
  const auto what = "operation " + std::to_string(operation) + (sticky ? " and all that follow" : "");
  remove_all_in(folder);
  std::int64_t failures = 0;
  std::int64_t acknowledged = -1;
  bool began = false;
  {
    tests::FailingVfs vfs;
    vfs.fail(operation, sticky, kind);
    RetryingWriter run(path);
    began = run.has_begun();
    int refused = 0;
    for (int row = 0; began && row < kRows; ++row)
      if (!run.second() && ++refused == 8) vfs.heal();
    failures = vfs.failures();
    vfs.heal();
    EXPECT_TRUE(!began || run.flush()) << what << ": the rows in memory are written after the disk recovers";
    acknowledged = run.acknowledged();
    EXPECT_TRUE(!began || acknowledged == kRows - 1) << what;
    EXPECT_TRUE(!began || kind != tests::FailingVfs::Kind::full || run.parts() == 1)
        << what << ": a full disk does not cause a new file";
    EXPECT_TRUE(!began || operation % 2 == 0 || run.finish()) << what;
  }
  if (began) expect_valid_record(path, acknowledged, what);
  EXPECT_EQ(std::filesystem::exists(path), began) << what << ": a file that could not be created is removed";
  return failures > 0;
}

void run_with_each_fault(tests::FailingVfs::Kind kind) {
  const Folder folder;
  std::filesystem::create_directory(folder / "disk");
  int points = 0;
  for (const bool sticky : {false, true})
    for (std::int64_t operation = 1; run_with_fault(folder / "disk", operation, sticky, kind);
         operation += kEachPoint) {
      ++points;
      if (::testing::Test::HasFailure()) return;
    }
  std::cout << points << " points\n";
  EXPECT_GT(points, 10);
}

TEST(DiskFaults, LoseNothingOnErrorAtAnyOperation) { run_with_each_fault(tests::FailingVfs::Kind::io_error); }

TEST(DiskFaults, ContinueInSameFileAfterFullDisk) { run_with_each_fault(tests::FailingVfs::Kind::full); }

/// If the failed file could be opened, the run would seem to be abandoned.
TEST(DiskFaults, KeepRecordLockedBetweenTwoFiles) {
  const Folder folder;
  const auto path = folder / "run.db";
  tests::FailingVfs vfs;
  RetryingWriter run(path);
  ASSERT_TRUE(run.second());
  vfs.fail(1, true, tests::FailingVfs::Kind::io_error);
  for (int attempt = 0; attempt < 3; ++attempt) {
    EXPECT_FALSE(run.second());
    const auto files = find_record_files(path);
    ASSERT_FALSE(files) << attempt;
    EXPECT_TRUE(is_locked(files.error())) << text(files.error());
  }
  vfs.heal();
  ASSERT_TRUE(run.flush());
  EXPECT_EQ(run.parts(), 2);
  EXPECT_TRUE(open_record(path)) << "which the next file continues";
}

TEST(DiskFaults, LoseNothingAcknowledgedInPowerCut) {
  const Folder folder;
  std::filesystem::create_directory(folder / "disk");
  const std::string path = folder / "disk/run.db";
  for (unsigned seed = 0; seed < kCuts; ++seed) {
    std::mt19937 random(seed);
    remove_all_in(folder / "disk");
    std::int64_t acknowledged = -1;
    {
      tests::FailingVfs vfs;
      {
        RetryingWriter run(path);
        ASSERT_TRUE(run.has_begun());
        vfs.fail(1 + random() % 600, true, tests::FailingVfs::Kind::power_cut);
        for (int row = 0; row < 150 && vfs.failures() == 0; ++row) run.second();
        acknowledged = run.acknowledged();
      }
      vfs.lose_unsynced_data(seed);
    }
    const auto what = "seed " + std::to_string(seed);
    expect_valid_record(path, acknowledged, what);
    auto store = Store::reopen(path);
    ASSERT_TRUE(store) << what << ": " << text(store.error());
    ASSERT_TRUE((*store)->finish()) << what;
  }
}

/// The program is killed, or the power fails, at one operation of the close: later operations have no effect.
TEST(DiskFaults, LeaveRecordReadableWhenCloseIsInterrupted) {
  const Folder folder;
  std::filesystem::create_directory(folder / "disk");
  const std::string path = folder / "disk/run.db";
  for (const bool power_cut : {false, true})
    for (std::int64_t operation = 1, done = 0; done == 0; ++operation) {
      remove_all_in(folder / "disk");
      {
        tests::FailingVfs vfs;
        {
          RetryingWriter run(path);
          ASSERT_TRUE(run.has_begun());
          for (int row = 0; row < kRows; ++row) ASSERT_TRUE(run.second());
          vfs.fail(operation, true, tests::FailingVfs::Kind::power_cut);
          (void)run.finish();
          done = vfs.failures() == 0 ? 1 : 0;
        }
        if (power_cut) vfs.lose_unsynced_data(static_cast<unsigned>(operation));
      }
      const auto what = (power_cut ? "power cut at " : "killed at ") + std::to_string(operation);
      EXPECT_FALSE(std::filesystem::exists(path + "-journal")) << what;
      expect_valid_record(path, kRows - 1, what);
      EXPECT_TRUE(done == 0 || operation > 10) << what;
      if (HasFailure()) return;
    }
}

/// After a failed sync, Linux marks the pages as clean: the next sync succeeds, but the data are not on the disk.
TEST(DiskFaults, LoseNothingAcknowledgedInPowerCutAfterFailedSync) {
  const Folder folder;
  std::filesystem::create_directory(folder / "disk");
  const std::string path = folder / "disk/run.db";
  for (std::int64_t sync = 1;; ++sync) {
    remove_all_in(folder / "disk");
    std::int64_t acknowledged = -1;
    {
      tests::FailingVfs vfs;
      {
        RetryingWriter run(path);
        ASSERT_TRUE(run.has_begun());
        vfs.fail(sync, false, tests::FailingVfs::Kind::sync_error);
        for (int row = 0; row < 2 * kRows; ++row) run.second();
        acknowledged = run.acknowledged();
        if (vfs.failures() == 0) break;
        vfs.fail(1, true, tests::FailingVfs::Kind::power_cut);
      }
      vfs.lose_unsynced_data(static_cast<unsigned>(sync));
    }
    EXPECT_EQ(acknowledged, 2 * kRows - 1);
    expect_valid_record(path, acknowledged, "sync " + std::to_string(sync));
    if (HasFailure()) return;
  }
}

/// Tests the last write before a run's first command, then all writes.
TEST(DiskFaults, AreFoundBeforeFirstCommandWhenDiskLosesWrites) {
  const Folder folder;
  const auto path = folder / "run.db";
  std::int64_t writes = 0;
  {
    tests::FailingVfs vfs;
    vfs.fail(0, true, tests::FailingVfs::Kind::forgetful);
    const auto store = Store::create(path, two_thermometers(), {});
    ASSERT_TRUE(store);
    writes = vfs.operations();
  }
  for (const std::int64_t from : {writes, writes / 2, std::int64_t{1}}) {
    remove_record(path);
    tests::FailingVfs vfs;
    vfs.fail(from, true, tests::FailingVfs::Kind::forgetful);
    EXPECT_FALSE(Store::create(path, two_thermometers(), {})) << from;
    EXPECT_GT(vfs.failures(), 0) << from;
    EXPECT_FALSE(std::filesystem::exists(path)) << from;
  }
}

/// A small ext4 file system with blocks of 4 KiB in a file. Only root can mount it.
class SmallDisk {
 public:
  explicit SmallDisk(const Folder& folder) : image_(folder / "image"), mounted_(folder / "mounted") {
    std::filesystem::create_directory(mounted_);
    works_ = ::geteuid() == 0 && run("truncate -s 8M '" + image_ + "' && mkfs.ext4 -q -b 4096 -m 0 '" + image_ +
                                     "' && mount -o loop '" + image_ + "' '" + mounted_ + "'");
  }
  ~SmallDisk() {
    if (works_) run("umount '" + mounted_ + "'");
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;
  [[nodiscard]] bool is_mounted() const { return works_; }
  [[nodiscard]] std::string operator/(const std::string& name) const { return mounted_ + "/" + name; }
  /// Fills the disk except for `but` bytes.
  void fill_up(std::uintmax_t but) const {
    const auto free = std::filesystem::space(mounted_).available;
    if (free <= but) return;
    run("dd if=/dev/zero of='" + mounted_ +
        "/ballast' bs=4096 status=none count=" + std::to_string((free - but) / 4096));
  }
  void make_room() const { std::filesystem::remove(mounted_ + "/ballast"); }

 private:
  static bool run(const std::string& command) { return std::system((command + " 2> /dev/null").c_str()) == 0; }
  std::string image_;
  std::string mounted_;
  bool works_{};
};

TEST(DiskFaults, LoseNothingWhenSmallDiskFillsUp) {
#ifdef GYROTHERM_NIGHTLY
  constexpr int kPoints = 64;
#else
  constexpr int kPoints = 8;
#endif
  const Folder folder;
  const SmallDisk disk(folder);
  if (!disk.is_mounted()) GTEST_SKIP() << "needs root, mkfs.ext4 and a loop device";
  for (int point = 0; point < kPoints; ++point) {
    const auto path = disk / ("run" + std::to_string(point) + ".db");
    auto store = Store::create(path, two_thermometers(), {.background = true, .retry = std::chrono::milliseconds(20)});
    ASSERT_TRUE(store) << text(store.error());
    disk.fill_up(static_cast<std::uintmax_t>(point) * 64 * 1024 * 8 / kPoints);
    std::int64_t slot = 0;
    const auto append = [&](int rows) {
      for (; rows > 0; --rows) EXPECT_TRUE((*store)->append(sample_at(slot++), {}));
    };
    while ((*store)->health().trouble.empty() && slot < 20'000) {
      append(50);
      static_cast<void>((*store)->settle(std::chrono::milliseconds(200)));
    }
    EXPECT_NE((*store)->health().trouble.find("the disk is full"), std::string::npos) << (*store)->health().trouble;
    append(500);
    EXPECT_FALSE((*store)->settle(std::chrono::milliseconds(100)));
    EXPECT_GE((*store)->health().backlog_s, 500);
    disk.make_room();
    EXPECT_TRUE((*store)->settle(std::chrono::seconds(20))) << (*store)->health().trouble;
    EXPECT_EQ((*store)->health().parts, 1);
    ASSERT_TRUE((*store)->finish());
    store->reset();
    expect_record(path, slot - 1, "point " + std::to_string(point));
    std::filesystem::remove(path);
  }
}

}  // namespace
}  // namespace gyrotherm::record
