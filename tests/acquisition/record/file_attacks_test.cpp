// SPDX-License-Identifier: Apache-2.0
/// Tests interference of other programs with the files of a record being written. No acknowledged second is lost.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <functional>
#include <thread>

#include "acquisition/record/chain.hpp"
#include "acquisition/record/record_files.hpp"
#include "acquisition/record/run_file.hpp"
#include "acquisition/record/status.hpp"
#include "tests/acquisition/record/runs.hpp"

namespace gyrotherm::record {
namespace {

namespace fs = std::filesystem;

struct Attack {
  const char* name;
  std::function<void(const std::string& path)> act;
  /// Damages the record's main file and not only its log.
  bool damages_database;
};

void overwrite(const std::string& file, std::streamoff at, std::size_t size, char with) {
  std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
  stream.seekp(at);
  stream << std::string(size, with);
}

std::size_t size_on_disk(const std::string& file) { return fs::file_size(file); }

std::vector<Attack> attacks() {
  return {
      {"Removed", [](const auto& path) { fs::remove(path); }, true},
      {"RemovedWithItsLog", [](const auto& path) { fs::remove(path), fs::remove(path + "-wal"); }, true},
      {"Moved", [](const auto& path) { fs::rename(path, path + ".away"); }, true},
      {"ReplacedByACopy",
       [](const auto& path) {
         fs::copy_file(path, path + ".copy");
         fs::rename(path + ".copy", path);
       },
       true},
      {"ReplacedByALink",
       [](const auto& path) {
         fs::rename(path, path + ".away");
         fs::create_symlink(path + ".away", path);
       },
       true},
      {"ReplacedByAFolder",
       [](const auto& path) {
         fs::rename(path, path + ".away");
         fs::create_directory(path);
       },
       true},
      {"ReplacedByAFifo",
       [](const auto& path) {
         fs::remove(path);
         ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
       },
       true},
      {"Emptied", [](const auto& path) { fs::resize_file(path, 0); }, true},
      {"CutInHalf", [](const auto& path) { fs::resize_file(path, size_on_disk(path) / 2); }, true},
      {"BeginningOverwritten", [](const auto& path) { overwrite(path, 0, 100, 'x'); }, true},
      {"MiddleOverwritten",
       [](const auto& path) { overwrite(path, static_cast<std::streamoff>(size_on_disk(path) / 2), 4096, 'x'); }, true},
      {"AllOverwritten", [](const auto& path) { overwrite(path, 0, size_on_disk(path), '\0'); }, true},
      {"WrittenBehind",
       [](const auto& path) { std::ofstream(path, std::ios::app | std::ios::binary) << "bytes after its end"; }, true},
      {"LogRemoved", [](const auto& path) { fs::remove(path + "-wal"); }, false},
      {"LogMoved", [](const auto& path) { fs::rename(path + "-wal", path + "-away"); }, false},
      {"LogReplaced",
       [](const auto& path) {
         fs::copy_file(path + "-wal", path + "-copy");
         fs::rename(path + "-copy", path + "-wal");
       },
       false},
      {"LogEmptied", [](const auto& path) { fs::resize_file(path + "-wal", 0); }, false},
      {"LogCutInHalf", [](const auto& path) { fs::resize_file(path + "-wal", size_on_disk(path + "-wal") / 2); },
       false},
      {"LogOverwritten", [](const auto& path) { overwrite(path + "-wal", 0, size_on_disk(path + "-wal"), 'x'); },
       false},
      {"LogsHeadOverwritten", [](const auto& path) { overwrite(path + "-wal", 0, 32, '\0'); }, false},
  };
}

/// The number of seconds before the attack and after it.
constexpr std::int64_t kBefore = 450, kAfter = 20;  // two checkpoints precede the attack

std::unique_ptr<Store> run_attack(const std::string& path, const Attack& attack) {
  auto store =
      Store::create(path, two_thermometers(), {.background = true, .retry = std::chrono::milliseconds(20)}).value();
  for (std::int64_t slot = 0; slot < kBefore; ++slot) {
    EXPECT_TRUE(store->append(sample_at(slot), {}));
    EXPECT_TRUE(store->settle(kLong));
  }
  attack.act(path);
  for (std::int64_t slot = kBefore; slot < kBefore + kAfter; ++slot) EXPECT_TRUE(store->append(sample_at(slot), {}));
  EXPECT_TRUE(store->settle(kLong));
  return store;
}

class FileAttacks : public ::testing::TestWithParam<Attack> {};

TEST_P(FileAttacks, LoseNothingAcknowledgedAndAreReported) {
  const Folder folder;
  const auto path = folder / "run.db";
  auto store = run_attack(path, GetParam());
  EXPECT_EQ(store->health().parts, 2);
  EXPECT_NE(store->health().damage.find("by another program while it was being written"), std::string::npos)
      << store->health().damage;
  const auto finished = store->finish();
  EXPECT_EQ(finished.has_value(), !GetParam().damages_database) << "status reports how it ended";
  store.reset();
  EXPECT_EQ(path_exists(manifest_path(path)), !GetParam().damages_database);

  for (const auto& name : {path, part_path(path, 2)}) {
    const auto record = read_record(name);
    ASSERT_TRUE(record) << name << ": " << text(record.error());
    EXPECT_EQ(record->slot.size(), static_cast<std::size_t>(kBefore + kAfter)) << name;
    EXPECT_EQ(record->gaps.size(), 0u) << name;
    EXPECT_EQ(read_status(name).value().acknowledged, kBefore + kAfter - 1) << name;
  }
  EXPECT_TRUE(verify_record(part_path(path, 2)));
  EXPECT_TRUE(GetParam().damages_database || verify_record(path));
}

TEST_P(FileAttacks, LetRunResumeAfterProgramDied) {
  const Folder folder;
  const auto path = folder / "run.db";
  run_attack(path, GetParam()).reset();
  const bool whole = verify_record(path).has_value();  // for example after a copy
  auto store = Store::reopen(path, {.background = true});
  ASSERT_TRUE(store) << text(store.error());
  ASSERT_TRUE((*store)->append(sample_at(kBefore + kAfter), {}));
  EXPECT_EQ((*store)->finish().has_value(), whole);
  store->reset();
  EXPECT_EQ(path_exists(manifest_path(path)), whole);
  EXPECT_EQ(read_record(path).value().slot.size(), static_cast<std::size_t>(kBefore + kAfter + 1));
}

TEST_P(FileAttacks, LoseNothingBetweenLastRowAndEnd) {
  const Folder folder;
  const auto path = folder / "run.db";
  auto store =
      Store::create(path, two_thermometers(), {.background = true, .retry = std::chrono::milliseconds(20)}).value();
  for (std::int64_t slot = 0; slot < kBefore; ++slot) {
    ASSERT_TRUE(store->append(sample_at(slot), {}));
    ASSERT_TRUE(store->settle(kLong));
  }
  GetParam().act(path);
  EXPECT_EQ(store->finish().has_value(), !GetParam().damages_database);
  store.reset();
  const auto record = read_record(path);
  ASSERT_TRUE(record) << text(record.error());
  EXPECT_EQ(record->slot.size(), static_cast<std::size_t>(kBefore));
  EXPECT_TRUE(record->finished);
  EXPECT_EQ(path_exists(manifest_path(path)), !GetParam().damages_database);
}

INSTANTIATE_TEST_SUITE_P(OnTheDisk, FileAttacks, ::testing::ValuesIn(attacks()),
                         [](const auto& of) { return std::string(of.param.name); });

/// An open descriptor still reads a removed file, so even a long run is complete.
TEST(FileAttack, CopiesLongRecordFromRemovedFile) {
  const Folder folder;
  const auto path = folder / "run.db";
  auto store = Store::create(path, two_thermometers(),
                             {.background = true, .most_rows = 50, .retry = std::chrono::milliseconds(20)})
                   .value();
  const Event event{sample_at(0).at, EventKind::note, "a note"};
  for (std::int64_t slot = 0; slot < 1000; ++slot) {
    auto sample = sample_at(slot);
    if (slot % 11 == 0) sample.thermometers[0].value = failure(FaultKind::timeout, "A", "silent");
    const bool late = slot >= 500 && slot < 510;
    if (!late) {
      ASSERT_TRUE(store->append(sample, std::span(&event, slot % 5 == 0 ? 1 : 0)));
    } else if (slot == 509) {
      ASSERT_TRUE(store->append_gap(500, 509, "late"));
    }
    if (slot % 20 == 19) {
      ASSERT_TRUE(store->settle(kLong));
    }
  }
  const auto kept = folder / "kept.db";
  fs::rename(path, kept);
  ASSERT_TRUE(store->append(sample_at(1000), {}));
  ASSERT_TRUE(store->settle(kLong));
  EXPECT_FALSE(store->finish());
  store.reset();

  const auto record = read_record(part_path(path, 2));
  ASSERT_TRUE(record) << text(record.error());
  EXPECT_EQ(record->slot.size(), 991u);
  ASSERT_EQ(record->gaps.size(), 1u);
  EXPECT_EQ(record->gaps[0].first, 500);
  EXPECT_EQ(record->events.size(), 198u + 1) << "and the event that reports it";
  EXPECT_TRUE(verify_record(part_path(path, 2)));
}

/// After each removal of the name, the next file has all rows, also those of a file that failed before.
TEST(FileAttack, LosesNothingWhenNameIsRemovedTwice) {
  const Folder folder;
  const auto path = folder / "run.db";
  auto store = Store::create(path, two_thermometers(),
                             {.background = true, .most_rows = 50, .retry = std::chrono::milliseconds(20)})
                   .value();
  auto hundred = [&, slot = std::int64_t{0}]() mutable {
    for (const auto end = slot + 100; slot < end; ++slot) {
      ASSERT_TRUE(store->append(sample_at(slot), {}));
      if (slot % 20 == 19) {
        ASSERT_TRUE(store->settle(kLong));
      }
    }
  };
  hundred();
  fs::remove(path + "-wal");  // the checkpointed rows remain
  hundred();
  for (const int part : {2, 3}) {
    fs::remove(part_path(path, part));
    hundred();
  }
  EXPECT_FALSE(store->finish());
  store.reset();
  EXPECT_EQ(last_part(path), 4) << "a number is not reused";
  EXPECT_FALSE(verify_record(path)) << "the fourth continues the third";
  const auto record = read_record(part_path(path, 4));
  ASSERT_TRUE(record) << text(record.error());
  EXPECT_EQ(record->slot.front(), 50) << "the first slot in memory when the log was lost";
  EXPECT_EQ(record->slot.size(), 350u);
}

/// Writes one transaction.
Result<void> second(
    RunFile& file, std::int64_t slot, const std::function<void()>& between = [] {}) {
  const auto entry = sample_entry(sample_at(slot), {}, two_thermometers());
  const auto begun = file.begin();
  between();
  return begun.and_then([&] { return file.insert(entry); })
      .and_then([&] { return file.replace_frames({}); })
      .and_then([&] { return file.commit(); });
}

/// A foreign write during a write of the program leaves the modification time of the latter.
TEST(FileAttack, IsDetectedInLogWhileWriting) {
  for (const std::streamoff at : {0, 40, 3000}) {
    const Folder folder;
    const auto path = folder / "run.db";
    auto file = RunFile::create(path, two_thermometers()).value();
    ASSERT_TRUE(second(file, 0));
    std::this_thread::sleep_for(std::chrono::milliseconds(600));
    EXPECT_FALSE(second(file, 1, [&] { overwrite(path + "-wal", at, 8, 'x'); })) << at;
    ASSERT_TRUE(file.interference()) << at;
    EXPECT_TRUE(file.interference()->is_log_only) << at;
    file.leave_untouched();
  }
}

TEST(FileAttack, IsDetectedInLogBeforeCheckpoint) {
  const Folder folder;
  const auto path = folder / "run.db";
  auto file = RunFile::create(path, two_thermometers()).value();
  Result<void> done;
  for (std::int64_t slot = 0; done && slot < 300; ++slot)
    done = second(file, slot, [&] {
             if (slot == 5) overwrite(path + "-wal", 3000, 8, 'x');
           }).and_then([&] { return file.checkpoint_log(); });
  EXPECT_FALSE(done);
  EXPECT_TRUE(file.interference());
  file.leave_untouched();
}

TEST(FileAttack, IsNotReportedAfterCheckpoint) {
  const Folder folder;
  const auto path = folder / "run.db";
  auto file = RunFile::create(path, two_thermometers()).value();
  for (std::int64_t slot = 0; slot < 300; ++slot) ASSERT_TRUE(second(file, slot));
  EXPECT_GT(fs::file_size(path + "-wal"), 0U);
  ASSERT_TRUE(file.checkpoint_log());
  EXPECT_EQ(fs::file_size(path + "-wal"), 0U)
      << "what is left of it would be read over the newer file, up to where it is damaged";
  EXPECT_TRUE(second(file, 300));
  EXPECT_TRUE(file.finish());
}

TEST(FileAttack, IsDetectedAtEndWhenMadeDuringCheckpoint) {
  constexpr std::int64_t kFew = 3000;
  const Folder folder;
  const auto path = folder / "run.db";
  auto file = RunFile::create(path, two_thermometers()).value();
  std::int64_t slot = 0;
  const auto fill = [&] {
    for (const auto end = slot + kFew; slot < end; ++slot) ASSERT_TRUE(second(file, slot));
  };
  fill();
  ASSERT_TRUE(file.checkpoint_log());
  fill();
  overwrite(path, 70'000, 8, 'x');
  ASSERT_TRUE(file.checkpoint_log());
  EXPECT_FALSE(file.finish());
  ASSERT_TRUE(file.interference());
  EXPECT_FALSE(file.interference()->is_log_only);
}

TEST(FileAttack, IgnoresTouchedFile) {
  const Folder folder;
  const auto path = folder / "run.db";
  auto store = Store::create(path, two_thermometers(), {.background = true}).value();
  auto second = [&, slot = std::int64_t{0}]() mutable {
    ASSERT_TRUE(store->append(sample_at(slot++), {}));
    ASSERT_TRUE(store->settle(kLong));
  };
  for (int i = 0; i < 2000; ++i) {
    if (i % 50 == 49) fs::last_write_time(path, fs::file_time_type::clock::now());
    second();
  }
  fs::permissions(path, fs::perms::none);
  second();
  fs::permissions(path, fs::perms::owner_read | fs::perms::owner_write);
  fs::create_hard_link(path, folder / "another-name");
  second();
  EXPECT_EQ(store->health().parts, 1);
  EXPECT_EQ(store->health().damage, "");
  EXPECT_TRUE(store->finish());
  store.reset();
  EXPECT_EQ(read_record(path).value().slot.size(), 2002u);
  EXPECT_TRUE(verify_record(path));
}

TEST(FileAttack, AcceptsMovedFolder) {
  const Folder folder;
  fs::create_directory(folder / "here");
  auto store = Store::create(folder / "here/run.db", two_thermometers(), {.background = true}).value();
  ASSERT_TRUE(store->append(sample_at(0), {}));
  ASSERT_TRUE(store->settle(kLong));
  fs::rename(folder / "here", folder / "there");
  ASSERT_TRUE(store->append(sample_at(1), {}));
  ASSERT_TRUE(store->settle(kLong));
  EXPECT_EQ(store->health().parts, 1);
  fs::rename(folder / "there", folder / "here");
  ASSERT_TRUE(store->append(sample_at(2), {}));
  EXPECT_TRUE(store->finish());
  store.reset();
  EXPECT_EQ(read_record(folder / "here/run.db").value().slot.size(), 3u);
}

}  // namespace
}  // namespace gyrotherm::record
