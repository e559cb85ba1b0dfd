#include "drivers/line/modbus_tcp.hpp"

#include <fmt/format.h>
#include <modbus/modbus.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <utility>

#include "drivers/line/backoff.hpp"
#include "drivers/line/deadline.hpp"
#include "drivers/line/half_open.hpp"
#include "drivers/line/modbus_frame.hpp"

namespace gyrotherm {

namespace {

using std::chrono::milliseconds;

constexpr Duration kWholeExchange = milliseconds(1000);
constexpr int kMostTries = 3;
constexpr Duration kFirstRestOfABusyUnit = milliseconds(20);
constexpr std::size_t kLongestFrame = 260;
constexpr int kSelectableDescriptors = 1000;  ///< libmodbus waits with select(), which ends at 1024
constexpr std::uint8_t kStillAtWork = 5, kBusy = 6;

struct FreeContext {
  void operator()(modbus_t* context) const {
    modbus_close(context);
    modbus_free(context);
  }
};

class ModbusTcp final : public Registers {
 public:
  ModbusTcp(LineAddress address, std::uint8_t unit, Duration timeout)
      : address_(std::move(address)), unit_(unit), timeout_(timeout) {}

  Result<std::vector<std::uint16_t>> read(std::uint16_t address, std::uint16_t count) override;
  Result<void> write(std::uint16_t address, std::span<const std::uint16_t> words) override;

 private:
  using Reply = Result<std::vector<std::uint16_t>>;

  [[nodiscard]] Result<void> connect(const Deadline& deadline);
  void disconnect() { context_.reset(); }
  void wait_for_reply_at_most(Duration limit);
  [[nodiscard]] Reply exchange(ModbusRequest& request, const Deadline& deadline);
  [[nodiscard]] Reply receive(const ModbusRequest& request);
  [[nodiscard]] bool rest_while_busy(Duration rest, const Deadline& deadline);
  [[nodiscard]] Reply conclude(const ModbusRequest& request, Reply words);

