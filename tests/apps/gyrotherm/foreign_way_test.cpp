// SPDX-License-Identifier: Apache-2.0
/// Complete use of a foreign file: detect its format, import, train and verify, without editing the map.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>

#include "acquisition/record/record.hpp"
#include "core/file.hpp"
#include "tests/apps/gyrotherm/program.hpp"

namespace gyrotherm::app {
namespace {

/// Six hours of rows, 10 s apart: an oven that cycles, a second thermometer that lags, and a rate that follows the
/// oven.
struct Bench {
  static constexpr int kRows = 2160;
  static double oven_c(int row) { return 20 - 20 * std::cos(row / 170.); }
  static double wall_c(int row) { return 19 - 18 * std::cos((row - 12) / 170.); }
  static double rate_deg_per_h(int row) { return 5 + 0.1 * oven_c(row) + 0.02 * std::sin(row * 1.7); }
};

std::string table(const std::string& header, const std::function<std::string(int)>& row) {
  std::string text = header + "\n";
  for (int i = 0; i < Bench::kRows; ++i) text += row(i) + "\n";
  return text;
}

std::string clock(int row) {
  const int s = 8 * 3600 + 10 * row;
  return fmt::format("{:02}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

std::string format_with_comma(double number, int digits) {
  auto text = fmt::format("{:.{}f}", number, digits);
  text[text.find('.')] = ',';
  return text;
}

struct ForeignTable {
  std::string name, text, axis;
};

std::vector<ForeignTable> tables() {
  using B = Bench;
  return {
      {"three axes in mdps",
       table("Time [ms],T1 [degC],T2 [degC],gyro_x [mdps],gyro_y [mdps],gyro_z [mdps]",
             [](int i) {
               const double w = B::rate_deg_per_h(i) / 3.6;
               return fmt::format("{},{:.3f},{:.3f},{:.5f},{:.5f},{:.5f}", 10'000 * i, B::oven_c(i), B::wall_c(i), w,
                                  2 * w, w);
             }),
       "--axis gyro_z"},
      {"a spreadsheet in German",
       table("Zeit;T1 [°C];T2 [°C];Gyro [°/h]",
             [](int i) {
               return "01.03.2026 " + clock(i) + ";" + format_with_comma(B::oven_c(i), 3) + ";" +
                      format_with_comma(B::wall_c(i), 3) + ";" + format_with_comma(B::rate_deg_per_h(i), 5);
             }),
       ""},
      {"minutes and Fahrenheit",
       "Chamber 3\nOperator: N. N.\n\n" + table("Time [min],T1 [°F],T2 [°F],Gyro [deg/h]",
                                                [](int i) {
                                                  return fmt::format("{:.4f},{:.3f},{:.3f},{:.5f}", i / 6.,
                                                                     32 + 1.8 * B::oven_c(i), 32 + 1.8 * B::wall_c(i),
                                                                     B::rate_deg_per_h(i));
                                                }),
       ""},
      {"equal names and torn lines",
       table("Time,Temp [°C],Temp [°C],w [rad/s]",
             [](int i) {
               return fmt::format("{},{:.3f},{:.3f},{:.9f}{}", 10 * i, B::oven_c(i), B::wall_c(i),
                                  B::rate_deg_per_h(i) / 206264.80624709636,
                                  i % 500 == 77 ? fmt::format("\n{},2", 10 * i + 5) : "");
             }),
       ""},
  };
}

TEST(ForeignWay, TrainsFromDetectedMapWithoutEditing) {
  for (const ForeignTable& foreign : tables()) {
    SCOPED_TRACE(foreign.name);
    const Folder folder;
    std::ofstream(folder / "f.csv", std::ios::binary) << foreign.text;
    const auto guessed = gyrotherm_with("import --guess " + (folder / "f.csv") + " --out " + (folder / "f.toml"));
    ASSERT_EQ(guessed.exit_code, 0) << guessed.err;
    const auto imported = gyrotherm_with("import " + (folder / "f.csv") + " --map " + (folder / "f.toml") + " --out " +
                                         (folder / "f.db") + " --json");
    ASSERT_EQ(imported.exit_code, 0) << imported.err << read_text_file(folder / "f.toml").value_or("");
    EXPECT_EQ(imported.out.rfind("{\"rows\":2160,\"seconds\":", 0), 0u) << imported.out;
    EXPECT_NEAR(std::stod(imported.out.substr(imported.out.find("seconds") + 9)), 21590, 0.01) << imported.out;
    EXPECT_NE(imported.out.find("\"gaps\":0,"), std::string::npos) << imported.out;
    const auto trained = gyrotherm_with("train " + (folder / "f.db") + " --inputs temperatures --method linear " +
                                        foreign.axis + " --out " + (folder / "m.json"));
    ASSERT_EQ(trained.exit_code, 0) << trained.err;
    EXPECT_NE(trained.out.find("linear on temperatures (2 inputs)"), std::string::npos) << trained.out;
    EXPECT_NE(trained.out.find("raw bias, without a model: std 1.4"), std::string::npos) << trained.out;
    const auto verified = gyrotherm_with("verify " + (folder / "m.json") + " " + (folder / "f.db"));
    EXPECT_EQ(verified.exit_code, 0) << verified.err;
    EXPECT_EQ(verified.out.find("no better than no model"), std::string::npos) << verified.out;
  }
}

/// Returns the path of a record of the bench with the bias that `rate` gives.
std::string make_record(const Folder& folder, const std::function<std::string(int)>& rate, const std::string& more = "",
                        const std::function<double(int)>& third = Bench::wall_c) {
  std::ofstream(folder / "t.csv") << table("t,TA,TB,w", [&](int i) {
    return fmt::format("{},{:.6f},{:.6f},{}", 10 * i, Bench::oven_c(i), third(i), rate(i));
  });
  std::ofstream(folder / "t.toml")
      << "schema = \"gyrotherm-import/1\"\nname = \"t\"\n[file]\n[time]\ncolumn = \"t\"\n"
         "unit = \"s\"\n[[thermometer]]\nname = \"TA\"\ncolumn = \"TA\"\n[[thermometer]]\n"
         "name = \"TB\"\ncolumn = \"TB\"\n[gyro]\ncolumn = \"w\"\nkind = \"rate\"\nscale = 1\n" +
             more;
  std::filesystem::remove(folder / "t.db");
  std::filesystem::remove(folder / "t.db.sha256");
  const auto made =
      gyrotherm_with("import " + (folder / "t.csv") + " --map " + (folder / "t.toml") + " --out " + (folder / "t.db"));
  EXPECT_EQ(made.exit_code, 0) << made.err;
  return folder / "t.db";
}

std::string clean_rate(int i) { return fmt::format("{:.6f}", Bench::rate_deg_per_h(i)); }

std::string train(const Folder& folder, const std::string& record, const std::string& options) {
  const auto trained = gyrotherm_with("train " + record + " --method linear --inputs temperatures --force --out " +
                                      (folder / "m.json") + " " + options);
  return trained.exit_code == 0 ? trained.out : trained.err;
}

TEST(ForeignWay, ReportsOutliersAndRemovesThemOnRequest) {
  const Folder folder;
  for (const double spike : {1000., -9999., 60.}) {
    const auto record =
        make_record(folder, [&](int i) { return i % 300 == 33 ? fmt::format("{}", spike) : clean_rate(i); });
    const auto named = train(folder, record, "");
    EXPECT_NE(named.find("8 samples of the bias are outliers"), std::string::npos) << named;
    EXPECT_NE(named.find("at 330 s"), std::string::npos) << named;
    const auto without = train(folder, record, "--outliers leave-out");
    EXPECT_NE(without.find("were left out"), std::string::npos) << without;
    EXPECT_NE(without.find("rmse 0.00"), std::string::npos) << without;
    EXPECT_NE(read_text_file(folder / "m.json").value().find("samples of the bias are outliers"), std::string::npos);
  }
  EXPECT_EQ(train(folder, make_record(folder, clean_rate), "").find("outlier"), std::string::npos);
}

TEST(ForeignWay, WarnsWhenModelIsNoBetterThanNone) {
  const Folder folder;
  for (const double seed : {1.3, 2.1, 5.7}) {
    const auto record = make_record(folder, [&](int i) {
      return fmt::format("{:.6f}", std::fmod(std::abs(std::sin(i * seed) * 43758.5453), 1.0));
    });
    const auto trained = train(folder, record, "--folds blocks:8");
    EXPECT_NE(trained.find("no better than no model: held-out residual bias std"), std::string::npos) << trained;
  }
}

int count_text(const std::string& text, const std::string& part) {
  int count = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

/// The second record has another offset of 12 °/h.
TEST(ForeignWay, GivesVerdictOnAnotherRecord) {
  const Folder folder;
  const auto trained = train(folder, make_record(folder, clean_rate), "");
  EXPECT_NE(trained.find("verdict: improves; std"), std::string::npos) << trained;
  EXPECT_EQ(trained.find("fitting:"), std::string::npos) << "progress is shown on a terminal only: " << trained;
  const auto record = make_record(folder, [](int i) { return fmt::format("{:.6f}", 12 + Bench::rate_deg_per_h(i)); });
  const auto verified = gyrotherm_with("verify " + (folder / "m.json") + " " + record);
  EXPECT_EQ(verified.exit_code, 0) << verified.err;
  EXPECT_NE(verified.out.find("the intervals do not hold"), std::string::npos) << verified.out;
  EXPECT_EQ(count_text(verified.out, "the record has no hold"), 1) << verified.out;
  const auto report =
      nlohmann::json::parse(gyrotherm_with("verify " + (folder / "m.json") + " " + record + " --json").out);
  EXPECT_EQ(report["verdict"]["intervals_hold"], false);
  EXPECT_LT(report["verdict"]["rmse_reduction_deg_per_h"]["value"], 20.0);
  const auto quiet = gyrotherm_with("verify " + (folder / "m.json") + " " + record + " --quiet");
  EXPECT_EQ(quiet.out, verified.out) << "results remain";
  EXPECT_EQ(quiet.err, "");
}

TEST(ForeignWay, RefusesRecordsWithCommonRows) {
  const Folder folder;
  const auto record = make_record(folder, clean_rate);
  const auto import_rows = [&](const std::string& name, int first, double other_noise) {
    std::ofstream file(folder / (name + ".csv"));
    file << "t,TA,TB,w\n";
    for (int i = first; i < Bench::kRows; ++i)
      file << fmt::format("{},{:.6f},{:.6f},{:.6f}\n", 10 * (i - first), Bench::oven_c(i), Bench::wall_c(i),
                          Bench::rate_deg_per_h(i) + other_noise * (std::sin(i * 2.3) - std::sin(i * 1.7)));
    file.close();
    const auto made = gyrotherm_with("import " + (folder / (name + ".csv")) + " --map " + (folder / "t.toml") +
                                     " --out " + (folder / (name + ".db")));
    EXPECT_EQ(made.exit_code, 0) << made.err;
    return folder / (name + ".db");
  };
  const auto part = import_rows("part", 2000, 0), other = import_rows("other", 0, 0.02);
  const auto refused = train(folder, record + " " + part, "");
  EXPECT_NE(refused.find(part + ": has rows of " + record), std::string::npos) << refused;
  EXPECT_NE(train(folder, part + " " + record, "").find(record + ": has rows of " + part), std::string::npos);
  EXPECT_NE(train(folder, record + " " + other, "").find("linear on temperatures"), std::string::npos);
}

TEST(ForeignWay, RefusesRecordThatWasExportedAgain) {
  const auto noisy = [](int i) {
    return Bench::rate_deg_per_h(i) + 0.2 * (std::fmod(std::abs(std::sin(i * 12.9898) * 43758.5453), 1.0) - 0.5);
  };
  const Folder folder;
  const auto record = make_record(folder, [&](int i) { return fmt::format("{:.6f}", noisy(i)); });
  std::ofstream table(folder / "again.csv");
  table << "t,TA,TB,w\n";
  for (int i = 0; i < Bench::kRows; ++i)
    table << fmt::format("{},{:.3f},{:.3f},{:.7f}\n", 10 * i + 7200, Bench::oven_c(i), Bench::wall_c(i),
                         noisy(i) / 3600);
  table.close();
  auto map = read_text_file(folder / "t.toml").value();
  const auto scale = map.find("scale = 1");
  ASSERT_NE(scale, std::string::npos) << map;
  std::ofstream(folder / "s.toml") << map.replace(scale, std::string("scale = 1").size(), "scale = 3600");
  const auto again = folder / "again.db";
  const auto made =
      gyrotherm_with("import " + (folder / "again.csv") + " --map " + (folder / "s.toml") + " --out " + again);
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const auto refused = train(folder, record + " " + again, "");
  EXPECT_NE(refused.find(again + ": has rows of " + record), std::string::npos) << refused;
  EXPECT_NE(train(folder, record, "").find("linear on temperatures"), std::string::npos);
  const auto verified = gyrotherm_with("verify " + (folder / "m.json") + " " + record + " " + again);
  EXPECT_EQ(verified.exit_code, 2) << verified.out;
  EXPECT_NE(verified.err.find(again + ": has rows of " + record), std::string::npos) << verified.err;
}

TEST(ForeignWay, NamesRemedyForSingleThermometer) {
  const Folder folder;
  std::ofstream(folder / "t.csv") << table(
      "t,TA,w", [&](int i) { return fmt::format("{},{:.6f},{}", 10 * i, Bench::oven_c(i), clean_rate(i)); });
  const std::string head =
      "schema = \"gyrotherm-import/1\"\nname = \"t\"\n[file]\n[time]\ncolumn = \"t\"\nunit = \"s\"\n";
  const std::string gyro = "[gyro]\ncolumn = \"w\"\nkind = \"rate\"\nscale = 1\n";
  const auto refused = [&](const std::string& map, const char* name) {
    std::ofstream(folder / "t.toml") << map;
    const std::string record = folder / name;
    const auto made =
        gyrotherm_with("import " + (folder / "t.csv") + " --map " + (folder / "t.toml") + " --out " + record);
    EXPECT_EQ(made.exit_code, 0) << made.err;
    const auto trained = gyrotherm_with("train " + record + " --out " + (folder / "m.json"));
    EXPECT_NE(trained.exit_code, 0);
    return trained.err;
  };
  const auto single = refused(head + "[[thermometer]]\nname = \"TA\"\ncolumn = \"TA\"\n" + gyro, "one.db");
  EXPECT_NE(single.find("use --inputs temperatures"), std::string::npos) << single;
  const auto none = refused(head + gyro, "none.db");
  EXPECT_NE(none.find("the record has no thermometer"), std::string::npos) << none;
}

TEST(ForeignWay, NamesFoldWithConstantInput) {
  const Folder folder;
  for (int fold = 0; fold < 4; ++fold) {
    const auto record = make_record(folder, clean_rate, "", [&](int i) { return i / 540 == fold ? 20. : 1.; });
    const auto refused = train(folder, record, "--folds blocks:4 --guard 0");
    EXPECT_NE(refused.find(fmt::format("without fold {} of 4", fold + 1)), std::string::npos) << refused;
    EXPECT_NE(refused.find("choose other --folds"), std::string::npos) << refused;
  }
}

TEST(ForeignWay, TrainsOnShortClusters) {
  const Folder folder;
  const auto record = make_record(folder, clean_rate);
  for (const auto& [length, clusters] : {std::pair("50", 432), std::pair("20", 1080), std::pair("200", 108)}) {
    const auto trained = train(folder, record, "--cluster-length " + std::string(length));
    EXPECT_NE(trained.find(fmt::format("over {} clusters", clusters)), std::string::npos) << trained;
    EXPECT_NE(trained.find("clusters are means over " + std::string(length) + " s"), std::string::npos) << trained;
    const auto verified = gyrotherm_with("verify " + (folder / "m.json") + " " + record);
    EXPECT_EQ(verified.exit_code, 0) << verified.err;
  }
}

TEST(ForeignWay, UsesTimeOfExportedTable) {
  const Folder folder;
  const auto record = make_record(folder, clean_rate, "earth_rate = 0\n");
  train(folder, record, "");
  ASSERT_EQ(gyrotherm_with("export " + record + " --out " + (folder / "t.out.csv")).exit_code, 0);
  const auto compensated = gyrotherm_with("compensate " + (folder / "m.json") + " < " + (folder / "t.out.csv"));
  EXPECT_EQ(compensated.exit_code, 4);
  EXPECT_NE(compensated.err.find("these rows are 10 s apart"), std::string::npos) << compensated.err;
}

/// Returns the folder of files from public reports; empty if it is not available.
std::string public_reports() {
  const char* shared = std::getenv("GYROTHERM_SHARED");
  const auto folder = shared != nullptr ? std::string(shared) + "/trials/files/" : "";
  return std::filesystem::exists(folder) ? folder : "";
}

/// Uses files from public reports if they are available.
TEST(ForeignWay, ReadsFilesOfPublicReports) {
  const auto trials = public_reports();
  if (trials.empty()) GTEST_SKIP() << "trials/files is not in GYROTHERM_SHARED";
  struct Trial {
    const char* file;
    std::size_t rows;
    const char* said;
  };
  const Folder folder;
  std::size_t seen = 0;
  for (const Trial& trial : {Trial{"c02_preamble.csv", 1080, "2 h 59 min 50 s"},
                             {"c03_excel_serial.csv", 1080, "2026-03-01T08:00:00Z"},
                             {"c05c_thousands_few.csv", 1080, "gyro: 1080 values, 995 to 1001"},
                             {"c06_german.csv", 1080, "2 h 59 min 50 s"},
                             {"c06_two_cols.csv", 1080, "2 h 59 min 50 s"},
                             {"c09_wrap.csv", 8000, "2 h 13 min 19 s"},
                             {"c10_dup_header.csv", 1080, "TempT: 1080 values"},
                             {"c11a_torn_fields.csv", 1080, "1 line cannot be read"},
                             {"c11b_torn_number.csv", 1079, "it has no line end"},
                             {"c14_degF.csv", 1080, "T1: 1080 values, 4.96056 to 35.0411 °C"},
                             {"c15_minutes.csv", 1080, "2 h 59 min 50 s"},
                             {"c22a_trailing_sep.csv", 1080, "2 h 59 min 50 s"},
                             {"c27_nul_tail.csv", 1080, "1 line cannot be read"},
                             {"c30_forward_glitch.csv", 1079, "2 h 59 min 50 s"},
                             {"c32_mdps.csv", 1080, "imu.z: 1080 values, 3544.03 to 3619.65 °/h"},
                             {"c34_time_10s.csv", 1080, "2 h 59 min 50 s"},
                             {"f_gz.csv.gz", 1080, "2 h 59 min 50 s"},
                             {"px4_default_topics.ulg", 900, "imu1.x: 900 values"},
                             {"px4_unpublished_flow.ulg", 600, "imu.x: 600 values"},
                             {"px4_stamps_since_1970.ulg", 600, "2026-03-01T08:00:0"},
                             {"px4_bad_sector.ulg", 1494, "not messages and were skipped"}}) {
    SCOPED_TRACE(trial.file);
    const std::string map = folder / (std::string(trial.file) + ".toml"),
                      out = folder / (std::string(trial.file) + ".db");
    ASSERT_EQ(gyrotherm_with("import --guess " + trials + trial.file + " --out " + map).exit_code, 0);
    const auto imported = gyrotherm_with("import " + trials + trial.file + " --map " + map + " --out " + out);
    ASSERT_EQ(imported.exit_code, 0) << imported.err;
    EXPECT_NE(imported.err.find(fmt::format("{} rows over", trial.rows)), std::string::npos) << imported.err;
    EXPECT_NE(imported.err.find(trial.said), std::string::npos) << imported.err;
    ++seen;
  }
  EXPECT_EQ(seen, 21u);
  EXPECT_NE(gyrotherm_with("import --guess " + trials + "f_log.zip").err.find("unpack it first"), std::string::npos);
  const auto overload = gyrotherm_with("import " + trials + "s13a_9.9e37.csv --map " + trials +
                                       "s13a_9.9e37.toml --out " + (folder / "o.db"));
  EXPECT_EQ(overload.exit_code, 4);
  EXPECT_NE(overload.err.find("overload"), std::string::npos) << overload.err;
}

/// Imports a file of a public report with its map.
Ran import_report(const std::string& file, const std::string& map, const std::string& out) {
  const auto trials = public_reports();
  return gyrotherm_with("import " + trials + file + " --map " + trials + map + " --out " + out);
}

TEST(ForeignWay, AcceptsMapsOfPublicReports) {
  if (public_reports().empty()) GTEST_SKIP() << "trials/files is not in GYROTHERM_SHARED";
  const Folder folder;
  const auto masked = import_report("n_valid_range.nc", "maps_nc.toml", folder / "n.db");
  EXPECT_NE(masked.err.find("T1: 1069 values, 5 to 35 °C, 11 missing"), std::string::npos) << masked.err;

  const auto pulses = import_report("c07b_dup_stamps_jitter.csv", "incr.toml", folder / "p.db");
  ASSERT_EQ(pulses.exit_code, 0) << pulses.err;
  const auto record = record::read_record(folder / "p.db");
  ASSERT_TRUE(record);
  double all = 0;
  for (const double number : record->units.at(0).rotation.at(0)) all += number;
  EXPECT_NEAR(all, 9029.5358, 1e-6) << "equals the sum of the file's own column";

  ASSERT_EQ(import_report("s0_good.csv", "s0e.toml", folder / "t.db").exit_code, 0);
  train(folder, folder / "t.db", "");
  ASSERT_EQ(gyrotherm_with("export " + (folder / "t.db") + " --out " + (folder / "t.csv")).exit_code, 0);
  const auto compensated = gyrotherm_with("compensate " + (folder / "m.json") + " < " + (folder / "t.csv"));
  EXPECT_NE(compensated.err.find("these rows are 10 s apart"), std::string::npos) << compensated.err;

  ASSERT_EQ(import_report("s7_spikes.csv", "s7_spikes.toml", folder / "s.db").exit_code, 0);
  EXPECT_NE(train(folder, folder / "s.db", "").find("20 samples of the bias are outliers"), std::string::npos);
  EXPECT_NE(train(folder, folder / "s.db", "--outliers leave-out").find("rmse 0.015"), std::string::npos);

  ASSERT_EQ(import_report("s12_step.csv", "s12_step.toml", folder / "c.db").exit_code, 0);
  const auto refused = train(folder, folder / "c.db", "");
  EXPECT_NE(refused.find("without fold 4 of 4"), std::string::npos) << refused;
}

}  // namespace
}  // namespace gyrotherm::app
