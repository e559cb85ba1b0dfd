// SPDX-License-Identifier: Apache-2.0
// Tests of this client against a third-party server, on sockets, on pseudo-terminals, and with a relay that makes
// faults. Every accepted word is compared with the server's register.
#include <arpa/inet.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <csignal>

#include "core/deadline.hpp"
#include "drivers/chamber/register_item.hpp"
#include "drivers/line/modbus.hpp"
#include "drivers/line/modbus_frame.hpp"
#include "tests/drivers/line/pseudo_terminal.hpp"
#include "tests/drivers/line/words.hpp"
#include "tests/drivers/peers/faulty_relay.hpp"
#include "tests/drivers/peers/python_server.hpp"

namespace gyrotherm::drivers {
namespace {

using std::chrono::milliseconds;
constexpr auto kHolding = ReadFunction::holding_registers;
constexpr long kTransactions = 10'000;

Line tcp_line(std::uint16_t port) { return TcpLine{"127.0.0.1", port}; }

ModbusLink link_of(ModbusLink::Framing framing, Duration timeout) {
  ModbusLink link;
  link.framing = framing;
  link.timeout = timeout;
  link.serial = {115200, 8, SerialParity::none, 1};
  return link;
}

/// Requires operations that every server supports.
void expect_agreement(Registers& registers) {
  for (const std::uint16_t count : Words{1, 2, 60, 125}) {
    const auto words = registers.read(kHolding, 100, count);
    ASSERT_TRUE(words) << text(words.error());
    for (std::uint16_t i = 0; i < count; ++i) EXPECT_EQ((*words)[i], pymodbus_register(100u + i));
  }
  EXPECT_EQ(registers.read(ReadFunction::input_registers, 7, 1).value(), Words{pymodbus_register(7)});
  EXPECT_EQ(registers.read(ReadFunction::coils, 0, 11).value(), (Words{1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0}));
  EXPECT_EQ(registers.read(ReadFunction::discrete_inputs, 2, 3).value(), (Words{0, 1, 0}));
  EXPECT_TRUE(registers.write(WriteFunction::one_register, 3000, Words{0xFE70}));
  EXPECT_TRUE(registers.write(WriteFunction::registers, 3001, Words{0xC221, 7}));
  EXPECT_EQ(registers.read(kHolding, 3000, 3).value(), (Words{0xFE70, 0xC221, 7}));
  EXPECT_TRUE(registers.write(WriteFunction::coil, 1, Words{1}));
  EXPECT_EQ(registers.read(ReadFunction::coils, 0, 2).value(), (Words{1, 1}));
}

void expect_four_word_orders(Registers& registers) {
  std::uint16_t address = 2000;
  for (const auto order : {WordOrder::abcd, WordOrder::cdab, WordOrder::badc, WordOrder::dcba}) {
    RegisterItem item;
    item.type = RegisterType::f32;
    item.order = order;
    const auto words = registers.read(kHolding, address, 2);
    ASSERT_TRUE(words);
    EXPECT_EQ(decode(item, *words).value(), -40.25) << address;
    address += 2;
  }
}

void expect_exceptions(Registers& registers) {
  const char* meanings[] = {"illegal function", "illegal data address", "illegal data value", "server device failure"};
  for (std::uint16_t code = 1; code <= 4; ++code) {
    const auto refused = registers.read(kHolding, static_cast<std::uint16_t>(60000 + code), 1);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().what, fmt::format("exception {}, {}", code, meanings[code - 1]));
  }
  EXPECT_EQ(registers.read(kHolding, 59999, 2).error().what, "exception 2, illegal data address");
}

/// Calls until the line is not in its rest period.
template <class Call>
auto rested(const Call& call) {
  while (true) {
    auto result = call();
    if (result || result.error().what.find("; next try in ") == std::string::npos) return result;
    (void)wait_until_ready(kNoDescriptor, POLLIN, Deadline(milliseconds(20)));
  }
}

/// Reads and writes at random. Every accepted value must be correct.
void expect_no_wrong_value(Registers& registers, const FaultyRelay& relay, unsigned seed) {
  Chance chance(seed);
  Account account;
  for (long i = 0; i < kTransactions; ++i) {
    if (chance.one_in(5)) {
      const auto address = static_cast<std::uint16_t>(3000 + chance.below(900));
      const Words words{static_cast<std::uint16_t>(chance.below(65536)), static_cast<std::uint16_t>(i)};
      const auto back = rested([&] { return registers.write(WriteFunction::registers, address, words); }).and_then([&] {
        return rested([&] { return registers.read(kHolding, address, 2); });
      });
      ++(back ? account.good : account.failed);
      account.wrong += back && *back != words;
      continue;
    }
    const auto address = static_cast<std::uint16_t>(4000 + chance.below(1000));
    const auto count = static_cast<std::uint16_t>(1 + chance.below(8));
    const auto words = rested([&] { return registers.read(kHolding, address, count); });
    ++(words ? account.good : account.failed);
    for (std::size_t k = 0; words && k < words->size(); ++k)
      account.wrong += (*words)[k] != pymodbus_register(static_cast<unsigned>(address + k));
  }
  EXPECT_EQ(account.wrong, 0) << "seed " << seed;
  EXPECT_GT(account.good, kTransactions / 2);
  EXPECT_GT(relay.faults(), kTransactions / 10);
  fmt::print("{} good, {} failed, {} wrong, {} faults made\n", account.good, account.failed, account.wrong,
             relay.faults());
}

Descriptor connected_to(std::uint16_t port) {
  Descriptor line(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  sockaddr_in peer{};
  peer.sin_family = AF_INET;
  peer.sin_port = htons(port);
  peer.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (connect(line.number(), reinterpret_cast<const sockaddr*>(&peer), sizeof peer) != 0) line.close();
  return line;
}

/// Listens on a free port of the loopback interface.
std::pair<Descriptor, std::uint16_t> listener() {
  Descriptor line(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  sockaddr_in here{};
  here.sin_family = AF_INET;
  here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof here;
  if (bind(line.number(), reinterpret_cast<sockaddr*>(&here), size) != 0 || listen(line.number(), 4) != 0 ||
      getsockname(line.number(), reinterpret_cast<sockaddr*>(&here), &size) != 0)
    throw std::runtime_error("cannot listen on loopback");
  return {std::move(line), ntohs(here.sin_port)};
}

/// Corrupts every field that identifies the request, but not the words, which Modbus TCP does not protect.
const RelayFraming kTcpFraming{
    .size = [](auto, std::span<const std::byte> bytes) -> std::optional<std::size_t> {
      return bytes.size() < 6 ? std::nullopt : std::optional<std::size_t>(6u + word_at(bytes, 4));
    },
    .falsify = [](Bytes& reply,
                  Chance& chance) { reply[chance.below(9)] ^= static_cast<std::byte>(1 + chance.below(255)); },
    .foreign =
        [](Bytes reply) {
          reply[0] ^= std::byte{0x40};
          return reply;
        },
};

const RelayFraming kRtuFraming{
    .size = [](std::span<const std::byte> asked, std::span<const std::byte> bytes) -> std::optional<std::size_t> {
      const auto request = decode_rtu_request(asked);
      if (!request) return std::nullopt;
      const auto size = rtu_answer_size(*request, bytes);
      return size ? *size : std::nullopt;
    },
    .falsify =
        [](Bytes& reply, Chance& chance) {
          reply[chance.below(reply.size())] ^= static_cast<std::byte>(1 << chance.below(8));
        },
    .foreign =
        [](Bytes reply) {
          reply.resize(reply.size() - 2);
          reply[0] = std::byte{9};
          append_rtu_crc(reply);
          return reply;
        },
};

class Pymodbus : public testing::Test {
 protected:
  void SetUp() override {
    if (!pymodbus_is_installed()) GTEST_SKIP() << "python3-pymodbus is not installed";
    // The relay writes to connections that the client has closed.
    std::signal(SIGPIPE, SIG_IGN);
  }
};

TEST_F(Pymodbus, AgreesOnTcp) {
  const PythonServer server("tcp");
  const auto registers = make_modbus(tcp_line(server.port()), link_of(ModbusLink::Framing::tcp, milliseconds(500)));
  expect_agreement(*registers);
  expect_four_word_orders(*registers);
  expect_exceptions(*registers);
}

TEST_F(Pymodbus, AgreesOnRtu) {
  const PseudoTerminal ours, theirs;
  const Descriptor keep_ours(open(ours.device().c_str(), O_RDWR | O_NOCTTY));
  const Descriptor keep_theirs(open(theirs.device().c_str(), O_RDWR | O_NOCTTY));
  const PythonServer server("rtu", theirs.device());
  const FaultyRelay wire([&] { return Descriptor(dup(ours.master())); },
                         [&] { return Descriptor(dup(theirs.master())); }, kRtuFraming, milliseconds(500), 0, 0);
  const auto registers =
      make_modbus(SerialLine{ours.device(), {}}, link_of(ModbusLink::Framing::rtu, milliseconds(500)));
  expect_agreement(*registers);
  expect_four_word_orders(*registers);
  expect_exceptions(*registers);
}

TEST_F(Pymodbus, NeverReturnsWrongValueOnTcp) {
  constexpr Duration kTimeout = milliseconds(50);
  const PythonServer server("tcp");
  const auto listening = listener();
  const auto port = listening.second;
  const FaultyRelay relay(
      [&] {
        return wait_until_ready(listening.first.number(), POLLIN, Deadline(milliseconds(20)))
                   ? Descriptor(accept(listening.first.number(), nullptr, nullptr))
                   : Descriptor();
      },
      [&] { return connected_to(server.port()); }, kTcpFraming, kTimeout, 7);
  const auto registers = make_modbus(tcp_line(port), link_of(ModbusLink::Framing::tcp, kTimeout));
  expect_no_wrong_value(*registers, relay, 8);
}

TEST_F(Pymodbus, NeverReturnsWrongValueOnRtu) {
  constexpr Duration kTimeout = milliseconds(50);
  const PseudoTerminal ours, theirs;
  const Descriptor keep_ours(open(ours.device().c_str(), O_RDWR | O_NOCTTY));
  const Descriptor keep_theirs(open(theirs.device().c_str(), O_RDWR | O_NOCTTY));
  const PythonServer server("rtu", theirs.device());
  const FaultyRelay relay([&] { return Descriptor(dup(ours.master())); },
                          [&] { return Descriptor(dup(theirs.master())); }, kRtuFraming, kTimeout, 9);
  const auto registers = make_modbus(SerialLine{ours.device(), {}}, link_of(ModbusLink::Framing::rtu, kTimeout));
  expect_no_wrong_value(*registers, relay, 10);
}

}  // namespace
}  // namespace gyrotherm::drivers
