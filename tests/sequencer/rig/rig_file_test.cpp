// SPDX-License-Identifier: Apache-2.0
#include "sequencer/rig/rig_file.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "core/file.hpp"

namespace gyrotherm::rig {
namespace {

const std::string kRigs = GYROTHERM_SOURCE_DIR "/profiles/rigs/";

std::string replace_once(std::string text, const std::string& what, const std::string& with) {
  const auto at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), with);
}

std::string virtual_rig() { return read_text_file(kRigs + "virtual.toml").value(); }

/// Returns the error of a rig file in the folder of the shipped rig.
std::string rig_error(const std::string& text) {
  const auto rig = parse_rig(text, kRigs + "virtual.toml");
  return rig ? "" : rig.error().what;
}

TEST(RigFile, ShippedVirtualRigsAreCompleteAndSimulated) {
  for (const auto* name : {"virtual.toml", "virtual-reference.toml", "virtual-gradients.toml", "virtual-mixed.toml"}) {
    const auto rig = read_rig(kRigs + name);
    ASSERT_TRUE(rig) << text(rig.error());
    EXPECT_TRUE(rig->simulated);
    EXPECT_EQ(list_channels(*rig).size(), 9u);
    EXPECT_EQ(rig->units[0].info.gradients.size(), 8u);
    EXPECT_EQ(rig->units[0].info.three_point, (std::vector<std::string>{"A", "D", "shell"}));
  }
}

TEST(RigFile, ParsesEveryShippedRig) {
  int real = 0, simulated = 0;
  for (const auto& entry : std::filesystem::directory_iterator(kRigs)) {
    if (entry.path().extension() != ".toml") continue;
    const auto rig = read_rig(entry.path());
    ASSERT_TRUE(rig) << text(rig.error());
    EXPECT_EQ(rig->name, entry.path().stem());
    EXPECT_EQ(rig->simulated, rig->name.starts_with("virtual"));
    ++(rig->simulated ? simulated : real);
  }
  EXPECT_GE(simulated, 8);
  EXPECT_GE(real, 2) << "examples of real rigs";
}

TEST(RigFile, ProjectsEarthRateOntoInputAxis) {
  const auto rig = read_rig(kRigs + "virtual.toml");
  ASSERT_TRUE(rig) << text(rig.error());
  ASSERT_TRUE(rig->units[0].info.axes[0].earth_rate);
  EXPECT_GT(rig->units[0].info.axes[0].earth_rate->value, 0);
  EXPECT_LT(rig->units[0].info.axes[0].earth_rate->value, 15.0411);
}

TEST(RigFile, ReportsMisspeltKeyWithPositionAndSuggestion) {
  const auto rig = parse_rig(replace_once(virtual_rig(), "safe_set_point", "save_set_point"), kRigs + "virtual.toml");
  ASSERT_FALSE(rig);
  EXPECT_EQ(rig.error().kind, FaultKind::bad_file);
  EXPECT_NE(rig.error().where.find("virtual.toml:"), std::string::npos);
  EXPECT_NE(rig.error().what.find("safe_set_point"), std::string::npos);
}

TEST(RigFile, RefusesMixOfVirtualAndRealLines) {
  EXPECT_NE(
      rig_error(replace_once(virtual_rig(), "line = \"virtual\"", "line = \"tcp://192.168.1.20:502\"")).find("wholly"),
      std::string::npos);
}

TEST(RigFile, RefusesLineThatIsNotAddress) {
  EXPECT_NE(rig_error(replace_once(virtual_rig(), "line = \"virtual\"", "line = \"COM3\"")), "");
}

/// Returns a shipped example of a real rig with additional lines before the first line that begins with `before`.
std::string real_rig_with(const std::string& lines, const std::string& example = "example-f4t-lakeshore-kvh.toml",
                          const std::string& before = "safe_set_point = ") {
  auto text = read_text_file(kRigs + example).value();
  const std::string table = "[chamber.link]\n";  // has only comments
  if (const auto at = text.find(table); at != std::string::npos) text.erase(at, table.size());
  return replace_once(text, before, lines + before);
}

drivers::ModbusLink read_link(const std::string& text) {
  const auto rig = parse_rig(text, kRigs + "mine.toml");
  EXPECT_TRUE(rig) << gyrotherm::text(rig.error());
  return rig ? rig->chamber_map.link.modbus : drivers::ModbusLink{};
}

TEST(RigFile, RefusesEmptyLineOfEachInstrument) {
  const auto text = read_text_file(kRigs + "example-binder-dcon-stim300.toml").value();
  int lines = 0;
  for (auto at = text.find("\nline = \""); at != std::string::npos; at = text.find("\nline = \"", at + 1)) {
    const auto begins = at + std::string("\nline = \"").size();
    auto emptied = text;
    emptied.erase(begins, text.find('"', begins) - begins);
    EXPECT_NE(rig_error(emptied).find("\"line\" is empty"), std::string::npos) << emptied.substr(at, 40);
    ++lines;
  }
  EXPECT_EQ(lines, 4);
}

TEST(RigFile, NamesMissingStreamOfGyro) {
  auto text = read_text_file(kRigs + "example-binder-dcon-stim300.toml").value();
  text = replace_once(text, "stream = \"stim300\"\n", "");
  EXPECT_NE(rig_error(text).find("missing key \"stream\""), std::string::npos) << rig_error(text);
  EXPECT_EQ(rig_error(text).find("gyro.frame.field"), std::string::npos);
}

TEST(RigFile, LinkSettingsReplaceThoseOfMap) {
  using std::chrono::milliseconds;
  const auto plain = read_link(real_rig_with(""));
  EXPECT_EQ(plain.unit, 1);
  EXPECT_EQ(plain.timeout, milliseconds(600));
  EXPECT_FALSE(plain.echo || plain.returns_other_transaction || plain.returns_other_unit ||
               plain.miscounts_write_replies);
  const auto tcp = read_link(
      real_rig_with("link = { unit = 2, timeout = \"1500 ms\", read_at_most = 20, returns_other_transaction = true, "
                    "returns_other_unit = true, miscounts_write_replies = true }\n"));
  EXPECT_EQ(tcp.unit, 2);
  EXPECT_EQ(tcp.timeout, milliseconds(1500));
  EXPECT_EQ(tcp.read_at_most, 20);
  EXPECT_TRUE(tcp.returns_other_transaction && tcp.returns_other_unit && tcp.miscounts_write_replies);
  EXPECT_EQ(tcp.port, plain.port) << "unstated settings come from the map";
  const auto serial =
      read_link(real_rig_with("link = { unit = 3, echo = true }\n", "example-binder-dcon-stim300.toml"));
  EXPECT_EQ(serial.unit, 3);
  EXPECT_TRUE(serial.echo);
  const auto gateway = read_link(real_rig_with("link = { framing = \"rtu_over_tcp\", echo = true }\n"));
  EXPECT_TRUE(gateway.echo);
  EXPECT_EQ(gateway.framing, drivers::ModbusLink::Framing::rtu);
  const auto order = parse_rig(real_rig_with("link = { word_order = \"dcba\" }\n"), kRigs + "mine.toml");
  ASSERT_TRUE(order);
  EXPECT_EQ(order->chamber_word_order, drivers::WordOrder::dcba);
}

