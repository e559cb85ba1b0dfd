// SPDX-License-Identifier: Apache-2.0
/// Tests of the identity checks in register maps: make and model, and the settings that change the meaning of
/// registers. The units here are independent of the maps' [simulated] tables.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <filesystem>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/file.hpp"
#include "drivers/chamber/item_exchange.hpp"
#include "drivers/chamber/modbus_chamber.hpp"

namespace gyrotherm::drivers {
namespace {

const std::filesystem::path kMaps = GYROTHERM_SOURCE_DIR "/profiles/chambers";

RegisterMap shipped_map(const std::string& name, const std::string& power = "") {
  const auto map = parse_register_map(read_text_file((kMaps / (name + ".toml")).string()).value(), name);
  EXPECT_TRUE(map) << (map ? "" : text(map.error()));
  return select_power_switch(*map, power).value();
}

/// An in-memory unit that reacts to writes. Absent registers are refused.
class ActiveUnit {
 public:
  std::map<std::uint16_t, std::uint16_t> words;
  std::vector<std::pair<std::uint16_t, std::uint16_t>> written;
  std::function<void(std::uint16_t address, std::uint16_t word)> reacts = [](auto, auto) {};

  void set_text(std::uint16_t address, const std::string& text) {
    for (const char c : text) words[address++] = static_cast<std::uint16_t>(c);
  }
  /// Stores a float with its low word first.
  void set_float(std::uint16_t address, float value) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    words[address] = static_cast<std::uint16_t>(bits);
    words[static_cast<std::uint16_t>(address + 1)] = static_cast<std::uint16_t>(bits >> 16);
  }
  [[nodiscard]] std::unique_ptr<Chamber> on_map(RegisterMap map) {
    return make_modbus_chamber(std::move(map), std::make_unique<Line>(*this), make_virtual_pauses());
  }
  /// Returns the words written to `address`, in order.
  [[nodiscard]] std::vector<std::uint16_t> written_to(std::uint16_t address) const {
    std::vector<std::uint16_t> all;
    for (const auto& [where, word] : written)
      if (where == address) all.push_back(word);
    return all;
  }

 private:
  class Line final : public Registers {
   public:
    explicit Line(ActiveUnit& unit) : unit_(unit) {}
    Result<std::vector<std::uint16_t>> read(ReadFunction, std::uint16_t address, std::uint16_t count) override {
      std::vector<std::uint16_t> found;
      for (std::uint16_t i = 0; i < count; ++i) {
        const auto word = unit_.words.find(static_cast<std::uint16_t>(address + i));
        if (word == unit_.words.end()) return failure(FaultKind::refused, "unit", "exception 2, illegal data address");
        found.push_back(word->second);
      }
      return found;
    }
    Result<void> write(WriteFunction, std::uint16_t address, std::span<const std::uint16_t> values) override {
      if (!unit_.words.contains(address)) return failure(FaultKind::refused, "unit", "exception 2");
      for (std::size_t i = 0; i < values.size(); ++i) unit_.words[static_cast<std::uint16_t>(address + i)] = values[i];
      unit_.written.emplace_back(address, values.front());
      unit_.reacts(address, values.front());
      return {};
    }

