#include "rig/rig_file.hpp"

#include <gtest/gtest.h>

#include "core/text_file.hpp"

namespace gyrotherm {
namespace {

const std::string kRigs = GYROTHERM_SOURCE_DIR "/profiles/rigs/";

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  const auto at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), with);
}

std::string virtual_rig() { return read_text_file(kRigs + "virtual.toml").value(); }

/// The fault of a rig file at the place of the shipped one.
std::string mistake_in(const std::string& text) {
  const auto rig = parse_rig(text, kRigs + "virtual.toml");
  return rig ? "" : rig.error().what;
}

TEST(RigFile, ShippedRigsAreWholeAndSimulated) {
  for (const auto* name : {"virtual.toml", "virtual-reference.toml", "virtual-gradients.toml"}) {
    const auto rig = read_rig(kRigs + name);
    ASSERT_TRUE(rig) << text(rig.error());
    EXPECT_TRUE(rig->simulated);
    EXPECT_EQ(channels_of(*rig).size(), 9u);
    EXPECT_EQ(rig->gradients.size(), 8u);
    EXPECT_EQ(rig->three_point, (std::vector<std::string>{"A", "D", "shell"}));
  }
}

TEST(RigFile, EarthRateIsProjectedOnTheInputAxis) {
  const auto rig = read_rig(kRigs + "virtual.toml");
  ASSERT_TRUE(rig) << text(rig.error());
  ASSERT_TRUE(rig->gyro.earth_rate);
  EXPECT_GT(rig->gyro.earth_rate->value, 0);
  EXPECT_LT(rig->gyro.earth_rate->value, 15.0411);
}

TEST(RigFile, AMisspeltKeyIsAMistakeWithItsPlaceAndAGuess) {
  const auto rig = parse_rig(replaced(virtual_rig(), "safe_set_point", "save_set_point"), kRigs + "virtual.toml");
  ASSERT_FALSE(rig);
  EXPECT_EQ(rig.error().kind, FaultKind::bad_file);
  EXPECT_NE(rig.error().where.find("virtual.toml:"), std::string::npos);
  EXPECT_NE(rig.error().what.find("safe_set_point"), std::string::npos);
}

TEST(RigFile, ARigIsWhollyVirtualOrWhollyReal) {
  EXPECT_NE(
      mistake_in(replaced(virtual_rig(), "line = \"virtual\"", "line = \"tcp://192.168.1.20:502\"")).find("wholly"),
      std::string::npos);
}

TEST(RigFile, ALineMustBeAnAddress) {
  EXPECT_NE(mistake_in(replaced(virtual_rig(), "line = \"virtual\"", "line = \"COM3\"")), "");
}

TEST(RigFile, ThreePointNamesMustBeChannels) {
  EXPECT_NE(mistake_in(replaced(virtual_rig(), "\"D\", \"shell\"]", "\"D\", \"shall\"]")).find("shall"),
            std::string::npos);
}

TEST(RigFile, AMissingRegisterMapIsNamed) {
  const auto rig =
      parse_rig(replaced(virtual_rig(), "chambers/virtual.toml", "chambers/none.toml"), kRigs + "virtual.toml");
  ASSERT_FALSE(rig);
  EXPECT_NE(rig.error().what.find("none.toml"), std::string::npos);
}

TEST(RigFile, ALimitThatWouldEndEveryRunIsAMistake) {
  for (const auto* line :
       {"confirming_samples = 0", "suspend_after = \"0 s\"", "gyro_lost = \"0 s\"", "air_lowest = 200"})
    EXPECT_NE(mistake_in(replaced(virtual_rig(), "[limits]\n", "[limits]\n" + std::string(line) + "\n")), "") << line;
}

TEST(RigFile, TheRecordsCopiesOfTheFilesItNamesAreEnough) {
  const auto map = read_text_file(GYROTHERM_SOURCE_DIR "/profiles/chambers/virtual.toml").value();
  const auto gyro = read_text_file(GYROTHERM_SOURCE_DIR "/profiles/gyros/calibrated.reduced.toml").value();
  const auto rig = parse_rig(virtual_rig(), "elsewhere/rig.toml", {.chamber_map = map, .gyro_model = gyro});
  ASSERT_TRUE(rig) << text(rig.error());
  EXPECT_EQ(rig->gyro_model.text, gyro);
  EXPECT_FALSE(parse_rig(virtual_rig(), "elsewhere/rig.toml", {.chamber_map = map, .gyro_model = {}}));
}

TEST(RigFile, AMissingGyroModelIsNamed) {
  const auto rig = parse_rig(replaced(virtual_rig(), "gyros/calibrated", "gyros/none"), kRigs + "virtual.toml");
  ASSERT_FALSE(rig);
  EXPECT_EQ(rig.error().kind, FaultKind::bad_file);
  EXPECT_NE(rig.error().where.find("virtual.toml:"), std::string::npos);
  EXPECT_NE(rig.error().what.find("none.reduced.toml"), std::string::npos);
}

}  // namespace
}  // namespace gyrotherm