TEST(RigFile, RefusesMistakesInVirtualChamberOfRealRig) {
  const auto map = read_text_file(GYROTHERM_SOURCE_DIR "/profiles/chambers/lauda.toml").value();
  const auto folder = std::filesystem::path(::testing::TempDir()) / "virtual_chamber";
  std::filesystem::create_directories(folder);
  for (const auto& [from, to] : {std::pair("turns_on = [", "turn_on = ["), std::pair("initial = [", "initially = [")}) {
    const auto chamber = (folder / "lauda.toml").string();
    std::ofstream(chamber) << replace_once(map, from, to);
    auto file = real_rig_with("");
    const auto begin = file.find("map = \""), end = file.find('\n', begin);
    file.replace(begin, end - begin, "map = \"" + chamber + "\"");
    const auto rig = parse_rig(file, kRigs + "mine.toml");
    ASSERT_FALSE(rig) << to;
    EXPECT_NE(rig.error().what.find(std::string(to).substr(0, 5)), std::string::npos) << text(rig.error());
  }
}

TEST(RigFile, ParametersReplaceThoseOfTextChamber) {
  const auto with = [](const std::string& lines) {
    auto text = real_rig_with(lines);
    const auto begin = text.find("map = \""), end = text.find('\n', begin);
    text.replace(begin, end - begin, "map = \"../chambers/lauda.toml\"");
    return parse_rig(text, kRigs + "mine.toml");
  };
  const auto rig = with("parameter = { type = \"^VC 600$\" }\nlink = { after_read = \"40 ms\" }\n");
  ASSERT_TRUE(rig) << text(rig.error());
  EXPECT_EQ(rig->chamber_map.identity->pattern, "^VC 600$");
  EXPECT_EQ(rig->chamber_parameters, (drivers::TextParameters{{"type", "^VC 600$"}}));
  EXPECT_EQ(rig->chamber_map.link.text.after_read, std::chrono::milliseconds(40));
  const auto unknown = with("parameter = { typ = \"VC\" }\n");
  ASSERT_FALSE(unknown);
  EXPECT_TRUE(unknown.error().where.starts_with(kRigs + "mine.toml:")) << unknown.error().where;
  EXPECT_NE(unknown.error().what.find("has no parameter \"typ\", expected one of: type"), std::string::npos)
      << unknown.error().what;
  const auto modbus = parse_rig(real_rig_with("parameter = { type = 1 }\n"), kRigs + "mine.toml");
  ASSERT_FALSE(modbus);
  EXPECT_NE(modbus.error().what.find("expected none"), std::string::npos) << modbus.error().what;
  EXPECT_FALSE(parse_rig(real_rig_with("link = { after_read = \"40 ms\" }\n"), kRigs + "mine.toml"));
}

TEST(RigFile, RefusesSettingsThatLinkCannotHave) {
  const auto expect = [](const std::string& lines, const std::string& mistake, const char* example) {
    const auto rig = parse_rig(real_rig_with(lines, example), kRigs + "mine.toml");
    ASSERT_FALSE(rig) << lines;
    EXPECT_EQ(rig.error().kind, FaultKind::bad_file);
    EXPECT_TRUE(rig.error().where.starts_with(kRigs + "mine.toml:")) << rig.error().where;
    EXPECT_NE(rig.error().what.find(mistake), std::string::npos) << rig.error().what;
  };
  constexpr const char* kTcp = "example-f4t-lakeshore-kvh.toml";
  constexpr const char* kSerial = "example-binder-dcon-stim300.toml";
  expect("link = { unit = 256 }\n", "\"unit\" is 256", kTcp);
  expect("link = { timeout = \"2100 ms\" }\n", "\"timeout\" is out of range", kTcp);
  expect("link = { timeout = \"2 s\", after_write = \"5 s\" }\n", "a pause of 5 s and twice the timeout of 2 s are 9 s",
         kTcp);
  expect("link = { timeout = \"0 s\" }\n", "\"timeout\" is out of range", kSerial);
  expect("link = { read_at_most = 126 }\n", "\"read_at_most\" is 126", kTcp);
  expect("link = { read_at_most = 1 }\n", "in one exchange", kTcp);
  expect("link = { echo = true }\n", "Modbus TCP has no echo", kTcp);
  expect("link = { returns_other_transaction = true }\n", "RTU frames have no such field", kSerial);
  expect("link = { returns_other_unit = true }\n", "RTU identifies a reply only by its unit number", kSerial);
  expect("link = { miscounts_write_replies = true }\n", "RTU frames have no such field", kSerial);
  expect("link = { speed = 9600 }\n", "speed", kSerial);
  expect("framing = \"tcp\"\nlink = { framing = \"tcp\" }\n", "expected only one of them", kTcp);
  const auto in_virtual = [](const std::string& link) {
    return rig_error(replace_once(virtual_rig(), "line = \"virtual\"", "line = \"virtual\"\nlink = { " + link + " }"));
  };
  EXPECT_NE(in_virtual("echo = true").find("a virtual line does not echo"), std::string::npos);
  EXPECT_NE(in_virtual("unit = 7").find("a virtual unit has the number of its map"), std::string::npos);
  EXPECT_EQ(in_virtual("unit = 1, timeout = \"1 s\""), "");
}

TEST(RigFile, AllowsTextInstrumentsOnEchoingLine) {
  const auto text = real_rig_with("link = { echo = true }\n", "example-binder-dcon-stim300.toml", "addresses = ");
  const auto rig = parse_rig(text, kRigs + "mine.toml");
  ASSERT_TRUE(rig) << gyrotherm::text(rig.error());
  EXPECT_TRUE(rig->thermometers[0].echo);
  EXPECT_FALSE(rig->thermometers[1].echo);
  const auto usb =
      real_rig_with("link = { echo = true }\n", "example-binder-dcon-stim300.toml", "line = \"hid:01A2B3C4\"");
  EXPECT_NE(parse_rig(usb, kRigs + "mine.toml").error().what.find("can echo"), std::string::npos);
}