   private:
    ActiveUnit& unit_;
  };
};

/// An F4T. The twelfth character of the part number encodes its loops and cascades.
ActiveUnit f4t(const std::string& loops) {
  ActiveUnit unit;
  unit.set_text(16, "F4T1F2EAA1B" + loops + "AAA");
  unit.words[6730] = 15;
  for (const auto address : std::initializer_list<std::uint16_t>{2782, 2820, 4042, 4182}) unit.set_float(address, 23);
  for (const auto address : std::initializer_list<std::uint16_t>{2774, 4034}) unit.set_float(address, -70);
  for (const auto address : std::initializer_list<std::uint16_t>{2776, 4036}) unit.set_float(address, 180);
  for (const auto address : std::initializer_list<std::uint16_t>{2730, 2814, 4010, 4012, 16568})
    unit.words[address] = 62;
  unit.words[16566] = 61;
  return unit;
}

/// Makes the control modes take effect immediately.
void take_modes(ActiveUnit& unit) {
  unit.reacts = [&unit](std::uint16_t address, std::uint16_t word) {
    if (address == 2730) unit.words[2814] = word;
    if (address == 4010) unit.words[4012] = word;
  };
}

TEST(Patterns, HaveSingleCharactersAndClasses) {
  struct Case {
    const char* pattern;
    std::vector<std::string> yes, no;
  };
  const std::vector<Case> cases{{"F4T????????[1-4]*", {"F4T1F2EAA1B1AAA", "F4T1F2EAA1B4"}, {"F4T1F2EAA1B7AAA", "F4T1"}},
                                {"F4T????????[6-9A-C]*", {"F4T1F2EAA1B9", "F4T1F2EAA1BCx"}, {"F4T1F2EAA1B5", ""}},
                                {"[!A-C]?", {"D1", "d "}, {"A1", "C1", "D", "D12"}},
                                {"*[0-9]", {"7", "ab7"}, {"", "7a"}},
                                {"LSCI,MODEL218?,*", {"LSCI,MODEL218S,1,2"}, {"LSCI,MODEL218,1,2"}},
                                {"a[-x]c", {"a-c", "axc"}, {"abc"}}};
  for (const auto& one : cases) {
    for (const auto& text : one.yes) EXPECT_TRUE(matches(one.pattern, text)) << one.pattern << " " << text;
    for (const auto& text : one.no) EXPECT_FALSE(matches(one.pattern, text)) << one.pattern << " " << text;
    EXPECT_TRUE(matches(one.pattern, make_example(one.pattern))) << one.pattern << " " << make_example(one.pattern);
  }
}

TEST(Patterns, RequireClosedNonEmptyClass) {
  auto text = read_text_file((kMaps / "watlow_f4t.toml").string()).value();
  for (const auto* wrong : {"F4T[1-4", "F4T[]*", "F4T[!]"}) {
    auto changed = text;
    const std::string good = "pattern = \"F4T????????[1-4]*\"";
    changed.replace(changed.find(good), good.size(), "pattern = \"" + std::string(wrong) + "\"");
    EXPECT_FALSE(parse_register_map(changed, "map.toml")) << wrong;
  }
}

TEST(Identity, DistinguishesF4TWithAndWithoutCascade) {
  const auto identify = [](const char* map, const std::string& loops) {
    auto unit = f4t(loops);
    auto who = unit.on_map(shipped_map(map))->identify();
    EXPECT_TRUE(unit.written.empty());
    return who;
  };
  for (const std::string loops : {"1", "2", "3", "4"}) {
    EXPECT_TRUE(identify("watlow_f4t", loops)) << loops;
    const auto other = identify("watlow_f4t_cascade", loops);
    ASSERT_FALSE(other) << loops;
    EXPECT_EQ(other.error().kind, FaultKind::mismatch);
    EXPECT_NE(other.error().what.find("use the map watlow_f4t"), std::string::npos) << other.error().what;
  }
  for (const std::string loops : {"6", "7", "8", "9", "A", "B", "C"}) {
    EXPECT_TRUE(identify("watlow_f4t_cascade", loops)) << loops;
    const auto other = identify("watlow_f4t", loops);
    ASSERT_FALSE(other) << loops;
    EXPECT_EQ(other.error().kind, FaultKind::mismatch);
    EXPECT_NE(other.error().what.find("use the map watlow_f4t_cascade"), std::string::npos) << other.error().what;
  }
  for (const auto* map : {"watlow_f4t", "watlow_f4t_cascade"})
    for (const std::string loops : {"5", "D", "0", " "}) EXPECT_FALSE(identify(map, loops)) << map << " " << loops;
}

TEST(Identity, ReadsAirAndLimitsOfCascadeUnit) {
  auto unit = f4t("7");
  take_modes(unit);
  unit.set_float(2820, 45);
  unit.set_float(2782, 45);
  unit.words[4200] = 63;
  const auto chamber = unit.on_map(shipped_map("watlow_f4t_cascade"));
  ASSERT_TRUE(chamber->identify());
  EXPECT_NEAR(chamber->read().value().air.value, 23, 1e-6);
  EXPECT_EQ(chamber->limits().value().lowest, Celsius{-70});
  ASSERT_TRUE(chamber->send_set_point(Celsius{30}));
  ASSERT_TRUE(chamber->start());
  EXPECT_TRUE(unit.written_to(2782).empty()) << "the set point of the humidity";
  EXPECT_TRUE(unit.written_to(2730).empty());
  EXPECT_EQ(unit.written_to(4042).size(), 1u);
}

/// Cases of settings that change the meaning of the registers.
TEST(Identity, RefusesAUnitWhoseSettingsChangeTheMeaningOfItsRegisters) {
  struct Case {
    const char* what;
    const char* map;
    std::string loops;
    std::uint16_t address, good, bad;
  };
  const std::vector<Case> cases{{"the unit ramps set points", "watlow_f4t", "1", 2794, 62, 85},
                                {"the unit ramps at startup and set points", "watlow_f4t", "2", 2794, 88, 13},
                                {"the set point is that of the part", "watlow_f4t_cascade", "7", 4200, 63, 62},
                                {"the cascade ramps set points", "watlow_f4t_cascade", "9", 4054, 62, 85}};
  for (const auto& one : cases) {
    auto unit = f4t(one.loops);
    const auto chamber = unit.on_map(shipped_map(one.map));
    ASSERT_TRUE(chamber->identify());
    EXPECT_NE(fmt::format("{}", fmt::join(chamber->verification().not_verified, ", ")).find("the unit has no"),
              std::string::npos)
        << one.what << ": a setting that cannot be read is said to be not verified";
    unit.words[one.address] = one.good;
    const auto good = chamber->identify();
    ASSERT_TRUE(good) << one.what << ": " << text(good.error());
    unit.words[one.address] = one.bad;
    const auto bad = chamber->identify();
    ASSERT_FALSE(bad) << one.what;
    EXPECT_EQ(bad.error().kind, FaultKind::mismatch);
    EXPECT_TRUE(chamber->recognise()) << "it is the same unit all the same";
    EXPECT_TRUE(good->starts_with(*chamber->recognise()));
  }
}

TEST(Identity, OfAControllerWithProductControlIsRefusedWhileThatIsOn) {
  ActiveUnit unit;
  for (std::uint16_t i = 0; i <= 180; ++i) unit.words[i] = 0;
  unit.words[0] = 1;
  unit.words[60] = unit.words[61] = 230;
  const auto chamber = unit.on_map(shipped_map("csz_ezt570i"));
  for (const auto off : std::initializer_list<std::uint16_t>{0, 4}) {
    unit.words[12] = off;
    EXPECT_TRUE(chamber->identify()) << off;
  }
  for (const auto on : std::initializer_list<std::uint16_t>{1, 2, 5, 6}) {
    unit.words[12] = on;
    EXPECT_FALSE(chamber->identify()) << on;
  }
}

TEST(Identity, ContainsSerialNumber) {
  auto unit = f4t("1");
  const auto chamber = unit.on_map(shipped_map("watlow_f4t"));
  const auto without = chamber->identify();
  unit.words[12] = 4711;
  unit.words[13] = 0;
  const auto first = chamber->identify();
  unit.words[12] = 4712;
  const auto second = chamber->identify();
  ASSERT_TRUE(without && first && second);
  EXPECT_NE(first->find("serial_number = 4711"), std::string::npos) << *first;
  EXPECT_NE(*first, *second);
  EXPECT_NE(*without, *first);
}

TEST(Identity, RefusesAUnitThatIsSetToAnotherWordOrder) {
  auto unit = f4t("1");
  const auto chamber = unit.on_map(shipped_map("watlow_f4t"));
  ASSERT_TRUE(chamber->identify());
  for (const auto address : std::initializer_list<std::uint16_t>{2782, 2820})
    std::swap(unit.words[address], unit.words[address + 1]);
  const auto swapped = chamber->identify();
  ASSERT_FALSE(swapped);
  EXPECT_EQ(swapped.error().kind, FaultKind::mismatch);
  for (const auto address : std::initializer_list<std::uint16_t>{2782, 2820}) unit.set_float(address, 0);
  EXPECT_TRUE(chamber->identify()) << "zeros show no order";
}

/// An EZ-ZONE PM with data map 1 that is off and stores its settings.
ActiveUnit ez_zone(std::uint16_t temperature_unit) {
  ActiveUnit unit;
  for (const auto address : std::initializer_list<std::uint16_t>{360, 2160}) unit.set_float(address, 23);
  unit.words[362] = 61;
  unit.words[1880] = 62;
  unit.words[2490] = temperature_unit;
  unit.words[2494] = 106;
  return unit;
}

TEST(EzZone, SendsPublishedWordsAndStoresNoSetPoint) {
  auto unit = ez_zone(30);
  const auto chamber = unit.on_map(shipped_map("watlow_ez_zone_pm"));
  ASSERT_TRUE(chamber->identify());
  ASSERT_TRUE(chamber->start());
  EXPECT_EQ(unit.written_to(2494), std::vector<std::uint16_t>{59});
  EXPECT_EQ(unit.written.front().first, 2494) << "before anything else";
  EXPECT_EQ(unit.written_to(1880), std::vector<std::uint16_t>{10});
  ASSERT_TRUE(chamber->send_set_point(Celsius{(75.0 - 32) / 1.8}));
  EXPECT_EQ(unit.words[2160], 0x0000);
  EXPECT_EQ(unit.words[2161], 0x4296) << "75.0 °F in the communications manual";
}

/// In data map 2 the register of the control mode is half of an alarm limit.
TEST(EzZone, IsRefusedWithDataMap2) {
  auto unit = ez_zone(15);
  const auto chamber = unit.on_map(shipped_map("watlow_ez_zone_pm"));
  ASSERT_TRUE(chamber->identify());
  unit.set_float(1880, 300);
  const auto other = chamber->identify();
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().kind, FaultKind::mismatch);
  EXPECT_TRUE(unit.written.empty());
}

