// SPDX-License-Identifier: Apache-2.0
/// Commands that read records verify them first.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "acquisition/record/sqlite.hpp"
#include "core/file.hpp"
#include "tests/apps/gyrotherm/small_record.hpp"

namespace gyrotherm::app {
namespace {

TEST(RecordedRun, IsRefusedWithPositionWhenChangedUnlessUnverified) {
  const Folder folder;
  make_small_model(folder);
  const auto record = folder / "record.db";
  {
    auto database = record::Database::open(record, record::Access::read_write, 0).value();
    ASSERT_TRUE(database.execute("UPDATE sample SET A = A + 0.001 WHERE slot = 2000"));
  }
  const std::vector<std::string> commands{
      "export " + record + " --out " + (folder / "x.csv"),
      "train " + record + " --inputs A-B --method linear --folds blocks --out " + (folder / "x.json"),
      "verify " + (folder / "model.json") + " " + record,
      "placement " + record + " --folds blocks",
      "reduce " + (folder / "model.json") + " " + record + " --keep 10 --out " + (folder / "small.json"),
      "export-model " + (folder / "model.json") + " --as libsvm --data " + record};
  for (const auto& command : commands) {
    const auto refused = gyrotherm_with(command);
    EXPECT_EQ(refused.exit_code, 4) << command;
    EXPECT_EQ(refused.err, "gyrotherm: " + record +
                               ": sample 2000 of second 2000, or an earlier row, does not match the hash chain\n")
        << command;
    EXPECT_EQ(refused.out, "") << command;
    const auto taken = gyrotherm_with(command + " --unverified");
    EXPECT_EQ(taken.exit_code, 0) << command << ": " << taken.err;
    EXPECT_NE(taken.err.find("warning: " + record + ": the integrity of the record was not verified"),
              std::string::npos)
        << command << taken.err;
  }
  EXPECT_TRUE(std::filesystem::exists(folder / "x.csv")) << "unverified";
}

TEST(RecordedRun, IsGivenOnceToPlacement) {
  const Folder folder;
  make_small_model(folder);
  const auto record = folder / "record.db";
  const auto twice = gyrotherm_with("placement " + record + " " + record + " --folds blocks");
  EXPECT_EQ(twice.exit_code, 2) << "it would be held out and used for training";
  EXPECT_NE(twice.err.find("is the same run as " + record), std::string::npos) << twice.err;
  const auto seen = gyrotherm_with("placement " + record + " --folds blocks --verify " + record);
  EXPECT_EQ(seen.exit_code, 2);
  EXPECT_NE(seen.err.find("--verify requires runs that do not influence the ranking"), std::string::npos) << seen.err;
}

/// Changes a byte that no row contains.
TEST(RecordedRun, IsRefusedByManifestWhenByteChanged) {
  const Folder folder;
  make_small_model(folder);
  const auto record = folder / "record.db";
  {
    std::fstream file(record, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(96);  // SQLite version of the writer
    file.put(1);
  }
  const auto refused = gyrotherm_with("export " + record + " --out " + (folder / "x.csv"));
  EXPECT_EQ(refused.exit_code, 4);
  EXPECT_EQ(refused.err, "gyrotherm: " + record + ": has changed since the run was closed\n");
  EXPECT_FALSE(std::filesystem::exists(folder / "x.csv"));
}

TEST(RecordedRun, IsVerifiedWithWordOfMissingManifest) {
  const Folder folder;
  make_small_model(folder);
  const auto record = folder / "record.db", verify = "status --verify " + record;
  EXPECT_NE(gyrotherm_with(verify).out.find("matches its manifest"), std::string::npos);
  std::filesystem::remove(record + ".sha256");
  const auto without = gyrotherm_with(verify);
  EXPECT_EQ(without.exit_code, 0) << without.err;
  EXPECT_NE(without.out.find("are unchanged; it has no manifest, although its run is finished"), std::string::npos)
      << without.out;
  EXPECT_NE(gyrotherm_with(verify + " --json").out.find("\"finished\": true, \"manifest\": false"), std::string::npos);
}

/// A rig may have only some virtual instruments.
TEST(RecordedRun, NamesVirtualInstrumentsInCompensatedTable) {
  const Folder folder;
  make_small_model(folder);
  const auto record = folder / "record.db", table = folder / "x.csv";
  const auto first_line = [&] {
    const auto done = gyrotherm_with("export " + record + " --compensated --model " + (folder / "model.json") +
                                     " --out " + table + " --force --unverified");
    EXPECT_EQ(done.exit_code, 0) << done.err;
    const auto text = read_text_file(table, std::size_t{1} << 24).value();
    return text.substr(0, text.find('\n'));
  };
  EXPECT_EQ(first_line().find("SIMULATED"), std::string::npos);
  {
    auto database = record::Database::open(record, record::Access::read_write, 0).value();
    ASSERT_TRUE(
        database.execute("INSERT INTO list(name, of, position, value) VALUES"
                         " ('virtual_instruments', '', 0, 'chamber'),"
                         " ('virtual_instruments', '', 1, 'thermometer 2')"));
  }
  EXPECT_EQ(first_line(), "# SIMULATED: these instruments were virtual: chamber, thermometer 2");
}

}  // namespace
}  // namespace gyrotherm::app
