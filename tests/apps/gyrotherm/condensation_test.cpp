// SPDX-License-Identifier: Apache-2.0
/// Humidity, warm-ups and warnings of condensation, as a user sees them.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <regex>

#include "acquisition/record/record.hpp"
#include "core/file.hpp"
#include "tests/apps/gyrotherm/program.hpp"

namespace gyrotherm::app {
namespace {

class CondensationTest : public testing::Test {
 protected:
  /// Writes the virtual rig with a humidity sensor and these tables.
  std::string rig(const std::string& tables, const std::string& map = "virtual_climate") {
    auto text = read_text_file(GYROTHERM_SOURCE_DIR "/profiles/rigs/virtual.toml").value();
    text = std::regex_replace(text, std::regex("\\.\\./chambers/virtual.toml\""),
                              "../chambers/" + map + ".toml\"\nhumidity = true");
    text = std::regex_replace(text, std::regex("\"\\.\\./"), "\"" GYROTHERM_SOURCE_DIR "/profiles/");
    const auto path = folder_ / "rig.toml";
    std::ofstream(path) << text << tables;
    return path;
  }
  /// Writes a profile that ends at -20 °C.
  std::string profile(const std::string& more = "") {
    const auto path = folder_ / "cold.toml";
    std::ofstream(path) << "schema = \"gyrotherm-profile/1\"\nname = \"cold\"\n"
                        << more << "[[segment]]\nkind = \"hold\"\nat = 20\ntime = \"10 min\"\n"
                        << "[[segment]]\nkind = \"ramp\"\nto = -20\nrate = 5\n"
                        << "[[segment]]\nkind = \"hold\"\ntime = \"1 h\"\n";
    return path;
  }
  Folder folder_;
};

TEST_F(CondensationTest, CheckListsWarmUp) {
  const auto checked = gyrotherm_with("check " + profile() + " --rig " + rig("\n[room]\n"));
  ASSERT_EQ(checked.exit_code, 0) << checked.err;
  EXPECT_NE(checked.out.find("warm-up to 25 °C"), std::string::npos) << checked.out;
  EXPECT_NE(checked.out.find("coldest thermometer at 16.8 °C or more"), std::string::npos) << checked.out;
  EXPECT_NE(checked.out.find("room: dew point 14.8 °C"), std::string::npos) << checked.out;
  EXPECT_NE(checked.out.find("humidity and dew point of the chamber are recorded"), std::string::npos);
  const auto without = gyrotherm_with("check " + profile() + " --rig virtual");
  EXPECT_EQ(without.out.find("warm-up"), std::string::npos) << "no person opens the door of a virtual rig";
  const auto real = gyrotherm_with("check " + profile() + " --rig example-f4t-lakeshore-kvh");
  EXPECT_NE(real.out.find("warm-up to 25 °C"), std::string::npos) << real.out << real.err;
}

TEST_F(CondensationTest, RunRecordsHumidityAndEndsWarm) {
  const auto record = folder_ / "run.db";
  const auto ran = gyrotherm_with("run " + profile() + " --quiet --rig " + rig("\n[room]\n") + " --out " + record);
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_EQ(ran.err.find("too cold"), std::string::npos) << ran.err;
  const auto kept = record::read_record(record);
  ASSERT_TRUE(kept) << text(kept.error());
  EXPECT_EQ(kept->info.segments.size(), 5u);
  for (const auto& thermometer : kept->thermometers_c) EXPECT_GT(thermometer.back(), 16);
  EXPECT_FALSE(std::isnan(kept->chamber_humidity_percent.back()));
  EXPECT_EQ(gyrotherm_with("export " + record + " --out " + (folder_ / "run.csv")).exit_code, 0);
  EXPECT_NE(read_text_file(folder_ / "run.csv").value().find("chamber dew point [°C]"), std::string::npos);
}

TEST_F(CondensationTest, RunWarnsAtColdEndWithoutWarmUp) {
  const auto record = folder_ / "run.db";
  const auto ran = gyrotherm_with("run " + profile("[condensation]\nwarm_up = false\n") + " --rig " +
                                  rig("\n[room]\ndew_point = \"9 °C\"\n") + " --out " + record);
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_NE((ran.out + ran.err).find("open the door only at 11.0 °C or more"), std::string::npos) << ran.err;
  const auto kept = record::read_record(record);
  ASSERT_TRUE(kept) << text(kept.error());
  EXPECT_EQ(kept->info.segments.size(), 3u);
}

TEST_F(CondensationTest, CheckRefusesWrongTables) {
  const auto error = [&](const std::string& tables, const std::string& map = "virtual_climate") {
    const auto checked = gyrotherm_with("check --rig " + rig(tables, map));
    EXPECT_EQ(checked.exit_code, 4) << tables;
    return checked.err;
  };
  EXPECT_NE(error("\n[room]\nhumidity_percent = 0\n").find("expected a humidity above 0"), std::string::npos);
  EXPECT_NE(error("\n[room]\ndew_point = 12\nhumidity_percent = 50\n").find("expected one of them"), std::string::npos);
  EXPECT_NE(error("\n[room]\nmargin = \"-1 K\"\n").find("expected 0 K or more"), std::string::npos);
  EXPECT_NE(error("", "virtual").find("the map has no item \"humidity\""), std::string::npos);
}

}  // namespace
}  // namespace gyrotherm::app