/// In another order, the value is near zero for every set point.
TEST(WordOrder, AcceptsTinyValueOfCorrectOrder) {
  const auto map = shipped_map("watlow_f4t");
  for (const float celsius : {21.0F, 23.3F, -40.25F, 19.97F, 70.1F}) {
    ActiveUnit unit;
    unit.set_float(0, celsius);
    const std::vector<std::uint16_t> words{unit.words[0], unit.words[1]};
    const auto findings = probe_word_order(*map.find("air_temperature"), words, *map.find("set_point"), words);
    EXPECT_TRUE(findings.front().plausible) << celsius;
    for (std::size_t i = 1; i < findings.size(); ++i)
      EXPECT_FALSE(findings[i].plausible && std::abs(findings[i].air_c) < 0.05) << celsius << " " << findings[i].air_c;
    EXPECT_FALSE(has_wrong_word_order(findings)) << celsius;
  }
  for (const float near_zero : {0.004F, -0.03F}) {
    ActiveUnit unit;
    unit.set_float(0, near_zero);
    const std::vector<std::uint16_t> words{unit.words[0], unit.words[1]};
    const auto findings = probe_word_order(*map.find("air_temperature"), words, *map.find("set_point"), words);
    EXPECT_FALSE(has_wrong_word_order(findings)) << near_zero << " is a temperature too";
  }
}

