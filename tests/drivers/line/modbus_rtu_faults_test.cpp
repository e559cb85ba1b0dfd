// SPDX-License-Identifier: Apache-2.0
// Tests of the RTU client against a unit with answers that are delayed, duplicated, truncated, corrupted, preceded or
// followed by frames of other units, or lost. Invariant: every accepted answer is the answer to the latest request.
//
// RTU frames do not identify their request. These faults are not generated, because no client can detect them:
// - an answer later than twice the timeout;
// - a copy of an answer that arrives after the gap between frames while an answer of the same form (unit, function,
//   size) is expected, or an answer of that form from a second unit with the same number;
// - four or more wrong bits that are not a burst of 16, and truncated answers that are completed by bytes within the
//   gap inside a frame: one in 65536 of these passes its CRC by chance;
// - the echo of a write, which equals its answer.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <map>

#include "drivers/line/modbus_frame.hpp"
#include "drivers/line/modbus_lines.hpp"
#include "tests/drivers/line/faults.hpp"
#include "tests/drivers/line/words.hpp"
#include "tests/support/simulated_line.hpp"

namespace gyrotherm::drivers {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

constexpr std::size_t kMostAskedFor = 20;
constexpr Duration kTimeout = milliseconds(200), kPieceGap = milliseconds(30);

class FaultyUnit {
 public:
  FaultyUnit(tests::SimulatedLine& line, Duration gap, unsigned seed) : line_(line), gap_(gap), chance_(seed) {}

  void hear(std::span<const std::byte> frame) {
    const auto request = decode_rtu_request(frame);
    ASSERT_TRUE(request) << text(request.error());
    ++requests_;
    if (!is_read(request->function) && request->function != ModbusFunction::loop_back)
      for (std::size_t i = 0; i < request->words.size(); ++i)
        stored_[static_cast<std::uint16_t>(request->address + i)] = request->words[i];
    auto reply = encode_rtu_reply(
        *request, is_read(request->function) ? telltale_words(request->address, request->count, requests_) : Words{});
    misbehave(*request, Bytes(frame.begin(), frame.end()), std::move(reply));
  }

  [[nodiscard]] std::uint32_t requests() const { return requests_; }
  [[nodiscard]] bool holds(std::uint16_t address, const Words& words) const {
    for (std::size_t i = 0; i < words.size(); ++i) {
      const auto found = stored_.find(static_cast<std::uint16_t>(address + i));
      if (found == stored_.end() || found->second != words[i]) return false;
    }
    return true;
  }
  [[nodiscard]] long faults() const { return faults_; }

 private:
  [[nodiscard]] Duration soon() { return chance_.between(milliseconds(1), milliseconds(60)); }

  void misbehave(const ModbusRequest& request, const Bytes& asked, Bytes reply) {
    ++faults_;
    const auto at = soon();
    switch (chance_.below(16)) {
      case 0: return;  // lost
      case 1: return line_.arrive(chance_.between(kTimeout, 2 * kTimeout - milliseconds(1)), std::move(reply));
      case 2: return twice(at, std::move(reply));
      case 3: reply.resize(chance_.below(reply.size())); return line_.arrive(at, std::move(reply));
      case 4: falsify(reply); return line_.arrive(at, std::move(reply));
      case 5: line_.arrive(chance_.between({}, at), foreign(request)); return line_.arrive(at, std::move(reply));
      case 6: line_.arrive(at + chance_.between({}, 2 * kTimeout), foreign(request)); return line_.arrive(at, reply);
      case 7: return in_pieces(at, reply);
      case 8: line_.arrive(chance_.between({}, at), noise()); return line_.arrive(at, std::move(reply));
      case 9: return line_.arrive(at, encode_rtu_exception(asked, static_cast<std::uint8_t>(1 + chance_.below(11))));
      case 10: return misdirect(at, request);
      // In place of the answer.
      case 11: line_.arrive(at, foreign(request)); return;
      default: --faults_; return line_.arrive(at, std::move(reply));
    }
  }

  /// Sends the answer twice within the gap, in which no unit may send.
  void twice(Duration at, Bytes reply) {
    line_.arrive(at + chance_.between({}, gap_), reply);
    line_.arrive(at, std::move(reply));
  }

  /// Flips one to three bits, or a burst of up to 16.
  void falsify(Bytes& reply) {
    const auto flip = [&](std::size_t bit) { reply[bit / 8] ^= static_cast<std::byte>(1 << bit % 8); };
    const auto bits = 8 * reply.size();
    const auto first = chance_.below(bits - 16);
    flip(first);
    if (chance_.one_in(2)) {
      for (std::size_t bit = 1; bit < 16; ++bit)
        if (chance_.one_in(2)) flip(first + bit);
    } else {
      for (auto more = chance_.below(3); more > 0; --more) flip((first + 16 * more) % bits);
    }
  }

