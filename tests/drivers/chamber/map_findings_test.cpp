// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>

#include "core/file.hpp"
#include "drivers/chamber/item_exchange.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/chamber/status_turns.hpp"
#include "tests/drivers/line/words.hpp"

namespace gyrotherm::drivers {
namespace {

RegisterMap shipped(const std::string& name) {
  const auto text = read_text_file(GYROTHERM_SOURCE_DIR "/profiles/chambers/" + name + ".toml");
  return parse_register_map(text.value(), name).value();
}

RegisterItem float_item(WordOrder order) {
  RegisterItem item;
  item.name = "x";
  item.type = RegisterType::f32;
  item.order = order;
  return item;
}

TEST(WordOrderProbe, FindsTheOrderThatTheUnitIsSetTo) {
  for (const auto unit : {WordOrder::abcd, WordOrder::cdab, WordOrder::badc, WordOrder::dcba})
    for (const auto map : {WordOrder::abcd, WordOrder::cdab, WordOrder::badc, WordOrder::dcba})
      for (const auto& [air, set_point] : {std::pair{23.41, 20.0}, {-40.25, -40.0}, {85.1, 85.0}, {0.3, 0.0}}) {
        const auto there = float_item(unit), here = float_item(map);
        const auto findings = probe_word_order(here, encode(there, air), here, encode(there, set_point));
        ASSERT_EQ(findings.size(), 4u);
        EXPECT_EQ(findings.front().order, map);
        for (const auto& one : findings)
          EXPECT_EQ(one.plausible, one.order == unit)
              << name(unit) << " read as " << name(one.order) << ": " << one.air_c;
      }
}

TEST(WordOrderProbe, ReportsRequiredChange) {
  const auto there = float_item(WordOrder::abcd), here = float_item(WordOrder::cdab);
  const auto wrong = describe(probe_word_order(here, encode(there, 23.41), here, encode(there, 20)));
  EXPECT_NE(wrong.find("set word_order to abcd (air 23.41 °C, set point 20.00 °C)"), std::string::npos) << wrong;
  const auto right = describe(probe_word_order(here, encode(here, 23.41), here, encode(here, 20)));
  EXPECT_EQ(right, "word order cdab (air 23.41 °C, set point 20.00 °C) fits; no other does");
  EXPECT_NE(describe(probe_word_order(here, Words{0, 0}, here, Words{0, 0})).find("no word order gives a plausible"),
            std::string::npos)
      << "two zeros say nothing";
  RegisterItem short_item;
  short_item.type = RegisterType::s16;
  EXPECT_TRUE(probe_word_order(short_item, Words{1}, short_item, Words{1}).empty());
}

TEST(MapConfidence, ListsUnverifiedItemsInUse) {
  const auto all = list_doubts(shipped("binder_mb1"));
  ASSERT_FALSE(all.empty());
  EXPECT_EQ(all.front().confidence, Confidence::unverified);
  const auto words = describe_confidence(shipped("binder_mb1"));
  EXPECT_NE(words.find("UNVERIFIED: set_point (two sources call it the manual set point"), std::string::npos) << words;
  EXPECT_EQ(describe_confidence(shipped("virtual")), "registers in use: 4 verified");
  EXPECT_NE(describe_confidence(shipped("csz_ezt570i")).find("from the manual"), std::string::npos);
}

TEST(SetPointTolerance, IsOneTenthIfControllerReportsDecimals) {
  for (const auto* name : {"watlow_f4", "watlow_f4t_map2", "watlow_f4t_map3", "watlow_f4t"})
    EXPECT_DOUBLE_EQ(set_point_tolerance(shipped(name)).value, 0.1) << name;
}

TEST(ReadPlan, MergesOnlyWhereHolesMayBeRead) {
  const auto at = [](std::uint16_t address, RegisterType type = RegisterType::u16) {
    RegisterItem item;
    item.address = address;
    item.type = type;
    return item;
  };
  const auto a = at(60), b = at(61, RegisterType::f32), c = at(119), d = at(120);
  const std::vector<const RegisterItem*> items{&d, &b, &a, &c};
  const auto holding = ReadFunction::holding_registers;
  EXPECT_EQ(plan_reads(items, false, 60).size(), 4u);
  EXPECT_EQ(plan_reads(items, true, 60), (std::vector<ReadSpan>{{holding, 60, 60}, {holding, 120, 1}}));
  EXPECT_EQ(plan_reads(items, true, 61), (std::vector<ReadSpan>{{holding, 60, 61}}));
}

TEST(Pattern, MatchesAnythingWithStar) {
  EXPECT_TRUE(matches("F4T*", "F4T1L2"));
  EXPECT_TRUE(matches("*", ""));
  EXPECT_TRUE(matches("F*T*9", "F4T199"));
  EXPECT_FALSE(matches("F4T*", "F4D"));
  EXPECT_FALSE(matches("F4T", "F4T1"));
}

TEST(ChamberSchema, EveryShippedMapIsValidForEditorsToo) {
  const std::string root = GYROTHERM_SOURCE_DIR;
  const auto command = "python3 " + root + "/tests/drivers/chamber/validate_maps.py " + root + "/profiles/chambers";
  const int status = std::system(command.c_str());
  if (!WIFEXITED(status) || WEXITSTATUS(status) == 77 || WEXITSTATUS(status) == 127)
    GTEST_SKIP() << "python3 with python3-jsonschema is not installed";
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

}  // namespace
}  // namespace gyrotherm::drivers
