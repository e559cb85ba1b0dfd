// SPDX-License-Identifier: Apache-2.0
/// The command `import`: a first map by --guess, then the record.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <random>

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
  EXPECT_EQ(imported.out.rfind(
                "{\"rows\":3,\"seconds\":2.0,\"gaps\":0,\"file_rows\":3,\"step_s\":1.0,\"file_step_s\":1.0,", 0),
            0u)
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

/// Returns a table of 1-s rows: a thermometer in four ramps and rests, and a gyro that depends on it.
std::string bench_table(int rows, int seed, double second_thermometer_stops_at = 1e9) {
  std::mt19937_64 random(static_cast<std::uint64_t>(seed));
  std::normal_distribution<double> normal;
  std::string table = "Time [s],T1 [°C],T2 [°C],Gyro [°/h]\n";
  double frozen = 0;
  for (int row = 0; row < rows; ++row) {
    const double temperature = 20 + 25 * std::sin(row / 900.0 + seed);
    const double second = temperature + 0.02 * normal(random);
    if (row < second_thermometer_stops_at) frozen = second;
    table +=
        fmt::format("{},{:.2f},{:.2f},{:.4f}\n", row, temperature + 0.02 * normal(random),
                    row < second_thermometer_stops_at ? second : frozen, 5 + 0.1 * temperature + 0.3 * normal(random));
  }
  return table;
}

/// Guesses a map, imports, and returns the output of the import.
Ran import_table(const Folder& folder, const std::string& name, const std::string& table) {
  std::ofstream(folder / (name + ".csv")) << table;
  const auto guessed =
      gyrotherm_with("import --guess " + (folder / (name + ".csv")) + " --out " + (folder / (name + ".toml")));
  EXPECT_EQ(guessed.exit_code, 0) << guessed.err;
  return gyrotherm_with("import " + (folder / (name + ".csv")) + " --map " + (folder / (name + ".toml")) + " --out " +
                        (folder / (name + ".db")));
}

Ran train_linear(const Folder& folder, const std::string& name) {
  return gyrotherm_with("train " + (folder / (name + ".db")) + " --inputs T1 --method linear --out " +
                        (folder / "model.json"));
}

TEST(ImportCommand, MakesTableThatCompensateReads) {
  const Folder folder;
  ASSERT_EQ(import_table(folder, "one", bench_table(9000, 1)).exit_code, 0);
  ASSERT_EQ(import_table(folder, "other", bench_table(5000, 2)).exit_code, 0);
  ASSERT_EQ(train_linear(folder, "one").exit_code, 0);
  const auto exported = gyrotherm_with("export " + (folder / "other.db") + " --out " + (folder / "other.x.csv"));
  ASSERT_EQ(exported.exit_code, 0) << exported.err;
  const auto table = read_text_file(folder / "other.x.csv").value();
  EXPECT_NE(table.find(", nothing removed\n"), std::string::npos) << table.substr(0, 300);
  const auto compensated = gyrotherm_with("compensate " + (folder / "model.json") + " --uncertainty", table);
  ASSERT_EQ(compensated.exit_code, 0) << compensated.err;
  EXPECT_EQ(compensated.err.find("reference"), std::string::npos) << compensated.err;
  EXPECT_EQ(std::ranges::count(compensated.out, '\n'), 5001);
  const auto last = compensated.out.substr(compensated.out.rfind('\n', compensated.out.size() - 2) + 1);
  EXPECT_LT(std::abs(std::stod(last)), 3) << "without the mean of 7 °/h";
}

TEST(ImportCommand, ReportListsColumnMap) {
  const Folder folder;
  ASSERT_EQ(import_table(folder, "two.axes", bench_table(9000, 1)).exit_code, 0);
  const std::string map = read_text_file(folder / "two.axes.toml").value();
  EXPECT_NE(map.find("\nname = \"two.axes\"\n"), std::string::npos) << map.substr(0, 400);
  const auto made =
      gyrotherm_with("report " + (folder / "two.axes.db") + " --language en,de --out " + (folder / "calibration"));
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const std::string json = read_text_file(folder / "calibration/calibration.json", kLargestTable).value();
  EXPECT_NE(json.find("\"role\": \"column_map\""), std::string::npos);
  EXPECT_EQ(json.find("\"role\": \"rig\""), std::string::npos);
  for (const auto& [file, words] :
       {std::pair("calibration.html", "Column map"), std::pair("calibration.de.html", "Spaltenzuordnung")})
    EXPECT_NE(read_text_file(folder / ("calibration/" + std::string(file)), kLargestTable).value().find(words),
              std::string::npos)
        << file;
}

