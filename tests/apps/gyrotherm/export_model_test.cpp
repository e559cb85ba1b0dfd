// SPDX-License-Identifier: Apache-2.0
/// Reduced models, and models exported to other programs.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/file.hpp"
#include "tests/apps/gyrotherm/small_record.hpp"

namespace gyrotherm::app {
namespace {

class ExportModel : public testing::Test {
 protected:
  void SetUp() override { make_small_model(folder_); }
  [[nodiscard]] nlohmann::json model(const std::string& name) const {
    return nlohmann::json::parse(read_text_file(folder_ / name).value());
  }
  const Folder folder_;
};

TEST_F(ExportModel, ExportsCThatPassesItsSelfTest) {
  if (!installed("gcc")) GTEST_SKIP() << "gcc is not installed";
  const auto ran =
      gyrotherm_with("export-model " + (folder_ / "model.json") + " --as c --out " + (folder_ / "unit-7.c"));
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  std::ofstream(folder_ / "main.c") << "#include \"unit_7.h\"\nint main(void) { return unit_7_self_test(); }\n";
  const auto compiled = shell("cd " + (folder_ / ".") +
                              " && gcc -std=c99 -Wall -Wextra -Werror -pedantic unit-7.c main.c -o program -lm");
  EXPECT_EQ(compiled.exit_code, 0) << compiled.err;
  EXPECT_EQ(shell(folder_ / "program").exit_code, 0);
}

TEST_F(ExportModel, ExportsCWithTrackerThatPassesItsSelfTest) {
  if (!installed("gcc")) GTEST_SKIP() << "gcc is not installed";
  std::ofstream(folder_ / "long.csv") << small_rows(9000);
  ASSERT_EQ(gyrotherm_with("import " + (folder_ / "long.csv") + " --map " + (folder_ / "map.toml") + " --out " +
                           (folder_ / "long.db"))
                .exit_code,
            0);
  const std::string command = "export-model " + (folder_ / "model.json") + " --noise " + (folder_ / "long.db");
  const auto ran = gyrotherm_with(command + " --track --as c --out " + (folder_ / "unit-7.c"));
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  std::ofstream(folder_ / "main.c") << "#include \"unit_7.h\"\nstatic unit_7_tracker t;\nint main(void) {\n"
                                       "  unit_7_track_start(&t);\n"
                                       "  return unit_7_self_test() + (unit_7_track(&t, 0.1, 1) != 0.0);\n}\n";
  const auto compiled = shell("cd " + (folder_ / ".") +
                              " && gcc -std=c99 -Wall -Wextra -Werror -pedantic unit-7.c main.c -o program -lm");
  EXPECT_EQ(compiled.exit_code, 0) << compiled.err;
  EXPECT_EQ(shell(folder_ / "program").exit_code, 0);
  EXPECT_EQ(gyrotherm_with(command + " --as c --out " + (folder_ / "unit-7.c")).exit_code, 2) << "without --track";
  EXPECT_EQ(gyrotherm_with(command + " --track --as libsvm").exit_code, 2);
}

TEST_F(ExportModel, RequiresFileNameEndingInC) {
  EXPECT_EQ(gyrotherm_with("export-model " + (folder_ / "model.json") + " --as c").exit_code, 2);
  EXPECT_EQ(gyrotherm_with("export-model " + (folder_ / "model.json") + " --as c --out x.txt").exit_code, 2);
  EXPECT_EQ(gyrotherm_with("export-model " + (folder_ / "model.json") + " --as fortran").exit_code, 2);
}

TEST_F(ExportModel, PrintsWrittenFilesAsJson) {
  const auto command = "export-model " + (folder_ / "model.json") + " --json --as ";
  const auto as_c = gyrotherm_with(command + "c --out " + (folder_ / "unit-7.c"));
  ASSERT_EQ(as_c.exit_code, 0) << as_c.err;
  const auto facts = nlohmann::json::parse(as_c.out);
  EXPECT_EQ(facts["file"], folder_ / "unit-7.c");
  EXPECT_EQ(facts["header"], folder_ / "unit_7.h");
  EXPECT_LT(facts["agrees_to_deg_per_h"], 1e-9);
  const auto as_libsvm = gyrotherm_with(command + "libsvm --out " + (folder_ / "model.libsvm"));
  EXPECT_EQ(nlohmann::json::parse(as_libsvm.out)["file"], folder_ / "model.libsvm") << as_libsvm.err;
  const auto to_stdout = gyrotherm_with(command + "libsvm");
  EXPECT_EQ(to_stdout.exit_code, 2) << "the model is not JSON";
  EXPECT_EQ(to_stdout.out, "");
}

TEST_F(ExportModel, ReportsChangeOfReducedModel) {
  const std::string command = "reduce " + (folder_ / "model.json") + " " + (folder_ / "record.db") + " --out ";
  const auto ran = gyrotherm_with(command + (folder_ / "small.json") + " --keep 5");
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_NE(ran.out.find("kept 5 of "), std::string::npos) << ran.out;
  const auto small = model("small.json");
  EXPECT_EQ(small["function"]["beta"].size(), 5u);
  EXPECT_EQ(small["reduction"]["vectors"], 5);
  EXPECT_GT(small["reduction"]["bound_deg_per_h"], small["reduction"]["max_change_deg_per_h"]);
  const auto verified = gyrotherm_with("verify " + (folder_ / "small.json") + " " + (folder_ / "record.db"));
  EXPECT_EQ(verified.exit_code, 0) << verified.err;

  ASSERT_EQ(gyrotherm_with(command + (folder_ / "close.json") + " --within 0.01").exit_code, 0);
  EXPECT_LE(model("close.json")["reduction"]["max_change_deg_per_h"], 0.01);
  EXPECT_EQ(gyrotherm_with(command + (folder_ / "x.json")).exit_code, 2);
  EXPECT_EQ(gyrotherm_with(command + (folder_ / "x.json") + " --keep 3 --within 1").exit_code, 2);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "x.json"));
}

}  // namespace
}  // namespace gyrotherm::app
