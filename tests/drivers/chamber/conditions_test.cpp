// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "core/file.hpp"
#include "drivers/chamber/modbus_chamber.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/chamber/text_registers.hpp"
#include "drivers/line/pauses.hpp"
#include "tests/drivers/chamber/two_registers.hpp"
#include "tests/support/fakes.hpp"

namespace gyrotherm::drivers {
namespace {

/// A unit that answers each question with a fixed line.
class FixedAnswers final : public ByteStream {
 public:
  explicit FixedAnswers(std::map<std::string, std::string> answers) : answers_(std::move(answers)) {}
  Result<std::size_t> read(std::span<std::byte> buffer, Duration) override {
    if (coming_.empty()) return failure(FaultKind::timeout, "unit", "nothing came");
    const auto bytes = std::exchange(coming_, "");
    std::ranges::copy(std::as_bytes(std::span(bytes)), buffer.begin());
    return bytes.size();
  }
  Result<void> write(std::span<const std::byte> bytes, Duration) override {
    const std::string line(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    coming_ = answers_[line];
    return {};
  }

 private:
  std::map<std::string, std::string> answers_;
  std::string coming_;
};

/// Returns the state of a text chamber with these answers.
Result<ChamberState> inspect(const RegisterMap& map, std::map<std::string, std::string> answers) {
  auto registers = make_text_registers(map, std::make_unique<FixedAnswers>(std::move(answers)), "unit");
  return make_modbus_chamber(map, std::move(registers), make_virtual_pauses(), {})->inspect();
}

RegisterMap cts_map() {
  const auto file = read_text_file(GYROTHERM_SOURCE_DIR "/profiles/chambers/cts.toml");
  return parse_register_map(file.value(), "cts.toml").value();
}

TEST(Conditions, EachGraveErrorOfCtsStopsRun) {
  const auto map = cts_map();
  const std::set<char> grave{'1', '2', '3', '4', '5', '6'};
  int stops = 0, warnings = 0, silent = 0;
  for (int byte = 0; byte < 0x7F; ++byte) {
    const auto error = static_cast<char>(byte);
    const auto state =
        inspect(map, {{"U1", "U1 999.9 999.9"}, {"A0", "A0 020.0 020.0"}, {"S", std::string("S10100000") + error}});
    ASSERT_TRUE(state) << byte << ": " << text(state.error());
    const bool is_warning = byte >= 1 && byte <= 6, is_none = byte == 0 || error == '0';
    EXPECT_EQ(state->must_stop, !is_warning && !is_none) << byte;
    EXPECT_EQ(state->alarms.size(), is_none ? 0u : 1u) << byte;
    stops += state->must_stop && grave.contains(error) ? 1 : 0;
    warnings += is_warning && !state->must_stop ? 1 : 0;
    silent += is_none ? 1 : 0;
  }
  EXPECT_EQ(stops, 6);
  EXPECT_EQ(warnings, 6);
  EXPECT_EQ(silent, 2);
}

TEST(Conditions, NamedErrorsOfCtsFitTheirRules) {
  const auto map = cts_map();
  const auto& item = *map.find("error_number");
  int named = 0;
  for (const auto& [name, codes] : item.codes)
    for (const auto code : codes) {
      const auto fitting = std::ranges::count_if(map.alarms, [&](const AlarmRule& rule) {
        return rule.when.item == item.name && holds(rule.when, static_cast<double>(code));
      });
      EXPECT_EQ(fitting, name == "none" ? 0 : 1) << name;
      ++named;
    }
  EXPECT_EQ(named, 14);
}

const std::string kRegisterMap = std::string(kTwoRegisters) + R"([[register]]
name = "state"
address = 9
type = "u16"
)";

constexpr const char* kLineMap = R"(schema = "gyrotherm-text/1"
kind = "chamber"
name = "n"
vendor = "v"
source = "s"
[link]
question_end = "\n"
answer_end = "\n"
[link.tcp]
port = 10001
[[item]]
name = "air_temperature"
ask = "T?"
answer = "{value:f.1}"
[[item]]
name = "set_point"
ask = "S?"
answer = "{value:f.1}"
tell = "S{value:f.1}"
acknowledged = "OK"
[[item]]
name = "state"
ask = "M?"
)";

/// Returns a map of registers whose register "state" has these keys, with an alarm under the condition.
std::string with_rule(const std::string& keys, const std::string& condition) {
  return kRegisterMap + keys + "\n[[alarm]]\nregister = \"state\"\n" + condition + "\n";
}
/// Returns a map of lines likewise, whose item "state" is a whole number.
std::string with_line_rule(const std::string& keys, const std::string& condition) {
  return kLineMap + std::string("answer = \"{value:d}\"\n") + keys + "\n[[alarm]]\nitem = \"state\"\n" + condition +
         "\n";
}

/// Returns the values from 0 to 9 that satisfy the condition, in both kinds of map.
std::string find_fitting(const std::string& keys, const std::string& condition) {
  std::string all;
  for (const auto& file : {with_rule(keys, condition), with_line_rule(keys, condition)}) {
    const auto map = parse_register_map(file, "map.toml");
    EXPECT_TRUE(map) << condition << ": " << text(map.error());
    if (!map) return "refused";
    std::string values;
    for (int value = 0; value < 10; ++value)
      if (holds(map->alarms.front().when, value)) values += static_cast<char>('0' + value);
    EXPECT_TRUE(all.empty() || values == all) << condition << ": " << values << " and " << all;
    all = values;
  }
  return all;
}

/// Returns the error of each kind of map, one below the other.
std::string find_errors(const std::string& keys, const std::string& condition) {
  std::string errors;
  for (const auto& file : {with_rule(keys, condition), with_line_rule(keys, condition)})
    if (const auto map = parse_register_map(file, "map.toml"); !map) errors += text(map.error()) + "\n";
  return errors;
}

TEST(Conditions, ListHoldsForEachNameAndForOtherValues) {
  const std::string keys = "codes = { none = 0, water = [1, 2], limiter = 5, fan = 6 }\notherwise = \"unlisted\"";
  const std::pair<const char*, const char*> cases[] = {
      {R"("unlisted")", "34789"},
      {R"(["limiter", "fan", "unlisted"])", "3456789"},
      {R"(["unlisted", "limiter", "fan"])", "3456789"},
      {R"(["limiter", "unlisted", "water"])", "12345789"},
      {R"(["limiter", "fan"])", "56"},
      {R"(["none", "water", "limiter", "fan", "unlisted"])", "0123456789"}};
  for (const auto& [names, fitting] : cases) {
    EXPECT_EQ(find_fitting(keys, std::string("is = ") + names), fitting);
    std::string others;
    for (char value = '0'; value <= '9'; ++value)
      if (std::string(fitting).find(value) == std::string::npos) others += value;
    EXPECT_EQ(find_fitting(keys, std::string("is_not = ") + names), others);
  }
}

TEST(Conditions, NameOfCodeMayBeThatOfOtherValues) {
  const std::string keys = "codes = { good = [0, 1], bad = 4 }\notherwise = \"bad\"";
  EXPECT_EQ(find_fitting(keys, "is = \"bad\""), "23456789");
  EXPECT_EQ(find_fitting(keys, "is_not = \"bad\""), "01");
  EXPECT_EQ(find_fitting(keys, "is = [\"bad\", \"good\"]"), "0123456789");
}

TEST(Conditions, RefuseFlagsWithNameOfOtherValues) {
  const std::string keys = "codes = { idle = 0 }\nflags = { door = 3, fan = 4 }\notherwise = \"busy\"";
  for (const auto* names : {R"(["door", "busy"])", R"(["busy", "fan"])", R"(["idle", "busy", "door"])"})
    for (const auto* key : {"is", "is_not"}) {
      const auto errors = find_errors(keys, std::string(key) + " = " + names);
      EXPECT_EQ(errors.find("map.toml:"), 0u) << errors;
      EXPECT_NE(errors.find("write a condition for the flags and another for \"busy\""), std::string::npos) << errors;
      EXPECT_NE(errors.find("map.toml:", 1), std::string::npos) << "both kinds of map: " << errors;
    }
  EXPECT_EQ(find_errors(keys, "is = \"busy\""), "");
  EXPECT_EQ(find_errors(keys, "is = [\"door\", \"idle\"]"), "");
}

TEST(Conditions, RefuseNameOfOtherValuesWithoutCodes) {
  for (const auto* keys : {"otherwise = \"bad\"", "flags = { fan = 2 }\notherwise = \"bad\""}) {
    const auto errors = find_errors(keys, "is = \"bad\"");
    EXPECT_NE(errors.find("\"state\" has no codes; name the values that are not \"bad\""), std::string::npos) << errors;
  }
}

TEST(Conditions, RefuseNumbersThatAreNotWhole) {
  const auto expect = [](const std::string& keys, const std::string& condition, const std::string& part) {
    const auto errors = find_errors(keys, condition);
    const auto first = errors.find(part);
    EXPECT_NE(first, std::string::npos) << keys << condition << ": " << errors;
    EXPECT_NE(errors.find(part, first + 1), std::string::npos) << "both kinds of map: " << errors;
  };
  expect("", "bits = [3.5]", "\"bits\" contains 3.5, expected whole numbers from 0 to 31");
  expect("", "bits = [1, 32]", "contains 32");
  expect("", "bits = [-1]", "contains -1");
  expect("codes = { a = [1, 2.5] }", "is = \"a\"", "\"a\" contains 2.5");
  expect("codes = { a = [1e17, 2] }", "is = \"a\"", "\"a\" contains 1e+17");
  EXPECT_EQ(find_fitting("", "bits = [1, 3.0]"), "236789");
}

TEST(Conditions, BitsOfNumber) {
  EXPECT_EQ(lower_bits(5), 5u);
  EXPECT_EQ(lower_bits(-2), 0xFFFFFFFEu);
  EXPECT_EQ(lower_bits(4294967299.0), 3u);
  EXPECT_EQ(lower_bits(9007199254740992.0), 0u);
  for (const double none : {1e16, -1e16, 1e30, std::numeric_limits<double>::max(),
                            std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_FALSE(lower_bits(none)) << none;
    EXPECT_FALSE(lower_bits(-none)) << none;
  }
}

TEST(Conditions, NumberWithoutBitsIsNotRead) {
  const auto map = parse_register_map(std::string(kLineMap) +
                                          "answer = \"{value:f}\"\n[[alarm]]\nseverity = \"stop\"\nitem = \"state\"\n"
                                          "bits = [1]\n",
                                      "map.toml");
  ASSERT_TRUE(map) << text(map.error());
  const auto with = [&](const std::string& state) {
    return inspect(*map, {{"T?\n", "20.0\n"}, {"S?\n", "20.0\n"}, {"M?\n", state + "\n"}});
  };
  for (const auto* stops : {"2", "-2", "6", "4294967298"}) EXPECT_TRUE(with(stops).value().must_stop) << stops;
  for (const auto* silent : {"0", "-4", "5"}) EXPECT_FALSE(with(silent).value().must_stop) << silent;
  for (const auto* none : {"1e30", "-1e30", "1e16"}) {
    const auto state = with(none);
    ASSERT_FALSE(state) << none;
    EXPECT_NE(state.error().what.find("which has no bits"), std::string::npos) << state.error().what;
    const auto& when = map->alarms.front().when;
    EXPECT_EQ(evaluate(when, *map->find("state"), std::stod(none)).error().kind, FaultKind::corrupted);
  }
}

/// Expects the same error in both kinds of map.
void expect_both_refuse(const std::string& keys, const std::string& condition, const std::string& part) {
  const auto errors = find_errors(keys, condition);
  const auto first = errors.find(part);
  EXPECT_NE(first, std::string::npos) << keys << " " << condition << ": " << errors;
  if (first == std::string::npos) return;
  EXPECT_NE(errors.find(part, first + 1), std::string::npos) << condition << ": " << errors;
}

TEST(Conditions, RefuseKeysThatExcludeEachOther) {
  const std::string keys = "codes = { idle = 0, busy = 1 }";
  const std::vector<std::string> all{"is = \"idle\"", "is_not = [\"busy\"]", "bits = [1]", "above = 2"};
  const std::vector<std::string> names{"is", "is_not", "bits", "above"};
  int pairs = 0;
  for (std::size_t i = 0; i < all.size(); ++i)
    for (std::size_t k = i + 1; k < all.size(); ++k, ++pairs) {
      const auto part = "\"" + names[i] + "\" and \"" + names[k] + "\" exclude each other";
      expect_both_refuse(keys, all[i] + "\n" + all[k], part);
      expect_both_refuse(keys, all[k] + "\n" + all[i], part);
      EXPECT_EQ(find_errors(keys, all[i] + "\n" + all[k]).find("unknown key"), std::string::npos);
    }
  EXPECT_EQ(pairs, 6);
}

TEST(Conditions, RefuseEmptyLists) {
  for (const auto* keys : {"flags = { fan = 2 }", "codes = { idle = 0 }"})
    for (const std::string key : {"is", "is_not", "bits"})
      expect_both_refuse(keys, key + " = []", "\"" + key + "\" is empty");
  EXPECT_EQ(find_fitting("flags = { fan = 2 }", ""), "4567") << "any flag";
}

TEST(Conditions, RefuseNumbersThatItemNeverHas) {
  expect_both_refuse("highest = 5", "above = 5", "a value above 5 is impossible by \"highest\" = 5 of \"state\"");
  expect_both_refuse("highest = 5", "above = 7.5", "a value above 7.5 is impossible");
  expect_both_refuse("scale = 0.1", "bits = [1]", "has a scale, an offset or a unit, so that its value has no bits");
  EXPECT_EQ(find_errors("highest = 5", "above = 4.9"), "");
  EXPECT_EQ(find_errors("scale = 0.1", "above = 3"), "");
  const auto errors = [](const std::string& keys, const std::string& bits) {
    const auto map = parse_register_map(with_rule(keys, bits), "map.toml");
    return map ? std::string() : text(map.error());
  };
  EXPECT_NE(errors("", "bits = [16]").find("the field of \"state\" has the bits 0 to 15"), std::string::npos);
  EXPECT_EQ(errors("", "bits = [15]"), "");
}

TEST(Conditions, RefuseRegistersThatCannotBeRead) {
  const std::string keys = "access = \"w\"\ncodes = { on = 1 }";
  const std::string part = "register \"state\" cannot be read, so that this condition would never be true";
  const std::string rest[] = {
      "[[alarm]]\nregister = \"state\"\nis = \"on\"",
      "[[state]]\nactivity = \"off\"\nregister = \"state\"\nis = \"on\"",
      "[sequence]\nstart = [{ wait = { register = \"state\", is = \"on\" } }]",
      "[sequence]\nstart = [{ when = { register = \"state\", is = \"on\" }, pause = \"1 s\" }]"};
  for (const auto& rule : rest) {
    const auto map = parse_register_map(kRegisterMap + keys + "\n" + rule + "\n", "map.toml");
    ASSERT_FALSE(map) << rule;
    EXPECT_NE(text(map.error()).find(part), std::string::npos) << text(map.error());
  }
}

TEST(Conditions, PowerSwitchMayCompareNumber) {
  const std::string file = kRegisterMap + R"(access = "rw"
[sequence]
start = [{ write = "state", value = 5 }]
stop = [{ write = "state", value = 0 }]
[[power]]
name = "main"
register = "state"
above = 3
on = [{ write = "state", value = 9 }]
off = [{ write = "state", value = 1 }]
)";
  const auto map = select_power_switch(parse_register_map(file, "map.toml").value(), "main").value();
  const auto& off = map.states.front();
  EXPECT_EQ(off.activity, ChamberActivity::off);
  EXPECT_TRUE(holds(off.when, 3));
  EXPECT_TRUE(holds(off.when, 0));
  EXPECT_FALSE(holds(off.when, 4));
}

TEST(ItemNames, RefusedIfNoValueHasThem) {
  expect_both_refuse("codes = { off = 0, tripped = 5 }\nsentinels = { none = 5 }", "is = \"tripped\"",
                     "the code 5 of \"tripped\" never occurs: \"sentinels\", \"lowest\" or");
  expect_both_refuse("codes = { off = 0, tripped = 5 }\nhighest = 4", "is = \"tripped\"",
                     "the code 5 of \"tripped\" never occurs: \"sentinels\", \"lowest\" or \"highest\" exclude it");
  expect_both_refuse("codes = { off = 0, tripped = 5 }\nlowest = 1", "is = \"tripped\"", "the code 0 of \"off\"");
  expect_both_refuse("flags = { fan = 2, door = 3 }\nhighest = 7", "is = \"door\"", "\"door\" is never set");
  expect_both_refuse("codes = { door = 1 }\nflags = { door = 3 }", "is = \"door\"",
                     "\"door\" is the name of a flag and of a code");
  expect_both_refuse("codes = { shut = 1 }\notherwise = \"door\"\nflags = { door = 3 }", "is = \"shut\"",
                     "\"door\" is the name of a flag and of a code");
  EXPECT_EQ(find_fitting("codes = { off = 0, tripped = 4 }\nsentinels = { none = 5 }\nhighest = 4", "is = \"tripped\""),
            "4");
}

TEST(ItemNames, OfRegistersFitTheirTypes) {
  const auto errors = [](const std::string& type, const std::string& keys) {
    auto file = with_rule(keys, "is = \"x\"");
    file.replace(file.rfind("\"u16\""), 5, "\"" + type + "\"");
    const auto map = parse_register_map(file, "map.toml");
    return map ? std::string() : text(map.error());
  };
  const std::string never = "of \"x\" never occurs: the nearest value is ";
  for (const auto& [type, keys, nearest] :
       {std::tuple("u16", "codes = { x = 65536 }", "65535"), std::tuple("u16", "codes = { x = -1 }", "0"),
        std::tuple("s16", "codes = { x = 65535 }", "32767"), std::tuple("s16", "codes = { x = [1, 32768] }", "32767"),
        std::tuple("u32", "codes = { x = 4294967296 }", "4.29497e+09"),
        std::tuple("f32", "codes = { x = 16777217 }", ""), std::tuple("u16", "codes = { x = 5 }\nscale = 2", "6")}) {
    EXPECT_NE(errors(type, keys).find(never + nearest), std::string::npos)
        << type << keys << ": " << errors(type, keys);
  }
  EXPECT_NE(errors("bits", "bit = 3\ncodes = { x = 2 }").find(never + "1"), std::string::npos);
  EXPECT_NE(errors("u16", "flags = { x = 2 }\nscale = 0.1").find("has flags, which have no scale"), std::string::npos);
  EXPECT_NE(errors("text", "characters = 4\ncodes = { x = 2 }").find("is not a number"), std::string::npos);
  for (const auto& [type, keys] :
       {std::pair("u16", "codes = { x = 65535 }"), std::pair("s16", "codes = { x = [-1, 32767] }"),
        std::pair("u32", "codes = { x = 4294967295 }"), std::pair("bits", "bit = 3\nwidth = 2\ncodes = { x = 3 }"),
        std::pair("u16", "codes = { x = 6 }\nscale = 2"), std::pair("u16", "codes = { x = 99999 }\naccess = \"w\"")})
    EXPECT_EQ(errors(type, keys).find("never occurs"), std::string::npos) << type << keys << ": " << errors(type, keys);
}

TEST(ItemNames, OfTextsHaveNoBoundsOfTheirQuestion) {
  const std::string item =
      "answer = \"{level:d} {valve:s}\"\nhighest = 1\nsentinels = { none = 0 }\n"
      "codes.valve = { shut = \"S\", open = \"O\", moving = \"M\" }\n";
  const auto map = parse_register_map(
      kLineMap + item + "[[alarm]]\nseverity = \"stop\"\nitem = \"valve\"\n" + "is = [\"shut\", \"moving\"]\n",
      "map.toml");
  ASSERT_TRUE(map) << text(map.error());
  for (const auto& [valve, stops] : {std::pair("S", true), std::pair("O", false), std::pair("M", true)}) {
    const auto state =
        inspect(*map, {{"T?\n", "20.0\n"}, {"S?\n", "20.0\n"}, {"M?\n", std::string("1 ") + valve + "\n"}});
    ASSERT_TRUE(state) << text(state.error());
    EXPECT_EQ(state->must_stop, stops) << valve;
  }
  const auto own = parse_register_map(kLineMap + std::string("answer = \"{value:s}\"\ncodes = { shut = \"S\" }\n"
                                                             "sentinels = { none = 0 }\n"),
                                      "map.toml");
  ASSERT_FALSE(own);
  EXPECT_NE(own.error().what.find("which have no sentinels and bounds"), std::string::npos) << own.error().what;
}

TEST(Limits, NarrowerOfMapAndControllerApplies) {
  for (const auto& [in_unit, low, high] :
       {std::tuple("-80 80", -40.0, 60.0), std::tuple("-20 50", -20.0, 50.0), std::tuple("-50 30", -40.0, 30.0)}) {
    const auto map = parse_register_map(std::string(kLineMap) + R"(answer = "{low:d} {high:d}"
[limits]
lowest = -40
highest = 60
lowest_item = "low"
highest_item = "high"
)",
                                        "map.toml");
    ASSERT_TRUE(map) << text(map.error());
    auto unit = std::make_unique<FixedAnswers>(std::map<std::string, std::string>{
        {"T?\n", "20.0\n"}, {"S?\n", "20.0\n"}, {"M?\n", std::string(in_unit) + "\n"}});
    const auto limits =
        make_modbus_chamber(*map, make_text_registers(*map, std::move(unit), "unit"), make_virtual_pauses(), {})
            ->limits();
    ASSERT_TRUE(limits) << text(limits.error());
    EXPECT_EQ(limits->lowest, Celsius{low}) << in_unit;
    EXPECT_EQ(limits->highest, Celsius{high}) << in_unit;
  }
}

