// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "drivers/chamber/modbus_chamber.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/chamber/text_registers.hpp"
#include "drivers/line/pauses.hpp"
#include "tests/support/fakes.hpp"

namespace gyrotherm::drivers {
namespace {

constexpr const char* kTextMap = R"(schema = "gyrotherm-text/1"
kind = "chamber"
name = "C 1"
vendor = "Maker"
source = "a test"
state = [{ activity = "running", item = "mode", is = "constant" }, { activity = "off", item = "mode", is = "standby" }]
[link]
question_end = "\r\n"
answer_end = "\r\n"
timeout = "200 ms"
refused = "NA:{reason:s}"
[link.tcp]
port = 10001
[identity]
ask = "TYPE?"
pattern = "C-1|C-2"
[[item]]
name = "temperature"
ask = "TEMP?"
answer = "{air_temperature:f}, {set_point:f}, {alarm_high:f}, {alarm_low:f}"
[[item]]
name = "set_point"
tell = "TEMP, S{value:f.1}"
acknowledged = "OK:{_:s}"
lags = "2 s"
[[item]]
name = "mode"
ask = "MODE?"
answer = "{value:s}"
tell = "MODE, {value:s}"
acknowledged = "OK:{_:s}"
codes = { standby = "STANDBY", constant = "CONSTANT" }
[control]
commanded = "mode"
on = "constant"
off = "standby"
[limits]
highest_item = "alarm_high"
lowest_item = "alarm_low"
[sequence]
start = [{ write = "mode", code = "constant" }]
stop = [{ write = "mode", code = "standby" }]
)";

/// A chamber written without the map: it answers each line with the next scripted answer, or by `answer`.
class ScriptedChamber final : public ByteStream {
 public:
  std::function<std::string(const std::string&)> answer;
  std::vector<std::string> heard;
  std::deque<std::string> coming;

  Result<std::size_t> read(std::span<std::byte> buffer, Duration) override {
    if (coming.empty()) return failure(FaultKind::timeout, "scripted", "nothing came");
    const auto bytes = coming.front().substr(0, buffer.size());
    coming.front().erase(0, bytes.size());
    if (coming.front().empty()) coming.pop_front();
    std::ranges::copy(std::as_bytes(std::span(bytes)), buffer.begin());
    return bytes.size();
  }
  Result<void> write(std::span<const std::byte> bytes, Duration) override {
    std::string line(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    EXPECT_TRUE(line.ends_with("\r\n"));
    line.resize(line.size() - 2);
    heard.push_back(line);
    if (const auto text = answer(line); !text.empty()) coming.push_back(text);
    return {};
  }
};

class TextChamber : public ::testing::Test {
 protected:
  TextChamber() {
    auto stream = std::make_unique<ScriptedChamber>();
    line = stream.get();
    line->answer = [this](const std::string& question) { return respond(question); };
    const auto map = parse_register_map(kTextMap, "test").value();
    chamber = make_modbus_chamber(map, make_text_registers(map, std::move(stream), "test"), make_virtual_pauses(), {});
  }

  std::string respond(const std::string& question) {
    if (question == "TYPE?") return "T,C-1,190.0\r\n";
    if (question == "TEMP?") return temperature + "\r\n";
    if (question == "MODE?") return mode + "\r\n";
    if (question.starts_with("TEMP, S")) {
      const auto value = question.substr(7);
      if (std::stod(value) > 100) return "NA:DATA OUT OF RANGE\r\n";
      temperature = "23.5," + value + ",105.0,-45.0";
      return "OK:" + question + "\r\n";
    }
    if (question.starts_with("MODE, ")) return mode = question.substr(6), "OK:" + question + "\r\n";
    return "NA:CMD ERR\r\n";
  }

