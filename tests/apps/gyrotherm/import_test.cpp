// SPDX-License-Identifier: Apache-2.0
/// The command `import`: a first map by --guess, then the record.
#include <gtest/gtest.h>

#include <fstream>

#include "core/file.hpp"
#include "tests/apps/gyrotherm/program.hpp"

namespace gyrotherm::app {
namespace {

constexpr const char* kForeignTable = "Time [s];Oven [°C];Gyro x [°/h]\n0;20,5;0,25\n1;20,6;0,5\n2;;0,75\n";

TEST(ImportCommand, DetectsMapThatReadsTable) {
  const Folder folder;
  std::ofstream(folder / "bench.csv") << kForeignTable;
  const auto guessed = gyrotherm_with("import --guess " + (folder / "bench.csv") + " --out " + (folder / "bench.toml"));
  ASSERT_EQ(guessed.exit_code, 0) << guessed.err;
  const auto shown = gyrotherm_with("import --guess " + (folder / "bench.csv"));
  EXPECT_EQ(shown.out, read_text_file(folder / "bench.toml").value());
  const auto imported = gyrotherm_with("import " + (folder / "bench.csv") + " --map " + (folder / "bench.toml") +
                                       " --out " + (folder / "bench.db") + " --json");
  ASSERT_EQ(imported.exit_code, 0) << imported.err;
  EXPECT_EQ(imported.out.rfind("{\"rows\":3,\"seconds\":2.0,\"gaps\":0,\"file_rows\":3,\"step_s\":1.0,", 0), 0u)
      << imported.out;
  EXPECT_NE(imported.out.find("\"missing_texts\":{\"\":1},\"least\":20.5,\"greatest\":20.6}"), std::string::npos)
      << imported.out;
  const auto status = gyrotherm_with("status " + (folder / "bench.db"));
  EXPECT_NE(status.out.find("an import of 3 rows"), std::string::npos) << status.out;
  EXPECT_EQ(status.out.find("second"), std::string::npos) << status.out;
}

TEST(ImportCommand, DoesNotReplaceExistingMap) {
  const Folder folder;
  std::ofstream(folder / "bench.csv") << kForeignTable;
  std::ofstream(folder / "bench.toml") << "corrected by hand";
  const auto guessed = gyrotherm_with("import --guess " + (folder / "bench.csv") + " --out " + (folder / "bench.toml"));
  EXPECT_EQ(guessed.exit_code, 4);
  EXPECT_EQ(read_text_file(folder / "bench.toml").value(), "corrected by hand");
}

TEST(ImportCommand, ExplainsHowToMakeMap) {
  const Folder folder;
  std::ofstream(folder / "bench.csv") << kForeignTable;
  const auto ran = gyrotherm_with("import " + (folder / "bench.csv") + " --out " + (folder / "bench.db"));
  EXPECT_EQ(ran.exit_code, 2);
  EXPECT_NE(ran.err.find("--guess"), std::string::npos) << ran.err;
  EXPECT_EQ(gyrotherm_with("import " + (folder / "bench.csv") + " --map freeimu").exit_code, 2);
  EXPECT_EQ(gyrotherm_with("import --guess " + (folder / "bench.csv") + " --map freeimu").exit_code, 2);
}

}  // namespace
}  // namespace gyrotherm::app