/// The relay must work while the line of the chamber is dead.
TEST(RigFile, RefusesRelayOnLineOfInstrument) {
  const auto text = read_text_file(kRigs + "example-f4t-lakeshore-kvh.toml").value();
  const auto refusal_of = [&](const std::string& line) {
    const auto rig = parse_rig(text + "\n[safe.also]\nline = \"" + line + "\"\ncoil = 3\n", kRigs + "mine.toml");
    return rig ? "" : rig.error().what;
  };
  const auto chamber = parse_rig(text, kRigs + "mine.toml").value().chamber_line;
  const auto host = chamber.substr(0, chamber.rfind(':'));
  for (const auto& line :
       {chamber, host + ":502", host, std::string("serial:/dev/serial/by-id/usb-Moxa_UPort_1150-if00-port0?19200,8N1")})
    EXPECT_NE(refusal_of(line).find("expected a line of the relay's own"), std::string::npos) << line;
  for (const auto& line : {host + ":503", std::string("tcp://192.0.2.77"), std::string("serial:/dev/ttyRelay")})
    EXPECT_EQ(refusal_of(line), "") << line;
}

/// The second instrument would otherwise be reported as locked by another program.
TEST(RigFile, RefusesLinkSettingsWithoutEffectOfRelay) {
  const auto refused = [](const std::string& relay, const std::string& link) {
    return rig_error(
        replace_once(virtual_rig(), "[limits]", "[safe.also]\n" + relay + "link = { " + link + " }\n[limits]"));
  };
  const std::string coil = "line = \"tcp://10.0.0.9\"\ncoil = 3\n";
  const std::string lines =
      "line = \"serial:/dev/ttyUSB9\"\nask = \"?\"\ntell_open = \"o\"\ntell_close = \"c\"\nis_open = \"0\"\nis_closed "
      "= \"1\"\n";
  EXPECT_EQ(refused(coil, "unit = 2"), "");
  EXPECT_EQ(refused(lines, "echo = true, after_write = \"20 ms\", after_read = \"20 ms\""), "");
  EXPECT_NE(refused(coil, "echo = true").find("has no echo"), std::string::npos);
  EXPECT_NE(refused(coil, "after_read = \"20 ms\"").find("lines of text only"), std::string::npos);
  EXPECT_NE(refused(lines, "unit = 2").find("no unit number"), std::string::npos);
  EXPECT_NE(refused(lines, "after_write = \"8 s\"").find("longer than 0.5 s"), std::string::npos);
  EXPECT_NE(refused(lines, "read_at_most = 2").find("applies to Modbus only"), std::string::npos);
}

TEST(RigFile, RefusesPortOfTwoInstruments) {
  const auto text = read_text_file(kRigs + "example-f4t-lakeshore-kvh.toml").value();
  const auto with_gyro_at = [&](const std::string& line) {
    const auto was = "serial:/dev/serial/by-id/usb-Moxa_UPort_1150-if00-port0";
    const auto rig = parse_rig(replace_once(text, was, line), kRigs + "mine.toml");
    return rig ? "" : rig.error().what;
  };
  EXPECT_NE(with_gyro_at("serial:/dev/serial/by-id/usb-FTDI_USB-RS232_Cable_FT123456-if00-port0")
                .find("FT123456-if00-port0?9600,7O1\" is the line of two instruments"),
            std::string::npos);
  EXPECT_EQ(with_gyro_at("tcp://192.168.1.20:502"), "") << "an address may lead to several instruments";
}

TEST(RigFile, NamesPositionOfLineThatIsTaken) {
  const auto text = read_text_file(kRigs + "example-f4t-lakeshore-kvh.toml").value();
  const auto rig =
      parse_rig(replace_once(text, "usb-Moxa_UPort_1150-if00-port0", "usb-FTDI_USB-RS232_Cable_FT123456-if00-port0"),
                kRigs + "mine.toml");
  ASSERT_FALSE(rig);
  const auto line =
      1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(text.find("usb-FTDI")), '\n');
  EXPECT_NE(rig.error().where.find(":" + std::to_string(line) + ":"), std::string::npos) << rig.error().where;
}

TEST(RigFile, ReportsMisspeltLineWithoutConsequences) {
  for (const auto* line : {"virtuel", "http://10.0.0.5"}) {
    const auto error =
        rig_error(replace_once(virtual_rig(), "line = \"virtual\"", std::string("line = \"") + line + "\""));
    EXPECT_NE(error, "");
    EXPECT_EQ(error.find("[virtual]"), std::string::npos) << error;
    EXPECT_EQ(error.find("wholly"), std::string::npos) << error;
  }
}

TEST(RigFile, ReportsRepeatedChannelOnce) {
  auto text = virtual_rig();
  const auto error = rig_error(replace_once(text, "channels = [\"A\", \"B\"", "channels = [\"A\", \"A\""));
  EXPECT_NE(error.find("channel \"A\" is listed twice"), std::string::npos) << error;
  EXPECT_EQ(error.find("already in use"), std::string::npos) << error;
}

TEST(RigFile, RefusesEmptyName) {
  EXPECT_NE(rig_error(replace_once(virtual_rig(), "name = \"virtual\"", "name = \"\"")).find("is empty"),
            std::string::npos);
}

TEST(RigFile, RefusesThreePointNamesThatAreNotChannels) {
  EXPECT_NE(rig_error(replace_once(virtual_rig(), "\"D\", \"shell\"]", "\"D\", \"shall\"]")).find("shall"),
            std::string::npos);
}

TEST(RigFile, RefusesRepeatedThermometersOfAnalysis) {
  const auto repeated = rig_error(replace_once(virtual_rig(), "\"D\", \"shell\"]", "\"shell\", \"shell\"]"));
  EXPECT_NE(repeated.find("\"shell\" is listed twice"), std::string::npos) << repeated;
}

TEST(RigFile, RefusesRepeatedThermometersOfUnit) {
  const auto with = [](const std::string& keys) {
    return replace_once(virtual_rig(), "[gyro]\n", "[gyro]\n" + keys + "\n");
  };
  for (const auto* keys : {"thermometers = [\"A\", \"A\"]", "three_point = [\"A\", \"D\", \"A\"]"})
    EXPECT_NE(rig_error(with(keys)).find("\"A\" is listed twice"), std::string::npos) << keys;
  const auto three_point = [&](const std::string& keys) {
    return parse_rig(with(keys), kRigs + "virtual.toml").value().units[0].info.three_point.size();
  };
  EXPECT_EQ(three_point(""), 3u) << "the ones of [analysis]";
  EXPECT_EQ(three_point("three_point = []"), 0u);
  EXPECT_EQ(three_point("thermometers = [\"A\", \"B\"]"), 0u);
}

