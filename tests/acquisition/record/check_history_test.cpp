// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/check_history.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "tests/support/folder.hpp"

namespace gyrotherm::record {
namespace {

std::vector<std::string> histories(const std::string& rig_text, const std::string& rig_file,
                                   const std::string& record) {
  RunInfo info;
  info.rig_text = rig_text;
  info.rig_file = rig_file;
  return list_check_histories(info, record);
}

using Paths = std::vector<std::string>;
const std::string kWithStandard = "[check_standard]\nserial_numbers = [\"G-0001\"]\n";

TEST(CheckHistories, AreBesideRigFileThenBesideRecord) {
  EXPECT_EQ(histories(kWithStandard, "/etc/gyrotherm/lab.toml", "/data/run.db"),
            (Paths{"/etc/gyrotherm/check-standard.jsonl", "/data/check-standard.jsonl"}));
  EXPECT_EQ(histories(kWithStandard, "/data/lab.toml", "/data/run.db"), Paths{"/data/check-standard.jsonl"});
  EXPECT_EQ(histories(kWithStandard, "", "/data/run.db"), Paths{"/data/check-standard.jsonl"}) << "a virtual rig";
}

TEST(CheckHistories, HaveTheNameInTheRigFile) {
  const auto named = kWithStandard + "history = \"../golden/2027.jsonl\"\n";
  EXPECT_EQ(histories(named, "/etc/rigs/lab.toml", "/data/day/run.db"),
            (Paths{"/etc/golden/2027.jsonl", "/data/golden/2027.jsonl"}));
  EXPECT_EQ(histories(kWithStandard + "history = \"/srv/h.jsonl\"\n", "/etc/lab.toml", "/data/run.db"),
            Paths{"/srv/h.jsonl"});
}

TEST(CheckHistories, AreNoneWithoutCheckStandardOrReadableRigFile) {
  EXPECT_EQ(histories("name = \"lab\"\n", "/etc/lab.toml", "/data/run.db"), Paths{});
  EXPECT_EQ(histories("", "", "/data/run.db"), Paths{});
  EXPECT_EQ(histories("[check_standard\n", "/etc/lab.toml", "/data/run.db"), Paths{}) << "not TOML";
  EXPECT_EQ(histories(std::string(1000, '\x80'), "", "/data/run.db"), Paths{});
}

TEST(NamedHistory, IsFirstThatExistsAndOnlyOfTheSameRig) {
  const tests::TestFolder folder;
  RunInfo info;
  info.rig_text = kWithStandard;
  info.rig_name = "lab";
  info.rig_file = folder / "rigs/lab.toml";
  const auto named = find_named_history(info, folder / "runs/run.db");
  ASSERT_TRUE(named);
  EXPECT_EQ(named->find_path(), "");
  for (const char* name : {"runs", "rigs"}) {
    std::filesystem::create_directory(folder / name);
    std::ofstream(folder / (name + std::string("/check-standard.jsonl"))) << "{}";
    EXPECT_EQ(named->find_path(), folder / (name + std::string("/check-standard.jsonl")));
  }
  EXPECT_TRUE(named->is_for("lab", is_simulated(info)));
  EXPECT_FALSE(named->is_for("lab", !is_simulated(info)));
  EXPECT_FALSE(named->is_for("hall", is_simulated(info)));
  info.rig_text = "";
  EXPECT_FALSE(find_named_history(info, folder / "runs/run.db"));
}

}  // namespace
}  // namespace gyrotherm::record
