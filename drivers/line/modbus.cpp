// SPDX-License-Identifier: Apache-2.0
#include "drivers/line/modbus.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <optional>
#include <utility>

#include "core/deadline.hpp"
#include "drivers/line/byte_streams.hpp"
#include "drivers/line/modbus_lines.hpp"
#include "drivers/line/pauses.hpp"

namespace gyrotherm::drivers {
namespace {

using std::chrono::milliseconds;

constexpr Duration kTcpExchangeLimit = milliseconds(1000), kRtuExchangeLimit = milliseconds(1500);
constexpr int kMaxTries = 3;
constexpr Duration kFirstBusyWait = milliseconds(20);
/// The second packet of a reply may wait for the acknowledgement of the first (RFC 896), which systems delay by 40 to
/// 200 ms.
constexpr Duration kPieceGapOverTcp = milliseconds(250);

/// Returns the time limit of an exchange with all its attempts. Without transaction numbers, an attempt may first have
/// to wait for twice the timeout, in which the answer to an older request may arrive.
Duration exchange_limit(const ModbusLink& link) {
  const bool must_wait = link.framing == ModbusLink::Framing::rtu || link.returns_other_transaction;
  const auto one_try = (must_wait ? 3 : 1) * link.timeout + link.gap;
  return std::max(must_wait ? kRtuExchangeLimit : kTcpExchangeLimit,
                  one_try + std::max(link.minimum_period, link.after_write));
}

class GuardedRegisters final : public Registers {
 public:
  GuardedRegisters(std::unique_ptr<ModbusLine> line, const ModbusLink& link, const Clock* clock)
      : line_(std::move(line)), link_(link), clock_(clock), backoff_(clock) {}

  Result<std::vector<std::uint16_t>> read(ReadFunction function, std::uint16_t address, std::uint16_t count) override {
    auto message = request(static_cast<std::uint8_t>(function), address);
    assert(count >= 1 && count <= (is_bit_read(message.function) ? kMostBits : link_.read_at_most));
    message.count = count;
    return exchange(message, kMaxTries);
  }

  Result<void> write(WriteFunction function, std::uint16_t address, std::span<const std::uint16_t> words) override {
    const bool is_one_exchange = function == WriteFunction::registers;
    assert(!words.empty() && (!is_one_exchange || words.size() <= link_.write_at_most));
    const auto size = is_one_exchange ? words.size() : 1;
    for (; !words.empty(); words = words.subspan(size)) {
      auto message = request(static_cast<std::uint8_t>(function), address);
      message.words.assign(words.begin(), words.begin() + static_cast<std::ptrdiff_t>(size));
      message.count = static_cast<std::uint16_t>(size);
      if (auto done = exchange(message, 1); !done) return failure(std::move(done.error()));
      address = static_cast<std::uint16_t>(address + size);
    }
    return {};
  }

  Result<void> write_unconfirmed(WriteFunction function, std::uint16_t address,
                                 std::span<const std::uint16_t> words) override {
    end_rest();
    const auto size = function == WriteFunction::registers ? words.size() : 1;
    for (; !words.empty(); words = words.subspan(size)) {
      auto message = request(static_cast<std::uint8_t>(function), address);
      message.words.assign(words.begin(), words.begin() + static_cast<std::ptrdiff_t>(size));
      message.count = static_cast<std::uint16_t>(size);
      auto sent = line_->send_unconfirmed(message, Deadline(exchange_limit(link_), clock_));
      if (!sent) note_break(sent.error());
      if (!sent) return failure(sent.error().kind, place(message), sent.error().what);
      address = static_cast<std::uint16_t>(address + size);
    }
    return {};
  }

  void end_rest() override {
    backoff_.end_rest();
    line_->end_rest();
  }

  std::uint64_t breaks() const override { return breaks_; }

 private:
  using Words = std::vector<std::uint16_t>;

  /// Sends a request, and repeats it within the time limit: a read while the unit is busy, and any request after a
  /// failure of the line, up to `most_tries` attempts. Returns the first of several failures, because a later one may
  /// result only from too little remaining time.
  [[nodiscard]] Result<ModbusAnswer> request_with_retries(ModbusRequest& request, int most_tries) {
    const Deadline deadline(exchange_limit(link_), clock_);
    auto rest = kFirstBusyWait;
    std::optional<Fault> first;
    for (int tries = 1;; ++tries) {
      auto answer = line_->try_request(request, deadline);
      if (!answer) note_break(answer.error());
      if (!answer && !first) first = answer.error();
      if (!answer) answer = failure(*first);
      const bool is_unit_busy = answer && is_busy(*answer);
      if (is_unit_busy ? !is_read(request.function) : answer || tries >= most_tries) return answer;
      if (deadline.left() <= (is_unit_busy ? rest : Duration::zero())) return answer;
      if (is_unit_busy) line_->rest(std::exchange(rest, 2 * rest));
    }
  }

  /// Counts a broken connection. A TCP connection is closed after every failed exchange and opened again for the next
  /// one.
  void note_break(const Fault& fault) {
    const bool is_closed = link_.framing == ModbusLink::Framing::tcp;
    if (is_closed || fault.kind == FaultKind::disconnected) ++breaks_;
  }

