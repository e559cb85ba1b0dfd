#include "drivers/line/modbus_tcp.hpp"

#include <fcntl.h>
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

#include "drivers/line/descriptor.hpp"
#include "drivers/line/modbus_frame.hpp"
#include "drivers/line/tcp_stream.hpp"

namespace gyrotherm {

namespace {

using std::chrono::milliseconds;

constexpr std::size_t kLongestTcpFrame = 260;
constexpr int kSelectableDescriptors = 1000;  ///< libmodbus waits with select(), which ends at 1024

/// Whether the next descriptor, which a connection will have, is one that libmodbus can wait for; it does so already
/// while it connects.
bool may_select() {
  const Descriptor next(::open("/", O_PATH | O_CLOEXEC));
  return next.is_open() && next.number() < kSelectableDescriptors;
}

struct FreeContext {
  void operator()(modbus_t* context) const {
    modbus_close(context);
    modbus_free(context);
  }
};

class LibmodbusConnection final : public FrameConnection {
 public:
  explicit LibmodbusConnection(TcpLine line) : line_(std::move(line)) {}

  bool is_open() const override { return context_ != nullptr; }
  Result<void> open(Duration within) override;
  void close() override { context_.reset(); }
  Result<void> send(std::span<const std::byte> frame) override;
  Result<std::size_t> receive(std::span<std::byte> frame, Duration within) override;
  bool silent_for(Duration time) override;

 private:
  void limit_waits(Duration within);

  TcpLine line_;
  std::unique_ptr<modbus_t, FreeContext> context_;  ///< exists while connected
};

void LibmodbusConnection::limit_waits(Duration within) {
  const auto us = std::max<std::int64_t>(std::chrono::duration_cast<std::chrono::microseconds>(within).count(), 1);
  modbus_set_response_timeout(context_.get(), static_cast<std::uint32_t>(us / 1'000'000),
                              static_cast<std::uint32_t>(us % 1'000'000));
}

Result<void> LibmodbusConnection::open(Duration within) {
  context_.reset(modbus_new_tcp(line_.host.c_str(), line_.port));
  if (!context_) return failure(FaultKind::disconnected, "", "the address is not a numeric IPv4 address");
  if (!may_select())
    return failure(FaultKind::disconnected, "",
                   fmt::format("more than {} files are open, expected fewer", kSelectableDescriptors));
  modbus_set_error_recovery(context_.get(), MODBUS_ERROR_RECOVERY_NONE);
  modbus_set_byte_timeout(context_.get(), 0, 0);
  limit_waits(within);
  if (modbus_connect(context_.get()) != 0) {
    close();
    return failure(FaultKind::disconnected, "", "no connection");
  }
  guard_against_half_open(modbus_get_socket(context_.get()));
  return {};
}

Result<void> LibmodbusConnection::send(std::span<const std::byte> frame) {
  const auto sent = ::send(modbus_get_socket(context_.get()), frame.data(), frame.size(), MSG_NOSIGNAL);
  if (sent == static_cast<ssize_t>(frame.size())) return {};
  return failure(FaultKind::disconnected, "", fmt::format("cannot send: {}", std::strerror(errno)));
}

Result<std::size_t> LibmodbusConnection::receive(std::span<std::byte> frame, Duration within) {
  assert(frame.size() >= kLongestTcpFrame);
  limit_waits(within);
  const int size = modbus_receive_confirmation(context_.get(), reinterpret_cast<std::uint8_t*>(frame.data()));
  if (size >= 0) return static_cast<std::size_t>(size);
  if (errno == ETIMEDOUT) return failure(FaultKind::timeout, "", "no reply");
  if (errno >= MODBUS_ENOBASE) return failure(FaultKind::corrupted, "", modbus_strerror(errno));
  return failure(FaultKind::disconnected, "", fmt::format("the line broke: {}", modbus_strerror(errno)));
}

bool LibmodbusConnection::silent_for(Duration time) {
  return !ready(context_ ? modbus_get_socket(context_.get()) : kNoDescriptor, POLLIN, Deadline(time));
}

class ModbusTcp final : public ModbusLine {
 public:
  ModbusTcp(std::unique_ptr<FrameConnection> connection, std::string place, const ModbusLink& link, const Clock* clock)
      : connection_(std::move(connection)), place_(std::move(place)), timeout_(link.timeout), pace_(link, clock) {}

  Result<ModbusAnswer> ask(ModbusRequest& request, const Deadline& deadline) override;
  void rest(Duration time) override {
    if (!connection_->silent_for(time)) connection_->close();
  }
  std::string place() const override { return place_; }

 private:
  [[nodiscard]] Result<ModbusAnswer> receive(const ModbusRequest& request, const Deadline& deadline);

  std::unique_ptr<FrameConnection> connection_;
  std::string place_;
  Duration timeout_;
  Pace pace_;
  std::uint16_t transaction_ = 0;  ///< counts on across connections
};

Result<ModbusAnswer> ModbusTcp::receive(const ModbusRequest& request, const Deadline& deadline) {
  std::array<std::byte, kLongestTcpFrame> frame;
  const auto size = connection_->receive(frame, std::min(timeout_, deadline.left()));
  if (size) return decode_answer(request, std::span(frame).first(*size));
  if (size.error().kind != FaultKind::timeout) return failure(size.error());
  return failure(FaultKind::timeout, "", fmt::format("no reply in {} ms", timeout_ / milliseconds(1)));
}

Result<ModbusAnswer> ModbusTcp::ask(ModbusRequest& request, const Deadline& deadline) {
  if (const auto pause = pace_.left(); pause > Duration::zero()) {
    if (pause >= deadline.left()) return failure(FaultKind::timeout, "", "no time left for the pause the unit needs");
    rest(pause);
  }
  if (!connection_->is_open())
    if (auto opened = connection_->open(std::min(timeout_, deadline.left())); !opened)
      return failure(std::move(opened.error()));
  request.transaction = ++transaction_;
  pace_.began();
  auto answer = connection_->send(encode_request(request)).and_then([&] { return receive(request, deadline); });
  pace_.ended(request);
  if (!answer) connection_->close();
  return answer;
}

}  // namespace

std::unique_ptr<ModbusLine> make_modbus_tcp(std::unique_ptr<FrameConnection> connection, std::string place,
                                            const ModbusLink& link, const Clock* clock) {
  return std::make_unique<ModbusTcp>(std::move(connection), std::move(place), link, clock);
}

std::unique_ptr<FrameConnection> make_modbus_connection(const TcpLine& line) {
  return std::make_unique<LibmodbusConnection>(line);
}

}  // namespace gyrotherm
