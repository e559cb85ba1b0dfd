// SPDX-License-Identifier: Apache-2.0
#include "drivers/chamber/modbus_chamber.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/file.hpp"
#include "tests/support/fakes.hpp"

namespace gyrotherm::drivers {
namespace {

constexpr const char* kMap = R"(schema = "gyrotherm-chamber/1"
name = "oven"
vendor = "test"
source = "none"
[link]
one_block = {}
[[register]]
name = "identity"
address = 0
type = "u16"
[[register]]
name = "air_temperature"
address = 1
type = "f32"
[[register]]
name = "set_point"
address = 3
type = "s16"
scale = 0.1
access = "rw"
[[register]]
name = "mode"
address = 4
type = "u16"
access = "rw"
codes = {{ off = 62, auto = 10 }}
[[register]]
name = "mode_active"
address = 5
type = "u16"
codes = {{ off = 62, auto = 10 }}
[identity]
register = "identity"
value = 570
[control]
commanded = "mode"
active = "mode_active"
on = "auto"
)";

constexpr const char* kStates = R"([[state]]
activity = "running"
register = "mode_active"
is = "auto"
[[state]]
activity = "off"
register = "mode_active"
is = "off"
)";

/// A chamber on in-memory registers: at 21.5 °C, set point 20.0 °C, off.
class OnFakeRegisters : public testing::Test {
 protected:
  void connect(bool one_block = true) { connect_with(fmt::format(fmt::runtime(kMap), one_block)); }
  /// Connects with states, which are read in every third reading.
  void connect_with_states() { connect_with(fmt::format(fmt::runtime(kMap), "false\nstatus_every = 3") + kStates); }
  void connect_with(const std::string& text_of_map) {
    auto map = parse_register_map(text_of_map, "map.toml");
    ASSERT_TRUE(map) << text(map.error());
    auto made = std::make_unique<tests::FakeRegisters>();
    registers = made.get();
    registers->words = {{0, 570}, {1, 0x41AC}, {2, 0}, {3, 200}, {4, 62}, {5, 62}};
    chamber = make_modbus_chamber(std::move(*map), std::move(made));
  }
  tests::FakeRegisters* registers{};
  std::unique_ptr<Chamber> chamber;
};
using ModbusChamber = OnFakeRegisters;

TEST_F(ModbusChamber, ReadsAirAndSetPointInOneBlockIfItsMapSaysSo) {
  connect(true);
  EXPECT_EQ(chamber->read().value(), (ChamberState{{21.5}, {20.0}}));
  EXPECT_EQ(registers->reads, 1);
}

TEST_F(ModbusChamber, ReadsItemsSeparately) {
  connect(false);
  EXPECT_EQ(chamber->read().value(), (ChamberState{{21.5}, {20.0}}));
  EXPECT_EQ(registers->reads, 2);
}

TEST_F(ModbusChamber, ChecksFingerprint) {
  connect();
  EXPECT_EQ(chamber->identify().value(), "test oven (identity = 570)");
  registers->words[0] = 571;
  EXPECT_EQ(chamber->identify().error().kind, FaultKind::mismatch);
  EXPECT_EQ(chamber->read().error().kind, FaultKind::mismatch) << "each block holds the fingerprint";
}

TEST_F(ModbusChamber, ReadsBackSetPoint) {
  connect();
  ASSERT_TRUE(chamber->send_set_point({-40.04}));
  EXPECT_EQ(registers->words[3], 0xFE70) << "-40.0 at the register's resolution";
  EXPECT_EQ(chamber->read().value().set_point, Celsius{-40.0});
}

TEST_F(ModbusChamber, ReportsMismatchWhenAcknowledgedWriteHasNoEffect) {
  connect();
  registers->ignore_writes();
  const auto done = chamber->send_set_point({-40});
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().kind, FaultKind::mismatch);
  EXPECT_EQ(text(done.error()), "chamber register 3 (set_point): reads 20 after -40 was written");
}

TEST_F(ModbusChamber, ReportsMismatchWhenStepOfOneCountIsIgnored) {
  connect();
  registers->ignore_writes();
  EXPECT_EQ(chamber->send_set_point({20.1}).error().kind, FaultKind::mismatch);
}

TEST_F(ModbusChamber, RefusesValueOutsideRegisterRange) {
  connect();
  EXPECT_EQ(chamber->send_set_point({4000}).error().kind, FaultKind::out_of_range);
  EXPECT_EQ(registers->words[3], 200);
}

