// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "drivers/chamber/register_map.hpp"
#include "tests/drivers/line/words.hpp"

namespace gyrotherm::drivers {
namespace {

constexpr const char* kBase = R"(schema = "gyrotherm-chamber/1"
name = "n"
vendor = "v"
source = "s"
)";
constexpr const char* kItems = R"(
[[register]]
name = "air_temperature"
address = 110
type = "s16"
scale = 0.1
[[register]]
name = "set_point"
address = 300
type = "s16"
access = "rw"
scale = 0.1
)";

Result<RegisterMap> parsed(const std::string& head, const std::string& more) {
  return parse_register_map(kBase + head + kItems + more, "map.toml");
}
RegisterMap good(const std::string& more, const std::string& head = "") {
  auto map = parsed(head, more);
  EXPECT_TRUE(map) << text(map.error());
  return map.value();
}
std::string mistakes(const std::string& more, const std::string& head = "") {
  const auto map = parsed(head, more);
  return map ? "" : text(map.error());
}
std::string item(const std::string& rest) { return "[[register]]\nname = \"x\"\naddress = 7\n" + rest; }

TEST(RegisterForm, ReadsBitFieldFromPartOfRegister) {
  const auto map = good(item("type = \"bits\"\nbit = 8\nwidth = 8\n"));
  EXPECT_EQ(decode(*map.find("x"), Words{0x1E05}).value(), 0x1E);
  EXPECT_EQ(encode(*map.find("x"), 30), Words{0x1E00});
  EXPECT_EQ(encode(*map.find("x"), 300), Words{0xFF00}) << "saturates";
}

TEST(RegisterForm, ReadAndWriteMayHaveScalesOfTheirOwn) {
  const auto map = good(item("type = \"s16\"\nscale = 0.01\nwrite_scale = 0.1\naccess = \"rw\"\n"));
  const auto& x = *map.find("x");
  EXPECT_EQ(encode(x, 22), Words{220});
  EXPECT_EQ(encode_as_read(x, 22), Words{2200});
  EXPECT_DOUBLE_EQ(decode(x, Words{2200}).value(), 22);
  EXPECT_DOUBLE_EQ(decode_as_written(x, Words{220}), 22);
  EXPECT_DOUBLE_EQ(x.resolution, 0.1) << "the coarser of the two";
}

TEST(RegisterForm, ConvertsFahrenheitOnlyOnTheWire) {
  const auto map =
      good(item("type = \"s16\"\nscale = 0.1\nunit = \"°F\"\naccess = \"rw\"\n") +
           "[[register]]\nname = \"band\"\naddress = 9\ntype = \"s16\"\nunit = \"°F\"\ndifference = true\n");
  EXPECT_EQ(encode(*map.find("x"), -40), Words{static_cast<std::uint16_t>(-400)});
  EXPECT_NEAR(decode(*map.find("x"), Words{2120}).value(), 100, 1e-9);
  EXPECT_NEAR(decode(*map.find("band"), Words{18}).value(), 10, 1e-9) << "18 °F of difference";
}

TEST(RegisterForm, UsesDecimalsAndUnitOfController) {
  auto x = *good(item("type = \"s16\"\n")).find("x");
  EXPECT_DOUBLE_EQ(decode(apply_context(x, {.decimals = 2, .fahrenheit = false}), Words{2345}).value(), 23.45);
  EXPECT_DOUBLE_EQ(apply_context(x, {.decimals = 3, .fahrenheit = {}}).resolution, 0.001);
  const auto resolution = [](const std::string& more) {
    return good(item("type = \"s16\"\ndecimals = \"d\"\n" + more) +
                "[[register]]\nname = \"d\"\naddress = 8\ntype = \"u16\"\n")
        .find("x")
        ->resolution;
  };
  EXPECT_DOUBLE_EQ(resolution(""), 0.1) << "what is usual, until the controller is asked";
  EXPECT_DOUBLE_EQ(resolution("resolution = 1\n"), 1) << "what the map says of one that is set to whole degrees";
  EXPECT_NEAR(decode(apply_context(x, {.decimals = 1, .fahrenheit = true}), Words{680}).value(), 20, 1e-9);
}

TEST(RegisterForm, NamesFaultOfSentinelAndImpossibleValue) {
  const auto map =
      good(item("type = \"s16\"\nscale = 0.01\nsentinels = { empty = -20000 }\nlowest = -150\nhighest = 250\n"));
  const auto& x = *map.find("x");
  const auto empty = decode(x, Words{0xB1E0});
  ASSERT_FALSE(empty);
  EXPECT_EQ(empty.error().kind, FaultKind::out_of_range);
  EXPECT_EQ(empty.error().what, "empty (B1E0)");
  EXPECT_EQ(decode(x, Words{30000}).error().kind, FaultKind::out_of_range);
  EXPECT_TRUE(decode(x, Words{2500}));
}

