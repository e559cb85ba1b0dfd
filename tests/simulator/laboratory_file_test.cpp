// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/file.hpp"
#include "core/toml_reader.hpp"
#include "tests/simulator/shipped_rigs.hpp"

namespace gyrotherm::simulator {
namespace {

/// A shipped rig file with one piece of its text replaced.
Result<LaboratoryParameters> rig_with(const std::string& rig, const std::string& piece,
                                      const std::string& replacement) {
  auto text = rig_text(rig);
  const auto at = text.find(piece);
  EXPECT_NE(at, std::string::npos) << piece;
  return parse_laboratory(text.replace(at, piece.size(), replacement), "rig.toml", "");
}

Result<LaboratoryParameters> file_with(const std::string& piece, const std::string& replacement) {
  return rig_with("virtual-reference", piece, replacement);
}

void expect_mistake(const Result<LaboratoryParameters>& laboratory, const std::string& what,
                    const std::string& where = "rig.toml:") {
  ASSERT_FALSE(laboratory);
  EXPECT_EQ(laboratory.error().kind, FaultKind::bad_file);
  EXPECT_TRUE(laboratory.error().where.starts_with(where)) << laboratory.error().where;
  EXPECT_NE(laboratory.error().what.find(what), std::string::npos) << laboratory.error().what;
}

TEST(LaboratoryFile, OfEveryReferenceRigIsRead) {
  for (const char* name : {"virtual-reference", "virtual-gradients"}) {
    const auto laboratory = parse_laboratory(rig_text(name), name);
    ASSERT_TRUE(laboratory) << text(laboratory.error());
    const auto& gyro = std::get<LumpedGyroParameters>(laboratory->body);
    EXPECT_EQ(gyro.network.nodes.size(), 11U);
    EXPECT_EQ(gyro.network.links.size(), 13U);
  }
}

TEST(LaboratoryFile, OfTheDefaultRigStandsOnTheTwin) {
  const auto gyro = reduced_of_rig("virtual");
  EXPECT_GT(gyro.model.conduction.rows(), 0);
  EXPECT_EQ(gyro.film, thermal::GyroFilm::chamber);
  EXPECT_EQ(gyro.bias.mode_hops.kelvin_per_mode, 0) << "off by default";
}

TEST(LaboratoryFile, FindsTheGyroBesideItsRig) {
  const auto used = gyro_model_of(rig_text("virtual"), rig_path("virtual"));
  ASSERT_TRUE(used) << text(used.error());
  EXPECT_EQ(used->name, "calibrated");
  EXPECT_EQ(used->film, "chamber");
  EXPECT_EQ(used->text, read_text_file(GYROTHERM_SOURCE_DIR "/profiles/gyros/calibrated.reduced.toml").value());
}

TEST(LaboratoryFile, TheRecordsCopyOfTheGyroIsEnough) {
  const auto gyro = gyro_model_of(rig_text("virtual"), rig_path("virtual"))->text;
  EXPECT_TRUE(parse_laboratory(rig_text("virtual"), "elsewhere/rig.toml", gyro));
}

TEST(LaboratoryFile, NamesAGyroThatIsNotThere) {
  const auto laboratory = parse_laboratory(rig_text("virtual"), "elsewhere/rig.toml");
  expect_mistake(laboratory, "calibrated.reduced.toml", "elsewhere/rig.toml:");
}

TEST(LaboratoryFile, OfTheReferenceNamesNoGyro) {
  const auto used = gyro_model_of(rig_text("virtual-reference"), "elsewhere/rig.toml");
  ASSERT_TRUE(used);
  EXPECT_EQ(used->name + used->film + used->text, "");
}

TEST(LaboratoryFile, TakesOneNumberForAllThermometersOrOneForEach) {
  const auto all = file_with("\nnoise_k = 0.01 ", "\nnoise_k = 0.02 ");
  const auto each = file_with("\nnoise_k = 0.01 ", "\nnoise_k = [0, 1, 2, 3, 4, 5, 6, 7, 8] ");
  ASSERT_TRUE(all) << text(all.error());
  ASSERT_TRUE(each) << text(each.error());
  for (std::size_t i = 0; i < 9; ++i) {
    EXPECT_EQ(all->thermometers.noise_k[i], 0.02);
    EXPECT_EQ(each->thermometers.noise_k[i], static_cast<double>(i));
  }
  expect_mistake(file_with("\nnoise_k = 0.01 ", "\nnoise_k = [0, 1] "), "expected 9");
  expect_mistake(file_with("\nnoise_k = 0.01 ", "\nnoise_k = -1 "), "at least 0");
}

TEST(LaboratoryFile, NamesABodyThatItDoesNotKnow) {
  expect_mistake(file_with("body = \"reference\"", "body = \"referenc\""), "reference");
}
TEST(LaboratoryFile, NamesAFilmThatItDoesNotKnow) {
  expect_mistake(rig_with("virtual", "film = \"chamber\"", "film = \"stil\""), "still");
}
TEST(LaboratoryFile, NamesAModeHopThatWouldNeverEnd) {
  expect_mistake(rig_with("virtual", "reach_modes = 1.5", "reach_modes = 0.4"), "half mode");
}

TEST(LaboratoryFile, NamesHeatAndDeadBandBeyondTheirLimits) {
  expect_mistake(rig_with("virtual-hard", "heating = 0.1 ", "heating = 0.5 "), "-0.45 to 0.45");
  expect_mistake(rig_with("virtual-hard", "share = 0.19 ", "share = 1.9 "), "more than all of it");
  expect_mistake(rig_with("virtual-hard", "split_per_k = 3e-4 ", "split_per_k = -3e-2 "), "-0.01 to 0.01");
  expect_mistake(rig_with("virtual-hard", "half_width_deg_per_h = 0.2", "half_width_deg_per_h = -0.2"), "below 0");
  expect_mistake(rig_with("virtual-hard", "sags_below = \"0 °C\"", "sags_below = \"-40 °C\""), "above -40");
}

TEST(LaboratoryFile, HasTheEarthRateOfItsRigsGeometry) {
  for (const char* name : {"virtual", "virtual-reference", "virtual-gradients"}) {
    const auto gyro = TomlTable::parse(rig_text(name), name)->table("gyro");
    const auto radians = [&](const char* key) { return gyro.number(key) * std::numbers::pi / 180; };
    const double latitude = radians("latitude");
    const double elevation = radians("elevation");
    const double along_axis = std::cos(latitude) * std::cos(radians("azimuth")) * std::cos(elevation) +
                              std::sin(latitude) * std::sin(elevation);
    const auto laboratory = laboratory_of_rig(name);
    EXPECT_NEAR(laboratory.gyro.earth_rate_deg_per_h, 15.041067 * along_axis, 1e-6);
    EXPECT_EQ(laboratory.gyro.arcsec_per_pulse, gyro.number("arcsec_per_pulse"));
  }
}

TEST(LaboratoryFile, DescribesAFrameThatCarriesItsGyro) {
  const auto root = TomlTable::parse(rig_text("virtual"), "virtual");
  const auto format = drivers::read_frame_format(root->table("gyro").table("frame"));
  EXPECT_EQ(format.length, 16U);
  ASSERT_NE(format.find(drivers::FieldRole::pulse_count), nullptr);
  ASSERT_NE(format.find(drivers::FieldRole::timestamp), nullptr);
  EXPECT_EQ(format.check.kind, drivers::CheckKind::crc);
  EXPECT_EQ(format.check.model.width, 16);
}

TEST(LaboratoryFile, NamesAMissingTable) {
  expect_mistake(parse_laboratory("name = \"real\"", "rig.toml"), "[virtual]");
}
TEST(LaboratoryFile, NamesAnUnknownKey) {
  expect_mistake(file_with("integral_time_s", "integral_tim_s"), "integral_time_s");
}
TEST(LaboratoryFile, NamesANumberThatMustBePositive) {
  expect_mistake(file_with("wave_period_k = 55", "wave_period_k = 0"), "above 0");
}
TEST(LaboratoryFile, NamesATimeConstantBelowTheStep) {
  expect_mistake(file_with("actuator_s = 3", "actuator_s = 0.5"), "step of 1 s");
}
TEST(LaboratoryFile, NamesAListOfTheWrongLength) {
  expect_mistake(file_with("[114.5,  122.3,", "[122.3,"), "10 numbers, expected 11");
}
TEST(LaboratoryFile, NamesALinkToAStrangeNode) {
  expect_mistake(file_with("\"hub\", \"base\"]\n", "\"hub\", \"bas\"]\n"), "\"bas\"");
}
TEST(LaboratoryFile, NamesANodeTooLightForTheStep) { expect_mistake(file_with("[114.5,", "[0.1,"), "node \"A\""); }
TEST(LaboratoryFile, NamesANodeWithoutAWayToTheChamber) {
  expect_mistake(file_with("1.2,    1.0]", "0,      0]"), "no way to the chamber");
}

}  // namespace
}  // namespace gyrotherm::simulator
