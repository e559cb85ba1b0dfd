// SPDX-License-Identifier: Apache-2.0
// Tests of the Modbus TCP client against a unit with answers that are delayed, duplicated, truncated, corrupted in any
// field that identifies their request, mixed with frames of other units, or lost, also across connections as in
// gateways. Invariant: every accepted answer is the answer to the latest request.
//
// These faults are not generated, because no client can detect them: wrong bits in the words themselves, which only
// TCP's checksum protects, and a truncated answer that is completed by later bytes of the same connection.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "drivers/line/modbus_frame.hpp"
#include "drivers/line/modbus_lines.hpp"
#include "tests/drivers/line/faults.hpp"
#include "tests/drivers/line/words.hpp"
#include "tests/support/simulated_line.hpp"

namespace gyrotherm::drivers {
namespace {

using std::chrono::milliseconds;

constexpr Duration kTimeout = milliseconds(200);

/// Splits an in-memory line into frames as libmodbus does: by function and byte count, not by the length in the header.
class MemoryConnection final : public FrameConnection {
 public:
  MemoryConnection(VirtualClock& clock, std::function<void(tests::SimulatedLine&, std::span<const std::byte>)> unit)
      : clock_(clock), unit_(std::move(unit)) {}

  Bytes gateway_keeps;  ///< sent on the next connection
  int opened = 0;

  bool is_open() const override { return line_ != nullptr; }
  Result<void> open(Duration) override {
    line_ = std::make_unique<tests::SimulatedLine>(clock_);
    ++opened;
    if (!gateway_keeps.empty()) line_->arrive(milliseconds(2), std::exchange(gateway_keeps, {}));
    return {};
  }
  void close() override { line_.reset(); }
  Result<void> send(std::span<const std::byte> frame) override {
    unit_(*line_, frame);
    return {};
  }
  Result<std::size_t> receive(std::span<std::byte> frame, Duration within) override {
    const auto until = clock_.now().since_start + within;
    std::size_t size = 0;
    for (std::size_t wanted = 8; size < wanted;) {
      const auto more = line_->read(frame.subspan(size, wanted - size), until - clock_.now().since_start);
      if (!more) return more;
      size += *more;
      if (size == 8) wanted += byte_at(frame, 7) == 6 || byte_at(frame, 7) == 16 ? 4 : 1;
      if (size == 9 && byte_at(frame, 7) <= 4) wanted += byte_at(frame, 8);
      if (wanted > 260) return failure(FaultKind::corrupted, "", "too many data");
    }
    return size;
  }
  bool is_silent_for(Duration time) override {
    std::array<std::byte, 1> any;
    if (line_) return !line_->read(any, time);
    clock_.advance(time);
    return true;
  }

 private:
  VirtualClock& clock_;
  std::function<void(tests::SimulatedLine&, std::span<const std::byte>)> unit_;
  std::unique_ptr<tests::SimulatedLine> line_;
};

class FaultyClient {
 public:
  /// Selects whether the unit returns transaction numbers; otherwise all its replies have transaction 0.
  explicit FaultyClient(unsigned seed, bool is_numbered = true) : chance_(seed), is_numbered_(is_numbered) {
    auto made = std::make_unique<MemoryConnection>(clock_, [this](auto& line, auto frame) { hear(line, frame); });
    connection_ = made.get();
    ModbusLink link;
    link.timeout = kTimeout;
    link.returns_other_transaction = !is_numbered;
    registers_ = make_guarded_registers(make_modbus_tcp(std::move(made), "unit", link, &clock_), link, &clock_);
  }