TEST(RegisterForm, SentinelsOfFloatsAreRecognised) {
  const auto map = good(item("type = \"f32\"\nsentinels = { none = 200004, under = -999 }\n"));
  for (const double value : {200004.0, -999.0}) EXPECT_FALSE(decode(*map.find("x"), encode(*map.find("x"), value)));
  EXPECT_TRUE(decode(*map.find("x"), encode(*map.find("x"), -998.0)));
}

TEST(RegisterForm, TextHasOneOrTwoCharactersARegister) {
  const TextForm low_first{.characters = 10, .per_register = 2, .low_byte_first = true};
  EXPECT_EQ(encode_text(low_first, "TEST 123"), (Words{0x4554, 0x5453, 0x3120, 0x3332, 0x2020}));
  const TextForm single{.characters = 4, .per_register = 1, .low_byte_first = false, .stride = 2, .padding = '\0'};
  EXPECT_EQ(encode_text(single, "F4T"), (Words{'F', 0, '4', 0, 'T', 0, 0}));
  EXPECT_EQ(decode_text(single, Words{'F', 0, '4', 0, 'T', 0, 0}), "F4T");
  EXPECT_EQ(decode_text(low_first, Words{0x0754, 0x2020, 0x2020, 0x2020, 0x2020}), "T?");
}

TEST(RegisterForm, TextComesBackAsItWasWritten) {
  std::mt19937 random(5);
  for (int i = 0; i < 2000; ++i) {
    const TextForm form{.characters = static_cast<std::uint16_t>(1 + random() % 20),
                        .per_register = static_cast<std::uint8_t>(1 + random() % 2),
                        .low_byte_first = random() % 2 == 0,
                        .stride = static_cast<std::uint16_t>(1 + random() % 3),
                        .padding = random() % 2 == 0 ? ' ' : '\0'};
    std::string text;
    while (text.size() < random() % (form.characters + 1U)) text += static_cast<char>('A' + random() % 26);
    RegisterItem item;
    item.type = RegisterType::text;
    item.text = form;
    const auto words = encode_text(form, text);
    ASSERT_EQ(words.size(), word_count(item)) << "seed 5, " << i;
    ASSERT_EQ(decode_text(form, words), text) << "seed 5, " << i;
  }
}

