// SPDX-License-Identifier: Apache-2.0
/// Tests which files belong to a record, with other files next to it and with files missing.
#include "acquisition/record/record_files.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "acquisition/record/chain.hpp"
#include "acquisition/record/live_copy.hpp"
#include "acquisition/record/run_file.hpp"
#include "acquisition/record/status.hpp"
#include "core/file.hpp"
#include "tests/acquisition/record/runs.hpp"

namespace gyrotherm::record {
namespace {

namespace fs = std::filesystem;

constexpr StoreOptions kInBackground{.background = true, .retry = std::chrono::milliseconds(20)};

template <class T>
std::string fault_text(const Result<T>& result) {
  return result ? "" : text(result.error());
}

/// Writes the file `part` as the continuation of file `before`, with the slots from `from` to `end` − 1.
void add_part(const std::string& record, int part, int before, std::int64_t from, std::int64_t end,
              const RunInfo& info = two_thermometers()) {
  const Continuation continuation{.part = part,
                                  .before = fs::path(part_path(record, before)).filename().string(),
                                  .from = from,
                                  .cause = "an I/O error"};
  auto file = RunFile::create(part_path(record, part), info, continuation).value();
  auto done = file.begin().and_then([&] {
    return file.insert_event(from - 1, {sample_at(from).at, EventKind::fault, "the record goes on"});
  });
  for (auto slot = from; done && slot < end; ++slot) {
    auto sample = sample_at(slot);
    sample.thermometers.resize(info.thermometers.size(), sample.thermometers[0]);
    sample.units.resize(info.units.size(), sample.units[0]);
    done = file.insert(sample_entry(sample, {}, info));
  }
  done = done.and_then([&] { return file.replace_frames({}); }).and_then([&] { return file.commit(); });
  ASSERT_EQ(fault_text(done), "");
}

/// Writes three files with ten seconds each.
void make_three_files(const std::string& path) {
  store_with(path, 10).reset();
  add_part(path, 2, 1, 10, 20);
  add_part(path, 3, 2, 20, 30);
}

TEST(RecordFilesInFolder, NamesRampRunAsThisVersionDoesUnlessOnlyFormerNameExists) {
  const Folder in;
  const std::string folder = in / "";
  EXPECT_EQ(ramp_record_path(folder), folder + "/ramp.db") << "neither exists";
  std::ofstream(folder + "/rate.db") << "0.1.0";
  EXPECT_EQ(ramp_record_path(folder), folder + "/rate.db");
  std::ofstream(folder + "/ramp.db") << "this version";
  EXPECT_EQ(ramp_record_path(folder), folder + "/ramp.db");
}

TEST(RunParts, AreDetectedByName) {
  EXPECT_EQ(part_path("/a/run.db", 2), "/a/run.2.db");
  for (const auto& [path, record] : {std::pair("/a/run.12.db", "/a/run.db"), std::pair("run.12.db", "run.db"),
                                     std::pair("run.12", "run"), std::pair("run.2.12.db", "run.2.db")}) {
    const auto name = part_name(path);
    ASSERT_TRUE(name) << path;
    EXPECT_EQ(name->record, record);
    EXPECT_EQ(name->part, 12);
  }
  for (const char* path : {"run.db", "run.1.db", "run.0.db", "run.02.db", "run.-2.db", "run.2x.db", "run..db",
                           "run.db.2", "run.live.db.7", "run.20261127.db", "run.2.db/", ""})
    EXPECT_FALSE(part_name(path)) << path;
}

/// A missing part must be a fault: a record with a hole would otherwise be read as complete, and a resumed run would
/// continue before the hole.
TEST(RunParts, ReportMissingOrDestroyedMiddlePart) {
  for (const bool destroyed : {false, true}) {
    const Folder folder;
    const auto path = folder / "run.db", second = part_path(path, 2), third = part_path(path, 3);
    make_three_files(path);
    ASSERT_EQ(fault_text(verify_record(path)), "");
    fs::remove(second);
    if (destroyed) std::ofstream(second) << std::string(4096, 'x');

    const auto record = read_record(path).value();
    EXPECT_EQ(record.slot.size(), 20u);
    EXPECT_EQ(record.slot.back(), 29);
    ASSERT_EQ(record.gaps.size(), 1u);
    EXPECT_EQ(record.gaps[0].first, 10);
    EXPECT_EQ(record.gaps[0].last, 19);
    EXPECT_EQ(record.gaps[0].cause, "lost with run.2.db: an I/O error");

    const std::string why = destroyed ? "not a gyrotherm record" : "no such file, expected a part of the record";
    const auto told = fault_text(verify_record(path));
    EXPECT_NE(told.find("run.2.db: " + why), std::string::npos) << told;
    EXPECT_NE(told.find("; the run continues in " + third), std::string::npos) << told;
    EXPECT_NE(read_status(path).value().record_damage.find("run.2.db: " + why), std::string::npos);

    auto store = Store::reopen(path).value();
    ASSERT_TRUE(store->append(sample_at(30), {})) << "the run continues where it ended";
    EXPECT_NE(fault_text(store->finish()).find("run.2.db: " + why), std::string::npos);
    store.reset();
    EXPECT_FALSE(path_exists(manifest_path(path)));
    EXPECT_EQ(last_part(path), 3);
    EXPECT_EQ(read_record(path).value().slot.back(), 30);
  }
}

TEST(RunParts, AreRefusedWithOtherChannelsThanBefore) {
  auto fewer = two_thermometers(), more = fewer, renamed = fewer, humid = fewer, unit = fewer, value = fewer;
  fewer.thermometers.pop_back();
  fewer.units[0].gradients = fewer.units[0].three_point = {};
  more.thermometers.push_back({"C", "another", Kelvins{0}});
  renamed.thermometers[0].name = "D";
  renamed.units[0].gradients = renamed.units[0].three_point = {};
  humid.has_humidity = true;
  unit.units.push_back(unit.units[0]);
  unit.units[0].name = "u1";
  unit.units[1].name = "u2";
  value.units[0].values = {{.name = "die", .unit = "°C"}};
  int cases = 0;
  for (const auto* other : {&fewer, &more, &renamed, &humid, &unit, &value}) {
    const Folder folder;
    const auto path = folder / "run.db";
    store_with(path, 10).reset();
    add_part(path, 2, 1, 10, 20, *other);
    const auto record = read_record(path);
    ASSERT_FALSE(record) << cases;
    EXPECT_EQ(record.error().kind, FaultKind::bad_file);
    EXPECT_EQ(record.error().where, part_path(path, 2));
    EXPECT_EQ(record.error().what, "has other channels than the parts before it");
    EXPECT_FALSE(read_verified_record(find_record_files(path).value())) << cases;
    ++cases;
  }
  EXPECT_EQ(cases, 6);
}

TEST(RunParts, NumberNewPartAfterAllOthers) {
  const Folder folder;
  const auto path = folder / "run.db";
  store_with(path, 10).reset();
  add_part(path, 3, 2, 10, 20);  // its predecessor was removed
  auto store = Store::reopen(path, kInBackground).value();
  ASSERT_TRUE(store->append(sample_at(20), {}));
  ASSERT_TRUE(store->settle(kLong));
  fs::remove(part_path(path, 3) + "-wal");
  ASSERT_TRUE(store->append(sample_at(21), {}));
  ASSERT_TRUE(store->settle(kLong));
  store.reset();
  EXPECT_FALSE(path_exists(part_path(path, 2)));
  EXPECT_EQ(last_part(path), 4);
  const auto record = read_record(path).value();
  EXPECT_EQ(record.slot.size(), 22u);
  EXPECT_EQ(record.slot.back(), 21);
}

TEST(RunParts, SkipNumbersOfLinksAndStatusFiles) {
  const Folder folder;
  const auto path = folder / "run.db";
  EXPECT_EQ(next_part(path, 1), 2);
  fs::create_symlink("nowhere", part_path(path, 2));
  std::ofstream(status_path(part_path(path, 3))) << "{}";
  EXPECT_EQ(next_part(path, 1), 4);
  EXPECT_EQ(next_part(path, 6), 7);
}

/// An earlier version gave the number of a removed second file to the file after the third one.
TEST(RunParts, AreInOrderOfRunWhenNumberWasReused) {
  const Folder folder;
  const auto path = folder / "run.db";
  store_with(path, 10).reset();
  add_part(path, 3, 2, 10, 20);
  add_part(path, 2, 3, 20, 30);
  const auto record = read_record(path).value();
  EXPECT_EQ(record.slot.size(), 30u);
  EXPECT_TRUE(record.gaps.empty());
  EXPECT_EQ(last_part(path), 2);
  EXPECT_EQ(fault_text(verify_record(path)), "") << "the third file has all rows of the former second one";
}

TEST(RunParts, DoNotMissPartWhoseRowsWereCopied) {
  const Folder folder;
  const auto path = folder / "run.db";
  store_with(path, 10).reset();
  add_part(path, 2, 1, 10, 15);
  add_part(path, 3, 2, 10, 20);
  for (const bool destroyed : {false, true}) {
    fs::remove(part_path(path, 2));
    if (destroyed) std::ofstream(part_path(path, 2)).close();
    EXPECT_EQ(fault_text(verify_record(path)), "");
    EXPECT_EQ(read_record(path).value().slot.size(), 20u);
  }
}

/// The part is empty because the failing disk prevented its removal.
TEST(RunParts, DoNotMissEmptyPartWithoutSuccessor) {
  const Folder folder;
  const auto path = folder / "run.db";
  store_with(path, 10).reset();
  add_part(path, 2, 1, 5, 8);
  add_part(path, 3, 1, 8, 20);
  EXPECT_EQ(fault_text(verify_record(path)), "");
  EXPECT_EQ(read_record(path).value().slot.size(), 20u);
}

TEST(RunParts, AreFoundAfterAllWereRenamed) {
  const Folder folder;
  const auto old = folder / "run.db", path = folder / "kept.db";
  make_three_files(old);
  for (int part = 1; part <= 3; ++part) fs::rename(part_path(old, part), part_path(path, part));
  EXPECT_EQ(fault_text(verify_record(path)), "");
  EXPECT_EQ(read_record(path).value().slot.size(), 30u);
  fs::remove(part_path(path, 2));
  EXPECT_NE(fault_text(verify_record(path)).find("kept.2.db: no such file"), std::string::npos);
}

TEST(RunParts, ExcludeRecordOfOtherRunWithPartName) {
  const Folder folder;
  const auto path = folder / "run.db";
  store_with(path, 10).reset();
  RunInfo other = two_thermometers();
  other.id[0] = 'f';
  const auto theirs = Store::create(part_path(path, 2), other).value();
  EXPECT_EQ(fault_text(verify_record(path)), "");
  EXPECT_EQ(read_record(path).value().slot.size(), 10u);
  EXPECT_FALSE(read_status(path).value().being_written);

  auto store = Store::reopen(path, kInBackground).value();
  ASSERT_TRUE(store->append(sample_at(10), {}));
  ASSERT_TRUE(store->settle(kLong));
  fs::remove(path + "-wal");
  ASSERT_TRUE(store->append(sample_at(11), {}));
  ASSERT_EQ(fault_text(store->finish()), "");
  store.reset();
  const auto told = parse_status(read_text_file(status_path(path)).value(), "status").value();
  EXPECT_EQ(told.parts, std::vector<std::string>{part_path(path, 3)});
  EXPECT_EQ(fault_text(verify_record(path)), "");
  const auto manifest = check_manifest(path).value().value();
  EXPECT_TRUE(manifest.contains("run.db") && manifest.contains("run.3.db"));
  EXPECT_FALSE(manifest.contains("run.2.db"));
}

TEST(RunParts, AreInStatusFileOfResumedRun) {
  const Folder folder;
  const auto path = folder / "run.db";
  make_three_files(path);
  const auto store = Store::reopen(path, kInBackground).value();
  ASSERT_TRUE(store->settle(kLong));
  EXPECT_EQ(store->health().parts, 3);
  const auto told = parse_status(read_text_file(status_path(path)).value(), "status").value();
  EXPECT_EQ(told.parts, (std::vector<std::string>{part_path(path, 2), part_path(path, 3)}));
}

/// Its writer died immediately after it was begun.
TEST(RunParts, ContinuePreviousPartWhenLastHasNoSample) {
  const Folder folder;
  const auto path = folder / "run.db";
  // The status file of the first part acknowledges second 9.
  store_with(path, 10).reset();
  add_part(path, 2, 1, 10, 10);
  EXPECT_EQ(fault_text(verify_record(path)), "");
  const auto status = read_status(path).value();
  EXPECT_EQ(status.acknowledged, 9);
  EXPECT_EQ(status.slot, 9);
  EXPECT_EQ(status.segment, "hold");
  EXPECT_EQ(status.chamber_air, sample_at(9).chamber.value->air);
  auto store = Store::reopen(path).value();
  ASSERT_EQ(fault_text(store->append(sample_at(10), {})), "");
  ASSERT_EQ(fault_text(store->finish()), "");
  store.reset();
  EXPECT_EQ(read_record(path).value().slot.size(), 11u);
}

TEST(RunParts, ExcludePartWithImpossibleFirstSlot) {
  for (const char* from : {"-1", "9223372036854775807"}) {
    const Folder folder;
    const auto path = folder / "run.db";
    store_with(path, 10).reset();
    add_part(path, 2, 1, 10, 20);
    {
      auto database = Database::open(part_path(path, 2), Access::read_write, 0).value();
      ASSERT_TRUE(database.execute(std::string("UPDATE meta SET value = ") + from + " WHERE key = 'continues_from'"));
    }
    EXPECT_EQ(last_part(path), 1) << from;
    EXPECT_EQ(read_record(path).value().slot.size(), 10u) << from;
  }
}

TEST(RunParts, ReserveNamesAgainstNewRecords) {
  const Folder folder;
  const auto path = folder / "run.db";
  EXPECT_EQ(fault_text(check_name_of_new_record(path)), "");
  store_with(path, 10).reset();
  EXPECT_NE(fault_text(check_name_of_new_record(path)).find("exists already"), std::string::npos);
  EXPECT_NE(fault_text(check_name_of_new_record(part_path(path, 2))).find("is the name of a continuation file"),
            std::string::npos);
  for (const char* name : {"run.20261127.db", "another.2.db"})
    EXPECT_EQ(fault_text(check_name_of_new_record(folder / name)), "") << name;
  add_part(path, 2, 1, 10, 20);
  fs::remove(path);
  const auto refused = fault_text(check_name_of_new_record(path));
  EXPECT_NE(refused.find("its run continues in " + part_path(path, 2)), std::string::npos) << refused;
  fs::remove(part_path(path, 2));
  EXPECT_NE(fault_text(check_name_of_new_record(path)).find("without run.db.status"), std::string::npos)
      << "the status file of an unfinished run remains";
  fs::remove(status_path(path));
  EXPECT_EQ(fault_text(check_name_of_new_record(path)), "");
  const auto fresh = folder / "fresh.db";
  for (const char* ending : {".status", ".sha256", ".socket", ".safe-state", ".made-safe", "-wal", "-shm", "-journal"})
    EXPECT_NE(fault_text(check_name_of_new_record(fresh + ending)).find(std::string("end with ") + ending),
              std::string::npos)
        << ending;
  EXPECT_NE(fault_text(check_name_of_new_record(live_copy_path(fresh))).find("end with .live.db"), std::string::npos);
  for (const char* name : {"status", "run-wal.db", "live.db", "sha256.db"})
    EXPECT_EQ(fault_text(check_name_of_new_record(folder / name)), "") << name;
}

TEST(RunParts, ReserveNameForFilesThatMovedRecordLeftBehind) {
  const Folder folder;
  const auto path = folder / "run.db";
  for (const std::string ending : {"-wal", ".safe-state", ".status"}) {
    std::ofstream(path + ending) << "left";
    const auto refused = check_name_of_new_record(path);
    ASSERT_FALSE(refused) << ending;
    EXPECT_EQ(refused.error().kind, FaultKind::storage);
    EXPECT_NE(refused.error().what.find("without run.db" + ending + ","), std::string::npos) << refused.error().what;
    fs::remove(path + ending);
    EXPECT_EQ(fault_text(check_name_of_new_record(path)), "") << ending;
  }
  std::ofstream(path + "-wal") << "left";
  std::ofstream(path + ".safe-state") << "left";
  EXPECT_NE(fault_text(check_name_of_new_record(path)).find("run.db-wal and run.db.safe-state"), std::string::npos);
}

TEST(RunParts, AllowNameOfRemovedFinishedRecord) {
  const Folder folder;
  const auto path = folder / "run.db";
  auto store = store_with(path, 3);
  ASSERT_TRUE(store->finish());
  store.reset();
  fs::remove(path);
  ASSERT_TRUE(fs::exists(status_path(path)));
  EXPECT_EQ(fault_text(check_name_of_new_record(path)), "");
  RunStatus waiting;  // a program was killed while it waited for serial numbers
  waiting.path = path;
  waiting.being_written = true;
  ASSERT_TRUE(write_status(waiting));
  EXPECT_EQ(fault_text(check_name_of_new_record(path)), "");
}

TEST(RunParts, RefuseNamesOfOtherKindsOfFiles) {
  const Folder folder;
  for (const char* name : {"run.csv", "run.json", "run.2.toml", "a.b.nc", "run.db.xlsx"}) {
    const auto checked = check_name_of_new_record(folder / name);
    ASSERT_FALSE(checked) << name;
    EXPECT_EQ(checked.error().kind, FaultKind::usage) << name;
    EXPECT_NE(checked.error().what.find("ends in .db"), std::string::npos) << checked.error().what;
  }
  for (const char* name : {"run", "csv", "run.sqlite", "run.csv.db", "2026.11.30"})
    EXPECT_EQ(fault_text(check_name_of_new_record(folder / name)), "") << name;
  std::ofstream(folder / "there.csv") << "0,1\n";
  EXPECT_NE(fault_text(check_name_of_new_record(folder / "there.csv")).find("exists already and is not a record"),
            std::string::npos);
  EXPECT_NE(fault_text(check_name_of_new_record(folder / "run.db/")).find("is a folder"), std::string::npos);
}

TEST(RunFinder, HidesPartsButNotRecordsWithSimilarNames) {
  const Folder folder;
  for (const char* name : {"soak.db", "soak.2.db", "soak.3.db", "soak.3.db.status", "soak.20261127.db", "soak.live.db",
                           "gone.2.db", "told.db.status", "told.2.db"})
    std::ofstream(folder / name) << "";
  EXPECT_EQ(list_records(folder / "."),
            (std::set<std::string>{folder / "./soak.db", folder / "./soak.3.db", folder / "./soak.20261127.db",
                                   folder / "./gone.2.db", folder / "./told.db"}));
}

}  // namespace
}  // namespace gyrotherm::record