TEST(RigFile, NamesMissingRegisterMap) {
  const auto rig =
      parse_rig(replace_once(virtual_rig(), "chambers/virtual.toml", "chambers/none.toml"), kRigs + "virtual.toml");
  ASSERT_FALSE(rig);
  EXPECT_NE(rig.error().what.find("none.toml"), std::string::npos);
}

TEST(RigFile, RefusesLimitThatWouldEndEveryRun) {
  for (const auto* line : {"confirming_samples = 0", "suspend_after = \"0 s\"", "gyro_lost = \"0 s\"",
                           "air_lowest = 200", "gyro_band = 0", "frozen_after = \"0 s\"", "response_step = 0"})
    EXPECT_NE(rig_error(replace_once(virtual_rig(), "[limits]\n", "[limits]\n" + std::string(line) + "\n")), "")
        << line;
}

TEST(RigFile, RefusesAbortTimeShorterThanSuspendTime) {
  const auto said = rig_error(
      replace_once(virtual_rig(), "[limits]\n", "[limits]\nsuspend_after = \"40 s\"\nthermometers_lost = \"10 s\"\n"));
  EXPECT_NE(said.find("thermometers_lost is 10 s, expected suspend_after, 40 s, or more"), std::string::npos) << said;
}

TEST(RigFile, RefusesSafeSetPointOutsideAirLimits) {
  const auto said = rig_error(replace_once(virtual_rig(), "[limits]\n", "[limits]\nair_highest = 15\n"));
  EXPECT_NE(said.find("the safe set point is 20 °C, outside the air limits, -60 to 15 °C"), std::string::npos) << said;
}

TEST(RigFile, RefusesThermometerNameThatRecordRefuses) {
  for (const auto* name : {"slot", "A,B", "", "a"}) {
    const auto said = rig_error(replace_once(virtual_rig(), "\"B\"", "\"" + std::string(name) + "\""));
    EXPECT_NE(said.find(std::string("thermometer \"") + name + "\": "), std::string::npos) << said;
  }
}

TEST(RigFile, RefusesRatesOfChamberBelowLowest) {
  for (const auto* key : {"fastest_heating", "fastest_cooling"})
    for (const auto* rate : {"-6 °C/min", "0 °C/min", "1e-300 °C/min"}) {
      const auto said = std::string(key) + " = \"6 °C/min\"";
      const auto mistake = rig_error(replace_once(virtual_rig(), said, std::string(key) + " = \"" + rate + "\""));
      EXPECT_NE(mistake.find("at least 0.001 °C/min"), std::string::npos) << key << " " << rate << ": " << mistake;
    }
}

/// Returns the shipped rig with only these limits.
Result<RigFile> with_limits(const std::string& lines) {
  auto text = virtual_rig();
  const auto from = text.find("[limits]\n"), to = text.find("\n[", from);
  return parse_rig(text.replace(from, to - from, "[limits]\n" + lines), kRigs + "virtual.toml");
}

TEST(RigFile, ReadsEachLimit) {
  using std::chrono_literals::operator""s;
  using std::chrono_literals::operator""min;
  using std::chrono_literals::operator""h;
  const auto rig = with_limits(R"(air_lowest = -51
air_highest = 91
thermometers_lowest = -52
thermometers_highest = 92
confirming_samples = 3
thermometers_needed = 4
air_fastest = 21
thermometers_fastest = 16
disagreement = 61
chamber_disagreement = 11
air_thermometers = ["shell"]
suspend_after = "6 s"
chamber_lost = "11 min"
thermometers_lost = "12 min"
gyro_lost = "61 min"
chamber_lag = "3 min"
follow_band = 3
follow_time = "6 min"
frozen_after = "62 s"
gyro_dead_after = "63 s"
gyro_band = 5
response_step = 25
response_time = "31 min"
drift = 2
backlog = "61 s"
clear_after = "11 s"
resume_delay = "12 s"
longest_suspended = "3 h"
longest_held = "13 h"
longest_return = "5 h"
)");
  ASSERT_TRUE(rig) << text(rig.error());
  const auto& limits = rig->limits;
  EXPECT_EQ(limits.air_lowest, Celsius{-51});
  EXPECT_EQ(limits.air_highest, Celsius{91});
  EXPECT_EQ(limits.thermometers_lowest, Celsius{-52});
  EXPECT_EQ(limits.thermometers_highest, Celsius{92});
  EXPECT_EQ(limits.confirming_samples, 3);
  EXPECT_EQ(limits.thermometers_needed, 4);
  EXPECT_EQ(limits.air_fastest, CelsiusPerMinute{21});
  EXPECT_EQ(limits.thermometers_fastest, CelsiusPerMinute{16});
  EXPECT_EQ(limits.disagreement, Kelvins{61});
  EXPECT_EQ(limits.chamber_disagreement, Kelvins{11});
  EXPECT_EQ(limits.air_thermometers, (std::vector<std::size_t>{8}));
  EXPECT_EQ(limits.suspend_after, 6s);
  EXPECT_EQ(limits.chamber_lost, 11min);
  EXPECT_EQ(limits.thermometers_lost, 12min);
  EXPECT_EQ(limits.gyro_lost, 61min);
  EXPECT_EQ(limits.chamber_lag, 3min);
  EXPECT_EQ(limits.follow_band, Kelvins{3});
  EXPECT_EQ(limits.follow_time, 6min);
  EXPECT_EQ(limits.frozen_after, 62s);
  EXPECT_EQ(limits.gyro_dead_after, 63s);
  EXPECT_EQ(limits.gyro_band, DegreesPerHour{5});
  EXPECT_EQ(limits.response_step, Kelvins{25});
  EXPECT_EQ(limits.response_time, 31min);
  EXPECT_EQ(limits.drift, Kelvins{2});
  EXPECT_EQ(limits.backlog, 61s);
  EXPECT_EQ(limits.clear_after, 11s);
  EXPECT_EQ(rig->run_limits.resume_delay, 12s);
  EXPECT_EQ(rig->run_limits.longest_suspended, 3h);
  EXPECT_EQ(rig->run_limits.longest_held, 13h);
  EXPECT_EQ(rig->run_limits.longest_return, 5h);
}

