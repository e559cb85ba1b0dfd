// SPDX-License-Identifier: Apache-2.0
#include "drivers/line/modbus_lines.hpp"

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

#include "core/deadline.hpp"
#include "drivers/line/byte_streams.hpp"
#include "drivers/line/modbus_frame.hpp"

namespace gyrotherm::drivers {

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
  explicit LibmodbusConnection(Connect connect) : connect_(std::move(connect)) {}

  bool is_open() const override { return context_ != nullptr; }

  Result<void> open(Duration within) override {
    context_.reset(modbus_new_tcp(line_.host.c_str(), line_.port));
    if (!context_) return failure(FaultKind::disconnected, "", "the address is not a numeric IPv4 address");
    if (!may_select())
      return failure(FaultKind::disconnected, "",
                     fmt::format("more than {} files are open, expected fewer", kSelectableDescriptors));
    modbus_set_error_recovery(context_.get(), MODBUS_ERROR_RECOVERY_NONE);
    modbus_set_byte_timeout(context_.get(), 0, 0);
    limit_waits(within);
    auto connected = connect_ ? take_over() : connect();
    if (!connected) close();
    return connected;
  }

  void close() override { context_.reset(); }

  Result<void> send(std::span<const std::byte> frame) override {
    const auto sent = ::send(modbus_get_socket(context_.get()), frame.data(), frame.size(), MSG_NOSIGNAL);
    if (sent == static_cast<ssize_t>(frame.size())) return {};
    return failure(FaultKind::disconnected, "", fmt::format("cannot send: {}", std::strerror(errno)));
  }

  Result<std::size_t> receive(std::span<std::byte> frame, Duration within) override {
    assert(frame.size() >= kLongestTcpFrame);
    limit_waits(within);
    const int size = modbus_receive_confirmation(context_.get(), reinterpret_cast<std::uint8_t*>(frame.data()));
    if (size >= 0) return static_cast<std::size_t>(size);
    if (errno == ETIMEDOUT) return failure(FaultKind::timeout, "", "no reply");
    if (errno >= MODBUS_ENOBASE) return failure(FaultKind::corrupted, "", modbus_strerror(errno));
    return failure(FaultKind::disconnected, "", fmt::format("the line broke: {}", modbus_strerror(errno)));
  }

  bool silent_for(Duration time) override {
    return !ready(context_ ? modbus_get_socket(context_.get()) : kNoDescriptor, POLLIN, Deadline(time));
  }

 private:
  Result<void> connect() {
    if (modbus_connect(context_.get()) != 0) return failure(FaultKind::disconnected, "", "no connection");
    guard_against_half_open(modbus_get_socket(context_.get()));
    return {};
  }

  Result<void> take_over() {
    auto connected = connect_();
    if (!connected) return failure(std::move(connected.error()));
    modbus_set_socket(context_.get(), std::move(*connected).release());
    return {};
  }

  void limit_waits(Duration within) {
    const auto us = std::max<std::int64_t>(std::chrono::duration_cast<std::chrono::microseconds>(within).count(), 1);
    modbus_set_response_timeout(context_.get(), static_cast<std::uint32_t>(us / 1'000'000),
                                static_cast<std::uint32_t>(us % 1'000'000));
  }

  TcpLine line_{"127.0.0.1", 0};
  Connect connect_;                                 ///< empty: the line is connected to
  std::unique_ptr<modbus_t, FreeContext> context_;  ///< exists while connected
};

class ModbusTcp final : public ModbusLine {
 public:
  ModbusTcp(std::unique_ptr<FrameConnection> connection, std::string place, const ModbusLink& link, const Clock* clock)
      : connection_(std::move(connection)), place_(std::move(place)), timeout_(link.timeout), pace_(link, clock) {}