TEST(RegisterForm, DecodesDatesAndRejectsInvalidOnes) {
  const auto map =
      good(item("type = \"date_time\"\nparts = [\"hour\", \"minute\", \"second\", \"month\", \"day\", \"year\"]\n"
                "stride = 2\n"));
  const auto& form = map.find("x")->date;
  EXPECT_EQ(word_count(*map.find("x")), 11);
  std::mt19937_64 random(11);
  for (int i = 0; i < 1000; ++i) {
    const auto time = to_civil_time(std::chrono::seconds(random() % 4'000'000'000));
    ASSERT_EQ(decode_date(form, encode_date(form, time)).value(), time) << "seed 11, " << i;
  }
  auto words = encode_date(form, {2026, 2, 28, 10, 0, 0});
  words[8] = 30;
  EXPECT_EQ(decode_date(form, words).error().kind, FaultKind::out_of_range) << "30th of February";
  EXPECT_EQ(add_duration({2026, 12, 31, 23, 59, 59}, std::chrono::seconds(2)), (CivilTime{2027, 1, 1, 0, 0, 1}));
}

TEST(RegisterForm, SeveralCodesMayMeanTheSame) {
  const auto map = good(item("type = \"u16\"\ncodes = { none = [61, 88, 12] }\notherwise = \"active\"\n"));
  const auto& x = *map.find("x");
  EXPECT_EQ(meaning(x, 88), "none");
  EXPECT_EQ(meaning(x, 1457), "active");
}

TEST(RegisterMap, SubtractsBaseFromAddressOfFile) {
  const auto map = good(item("type = \"u16\"\n"), "[link]\naddress_base = 1\n");
  EXPECT_EQ(map.find("x")->address, 6);
  EXPECT_NE(
      mistakes("[[register]]\nname = \"x\"\naddress = 0\ntype = \"u16\"\n", "[link]\naddress_base = 1\n").find("-1"),
      std::string::npos);
}

TEST(RegisterMap, EachLinkHasSettingsAndAddressesOfItsOwn) {
  const auto map = good("[[register]]\nname = \"u\"\naddress = { tcp = 6730, rtu = 14080 }\ntype = \"u16\"\n",
                        "[link]\nunit = 0\n[link.tcp]\n[link.rtu]\nserial = \"9600,8E1\"\nminimum_period = \"500 ms\"\n"
                        "unit = 7\n[link.rtu_over_tcp]\nport = 10001\n");
  EXPECT_EQ(map.link.kind, LinkKind::tcp);
  EXPECT_EQ(map.link.modbus.unit, 0);
  EXPECT_EQ(map.find("u")->address, 6730);
  const auto rtu = select_link_for(map, SerialLine{"/dev/ttyS0", {}}).value();
  EXPECT_EQ(rtu.find("u")->address, 14080);
  EXPECT_EQ(rtu.link.modbus.serial.parity, SerialParity::even);
  EXPECT_EQ(rtu.link.modbus.unit, 7);
  EXPECT_EQ(rtu.link.modbus.framing, ModbusLink::Framing::rtu);
  const auto server = select_link_for(rtu, TcpLine{"10.0.0.1", 0}, LinkKind::rtu_over_tcp).value();
  EXPECT_EQ(server.link.modbus.port, 10001);
  EXPECT_EQ(server.find("u")->address, 14080);
  EXPECT_EQ(select_link_for(server, TcpLine{"10.0.0.1", 0}).value().find("u")->address, 6730);
  EXPECT_FALSE(select_link(good(""), LinkKind::rtu)) << "a map says which links it has";
}

TEST(RegisterMap, RepeatsItemsByCount) {
  const auto map = good("[[register]]\nname = \"loop\"\naddress = 60\ntype = \"s16\"\ncount = 5\nspacing = 12\n");
  EXPECT_EQ(map.find("loop_1")->address, 60);
  EXPECT_EQ(map.find("loop_5")->address, 108);
  EXPECT_FALSE(map.find("loop"));
}

TEST(RegisterMap, ReportsEachErrorOfRules) {
  const auto expect = [](const std::string& more, const std::string& what, const std::string& head = "") {
    EXPECT_NE(mistakes(more, head).find(what), std::string::npos) << more << "\n" << mistakes(more, head);
  };
  expect("[sequence]\nstart = [{ write = \"air_temperature\", value = 1 }]", "is not writable");
  expect("[sequence]\nstart = [{ write = \"set_point\", code = \"on\" }]", "no code named \"on\"");
  expect("[sequence]\nstart = [{ wait = { register = \"mode\", is = \"on\" } }]", "no register is named \"mode\"");
  expect("[sequence]\nfly = [{ pause = \"1 s\" }]", "\"fly\" is not one of prepare, start, stop");
  expect("[sequence]\nstart = []", "has no steps");
  expect("[[state]]\nactivity = \"off\"\nregister = \"set_point\"",
         "expected \"is\", \"is_not\", \"bits\" or \"above\"");
  expect("[[state]]\nactivity = \"sleeping\"\nregister = \"set_point\"\nabove = 0", "\"sleeping\" is not one of");
  expect("[[alarm]]\nregister = \"set_point\"\nis = \"open\"", "no code named \"open\"");
  expect("[limits]\nlowest = 20\nhighest = 10", "not below the highest");
  expect("[limits]\nlowest_register = \"low\"", "no register is named \"low\"");
  expect("[[forbidden]]\nfirst = 290\nlast = 310\nwhy = \"no\"", "lies in this range and is writable");
  expect(item("type = \"s16\"\ndecimals = \"d\"\n"), "no register is named \"d\"");
  expect(item("type = \"s16\"\nunit_register = \"air_temperature\"\n"), "no codes \"celsius\" and \"fahrenheit\"");
  expect(item("type = \"text\"\ncharacters = 40\nper_register = 1\n"), "at most 16", "[link]\nread_at_most = 16\n");
  expect(item("type = \"date_time\"\nparts = [\"fortnight\"]\n"), "\"fortnight\" is not one of");
  expect("", "no [link.rtu]", "[link]\nusual = \"rtu\"\n");
  expect("", "the baud rate is unknown", "[link.rtu]\nserial = \"9601,8N1\"\n");
  expect("[profile_memory]\nsteps_at_most = 3\nlongest_step = \"1 h\"", "no cell of a step contains its target");
}

TEST(UnknownTexts, HaveNumbersBelowZero) {
  UnknownTexts texts;
  EXPECT_EQ(texts.assign_number("A"), -1);
  EXPECT_EQ(texts.assign_number("B"), -2);
  EXPECT_EQ(texts.assign_number("A"), -1);
  EXPECT_EQ(texts.find_text(-2), "B");
  for (const double number : {0.0, 1.0, -3.0, -1e300}) EXPECT_FALSE(texts.find_text(number)) << number;
  for (int i = 0; i < 100; ++i) (void)texts.assign_number(std::to_string(i));
  EXPECT_FALSE(texts.find_text(texts.assign_number("one too many")));
}

}  // namespace
}  // namespace gyrotherm::drivers