  std::string temperature = "23.5,20.0,105.0,-45.0", mode = "STANDBY";
  ScriptedChamber* line{};
  std::unique_ptr<Chamber> chamber;
};

TEST_F(TextChamber, IsReadAndControlled) {
  EXPECT_EQ(chamber->identify().value(), "Maker C 1 (identity = T,C-1,190.0)");
  const auto state = chamber->inspect().value();
  EXPECT_EQ(state.air.value, 23.5);
  EXPECT_EQ(state.set_point.value, 20);
  EXPECT_EQ(state.activity, ChamberActivity::off);
  ASSERT_TRUE(chamber->start());
  ASSERT_TRUE(chamber->send_set_point({-40}));
  EXPECT_EQ(chamber->inspect().value().set_point.value, -40);
  EXPECT_EQ(chamber->inspect().value().activity, ChamberActivity::running);
  EXPECT_EQ(chamber->limits().value().highest->value, 105);
  ASSERT_TRUE(chamber->stop());
  EXPECT_EQ(mode, "STANDBY");
}

TEST_F(TextChamber, ReportsRefusalsWithTheirReason) {
  temperature = "23.5,20.0,150.0,-45.0";
  const auto sent = chamber->send_set_point({120});
  ASSERT_FALSE(sent);
  EXPECT_EQ(sent.error().kind, FaultKind::refused);
  EXPECT_NE(sent.error().what.find("DATA OUT OF RANGE"), std::string::npos);
}

TEST_F(TextChamber, NeedsAnotherUnitsNameToFit) {
  line->answer = [&](const std::string& question) {
    return question == "TYPE?" ? "T,D-9,190.0\r\n" : respond(question);
  };
  EXPECT_EQ(chamber->identify().error().kind, FaultKind::mismatch);
}

TEST_F(TextChamber, KeepsTextWithoutCode) {
  mode = "AUTO";
  EXPECT_EQ(chamber->inspect().value().activity, ChamberActivity::unknown);
  EXPECT_EQ(chamber->unmatched_state(), "mode \"AUTO\" (no name in codes)");
  mode = "HOLD";
  (void)chamber->inspect();
  EXPECT_EQ(chamber->unmatched_state(), "mode \"HOLD\" (no name in codes)");
  mode = "STANDBY";
  EXPECT_EQ(chamber->inspect().value().activity, ChamberActivity::off);
  EXPECT_EQ(chamber->unmatched_state(), "");
}

TEST_F(TextChamber, AcceptsNoGarbageAsAValue) {
  for (const auto* garbage : {"23,5,20,0,105,0,-45,0", "23.5,20.0", "23.5,20.0,105.0,-45.0,7", "OK:TEMP?", "nan,1,2,3",
                              "23.5 C,20.0,105.0,-45.0", "1.7E400,1,2,3"}) {
    temperature = garbage;
    const auto read = chamber->read();
    ASSERT_FALSE(read) << garbage;
    EXPECT_EQ(read.error().kind, FaultKind::corrupted) << garbage;
  }
  temperature = "23.5,20.0,105.0,-45.0";
}

TEST_F(TextChamber, TakesNoLateAnswerForALaterQuestion) {
  ASSERT_TRUE(chamber->identify());
  bool loses = true;
  std::string kept;
  line->answer = [&](const std::string& question) -> std::string {
    if (question == "TEMP?" && loses) return loses = false, kept = "99.0,20.0,105.0,-45.0\r\n", "";
    if (question == "TYPE?" && !kept.empty()) return std::exchange(kept, "") + respond(question);
    return respond(question);
  };
  EXPECT_FALSE(chamber->read());
  for (int i = 0; i < 3; ++i)
    if (const auto state = chamber->read()) {
      EXPECT_EQ(state->air.value, 23.5);
    }
}

TEST_F(TextChamber, StopTriesEveryStepAndReportsFirstFailure) {
  std::string text_of = kTextMap;
  const std::string step = "stop = [{ write = \"mode\", code = \"standby\" }]";
  text_of.replace(text_of.find(step), step.size(),
                  "stop = [{ write = \"set_point\", value = 300 }, { write = \"mode\", code = \"standby\" }]");
  auto stream = std::make_unique<ScriptedChamber>();
  stream->answer = [this](const std::string& question) { return respond(question); };
  const auto map = parse_register_map(text_of, "test").value();
  chamber = make_modbus_chamber(map, make_text_registers(map, std::move(stream), "test"), make_virtual_pauses(), {});
  mode = "CONSTANT";
  const auto stopped = chamber->stop();
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().kind, FaultKind::refused);
  EXPECT_EQ(mode, "STANDBY");
}

/// Returns the map with `from` replaced.
std::string map_text_with(const std::string& from, const std::string& to) {
  std::string text_of = kTextMap;
  EXPECT_NE(text_of.find(from), std::string::npos) << from;
  return text_of.replace(text_of.find(from), from.size(), to);
}

TEST(TextMap, ParametersOfTheRigReplaceThoseOfTheFile) {
  const auto text_of = map_text_with("[[item]]\nname = \"temperature\"\nask = \"TEMP?\"",
                                     "[parameter]\nchannel = 1\nunit_name = \"C-1\"\n[[item]]\n"
                                     "name = \"temperature\"\nask = \"TEMP{channel:d}?\"");
  const auto usual = parse_register_map(text_of, "test").value();
  EXPECT_EQ(usual.text_link->queries[1].ask, "TEMP1?");
  const auto other = parse_register_map(text_of, "test", {}, {{"channel", "2"}}).value();
  EXPECT_EQ(other.text_link->queries[1].ask, "TEMP2?");
  EXPECT_EQ(other.parameters, (TextParameters{{"channel", "2"}, {"unit_name", "C-1"}}));
  EXPECT_TRUE(check_parameters(other, {{"unit_name", "C-2"}}));
  const auto unknown = check_parameters(other, {{"chanel", "2"}});
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().where, "chanel");
  EXPECT_NE(unknown.error().what.find("expected one of: channel, unit_name"), std::string::npos);
  const auto no_number = parse_register_map(text_of, "test", {}, {{"channel", "A"}});
  ASSERT_FALSE(no_number);
  EXPECT_NE(text(no_number.error()).find("is a number"), std::string::npos) << text(no_number.error());
}

TEST(TextMap, IdentityPatternHasParameters) {
  auto text_of = map_text_with("pattern = \"C-1|C-2\"", "pattern = \"^{type:s}\"\n[parameter]\ntype = \"C-1\"");
  EXPECT_EQ(parse_register_map(text_of, "test").value().identity->pattern, "^C-1");
  EXPECT_EQ(parse_register_map(text_of, "test", {}, {{"type", "D-9"}}).value().identity->pattern, "^D-9");
}

TEST(TextMap, ReadsListsAsNumberedItems) {
  const auto text_of = map_text_with("[control]",
                                     "[[item]]\nname = \"zones\"\nask = \"ZONES?\"\n"
                                     "answer = \"{value:f*3,}\"\n[control]");
  const auto map = parse_register_map(text_of, "test").value();
  auto stream = std::make_unique<ScriptedChamber>();
  stream->answer = [](const std::string&) { return "1.5,2.5,-3\r\n"; };
  const auto registers = make_text_registers(map, std::move(stream), "test");
  const auto& third = *map.find("zones_3");
  const auto words = registers->read(ReadFunction::holding_registers, third.address, word_count(third));
  ASSERT_TRUE(words) << text(words.error());
  EXPECT_EQ(decode(third, *words).value(), -3);
}