  Result<ModbusAnswer> ask(ModbusRequest& request, const Deadline& deadline) override {
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

  void rest(Duration time) override {
    if (!connection_->silent_for(time)) connection_->close();
  }
  std::string place() const override { return place_; }

 private:
  [[nodiscard]] Result<ModbusAnswer> receive(const ModbusRequest& request, const Deadline& deadline) {
    std::array<std::byte, kLongestTcpFrame> frame;
    const auto size = connection_->receive(frame, std::min(timeout_, deadline.left()));
    if (size) return decode_answer(request, std::span(frame).first(*size));
    if (size.error().kind != FaultKind::timeout) return failure(size.error());
    return failure(FaultKind::timeout, "", fmt::format("no reply in {} ms", timeout_ / milliseconds(1)));
  }

  std::unique_ptr<FrameConnection> connection_;
  std::string place_;
  Duration timeout_;
  Pace pace_;
  std::uint16_t transaction_ = 0;  ///< counts on across connections
};

}  // namespace

std::unique_ptr<ModbusLine> make_modbus_tcp(std::unique_ptr<FrameConnection> connection, std::string place,
                                            const ModbusLink& link, const Clock* clock) {
  return std::make_unique<ModbusTcp>(std::move(connection), std::move(place), link, clock);
}

std::unique_ptr<FrameConnection> make_modbus_connection(const TcpLine& line) {
  return std::make_unique<LibmodbusConnection>(line);
}

std::unique_ptr<FrameConnection> make_modbus_connection(Connect connect) {
  return std::make_unique<LibmodbusConnection>(std::move(connect));
}

namespace {

using std::chrono::milliseconds;

constexpr int kFastestByCharacters = 19200;
constexpr Duration kSilenceOfFastLines = std::chrono::microseconds(1750);
constexpr std::size_t kRoom = kLongestRtuFrame + 4;
constexpr int kLeastPieceGapInCharacters = 4;

/// Whether `bytes`, three or more, are those that `sent` begins with.
bool begins_with(std::span<const std::byte> bytes, std::span<const std::byte> sent) {
  const auto size = std::min(bytes.size(), sent.size());
  return size >= 3 && std::ranges::equal(bytes.first(size), sent.first(size));
}

class ModbusRtu final : public ModbusLine {
 public:
  ModbusRtu(std::unique_ptr<ByteStream> stream, std::string place, const ModbusLink& link, const Clock* clock)
      : stream_(std::move(stream)),
        place_(std::move(place)),
        unit_(link.unit),
        timeout_(link.timeout),
        piece_gap_(std::max(link.piece_gap, kLeastPieceGapInCharacters * character_time(link.serial))),
        silence_(silence_between_frames(link)),
        loop_back_(link.loop_back),
        clock_(clock),
        late_answers_(Duration::zero(), clock),
        pace_(link, clock) {}

  Result<ModbusAnswer> ask(ModbusRequest& request, const Deadline& deadline) override {
    const bool lost_the_resync = answer_may_come_late_;
    if (auto silent = wait_for_silence(deadline); !silent) return failure(std::move(silent.error()));
    if (loop_back_ && (lost_the_resync || answer_may_come_late_))
      if (auto found = resynchronise(deadline); !found) return failure(std::move(found.error()));
    return exchange(request, deadline);
  }

  void rest(Duration time) override {
    std::array<std::byte, kRoom> stale;
    const Deadline deadline(time, clock_);
    while (!deadline.over()) {
      const auto size = stream_->read(stale, deadline.left());
      if (size) answer_may_come_late_ = true;
      if (!size && size.error().kind != FaultKind::timeout) return;  // the next try says so
    }
  }

  void insist() override { stream_->insist(); }

  std::string place() const override { return place_; }

