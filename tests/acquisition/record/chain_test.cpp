// SPDX-License-Identifier: Apache-2.0
/// Tests that an edit of a record is detected.
#include "acquisition/record/chain.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <random>

#include "acquisition/record/run_file.hpp"
#include "tests/acquisition/record/runs.hpp"

namespace gyrotherm::record {
namespace {

TEST(Sha256, MatchesDigestsOfStandard) {
  const auto of = [](std::string_view bytes) {
    Sha256 hash;
    hash.add(bytes);
    return hex(hash.digest());
  };
  EXPECT_EQ(of(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(of("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(of("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(
      of("abcdefghbcdefghicdefghijdefghijkefghijklfghijklmghijklmnhijklmnoijklmnopjklmnopqklmnopqrlmnopqrsmnopqrst"
         "nopqrstu"),
      "cf5b16a778af8380036ce59e7b0492370b249b11e8f07a51afac45037afee9d1");
  EXPECT_EQ(of(std::string(1'000'000, 'a')), "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Sha256, DoesNotDependOnPieces) {
  std::mt19937 random(4);
  const std::string bytes(1000, 'q');
  Sha256 whole;
  whole.add(bytes);
  const auto expected = whole.digest();
  for (int i = 0; i < 100; ++i) {
    Sha256 pieces;
    for (std::size_t at = 0; at < bytes.size();) {
      const auto size = std::min<std::size_t>(random() % 130, bytes.size() - at);
      pieces.add(std::string_view(bytes).substr(at, size));
      at += size;
    }
    EXPECT_EQ(pieces.digest(), expected);
  }
}

/// Makes a finished run with every kind of row: 30 samples, a gap, missing readings, events.
void make_run(const std::string& path, bool finished = true) {
  auto store = Store::create(path, two_thermometers()).value();
  const Event event{sample_at(0).at, EventKind::note, "a note"};
  ASSERT_TRUE(store->append_event(event));
  for (int slot = 0; slot < 35; ++slot) {
    if (slot == 10) {
      ASSERT_TRUE(store->append_gap(10, 14, "late"));
    }
    if (slot >= 10 && slot < 15) continue;
    Sample sample = sample_at(slot);
    if (slot % 10 == 3) sample.thermometers[1].value = failure(FaultKind::timeout, "shell", "silent");
    if (slot == 20) sample.units[0].count.value = failure(FaultKind::timeout, "gyro", "silent");
    ASSERT_TRUE(store->append(sample, std::span(&event, slot % 7 == 0 ? 1 : 0)));
    if (slot % 4 == 0) {
      ASSERT_TRUE(store->append_event(event));
    }
    ASSERT_TRUE(store->sync());
  }
  if (finished) {
    ASSERT_TRUE(store->finish());
  }
}

TEST(Chain, MatchesUnchangedRecord) {
  const Folder folder;
  make_run(folder / "run.db");
  const auto verified = verify_record(folder / "run.db");
  ASSERT_TRUE(verified) << text(verified.error());
  EXPECT_EQ(verified->rows, 30 + 1 + 4 + 5 + 8);
  EXPECT_TRUE(verified->finished && verified->manifest);
}

TEST(Chain, ContinuesWhenRunIsResumed) {
  const Folder folder;
  make_run(folder / "run.db", false);
  ASSERT_TRUE(verify_record(folder / "run.db"));
  auto store = Store::reopen(folder / "run.db").value();
  ASSERT_TRUE(store->append_gap(35, 39, "power cut"));
  ASSERT_TRUE(store->append(sample_at(40), {}));
  ASSERT_TRUE(store->finish());
  const auto verified = verify_record(folder / "run.db");
  ASSERT_TRUE(verified) << text(verified.error());
}

TEST(Chain, DoesNotDependOnBatches) {
  const auto info = two_thermometers();
  std::vector<SampleRow> rows;
  for (int slot = 0; slot < 100; ++slot) {
    Sample sample = sample_at(slot);
    if (slot < 50) sample.units[0].count.value = failure(FaultKind::timeout, "gyro", "silent");
    if (slot % 10 == 3) sample.thermometers[1].value = failure(FaultKind::timeout, "shell", "silent");
    rows.push_back(*sample_entry(sample, {}, info).sample);
  }
  const Folder folder;
  const auto write = [&](const char* name, const auto& insert) {
    auto file = RunFile::create_at_once(folder / name, info).value();
    EXPECT_TRUE(file.begin());
    insert(file);
    EXPECT_TRUE(file.replace_frames({}));
    EXPECT_TRUE(file.commit());
    EXPECT_TRUE(file.finish());
  };
  write("one.db", [&](RunFile& file) {
    for (const SampleRow& row : rows) EXPECT_TRUE(file.insert(row));
  });
  write("many.db", [&](RunFile& file) {
    ChainedSamples first, second;
    file.chain(std::span(rows).first(43), first);
    file.chain(std::span(rows).subspan(43), second);
    EXPECT_TRUE(file.write(first));
    EXPECT_TRUE(file.write(second));
  });
  EXPECT_EQ(verify_record(folder / "many.db").value().rows, 100);
  const auto table = [&](const char* name) {
    auto database = open_record(folder / name).value();
    std::vector<std::string> cells;
    EXPECT_TRUE(database.each_row("SELECT * FROM sample ORDER BY slot", [&](const Statement& row) {
      for (int column = 0; column < row.columns(); ++column) cells.emplace_back(row.text(column));
    }));
    return cells;
  };
  EXPECT_EQ(table("one.db"), table("many.db"));
}

/// The column of pulses stores whole numbers as integers, up to the largest SQLite integer.
TEST(Chain, HoldsLargestNumbersOfGyro) {
  const auto info = two_thermometers();
  const Folder folder;
  {
    auto file = RunFile::create_at_once(folder / "run.db", info).value();
    EXPECT_TRUE(file.begin());
    auto row = *sample_entry(sample_at(0), {}, info).sample;
    for (const double pulses : {9.2e18, 9.21e18, 0x1p63, -0x1p63, 1e300, -0.0}) {
      row.units[0].rotation[0] = pulses;
      EXPECT_TRUE(file.insert(row));
      ++row.slot;
    }
    EXPECT_TRUE(file.replace_frames({}));
    EXPECT_TRUE(file.commit());
    EXPECT_TRUE(file.finish());
  }
  const auto verified = verify_record(folder / "run.db");
  EXPECT_TRUE(verified) << text(verified.error());
}

TEST(Chain, DetectsEachEditAndNamesFirstRow) {
  const Folder folder;
  make_run(folder / "run.db");
  std::filesystem::remove(manifest_path(folder / "run.db"));
  const std::vector<std::pair<const char*, const char*>> edits{
      {"UPDATE sample SET A = A + 1e-9 WHERE slot = 7", "sample 7 of second 7"},
      {"UPDATE sample SET pulses = NULL WHERE slot = 7", "sample 7 of second 7"},
      {"UPDATE sample SET phase = 'overdue' WHERE slot = 34", "sample 34 of second 34"},
      {"UPDATE sample SET state = 'held' WHERE slot = 0", "sample 0 of second 0"},
      {"DELETE FROM sample WHERE slot = 8", "event 6 of second 8"},
      {"UPDATE sample SET slot = 1000 WHERE slot = 9", "gap 10 of second 14"},
      {"INSERT INTO sample SELECT 35, monotonic_ns, utc_ns, set_point_c, chamber_air_c, chamber_set_point_c, A, "
       "\"shell-1.b\", pulses, interval_ns, segment, cycle, phase, in_segment_ns, soaked_ns, state, "
       "true_bias_deg_per_h, chain FROM sample "
       "WHERE slot = 34",
       "sample 35 of second 35"},
      {"DELETE FROM sample WHERE slot = 34", "the end of the record"},
      {"UPDATE gap SET cause = 'lunch'", "gap 10 of second 14"},
      {"UPDATE fault SET what = 'loud' WHERE slot = 20", "fault 2 of second 20"},
      {"UPDATE event SET text = 'another' WHERE id = 1", "event 1 of second -1"},
      {"UPDATE event SET utc_ns = utc_ns + 1 WHERE id = 13", "event 13"},
      {"UPDATE sample SET chain = chain + 1 WHERE slot = 3", "sample 3 of second 3"},
      {"UPDATE meta SET value = 'b' WHERE key = 'rig_text'", "the description of the run"},
      {"UPDATE channel SET offset_k = 0 WHERE name = 'A'", "the description of the run"},
      {"UPDATE segment SET rate_c_per_min = 6 WHERE position = 0", "the description of the run"},
      {"DELETE FROM list WHERE name = 'cycles'", "the description of the run"},
      {"DELETE FROM meta WHERE key = 'outcome'", "the outcome of the run"},
      {"UPDATE frames SET lost = 1", "the outcome of the run"},
      {"INSERT INTO frames SELECT 2, seen, lost, bad, head FROM frames", "the frame count"}};
  for (const auto& [edit, place] : edits) {
    const auto path = folder / "edited.db";
    std::filesystem::copy_file(folder / "run.db", path, std::filesystem::copy_options::overwrite_existing);
    {
      auto database = Database::open(path, Access::read_write, 0).value();
      ASSERT_TRUE(database.execute(edit)) << edit;
    }
    const auto verified = verify_record(path);
    ASSERT_FALSE(verified) << edit;
    EXPECT_EQ(verified.error().kind, FaultKind::bad_file);
    EXPECT_NE(verified.error().what.find(place), std::string::npos) << edit << ": " << verified.error().what;
  }
}

TEST(Chain, PreventsResumeWhenBroken) {
  const Folder folder;
  make_run(folder / "run.db", false);
  {
    auto database = Database::open(folder / "run.db", Access::read_write, 0).value();
    ASSERT_TRUE(database.execute("UPDATE sample SET A = 0 WHERE slot = 2"));
  }
  const auto store = Store::reopen(folder / "run.db");
  ASSERT_FALSE(store);
  EXPECT_NE(store.error().what.find("sample 2 of second 2"), std::string::npos) << store.error().what;
}

TEST(Chain, IsVerifiedBeforeManifest) {
  const Folder folder;
  make_run(folder / "run.db");
  {
    auto database = Database::open(folder / "run.db", Access::read_write, 0).value();
    ASSERT_TRUE(database.execute("UPDATE sample SET A = 0 WHERE slot = 2"));
  }
  EXPECT_NE(verify_record(folder / "run.db").error().what.find("sample 2 of second 2"), std::string::npos);
}

/// The rows are chained again, in a file that the manifest does not list.
TEST(Manifest, ListsAllFilesOfRecord) {
  const Folder folder;
  const auto path = folder / "run.db";
  make_run(path);
  ASSERT_TRUE(verify_record(path));
  std::ofstream(folder / "run.db-wal") << "frames";
  EXPECT_EQ(text(check_manifest(path).error()), (folder / "run.db-wal") + ": did not exist when the run was closed");
  std::filesystem::remove(folder / "run.db-wal");
  {
    auto part = RunFile::create(folder / "run.2.db", two_thermometers(),
                                Continuation{.part = 2, .before = "run.db", .from = 35, .cause = "forged"})
                    .value();
    ASSERT_TRUE(part.begin() && part.insert_event(35, {{}, EventKind::note, "forged"}) && part.replace_frames({}) &&
                part.commit() && part.finish());
  }
  ASSERT_EQ(read_record(path)->events.back().event.text, "forged");
  EXPECT_EQ(text(verify_record(path).error()), (folder / "run.2.db") + ": did not exist when the run was closed");
}

/// Texts of instruments and operators are stored so that any program can read them.
TEST(Chain, HoldsTextsInUtf8WithoutControlCharacters) {
  const Folder folder;
  const auto path = folder / "run.db";
  {
    auto store = Store::create(path, two_thermometers()).value();
    ASSERT_TRUE(store->append_event({sample_at(0).at, EventKind::note,
                                     "20 \xB0"
                                     "C \x1b[2J"}));
    Sample sample = sample_at(0);
    sample.units[0].count.value = failure(FaultKind::corrupted, "gyro \x07", "said \"\xff\"");
    ASSERT_TRUE(store->append(sample, {}));
    ASSERT_TRUE(store->append_gap(1, 2, "late\n"));
    ASSERT_TRUE(store->finish());
  }
  EXPECT_TRUE(verify_record(path));
  EXPECT_EQ(read_record(path)->events[0].event.text, "20 \\xb0C \\x1b[2J");
  EXPECT_EQ(read_record(path)->gaps[0].cause, "late\\x0a");
  auto database = Database::open(path, Access::read_only, 0).value();
  EXPECT_EQ(database.query_text("SELECT \"where\" || ': ' || what FROM fault").value(), "gyro \\x07: said \"\\xff\"");
}

TEST(Manifest, IsAcceptedBySha256sum) {
  const Folder folder;
  make_run(folder / "run.db");
  EXPECT_EQ(std::system(("cd '" + (folder / "") + "' && sha256sum -c --quiet run.db.sha256").c_str()), 0);
}

TEST(Manifest, NamesOtherRecordInSameFolder) {
  const Folder folder;
  make_run(folder / "run.db");
  std::filesystem::copy_file(folder / "run.db", folder / "other.db");
  std::filesystem::copy_file(folder / "run.db.sha256", folder / "other.db.sha256");
  EXPECT_TRUE(check_manifest(folder / "other.db")) << "a copy under another name";
  std::ofstream(folder / "other.db", std::ios::app) << "x";
  EXPECT_EQ(text(check_manifest(folder / "other.db").error()),
            folder / "other.db.sha256" + ": is the manifest of run.db, which is in the same folder");
}

TEST(Manifest, MatchesRenamedRecord) {
  const Folder folder;
  const auto old = folder / "run.db", path = folder / "kept.db";
  auto store = Store::create(old, two_thermometers(), {.background = true}).value();
  for (int slot = 0; slot < 10; ++slot) {
    ASSERT_TRUE(store->append(sample_at(slot), {}));
    ASSERT_TRUE(store->settle(kLong));
    if (slot == 5) std::filesystem::remove(old + "-wal");
  }
  ASSERT_TRUE(store->finish());
  store.reset();
  for (const char* name : {".db", ".2.db", ".db.sha256"})
    std::filesystem::rename(folder / "run" + name, folder / "kept" + name);
  const auto verified = verify_record(path);
  ASSERT_TRUE(verified) << text(verified.error());
  EXPECT_TRUE(verified->manifest);
  EXPECT_EQ(verified->files, 2);
  const auto manifest = check_manifest(path).value().value();
  EXPECT_TRUE(manifest.contains("kept.db") && manifest.contains("kept.2.db"));
  EXPECT_EQ(verified->digest, manifest.at("kept.db"));
  std::ofstream(path, std::ios::app) << "x";
  EXPECT_EQ(text(check_manifest(path).error()), path + ": has changed since the run was closed");
  std::ofstream(manifest_path(path)) << std::string(64, '0') << "  other.db-wal\n";
  EXPECT_EQ(text(check_manifest(path).error()), manifest_path(path) + ": does not name the record");
}

TEST(Manifest, DetectsEachOfTenThousandEditsOfOneByte) {
  const Folder folder;
  const auto path = folder / "run.db";
  make_run(path);
  ASSERT_TRUE(check_manifest(path).value());
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  const auto size = std::filesystem::file_size(path);
  std::mt19937_64 random(11);
  for (int i = 0; i < 10'000; ++i) {
    const auto at = static_cast<std::streamoff>(random() % size);
    const auto exchange = [&](char by) {
      file.seekg(at);
      const char was = static_cast<char>(file.get());
      file.seekp(at);
      file.put(static_cast<char>(was ^ by));
      file.flush();
    };
    const auto by = static_cast<char>(1 + random() % 255);
    exchange(by);
    ASSERT_FALSE(check_manifest(path)) << "byte " << at << " of " << size;
    exchange(by);
  }
  EXPECT_TRUE(check_manifest(path).value());
}

}  // namespace
}  // namespace gyrotherm::record