TEST(ImportCommand, TreatsEarthRateOfZeroAsNone) {
  const Folder folder;
  ASSERT_EQ(import_table(folder, "one", bench_table(9000, 1)).exit_code, 0);
  ASSERT_EQ(train_linear(folder, "one").exit_code, 0);
  std::ofstream(folder / "zero.csv") << bench_table(5000, 2);
  auto map = read_text_file(folder / "one.toml").value();
  std::ofstream(folder / "zero.toml") << map << "earth_rate = 0\n";
  ASSERT_EQ(gyrotherm_with("import " + (folder / "zero.csv") + " --map " + (folder / "zero.toml") + " --out " +
                           (folder / "zero.db"))
                .exit_code,
            0);
  const auto verified = gyrotherm_with("verify " + (folder / "model.json") + " " + (folder / "zero.db"));
  ASSERT_EQ(verified.exit_code, 0) << verified.err;
  EXPECT_EQ(verified.out.find("reference"), std::string::npos) << verified.out;
}

TEST(ImportCommand, ReportsMissingReferenceFirst) {
  const Folder folder;
  ASSERT_EQ(import_table(folder, "one", bench_table(9000, 1)).exit_code, 0);
  ASSERT_EQ(train_linear(folder, "one").exit_code, 0);
  const auto ran = gyrotherm_with("compensate " + (folder / "model.json") + " --uncertainty",
                                  "# axis gyro: scale 1\nslot,T1 [°C],gyro [1 °/h]\n0,20,7\n");
  EXPECT_EQ(ran.exit_code, 4);
  EXPECT_EQ(ran.err.rfind("gyrotherm: stdin: the Earth rate on gyro is missing", 0), 0u) << ran.err;
}

TEST(ImportCommand, WarnsOfFailedThermometerUntilVerification) {
  const Folder folder;
  const auto imported = import_table(folder, "one", bench_table(9000, 1, 4500));
  ASSERT_EQ(imported.exit_code, 0) << imported.err;
  EXPECT_NE(imported.err.find("warning: T2 repeats "), std::string::npos) << imported.err;
  const auto trained = train_linear(folder, "one");
  EXPECT_NE(trained.out.find("one.db: T2 repeats "), std::string::npos) << trained.out;
  const auto verified = gyrotherm_with("verify " + (folder / "model.json") + " " + (folder / "one.db"));
  EXPECT_NE(verified.out.find("one.db: T2 repeats "), std::string::npos) << verified.out;
}

TEST(ImportCommand, StatesShareThatMissingValuesLeaveOut) {
  const Folder folder;
  auto table = bench_table(9000, 1);
  for (std::size_t at = table.find("\n4500,"), row = 0; row < 4500; ++row, at = table.find('\n', at + 1)) {
    const auto begin = table.find(',', table.find(',', at) + 1) + 1;
    table.replace(begin, table.find(',', begin) - begin, "OPEN");
  }
  ASSERT_EQ(import_table(folder, "one", table).exit_code, 0);
  const auto trained = train_linear(folder, "one");
  ASSERT_EQ(trained.exit_code, 0) << trained.err;
  EXPECT_NE(trained.out.find("left out because values are missing: T2 in 45 clusters (50.0 %)"), std::string::npos)
      << trained.out;
}