TEST(EveryMap, StatesWhatItVerifiesAndWhatItCannot) {
  std::set<std::string> seen;
  for (const auto& file : std::filesystem::directory_iterator(kMaps)) {
    if (file.path().extension() != ".toml") continue;
    const auto name = file.path().stem().string();
    const auto map = shipped_map(name);
    const auto& verification = map.verification;
    seen.insert(name);
    if (name.starts_with("virtual")) continue;
    EXPECT_FALSE(verification.not_verified.empty()) << name;
    if (map.identity) {
      EXPECT_FALSE(verification.verifies.empty()) << name;
    } else {
      EXPECT_NE(verification.not_verified.front().find("make"), std::string::npos) << name;
    }
  }
  EXPECT_EQ(seen.size(), 30u);
}

/// Returns the activity that a map derives from its items, as the chamber does: the first matching rule decides.
ChamberActivity activity_of(const RegisterMap& map, const std::map<std::string, double>& values) {
  for (const auto& rule : map.states)
    if (const auto value = values.find(rule.when.item); value != values.end() && holds(rule.when, value->second))
      return rule.activity;
  return ChamberActivity::unknown;
}

/// Returns a value for each code of an item, and one for each bit that a rule names.
std::vector<double> values_of(const RegisterMap& map, const RegisterItem& item) {
  std::set<double> values;
  for (const auto& [meaning, codes] : item.codes)
    for (const auto code : codes) values.insert(static_cast<double>(code));
  const bool is_of_bits = std::ranges::any_of(
      map.states, [&](const StateRule& rule) { return rule.when.item == item.name && rule.when.bits != 0; });
  if (is_of_bits || values.empty()) values.insert(0);
  for (const auto& rule : map.states) {
    if (rule.when.item != item.name) continue;
    for (std::uint32_t bit = 1; bit != 0; bit <<= 1)
      if ((rule.when.bits & bit) != 0) values.insert(bit);
    if (rule.when.above) values.insert(*rule.when.above + 1);
  }
  return {values.begin(), values.end()};
}

