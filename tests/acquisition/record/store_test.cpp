#include "acquisition/record/store.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "acquisition/record/status.hpp"
#include "tests/acquisition/record/runs.hpp"

namespace gyrotherm {
namespace {

TEST(Store, NeverOverwritesAFile) {
  const Folder folder;
  std::ofstream(folder / "run.db") << "precious";
  const auto store = Store::create(folder / "run.db", two_thermometers());
  ASSERT_FALSE(store);
  EXPECT_EQ(store.error().kind, FaultKind::storage);
  EXPECT_EQ(std::filesystem::file_size(folder / "run.db"), 8u);
}

TEST(Store, RefusesSlotsThatDoNotIncrease) {
  const Folder folder;
  const auto store = store_with(folder / "run.db", 3);
  for (const std::int64_t slot : {2, 0}) {
    const auto again = store->append(sample_at(slot), {});
    ASSERT_FALSE(again);
    EXPECT_EQ(again.error().kind, FaultKind::storage);
  }
  EXPECT_TRUE(store->append(sample_at(3), {})) << "a refused sample spoils nothing";
}

TEST(Store, RefusesSlotsThatHaveNeitherASampleNorAGap) {
  const Folder folder;
  const auto store = store_with(folder / "run.db", 3);
  const auto jump = store->append(sample_at(5), {});
  ASSERT_FALSE(jump);
  EXPECT_EQ(text(jump.error()), "slot 5: slots 3 to 4 have neither a sample nor a gap");
  EXPECT_FALSE(store->append_gap(2, 4, "overlaps"));
  EXPECT_TRUE(store->append_gap(3, 4, "late"));
  EXPECT_TRUE(store->append(sample_at(5), {}));
  EXPECT_EQ(store->sync().value(), 5);
}

TEST(Store, AcknowledgesNothingBeforeASync) {
  const Folder folder;
  auto store = store_with(folder / "run.db", 2);
  ASSERT_TRUE(store->append(sample_at(2), {}));
  store.reset();
  EXPECT_EQ(read_record(folder / "run.db").value().slot.back(), 1);
}

TEST(Store, SyncWithoutASampleAcknowledgesMinusOne) {
  const Folder folder;
  const auto store = store_with(folder / "run.db", 0);
  EXPECT_EQ(store->sync().value(), -1);
}

TEST(Store, IsOneFileOfItsOwnWhenFinished) {
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

TEST(Store, TakesNothingAfterItsEnd) {
  const Folder folder;
  const auto store = store_with(folder / "run.db", 1);
  ASSERT_TRUE(store->finish());
  EXPECT_FALSE(store->append(sample_at(1), {}));
  EXPECT_FALSE(store->sync());
}

TEST(Store, GoesOnWithAnUnfinishedRun) {
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

TEST(Store, RefusesToGoOnWithAFinishedRun) {
  const Folder folder;
  auto store = store_with(folder / "run.db", 1);
  ASSERT_TRUE(store->finish());
  store.reset();
  const auto again = Store::reopen(folder / "run.db");
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().kind, FaultKind::bad_file);
}

TEST(Store, RefusesWhatIsNoRecordAndLeavesItAlone) {
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

TEST(Store, StopsAcknowledgingWhenItsLogIsStolen) {
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

TEST(Store, IsNotDeceivedByAnotherLogUnderTheSameName) {
  const Folder folder;
  const auto store = store_with(folder / "run.db", 5);
  std::filesystem::rename(folder / "run.db-wal", folder / "stolen");
  std::filesystem::copy_file(folder / "stolen", folder / "run.db-wal");
  EXPECT_FALSE(store->append(sample_at(5), {}));
  EXPECT_FALSE(store->sync());
}

TEST(Store, RefusesNamesThatCannotBeColumns) {
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

TEST(Store, InMemoryGivesBackWhatWasAppended) {
  auto store = store_with(kInMemory, 5);
  ASSERT_TRUE(store->append(sample_at(5), {}));
  const auto record = store->read_back();
  ASSERT_TRUE(record) << text(record.error());
  EXPECT_EQ(record->slot.size(), 6u);
  ASSERT_TRUE(store->finish());
  EXPECT_FALSE(std::filesystem::exists(kInMemory));
  EXPECT_FALSE(std::filesystem::exists(status_path(kInMemory)));
}

TEST(Store, LeavesAFileWhoseLogWasStolenAsItIs) {
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
}  // namespace gyrotherm