TEST(LineItems, RefuseKeysWithoutEffect) {
  const auto errors = [](const std::string& keys) {
    const auto map = parse_register_map(kLineMap + std::string("answer = \"{value:d}\"\n") + keys, "map.toml");
    return map ? std::string() : text(map.error());
  };
  EXPECT_NE(errors("highest = 3\ninvalid_above = 9\n").find("is another name of \"highest\""), std::string::npos);
  EXPECT_NE(errors("lowest = 3\nhighest = 2\n").find("no value is possible"), std::string::npos);
  const std::string command = "tell = \"M{value:d}\"\nacknowledged = \"OK\"\n";
  EXPECT_NE(errors(command + "seen_later = true\n").find("allowed only for the item \"set_point\""), std::string::npos);
  EXPECT_NE(errors(command + "then_when = { item = \"state\", above = 1 }\n").find("expected the lines of \"then\""),
            std::string::npos);
  EXPECT_EQ(errors(command + "then = \"GO\"\nthen_when = { item = \"state\", above = 1 }\n"), "");
  EXPECT_EQ(errors("lowest = 2\ninvalid_above = 9\n"), "");
  for (const std::string key : {"codes", "flags"}) {
    EXPECT_NE(errors(key + ".stat = { on = 1 }\n").find("no field \"stat\" to which these " + key + " belong"),
              std::string::npos);
    EXPECT_EQ(errors(key + ".state = { on = 1 }\n"), "");
  }
}