/// docs/interlocks.md has the table.
TEST(RigFile, UsesDocumentedDefaultsOfLimits) {
  using std::chrono_literals::operator""s;
  using std::chrono_literals::operator""min;
  using std::chrono_literals::operator""h;
  const auto rig = with_limits("");
  ASSERT_TRUE(rig) << text(rig.error());
  const auto& limits = rig->limits;
  for (const auto lowest : {limits.air_lowest, limits.thermometers_lowest}) EXPECT_EQ(lowest, Celsius{-60});
  for (const auto highest : {limits.air_highest, limits.thermometers_highest}) EXPECT_EQ(highest, Celsius{100});
  EXPECT_EQ(limits.confirming_samples, 2);
  EXPECT_EQ(limits.thermometers_needed, 1);
  EXPECT_EQ(limits.air_fastest, CelsiusPerMinute{20});
  EXPECT_EQ(limits.thermometers_fastest, CelsiusPerMinute{15});
  EXPECT_EQ(limits.disagreement, Kelvins{60});
  EXPECT_EQ(limits.chamber_disagreement, Kelvins{10});
  EXPECT_TRUE(limits.air_thermometers.empty());
  EXPECT_EQ(limits.suspend_after, 5s);
  for (const auto lost : {limits.chamber_lost, limits.thermometers_lost}) EXPECT_EQ(lost, 10min);
  EXPECT_EQ(limits.gyro_lost, 60min);
  EXPECT_EQ(limits.chamber_lag, 2min);
  EXPECT_EQ(limits.follow_band, Kelvins{2});
  EXPECT_EQ(limits.follow_time, 5min);
  for (const auto time : {limits.frozen_after, limits.gyro_dead_after}) EXPECT_EQ(time, 60s);
  EXPECT_EQ(limits.gyro_band, std::nullopt);
  EXPECT_EQ(limits.response_step, Kelvins{20});
  EXPECT_EQ(limits.response_time, 30min);
  EXPECT_EQ(limits.drift, Kelvins{1.5});
  EXPECT_EQ(limits.backlog, 60s);
  for (const auto delay : {limits.clear_after, rig->run_limits.resume_delay}) EXPECT_EQ(delay, 10s);
  EXPECT_EQ(rig->run_limits.longest_suspended, 2h);
  EXPECT_EQ(rig->run_limits.longest_held, 12h);
  EXPECT_EQ(rig->run_limits.longest_return, 4h);
}

std::string with_tables(const std::string& tables) {
  return replace_once(virtual_rig(), "[limits]\n", tables + "[limits]\n");
}

TEST(RigFile, RefusesPolicyThatWouldDamageUnit) {
  const auto rig =
      parse_rig(with_tables("[policy]\ndoor = \"hold\"\ngyro_silent = \"warn\"\n"), kRigs + "virtual.toml");
  ASSERT_TRUE(rig) << text(rig.error());
  EXPECT_EQ(rig->limits.policy[static_cast<std::size_t>(interlocks::InterlockId::door)], interlocks::Reaction::hold);
  EXPECT_EQ(rig->limits.policy[static_cast<std::size_t>(interlocks::InterlockId::gyro_silent)],
            interlocks::Reaction::warn);
  EXPECT_EQ(rig->limits.policy[static_cast<std::size_t>(interlocks::InterlockId::restarted)],
            interlocks::Reaction::suspend);
  EXPECT_EQ(rig->limits.policy[static_cast<std::size_t>(interlocks::InterlockId::restarted_off)],
            interlocks::Reaction::hold);
  EXPECT_NE(rig_error(with_tables("[policy]\nair_limit = \"warn\"\n")), "");
  EXPECT_NE(rig_error(with_tables("[policy]\ndoors = \"hold\"\n")), "");
  EXPECT_NE(rig_error(with_tables("[policy]\ndoor = \"stop\"\n")), "");
}

TEST(RigFile, PolicyOfRestartAppliesToRestartWithChamberOff) {
  const auto policy_of = [](const std::string& policy) {
    const auto rig = parse_rig(with_tables("[policy]\n" + policy), kRigs + "virtual.toml");
    EXPECT_TRUE(rig) << text(rig.error());
    return rig->limits.policy[static_cast<std::size_t>(interlocks::InterlockId::restarted_off)];
  };
  EXPECT_EQ(policy_of("restarted = \"suspend\"\n"), interlocks::Reaction::suspend) << "as in files of 0.1.0";
  EXPECT_EQ(policy_of("restarted_off = \"suspend\"\n"), interlocks::Reaction::suspend);
  EXPECT_EQ(policy_of("restarted = \"suspend\"\nrestarted_off = \"abort\"\n"), interlocks::Reaction::abort);
}

TEST(RigFile, ReadsSafeSequenceWithinChamberLimits) {
  const auto rig =
      parse_rig(with_tables("[safe]\nset_point = 23\noff = true\non_stop = \"hold\"\n"), kRigs + "virtual.toml");
  ASSERT_TRUE(rig) << text(rig.error());
  EXPECT_EQ(rig->safe_set_point, Celsius{23});
  EXPECT_TRUE(rig->safe_off);
  EXPECT_EQ(rig->run_limits.on_stop, interlocks::OnStop::hold);
  EXPECT_NE(rig_error(with_tables("[safe]\nset_point = 90\n")), "");
}

TEST(RigFile, RefusesSwitchOffThatMapCannotCommand) {
  for (const auto& [map, can_stop] : {std::pair("eurotherm_3504", false), std::pair("watlow_f4", false),
                                      std::pair("lauda", true), std::pair("watlow_f4t", true)})
    for (const bool off : {false, true}) {
      auto file = with_tables(off ? "[safe]\noff = true\n" : "[safe]\noff = false\n");
      const auto begin = file.find("map = \""), end = file.find('\n', begin);
      file.replace(begin, end - begin, "map = \"../chambers/" + std::string(map) + ".toml\"");
      const bool is_refused = rig_error(file).find("has no command that stops the chamber") != std::string::npos;
      EXPECT_EQ(is_refused, off && !can_stop) << map << ": " << rig_error(file);
    }
  const auto record = read_text_file(GYROTHERM_SOURCE_DIR "/profiles/chambers/watlow_f4.toml").value();
  const auto rig = parse_rig(with_tables("[safe]\noff = true\n"), kRigs + "virtual.toml", {.chamber_map = record});
  EXPECT_TRUE(rig) << "a record can still be read: " << text(rig.error());
}

