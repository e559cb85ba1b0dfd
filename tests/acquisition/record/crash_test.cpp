// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <random>

#include "acquisition/record/status.hpp"
#include "tests/acquisition/record/runs.hpp"
#include "tests/support/slept.hpp"

namespace gyrotherm::record {
namespace {

/// A process that writes a run and reports each acknowledged slot on a pipe until it is killed.
class WriterProcess {
 public:
  WriterProcess(const std::string& path, unsigned seed) {
    int ends[2];
    EXPECT_EQ(::pipe(ends), 0);
    read_end_ = ends[0];
    process_ = ::fork();
    if (process_ == 0) {
      ::close(ends[0]);
      write_run(path, seed, ends[1]);
      ::_exit(1);
    }
    ::close(ends[1]);
  }
  ~WriterProcess() {
    kill();
    ::close(read_end_);
  }
  WriterProcess(const WriterProcess&) = delete;
  WriterProcess& operator=(const WriterProcess&) = delete;

  /// Waits for one acknowledgement. Returns −1 at the end of the pipe.
  std::int64_t next_acknowledged() {
    std::int64_t slot = -1;
    return ::read(read_end_, &slot, sizeof slot) == sizeof slot ? slot : -1;
  }
  void kill() {
    if (process_ <= 0) return;
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
    process_ = -1;
  }
  [[nodiscard]] pid_t process() const { return process_; }

 private:
  static void write_run(const std::string& path, unsigned seed, int acknowledged) {
    std::mt19937 random(seed);
    auto store = Store::create(path, two_thermometers());
    if (!store) return;
    for (std::int64_t slot = 0;;) {
      for (auto batch = 1 + random() % 40; batch > 0; --batch)
        if (!(*store)->append(sample_at(slot++), {})) return;
      const auto last = (*store)->sync();
      if (!last || ::write(acknowledged, &*last, sizeof *last) != sizeof *last) return;
    }
  }
  int read_end_{-1};
  pid_t process_{-1};
};

TEST(Crash, LosesNothingAcknowledged) {
  constexpr int kKills = 20;
  std::mt19937 random(20151130);
  for (int kill = 0; kill < kKills; ++kill) {
    const Folder folder;
    const std::string path = folder / "run.db";
    std::int64_t acknowledged = -1;
    {
      WriterProcess writer(path, static_cast<unsigned>(kill));
      const auto wanted = 1 + random() % 60;
      for (unsigned i = 0; i < wanted; ++i) acknowledged = writer.next_acknowledged();
      writer.kill();
      for (std::int64_t slot; (slot = writer.next_acknowledged()) >= 0;) acknowledged = slot;
    }
    const auto record = read_record(path);
    ASSERT_TRUE(record) << "kill " << kill << ": " << text(record.error());
    EXPECT_FALSE(record->finished);
    ASSERT_GE(static_cast<std::int64_t>(record->slot.size()), acknowledged + 1) << "kill " << kill;
    for (std::size_t i = 0; i < record->slot.size(); ++i) ASSERT_EQ(record->slot[i], static_cast<std::int64_t>(i));
    auto store = Store::reopen(path);
    ASSERT_TRUE(store) << "kill " << kill << ": " << text(store.error());
    ASSERT_TRUE((*store)->append(sample_at(record->slot.back() + 1), {}));
    ASSERT_TRUE((*store)->finish());
    store->reset();
    EXPECT_EQ(read_record(path)->slot.back(), record->slot.back() + 1);
  }
}

TEST(Crash, LeavesFilesThatReadingDoesNotChange) {
  const Folder folder;
  const std::string path = folder / "run.db";
  {
    WriterProcess writer(path, 1);
    while (writer.next_acknowledged() < 200) {
    }
  }
  const auto size = std::filesystem::file_size(path);
  const auto log_size = std::filesystem::file_size(path + "-wal");
  ASSERT_TRUE(read_record(path));
  ASSERT_TRUE(read_status(path));
  EXPECT_EQ(std::filesystem::file_size(path), size);
  EXPECT_EQ(std::filesystem::file_size(path + "-wal"), log_size);
  auto store = Store::reopen(path);
  ASSERT_TRUE(store) << text(store.error());
  ASSERT_TRUE((*store)->finish());
  store->reset();
  EXPECT_FALSE(std::filesystem::exists(path + "-wal") || std::filesystem::exists(path + "-shm"))
      << "one file in the end";
}

TEST(Crash, PreventsTwoWritersOfOneRecord) {
  const Folder folder;
  const std::string path = folder / "run.db";
  WriterProcess writer(path, 2);
  ASSERT_GE(writer.next_acknowledged(), 0);
  const tests::SleepMeter meter;
  const auto second = Store::reopen(path);
  EXPECT_LT(meter.slept(), std::chrono::seconds(1)) << "it does not wait for the lock";
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().kind, FaultKind::storage);
  EXPECT_EQ(second.error().what, "being written by another program");
  EXPECT_FALSE(Store::create(path, two_thermometers()));
  const auto before = writer.next_acknowledged();
  EXPECT_GT(writer.next_acknowledged(), before) << "the first writer continues";
}

TEST(Crash, NamesWriterOfRecordBeingWritten) {
  const Folder folder;
  const std::string path = folder / "run.db";
  WriterProcess writer(path, 3);
  ASSERT_GE(writer.next_acknowledged(), 0);
  const auto record = read_record(path);
  ASSERT_FALSE(record);
  EXPECT_EQ(record.error().kind, FaultKind::storage);
  EXPECT_EQ(record.error().what, "being written by another program (process " + std::to_string(writer.process()) + ")");
}

TEST(Crash, ReadsStatusOfRecordBeingWrittenFromStatusFile) {
  const Folder folder;
  const std::string path = folder / "run.db";
  WriterProcess writer(path, 4);
  std::int64_t acknowledged = writer.next_acknowledged();
  ASSERT_GE(acknowledged, 0);
  const auto live = read_status(path);
  ASSERT_TRUE(live) << text(live.error());
  EXPECT_TRUE(live->being_written);
  EXPECT_EQ(live->pid, writer.process());
  EXPECT_GE(live->acknowledged, acknowledged);
  writer.kill();
  const auto dead = read_status(path);
  ASSERT_TRUE(dead) << text(dead.error());
  EXPECT_FALSE(dead->being_written);
  EXPECT_GE(dead->acknowledged, live->acknowledged);
}

}  // namespace
}  // namespace gyrotherm::record
