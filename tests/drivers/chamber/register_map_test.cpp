// SPDX-License-Identifier: Apache-2.0
#include "drivers/chamber/register_map.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>
#include <string>

#include "tests/drivers/line/words.hpp"

namespace gyrotherm::drivers {
namespace {

const std::filesystem::path kChambers = std::filesystem::path(GYROTHERM_SOURCE_DIR) / "profiles/chambers";

std::string content(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

RegisterItem item(RegisterType type, WordOrder order = WordOrder::abcd, double scale = 1) {
  RegisterItem made;
  made.name = "item";
  made.type = type;
  made.order = order;
  made.scale = scale;
  return made;
}

// libmodbus 3.1.6 in Debian swaps the bytes of each of these, so this codec replaces its functions.
TEST(RegisterValue, PinsTheWordOrdersOfAFloat) {
  EXPECT_EQ(encode(item(RegisterType::f32, WordOrder::abcd), -40.25), (Words{0xC221, 0x0000}));
  EXPECT_EQ(encode(item(RegisterType::f32, WordOrder::cdab), -40.25), (Words{0x0000, 0xC221}));
  EXPECT_EQ(encode(item(RegisterType::f32, WordOrder::badc), -40.25), (Words{0x21C2, 0x0000}));
  EXPECT_EQ(encode(item(RegisterType::f32, WordOrder::dcba), -40.25), (Words{0x0000, 0x21C2}));
}

TEST(RegisterValue, ScalesRoundsAndSaturates) {
  EXPECT_EQ(encode(item(RegisterType::s16, {}, 0.1), -40.0), Words{0xFE70}) << "EZT-570i, -40.0 °C";
  EXPECT_EQ(encode(item(RegisterType::s16, {}, 0.1), 20.04), Words{200});
  EXPECT_EQ(encode(item(RegisterType::s16), 1e9), Words{0x7FFF});
  EXPECT_EQ(encode(item(RegisterType::s16), -1e9), Words{0x8000});
  EXPECT_EQ(encode(item(RegisterType::u16), -1), Words{0});
  EXPECT_EQ(encode(item(RegisterType::u32), 1e12), (Words{0xFFFF, 0xFFFF}));
}

TEST(RegisterValue, ReadsBackWhatItWrote) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> celsius(-100, 300);
  for (const auto type : {RegisterType::s16, RegisterType::s32, RegisterType::f32})
    for (const auto order : {WordOrder::abcd, WordOrder::cdab, WordOrder::badc, WordOrder::dcba})
      for (int i = 0; i < 200; ++i) {
        const auto described = item(type, order, 0.01);
        const double value = celsius(random);
        EXPECT_NEAR(decode(described, encode(described, value)).value(), value, 0.0051);
      }
}

TEST(RegisterValue, NotANumberIsCorrupted) {
  EXPECT_EQ(decode(item(RegisterType::f32), Words{0x7FC0, 0}).error().kind, FaultKind::corrupted);
  EXPECT_EQ(decode(item(RegisterType::f32), Words{0x7F80, 0}).error().kind, FaultKind::corrupted);
}

std::vector<std::filesystem::path> shipped_maps() {
  std::vector<std::filesystem::path> maps;
  for (const auto& file : std::filesystem::directory_iterator(kChambers))
    if (file.path().extension() == ".toml") maps.push_back(file.path());
  return maps;
}

TEST(RegisterMap, ParsesEveryShippedMap) {
  int maps = 0;
  for (const auto& path : shipped_maps()) {
    const auto map = parse_register_map(content(path), path.filename());
    EXPECT_TRUE(map) << text(map.error());
    ++maps;
  }
  EXPECT_GE(maps, 13);
}

TEST(RegisterMap, ReadsWatlowF4TMap) {
  const auto map = parse_register_map(content(kChambers / "watlow_f4t.toml"), "watlow_f4t.toml");
  ASSERT_TRUE(map) << text(map.error());
  EXPECT_EQ(map->find("set_point")->address, 2782);
  EXPECT_EQ(map->find("air_temperature")->address, 2820);
  EXPECT_EQ(encode(*map->find("set_point"), -40.25), (Words{0x0000, 0xC221})) << "low word first by default";
  ASSERT_TRUE(map->control);
  EXPECT_EQ(map->control->on, 10);
  EXPECT_EQ(map->control->off, 62);
  EXPECT_EQ(map->find("control_mode")->address, 2730);
  EXPECT_EQ(map->find(map->control->active)->address, 2814);
}

TEST(RegisterMap, WhereTheUnitOfTheSetPointIsAskedForThatOfTheProgramIsToo) {
  int asked = 0;
  for (const auto& path : shipped_maps()) {
    const auto map = parse_register_map(content(path), path.filename());
    ASSERT_TRUE(map) << text(map.error());
    const auto& unit = map->find("set_point")->unit;
    if (unit.empty() || !map->memory) continue;
    for (const auto* blocks : {&map->memory->header, &map->memory->step, &map->memory->footer})
      for (const auto& block : *blocks)
        for (const auto& [at, source, constant, form] : block.cells) {
          const bool is_difference = source == CellSource::soak_band || source == CellSource::rate;
          if (!is_difference && source != CellSource::start && source != CellSource::target) continue;
          EXPECT_EQ(form.unit, unit) << path << ", register " << block.address;
          EXPECT_EQ(form.step, is_difference) << path << ", register " << block.address;
          ++asked;
        }
  }
  EXPECT_EQ(asked, 5) << "target and band of the two F4T maps, target of the F4";
}

TEST(RegisterMap, LetsUserOverrideDefaultWordOrder) {
  const auto map = parse_register_map(content(kChambers / "watlow_f4t.toml"), "watlow_f4t.toml", WordOrder::abcd);
  ASSERT_TRUE(map) << text(map.error());
  EXPECT_EQ(encode(*map->find("set_point"), -40.25), (Words{0xC221, 0x0000}));
}

constexpr const char* kSmallest = R"(schema = "gyrotherm-chamber/1"
name = "n"
vendor = "v"
source = "s"
[[register]]
name = "air_temperature"
address = 10
type = "s16"
scale = 0.1
[[register]]
name = "set_point"
address = 300
type = "s16"
access = "rw"
scale = 0.1
)";

std::string mistakes_in(const std::string& map) {
  const auto parsed = parse_register_map(map, "map.toml");
  return parsed ? "" : text(parsed.error());
}

TEST(RegisterMap, ParsesMinimalMap) {
  EXPECT_EQ(mistakes_in(kSmallest), "");
  const auto map = parse_register_map(kSmallest, "map.toml").value();
  EXPECT_EQ(map.link.modbus.port, 502);
  EXPECT_EQ(map.link.modbus.unit, 1);
  EXPECT_DOUBLE_EQ(map.find("set_point")->resolution, 0.1);
  EXPECT_FALSE(map.identity);
  EXPECT_FALSE(map.control);
  EXPECT_EQ(map.text, kSmallest);
}

TEST(RegisterMap, ReportsEachError) {
  const std::string smallest = kSmallest;
  const auto with = [&](const char* more) { return mistakes_in(smallest + more); };
  EXPECT_NE(with("colour = 3").find("unknown key \"colour\""), std::string::npos);
  EXPECT_NE(with("[[register]]\nname = \"x\"\naddress = 65535\ntype = \"f32\"").find("does not fit"),
            std::string::npos);
  EXPECT_NE(with("[[register]]\nname = \"set_point\"\naddress = 1\ntype = \"u16\"").find("a second register"),
            std::string::npos);
  EXPECT_NE(with("[link]\none_block = true").find("spans 291 registers"), std::string::npos);
  EXPECT_NE(with("[identity]\nregister = \"who\"\nvalue = 1").find("no register is named \"who\""), std::string::npos);
  EXPECT_NE(with("[control]\ncommanded = \"air_temperature\"").find("not writable"), std::string::npos);
  EXPECT_NE(with("[control]\ncommanded = \"set_point\"").find("no code named \"on\""), std::string::npos);
  const std::string state = "[[register]]\nname = \"state\"\naddress = 9\ntype = \"u16\"\n";
  EXPECT_NE(with((state + "codes = { standby = 0, constant = 0 }").c_str()).find("constant and standby are both 0"),
            std::string::npos);
  EXPECT_NE(with((state + "codes = { a = [1, 2], b = [3, 2] }").c_str()).find("a and b are both 2"), std::string::npos);
  EXPECT_NE(with((state + "flags = { door = 4, fan = 4 }").c_str()).find("door and fan are both bit 4"),
            std::string::npos);
  EXPECT_EQ(with((state + "codes = { a = [1, 2], b = 3 }").c_str()), "");
  EXPECT_NE(with("[link]\ngap = \"11 s\"").find("\"gap\" is 11 s, expected at most 10 s"), std::string::npos);
  EXPECT_NE(with("[link]\nminimum_period = \"1 min\"").find("expected at most 10 s"), std::string::npos);
  EXPECT_NE(with("[link]\ntimeout = \"1 s\"\nafter_write = \"7 s\"")
                .find("a pause of 7 s and twice the timeout of 1 s are 9 s"),
            std::string::npos);
  EXPECT_EQ(with("[link]\ntimeout = \"1 s\"\nafter_write = \"6 s\""), "");
  EXPECT_NE(mistakes_in("schema = \"gyrotherm-chamber/1\"").find("\"air_temperature\""), std::string::npos);
}

}  // namespace
}  // namespace gyrotherm::drivers