TEST(RegisterKeys, RefusedIfTheyHaveNoEffect) {
  const auto errors = [](const std::string& keys) {
    const auto map = parse_register_map(kRegisterMap + keys, "map.toml");
    return map ? std::string() : text(map.error());
  };
  for (const std::string access : {"command", "r"})
    for (const auto* key : {"seen_in = \"air_temperature\"", "tolerance = 2", "within = \"2 s\""}) {
      const auto found = errors("access = \"" + access + "\"\n" + key + "\n");
      EXPECT_NE(found.find("has no effect with access = \"" + access + "\""), std::string::npos) << found;
      EXPECT_EQ(errors(std::string("access = \"rw\"\n") + key + "\n"), "");
    }
  EXPECT_NE(errors("unit = \"°F\"\nunit_register = \"air_temperature\"\n").find("exclude each other"),
            std::string::npos);
  const std::string power =
      "[[power]]\nname = \"main\"\nregister = \"state\"\nabove = 1\n"
      "on = [{ pause = \"1 s\" }]\noff = [{ pause = \"1 s\" }]\n";
  const std::string commands = "[sequence]\nstart = [{ pause = \"1 s\" }]\nstop = [{ pause = \"1 s\" }]\n";
  EXPECT_EQ(errors(commands + power), "");
  EXPECT_NE(errors(commands + power + power).find("a second power switch is named \"main\""), std::string::npos);
}

