// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>

#include "drivers/line/modbus_frame.hpp"
#include "simulator/chamber_registers.hpp"
#include "simulator/servers/modbus_server.hpp"
#include "tests/simulator/shipped_rigs.hpp"
#include "tests/support/modbus_words.hpp"

namespace gyrotherm::simulator {
namespace {

using Words = std::vector<std::uint16_t>;

class ModbusSessionTest : public testing::Test {
 protected:
  Result<Words> ask(const drivers::ModbusRequest& request) {
    std::vector<std::byte> reply;
    EXPECT_TRUE(session.feed(encode_request(request), reply));
    return decode_reply(request, reply);
  }
  Result<Words> read(const char* item) {
    const auto& found = *map.find(item);
    return ask(
        {7, map.link.modbus.unit, drivers::ModbusFunction::read_holding, found.address, word_count(found.type), {}});
  }
  Result<Words> write(const char* item, double value) {
    const auto& found = *map.find(item);
    const auto words = encode(found, value);
    return ask({8, map.link.modbus.unit, drivers::ModbusFunction::write_multiple, found.address,
                static_cast<std::uint16_t>(words.size()), words});
  }
  static void expect_exception(const Result<Words>& reply, const std::string& code) {
    ASSERT_FALSE(reply);
    EXPECT_EQ(reply.error().kind, FaultKind::refused);
    EXPECT_TRUE(reply.error().what.starts_with("exception " + code)) << reply.error().what;
  }

