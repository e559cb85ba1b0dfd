// SPDX-License-Identifier: Apache-2.0
/// Tests of impossible air temperatures, and of a unit register that cannot be read while the chamber is made safe.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "core/file.hpp"
#include "drivers/chamber/modbus_chamber.hpp"
#include "tests/support/fakes.hpp"

namespace gyrotherm::drivers {
namespace {

using std::chrono::seconds;

/// A clock under the control of the test.
class TestPauses final : public Pauses {
 public:
  explicit TestPauses(Duration& now) : now_(now) {}
  Duration now() const override { return now_; }
  void rest(Duration time) override { now_ += time; }

 private:
  Duration& now_;
};

/// Registers, some of which answer with an exception.
class SomeRefuse final : public Registers {
 public:
  SomeRefuse(std::map<std::uint16_t, std::uint16_t>& words, std::set<std::uint16_t>& refused)
      : words_(words), refused_(refused) {}
  Result<std::vector<std::uint16_t>> read(ReadFunction, std::uint16_t address, std::uint16_t count) override {
    std::vector<std::uint16_t> found;
    for (std::uint16_t at = address; at < address + count; ++at) {
      if (refused_.contains(at)) return failure(FaultKind::refused, "fake", "exception 2");
      found.push_back(words_[at]);
    }
    return found;
  }
  Result<void> write(WriteFunction, std::uint16_t address, std::span<const std::uint16_t> values) override {
    for (const auto value : values) words_[address++] = value;
    return {};
  }

 private:
  std::map<std::uint16_t, std::uint16_t>& words_;
  std::set<std::uint16_t>& refused_;
};

/// A chamber with a shipped map, on in-memory registers.
class ShippedChamber {
 public:
  explicit ShippedChamber(const std::string& name) {
    const auto file = GYROTHERM_SOURCE_DIR "/profiles/chambers/" + name + ".toml";
    map_ = parse_register_map(read_text_file(file).value(), file).value();
    for (const auto& item : map_.items)
      if (!item.codes.empty()) set(item.name, static_cast<double>(item.codes.begin()->second.front()));
  }
  void set(const std::string& name, double value) {
    const auto& item = *map_.find(name);
    auto at = item.address;
    for (const auto word : encode_as_read(item, value)) words_[at++] = word;
  }
  [[nodiscard]] double raw(const std::string& name) {
    const auto& item = *map_.find(name);
    std::vector<std::uint16_t> words;
    for (std::uint16_t i = 0; i < word_count(item); ++i)
      words.push_back(words_[static_cast<std::uint16_t>(item.address + i)]);
    return decode_as_written(item, words);
  }
  void refuse(const std::string& name) { refused_.insert(map_.find(name)->address); }
  [[nodiscard]] std::unique_ptr<Chamber> connect(const ControllerSettings& before = {}) {
    return make_modbus_chamber(map_, std::make_unique<SomeRefuse>(words_, refused_), std::make_unique<TestPauses>(now),
                               before);
  }
  Duration now{};