  /// Performs an exchange with retries and updates the rest period. Adds the location to a fault.
  [[nodiscard]] Result<Words> exchange(ModbusRequest& request, int most_tries) {
    if (backoff_.left() > Duration::zero()) return failure(FaultKind::disconnected, place(request), backoff_.message());
    auto answer = request_with_retries(request, most_tries);
    answer ? backoff_.note_success() : backoff_.note_failure(answer.error().what);
    if (answer && answer->exception == 0) return std::move(answer->words);
    auto fault = answer ? refusal(request, answer->exception) : std::move(answer.error());
    fault.where = place(request);
    return failure(std::move(fault));
  }

  [[nodiscard]] bool is_busy(const ModbusAnswer& answer) const {
    return answer.exception != 0 && link_.busy_exceptions.contains(answer.exception);
  }

  [[nodiscard]] std::string place(const ModbusRequest& request) const {
    const auto table = [&] {
      switch (request.function) {
        case ModbusFunction::read_coils:
        case ModbusFunction::write_coil: return "coil ";
        case ModbusFunction::read_discrete_inputs: return "discrete input ";
        case ModbusFunction::read_input: return "input ";
        default: return "";
      }
    };
    return fmt::format("{} unit {} {} {}{}+{}", line_->place(), link_.unit,
                       is_read(request.function) ? "read" : "write", table(), request.address, request.count);
  }

  [[nodiscard]] Fault refusal(const ModbusRequest& request, std::uint8_t exception) const {
    const auto vendor_name = link_.exception_names.find(exception);
    const bool is_vendor_specific = vendor_name != link_.exception_names.end();
    return {fault_kind(request, exception, is_vendor_specific), "",
            fmt::format("exception {}, {}", exception,
                        is_vendor_specific ? vendor_name->second : exception_meaning(exception))};
  }

  /// Returns the fault kind of an exception: timeout if the unit is busy or a gateway did not reach it, because nothing
  /// was refused. For a read, only exceptions 1 and 2 (no such function or register) are refused; any other exception
  /// means that the unit has no value at present.
  [[nodiscard]] FaultKind fault_kind(const ModbusRequest& request, std::uint8_t exception,
                                     bool is_vendor_specific) const {
    constexpr std::uint8_t kNoAddress = 2, kFailure = 4, kAcknowledged = 5, kBusy = 6, kNoPath = 10, kNoAnswer = 11;
    if (link_.busy_exceptions.contains(exception)) return FaultKind::timeout;
    const bool is_temporary =
        exception == kAcknowledged || exception == kBusy || exception == kNoPath || exception == kNoAnswer;
    if (is_temporary && !is_vendor_specific) return FaultKind::timeout;
    if (is_read(request.function)) return exception > kNoAddress ? FaultKind::out_of_range : FaultKind::refused;
    return exception == kFailure && !is_vendor_specific ? FaultKind::timeout : FaultKind::refused;
  }

  [[nodiscard]] ModbusRequest request(std::uint8_t function, std::uint16_t address) const {
    return {.unit = link_.unit,
            .function = static_cast<ModbusFunction>(function),
            .address = address,
            .count = 1,
            .words = {},
            .either_read_function = link_.answers_reads_by_either_function,
            .miscounted_reply = link_.miscounts_write_replies,
            .any_transaction = link_.returns_other_transaction,
            .any_unit = link_.returns_other_unit};
  }

  std::unique_ptr<ModbusLine> line_;
  ModbusLink link_;
  const Clock* clock_;
  Backoff backoff_;
  std::uint64_t breaks_ = 0;
};

constexpr int kFastestBaud = 921600;

}  // namespace

std::unique_ptr<Registers> make_guarded_registers(std::unique_ptr<ModbusLine> line, const ModbusLink& link,
                                                  const Clock* clock) {
  return std::make_unique<GuardedRegisters>(std::move(line), link, clock);
}

ModbusLink remove_pauses(ModbusLink link) {
  link.minimum_period = link.after_write = Duration::zero();
  link.gap = Duration(1);  // 0 means 3.5 characters
  link.serial.baud = kFastestBaud;
  return link;
}

std::unique_ptr<Registers> make_modbus(const Line& line, const ModbusLink& link) {
  assert(is_byte_line(line));
  auto at = line;
  if (auto* tcp = std::get_if<TcpLine>(&at); tcp != nullptr && tcp->port == 0) tcp->port = link.port;

  if (link.framing == ModbusLink::Framing::tcp) {
    const auto& tcp = std::get<TcpLine>(at);
    return make_guarded_registers(
        make_modbus_tcp(make_modbus_connection(tcp), fmt::format("modbus {}:{}", tcp.host, tcp.port), link), link);
  }
  auto timed = link;
  if (const auto* serial = std::get_if<SerialLine>(&at))
    timed.serial = serial->format.value_or(link.serial);
  else
    timed.piece_gap = std::max(link.piece_gap, kPieceGapOverTcp);
  auto stream = make_stream(at, {.port = link.port, .serial = timed.serial}, link.timeout);
  if (link.echo) stream = make_echo_stream(std::move(stream));
  return make_guarded_registers(make_modbus_rtu(std::move(stream), fmt::format("modbus rtu {}", text(at)), timed),
                                timed);
}

}  // namespace gyrotherm::drivers