/// Calls `see` with each combination of values of the items in a map's rules.
void for_each_combination(const RegisterMap& map,
                          const std::function<void(const std::map<std::string, double>&)>& see) {
  std::map<std::string, std::vector<double>> items;
  for (const auto& rule : map.states) items.try_emplace(rule.when.item, values_of(map, *map.find(rule.when.item)));
  std::map<std::string, double> values;
  const auto next = [&](const auto& self, auto item) -> void {
    if (item == items.end()) return see(values);
    for (const double value : item->second) {
      values[item->first] = value;
      self(self, std::next(item));
    }
  };
  next(next, items.begin());
}

/// A mode without a state would not cast doubt on the set point.
TEST(EveryMap, HasStateForEachModeCode) {
  int combinations = 0;
  std::set<std::string> not_following;
  for (const auto& file : std::filesystem::directory_iterator(kMaps)) {
    if (file.path().extension() != ".toml") continue;
    const auto name = file.path().stem().string();
    const auto map = shipped_map(name);
    if (map.states.empty()) continue;
    for_each_combination(map, [&](const auto& values) {
      ++combinations;
      const auto activity = activity_of(map, values);
      std::string shown;
      for (const auto& [item, value] : values) shown += fmt::format(" {} = {:g}", item, value);
      EXPECT_NE(activity, ChamberActivity::unknown) << name << ":" << shown;
      if (activity == ChamberActivity::not_following) not_following.insert(name);
      const auto is_manual = [&](const auto& one) {
        const auto* item = map.find(one.first);
        const auto codes = item->codes.find("manual");
        return codes != item->codes.end() && std::ranges::count(codes->second, std::int64_t(one.second)) > 0;
      };
      if (name.starts_with("watlow_f4t") && std::ranges::any_of(values, is_manual)) {
        EXPECT_NE(activity, ChamberActivity::running) << name << ":" << shown << ": a manual output follows nothing";
      }
    });
  }
  EXPECT_GT(combinations, 100);
  EXPECT_TRUE(not_following.contains("watlow_f4t") && not_following.contains("watlow_f4t_cascade"));
}

/// The basic mode returns to idle by itself. The mode is a bit field.
TEST(BinderMb1, ConfirmsStopByAnyIdleMode) {
  struct Case {
    /// Mode after the basic mode was commanded.
    std::uint16_t shown;
    bool is_stopped;
  };
  for (const auto& [shown, is_stopped] : {Case{0, true}, Case{0x1000, true}, Case{0x1001, true}, Case{0x0002, true},
                                          Case{0x0800, false}, Case{0x0801, false}, Case{0x0400, false}}) {
    ActiveUnit unit;
    unit.words[0x1A22] = 0x0800;
    unit.reacts = [&unit, shown = shown](std::uint16_t, std::uint16_t) { unit.words[0x1A22] = shown; };
    const auto stopped = unit.on_map(shipped_map("binder_mb1"))->stop();
    EXPECT_EQ(stopped.has_value(), is_stopped) << shown;
    EXPECT_EQ(unit.written_to(0x1A22), std::vector<std::uint16_t>{0x1000});
  }
}

TEST(BinderMb1, ConfirmsStartByManualModeBit) {
  for (const auto& [shown, is_started] : {std::pair<std::uint16_t, bool>{0x0800, true}, {0x0801, true}, {0, false}}) {
    ActiveUnit unit;
    unit.words[0x1A22] = 0;
    unit.reacts = [&unit, shown = shown](std::uint16_t, std::uint16_t) { unit.words[0x1A22] = shown; };
    EXPECT_EQ(unit.on_map(shipped_map("binder_mb1"))->start().has_value(), is_started) << shown;
  }
}

/// The unit ignores set points while it is off, and its set point cannot be read.
TEST(UnreadableSetPoint, IsSentAgainAfterStart) {
  ActiveUnit unit;
  const auto map = shipped_map("tt5166");
  const auto address = static_cast<std::uint16_t>(map.find("set_point")->address);
  ASSERT_FALSE(map.find("set_point")->readable);
  for (int word = 0; word < 4096; ++word) unit.words[static_cast<std::uint16_t>(word)] = 0;
  const auto chamber = unit.on_map(map);
  ASSERT_TRUE(chamber->send_set_point({30}));
  ASSERT_EQ(unit.written_to(address).size(), 1U);
  (void)chamber->start();
  ASSERT_EQ(unit.written_to(address).size(), 2U);
  EXPECT_EQ(unit.written_to(address)[0], unit.written_to(address)[1]);
  EXPECT_EQ(unit.written.back().first, address) << "after the command that starts it";
}

