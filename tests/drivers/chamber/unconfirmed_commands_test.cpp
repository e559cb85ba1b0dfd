// SPDX-License-Identifier: Apache-2.0
/// Commands of the safe state to a chamber whose answers cannot be understood.
#include <gtest/gtest.h>

#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "drivers/chamber/modbus_chamber.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/chamber/text_registers.hpp"
#include "drivers/line/modbus.hpp"
#include "drivers/line/modbus_frame.hpp"
#include "drivers/line/modbus_lines.hpp"
#include "drivers/line/pauses.hpp"
#include "tests/support/fakes.hpp"

namespace gyrotherm::drivers {
namespace {

constexpr const char* kAddressedUnit = R"(schema = "gyrotherm-text/1"
kind = "chamber"
name = "A 1"
vendor = "Maker"
source = "a test"
state = [{ activity = "running", item = "mode", is = "constant" }, { activity = "off", item = "mode", is = "standby" }]
[link]
question_end = "\r"
answer_end = "\r"
prefix = "@{address:d2}"
answers_have_prefix = true
address = 3
timeout = "200 ms"
[link.tcp]
port = 10001
[identity]
ask = "ID?"
answer = "ID={value:s}"
pattern = "MAKER A-1"
[[item]]
name = "air_temperature"
unit = "°C"
ask = "PV?"
answer = "PV={value:f.1}"
[[item]]
name = "set_point"
unit = "°C"
ask = "SP?"
answer = "SP={value:f.1}"
tell = "SP={value:f.1}"
acknowledged = "ACK"
[[item]]
name = "mode"
ask = "MD?"
answer = "MD={value:d}"
tell = "MD={value:d}"
acknowledged = "ACK"
codes = { standby = 0, constant = 1 }
[[item]]
name = "remote"
tell = "RM={value:d}"
acknowledged = "ACK"
codes = { off = 0, on = 1 }
[control]
commanded = "mode"
on = "constant"
off = "standby"
[sequence]
prepare = [{ write = "remote", code = "on" }]
stop = [{ write = "mode", code = "standby" }]
)";

/// A unit at address 3 that obeys every command. `form` makes the line of an answer.
class ObedientUnit final : public ByteStream {
 public:
  std::function<std::string(const std::string& answer)> form = [](const std::string& answer) { return "@03" + answer; };
  std::vector<std::string> commands;
  std::string identity = "MAKER A-1 #7";

  Result<std::size_t> read(std::span<std::byte> buffer, Duration) override {
    if (coming_.empty()) return failure(FaultKind::timeout, "unit", "no data");
    const auto bytes = coming_.front();
    coming_.pop_front();
    std::ranges::copy(std::as_bytes(std::span(bytes)), buffer.begin());
    return bytes.size();
  }
  Result<void> write(std::span<const std::byte> bytes, Duration) override {
    const std::string line(reinterpret_cast<const char*>(bytes.data()), bytes.size() - 1);
    if (!line.starts_with("@03")) return {};
    if (const auto answer = form(respond(line.substr(3))); !answer.empty()) coming_.push_back(answer + "\r");
    return {};
  }