 private:
  /// Throws away what comes until the line has been silent long enough.
  [[nodiscard]] Result<void> wait_for_silence(const Deadline& deadline) {
    std::array<std::byte, kRoom> stale;
    while (true) {
      const auto pause = std::max(silence_, pace_.left());
      const auto silence = answer_may_come_late_ ? std::max({timeout_, late_answers_.left(), pause}) : pause;
      const auto left = deadline.left();
      const auto size = stream_->read(stale, std::min(silence, left));
      if (!size && size.error().kind != FaultKind::timeout) return failure(size.error());
      if (!size && left >= silence) return {};
      if (!size) return failure(FaultKind::timeout, "", "no time left to wait for silence on the line");
      if (deadline.over()) return failure(FaultKind::corrupted, "", "the line does not fall silent");
      answer_may_come_late_ = true;
    }
  }

  /// A number that only this request can have brought back.
  [[nodiscard]] Result<void> resynchronise(const Deadline& deadline) {
    const ModbusRequest ask{
        .unit = unit_, .function = ModbusFunction::loop_back, .count = 1, .words = {++last_number_}};
    auto answer = exchange(ask, deadline);
    if (!answer) return failure(std::move(answer.error()));
    if (answer->exception == 0) return wait_for_silence(deadline);
    return failure(FaultKind::corrupted, "", "the unit does not return what it is sent (function 8)");
  }

  [[nodiscard]] Result<ModbusAnswer> exchange(const ModbusRequest& request, const Deadline& deadline) {
    const auto frame = encode_rtu_request(request);
    if (auto sent = stream_->write(frame, deadline.left()); !sent) return failure(std::move(sent.error()));
    pace_.began();
    answer_may_come_late_ = true;
    late_answers_ = Deadline(2 * timeout_, clock_);
    auto answer = receive(request, frame, deadline);
    pace_.ended(request);
    if (answer) answer_may_come_late_ = false;
    return answer;
  }

  /// Collects the bytes of one answer, and no more.
  [[nodiscard]] Result<ModbusAnswer> receive(const ModbusRequest& request, std::span<const std::byte> sent,
                                             const Deadline& deadline) {
    std::array<std::byte, kRoom> frame;
    std::size_t size = 0;
    const Deadline reply(std::min(timeout_, deadline.left()), clock_);
    while (true) {
      const auto within = size == 0 ? reply.left() : std::min(piece_gap_, reply.left());
      const auto more = stream_->read(std::span(frame).subspan(size), within);
      if (!more && more.error().kind != FaultKind::timeout) return failure(more.error());
      if (!more && size == 0)
        return failure(FaultKind::timeout, "", fmt::format("no reply in {} ms", timeout_ / milliseconds(1)));
      if (!more) return failure(FaultKind::corrupted, "", fmt::format("the reply ends after {} bytes", size));
      size += *more;
      const auto bytes = std::span<const std::byte>(frame).first(size);
      const auto whole = rtu_answer_size(request, bytes);
      if (!whole && begins_with(bytes, sent))
        return failure(FaultKind::corrupted, "", "what was sent comes back: the line or its adapter echoes");
      if (!whole) return failure(whole.error());
      if (*whole && size >= **whole) return decode_rtu_answer(request, bytes);
    }
  }

  std::unique_ptr<ByteStream> stream_;
  std::string place_;
  std::uint8_t unit_;
  Duration timeout_, piece_gap_, silence_;
  bool loop_back_;
  const Clock* clock_;
  bool answer_may_come_late_ = true;  ///< who used the line before is not known
  Deadline late_answers_;             ///< until then answers to the last request are to be expected
  Pace pace_;
  std::uint16_t last_number_ = 0;  ///< of a loop-back
};

}  // namespace

Duration silence_between_frames(const ModbusLink& link) {
  if (link.gap > Duration::zero()) return link.gap;
  if (link.serial.baud >= kFastestByCharacters) return kSilenceOfFastLines;
  return 7 * character_time(link.serial) / 2;
}

std::unique_ptr<ModbusLine> make_modbus_rtu(std::unique_ptr<ByteStream> stream, std::string place,
                                            const ModbusLink& link, const Clock* clock) {
  return std::make_unique<ModbusRtu>(std::move(stream), std::move(place), link, clock);
}

}  // namespace gyrotherm::drivers