TEST(LineItems, RefuseFramesWithoutRecognisableEnd) {
  const auto errors = [](const std::string& frame) {
    std::string file = kLineMap + std::string("answer = \"{value:d}\"\n");
    file.replace(file.find("port = 10001\n"), 13, "port = 10001\nframe = { " + frame + " }\n");
    const auto map = parse_register_map(file, "map.toml");
    return map ? std::string() : text(map.error());
  };
  EXPECT_NE(errors("begin = 13, end = 13").find("the start and end byte are the same"), std::string::npos);
  EXPECT_NE(errors("end = 0, checksum = \"xor\"").find("one byte too short"), std::string::npos);
  EXPECT_NE(errors("end = 0x46, checksum = \"sum\"").find("the digit F, occurs in the checksum"), std::string::npos);
  for (const auto* good :
       {"checksum = \"xor\"", "end = 0, checksum = \"xor\", high_bit = true", "begin = 0x3A, end = 13"})
    EXPECT_EQ(errors(good), "") << good;
}

TEST(LineItems, RefuseCodesThatAreNoNumbers) {
  for (const std::string form : {"d", "f", "x2"})
    for (const std::string code : {"+-5", "-+5", "++5", "+", "-", "5-"}) {
      const auto map = parse_register_map(
          kLineMap + ("answer = \"{value:" + form + "}\"\ncodes = { on = \"" + code + "\" }\n"), "map.toml");
      ASSERT_FALSE(map) << form << " " << code;
      EXPECT_NE(map.error().what.find("is never the text \"" + code + "\""), std::string::npos) << map.error().what;
    }
  EXPECT_TRUE(parse_register_map(kLineMap + std::string("answer = \"{value:d}\"\ncodes = { on = \"+5\" }\n"), "map"));
}