  LineAddress address_;
  std::uint8_t unit_;
  Duration timeout_;
  std::unique_ptr<modbus_t, FreeContext> context_;  ///< exists while connected
  Backoff backoff_;
  std::uint16_t transaction_ = 0;  ///< counts on across connections
  bool busy_ = false;              ///< the last reply asked for patience
};

void ModbusTcp::wait_for_reply_at_most(Duration limit) {
  const auto us = std::max<std::int64_t>(std::chrono::duration_cast<std::chrono::microseconds>(limit).count(), 1);
  modbus_set_response_timeout(context_.get(), static_cast<std::uint32_t>(us / 1'000'000),
                              static_cast<std::uint32_t>(us % 1'000'000));
}

Result<void> ModbusTcp::connect(const Deadline& deadline) {
  if (context_) return {};
  if (const auto rest = backoff_.left(); rest > Duration::zero())
    return failure(FaultKind::disconnected, "", fmt::format("failed before, next try in {:.1f} s", to_seconds(rest)));
  context_.reset(modbus_new_tcp(address_.host.c_str(), address_.port));
  if (!context_) return failure(FaultKind::disconnected, "", "the address is not a numeric IPv4 address");
  modbus_set_error_recovery(context_.get(), MODBUS_ERROR_RECOVERY_NONE);
  modbus_set_byte_timeout(context_.get(), 0, 0);
  wait_for_reply_at_most(std::min(timeout_, deadline.left()));
  if (modbus_connect(context_.get()) != 0) {
    disconnect();
    return failure(FaultKind::disconnected, "", "no connection");
  }
  const int socket = modbus_get_socket(context_.get());
  assert(socket < kSelectableDescriptors);
  guard_against_half_open(socket);
  return {};
}

ModbusTcp::Reply ModbusTcp::receive(const ModbusRequest& request) {
  std::array<std::uint8_t, kLongestFrame> frame;
  const int size = modbus_receive_confirmation(context_.get(), frame.data());
  if (size < 0 && errno == ETIMEDOUT)
    return failure(FaultKind::timeout, "", fmt::format("no reply in {} ms", timeout_ / milliseconds(1)));
  if (size < 0 && errno >= MODBUS_ENOBASE) return failure(FaultKind::corrupted, "", modbus_strerror(errno));
  if (size < 0) return failure(FaultKind::disconnected, "", fmt::format("the line broke: {}", modbus_strerror(errno)));
  const auto reply = std::as_bytes(std::span(frame).first(static_cast<std::size_t>(size)));
  auto words = decode_reply(request, reply);
  if (!words && words.error().kind == FaultKind::refused) {
    const auto code = frame[reply.size() - 1];
    busy_ = code == kStillAtWork || code == kBusy;
  }
  return words;
}

/// One try. After anything but a good reply or an exception the connection is closed.
ModbusTcp::Reply ModbusTcp::exchange(ModbusRequest& request, const Deadline& deadline) {
  busy_ = false;
  if (auto connected = connect(deadline); !connected) return failure(std::move(connected.error()));
  request.transaction = ++transaction_;
  const auto frame = encode_request(request);
  wait_for_reply_at_most(std::min(timeout_, deadline.left()));
  const auto sent = send(modbus_get_socket(context_.get()), frame.data(), frame.size(), MSG_NOSIGNAL);
  auto words = sent == static_cast<ssize_t>(frame.size())
                   ? receive(request)
                   : Reply(failure(FaultKind::disconnected, "", fmt::format("cannot send: {}", std::strerror(errno))));
  if (!words && words.error().kind != FaultKind::refused) disconnect();
  return words;
}

/// Nothing may come while a busy unit rests; false if something does, or if there is no time left.
bool ModbusTcp::rest_while_busy(Duration rest, const Deadline& deadline) {
  if (deadline.left() <= rest) return false;
  pollfd line{modbus_get_socket(context_.get()), POLLIN, 0};
  if (poll(&line, 1, static_cast<int>(rest / milliseconds(1))) == 0) return true;
  disconnect();
  return false;
}

/// Names the place of a failure, and keeps the account for the back-off.
ModbusTcp::Reply ModbusTcp::conclude(const ModbusRequest& request, Reply words) {
  if (words) {
    backoff_.succeeded();
    return words;
  }
  auto& fault = words.error();
  const bool reading = request.function == ModbusFunction::read_holding;
  fault.where = fmt::format("modbus {}:{} unit {} {} {}+{}", address_.host, address_.port, unit_,
                            reading ? "read" : "write", request.address, request.count);
  if (fault.kind == FaultKind::refused)
    backoff_.succeeded();
  else if (backoff_.left() == Duration::zero())
    backoff_.failed();
  return words;
}

Result<std::vector<std::uint16_t>> ModbusTcp::read(std::uint16_t address, std::uint16_t count) {
  assert(count >= 1 && count <= 125);
  const Deadline deadline(kWholeExchange);
  ModbusRequest request{.unit = unit_, .function = ModbusFunction::read_holding, .address = address, .count = count};
  auto words = exchange(request, deadline);
  auto rest = kFirstRestOfABusyUnit;
  for (int tries = 1; !words && !deadline.over(); ++tries) {
    if (busy_) {
      if (!rest_while_busy(rest, deadline)) break;
      rest *= 2;
    } else if (words.error().kind == FaultKind::refused || tries == kMostTries) {
      break;
    }
    words = exchange(request, deadline);
  }
  return conclude(request, std::move(words));
}

Result<void> ModbusTcp::write(std::uint16_t address, std::span<const std::uint16_t> words) {
  assert(!words.empty() && words.size() <= 123);
  const Deadline deadline(kWholeExchange);
  ModbusRequest request{.unit = unit_, .address = address, .count = static_cast<std::uint16_t>(words.size())};
  request.function = words.size() == 1 ? ModbusFunction::write_single : ModbusFunction::write_multiple;
  request.words.assign(words.begin(), words.end());
  auto done = conclude(request, exchange(request, deadline));
  if (!done) return failure(std::move(done.error()));
  return {};
}

}  // namespace

std::unique_ptr<Registers> make_modbus_tcp(const LineAddress& address, std::uint8_t unit, Duration timeout) {
  return std::make_unique<ModbusTcp>(address, unit, timeout);
}

}  // namespace gyrotherm