TEST(TextMap, ScaleOfQuestionIsNotThatOfItsCodes) {
  const auto text_of = map_text_with(
      "[control]",
      "[[item]]\nname = \"all\"\nask = \"ALL?\"\nanswer = \"{humidity:d};{valve:d};{door:d}\"\nscale = 0.1\n"
      "codes.valve = { shut = \"3\", open = \"4\" }\nflags.door = { open = 1 }\n[control]");
  const auto map = parse_register_map(text_of, "test");
  ASSERT_TRUE(map) << text(map.error());
  EXPECT_EQ(map->find("humidity")->scale, 0.1);
  EXPECT_EQ(map->find("valve")->scale, 1);
  EXPECT_EQ(map->find("door")->scale, 1);
  const auto scaled = parse_register_map(map_text_with("codes = {", "scale = 0.1\ncodes = {"), "test");
  ASSERT_FALSE(scaled);
  EXPECT_NE(scaled.error().what.find("\"mode\" has codes or flags"), std::string::npos) << scaled.error().what;
}

/// A unit whose set points take effect at the next start command, which it does not acknowledge.
const std::string kPendingSetPoint =
    "tell = \"TEMP, S{value:f.1}\"\nthen = \"RUN\"\nthen_when = { item = \"mode\", is = \"constant\" }";

TEST(TextMap, LinesAfterACommandHaveACondition) {
  const auto map = parse_register_map(map_text_with("tell = \"TEMP, S{value:f.1}\"", kPendingSetPoint), "test").value();
  std::string mode = "CONSTANT";
  auto stream = std::make_unique<ScriptedChamber>();
  auto* line = stream.get();
  line->answer = [&](const std::string& question) -> std::string {
    if (question == "MODE?") return mode + "\r\n";
    return question == "RUN" ? "" : "OK:" + question + "\r\n";
  };
  const auto registers = make_text_registers(map, std::move(stream), "test");
  const auto& set_point = *map.find("set_point");
  ASSERT_TRUE(registers->write(WriteFunction::registers, set_point.address, encode(set_point, 30)));
  EXPECT_EQ(line->heard, (std::vector<std::string>{"MODE?", "TEMP, S30.0"}))
      << "the caller does not wait for the pause";
  const auto& mode_item = *map.find("mode");
  ASSERT_TRUE(registers->read(ReadFunction::holding_registers, mode_item.address, word_count(mode_item)));
  EXPECT_EQ(line->heard, (std::vector<std::string>{"MODE?", "TEMP, S30.0", "RUN", "MODE?"}));
  line->heard.clear();
  mode = "STANDBY";
  ASSERT_TRUE(registers->write(WriteFunction::registers, set_point.address, encode(set_point, 31)));
  ASSERT_TRUE(registers->read(ReadFunction::holding_registers, mode_item.address, word_count(mode_item)));
  EXPECT_EQ(line->heard, (std::vector<std::string>{"MODE?", "TEMP, S31.0", "MODE?"}))
      << "a stopped unit is not started";
}

TEST(TextMap, ReadsProposedForm) {
  const auto map = parse_register_map(kTextMap, "test").value();
  EXPECT_TRUE(map.find("air_temperature")->readable);
  EXPECT_TRUE(map.find("set_point")->writable);
  EXPECT_EQ(map.find("set_point")->resolution, 0.1);
  EXPECT_EQ(map.link.modbus.port, 10001);
  EXPECT_EQ(map.text_link->queries.size(), 3U);
}

TEST(TextMap, NamesEachErrorWithItsPlace) {
  const auto fails = [](const std::string& from, const std::string& to, const std::string& expected) {
    std::string text = kTextMap;
    text.replace(text.find(from), from.size(), to);
    const auto map = parse_register_map(text, "test.toml");
    ASSERT_FALSE(map) << to;
    EXPECT_NE((map.error().where + map.error().what).find(expected), std::string::npos) << map.error().what;
  };
  fails("{value:f.1}", "{value:z}", "is not a field");
  fails("{value:f.1}", "20.0", "the command does not send the value of \"set_point\"");
  fails("ask = \"TEMP?\"", "asks = \"TEMP?\"", "asks");
  fails("pattern = \"C-1|C-2\"", "pattern = \"(C-1\"", "regular expression");
  fails("answer = \"{air_temperature:f}, {set", "answer = \"{air:f}, {set", "air_temperature");
  fails("port = 10001", "port = 100010", "port");
  fails("is = \"constant\"", "is = \"constnat\"", "constnat");
  fails("answer_end = \"\\r\\n\"", "answer_end = \"\"", "a lost digit is not noticed");
  fails("[control]", "[[item]]\nname = \"go\"\ntell = \"GO\"\neffect = \"gone\"\n[control]", "gone");
  fails("[control]", "[[item]]\nname = \"go\"\ntell = \"GO\"\n[control]", "neither acknowledged nor read back");
  const std::string memory = "[profile_memory]\nsteps_at_most = 9\nlongest_step = \"1 h\"\n[[profile_memory.step]]\n";
  fails("[control]", memory + "tell = \"S{step:d}\"\nacknowledged = \"OK\"\n[control]", "its target or its start");
  fails("[control]", memory + "tell = \"S{step:d},{speed:d}\"\n[control]", "not a part of a program");
  fails("[control]",
        memory +
            "tell = \"S{step:d},{target:f},{total_seconds:d}\"\nask = \"S{target:f}?\"\nanswer = "
            "\"{target:f}\"\n[control]",
        "expected number or step");
  fails("[control]",
        memory +
            "tell = \"S{step:d},{target:f},{total_seconds:d}\"\nask = \"S{step:d}?\"\nanswer = "
            "\"{target:f}\"\n[control]",
        "the field \"total_seconds\" of \"tell\" is missing");
}

