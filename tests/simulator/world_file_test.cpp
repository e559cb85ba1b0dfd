#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/toml_reader.hpp"
#include "tests/simulator/laboratory.hpp"

namespace gyrotherm {
namespace {

/// The shipped rig with one piece of its text replaced.
Result<WorldParameters> with(const std::string& piece, const std::string& replacement) {
  auto text = rig_text("virtual");
  const auto at = text.find(piece);
  EXPECT_NE(at, std::string::npos) << piece;
  return parse_world(text.replace(at, piece.size(), replacement), "rig.toml");
}

void expect_mistake(const Result<WorldParameters>& world, const std::string& what) {
  ASSERT_FALSE(world);
  EXPECT_EQ(world.error().kind, FaultKind::bad_file);
  EXPECT_TRUE(world.error().where.starts_with("rig.toml:")) << world.error().where;
  EXPECT_NE(world.error().what.find(what), std::string::npos) << world.error().what;
}

TEST(WorldFile, OfEveryShippedRigIsRead) {
  for (const char* name : {"virtual", "virtual-gradients"}) {
    const auto world = parse_world(rig_text(name), name);
    ASSERT_TRUE(world) << text(world.error());
    EXPECT_EQ(world->network.nodes.size(), 11U);
    EXPECT_EQ(world->network.links.size(), 13U);
  }
}

TEST(WorldFile, HasTheEarthRateOfItsRigsGeometry) {
  for (const char* name : {"virtual", "virtual-gradients"}) {
    const auto gyro = TomlTable::parse(rig_text(name), name)->table("gyro");
    const auto radians = [&](const char* key) { return gyro.number(key) * std::numbers::pi / 180; };
    const double latitude = radians("latitude");
    const double elevation = radians("elevation");
    const double along_axis = std::cos(latitude) * std::cos(radians("azimuth")) * std::cos(elevation) +
                              std::sin(latitude) * std::sin(elevation);
    const auto world = world_of_rig(name);
    EXPECT_NEAR(world.gyro.earth_rate_deg_per_h, 15.041067 * along_axis, 1e-6);
    EXPECT_EQ(world.gyro.arcsec_per_pulse, gyro.number("arcsec_per_pulse"));
  }
}

TEST(WorldFile, DescribesAFrameThatCarriesItsGyro) {
  const auto root = TomlTable::parse(rig_text("virtual"), "virtual");
  const auto format = read_frame_format(root->table("gyro").table("frame"));
  EXPECT_EQ(format.length, 16U);
  ASSERT_NE(format.find(FieldRole::pulse_count), nullptr);
  ASSERT_NE(format.find(FieldRole::timestamp), nullptr);
  EXPECT_EQ(format.check.kind, CheckKind::crc16);
}

TEST(WorldFile, NamesAMissingTable) { expect_mistake(parse_world("name = \"real\"", "rig.toml"), "[virtual]"); }
TEST(WorldFile, NamesAnUnknownKey) { expect_mistake(with("integral_time_s", "integral_tim_s"), "integral_time_s"); }
TEST(WorldFile, NamesANumberThatMustBePositive) {
  expect_mistake(with("wave_period_k = 55", "wave_period_k = 0"), "above 0");
}
TEST(WorldFile, NamesATimeConstantBelowTheStep) {
  expect_mistake(with("actuator_s = 3", "actuator_s = 0.5"), "step of 1 s");
}
TEST(WorldFile, NamesAListOfTheWrongLength) {
  expect_mistake(with("[114.5,  122.3,", "[122.3,"), "10 numbers, expected 11");
}
TEST(WorldFile, NamesALinkToAStrangeNode) {
  expect_mistake(with("\"hub\", \"base\"]\n", "\"hub\", \"bas\"]\n"), "\"bas\"");
}
TEST(WorldFile, NamesANodeTooLightForTheStep) { expect_mistake(with("[114.5,", "[0.1,"), "node \"A\""); }
TEST(WorldFile, NamesANodeWithoutAWayToTheChamber) {
  expect_mistake(with("1.2,    1.0]", "0,      0]"), "no way to the chamber");
}

}  // namespace
}  // namespace gyrotherm