TEST(LineItems, RefuseUsualLinkThatFileDoesNotHave) {
  const auto errors = [](const std::string& usual, const std::string& links) {
    std::string file = kLineMap + std::string("answer = \"{value:d}\"\n");
    file.replace(file.find("[link.tcp]\n"), 11, "usual = \"" + usual + "\"\n" + links + "[link.tcp]\n");
    const auto map = parse_register_map(file, "map.toml");
    return map ? std::string(name(map->links.front().kind)) : text(map.error());
  };
  const std::string serial = "[link.serial]\nsettings = \"9600,8N1\"\n";
  EXPECT_NE(errors("seriall", serial).find("did you mean \"serial\""), std::string::npos);
  EXPECT_NE(errors("serial", "").find("this file has no [link.serial]"), std::string::npos);
  EXPECT_EQ(errors("tcp", serial), name(LinkKind::text_tcp));
  EXPECT_EQ(errors("serial", serial), name(LinkKind::text_serial));
}

TEST(Conditions, RefusedIfStatusIsNeverRead) {
  const std::string unit = kRegisterMap + "codes = { bad = 1 }\n", link = "[link]\nstatus_every = 0\n";
  for (const std::string rule : {"[[alarm]]\n", "[[state]]\nactivity = \"off\"\n"}) {
    const auto file = unit + rule + "register = \"state\"\nis = \"bad\"\n";
    const auto read = parse_register_map(file, "map.toml");
    EXPECT_TRUE(read) << text(read.error());
    const auto unread = parse_register_map(file + link, "map.toml");
    ASSERT_FALSE(unread) << rule;
    EXPECT_NE(unread.error().what.find("0 leaves every"), std::string::npos) << unread.error().what;
  }
  EXPECT_TRUE(parse_register_map(unit + link, "map.toml"));
  auto lines = with_line_rule("codes = { bad = 1 }", "is = \"bad\"");
  EXPECT_TRUE(parse_register_map(lines, "map.toml"));
  lines.insert(lines.find("[link.tcp]"), "status_every = 0\n");
  EXPECT_FALSE(parse_register_map(lines, "map.toml"));
}