/// A chamber whose set point is a word while it is off, which must be prepared, and whose status is two words of bits.
constexpr const char* kWordMap = R"(schema = "gyrotherm-text/1"
kind = "chamber"
name = "C 2"
vendor = "Maker"
source = "a test"
[link]
question_end = "\r\n"
answer_end = "\r\n"
timeout = "200 ms"
refused = "NA:{reason:s}"
[link.tcp]
port = 10001
[identity]
ask = "TYPE?"
pattern = "C-2"
[[item]]
name = "air_temperature"
ask = "CHAM?"
answer = "{value:f.1}"
[[item]]
name = "set_point"
ask = "SET?"
answer = ["{value:f.1}", "NONE"]
tell = "SET {value:f.1}"
acknowledged = "OK"
[[item]]
name = "status"
ask = "STAT?"
answer = "{running:s1}{error:s1} {low:x2}{high:x2}"
codes.running = { no = "N", yes = "Y" }
codes.error = { no = "N", yes = "Y" }
flags.low = { cooling = 0 }
flags.high = { over_temperature = 0, door = 3 }
[[item]]
name = "com"
tell = "COM"
acknowledged = "OK"
[[item]]
name = "on"
tell = "ON"
acknowledged = "OK"
[[item]]
name = "off"
tell = "OFF"
acknowledged = "OK"
[sequence]
prepare = [{ write = "com" }]
start = [{ write = "on" }]
stop = [{ write = "off" }]
[[state]]
activity = "running"
item = "running"
is = "yes"
[[state]]
activity = "off"
item = "running"
is = "no"
[[alarm]]
severity = "stop"
item = "high"
is = "over_temperature"
[[alarm]]
severity = "warning"
item = "high"
is = "door"
)";

class TextWord : public ::testing::Test {
 protected:
  TextWord() {
    auto stream = std::make_unique<ScriptedChamber>();
    line = stream.get();
    line->answer = [this](const std::string& question) { return respond(question) + "\r\n"; };
    const auto map = parse_register_map(kWordMap, "test");
    EXPECT_TRUE(map) << text(map.error());
    chamber =
        make_modbus_chamber(*map, make_text_registers(*map, std::move(stream), "test"), make_virtual_pauses(), {});
  }

  std::string respond(const std::string& question) {
    if (question == "TYPE?") return "C-2 of Maker";
    if (question == "CHAM?") return "23.5";
    if (question == "SET?") return set_point;
    if (question == "STAT?") return std::string(is_on ? "Y" : "N") + "N" + bits;
    if (question == "COM") return ++prepared, "OK";
    if (prepared == 0) return "NA:LOCAL";
    if (question.starts_with("SET ")) return set_point = question.substr(4), "OK";
    if (question == "ON" && set_point == "NONE") return "NA:NO SET POINT";
    if (question == "ON") return is_on = true, "OK";
    if (question == "OFF") return is_on = false, set_point = "NONE", "OK";
    return "NA:CMD ERR";
  }

  std::string set_point = "NONE", bits = "0100";
  bool is_on = false;
  int prepared = 0;
  ScriptedChamber* line{};
  std::unique_ptr<Chamber> chamber;
};

TEST_F(TextWord, SetPointMayBeWordBeforeFirstCommandAndWhileOff) {
  ASSERT_TRUE(chamber->identify());
  auto state = chamber->inspect();
  ASSERT_TRUE(state) << text(state.error());
  EXPECT_TRUE(std::isnan(state->set_point.value));
  EXPECT_EQ(state->air.value, 23.5);
  EXPECT_EQ(state->activity, ChamberActivity::off);
  ASSERT_TRUE(chamber->send_set_point({40}));
  ASSERT_TRUE(chamber->start());
  EXPECT_EQ(chamber->inspect()->set_point.value, 40);
  ASSERT_TRUE(chamber->stop());
  state = chamber->read();
  ASSERT_TRUE(state) << text(state.error());
  EXPECT_TRUE(std::isnan(state->set_point.value)) << "one item without a value is no silent chamber";
  ASSERT_TRUE(chamber->send_set_point_immediately({20}));
  EXPECT_EQ(chamber->inspect()->set_point.value, 20);
}

TEST_F(TextWord, StartSendsSetPointAgainThatWasLost) {
  ASSERT_TRUE(chamber->send_set_point({40}));
  set_point = "NONE";
  line->answer = [this](const std::string& question) {
    if (question == "ON") return is_on = true, std::string("OK\r\n");
    return respond(question) + "\r\n";
  };
  ASSERT_TRUE(chamber->start());
  EXPECT_EQ(set_point, "40.0");
}

TEST_F(TextWord, WriteThatLeavesWordFailsWithReason) {
  line->answer = [this](const std::string& question) {
    if (question.starts_with("SET ")) return std::string("OK\r\n");
    return respond(question) + "\r\n";
  };
  const auto sent = chamber->send_set_point({40});
  ASSERT_FALSE(sent);
  EXPECT_NE(sent.error().what.find("answered without a value"), std::string::npos) << sent.error().what;
}