/// The event output of a TestEquity chamber.
TEST(PowerSwitch, IsSwitchedOnBeforeTheLoopAndOffAfterIt) {
  for (const auto* map : {"watlow_f4t", "watlow_f4t_cascade"}) {
    auto unit = f4t(map == std::string("watlow_f4t") ? "1" : "7");
    take_modes(unit);
    unit.words[16594] = 62;
    const auto chamber = unit.on_map(shipped_map(map, "event_1"));
    EXPECT_EQ(chamber->inspect().value().activity, ChamberActivity::off);
    ASSERT_TRUE(chamber->start());
    EXPECT_EQ(unit.written.front(), (std::pair<std::uint16_t, std::uint16_t>{16594, 63}));
    EXPECT_EQ(chamber->inspect().value().activity, ChamberActivity::running);
    ASSERT_TRUE(chamber->start());
    EXPECT_EQ(unit.written_to(16594).size(), 1u) << "it is on";
    ASSERT_TRUE(chamber->stop());
    EXPECT_EQ(unit.written.back(), (std::pair<std::uint16_t, std::uint16_t>{16594, 62}));
    EXPECT_EQ(chamber->inspect().value().activity, ChamberActivity::off);
  }
}

/// The key of an ESPEC chamber. A second press stops the chamber.
TEST(PowerSwitch, PressesKeyOnlyIfOutputIsOff) {
  auto unit = f4t("1");
  unit.words[33718] = 62;
  unit.words[6850] = 1456;
  unit.reacts = [&unit](std::uint16_t address, std::uint16_t word) {
    if (address == 2730) unit.words[2814] = word;
    if (address == 6850 && word == 1457) unit.words[33718] = unit.words[33718] == 63 ? 62 : 63;
  };
  const auto chamber = unit.on_map(shipped_map("watlow_f4t", "key_1"));
  const auto presses = [&] { return std::ranges::count(unit.written_to(6850), 1457); };
  ASSERT_TRUE(chamber->start());
  EXPECT_EQ(unit.words[33718], 63);
  ASSERT_TRUE(chamber->start());
  EXPECT_EQ(presses(), 1) << "a second press would stop it";
  ASSERT_TRUE(chamber->stop());
  EXPECT_EQ(unit.words[33718], 62);
  ASSERT_TRUE(chamber->stop());
  EXPECT_EQ(presses(), 2);
}

TEST(PowerSwitch, IsNotSwitchedUnlessRigNamesIt) {
  auto unit = f4t("1");
  take_modes(unit);
  unit.words[16594] = unit.words[33718] = 62;
  unit.words[6850] = 1456;
  const auto chamber = unit.on_map(shipped_map("watlow_f4t"));
  ASSERT_TRUE(chamber->start());
  ASSERT_TRUE(chamber->stop());
  EXPECT_TRUE(unit.written_to(16594).empty());
  EXPECT_TRUE(unit.written_to(6850).empty());
  const auto map = shipped_map("watlow_f4t");
  EXPECT_EQ(select_power_switch(map, "event_9").error().kind, FaultKind::usage);
  EXPECT_EQ(select_power_switch(shipped_map("binder_mb1"), "event_1").error().kind, FaultKind::usage);
}

TEST(F4tLimitModule, RaisesStopAlarmWhenTripped) {
  struct Case {
    std::uint16_t address, code;
  };
  for (const auto& [address, code] : {Case{11250, 28}, Case{11264, 32}, Case{11288, 12}}) {
    auto unit = f4t("1");
    unit.words[11250] = 61;
    unit.words[11264] = 61;
    unit.words[11288] = 61;
    const auto chamber = unit.on_map(shipped_map("watlow_f4t"));
    EXPECT_FALSE(chamber->inspect().value().must_stop);
    unit.words[address] = code;
    EXPECT_TRUE(chamber->inspect().value().must_stop) << address;
  }
}

}  // namespace
}  // namespace gyrotherm::drivers
