// SPDX-License-Identifier: Apache-2.0
/// Compares requests and replies byte by byte: the requests of the client for a unit of analogue inputs with the
/// shipped map, and the replies of the virtual unit.
#include <gtest/gtest.h>

#include <algorithm>

#include "drivers/analogue/modbus_analogue_input.hpp"
#include "simulator/analogue_registers.hpp"
#include "tests/simulator/chamber_on_a_line.hpp"

namespace gyrotherm::simulator {
namespace {

drivers::AnalogueMap shipped_inputs(const std::string& name) {
  const auto path = GYROTHERM_SOURCE_DIR "/profiles/analogue-inputs/" + name + ".toml";
  return drivers::parse_analogue_map(read_text_file(path).value(), path).value();
}

/// Line to an analogue input unit. Inputs 1 and 3 measure the discharge currents of two units of the shipped rig.
class InputsOnALine {
 public:
  InputsOnALine() : laboratory_(laboratory_of_rig("virtual-triad"), {}) {
    auto map = shipped_inputs("moxa_iologik_e1240");
    const std::string current = "discharge_current_ma";
    registers_.emplace(AnalogueRegisters::make(
                           {.map = map,
                            .inputs = {{.input = 0, .unit = "x", .value = current},
                                       {.input = 2, .unit = "z", .value = current, .scale = 0.125, .offset = -0.5}}},
                           laboratory_)
                           .value());
    session_ = make_modbus_session(*registers_);
    const auto& link = map.registers.link.modbus;
    auto connection = std::make_unique<SessionConnection>(clock_, [this](auto frame) { return answer(frame); });
    auto line = make_modbus_tcp(std::move(connection), "unit", link, &clock_);
    inputs = make_modbus_analogue_inputs(map, {0, 1, 2}, "analogue input 1",
                                         make_guarded_registers(std::move(line), link, &clock_),
                                         std::make_unique<ClockPauses>(clock_));
  }

  [[nodiscard]] double current_ma(std::size_t unit) const { return laboratory_.values(unit)[0].value; }

  /// Requests and replies without their transaction numbers.
  std::vector<std::string> heard, said;
  std::unique_ptr<drivers::AnalogueInputs> inputs;

 private:
  std::vector<std::byte> answer(std::span<const std::byte> frame) {
    std::vector<std::byte> reply;
    (void)session_->feed(frame, reply);
    heard.push_back(tests::format_hex(frame.subspan(2)));
    said.push_back(reply.size() < 2 ? "" : tests::format_hex(std::span(reply).subspan(2)));
    return reply;
  }

  VirtualClock clock_;
  VirtualLaboratory laboratory_;
  std::optional<AnalogueRegisters> registers_;
  std::unique_ptr<Session> session_;
};

TEST(AnalogueGoldenFrames, MatchIoLogikE1240) {
  InputsOnALine line;
  const auto readings = line.inputs->read();
  ASSERT_EQ(line.heard, (std::vector<std::string>{"00 00 00 06 01 03 00 18 00 08", "00 00 00 06 01 04 00 00 00 08",
                                                  "00 00 00 06 01 04 00 3C 00 08"}));
  EXPECT_EQ(line.said[0], "00 00 00 13 01 03 10 00 01 00 01 00 01 00 01 00 01 00 01 00 01 00 01") << "4 … 20 mA";
  EXPECT_TRUE(line.said[1].starts_with("00 00 00 13 01 04 10 ")) << line.said[1];
  EXPECT_EQ(line.said[2], "00 00 00 13 01 04 10 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00");
  // The range starts at 4 mA. A current of 1 mA and an unconnected input are both read as 4 mA.
  EXPECT_DOUBLE_EQ(readings[0].value(), 4);
  EXPECT_DOUBLE_EQ(readings[1].value(), 4);
  EXPECT_NEAR(readings[2].value() * 0.125 - 0.5, line.current_ma(2), 0.125 * 16 / 65535 / 2 + 1e-12);
  EXPECT_EQ(line.said[1].substr(21, 11), "00 00 00 00");
}

TEST(AnalogueRegisters, RefuseUnknownUnitValueOrInput) {
  VirtualLaboratory laboratory(laboratory_of_rig("virtual-triad"), {});
  const auto map = shipped_inputs("moxa_iologik_e1240");
  const auto refusal = [&](WiredInput input) {
    const auto made = AnalogueRegisters::make({.map = map, .inputs = {std::move(input)}}, laboratory);
    return made ? "" : text(made.error());
  };
  EXPECT_NE(refusal({.input = 0, .unit = "q", .value = "discharge_current_ma"}).find("\"q\" is not one of the units"),
            std::string::npos);
  EXPECT_NE(refusal({.input = 0, .unit = "x", .value = "voltage"}).find("has no value \"voltage\""), std::string::npos);
  EXPECT_NE(refusal({.input = 8, .unit = "x", .value = "discharge_current_ma"}).find("has no input 9"),
            std::string::npos);
  EXPECT_EQ(refusal({.input = 7, .unit = "x", .value = "discharge_current_ma"}), "");
}

TEST(AnalogueRegisters, AnswerOnlyTheirReadFunction) {
  VirtualLaboratory laboratory(laboratory_of_rig("virtual-triad"), {});
  auto registers = AnalogueRegisters::make({.map = shipped_inputs("moxa_iologik_e1240"), .inputs = {}}, laboratory);
  std::vector<std::uint16_t> words;
  EXPECT_TRUE(registers->read(drivers::ReadFunction::input_registers, 0, 8, words));
  EXPECT_EQ(registers->read(drivers::ReadFunction::holding_registers, 0, 8, words).error(),
            ModbusException::illegal_address);
  EXPECT_EQ(registers->read(drivers::ReadFunction::input_registers, 7, 2, words).error(),
            ModbusException::illegal_address);
  EXPECT_EQ(registers->read(drivers::ReadFunction::input_registers, 0, 0, words).error(),
            ModbusException::illegal_value);
  EXPECT_EQ(words.size(), 8u) << "a refused read adds no registers";
  EXPECT_EQ(registers->write(drivers::WriteFunction::registers, 0, words).error(), ModbusException::illegal_address);
}

}  // namespace
}  // namespace gyrotherm::simulator
