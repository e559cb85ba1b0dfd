// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "core/file.hpp"
#include "core/toml_reader.hpp"
#include "tests/simulator/shipped_rigs.hpp"

namespace gyrotherm::simulator {
namespace {

/// Returns a shipped rig with one part of its text replaced.
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

TEST(LaboratoryFile, ReadsEveryReferenceRig) {
  for (const char* name : {"virtual-reference", "virtual-gradients"}) {
    const auto laboratory = parse_laboratory(rig_text(name), name);
    ASSERT_TRUE(laboratory) << text(laboratory.error());
    const auto& gyro = std::get<LumpedGyroParameters>(laboratory->body);
    EXPECT_EQ(gyro.network.nodes.size(), 11U);
    EXPECT_EQ(gyro.network.links.size(), 13U);
  }
}

TEST(LaboratoryFile, UsesTwinForDefaultRig) {
  const auto gyro = reduced_of_rig("virtual");
  EXPECT_GT(gyro.model.conduction.rows(), 0);
  EXPECT_EQ(gyro.film, thermal::GyroFilm::chamber);
  EXPECT_EQ(gyro.bias.mode_hops.kelvin_per_mode, 0) << "off by default";
}

TEST(LaboratoryFile, FindsGyroNextToRig) {
  const auto used = find_gyro_model(rig_text("virtual"), rig_path("virtual"));
  ASSERT_TRUE(used) << text(used.error());
  EXPECT_EQ(used->name, "calibrated");
  EXPECT_EQ(used->film, "chamber");
  EXPECT_EQ(used->text, read_text_file(GYROTHERM_SOURCE_DIR "/profiles/gyros/calibrated.reduced.toml").value());
}

TEST(LaboratoryFile, AcceptsGyroFromRecord) {
  const auto gyro = find_gyro_model(rig_text("virtual"), rig_path("virtual"))->text;
  EXPECT_TRUE(parse_laboratory(rig_text("virtual"), "elsewhere/rig.toml", gyro));
}

TEST(LaboratoryFile, ReportsMissingGyro) {
  const auto laboratory = parse_laboratory(rig_text("virtual"), "elsewhere/rig.toml");
  expect_mistake(laboratory, "calibrated.reduced.toml", "elsewhere/rig.toml:");
}

TEST(LaboratoryFile, NeedsNoGyroForReferenceRig) {
  const auto used = find_gyro_model(rig_text("virtual-reference"), "elsewhere/rig.toml");
  ASSERT_TRUE(used);
  EXPECT_EQ(used->name + used->film + used->text, "");
}

TEST(LaboratoryFile, ReadsOneNumberOrOnePerThermometer) {
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

TEST(LaboratoryFile, ReportsUnknownBody) {
  expect_mistake(file_with("body = \"reference\"", "body = \"referenc\""), "reference");
}
TEST(LaboratoryFile, ReportsUnknownFilm) {
  expect_mistake(rig_with("virtual", "film = \"chamber\"", "film = \"stil\""), "still");
}
TEST(LaboratoryFile, ReportsEndlessModeHop) {
  expect_mistake(rig_with("virtual", "reach_modes = 1.5", "reach_modes = 0.4"), "half mode");
}

TEST(LaboratoryFile, ReportsHeatAndDeadBandOutsideLimits) {
  expect_mistake(rig_with("virtual-hard", "heating = 0.1 ", "heating = 0.5 "), "-0.45 to 0.45");
  expect_mistake(rig_with("virtual-hard", "share = 0.19 ", "share = 1.9 "), "expected at most 1");
  expect_mistake(rig_with("virtual-hard", "split_per_k = 3e-4 ", "split_per_k = -3e-2 "), "-0.01 to 0.01");
  expect_mistake(rig_with("virtual-hard", "half_width_deg_per_h = 0.2", "half_width_deg_per_h = -0.2"), "below 0");
  expect_mistake(rig_with("virtual-hard", "sags_below = \"0 °C\"", "sags_below = \"-40 °C\""), "above -40");
}

TEST(LaboratoryFile, HasEarthRateOfRigGeometry) {
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

constexpr std::array kRigsOfUnits{"virtual-triad", "virtual-lot", "virtual-tetrad"};

using Vector = std::array<double, 3>;

Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Returns the axes x, y and z of the fixture in the coordinates north, west and up. The azimuth turns x to the east,
/// the elevation raises x, and the roll turns y and z about x.
std::array<Vector, 3> attitude_of(const TomlTable& fixture) {
  const auto radians = [&](const char* key) { return fixture.number(key) * std::numbers::pi / 180; };
  const double azimuth = radians("azimuth"), elevation = radians("elevation"), roll = radians("roll");
  const Vector x{std::cos(azimuth) * std::cos(elevation), -std::sin(azimuth) * std::cos(elevation),
                 std::sin(elevation)};
  const Vector level{std::sin(azimuth), std::cos(azimuth), 0};
  const Vector above = cross(x, level);
  Vector y, z;
  for (std::size_t i = 0; i < 3; ++i) {
    y[i] = std::cos(roll) * level[i] + std::sin(roll) * above[i];
    z[i] = std::cos(roll) * above[i] - std::sin(roll) * level[i];
  }
  return {x, y, z};
}

TEST(LaboratoryFile, HasEarthRateOfEachAxisInFixture) {
  for (const auto* name : kRigsOfUnits) {
    const auto root = TomlTable::parse(rig_text(name), name);
    const auto fixture = root->table("fixture");
    const auto attitude = attitude_of(fixture);
    const double latitude = fixture.number("latitude") * std::numbers::pi / 180;
    const auto laboratory = laboratory_of_rig(name);
    const auto gyros = root->tables("gyro");
    ASSERT_EQ(gyros.size(), laboratory.units.size());
    for (std::size_t u = 0; u < gyros.size(); ++u) {
      EXPECT_EQ(gyros[u].text("name"), laboratory.units[u].name);
      EXPECT_EQ(gyros[u].number("arcsec_per_pulse"), laboratory.gyro.arcsec_per_pulse);
      const auto axes = gyros[u].tables("axis");
      ASSERT_EQ(axes.size(), laboratory.units[u].axes.size());
      for (std::size_t a = 0; a < axes.size(); ++a) {
        EXPECT_EQ(axes[a].text("name", ""), laboratory.units[u].axes[a].name);
        const auto direction = axes[a].numbers("direction");
        double north = 0, up = 0, square = 0;
        for (std::size_t i = 0; i < 3; ++i) {
          north += direction.at(i) * attitude[i][0];
          up += direction[i] * attitude[i][2];
          square += direction[i] * direction[i];
        }
        EXPECT_NEAR(square, 1, 1e-12);
        EXPECT_NEAR(laboratory.units[u].axes[a].earth_rate_deg_per_h,
                    15.041067 * (north * std::cos(latitude) + up * std::sin(latitude)), 1e-6)
            << name << ' ' << u << ' ' << a;
      }
    }
  }
}

TEST(LaboratoryFile, MatchesInstrumentsToUnits) {
  for (const auto* name : kRigsOfUnits) {
    const auto started = VirtualInstruments::start(VirtualLaboratory(laboratory_of_rig(name), {}),
                                                   {.chamber = chamber_map("virtual"),
                                                    .thermometers = thermometers_of_rig(name),
                                                    .gyros = gyro_lines_of_rig(name)});
    EXPECT_TRUE(started) << text(started.error());
  }
}

TEST(LaboratoryFile, HasHopAndDeadThermometerOnlyForTetrad) {
  for (const auto* name : kRigsOfUnits) {
    int hops = 0, failing = 0;
    for (const auto& unit : laboratory_of_rig(name).units)
      for (const auto& axis : unit.axes) {
        hops += axis.hop ? 1 : 0;
        failing += static_cast<int>(axis.failing.size());
      }
    const int expected = name == std::string("virtual-tetrad") ? 1 : 0;
    EXPECT_EQ(hops, expected) << name;
    EXPECT_EQ(failing, expected) << name;
  }
}

TEST(LaboratoryFile, MatchesGyroFrame) {
  const auto root = TomlTable::parse(rig_text("virtual"), "virtual");
  const auto format = drivers::read_frame_format(root->table("gyro").table("frame"));
  EXPECT_EQ(format.length, 16U);
  ASSERT_NE(format.find(drivers::FieldRole::pulse_count), nullptr);
  ASSERT_NE(format.find(drivers::FieldRole::timestamp), nullptr);
  EXPECT_EQ(format.check.kind, drivers::CheckKind::crc);
  EXPECT_EQ(format.check.model.width, 16);
}

TEST(LaboratoryFile, ReportsMissingTable) {
  expect_mistake(parse_laboratory("name = \"real\"", "rig.toml"), "[virtual]");
}
TEST(LaboratoryFile, ReportsUnknownKey) {
  expect_mistake(file_with("integral_time_s", "integral_tim_s"), "integral_time_s");
}
TEST(LaboratoryFile, ReportsNumberThatIsNotPositive) {
  expect_mistake(file_with("wave_period_k = 55", "wave_period_k = 0"), "above 0");
}
TEST(LaboratoryFile, ReportsTimeConstantBelowStep) {
  expect_mistake(file_with("actuator_s = 3", "actuator_s = 0.5"), "expected at least 1 s");
}
TEST(LaboratoryFile, ReportsListOfWrongLength) {
  expect_mistake(file_with("[114.5,  122.3,", "[122.3,"), "10 numbers, expected 11");
}
TEST(LaboratoryFile, ReportsLinkToUnknownNode) {
  expect_mistake(file_with("\"hub\", \"base\"]\n", "\"hub\", \"bas\"]\n"), "\"bas\"");
}
TEST(LaboratoryFile, ReportsNodeTooLightForStep) { expect_mistake(file_with("[114.5,", "[0.1,"), "node \"A\""); }
TEST(LaboratoryFile, ReportsIsolatedNode) {
  expect_mistake(file_with("1.2,    1.0]", "0,      0]"), "no path to the chamber");
}

constexpr const char* kUnits = R"(
[[virtual.unit]]
name = "u1"
[[virtual.unit.axis]]
name = "x"
earth_rate_deg_per_h = 10
[[virtual.unit.axis]]
name = "y"
earth_rate_deg_per_h = -5
crosswise_earth_rate_deg_per_h = 3
hop = { at = "10 h", deg_per_h = 0.004, for = "1 h" }
[[virtual.unit]]
name = "u2"
[[virtual.unit.axis]]
earth_rate_deg_per_h = 1
[[virtual.bracket]]
units = ["u2", "u1"]
share = 0.2
time_constant_s = 900
[virtual.own_temperature]
time_constant_s = 30
noise_k = 0.02
[[virtual.value]]
name = "discharge_current_a"
at_20_c = 1e-3
per_k = 1e-7
[[virtual.thermometers.failing]]
channel = "u1.y.C"
how = "dead"
from = "5 h"
)";

/// Returns the default rig with units, and with one part of its text replaced.
Result<LaboratoryParameters> units_with(const std::string& piece = "", const std::string& replacement = "") {
  auto text = rig_text("virtual");
  const auto earth = text.find("earth_rate_deg_per_h");
  text.erase(earth, text.find('\n', earth) - earth);
  std::string units = kUnits;
  const auto at = units.find(piece);
  EXPECT_NE(at, std::string::npos) << piece;
  text += units.replace(at, piece.size(), replacement);
  const auto gyro = find_gyro_model(rig_text("virtual"), rig_path("virtual"))->text;
  return parse_laboratory(text, "rig.toml", gyro);
}

TEST(LaboratoryFile, ReadsUnitsAndBrackets) {
  const auto laboratory = units_with();
  ASSERT_TRUE(laboratory) << text(laboratory.error());
  ASSERT_EQ(laboratory->units.size(), 2U);
  const auto& y = laboratory->units[0].axes.at(1);
  EXPECT_EQ(y.name, "y");
  EXPECT_EQ(y.earth_rate_deg_per_h, -5);
  EXPECT_EQ(y.crosswise_earth_rate_deg_per_h, 3);
  EXPECT_EQ(y.hop->at_s, 36000);
  EXPECT_EQ(y.hop->for_s, 3600);
  ASSERT_EQ(y.failing.size(), 1U);
  EXPECT_EQ(y.failing[0].index, 2U);
  EXPECT_EQ(y.failing[0].mode, FailureMode::dead);
  EXPECT_TRUE(laboratory->thermometers.failing.empty());
  EXPECT_EQ(laboratory->units[1].axes.at(0).name, "");
  EXPECT_EQ(laboratory->brackets.at(0).units, (std::vector<std::size_t>{1, 0}));
  EXPECT_EQ(laboratory->own_temperature->resolution_k, 0);
  EXPECT_EQ(laboratory->values.at(0).name, "discharge_current_a");
}

TEST(LaboratoryFile, ReportsErrorsOfUnits) {
  expect_mistake(units_with("\"u2\"\n[[", "\"u1\"\n[["), "twice");
  expect_mistake(units_with("\"u1\"", "\"u.1\""), "without dots");
  expect_mistake(units_with("\"y\"", "\"x\""), "twice");
  expect_mistake(units_with("name = \"y\"", ""), "name");
  expect_mistake(units_with("[[virtual.unit.axis]]\nearth_rate_deg_per_h = 1\n", ""), "no axis");
  expect_mistake(units_with("earth_rate_deg_per_h = 10", ""), "earth_rate_deg_per_h");
  expect_mistake(units_with("[\"u2\", \"u1\"]", "[\"u2\", \"u3\"]"), "\"u3\" is not one of the units u1, u2");
  expect_mistake(units_with("[\"u2\", \"u1\"]", "[\"u2\", \"u2\"]"), "is already on a bracket");
  expect_mistake(units_with("share = 0.2", "share = 0.95"), "at most 0.9");
  expect_mistake(units_with("discharge_current_a", "self"), "twice");
  expect_mistake(units_with("u1.y.C", "C"), "u1.x.A");
}

/// The key is an error, because it would have no effect.
TEST(LaboratoryFile, RefusesEarthRateInTypeOfUnits) {
  expect_mistake(rig_with("virtual-triad", "[virtual.gyro]", "[virtual.gyro]\nearth_rate_deg_per_h = 10"),
                 "earth_rate_deg_per_h");
}

}  // namespace
}  // namespace gyrotherm::simulator