TEST(ImportCommand, RecognisesPartOfTrainingDataInOtherFile) {
  const Folder folder;
  const auto table = bench_table(9000, 1);
  ASSERT_EQ(import_table(folder, "one", table).exit_code, 0);
  ASSERT_EQ(train_linear(folder, "one").exit_code, 0);
  std::string cut = table.substr(0, table.find('\n') + 1);
  for (std::size_t at = table.find("\n3000,") + 1; at < table.find("\n6000,"); at = table.find('\n', at) + 1) {
    const auto comma = table.find(',', at);
    cut += std::to_string(std::stoi(table.substr(at, comma - at)) - 3000) +
           table.substr(comma, table.find('\n', at) + 1 - comma);
  }
  ASSERT_EQ(import_table(folder, "cut", cut).exit_code, 0);
  ASSERT_EQ(import_table(folder, "other", bench_table(3000, 2)).exit_code, 0);
  const auto same = gyrotherm_with("verify " + (folder / "model.json") + " " + (folder / "cut.db"));
  EXPECT_NE(same.out.find("rows of this record, which are in another file"), std::string::npos) << same.out;
  const auto other = gyrotherm_with("verify " + (folder / "model.json") + " " + (folder / "other.db"));
  EXPECT_EQ(other.out.find("in-sample"), std::string::npos) << other.out;
}

TEST(ImportCommand, StatesSpacingOfFileAndOfCombinedRows) {
  const Folder folder;
  const auto import_rows = [&](const std::string& name, int rows, double step_s, const std::string& time,
                               const std::string& options = "") {
    std::string table = "t,T,w\n";
    for (int row = 0; row < rows; ++row)
      table += fmt::format("{:.3f},{},{}\n", step_s * row, 20 + 0.01 * (row % 50), row % 7);
    std::ofstream(folder / (name + ".csv")) << table;
    std::ofstream(folder / (name + ".toml"))
        << "schema = \"gyrotherm-import/1\"\nname = \"m\"\n[time]\ncolumn = \"t\"\n"
           "unit = \"s\"\n"
        << time
        << "[[thermometer]]\nname = \"T\"\ncolumn = \"T\"\n[gyro]\ncolumn = \"w\"\n"
           "kind = \"rate\"\nscale = 1\n";
    return gyrotherm_with("import " + (folder / (name + ".csv")) + " --map " + (folder / (name + ".toml")) + " --out " +
                          (folder / (name + ".db")) + options);
  };
  const auto expect_line = [](const Ran& ran, const std::string& line) {
    EXPECT_EQ(ran.exit_code, 0) << ran.err;
    EXPECT_NE(ran.err.find(line), std::string::npos) << ran.err;
  };
  expect_line(import_rows("fast", 600, 0.1, "every = \"1 s\"\n"),
              "600 rows in the file, usually 0.1 s apart, combined into rows of 1 s\n");
  const auto slow = import_rows("slow", 200, 5, "every = \"2 min\"\n");
  expect_line(slow, "200 rows in the file, usually 5 s apart, combined into rows of 120 s\n");
  EXPECT_EQ(slow.err.find("is the unit in [time] right?"), std::string::npos) << slow.err;
  expect_line(import_rows("plain", 60, 0.5, ""), "60 rows in the file, usually 0.5 s apart\n");
  expect_line(import_rows("same", 30, 2, "every = \"2 s\"\n"), "30 rows in the file, usually 2 s apart\n");
  const auto as_json = import_rows("json", 600, 0.25, "every = \"2 s\"\n", " --json");
  EXPECT_NE(as_json.out.find("\"step_s\":2.0,\"file_step_s\":0.25,"), std::string::npos) << as_json.out;
}

TEST(ImportCommand, StatesResolutionOfTimes) {
  const Folder folder;
  std::string table = "Time,Temp C,Gyro dph\n";
  for (int row = 0; row < 360; ++row)
    table += fmt::format("13.3.2026 8:{:02d},{},{}\n", row / 6, 20 + row % 7, row % 5);
  const auto imported = import_table(folder, "nosec", table);
  ASSERT_EQ(imported.exit_code, 0) << imported.err;
  EXPECT_NE(imported.err.find("on average 10 s apart; their times have a resolution of 60 s"), std::string::npos)
      << imported.err;
}

}  // namespace
}  // namespace gyrotherm::app