TEST_F(ModbusChamber, StartAndStopAreSeenInTheActiveMode) {
  connect();
  EXPECT_EQ(chamber->start().error().kind, FaultKind::mismatch) << "commanded, but the mode did not follow";
  EXPECT_EQ(registers->words[4], 10);
  registers->words[5] = 10;
  EXPECT_TRUE(chamber->start());
  EXPECT_FALSE(chamber->stop());
  registers->words[5] = 62;
  EXPECT_TRUE(chamber->stop());
  EXPECT_EQ(registers->words[4], 62);
}

TEST_F(ModbusChamber, DoesNotReportOffAfterStart) {
  connect_with_states();
  EXPECT_EQ(chamber->read().value().activity, ChamberActivity::off);
  registers->words[5] = 10;
  ASSERT_TRUE(chamber->start());
  EXPECT_EQ(chamber->read().value().activity, ChamberActivity::running);
}

TEST_F(ModbusChamber, ReportsUnknownActivityAfterStart) {
  connect_with_states();
  EXPECT_EQ(chamber->read().value().activity, ChamberActivity::off);
  registers->words[5] = 10;
  ASSERT_TRUE(chamber->start());
  registers->words.erase(5);
  EXPECT_EQ(chamber->read().value().activity, ChamberActivity::unknown);
}

TEST_F(ModbusChamber, ReturnsFaultOfLine) {
  connect();
  registers->fall_silent();
  EXPECT_EQ(chamber->read().error().kind, FaultKind::timeout);
  registers->disconnect();
  EXPECT_EQ(chamber->send_set_point({10}).error().kind, FaultKind::disconnected);
  registers->recover();
  EXPECT_TRUE(chamber->read());
}

TEST_F(ModbusChamber, ReportsFaultWhenAcknowledgementOfWriteIsLate) {
  connect();
  registers->answer_late();
  EXPECT_EQ(chamber->send_set_point({10}).error().kind, FaultKind::timeout);
  EXPECT_EQ(chamber->read().value().set_point, Celsius{10});
}

RegisterMap shipped(const std::string& name) {
  const auto file = read_text_file(GYROTHERM_SOURCE_DIR "/profiles/chambers/" + name + ".toml");
  return parse_register_map(file.value(), name + ".toml").value();
}

TEST(Ezt570i, IsOffWhenOfflineDespiteFrozenRegisters) {
  auto made = std::make_unique<tests::FakeRegisters>();
  auto& words = made->words;
  for (std::uint16_t at = 0; at <= 61; ++at) words[at] = 0;
  const auto chamber = make_modbus_chamber(shipped("csz_ezt570i"), std::move(made));
  words[0] = 1;
  words[22] = 1;
  words[24] = 1 << 5;  // its program ramps
  words[60] = words[61] = 236;
  EXPECT_EQ(chamber->inspect().value().activity, ChamberActivity::ramping);
  words[0] = 0;
  EXPECT_EQ(chamber->inspect().value().activity, ChamberActivity::off);
}

/// A chamber that sends meaningless zeros; its registers hold the values that it shows.
class SendsZeros {
 public:
  explicit SendsZeros(const std::string& map) : air_(*shipped(map).find("air_temperature")) {
    auto made = std::make_unique<tests::FakeRegisters>();
    registers_ = made.get();
    for (std::uint16_t i = 0; i < 2; ++i) registers_->words[static_cast<std::uint16_t>(air_.address + i)] = 0;
    chamber = make_modbus_chamber(shipped(map), std::move(made));
  }
  void show(double celsius) {
    auto at = air_.address;
    for (const auto word : encode_as_read(air_, celsius)) registers_->words[at++] = word;
  }
  [[nodiscard]] Result<ChamberState> read(double celsius) {
    show(celsius);
    return chamber->read();
  }

  std::unique_ptr<Chamber> chamber;

 private:
  RegisterItem air_;
  tests::FakeRegisters* registers_;
};

TEST(StrayZeros, AreDistinguishedFromRampByPreviousReading) {
  for (const auto* map : {"tt5166", "umc1200", "yinhe"}) {
    SendsZeros unit(map);
    EXPECT_NEAR(unit.read(23.4).value().air.value, 23.4, 1e-5) << map;
    const auto stray = unit.read(0);
    ASSERT_FALSE(stray) << map;
    EXPECT_EQ(stray.error().kind, FaultKind::out_of_range);
    EXPECT_EQ(stray.error().what, "the unit returned a stray zero instead of a value");
    for (const double ramp : {23.5, 15.0, 7.0, 0.3, 0.0, -0.2, 0.0, 0.0})
      EXPECT_TRUE(unit.read(ramp)) << map << " at " << ramp;
  }
}