TEST(WrittenValues, RefusedIfRegisterCannotHoldThem) {
  const auto errors = [](const std::string& keys, const std::string& value) {
    const auto map = parse_register_map(
        kRegisterMap + keys + "\naccess = \"rw\"\n[sequence]\nstart = [{ write = " + "\"state\", " + value + " }]\n",
        "map.toml");
    return map ? std::string() : text(map.error());
  };
  EXPECT_NE(errors("", "value = 70000").find("cannot hold 70000; it would be written as 65535"), std::string::npos);
  EXPECT_NE(errors("", "value = -1").find("cannot hold -1"), std::string::npos);
  EXPECT_NE(errors("scale = 0.1", "value = 7000").find("cannot hold 7000"), std::string::npos);
  EXPECT_NE(errors("codes = { on = 70000 }", "code = \"on\"").find("cannot hold 70000"), std::string::npos);
  for (const auto* good : {"value = 65535", "value = 0"}) EXPECT_EQ(errors("", good), "") << good;
  EXPECT_EQ(errors("scale = 0.1", "value = 23.4"), "");
  EXPECT_EQ(errors("codes = { on = [7, 8] }", "code = \"on\""), "");
  EXPECT_EQ(errors("", "of = \"program\""), "");
}

TEST(ForbiddenRange, CoversAddressesOfRtu) {
  std::string file = kRegisterMap + "access = \"rw\"\n[[forbidden]]\nfirst = 900\nwhy = \"service\"\n";
  EXPECT_TRUE(parse_register_map(file, "map.toml"));
  file.replace(file.find("address = 9\n"), 12, "address = { tcp = 9, rtu = 900 }\n");
  const auto map = parse_register_map(file, "map.toml");
  ASSERT_FALSE(map);
  EXPECT_NE(map.error().what.find("\"state\" lies in this range"), std::string::npos) << map.error().what;
}

}  // namespace
}  // namespace gyrotherm::drivers