  Account run(long transactions) {
    Account account;
    for (long i = 0; i < transactions; ++i) {
      const bool good = chance_.one_in(4) ? write_once(account) : read_once(account);
      ++(good ? account.good : account.failed);
      if (!good) clock_.advance(milliseconds(10'000));
    }
    account.faults = faults_;
    return account;
  }
  [[nodiscard]] int connections() const { return connection_->opened; }

 private:
  void hear(tests::SimulatedLine& line, std::span<const std::byte> frame) {
    const auto request = decode_request(frame);
    ASSERT_TRUE(request) << text(request.error());
    ++requests_;
    if (!is_read(request->function)) stored_ = *request;
    auto reply = encode_reply(
        *request, is_read(request->function) ? telltale_words(request->address, request->count, requests_) : Words{});
    if (!is_numbered_) reply[0] = reply[1] = std::byte{0};
    is_numbered_ ? misbehave(line, *request, frame, std::move(reply)) : misbehave_unnumbered(line, std::move(reply));
    last_ = *request;
  }

  void misbehave(tests::SimulatedLine& line, const ModbusRequest& request, std::span<const std::byte> asked,
                 Bytes reply) {
    ++faults_;
    const auto at = chance_.between(milliseconds(1), milliseconds(60));
    switch (chance_.below(12)) {
      case 0: return;
      case 1: return line.arrive(chance_.between(kTimeout, 4 * kTimeout), std::move(reply));
      case 2: line.arrive(at + chance_.between({}, milliseconds(300)), reply); return line.arrive(at, std::move(reply));
      case 3: reply.resize(chance_.below(reply.size())); return line.arrive_last(at, std::move(reply));
      case 4: falsify(request, reply); return line.arrive(at, std::move(reply));
      case 5: line.arrive(chance_.between({}, at), older()); return line.arrive(at, std::move(reply));
      case 6: return line.arrive(at, older());
      case 7: connection_->gateway_keeps = std::move(reply); return;
      case 8: return line.arrive(at, encode_exception(asked, static_cast<std::uint8_t>(1 + chance_.below(11))));
      default: --faults_; return line.arrive(at, std::move(reply));
    }
  }

  /// Generates only faults that can be distinguished by time: no matching frame arrives while another answer is
  /// expected.
  void misbehave_unnumbered(tests::SimulatedLine& line, Bytes reply) {
    ++faults_;
    const auto at = chance_.between(milliseconds(1), milliseconds(60));
    switch (chance_.below(8)) {
      case 0: return;
      case 1: return line.arrive(chance_.between(kTimeout, 4 * kTimeout), std::move(reply));
      case 2: line.arrive(at, reply); return line.arrive(at, std::move(reply));  // twice at once
      case 3: reply.resize(chance_.below(reply.size())); return line.arrive_last(at, std::move(reply));
      case 4: connection_->gateway_keeps = std::move(reply); return;
      default: --faults_; return line.arrive(at, std::move(reply));
    }
  }

  /// Corrupts the header, the function or the byte count, and for a write also the address, count or value.
  void falsify(const ModbusRequest& request, Bytes& reply) {
    const auto end = is_read(request.function) ? std::size_t{9} : reply.size();
    for (auto flips = 1 + chance_.below(3); flips > 0; --flips)
      reply[chance_.below(end)] ^= static_cast<std::byte>(1 + chance_.below(255));
  }

  /// Returns an answer to the previous request, of any form.
  [[nodiscard]] Bytes older() {
    auto request = last_;
    if (request.function == ModbusFunction{}) request.function = ModbusFunction::read_holding, request.count = 1;
    return encode_reply(request,
                        telltale_words(request.address, is_read(request.function) ? request.count : 0, requests_));
  }

  bool read_once(Account& account) {
    const auto address = static_cast<std::uint16_t>(chance_.below(400));
    const auto count = static_cast<std::uint16_t>(1 + chance_.below(chance_.one_in(2) ? 2 : 20));
    const auto words = registers_->read(ReadFunction::holding_registers, address, count);
    if (words && *words != telltale_words(address, count, requests_)) ++account.wrong;
    return words.has_value();
  }

  bool write_once(Account& account) {
    const auto address = static_cast<std::uint16_t>(chance_.below(400));
    Words words(1 + chance_.below(3));
    for (auto& word : words) word = static_cast<std::uint16_t>(chance_.below(0x10000));
    const auto done = registers_->write(WriteFunction::registers, address, words);
    if (done && (stored_.address != address || stored_.words != words)) ++account.wrong;
    return done.has_value();
  }

  Chance chance_;
  bool is_numbered_;
  VirtualClock clock_;
  MemoryConnection* connection_{};
  std::unique_ptr<Registers> registers_;
  std::uint32_t requests_ = 0;
  ModbusRequest stored_, last_;
  long faults_ = 0;
};

TEST(ModbusTcpFaults, NeverReturnWrongValue) {
  constexpr unsigned kSeed = 20151202;
  FaultyClient client(kSeed);
  const auto account = client.run(kFaultedTransactions);
  EXPECT_EQ(account.wrong, 0) << "seed " << kSeed;
  EXPECT_GT(account.good, kFaultedTransactions / 2);
  EXPECT_GT(account.failed, kFaultedTransactions / 100);
  EXPECT_GT(client.connections(), kFaultedTransactions / 10);
  fmt::print("{} good, {} failed, {} wrong, {} faults made\n", account.good, account.failed, account.wrong,
             account.faults);
}

TEST(ModbusTcpFaults, NeverReturnWrongValueWithoutTransaction) {
  constexpr unsigned kSeed = 20261127;
  FaultyClient client(kSeed, false);
  const auto account = client.run(kFaultedTransactions);
  EXPECT_EQ(account.wrong, 0) << "seed " << kSeed;
  EXPECT_GT(account.good, kFaultedTransactions / 2);
  EXPECT_GT(account.failed, kFaultedTransactions / 100);
  EXPECT_GT(client.connections(), kFaultedTransactions / 10);
  fmt::print("{} good, {} failed, {} wrong, {} faults made\n", account.good, account.failed, account.wrong,
             account.faults);
}

}  // namespace
}  // namespace gyrotherm::drivers