TEST(RigFile, ReadsLimitsOfSingleThermometer) {
  const auto own = [](const std::string& tables) {
    return replace_once(virtual_rig(), "\n[virtual]\n", "\n" + tables + "\n[virtual]\n");
  };
  const auto rig = parse_rig(own("[limits.channel.C]\nhighest = \"61 °C\"\n"), kRigs + "virtual.toml");
  ASSERT_TRUE(rig) << text(rig.error());
  ASSERT_EQ(rig->limits.thermometers.size(), 9u);
  EXPECT_EQ(rig->limits.thermometers[2].highest, Celsius{61});
  EXPECT_EQ(rig->limits.thermometers[2].lowest, Celsius{-50});
  EXPECT_EQ(rig->limits.thermometers[3].highest, Celsius{85});
  EXPECT_NE(rig_error(own("[limits.channel.Z]\nhighest = 60\n")), "");
}

TEST(RigFile, ParsesWithFilesStoredInRecord) {
  const auto map = read_text_file(GYROTHERM_SOURCE_DIR "/profiles/chambers/virtual.toml").value();
  const auto gyro = read_text_file(GYROTHERM_SOURCE_DIR "/profiles/gyros/calibrated.reduced.toml").value();
  const auto rig = parse_rig(virtual_rig(), "elsewhere/rig.toml", {.chamber_map = map, .gyro_model = gyro});
  ASSERT_TRUE(rig) << text(rig.error());
  EXPECT_EQ(rig->gyro_model.text, gyro);
  EXPECT_FALSE(parse_rig(virtual_rig(), "elsewhere/rig.toml", {.chamber_map = map, .gyro_model = {}}));
}

TEST(RigFile, NamesMissingGyroModel) {
  const auto rig = parse_rig(replace_once(virtual_rig(), "gyros/calibrated", "gyros/none"), kRigs + "virtual.toml");
  ASSERT_FALSE(rig);
  EXPECT_EQ(rig.error().kind, FaultKind::bad_file);
  EXPECT_NE(rig.error().where.find("virtual.toml:"), std::string::npos);
  EXPECT_NE(rig.error().what.find("none.reduced.toml"), std::string::npos);
}

TEST(RigFile, TakesFramesScaleAndPortFromStream) {
  const auto rig = read_rig(kRigs + "example-f4t-lakeshore-kvh.toml");
  ASSERT_TRUE(rig) << text(rig.error());
  ASSERT_TRUE(rig->gyro_lines[0].stream);
  EXPECT_EQ(rig->gyro_lines[0].frame.name, "kvh-dsp-3000-ascii");
  EXPECT_EQ(rig->gyro_lines[0].stream->port.baud, 38400u);
  EXPECT_EQ(rig->gyro_lines[0].stream->start.front().send, "RRR");
  EXPECT_EQ(rig->units[0].info.axes[0].scale, 1e-6) << "for a rate, one count is 1e-6 arcsec";
  EXPECT_EQ(rig->limits.units[0].axes[0].largest_bias, DegreesPerHour{20});
}

std::string mixed_rig() { return read_text_file(kRigs + "virtual-mixed.toml").value(); }

TEST(RigFile, RefusesSecondScale) {
  const std::string stream = "stream = \"../gyro-streams/kvh-17xx-a.toml\"";
  EXPECT_EQ(rig_error(mixed_rig()), "");
  EXPECT_NE(rig_error(replace_once(mixed_rig(), stream, stream + "\narcsec_per_pulse = 1")).find("contain their scale"),
            std::string::npos);
  const std::string pulses = "stream = \"../gyro-streams/pulse-count.toml\"";
  const auto of_pulses = replace_once(replace_once(mixed_rig(), stream, pulses), "axis = \"z\"\n", "");
  EXPECT_NE(rig_error(of_pulses).find("arcsec_per_pulse"), std::string::npos);
  EXPECT_EQ(rig_error(replace_once(of_pulses, pulses, pulses + "\narcsec_per_pulse = 0.1")), "");
}

TEST(RigFile, ReadsFrameRateOfGyro) {
  const std::string axis = "axis = \"z\"\n";
  const auto rig = parse_rig(
      replace_once(mixed_rig(), axis, axis + "rate_hz = 100\nlisten_only = true\nlargest_bias_deg_per_h = 3\n"),
      kRigs + "virtual-mixed.toml");
  ASSERT_TRUE(rig) << text(rig.error());
  EXPECT_EQ(rig->gyro_lines[0].frame.rate_hz, 100);
  EXPECT_TRUE(rig->gyro_lines[0].listen_only);
  EXPECT_EQ(rig->limits.units[0].axes[0].largest_bias, DegreesPerHour{3}) << "replaces the 20 of its stream";
  EXPECT_FALSE(read_rig(kRigs + "virtual-mixed.toml")->gyro_lines[0].listen_only);
  EXPECT_NE(rig_error(replace_once(mixed_rig(), axis, axis + "rate_hz = 0\n")).find("positive number of frames"),
            std::string::npos);
  EXPECT_NE(rig_error(replace_once(mixed_rig(), axis, axis + "largest_bias_deg_per_h = -1\n")).find("zero or more"),
            std::string::npos);
}

TEST(RigFile, ReportsMismatchOfSerialNumber) {
  const std::string axis = "axis = \"z\"\n";
  const auto compared = [&](const std::string& keys, const std::string& identity) {
    const auto rig = parse_rig(replace_once(mixed_rig(), axis, axis + keys), kRigs + "virtual-mixed.toml").value();
    return compare_serial_number(rig.gyro_lines[0], rig.units, identity);
  };
  EXPECT_TRUE(compared("", "vectornav 0100011981"));
  EXPECT_TRUE(compared("serial_number = \"100011981\"\n", "vectornav 0100011981"));
  for (const auto* other : {"vectornav 0100011982", "vectornav 1", "stim300 N25581"}) {
    const auto same = compared("serial_number = \"0100011981\"\n", other);
    ASSERT_FALSE(same) << other;
    EXPECT_EQ(same.error().kind, FaultKind::mismatch);
    EXPECT_EQ(same.error().where, "gyro");
  }
}

TEST(RigFile, NamesMissingOrInvalidStream) {
  EXPECT_NE(rig_error(replace_once(mixed_rig(), "kvh-17xx-a", "none")).find("none.toml"), std::string::npos);
  const auto rig = parse_rig(replace_once(mixed_rig(), "axis = \"z\"", "axis = \"w\""), kRigs + "virtual.toml");
  ASSERT_FALSE(rig);
  EXPECT_NE(text(rig.error()).find("rigs/virtual.toml:"), std::string::npos) << text(rig.error());
  EXPECT_NE(text(rig.error()).find("has no axis \"w\", expected x, y, z"), std::string::npos) << text(rig.error());
}