  drivers::RegisterMap map = chamber_map("virtual");
  VirtualLaboratory laboratory{laboratory_of_rig("virtual"), {}};
  ChamberRegisters registers{map, laboratory};
  ModbusSession session{registers};
};

TEST_F(ModbusSessionTest, ReadsMeasuredAir) {
  laboratory.step();
  const auto words = read("air_temperature");
  ASSERT_TRUE(words);
  EXPECT_NEAR(*decode(*map.find("air_temperature"), *words), laboratory.air_as_measured().value, 1e-5);
}

TEST_F(ModbusSessionTest, AnswersGoldenFrames) {
  const auto bytes = [](std::initializer_list<int> values) {
    std::vector<std::byte> all;
    for (const int value : values) all.push_back(static_cast<std::byte>(value));
    return all;
  };
  std::vector<std::byte> reply;
  ASSERT_TRUE(session.feed(bytes({0x12, 0x34, 0, 0, 0, 6, 1, 3, 0, 100, 0, 1}), reply));
  EXPECT_EQ(reply, bytes({0x12, 0x34, 0, 0, 0, 5, 1, 3, 2, 0x55, 0x6C}));
  reply.clear();
  ASSERT_TRUE(session.feed(bytes({0x12, 0x35, 0, 0, 0, 6, 1, 3, 0, 103, 0, 2}), reply));
  EXPECT_EQ(reply, bytes({0x12, 0x35, 0, 0, 0, 7, 1, 3, 4, 0x41, 0xA0, 0, 0}));
  reply.clear();
  ASSERT_TRUE(session.feed(bytes({0x12, 0x36, 0, 0, 0, 6, 1, 3, 0, 99, 0, 1}), reply));
  EXPECT_EQ(reply, bytes({0x12, 0x36, 0, 0, 0, 3, 1, 0x83, 2}));
}

TEST_F(ModbusSessionTest, StoresAndReturnsSetPoint) {
  ASSERT_TRUE(write("set_point", -40.25));
  EXPECT_EQ(laboratory.set_point().value, -40.25);
  EXPECT_EQ(*read("set_point"), encode(*map.find("set_point"), -40.25));
}

TEST_F(ModbusSessionTest, SwitchesControllerOnAndOff) {
  ASSERT_TRUE(write("control_mode", 1));
  EXPECT_TRUE(laboratory.is_on());
  ASSERT_TRUE(
      ask({9, map.link.modbus.unit, drivers::ModbusFunction::write_single, map.find("control_mode")->address, 1, {0}}));
  EXPECT_FALSE(laboratory.is_on());
  expect_exception(write("control_mode", 3), "3");
}

TEST_F(ModbusSessionTest, ReadsSameRegistersByFunctionsThreeAndFour) {
  const auto address = map.find("set_point")->address;
  EXPECT_EQ(*ask({1, map.link.modbus.unit, drivers::ModbusFunction::read_input, address, 2, {}}), *read("set_point"));
}

TEST_F(ModbusSessionTest, RefusesSetPointOutsidePlantRange) {
  expect_exception(write("set_point", 200), "3");
  EXPECT_EQ(laboratory.set_point().value, 20);
}

TEST_F(ModbusSessionTest, RefusesToWriteReadOnlyRegister) { expect_exception(write("air_temperature", 20), "2"); }

TEST_F(ModbusSessionTest, RefusesHalfOfSetPoint) {
  expect_exception(
      ask({1, map.link.modbus.unit, drivers::ModbusFunction::write_single, map.find("set_point")->address, 1, {0}}),
      "2");
}

TEST_F(ModbusSessionTest, WritesAllOrNothing) {
  const auto address = map.find("set_point")->address;
  auto words = encode(*map.find("set_point"), 30);
  words.push_back(1);  // control_mode
  words.push_back(0);  // output, read-only
  expect_exception(ask({1, map.link.modbus.unit, drivers::ModbusFunction::write_multiple, address, 4, words}), "2");
  EXPECT_EQ(laboratory.set_point().value, 20);
  EXPECT_FALSE(laboratory.is_on());
}

TEST_F(ModbusSessionTest, RefusesUnknownRegisters) {
  expect_exception(ask({1, map.link.modbus.unit, drivers::ModbusFunction::read_holding, 5000, 1, {}}), "2");
  expect_exception(ask({1, map.link.modbus.unit, drivers::ModbusFunction::read_holding, 107, 2, {}}), "2");
}

TEST_F(ModbusSessionTest, RefusesCountOfZero) {
  expect_exception(ask({1, map.link.modbus.unit, drivers::ModbusFunction::read_holding, 101, 0, {}}), "3");
}

TEST_F(ModbusSessionTest, IsSilentForAnotherUnit) {
  std::vector<std::byte> reply;
  EXPECT_TRUE(session.feed(drivers::encode_request({1, 17, drivers::ModbusFunction::read_holding, 101, 2, {}}), reply));
  EXPECT_TRUE(reply.empty());
}

TEST_F(ModbusSessionTest, DropsClientThatViolatesProtocol) {
  std::vector<std::byte> reply;
  EXPECT_FALSE(session.feed(std::as_bytes(std::span(std::string_view("GET / HTTP/1.1"))), reply));
}

TEST_F(ModbusSessionTest, AcceptsFramesInAnyPieces) {
  auto bytes = drivers::encode_request({1, map.link.modbus.unit, drivers::ModbusFunction::read_holding, 103, 2, {}});
  const auto second =
      drivers::encode_request({2, map.link.modbus.unit, drivers::ModbusFunction::read_holding, 101, 2, {}});
  bytes.insert(bytes.end(), second.begin(), second.end());
  std::vector<std::byte> at_once;
  ASSERT_TRUE(session.feed(bytes, at_once));
  std::vector<std::byte> in_pieces;
  for (const auto byte : bytes) ASSERT_TRUE(session.feed(std::span(&byte, 1), in_pieces));
  EXPECT_EQ(at_once, in_pieces);
  EXPECT_EQ(at_once.size(), 26U);
}

TEST(ChamberRegisters, ServesEveryItemOfEveryShippedMap) {
  std::size_t items = 0;
  for (const auto& name : shipped_chambers()) {
    VirtualLaboratory laboratory(laboratory_of_rig("virtual"), {});
    laboratory.step();
    const auto map = chamber_map(name);
    const ChamberRegisters registers(map, laboratory);
    for (const auto& item : map.items) {
      if (!item.readable) continue;
      Words words;
      const auto function = item.read_function.value_or(drivers::ReadFunction::holding_registers);
      EXPECT_TRUE(registers.read(function, item.address, word_count(item), words)) << name << " " << item.name;
      EXPECT_EQ(words.size(), word_count(item));
      ++items;
    }
  }
  EXPECT_GT(items, 100u);
}

TEST(ChamberRegisters, ReadsGapsInBlockAsZero) {
  auto map = chamber_map("virtual");
  for (auto& item : map.items) {
    if (item.name == "set_point") item.address = 110;
  }
  VirtualLaboratory laboratory(laboratory_of_rig("virtual"), {});
  Words words;
  EXPECT_TRUE(ChamberRegisters(map, laboratory).read(drivers::ReadFunction::holding_registers, 100, 12, words));
  EXPECT_EQ(words[9], 0);
  EXPECT_EQ(words[10], 0x41A0);
  map.one_block = false;
  EXPECT_FALSE(ChamberRegisters(map, laboratory).read(drivers::ReadFunction::holding_registers, 100, 12, words));
}

/// Reads `count` registers of a unit on one of its links.
Result<Words> read_on(ChamberRegisters& registers, drivers::LinkKind kind, std::uint16_t address, std::uint16_t count) {
  const drivers::ModbusRequest request{1, registers.unit(), drivers::ModbusFunction::read_holding, address, count, {}};
  std::vector<std::byte> reply;
  if (kind == drivers::LinkKind::tcp) {
    EXPECT_TRUE(ModbusSession(registers).feed(encode_request(request), reply));
    return decode_reply(request, reply);
  }
  EXPECT_TRUE(ModbusRtuSession(registers, kind).feed(encode_rtu_request(request), reply));
  return decode_rtu_answer(request, reply).and_then(drivers::words_of);
}

TEST(LinkAddresses, MatchMapOfEachLink) {
  const auto map = chamber_map("watlow_f4t");
  const auto celsius = static_cast<std::uint16_t>(map.find("communication_unit")->codes.at("celsius").front());
  for (const auto in_use : {drivers::LinkKind::tcp, drivers::LinkKind::rtu}) {
    VirtualLaboratory laboratory(laboratory_of_rig("virtual"), {});
    ChamberRegisters registers(select_link(map, in_use).value(), laboratory);
    EXPECT_EQ(read_on(registers, drivers::LinkKind::tcp, 6730, 1).value(), Words{celsius});
    EXPECT_FALSE(read_on(registers, drivers::LinkKind::tcp, 14080, 1));
    for (const auto rtu : {drivers::LinkKind::rtu, drivers::LinkKind::rtu_over_tcp}) {
      EXPECT_EQ(read_on(registers, rtu, 14080, 1).value(), Words{celsius});
      EXPECT_FALSE(read_on(registers, rtu, 6730, 1));
      EXPECT_EQ(read_on(registers, rtu, 2782, 2).value(), read_on(registers, drivers::LinkKind::tcp, 2782, 2).value());
      EXPECT_FALSE(read_on(registers, rtu, 65535, 2)) << "addresses do not wrap around to 0";
    }
  }
}

/// An item of several registers has another address on this link. It is read together with adjacent registers.
TEST(LinkAddresses, ReadAndWriteMovedItem) {
  auto map = chamber_map("virtual");
  drivers::MapLink rtu = map.links.front();
  rtu.kind = drivers::LinkKind::rtu;
  rtu.modbus.unit = 9;
  map.links.push_back(rtu);
  for (auto& item : map.items)
    if (item.name == "set_point") item.rtu_address = 500;
  VirtualLaboratory laboratory(laboratory_of_rig("virtual"), {});
  ChamberRegisters registers(map, laboratory);
  const auto address = map.find("set_point")->address;
  const auto words = encode(*map.find("set_point"), 30);
  const auto write = [&](std::uint16_t at) {
    const drivers::ModbusRequest request{1, 9, drivers::ModbusFunction::write_multiple, at, 2, words};
    std::vector<std::byte> reply;
    EXPECT_TRUE(ModbusRtuSession(registers, drivers::LinkKind::rtu).feed(encode_rtu_request(request), reply));
    return decode_rtu_answer(request, reply).and_then(drivers::words_of).has_value();
  };
  EXPECT_FALSE(write(address));
  EXPECT_TRUE(write(500));
  EXPECT_EQ(laboratory.set_point(), Celsius{30});
  EXPECT_EQ(read_on(registers, drivers::LinkKind::tcp, address, 2).value(), words);
}

}  // namespace
}  // namespace gyrotherm::simulator