  /// Returns a valid answer to a request that the client never makes: of another unit, function or size.
  [[nodiscard]] Bytes foreign(ModbusRequest request) {
    if (!is_read(request.function))
      request = {.unit = request.unit, .function = ModbusFunction::read_holding, .count = 9};
    const auto kind = chance_.below(3);
    if (kind == 0) request.unit ^= static_cast<std::uint8_t>(1 + chance_.below(255));
    if (kind == 1) request.function = ModbusFunction::read_input;
    if (kind == 2) request.count = static_cast<std::uint16_t>(kMostAskedFor + 1 + chance_.below(20));
    return encode_rtu_reply(request, telltale_words(request.address, request.count, ~requests_));
  }

  /// Answers a write with another register or value. A read has no such field.
  void misdirect(Duration at, ModbusRequest request) {
    if (is_read(request.function)) return line_.arrive(at, foreign(request));
    request.address ^= static_cast<std::uint16_t>(1 + chance_.below(0xFFFF));
    line_.arrive(at, encode_rtu_reply(request, {}));
  }

  void in_pieces(Duration at, const Bytes& reply) {
    const auto cut = 1 + chance_.below(reply.size() - 1);
    line_.arrive(at, Bytes(reply.begin(), reply.begin() + static_cast<std::ptrdiff_t>(cut)));
    line_.arrive(at + chance_.between({}, kPieceGap),
                 Bytes(reply.begin() + static_cast<std::ptrdiff_t>(cut), reply.end()));
  }

  [[nodiscard]] Bytes noise() {
    Bytes bytes(1 + chance_.below(5));
    for (auto& byte : bytes) byte = chance_.byte();
    return bytes;
  }

  tests::SimulatedLine& line_;
  Duration gap_;
  Chance chance_;
  std::uint32_t requests_ = 0;
  std::map<std::uint16_t, std::uint16_t> stored_;
  long faults_ = 0;
};

class Client {
 public:
  Client(unsigned seed, bool loop_back) : chance_(seed) {
    ModbusLink link;
    link.framing = ModbusLink::Framing::rtu;
    link.timeout = kTimeout;
    link.piece_gap = kPieceGap;
    link.loop_back = loop_back;
    auto made = std::make_unique<tests::SimulatedLine>(clock_);
    line_ = made.get();
    unit_ = std::make_unique<FaultyUnit>(*line_, silence_between_frames(link), seed + 1);
    line_->heard = [this](auto frame) { unit_->hear(frame); };
    registers_ = make_guarded_registers(make_modbus_rtu(std::move(made), "line", link, &clock_), link, &clock_);
  }

  Account run(long transactions) {
    Account account;
    for (long i = 0; i < transactions; ++i) {
      const auto good = chance_.one_in(4) ? write_once(account) : read_once(account);
      ++(good ? account.good : account.failed);
      if (chance_.one_in(4)) clock_.advance(chance_.between({}, milliseconds(1000)));
      // The line may be used again after this time.
      if (!good) clock_.advance(milliseconds(10'000));
    }
    account.faults = unit_->faults();
    return account;
  }

 private:
  bool read_once(Account& account) {
    const auto address = static_cast<std::uint16_t>(chance_.below(400));
    const auto count = static_cast<std::uint16_t>(1 + chance_.below(chance_.one_in(2) ? 2 : kMostAskedFor));
    const auto words = registers_->read(ReadFunction::holding_registers, address, count);
    if (words && *words != telltale_words(address, count, unit_->requests())) ++account.wrong;
    return words.has_value();
  }

  bool write_once(Account& account) {
    const auto address = static_cast<std::uint16_t>(chance_.below(400));
    Words words(1 + chance_.below(3));
    for (auto& word : words) word = static_cast<std::uint16_t>(chance_.below(0x10000));
    const auto function = chance_.one_in(2) ? WriteFunction::one_register : WriteFunction::registers;
    const auto done = registers_->write(function, address, words);
    if (done && !unit_->holds(address, words)) ++account.wrong;
    return done.has_value();
  }

  Chance chance_;
  VirtualClock clock_;
  tests::SimulatedLine* line_{};
  std::unique_ptr<FaultyUnit> unit_;
  std::unique_ptr<Registers> registers_;
};

void expect_no_wrong_value(unsigned seed, bool loop_back) {
  const auto account = Client(seed, loop_back).run(kFaultedTransactions);
  EXPECT_EQ(account.wrong, 0) << "seed " << seed;
  EXPECT_GT(account.good, kFaultedTransactions * 2 / 5);
  EXPECT_GT(account.failed, kFaultedTransactions / 100);
  fmt::print("{} good, {} failed, {} wrong, {} faults made\n", account.good, account.failed, account.wrong,
             account.faults);
}

TEST(ModbusRtuFaults, NeverReturnWrongValue) { expect_no_wrong_value(20151130, false); }
TEST(ModbusRtuFaults, NeverReturnWrongValueWithLoopBack) { expect_no_wrong_value(20151201, true); }

}  // namespace
}  // namespace gyrotherm::drivers