/// A stream with one axis has no name for it. The error is in the rig file, and it is the only one.
TEST(RigFile, RefusesNameForOnlyAxisOfStream) {
  const auto one_axis = replace_once(mixed_rig(), "kvh-17xx-a", "kvh-dsp-3000-ascii");
  EXPECT_EQ(rig_error(replace_once(one_axis, "axis = \"z\"\n", "")), "");
  const auto named = rig_error(replace_once(one_axis, "axis = \"z\"", "[[gyro.axis]]\nname = \"z\""));
  EXPECT_NE(named.find("single axis without a name"), std::string::npos) << named;
  EXPECT_EQ(named.find("kvh-dsp-3000-ascii.toml"), std::string::npos) << named;
  EXPECT_EQ(std::ranges::count(named, '\n'), 0) << named;
  const auto keyed = rig_error(one_axis);
  EXPECT_NE(keyed.find("single axis without a name"), std::string::npos) << keyed;
}

TEST(RigFile, ParsesWithStreamStoredInRecord) {
  const auto rig = read_rig(kRigs + "virtual-mixed.toml").value();
  const NamedTexts known{.chamber_map = rig.chamber_map.text,
                         .gyro_model = rig.gyro_model.text,
                         .gyro_streams = {{"gyro", rig.gyro_lines[0].stream->text}}};
  const auto again = parse_rig(rig.text, "elsewhere/rig.toml", known);
  ASSERT_TRUE(again) << text(again.error());
  EXPECT_EQ(again->gyro_lines[0].frame.name, "kvh-17xx-a");
}

TEST(RigFile, ReadsCalibrationOfEachChannel) {
  const auto channels = list_channels(read_rig(kRigs + "example-f4t-lakeshore-kvh.toml").value());
  ASSERT_EQ(channels.size(), 9u);
  EXPECT_EQ(channels[0].offset, Kelvins{-0.012});
  EXPECT_EQ(channels[0].certificate, "K-2026-0117") << "from the instrument";
  EXPECT_EQ(channels[1].polynomial, (std::vector<double>{0.0031, 0.99987, 1.2e-6}));
  EXPECT_EQ(channels[1].certificate, "K-2026-0118") << "its own";
  EXPECT_EQ(channels[2].offset, Kelvins{});
  EXPECT_EQ(channels[8].instrument,
            "pt12 2 at serial:/dev/serial/by-id/usb-FTDI_USB-RS232_Cable_FT123457-if00-port0, input 1");
  ASSERT_TRUE(channels[8].due);
}

TEST(RigFile, ReadsUncertaintyOfEachThermometer) {
  const auto rig = read_rig(kRigs + "example-f4t-lakeshore-kvh.toml").value();
  const auto channels = list_channels(rig);
  const auto& of_all = channels[0].uncertainty;
  EXPECT_EQ(of_all.calibration, Kelvins{0.02 / 2}) << "U of the certificate divided by k";
  EXPECT_FALSE(of_all.rectangular);
  EXPECT_EQ(of_all.drift_in_a_year, Kelvins{0.05});
  EXPECT_EQ(of_all.calibrated, record::parse_day("2026-01-17"));
  EXPECT_EQ(channels[1].uncertainty.calibration, Kelvins{0.01 / 2}) << "from the channel; k defaults to 2";
  EXPECT_EQ(channels[1].uncertainty.drift_in_a_year, Kelvins{0.05}) << "from the instrument";
  EXPECT_DOUBLE_EQ(channels[8].uncertainty.calibration->value, 0.03 / std::sqrt(3)) << "limits of ± 0.03 K";
  EXPECT_TRUE(channels[8].uncertainty.rectangular);
  EXPECT_EQ(rig.units[0].info.axes[0].uncertainty.latitude_deg, 47.3769);
  EXPECT_EQ(rig.units[0].info.axes[0].uncertainty.tilt_uncertainty_deg, 0.017);
  EXPECT_EQ(rig.units[0].info.axes[0].uncertainty.turn_on_repeatability_deg_per_h, 0.5);
}

TEST(RigFile, RefusesImpossibleUncertainty) {
  const std::string mark = "channels = [\"A\", \"B\", \"C\", \"D\"]";
  const auto with = [&](const std::string& more) {
    return rig_error(replace_once(mixed_rig(), mark, mark + "\n" + more));
  };
  EXPECT_EQ(with("uncertainty = 0.01\ncoverage_factor = 2\ndrift_k_per_year = 0.05"), "");
  EXPECT_NE(with("uncertainty = 0").find("above zero"), std::string::npos);
  EXPECT_NE(with("uncertainty = 40").find("expected at most 5 K"), std::string::npos);
  EXPECT_NE(with("drift_k_per_year = -0.1").find("above zero"), std::string::npos);
  EXPECT_NE(with("coverage_factor = 2").find("\"uncertainty\", which is missing"), std::string::npos);
  EXPECT_NE(with("uncertainty = 0.01\ncoverage_factor = 2\ndistribution = \"rectangular\"")
                .find("rectangular limits have no"),
            std::string::npos);
  EXPECT_NE(with("calibrated = \"2026-02-30\"").find("expected a day"), std::string::npos);
  const std::string gyro = "[gyro]\n";
  EXPECT_NE(rig_error(replace_once(mixed_rig(), gyro, gyro + "tilt_uncertainty = -1\n")).find("of zero or more"),
            std::string::npos);
}

TEST(RigFile, RefusesImpossibleAngles) {
  for (const auto* line : {"azimuth = 4000", "elevation = 190", "elevation = -91", "azimuth_uncertainty = 100"}) {
    const std::string replaced = std::string(line).starts_with("elevation") ? "elevation = 90.0" : "azimuth = 0.0";
    EXPECT_NE(rig_error(replace_once(mixed_rig(), replaced, line)).find("°, expected"), std::string::npos) << line;
  }
}