 private:
  RegisterMap map_;
  std::map<std::uint16_t, std::uint16_t> words_;
  std::set<std::uint16_t> refused_;
};

struct UnitOfAMap {
  const char *map, *unit;
  double fahrenheit;  ///< code of °F
  /// Decimals of set points; -1 if the map has no register for them.
  int decimals;
};

class UnitRegister : public testing::TestWithParam<UnitOfAMap> {
 protected:
  void SetUp() override {
    const auto& [map, unit, fahrenheit, decimals] = GetParam();
    if (decimals >= 0) shipped.set("decimals", decimals);
    shipped.set(unit, fahrenheit);
    shipped.set("air_temperature", 140 * std::pow(10, std::max(decimals, 0)));
    shipped.set("set_point", 140 * std::pow(10, std::max(decimals, 0)));
  }
  [[nodiscard]] double set_point() { return shipped.raw("set_point") / std::pow(10, std::max(GetParam().decimals, 0)); }
  ShippedChamber shipped{GetParam().map};
};

TEST_P(UnitRegister, KeepsLatestUnitOnlyForSafeSetPoint) {
  const auto chamber = shipped.connect();
  ASSERT_NEAR(chamber->read().value().air.value, 60, 0.01);
  shipped.refuse(GetParam().unit);
  const double before = set_point();
  EXPECT_EQ(chamber->send_set_point({22}).error().kind, FaultKind::refused) << "no run goes on by guesses";
  EXPECT_EQ(set_point(), before) << "nothing is sent in a unit that was not read";
  EXPECT_EQ(chamber->read().error().kind, FaultKind::refused);
  ASSERT_TRUE(chamber->send_set_point_immediately({22}));
  EXPECT_NEAR(set_point(), 71.6, 0.11) << "°F";
  const auto state = chamber->read();
  ASSERT_TRUE(state) << text(state.error());
  EXPECT_NEAR(state->air.value, 60, 0.01) << "the air is still watched";
  EXPECT_NEAR(state->set_point.value, 22, 0.06);
}

TEST_P(UnitRegister, IsPassedToMakeSafe) {
  const auto chamber = shipped.connect();
  ASSERT_TRUE(chamber->read());
  const auto settings = chamber->settings();
  EXPECT_EQ(settings.at(GetParam().unit), GetParam().fahrenheit);
  shipped.refuse(GetParam().unit);
  const auto other = shipped.connect(settings);
  ASSERT_TRUE(other->send_set_point_immediately({22}));
  EXPECT_NEAR(set_point(), 71.6, 0.11);
  EXPECT_FALSE(shipped.connect()->send_set_point_immediately({22})) << "nothing is known of the unit";
}

INSTANTIATE_TEST_SUITE_P(Maps, UnitRegister,
                         testing::Values(UnitOfAMap{"watlow_f4t", "communication_unit", 30, -1},
                                         UnitOfAMap{"watlow_f4", "temperature_unit", 0, 1},
                                         UnitOfAMap{"watlow_f4t_map2", "temperature_unit", 0, 1},
                                         UnitOfAMap{"watlow_f4t_map3", "temperature_unit", 0, 1},
                                         UnitOfAMap{"watlow_ez_zone_pm", "communication_unit", 30, -1}),
                         [](const auto& one) { return std::string(one.param.map); });

class SoundAir : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override { show(20); }
  void show(double air) { shipped.set("air_temperature", air); }
  [[nodiscard]] FaultKind fault() {
    const auto state = chamber->read();
    // No chamber fails with this kind.
    return state ? FaultKind::interrupted : state.error().kind;
  }
  static constexpr auto kNone = FaultKind::interrupted;
  ShippedChamber shipped{GetParam()};
  std::unique_ptr<Chamber> chamber = shipped.connect();
};

TEST_P(SoundAir, IsWithinChamberLimits) {
  ASSERT_EQ(fault(), kNone);
  for (const double air : {-1.9e31, 2.5e17, 251.0, -121.0, 3e-20, -2.6e-5}) {
    show(air);
    for (int i = 0; i < 20; ++i) EXPECT_EQ(fault(), FaultKind::out_of_range) << air << " °C";
  }
  show(20);
  EXPECT_EQ(fault(), kNone);
}

TEST_P(SoundAir, DoesNotJump) {
  ASSERT_EQ(fault(), kNone);
  for (const double air : {135.26, -60.0, 40.0}) {
    show(air);
    EXPECT_EQ(fault(), FaultKind::out_of_range) << air << " °C";
    show(20);
    EXPECT_EQ(fault(), kNone) << "and is back";
  }
  shipped.now += seconds(60);
  show(60);
  EXPECT_EQ(fault(), kNone) << "that far it may have come in a minute";
}

TEST_P(SoundAir, AcceptsPersistentValueAfterJump) {
  ASSERT_EQ(fault(), kNone);
  show(120);
  int refused = 0;
  while (fault() == FaultKind::out_of_range && refused < 100) ++refused;
  EXPECT_EQ(refused, 2) << "the interlocks judge it then";
}

TEST_P(SoundAir, MayBeNearZero) {
  for (double air = 20; air > -5; air -= 0.5) {
    show(air);
    EXPECT_EQ(fault(), kNone) << air;
  }
  show(-2e-5 - 1e-5);
  show(0.4);
  EXPECT_EQ(fault(), kNone);
  show(2e-5);
  EXPECT_EQ(fault(), kNone) << "it was near before";
}

INSTANTIATE_TEST_SUITE_P(Maps, SoundAir, testing::Values("watlow_f4t", "yinhe", "binder_mb2"),
                         [](const auto& one) { return std::string(one.param); });

}  // namespace
}  // namespace gyrotherm::drivers