TEST(StrayZeros, AreAcceptedAfterSix) {
  SendsZeros unit("umc1200");
  ASSERT_TRUE(unit.read(-40));
  for (int i = 0; i < 6; ++i) EXPECT_FALSE(unit.read(0)) << i;
  EXPECT_EQ(unit.read(0).value().air, Celsius{0});
  EXPECT_TRUE(unit.read(0));
}

TEST(StrayZeros, AreRetriedAtFirstReading) {
  SendsZeros unit("tt5166");
  EXPECT_FALSE(unit.read(0));
  SendsZeros at_zero("tt5166");
  at_zero.show(0);
  EXPECT_EQ(at_zero.chamber->inspect().value().air, Celsius{0});
}

/// A chamber with humidity registers, at 60 % and a dew point of 5.5 °C.
class HumidChamber : public OnFakeRegisters {
 protected:
  void connect(const std::string& items, bool has_states = true) {
    auto map = parse_register_map(
        fmt::format(fmt::runtime(kMap), "false\nstatus_every = 1") + items + (has_states ? kStates : ""), "map.toml");
    ASSERT_TRUE(map) << text(map.error());
    auto selected = select_humidity(std::move(*map));
    ASSERT_TRUE(selected) << text(selected.error());
    auto made = std::make_unique<tests::FakeRegisters>();
    registers = made.get();
    registers->words = {{0, 570}, {1, 0x41AC}, {2, 0}, {3, 200}, {4, 62}, {5, 62}, {9, 600}, {12, 55}};
    chamber = make_modbus_chamber(std::move(*selected), std::move(made));
  }
  static constexpr const char* kHumidity =
      "[[register]]\nname = \"humidity\"\naddress = 9\ntype = \"s16\"\nscale = 0.1\n";
  static constexpr const char* kDewPoint =
      "[[register]]\nname = \"dew_point\"\naddress = 12\ntype = \"s16\"\nscale = 0.1\n";
};

TEST_F(HumidChamber, ComputesDewPoint) {
  for (const bool has_states : {true, false}) {
    connect(kHumidity, has_states);
    const auto state = chamber->read().value();
    EXPECT_DOUBLE_EQ(state.humidity_percent.value(), 60);
    EXPECT_NEAR(state.dew_point.value().value, 13.4, 0.05) << "21.5 °C, 60 %";
  }
}

TEST_F(HumidChamber, PrefersMeasuredDewPoint) {
  connect(std::string(kHumidity) + kDewPoint);
  EXPECT_EQ(chamber->read().value().dew_point, Celsius{5.5});
  connect(kDewPoint);
  const auto state = chamber->read().value();
  EXPECT_FALSE(state.humidity_percent);
  EXPECT_EQ(state.dew_point, Celsius{5.5});
}

TEST_F(HumidChamber, HasStateWithoutHumidity) {
  connect(kHumidity);
  for (const std::uint16_t impossible : std::initializer_list<std::uint16_t>{0, 1200, 0xFFFF}) {
    registers->words[9] = impossible;
    const auto state = chamber->read().value();
    EXPECT_FALSE(state.humidity_percent || state.dew_point) << impossible;
    EXPECT_EQ(state.activity, ChamberActivity::off);
  }
  registers->words[9] = 500;
  ASSERT_TRUE(chamber->read().value().humidity_percent);
  registers->words.erase(9);
  for (int i = 0; i < 200; ++i) {
    const auto state = chamber->read();
    ASSERT_TRUE(state) << "in reading " << i << ": " << text(state.error());
    EXPECT_FALSE(state->humidity_percent) << "an old value is not repeated";
    EXPECT_EQ(state->activity, ChamberActivity::off);
  }
}

TEST_F(HumidChamber, IsRefusedWithoutItems) {
  const auto selected =
      select_humidity(parse_register_map(fmt::format(fmt::runtime(kMap), "false"), "map.toml").value());
  ASSERT_FALSE(selected);
  EXPECT_EQ(selected.error().kind, FaultKind::usage);
}

}  // namespace
}  // namespace gyrotherm::drivers
