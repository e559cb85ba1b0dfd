// SPDX-License-Identifier: Apache-2.0
/// Tests of all axes and all housekeeping of the shipped streams, with published frames, and with frames that were
/// computed independently (Python's struct).
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "drivers/gyro/framed_gyro.hpp"
#include "tests/drivers/gyro/decimal_lines.hpp"
#include "tests/drivers/gyro/virtual_gyro_frame.hpp"
#include "tests/support/fakes.hpp"
#include "tests/support/frame_streams.hpp"

namespace gyrotherm::drivers {
namespace {

const std::vector<std::string> kAxes{"x", "y", "z"};
constexpr double kAbsent = std::numeric_limits<double>::quiet_NaN();

void expect_housekeeping(const tests::DecodedStream& fed, std::size_t frame,
                         const std::map<std::string, double>& expected) {
  for (const auto& [name, value] : expected) {
    const double found = fed.housekeeping(name, frame);
    if (std::isnan(value))
      EXPECT_TRUE(std::isnan(found)) << name << " is " << found;
    else
      EXPECT_NEAR(found, value, 5e-8 * std::abs(value)) << name;
  }
}

void expect_axes(const tests::DecodedStream& fed, std::size_t frame, const std::vector<double>& expected) {
  const auto& axes = fed.frames.at(frame).axes;
  ASSERT_EQ(axes.size(), expected.size());
  for (std::size_t i = 0; i < axes.size(); ++i)
    EXPECT_NEAR(axes[i].value.value(), expected[i], 5e-8 * std::abs(expected[i])) << i;
}

std::string names_of(const std::string& stream) {
  std::string names;
  for (const auto& value : list_housekeeping(tests::whole_shipped_stream(stream).frame))
    names +=
        fmt::format("{}{}[{}]{}", names.empty() ? "" : " ", value.name, value.unit, value.is_temperature ? "T" : "");
  return names;
}

TEST(GyroHousekeeping, ListsValuesOfEachStream) {
  const std::string kvh = "acceleration_x[g] acceleration_y[g] acceleration_z[g] temperature[°C]T frames[1] flagged[1]";
  EXPECT_EQ(names_of("kvh-17xx-a"), kvh);
  EXPECT_EQ(names_of("kvh-17xx-b"), kvh);
  EXPECT_EQ(names_of("hg1700-rawimusx"), names_of("hg1700-rawimusxa"));
  EXPECT_EQ(names_of("hg1700-rawimusx"),
            "temperature[°C]T path_length_reset_x[1] path_length_reset_y[1] path_length_reset_z[1] velocity_x[m/s] "
            "velocity_y[m/s] velocity_z[m/s] frames[1] flagged[1]");
  EXPECT_EQ(names_of("vectornav"),
            "magnetic_x[gauss] magnetic_y[gauss] magnetic_z[gauss] temperature[°C]T pressure[kPa] delta_time[s] "
            "velocity_x[m/s] velocity_y[m/s] velocity_z[m/s] frames[1] flagged[1]");
  for (const auto* bare : {"pulse-count", "kvh-dsp-1750", "kvh-dsp-3000-ascii", "kvh-dsp-3000-binary"})
    EXPECT_EQ(names_of(bare), "") << bare;
}

TEST(GyroHousekeeping, IsTheSameWhicheverAxesAreAskedFor) {
  for (const auto& name : tests::shipped_streams()) {
    const auto own = tests::shipped_stream(name).frame, whole = tests::whole_shipped_stream(name).frame;
    EXPECT_EQ(list_housekeeping(own).size(), list_housekeeping(whole).size()) << name;
    EXPECT_EQ(own.axes.size(), 1u);
    EXPECT_EQ(own.gyros().size(), 1u);
    EXPECT_EQ(own.gyro(), own.gyros().front());
    EXPECT_EQ(whole.axes, whole.all_axes.empty() ? std::vector<std::string>{""} : kAxes) << name;
    ASSERT_EQ(whole.gyros().size(), whole.axes.size()) << name;
    for (std::size_t i = 0; i < whole.axes.size(); ++i) EXPECT_EQ(whole.gyros()[i]->axis, whole.axes[i]) << name;
  }
}

TEST(GyroHousekeeping, AxesComeInTheOrderAskedFor) {
  const auto format = tests::shipped_stream("kvh-17xx-a", {"z", "x"}).frame;
  const tests::DecodedStream fed(format,
                                 tests::from_hex("FE81FF55 37A96A6E 38586C1F B75BF862 BF803E78 BB650D28 3B0A37AC 77 3D "
                                                 "0028 4BFA34D8"));
  expect_axes(fed, 0, {-1.3111248e-5, 2.0195930e-5});
  EXPECT_EQ(fed.value("gyro_y"), static_cast<double>(5.1599109e-5f));
  EXPECT_TRUE(std::isnan(fed.housekeeping("gyro_y"))) << "an axis that was not asked for is no housekeeping";
}

/// The sample in the 1775's manual, and the same frame with accelerometer X marked invalid, which only flags it.
TEST(GyroHousekeeping, OfTheKvhImus) {
  auto bytes = tests::from_hex("FE81FF5537A96A6E38586C1FB75BF862BF803E78BB650D283B0A37AC773D00284BFA34D8");
  const auto flagged = tests::from_hex("FE81FF5537A96A6E38586C1FB75BF862BF803E78BB650D283B0A37AC673D0028BCEE197B");
  bytes.insert(bytes.end(), flagged.begin(), flagged.end());
  const tests::DecodedStream fed(tests::shipped_stream("kvh-17xx-a", kAxes).frame, bytes);
  ASSERT_EQ(fed.frames.size(), 2u);
  for (const std::size_t frame : {0u, 1u}) {
    expect_axes(fed, frame, {2.0195930e-5, 5.1599109e-5, -1.3111248e-5});
    expect_housekeeping(fed, frame,
                        {{"acceleration_x", -1.0019064},
                         {"acceleration_y", -0.0034950468},
                         {"acceleration_z", 0.0021090312},
                         {"temperature", 40}});
    EXPECT_TRUE(fed.frames[frame].good);
  }
  EXPECT_FALSE(fed.frames[0].flagged);
  EXPECT_TRUE(fed.frames[1].flagged);
}

TEST(GyroHousekeeping, ReadsKvhFormatCInTurn) {
  std::vector<std::byte> bytes;
  for (const auto* frame : {"FE81FF5737800000B80000003880000000000000000000003F80000041BC0000770833414C7B",
                            "FE81FF5737800000B80000003880000000000000000000003F8000003E80000077094034C31E",
                            "FE81FF5737800000B80000003880000000000000000000003F800000BF000000770AFE00D4D0",
                            "FE81FF5737800000B80000003880000000000000000000003F8000003E000000770B4422FECC"}) {
    const auto one = tests::from_hex(frame);
    bytes.insert(bytes.end(), one.begin(), one.end());
  }
  const tests::DecodedStream fed(tests::shipped_stream("kvh-17xx-c", kAxes).frame, bytes);
  ASSERT_EQ(fed.frames.size(), 4u);
  const std::pair<const char*, double> turns[] = {
      {"temperature", 23.5}, {"magnetic_x", 0.25}, {"magnetic_y", -0.5}, {"magnetic_z", 0.125}};
  for (std::size_t frame = 0; frame < 4; ++frame) {
    expect_axes(fed, frame, {0x1p-16, -0x1p-15, 0x1p-14});
    expect_housekeeping(fed, frame, {{"acceleration_z", 1}});
    for (std::size_t turn = 0; turn < 4; ++turn)
      expect_housekeeping(fed, frame, {{turns[turn].first, turn == frame ? turns[turn].second : kAbsent}});
  }
}

/// The published line of an AG58, with the increments of gravity in a hundredth of a second. The second line is the
/// same at -20 °C after a reset of Y's path-length control.
TEST(GyroHousekeeping, OfARingLaserGyro) {
  const std::string lines =
      "%RAWIMUSXA,1692,484620.664;00,11,1692,484620.664389000,00801503,43110635,-817242,-202184,-215194,-41188,-9895"
      "*a5db8c7b\r\n"
      "%RAWIMUSXA,1692,484620.664;00,11,1692,484620.664389000,0080EC43,43110635,-817242,-202184,-215194,-41188,-9895"
      "*0c63ba86\r\n";
  const tests::DecodedStream fed(tests::shipped_stream("hg1700-rawimusxa", kAxes).frame, tests::bytes_of(lines));
  ASSERT_EQ(fed.frames.size(), 2u);
  const double g =
      std::hypot(fed.housekeeping("velocity_x"), fed.housekeeping("velocity_y"), fed.housekeeping("velocity_z")) * 100;
  EXPECT_NEAR(g, 9.79, 0.01);
  expect_axes(fed, 0, {-9895 * 0x1p-33, 41188 * 0x1p-33, -215194 * 0x1p-33});
  expect_housekeeping(fed, 0,
                      {{"temperature", 21},
                       {"path_length_reset_y", 0},
                       {"velocity_x", -202184 * 0x1p-27 * 0.3048},
                       {"velocity_y", 817242 * 0x1p-27 * 0.3048},
                       {"velocity_z", 43110635 * 0x1p-27 * 0.3048}});
  EXPECT_FALSE(fed.frames[0].flagged);
  expect_housekeeping(
      fed, 1,
      {{"temperature", -20}, {"path_length_reset_x", 0}, {"path_length_reset_y", 1}, {"path_length_reset_z", 0}});
  EXPECT_TRUE(fed.frames[1].flagged);
  EXPECT_TRUE(fed.frames[1].good);
  EXPECT_EQ(fed.broken_rules[1], std::vector<std::string>{"the path-length control of Y was reset"});
}

/// Binary message with the same numbers.
TEST(GyroHousekeeping, OfARingLaserGyroInBinary) {
  const tests::DecodedStream fed(
      tests::shipped_stream("hg1700-rawimusx", kAxes).frame,
      tests::from_hex("AA441328B6059C0678B9E21C000B9C060B9755A832941D4103158000EBD09102A687F3FF38EAFC"
                      "FF66B7FCFF1C5FFFFF59D9FFFF475FAFBA"));
  ASSERT_EQ(fed.frames.size(), 1u);
  expect_axes(fed, 0, {-9895 * 0x1p-33, 41188 * 0x1p-33, -215194 * 0x1p-33});
  expect_housekeeping(fed, 0, {{"temperature", 21}, {"velocity_z", 43110635 * 0x1p-27 * 0.3048}});
}

TEST(GyroHousekeeping, OfTheStim300DependsOnItsMessage) {
  auto bytes = tests::from_hex(
      "AF004000FFE00000002800080000FC000002000000400000000000C00000401900F5C00080001A001B001C00001D001E001F000040000000"
      "1802BC598CE652");
  const auto small = tests::from_hex("94004000FFC000FFFF850014801482F5C0001001F463BD8987");
  bytes.insert(bytes.end(), small.begin(), small.end());
  const tests::DecodedStream fed(tests::shipped_stream("stim300", kAxes).frame, bytes);
  ASSERT_EQ(fed.frames.size(), 2u);
  expect_axes(fed, 0, {1, -0.5, 40.0 / 16384});
  expect_housekeeping(fed, 0,
                      {{"acceleration_x", 1},
                       {"acceleration_y", -0.5},
                       {"acceleration_z", 0.25},
                       {"inclination_x", 1},
                       {"inclination_z", -1},
                       {"temperature_x", 25},
                       {"temperature_y", -10.25},
                       {"temperature_z", 0.5},
                       {"accelerometer_temperature_x", 26},
                       {"accelerometer_temperature_z", 28},
                       {"inclinometer_temperature_x", 29},
                       {"inclinometer_temperature_z", 31},
                       {"auxiliary", 1.25},
                       {"latency_us", 700}});
  EXPECT_TRUE(fed.frames[0].good);
  EXPECT_TRUE(fed.frames[0].flagged) << "an inclinometer is starting up";
  expect_axes(fed, 1, {1, -1, -123.0 / 16384});
  expect_housekeeping(fed, 1,
                      {{"temperature_x", 20.5},
                       {"temperature_y", 20.5 + 2.0 / 256},
                       {"temperature_z", -10.25},
                       {"latency_us", 500},
                       {"acceleration_x", kAbsent},
                       {"accelerometer_temperature_x", kAbsent},
                       {"auxiliary", kAbsent}});
  EXPECT_FALSE(fed.frames[1].flagged);
}

TEST(GyroHousekeeping, OfTheVectorNav) {
  const tests::DecodedStream fed(
      tests::shipped_stream("vectornav", kAxes).frame,
      tests::from_hex("FA01010C081A99BE1C0000000000803E000000BF0000003E0000FC410080CA420AD7233C0000003F000080BE0000"
                      "803A0AD7233C0AD7A33C8FC2F53CC3A0"));
  ASSERT_EQ(fed.frames.size(), 1u);
  expect_axes(fed, 0, {0.5, -0.25, 0.0009765625});
  expect_housekeeping(fed, 0,
                      {{"magnetic_x", 0.25},
                       {"magnetic_y", -0.5},
                       {"magnetic_z", 0.125},
                       {"temperature", 31.5},
                       {"pressure", 101.25},
                       {"delta_time", 0.01},
                       {"velocity_x", 0.01},
                       {"velocity_y", 0.02},
                       {"velocity_z", 0.03}});
}

/// Status 2 contains the temperature in some messages, and the software version in others.
TEST(GyroHousekeeping, DecodesHg4930) {
  auto bytes = tests::from_hex("0E01640038FF2C01E8030000FFFF0400F680B786");
  const auto increments =
      tests::from_hex("0E02640038FF2C01E8030000FFFF05001700E803000030F8FFFF711B0D000000000800000000000000F86E1E");
  const auto start_data = tests::from_hex("0E01640038FF2C01E8030000FFFF06001702DA07");
  bytes.insert(bytes.end(), increments.begin(), increments.end());
  bytes.insert(bytes.end(), start_data.begin(), start_data.end());
  const tests::DecodedStream fed(tests::shipped_stream("hg4930", kAxes).frame, bytes);
  ASSERT_EQ(fed.frames.size(), 3u);
  EXPECT_FALSE(fed.frames[0].axes[2].value);
  expect_housekeeping(fed, 0,
                      {{"accelerometer_temperature_x", -10},
                       {"rate_y", -200 * 600 * 0x1p-20},
                       {"acceleration_x", 1000 * 600 * 0x1p-14 * 0.3048},
                       {"velocity_x", kAbsent}});
  expect_axes(fed, 1, {1000 * 0x1p-33, -2000 * 0x1p-33, 858993 * 0x1p-33});
  expect_housekeeping(fed, 1,
                      {{"accelerometer_temperature_x", kAbsent},
                       {"rate_y", -200 * 600 * 0x1p-20},
                       {"velocity_x", 0.3048},
                       {"velocity_z", -0.3048}});
  EXPECT_TRUE(fed.frames[0].good && fed.frames[1].good);
  EXPECT_FALSE(fed.frames[2].good) << "0x5555 in place of data";
}

TEST(GyroHousekeeping, OfTheHg1120) {
  const tests::DecodedStream fed(
      tests::shipped_stream("hg1120", kAxes).frame,
      tests::from_hex("0E05640038FF2C01004000C00000E80318FC0000430034121B430000C979FFFF711B0D0000000010000000000000"
                      "00F0AEF0"));
  ASSERT_EQ(fed.frames.size(), 1u);
  expect_axes(fed, 0, {17179 * 0x1p-34, -34359 * 0x1p-34, 858993 * 0x1p-34});
  expect_housekeeping(fed, 0,
                      {{"rate_x", 100 * 1200 * 0x1p-20},
                       {"acceleration_x", 1200 * 0.3048},
                       {"acceleration_y", -1200 * 0.3048},
                       {"magnetic_x", 438.404},
                       {"magnetic_y", -438.404},
                       {"velocity_x", 0.3048},
                       {"velocity_z", -0.3048}});
  EXPECT_TRUE(fed.frames[0].good);
  EXPECT_TRUE(fed.frames[0].flagged) << "an accelerometer is invalid";
}

/// Housekeeping of every shipped stream is decoded as encoded, within one step of its field.
TEST(GyroHousekeeping, IsReadBackAsEncoded) {
  std::size_t read_back = 0;
  for (const auto& name : tests::shipped_streams()) {
    const auto format = tests::whole_shipped_stream(name).frame;
    const auto fields = format.values();
    std::vector<std::optional<double>> values;
    for (std::size_t i = 0; i < fields.size(); ++i)
      values.emplace_back(is_real(fields[i]->type) ? static_cast<double>(i) + 0.5
                                                   : apply_scale(*fields[i], {.whole = fields[i]->bits > 1 ? 5 : 1}));
    std::vector<std::byte> bytes = format.line ? tests::bytes_of("\r\n") : std::vector<std::byte>();
    const auto count = std::max<std::size_t>(4, format.lock_frames + 1);
    const auto* sequence = format.find(FieldRole::sequence);
    for (std::size_t i = 0; i < count; ++i) {
      const auto number = sequence ? i * sequence->step % sequence->range : i;
      const auto one = encode_frame(format, {.axes = std::vector<AxisReading>(format.axes.size()),
                                             .sequence = static_cast<std::uint32_t>(number),
                                             .values = values});
      bytes.insert(bytes.end(), one.begin(), one.end());
      bytes.insert(bytes.end(), format.tail.begin(), format.tail.end());
    }
    const tests::DecodedStream fed(format, bytes);
    ASSERT_EQ(fed.frames.size(), count) << name;
    read_back += values.size();
    for (std::size_t i = 0; i < values.size(); ++i) {
      const auto& frame = fed.frames[fields[i]->every > 1 ? fields[i]->turn : 0];
      ASSERT_TRUE(frame.values[i]) << name << ' ' << fields[i]->name;
      EXPECT_NEAR(*frame.values[i], *values[i], 1e-6) << name << ' ' << fields[i]->name;
    }
  }
  EXPECT_GT(read_back, 50u);
}

TEST(GyroHousekeeping, SaturatesAtFieldLimits) {
  const auto format = tests::shipped_stream("hg1700-rawimusx").frame;
  for (const auto& [sent, read] : {std::pair(300.0, 127.0), std::pair(-300.0, -128.0)})
    EXPECT_EQ(tests::DecodedStream(format, encode_frame(format, {.values = {sent}})).housekeeping("temperature"), read);
}

constexpr const char* kHead = "[frame]\nname = \"f\"\nsync = [1]\nlength = 16\n";
constexpr const char* kGyro = "[[frame.field]]\nrole = \"increment\"\ntype = \"i16\"\noffset = 1\n";

std::string value_field(const std::string& keys) {
  return "[[frame.field]]\nrole = \"value\"\ntype = \"u8\"\noffset = 8\n" + keys;
}

std::string mistakes_of(const std::string& fields) {
  const auto file = TomlTable::parse(kHead + fields, "frame.toml").value();
  (void)read_frame_format(file.table("frame"));
  const auto verdict = file.verdict();
  return verdict ? "" : text(verdict.error());
}

TEST(GyroHousekeeping, KeepsValueWithUnitByName) {
  const auto format =
      frame_format_of((std::string(kHead) + kGyro + value_field("name = \"discharge_current_a\"\nunit = \"mA\"\n") +
                       value_field("name = \"version\"\n"))
                          .c_str());
  const auto values = list_housekeeping(format);
  ASSERT_EQ(values.size(), 3u);
  EXPECT_EQ(values[0].name, "discharge_current_a");
  EXPECT_EQ(values[0].unit, "mA");
  EXPECT_FALSE(values[0].is_temperature);
  EXPECT_EQ(values[1].name, "frames");
  EXPECT_EQ(values[2].name, "flagged");
}

TEST(GyroHousekeeping, ReportsEachErrorWithItsPosition) {
  const auto one = [](const std::string& keys) { return mistakes_of(kGyro + value_field(keys)); };
  EXPECT_EQ(one("name = \"current_1\"\nunit = \"mA\"\n"), "");
  EXPECT_NE(one("name = \"current-1\"\nunit = \"mA\"\n").find("frame.toml:13:8: \"current-1\" is not a name"),
            std::string::npos);
  EXPECT_NE(one("name = \"Strom °\"\nunit = \"mA\"\n").find("letters, digits"), std::string::npos);
  EXPECT_NE(one("name = \"\"\nunit = \"mA\"\n").find("letters, digits"), std::string::npos);
  EXPECT_EQ(one("name = \"a-b\"\n"), "") << "without a unit it is not kept";
  EXPECT_NE(one("name = \"frames\"\nunit = \"1\"\n").find("is reserved"), std::string::npos);
  EXPECT_NE(one("name = \"flagged\"\nunit = \"1\"\n").find("is reserved"), std::string::npos);
  const auto two = value_field("name = \"a\"\nunit = \"V\"\n");
  EXPECT_NE(mistakes_of(kGyro + two + two).find("frame.toml:15:1: 2 fields have the name \"a\""), std::string::npos)
      << mistakes_of(kGyro + two + two);
  EXPECT_NE(mistakes_of(kGyro + two + value_field("name = \"a\"\nunit = \"A\"\n")).find("differ in role or unit"),
            std::string::npos);
  const std::string temperature = "[[frame.field]]\nrole = \"temperature\"\ntype = \"i8\"\noffset = 8\n";
  EXPECT_EQ(mistakes_of(kGyro + temperature), "");
  EXPECT_NE(mistakes_of(kGyro + temperature + temperature).find("2 fields have the name \"temperature\""),
            std::string::npos);
  EXPECT_EQ(mistakes_of(kGyro + temperature + "name = \"t1\"\n" + temperature + "name = \"t2\"\n"), "");
  EXPECT_NE(mistakes_of(kGyro + temperature + "unit = \"degF\"\n").find("must be in °C"), std::string::npos);
}

TEST(GyroHousekeeping, ReportsEachErrorOfConditions) {
  const auto one = [](const std::string& when) {
    return mistakes_of(kGyro + value_field("name = \"a\"\nunit = \"V\"\nwhen = " + when + "\n"));
  };
  EXPECT_EQ(one("{ mask = 0x80, value = 0x80 }"), "");
  EXPECT_EQ(one("{ mask = 0x80, value = 0 }"), "");
  EXPECT_NE(one("{ mask = 0, value = 0 }").find("the mask is empty"), std::string::npos);
  EXPECT_NE(one("{ mask = 1, value = 2 }").find("does not contain the value"), std::string::npos);
  EXPECT_NE(one("{ mask = 0x100, value = 0 }").find("has bits outside the field"), std::string::npos);
  const auto when = [](const char* value) {
    return value_field(fmt::format("name = \"a\"\nunit = \"V\"\nwhen = {{ mask = 0xC0, value = {} }}\n", value));
  };
  EXPECT_EQ(mistakes_of(kGyro + when("0x40") + when("0x80")), "") << "no frame has both";
  EXPECT_NE(mistakes_of(kGyro + when("0x40") + when("0x40")).find("2 fields have the name \"a\""), std::string::npos);
}

TEST(GyroHousekeeping, RefusesDescriptionWithoutAxis) {
  const auto stream = tests::shipped_stream("kvh-17xx-a");
  const auto refused = [&](const std::vector<std::string>& axes) {
    const auto parsed = parse_gyro_stream(stream.text, "g.toml", axes);
    return parsed ? std::string() : text(parsed.error());
  };
  EXPECT_EQ(refused({"x", "z"}), "");
  EXPECT_NE(refused({"x", "w"}).find("no gyro field has the axis \"w\""), std::string::npos);
  EXPECT_NE(refused({"x", "x"}).find("the axis \"x\" is requested twice"), std::string::npos);
  const auto bare = tests::shipped_stream("pulse-count");
  EXPECT_TRUE(bare.frame.all_axes.empty());
  EXPECT_FALSE(parse_gyro_stream(bare.text, "g.toml", {"z"}));
  EXPECT_TRUE(parse_gyro_stream(bare.text, "g.toml", {""}));
}

/// An axis in two messages must have the same meaning in both.
TEST(GyroHousekeeping, NamesSameAxisInEveryMessage) {
  const auto mistakes = [](const char* unit, const char* axis) {
    const auto file = TomlTable::parse(
        fmt::format("[frame]\nname = \"f\"\nsync = [1]\n[frame.id]\noffset = 1\n[[frame.message]]\nid = 1\nlength = 8\n"
                    "[[frame.message]]\nid = 2\nlength = 8\n"
                    "[[frame.field]]\nrole = \"increment\"\ntype = \"i16\"\noffset = 2\nids = [1]\naxis = \"x\"\n"
                    "unit = \"deg\"\n"
                    "[[frame.field]]\nrole = \"increment\"\ntype = \"i16\"\noffset = 4\nids = [2]\naxis = \"{}\"\n"
                    "unit = \"{}\"\n",
                    axis, unit),
        "frame.toml");
    const auto format = read_frame_format(file->table("frame"));
    EXPECT_EQ(format.gyros().size(), 1u);
    const auto verdict = file->verdict();
    return verdict ? std::string() : text(verdict.error());
  };
  EXPECT_EQ(mistakes("deg", "x"), "");
  EXPECT_NE(mistakes("rad", "x").find("the fields of axis \"x\" differ"), std::string::npos);
  EXPECT_EQ(mistakes("rad", "y"), "");
}

/// Returns a stream of lines "S,RATE,STATUS" whose status has the type.
FrameFormat lines_with_status(const std::string& type) {
  return decimal_lines(R"([[frame.field]]
name = "status"
role = "status"
word = 2
mask = 0
rule = [
  { mask = 0x1, good = 0, verdict = "invalid", meaning = "sensor" },
  { mask = 0x80000000, good = 0x80000000, verdict = "mismatch", meaning = "range" },
]
type = ")" + type + "\"\n");
}

TEST(FrameDecoder, BrokenRulesAreThoseThatMarkFrame) {
  const std::pair<const char*, std::vector<std::pair<const char*, std::uint32_t>>> cases[] = {
      {"integer", {{"0", 0}, {"1", 1}, {"-2", 0xFFFFFFFE}, {"-2147483648", 0x80000000}, {"4294967298", 2}}},
      {"signed_hexadecimal", {{"FFFFFFFFFFFFFFFE", 0xFFFFFFFE}, {"80000001", 0x80000001}}},
      {"hexadecimal", {{"100000000", 0}, {"FFFFFFFF80000000", 0x80000000}, {"7", 7}, {"80000000", 0x80000000}}},
  };
  int lines = 0;
  for (const auto& [type, statuses] : cases)
    for (const auto& [word, bits] : statuses) {
      FrameDecoder decoder(lines_with_status(type));
      decoder.feed(tests::bytes_of(fmt::format("S,0,0\nS,1.5,{}\n", word)));
      // Without a check, the first line is left out, because it may be incomplete.
      const auto* frame = decoder.take();
      ASSERT_TRUE(frame) << type << " " << word;
      std::vector<std::string> broken, differing;
      if ((bits & 1U) != 0) broken.emplace_back("sensor");
      if ((bits & 0x80000000U) == 0) broken.emplace_back("range"), differing.emplace_back("range");
      EXPECT_EQ(frame->good, (bits & 1U) == 0) << type << " " << word;
      EXPECT_EQ(frame->flagged, !broken.empty()) << type << " " << word;
      EXPECT_EQ(decoder.broken_rules(), broken) << type << " " << word;
      EXPECT_EQ(decoder.differing_settings(), differing) << type << " " << word;
      ++lines;
    }
  EXPECT_EQ(lines, 11);
}

}  // namespace
}  // namespace gyrotherm::drivers
