// SPDX-License-Identifier: Apache-2.0
/// Rig files with many units under test, and short runs on them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>
#include <string>

#include "core/file.hpp"
#include "sequencer/rig/rig_file.hpp"
#include "tests/support/dry_run.hpp"

namespace gyrotherm::rig {
namespace {

const std::string kRigFolder = GYROTHERM_SOURCE_DIR "/profiles/rigs/";

std::string read_shipped_rig(const std::string& name) { return read_text_file(kRigFolder + name + ".toml").value(); }

std::string replace_text(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string rig_errors(const std::string& text) {
  const auto rig = parse_rig(text, kRigFolder + "x.toml");
  return rig ? std::string() : rig.error().what;
}

TEST(ManyUnitsRig, TriadHasThreeUnitsOnSeparateLines) {
  const auto rig = read_rig(kRigFolder + "virtual-triad.toml").value();
  ASSERT_EQ(rig.units.size(), 3u);
  ASSERT_EQ(rig.gyro_lines.size(), 3u);
  EXPECT_EQ(rig.units[1].info.name, "y");
  EXPECT_EQ(rig.units[1].info.axes.size(), 1u);
  EXPECT_TRUE(rig.units[1].info.axes[0].direction);
  EXPECT_EQ(rig.units[1].info.gradients.size(), 8u);
  EXPECT_TRUE(rig.units[1].continue_when_silent) << "one of several";
  EXPECT_EQ(line_title(rig.gyro_lines[1], rig.units), "gyro y");
  const auto channels = list_channels(rig);
  EXPECT_EQ(channels[8].unit_under_test, "y");
  EXPECT_EQ(rig.limits.units[1].thermometers.size(), 9u) << "including the shell of three_point";
}

TEST(ManyUnitsRig, LotHasTwentyFourAxesAndValues) {
  const auto rig = read_rig(kRigFolder + "virtual-lot.toml").value();
  ASSERT_EQ(rig.units.size(), 8u);
  for (const auto& unit : rig.units) {
    EXPECT_EQ(unit.info.axes.size(), 3u);
    EXPECT_FALSE(unit.info.values.empty());
    EXPECT_TRUE(unit.info.values.front().is_temperature);
  }
  EXPECT_EQ(rig.gyro_lines[7].frame.axes, (std::vector<std::string>{"x", "y", "z"}));
}

/// Returns a real rig whose inertial unit is two units under test on one line: its z axis, and its x axis with a
/// temperature.
std::string rig_with_two_units_on_one_line() {
  return replace_text(read_shipped_rig("example-binder-dcon-stim300"), "[gyro]\n", "[[gyro]]\nname = \"a\"\n") +
         "\n[[gyro]]\nname = \"b\"\nshares_line_with = \"a\"\naxis = \"x\"\nvalues = [\"temperature_x\"]\n";
}

TEST(ManyUnitsRig, AllowsUnitsToShareLine) {
  const auto rig = parse_rig(rig_with_two_units_on_one_line(), kRigFolder + "x.toml");
  ASSERT_TRUE(rig) << text(rig.error());
  ASSERT_EQ(rig->gyro_lines.size(), 1u);
  const auto& line = rig->gyro_lines[0];
  EXPECT_EQ(line.frame.axes, (std::vector<std::string>{"z", "x"}));
  ASSERT_EQ(line.shares.size(), 2u);
  EXPECT_EQ(line.shares[1].axes, std::vector<std::size_t>{1});
  EXPECT_EQ(line_title(line, rig->units), "gyro a+b");
  ASSERT_EQ(rig->units[1].info.values.size(), 1u);
  EXPECT_EQ(rig->units[1].info.values[0].name, "temperature_x");
  for (const auto& value : rig->units[0].info.values) EXPECT_NE(value.name, "temperature_x") << "the other's";
}

TEST(ManyUnitsRig, RefusesSharedLineWithoutOwner) {
  EXPECT_NE(
      rig_errors(replace_text(rig_with_two_units_on_one_line(), "shares_line_with = \"a\"", "shares_line_with = \"c\""))
          .find("\"c\" is not a gyro with a line of its own"),
      std::string::npos);
  EXPECT_NE(rig_errors(replace_text(rig_with_two_units_on_one_line(), "[\"temperature_x\"]", "[\"temperature_q\"]"))
                .find("\"temperature_q\" is not one of the stream's values"),
            std::string::npos);
}

TEST(ManyUnitsRig, ReportsEveryErrorWithPosition) {
  const auto lot = read_shipped_rig("virtual-lot");
  EXPECT_NE(rig_errors(replace_text(lot, "name = \"u2\"", "name = \"u1\"")).find("\"u1\" is the name of another gyro"),
            std::string::npos);
  EXPECT_NE(
      rig_errors(replace_text(lot, "direction = [1, 0, 0]", "direction = [0, 0, 0]")).find("that are not all zero"),
      std::string::npos);
  const auto triad = read_shipped_rig("virtual-triad");
  EXPECT_NE(rig_errors(replace_text(triad, "thermometers = [\"x.A\"", "thermometers = [\"x.Q\""))
                .find("\"x.Q\" is not a channel of this rig's thermometers"),
            std::string::npos);
}

/// Returns the rig file with only one of its units.
std::string keep_unit(const std::string& rig_text, const std::string& unit) {
  std::string kept, block;
  bool of_a_unit = false;
  const auto end_block = [&] {
    if (!of_a_unit || block.find('"' + unit) != std::string::npos) kept += block;
    block.clear();
  };
  std::istringstream lines(rig_text);
  for (std::string line; std::getline(lines, line);) {
    const bool is_head = line.starts_with("[");
    const bool goes_on = line.starts_with("[[gyro.") || line.starts_with("[[virtual.unit.") ||
                         line.starts_with("[gyro.") || line.starts_with("[[thermometer.");
    if (is_head && !goes_on) {
      end_block();
      of_a_unit = line == "[[gyro]]" || line == "[[virtual.unit]]" || line == "[[virtual.bracket]]" ||
                  line == "[[thermometer]]";
    }
    block += line + "\n";
  }
  end_block();
  return kept;
}

/// Returns the record of two minutes on a rig.
record::Record record_two_minutes(const std::string& rig_text, const std::string& which) {
  auto rig = parse_rig(rig_text, kRigFolder + which + ".toml");
  EXPECT_TRUE(rig) << text(rig.error());
  tests::DryRun run(GYROTHERM_SOURCE_DIR "/profiles/cold-start.toml", 3);
  run.file() = std::move(*rig);
  run.run(120);
  return record::read_record(run.path()).value();
}

/// A single axis is bit-identical to the same axis among twenty-four. Only the description of the record differs, and
/// with it the hash chain.
TEST(ManyUnitsRig, SingleUnitEqualsSameUnitOfLot) {
  const auto lot = read_shipped_rig("virtual-lot");
  const auto all = record_two_minutes(lot, "lot"), alone = record_two_minutes(keep_unit(lot, "u3"), "alone");
  ASSERT_EQ(alone.units.size(), 1u);
  ASSERT_EQ(all.units.size(), 8u);
  EXPECT_EQ(alone.info.units[0].name, "u3");
  EXPECT_EQ(alone.units[0].rotation, all.units[2].rotation);
  EXPECT_EQ(alone.units[0].interval_s, all.units[2].interval_s);
  EXPECT_EQ(alone.units[0].true_bias_deg_per_h, all.units[2].true_bias_deg_per_h);
  EXPECT_EQ(alone.units[0].values, all.units[2].values);
  for (std::size_t i = 0; i < alone.thermometers_c.size(); ++i) {
    const auto& name = alone.info.thermometers[i].name;
    const auto at =
        std::ranges::find(all.info.thermometers, name, &record::Channel::name) - all.info.thermometers.begin();
    EXPECT_EQ(alone.thermometers_c[i], all.thermometers_c[static_cast<std::size_t>(at)]) << name;
  }
  EXPECT_NE(all.units[2].rotation, all.units[3].rotation) << "each unit is a separate gyro";
}

TEST(ManyUnitsRig, RecordsEveryChannelOfTriad) {
  const auto record = record_two_minutes(read_shipped_rig("virtual-triad"), "triad");
  ASSERT_EQ(record.units.size(), 3u);
  for (const auto& unit : record.units)
    for (const double pulses : unit.rotation[0]) ASSERT_FALSE(std::isnan(pulses));
  for (const auto& thermometer : record.thermometers_c)
    for (const double celsius : thermometer) ASSERT_FALSE(std::isnan(celsius));
  for (std::size_t u = 0; u < 3; ++u) {
    const auto& axis = record.info.units[u].axes[0];
    const double rate = 0.1 *
                        std::accumulate(record.units[u].rotation[0].begin(), record.units[u].rotation[0].end(), 0.0) /
                        std::accumulate(record.units[u].interval_s.begin(), record.units[u].interval_s.end(), 0.0);
    EXPECT_NEAR(rate, axis.earth_rate->value, 0.2) << record.info.units[u].name;
  }
}

}  // namespace
}  // namespace gyrotherm::rig