TEST_F(TextWord, AirThatIsWordIsFaultOfThatItem) {
  line->answer = [this](const std::string& question) {
    return question == "CHAM?" ? std::string("OPEN\r\n") : respond(question) + "\r\n";
  };
  const auto state = chamber->read();
  ASSERT_FALSE(state);
  EXPECT_NE(state.error().what.find("\"OPEN\" is no answer to \"CHAM?\""), std::string::npos) << state.error().what;
}

TEST_F(TextWord, PreparesOncePerConnectionBeforeFirstSetPoint) {
  ASSERT_TRUE(chamber->send_set_point({40}));
  ASSERT_TRUE(chamber->send_set_point({41}));
  ASSERT_TRUE(chamber->start());
  EXPECT_EQ(prepared, 1);
  const auto com = std::ranges::find(line->heard, "COM");
  EXPECT_LT(com, std::ranges::find_if(line->heard, [](const auto& one) { return one.starts_with("SET "); }));
}

TEST_F(TextWord, PreparesBeforeSafeSetPointOfNewProgram) {
  ASSERT_TRUE(chamber->send_set_point_immediately({20}));
  EXPECT_EQ(prepared, 1);
  EXPECT_EQ(set_point, "20.0");
}

TEST_F(TextWord, RefusedPreparationStopsRunButNotMakeSafe) {
  line->answer = [this](const std::string& question) {
    if (question == "COM") return ++prepared, std::string("NA:REMOTE ALREADY\r\n");
    return respond(question) + "\r\n";
  };
  const auto sent = chamber->send_set_point({40});
  ASSERT_FALSE(sent);
  EXPECT_NE(sent.error().what.find("REMOTE ALREADY"), std::string::npos);
  EXPECT_EQ(set_point, "NONE") << "nothing was sent";
  EXPECT_TRUE(chamber->send_set_point_immediately({20}));
}

TEST_F(TextWord, ReadsFlagsOfSeveralWordsInOneAnswer) {
  bits = "0108";
  EXPECT_EQ(chamber->inspect()->alarms, std::vector<std::string>{"door"});
  bits = "0001";
  EXPECT_TRUE(chamber->inspect()->must_stop);
}

/// Returns the errors of the first test map after a replacement; empty if there are none.
std::string errors_after(const std::string& from, const std::string& to) {
  std::string file = kTextMap;
  file.replace(file.find(from), from.size(), to);
  const auto map = parse_register_map(file, "test.toml");
  return map ? "" : map.error().where + map.error().what;
}

TEST(TextMap, RefusesOtherUnitsOfTemperatures) {
  const std::string line = "lags = \"2 s\"\n";
  for (const auto* unit : {"degF", "K", "° F", "°f", "deg C", "Celsius", "º C", "%", "kelvin"})
    EXPECT_NE(errors_after("ask = \"TEMP?\"\n", "unit = \"" + std::string(unit) + "\"\nask = \"TEMP?\"\n")
                  .find("expected one of: \"°C\", \"°F\""),
              std::string::npos)
        << unit;
  for (const auto* unit : {"°C", "°F", ""})
    EXPECT_EQ(errors_after("ask = \"TEMP?\"\n", "unit = \"" + std::string(unit) + "\"\nask = \"TEMP?\"\n"), "") << unit;
  const auto other = [](const std::string& keys) {
    return errors_after("[control]",
                        "[[item]]\nname = \"other\"\nask = \"O?\"\nanswer = \"{value:f}\"\n" + keys + "\n[control]");
  };
  for (const auto* unit : {"%", "K/min", "s", "°C", "°F", "1", "deg", "°C/min"})
    EXPECT_EQ(other("unit = \"" + std::string(unit) + "\""), "") << unit;
  EXPECT_EQ(other("unit = \"K\"\ndifference = true"), "");
  for (const auto* unit : {"K", "degC", "°c", "Fahrenheit"})
    EXPECT_NE(other("unit = \"" + std::string(unit) + "\""), "") << unit;
}

TEST(TextMap, RefusesTwoNamesOfOneCode) {
  const std::string codes = "{ standby = \"STANDBY\", constant = \"CONSTANT\" }";
  EXPECT_NE(errors_after(codes, "{ standby = \"STANDBY\", constant = [\"RUN\", \"STANDBY\"] }")
                .find("constant and standby are both \"STANDBY\""),
            std::string::npos);
  EXPECT_EQ(errors_after(codes, "{ standby = \"STANDBY\", constant = [\"RUN\", \"CONSTANT\"] }"), "");
  const auto numbers = [](const std::string& keys) {
    return errors_after("[control]",
                        "[[item]]\nname = \"other\"\nask = \"O?\"\nanswer = \"{value:d}\"\n" + keys + "\n[control]");
  };
  EXPECT_NE(numbers("codes = { off = 3, on = 4, held = [7, 3] }").find("held and off are both 3"), std::string::npos);
  EXPECT_EQ(numbers("codes = { off = [3, 3], on = 4 }"), "") << "one name";
  EXPECT_NE(numbers("flags = { door = 2, fan = 2 }").find("door and fan are both bit 2"), std::string::npos);
  EXPECT_EQ(numbers("flags = { door = 2, fan = 3 }"), "");
}