TEST(RigFile, RefusesImpossibleCalibration) {
  const std::string mark = "channels = [\"A\", \"B\", \"C\", \"D\"]";
  const auto with = [&](const std::string& more) {
    return rig_error(replace_once(mixed_rig(), mark, mark + "\n" + more));
  };
  const std::string of_a = "[[thermometer.calibration]]\nchannel = \"A\"\n";
  EXPECT_EQ(with(of_a + "offset = 0.1\ndue = \"2027-01-31\""), "");
  EXPECT_NE(with(of_a + "offset = 0.1\npolynomial = [0, 1]").find("one of the two"), std::string::npos);
  EXPECT_NE(with(of_a + "polynomial = [1]").find("2 to 10"), std::string::npos);
  for (const auto* wrong :
       {"polynomial = [0, 0]", "polynomial = [0.99987, 0.0031]", "polynomial = [0, 1, 0.002]", "offset = -273.15"})
    EXPECT_NE(with(of_a + wrong).find("expected a correction of at most 10 K"), std::string::npos) << wrong;
  EXPECT_EQ(with(of_a + "polynomial = [-1.5, 1.02, 3e-4]"), "");
  EXPECT_NE(with("offsets = [0, 0, 293, 0]").find("expected a correction of at most 10 K"), std::string::npos);
  EXPECT_NE(with(of_a + "due = \"2027-02-30\"").find("expected a day"), std::string::npos);
  EXPECT_NE(with("[[thermometer.calibration]]\nchannel = \"Z\"\noffset = 1").find("not a channel"), std::string::npos);
  for (const auto* first : {"offset = 0.1", "offset = 0", "certificate = \"K1\"", "uncertainty = 0.04"})
    EXPECT_NE(with(of_a + first + "\n" + of_a + "offset = 0.2").find("already"), std::string::npos) << first;
  EXPECT_NE(with("offsets = [1, 2]").find("2 offsets for 4 channels"), std::string::npos);
}

TEST(RigFile, ChecksKeysOfEachDriver) {
  const auto file = kRigs + "example-binder-dcon-stim300.toml";
  const auto text_of = read_text_file(file).value();
  const auto with = [&](const std::string& what, const std::string& instead) {
    const auto rig = parse_rig(replace_once(text_of, what, instead), file);
    return rig ? "" : rig.error().what;
  };
  const auto rig = read_rig(file).value();
  EXPECT_EQ(rig.thermometers[0].addresses, (std::vector<std::uint8_t>{1, 2}));
  EXPECT_EQ(rig.thermometers[0].type, 0x10);
  EXPECT_TRUE(std::holds_alternative<drivers::MccRtd>(rig.thermometers[1].sensor.value()));
  EXPECT_LT(rig.units[0].info.axes[0].earth_rate->value, 0) << "its axis points down";
  EXPECT_NE(with("addresses = [1, 2]", "addresses = [1, 256]").find("0 to 255"), std::string::npos);
  EXPECT_NE(with("addresses = [1, 2]", "addresses = [2, 2]").find("has 2 twice"), std::string::npos);
  EXPECT_NE(with("type = \"T\"", "type = \"X\"").find("not one of J, K, T, E"), std::string::npos);
  EXPECT_NE(with("hid:01A2B3C4", "serial:/dev/ttyUSB0").find("HID device"), std::string::npos);
  EXPECT_NE(with("channels = [\"shell\"]", "channels = [\"shell\", \"A\"]").find("is listed twice"), std::string::npos);
  EXPECT_NE(with("kind = \"rtd\"", "kind = \"ntc\"").find("not one of rtd"), std::string::npos);
}

TEST(RigFile, RefusesLimiterInsideSetPointRange) {
  const auto with = [](const std::string& lines) {
    return replace_once(virtual_rig(), "[[thermometer]]", "[chamber.limiter]\n" + lines + "\n[[thermometer]]");
  };
  const auto good =
      parse_rig(with("class = \"3.3\"\nlowest = \"-50 °C\"\nhighest = \"75 °C\"\n"), kRigs + "virtual.toml");
  ASSERT_TRUE(good && good->limiter) << rig_error(with("class = \"3.3\"\nlowest = \"-50 °C\"\nhighest = \"75 °C\"\n"));
  EXPECT_EQ(describe(*good->limiter), "class 3.3, below -50 °C, above 75 °C");
  EXPECT_NE(rig_error(with("class = \"2\"\nhighest = \"70 °C\"\n")).find("would trip"), std::string::npos);
  EXPECT_NE(rig_error(with("class = \"3.2\"\nlowest = \"-40 °C\"\n")).find("would trip"), std::string::npos);
  EXPECT_NE(rig_error(with("class = \"2\"\n")).find("the limiter's settings"), std::string::npos);
  EXPECT_EQ(rig_error(with("class = \"3.3\"\nlowest = 75\nhighest = -50\n")),
            "the limiter's lowest setting is not below its highest");
  EXPECT_NE(rig_error(with("class = \"4\"\nhighest = \"75 °C\"\n")), "");
  const std::string lowest = "lowest = \"-50 °C\"\n", highest = "highest = \"75 °C\"\n";
  EXPECT_EQ(rig_error(with("class = \"3.1\"\n" + highest)), "");
  EXPECT_EQ(rig_error(with("class = \"3.2\"\n" + lowest)), "");
  EXPECT_NE(rig_error(with("class = \"3.1\"\n" + lowest)).find("acts at a high temperature"), std::string::npos);
  EXPECT_NE(rig_error(with("class = \"3.2\"\n" + highest)).find("acts at a low temperature"), std::string::npos);
  for (const auto& one : {lowest, highest})
    EXPECT_NE(rig_error(with("class = \"3.3\"\n" + one)).find("acts on both sides"), std::string::npos) << one;
}

TEST(RigFile, FindsLimiterThatTripsBeforeInterlock) {
  RigFile rig;
  rig.limits.air_lowest = Celsius{-50};
  rig.limits.air_highest = Celsius{70};
  const auto found = [&](std::optional<Celsius> lowest, std::optional<Celsius> highest) {
    rig.limiter = Limiter{.protection_class = "3.3", .lowest = lowest, .highest = highest};
    return describe_limiter_that_trips_first(rig);
  };
  EXPECT_EQ(describe_limiter_that_trips_first(rig), "") << "no limiter is described";
  EXPECT_EQ(found(Celsius{-51}, Celsius{71}), "");
  EXPECT_EQ(found({}, {}), "");
  EXPECT_NE(found(Celsius{-50}, Celsius{71}).find("(air_lowest = -50 °C)"), std::string::npos);
  EXPECT_NE(found({}, Celsius{65}).find("(air_highest = 70 °C)"), std::string::npos);
  EXPECT_NE(found(Celsius{-45}, Celsius{65}).find("(air_lowest = -50 °C, air_highest = 70 °C)"), std::string::npos);
}

}  // namespace
}  // namespace gyrotherm::rig