 private:
  std::string respond(const std::string& line) {
    if (line == "ID?") return "ID=" + identity;
    if (line == "PV?") return "PV=23.5";
    if (line == "SP?") return "SP=" + set_point_;
    if (line == "MD?") return "MD=1";
    commands.push_back(line);
    if (line.starts_with("SP=")) set_point_ = line.substr(3);
    return "ACK";
  }
  std::deque<std::string> coming_;
  std::string set_point_ = "80.0";
};

struct TextBench {
  TextBench() {
    auto stream = std::make_unique<ObedientUnit>();
    unit = stream.get();
    const auto map = parse_register_map(kAddressedUnit, "test").value();
    chamber = make_modbus_chamber(map, make_text_registers(map, std::move(stream), "test"), make_virtual_pauses(), {});
  }
  ObedientUnit* unit{};
  std::unique_ptr<Chamber> chamber;
};

const std::vector<std::string> kSafeCommands{"RM=1", "SP=20.0", "MD=0"};

TEST(UnconfirmedCommands, ReachTextUnitWhoseAnswersAreWrong) {
  const std::vector<std::function<std::string(const std::string&)>> wrong{
      [](const std::string& answer) { return "@04" + answer; }, [](const std::string&) { return "\x81\x7f#"; },
      [](const std::string&) { return ""; }, [](const std::string& answer) { return answer + "@03"; }};
  for (const auto& form : wrong) {
    TextBench bench;
    ASSERT_TRUE(bench.chamber->identify());
    ASSERT_TRUE(bench.chamber->read());
    bench.unit->form = form;
    for (int i = 0; i < 6; ++i) EXPECT_FALSE(bench.chamber->read());
    EXPECT_FALSE(bench.chamber->send_set_point_immediately({20})) << "no answer confirms it";
    for (int i = 0; i < 3; ++i) {
      bench.unit->commands.clear();
      EXPECT_TRUE(bench.chamber->send_safe_state_unconfirmed({20}, true));
      EXPECT_EQ(bench.unit->commands, kSafeCommands);
    }
    bench.unit->commands.clear();
    EXPECT_TRUE(bench.chamber->send_safe_state_unconfirmed({20}, false));
    EXPECT_EQ(bench.unit->commands, (std::vector<std::string>{"RM=1", "SP=20.0"}));
    bench.unit->form = [](const std::string& answer) { return "@03" + answer; };
    bench.chamber->end_rest();
    EXPECT_TRUE(bench.chamber->send_set_point_immediately({21})) << "its answers can be understood again";
  }
}

TEST(UnconfirmedCommands, DoNotReachOtherUnitThatHasAnswered) {
  TextBench bench;
  ASSERT_TRUE(bench.chamber->identify());
  bench.unit->identity = "OTHER B-2 #9";
  EXPECT_EQ(bench.chamber->recognise().error().kind, FaultKind::mismatch);
  bench.unit->form = [](const std::string&) { return ""; };
  EXPECT_FALSE(bench.chamber->send_safe_state_unconfirmed({20}, true));
  EXPECT_TRUE(bench.unit->commands.empty());
}

TEST(UnconfirmedCommands, QuoteLineThatIsNoAnswer) {
  TextBench bench;
  ASSERT_TRUE(bench.chamber->identify());
  bench.unit->form = [](const std::string& answer) { return "@04" + answer; };
  std::string faults;
  for (int i = 0; i < 4; ++i) faults += text(bench.chamber->read().error()) + "\n";
  EXPECT_NE(faults.find("; received \"@04ID=MAKER A-1 #7\""), std::string::npos) << faults;
}

/// An RTU line on which every request is noted and answered with a wrong checksum.
class WrongSums final : public ByteStream {
 public:
  std::vector<std::vector<std::byte>> requests;

  Result<std::size_t> read(std::span<std::byte> buffer, Duration) override {
    if (coming_.empty()) return failure(FaultKind::timeout, "line", "no data");
    const auto size = coming_.size();
    std::ranges::copy(coming_, buffer.begin());
    coming_.clear();
    return size;
  }
  Result<void> write(std::span<const std::byte> bytes, Duration) override {
    requests.emplace_back(bytes.begin(), bytes.end());
    coming_ = requests.back();
    coming_.back() ^= std::byte{0x55};
    return {};
  }

 private:
  std::vector<std::byte> coming_;
};

TEST(UnconfirmedCommands, ReachModbusUnitWhoseChecksumsAreWrong) {
  for (const bool loop_back : {false, true}) {
    ModbusLink link{.framing = ModbusLink::Framing::rtu, .unit = 5, .loop_back = loop_back};
    auto stream = std::make_unique<WrongSums>();
    auto& line = *stream;
    const auto registers = make_guarded_registers(make_modbus_rtu(std::move(stream), "test", link, nullptr), link);
    const std::vector<std::uint16_t> words{200};
    for (int i = 0; i < 4; ++i) EXPECT_FALSE(registers->write(WriteFunction::one_register, 60, words));
    const auto before = line.requests.size();
    for (std::size_t i = 1; i < 4; ++i) {
      EXPECT_TRUE(registers->write_unconfirmed(WriteFunction::one_register, 60, words));
      ASSERT_EQ(line.requests.size(), before + i) << "rest periods are ignored";
    }
    ModbusRequest sent{.unit = 5, .function = ModbusFunction::write_single, .address = 60, .count = 1, .words = words};
    EXPECT_EQ(line.requests.back(), encode_rtu_request(sent));
  }
}

}  // namespace
}  // namespace gyrotherm::drivers