TEST(TextMap, RefusesSpeltTerminators) {
  const std::string end = "question_end = \"\\r\\n\"";
  for (const auto& [spelt, what] :
       {std::pair(R"("CR")", R"("CR" is two letters; write "\r")"), std::pair(R"("lf")", R"(write "\n")"),
        std::pair(R"("CRLF")", R"("CRLF" is four letters; write "\r\n")"), std::pair(R"("CR LF")", R"(write "\r\n")"),
        std::pair(R"("<CR><LF>")", R"(write "\r\n")"), std::pair(R"("\\r")", R"(write "\r")"),
        std::pair(R"('\r\n')", R"(write "\r\n")"), std::pair(R"("X")", R"("X" is one letter, expected)"),
        std::pair(R"("ETX")", R"(write "\u0003")")})
    EXPECT_NE(errors_after(end, "question_end = " + std::string(spelt)).find(what), std::string::npos)
        << errors_after(end, "question_end = " + std::string(spelt));
  for (const auto* good : {R"("\r")", R"("\n")", R"("\r\n")", R"(";")", R"("\u0003")", R"(">")", R"("#\r")", R"("")"})
    EXPECT_EQ(errors_after(end, "question_end = " + std::string(good)), "") << good;
  EXPECT_NE(errors_after("answer_end = \"\\r\\n\"", "answer_end = \"LF\"").find("two letters"), std::string::npos);
}

/// Returns the first test map with one more item.
std::string map_with_item(const std::string& item, const std::string& rules = "") {
  return map_text_with("[control]", "[[item]]\n" + item + "\n[control]") + (rules.empty() ? "" : "\n" + rules + "\n");
}

/// Reads the named item of a map whose unit answers `answer` to the question "R?".
double read_after(const std::string& map_text, const std::string& answer, const std::string& name) {
  const auto map = parse_register_map(map_text, "test");
  EXPECT_TRUE(map) << text(map.error());
  if (!map) return NAN;
  auto stream = std::make_unique<ScriptedChamber>();
  stream->answer = [&](const std::string&) { return answer + "\r\n"; };
  const auto registers = make_text_registers(*map, std::move(stream), "test");
  const auto& item = *map->find(name);
  const auto words = registers->read(ReadFunction::holding_registers, item.address, word_count(item));
  EXPECT_TRUE(words) << text(words.error());
  const auto value = words ? decode(item, *words) : failure(words.error());
  return value.value_or(NAN);
}

TEST(TextMap, ReadsStatusInHexadecimalDigitsWithoutSign) {
  const std::string status = "name = \"status\"\nask = \"R?\"\nanswer = \"R{value:x2}{error:x2}\"\n";
  const auto codes = map_with_item(status + "codes.status = { off = 0, on = 0x81 }");
  EXPECT_EQ(read_after(codes, "R8100", "status"), 0x81);
  EXPECT_EQ(read_after(codes, "R8180", "error"), -128) << "a number without codes and conditions";
  const auto flags = map_with_item(status + "flags.error = { fatal = 7 }");
  EXPECT_EQ(read_after(flags, "R8180", "error"), 0x80);
  for (const auto* rule : {"above = 0", "bits = [7]"}) {
    const auto alarm = map_with_item(status, "[[alarm]]\nitem = \"error\"\nseverity = \"stop\"\n" + std::string(rule));
    EXPECT_EQ(read_after(alarm, "R0080", "error"), 0x80) << rule;
    const auto map = parse_register_map(alarm, "test").value();
    EXPECT_TRUE(holds(map.alarms.back().when, 0x80)) << rule;
  }
  EXPECT_EQ(read_after(map_with_item(status + "codes.status = { failed = -1, on = 1 }"), "RFF00", "status"), -1)
      << "a negative code states the sign";
  EXPECT_EQ(read_after(map_with_item("name = \"count\"\nask = \"R?\"\nanswer = \"R{value:u4}\""), "RFFFE", "count"),
            0xFFFE);
  const auto cold = map_with_item("name = \"product\"\nask = \"R?\"\nanswer = \"{value:x2}\"\nunit = \"°C\"",
                                  "[[alarm]]\nitem = \"product\"\nabove = 90");
  EXPECT_EQ(read_after(cold, "D8", "product"), -40) << "a temperature has a sign";
}

TEST(TextMap, RepeatsPresentTextWithoutCode) {
  const auto map =
      parse_register_map(map_text_with("tell = \"TEMP, S{value:f.1}\"", "tell = \"SET {value:f.1},{mode:s}\""), "test");
  ASSERT_TRUE(map) << text(map.error());
  auto stream = std::make_unique<ScriptedChamber>();
  auto* line = stream.get();
  line->answer = [](const std::string& question) {
    return (question == "MODE?" ? "PAUSED" : "OK:" + question) + std::string("\r\n");
  };
  const auto registers = make_text_registers(*map, std::move(stream), "test");
  const auto& set_point = *map->find("set_point");
  ASSERT_TRUE(registers->write(WriteFunction::registers, set_point.address, encode(set_point, 30)));
  EXPECT_EQ(line->heard.back(), "SET 30.0,PAUSED") << "the command must not change the mode";
}

TEST(TextMap, SendsNoValueThatDoesNotFitItsField) {
  const auto map = parse_register_map(
      map_text_with("tell = \"TEMP, S{value:f.1}\"", "tell = \"TEMP, S{value:x4}\"\nscale = 0.01"), "test");
  ASSERT_TRUE(map) << text(map.error());
  auto stream = std::make_unique<ScriptedChamber>();
  auto* line = stream.get();
  line->answer = [](const std::string& question) { return "OK:" + question + "\r\n"; };
  const auto registers = make_text_registers(*map, std::move(stream), "test");
  const auto& set_point = *map->find("set_point");
  ASSERT_TRUE(registers->write(WriteFunction::registers, set_point.address, encode(set_point, -40)));
  EXPECT_EQ(line->heard.back(), "TEMP, SF060");
  const auto hot = registers->write(WriteFunction::registers, set_point.address, encode(set_point, 400));
  ASSERT_FALSE(hot) << "would be -255.36";
  EXPECT_EQ(hot.error().kind, FaultKind::refused);
  EXPECT_FALSE(registers->write_unconfirmed(WriteFunction::registers, set_point.address, encode(set_point, 400)));
  EXPECT_EQ(line->heard.size(), 1U);
}

TEST(TextMap, SentinelsInHexadecimalDigitsHaveEitherSign) {
  for (const auto* sentinel : {"0x8000", "-32768", "32768"}) {
    const auto file = map_with_item(
        "name = \"zone\"\nask = \"R?\"\nanswer = \"{value:x4}\"\nscale = 0.01\n"
        "sentinels = { no_sensor = " +
        std::string(sentinel) + " }");
    EXPECT_TRUE(std::isnan(read_after(file, "8000", "zone"))) << sentinel;
    EXPECT_EQ(read_after(file, "F060", "zone"), -40) << sentinel;
  }
  const auto without_sign = map_with_item(
      "name = \"zone\"\nask = \"R?\"\nanswer = \"{value:x2}\"\ncodes = { off = 0 }\nsentinels = { none = -1 }");
  EXPECT_TRUE(std::isnan(read_after(without_sign, "FF", "zone")));
}

TEST(TextMap, RefusesCodesThatFieldCannotProduce) {
  const auto errors = [](const std::string& form, const std::string& keys) {
    const auto map = parse_register_map(
        map_with_item("name = \"other\"\nask = \"R?\"\nanswer = \"{value:" + form + "}\"\n" + keys), "test.toml");
    return map ? std::string() : map.error().what;
  };
  const auto expect = [&](const std::string& form, const std::string& keys, const std::string& part) {
    EXPECT_NE(errors(form, keys).find(part), std::string::npos) << form << " " << keys << ": " << errors(form, keys);
  };
  expect("x2", "[[alarm]]\nitem = \"other\"\nbits = [8]", "the field of \"other\" has the bits 0 to 7");
  expect("x2", "flags = { fatal = 12 }", "the bit 12 of \"fatal\" is never set: the field has 8 bits");
  expect("x2", "codes = { on = 256 }", "the code 256 of \"on\" never occurs: the field has numbers from 0 to 255");
  expect("x2", "codes = { on = 200, off = -1 }", "numbers from -128 to 127");
  expect("u1", "codes = { on = -1 }", "numbers from 0 to 15");
  expect("x2", "sentinels = { none = 1000 }", "the sentinel 1000 of \"none\" never occurs");
  expect("b1", "codes = { on = 2 }", "numbers from 0 to 1");
  expect("s", "codes = { on = 1 }", "is never the number 1");
  expect("s2", "flags = { on = 1 }", "expected a whole number for flags");
  expect("d", "codes = { on = \"ON\" }", "is never the text \"ON\"");
  for (const auto& [form, keys] :
       {std::pair("x2", "flags = { fatal = 7 }"), std::pair("x2", "codes = { on = 255 }"),
        std::pair("x2", "codes = { on = 127, off = -128 }"), std::pair("x2", "[[alarm]]\nitem = \"other\"\nbits = [7]"),
        std::pair("b1", "codes = { on = 1, off = 0 }"), std::pair("s", "codes = { on = \"1\" }"),
        std::pair("d", "codes = { on = \"1\", off = 0 }"), std::pair("d", "flags = { on = 31 }"),
        std::pair("x8", "flags = { on = 31 }")})
    EXPECT_EQ(errors(form, keys), "") << form << " " << keys;
}

TEST(TextMap, TextsOfNumbersAreTheirNumbers) {
  const std::string status = "name = \"valve\"\nask = \"R?\"\nanswer = \"{value:";
  EXPECT_EQ(read_after(map_with_item(status + "d}\"\ncodes = { shut = \"3\", open = \"4\" }"), "4", "valve"), 4);
  const auto map = parse_register_map(map_with_item(status + "x2}\"\ncodes = { open = \"8A\" }"), "test").value();
  EXPECT_EQ(map.find("valve")->codes.at("open"), std::vector<std::int64_t>{0x8A});
}

TEST(TextMap, RefusesTimesThatGuardTakesForHungProgram) {
  const std::string timeout = "timeout = \"200 ms\"";
  for (const auto* time : {"5 s", "4001 ms", "20 s", "1 min"})
    EXPECT_NE(errors_after(timeout, "timeout = \"" + std::string(time) + "\"").find("expected at most 4 s"),
              std::string::npos)
        << time;
  EXPECT_NE(errors_after(timeout, "timeout = \"0 s\"").find("expected more than zero"), std::string::npos);
  EXPECT_NE(errors_after("port = 10001", "port = 10001\ntimeout = \"9 s\"").find("at most 4 s"), std::string::npos);
  for (const auto* key : {"silence", "quiet"})
    EXPECT_NE(errors_after(timeout, std::string(key) + " = \"5 s\"").find("at most 4 s"), std::string::npos) << key;
  for (const auto* key : {"after_read", "after_write"})
    EXPECT_NE(errors_after(timeout, std::string(key) + " = \"11 s\"").find("at most 10 s"), std::string::npos) << key;
  for (const auto* good : {"timeout = \"4 s\"", "timeout = \"1 ms\"", "after_write = \"6 s\"", "silence = \"4 s\""})
    EXPECT_EQ(errors_after(timeout, good), "") << good;
}

TEST_F(TextChamber, NamesRemedyOfLineThatRepeatsQuestion) {
  for (const bool at_once : {false, true}) {
    line->answer = [&](const std::string& question) {
      if (!at_once) line->coming.push_back(question + "\r\n");
      return (at_once ? question + "\r\n" : "") + respond(question);
    };
    const auto identity = chamber->identify();
    ASSERT_FALSE(identity);
    EXPECT_NE(identity.error().what.find("repeats the question \"TYPE?\"; set echo = true in [chamber.link]"),
              std::string::npos)
        << identity.error().what;
  }
}

TEST_F(TextChamber, NamesRemedyOfAnswerAfterRepeatedQuestion) {
  for (const auto* end : {"\r", "\n", "\n\r"}) {
    line->answer = [&](const std::string& question) { return question + end + " 20.28\r\n"; };
    ASSERT_FALSE(chamber->read());
    const auto fault = chamber->read().error();
    EXPECT_NE(fault.what.find("repeats the question"), std::string::npos) << fault.what;
    EXPECT_NE(fault.what.find("or write the repeated question into the template"), std::string::npos) << fault.what;
  }
  line->answer = [&](const std::string& question) { return question + " 20.28\r\n"; };
  EXPECT_EQ(chamber->read().error().what.find("repeats"), std::string::npos) << "may be the name of the value";
}

TEST(TextMap, EachMistakeIsOneErrorWithItsCause) {
  const auto expect = [](const std::string& from, const std::string& to, const std::string& part) {
    const auto errors = errors_after(from, to);
    EXPECT_NE(errors.find(part), std::string::npos) << to << ": " << errors;
    EXPECT_EQ(std::ranges::count(errors, '\n'), 0) << to << ": " << errors;
  };
  expect("answer = \"{value:s}\"", "answer = \"{value}\"", "is not a field");
  expect("answer = \"{air_temperature:f}, {set_point:f}", "answer = \"{air_temperature}, {set_point:f}",
         "is not a field");
  expect("[control]", "[[item]]\nname = \"mode\"\nask = \"M?\"\nanswer = \"{value:d}\"\n[control]",
         "duplicate item \"mode\"");
  expect("[control]", "[[item]]\nname = \"go\"\ntell = \"GO\"\neffect = \"gone\"\n[control]",
         "no item is named \"gone\"");
  const std::string tell = "tell = \"TEMP, S{value:f.1}\"\nacknowledged = \"OK:{_:s}\"\n";
  expect(tell, "", "expected \"ask\" or \"tell\"");
  expect(tell, "ask = \"SP?\"\nanswer = \"{value:f}\"\n", "item \"set_point\" has no \"tell\"");
  expect("is = \"constant\"", "is = \"constnat\"",
         "item \"mode\" has no code named \"constnat\"; expected one of: constant, standby");
  expect("on = \"constant\"", "on = \"run\"", "item \"mode\" has no code named \"run\"; expected one of");
  expect("code = \"constant\"", "code = \"run\"", "item \"mode\" has no code named \"run\"; expected one of");
  expect("timeout = \"200 ms\"", "answers_have_prefix = true", "has no \"prefix\"");
  expect("ask = \"TEMP?\"", "ask = \"TEMP?\\r\\n\"", "contains \"question_end\"");
  expect("tell = \"TEMP, S{value:f.1}\"", "tell = \"TEMP, S{value:f.1}\\r\\n\"", "contains \"question_end\"");
  expect("[control]", "[[item]]\nname = \"again\"\nask = \"MODE?\"\nanswer = \"{value:d}\"\n[control]",
         "the item \"mode\" asks the same question");
  const std::string status = "[[item]]\nname = \"status\"\nask = \"S?\"\nanswer = \"{lamp:d},{fan:x2}\"\n";
  const std::string lamp = "[[item]]\nname = \"lamp\"\ntell = \"L{value:d}\"\nacknowledged = \"OK\"\n";
  expect("[control]", status + "codes.lamp = { off = 0, on = 5 }\n" + lamp + "codes = { off = 0, on = 1 }\n[control]",
         "one of the codes of \"lamp\" is given twice and differs");
  expect("[control]", status + "flags.lamp = { on = 1, off = 2 }\n" + lamp + "flags = { on = 3 }\n[control]",
         "one of the flags of \"lamp\" is given twice and differs");
  EXPECT_EQ(errors_after("[control]", status + "codes.lamp = { off = 0, on = 1 }\n" + lamp +
                                          "codes = { off = 0, spare = 2 }\n[control]"),
            "")
      << "names that agree are combined";
  expect("state = [", "alarm = [{ item = \"fan\", is = \"jam\" }]\nstate = [", "no item is named \"fan\"");
  const auto flags = map_with_item("name = \"fan\"\nask = \"F?\"\nanswer = \"{value:d}\"\nflags = { stuck = 1 }",
                                   "[[alarm]]\nitem = \"fan\"\nis = \"jam\"");
  EXPECT_NE(parse_register_map(flags, "test").error().what.find("has no flag named \"jam\"; expected one of: stuck"),
            std::string::npos);
}

TEST(TextMap, RejectedItemCausesOneError) {
  for (const auto& [from, to] :
       {std::pair<std::string, std::string>("{running:s1}{error:s1}", "{running:s}{error:s1}"),
        std::pair<std::string, std::string>("{value:f.1}\", \"NONE\"", "{value:q}\", \"NONE\"")}) {
    std::string file = kWordMap;
    file.replace(file.find(from), from.size(), to);
    const auto map = parse_register_map(file, "test.toml");
    ASSERT_FALSE(map) << to;
    EXPECT_EQ(std::ranges::count(map.error().what, '\n'), 0) << map.error().what;
  }
}

}  // namespace
}  // namespace gyrotherm::drivers
