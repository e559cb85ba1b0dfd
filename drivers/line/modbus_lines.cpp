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
constexpr int kSelectableDescriptors = 1000;  ///< below FD_SETSIZE

/// Returns whether the next file descriptor, which the connection will use, is small enough for select(), which
/// libmodbus calls.
bool can_select() {
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

  Result<void> open(Duration within) override {
    context_.reset(modbus_new_tcp(line_.host.c_str(), line_.port));
    if (!context_) return failure(FaultKind::disconnected, "", "the address is not a numeric IPv4 address");
    if (!can_select())
      return failure(FaultKind::disconnected, "",
                     fmt::format("more than {} files are open, expected fewer", kSelectableDescriptors));
    modbus_set_error_recovery(context_.get(), MODBUS_ERROR_RECOVERY_NONE);
    modbus_set_byte_timeout(context_.get(), 0, 0);
    set_timeout(within);
    auto connected = connect();
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
    set_timeout(within);
    const int size = modbus_receive_confirmation(context_.get(), reinterpret_cast<std::uint8_t*>(frame.data()));
    if (size >= 0) return static_cast<std::size_t>(size);
    if (errno == ETIMEDOUT) return failure(FaultKind::timeout, "", "no reply");
    if (errno >= MODBUS_ENOBASE) return failure(FaultKind::corrupted, "", modbus_strerror(errno));
    return failure(FaultKind::disconnected, "", fmt::format("connection lost: {}", modbus_strerror(errno)));
  }

  bool is_silent_for(Duration time) override {
    return !wait_until_ready(context_ ? modbus_get_socket(context_.get()) : kNoDescriptor, POLLIN, Deadline(time));
  }

 private:
  Result<void> connect() {
    if (modbus_connect(context_.get()) != 0)
      return failure(FaultKind::disconnected, "", fmt::format("no connection: {}", modbus_strerror(errno)));
    enable_dead_peer_detection(modbus_get_socket(context_.get()));
    return {};
  }

  void set_timeout(Duration within) {
    const auto us = std::max<std::int64_t>(std::chrono::duration_cast<std::chrono::microseconds>(within).count(), 1);
    modbus_set_response_timeout(context_.get(), static_cast<std::uint32_t>(us / 1'000'000),
                                static_cast<std::uint32_t>(us % 1'000'000));
  }

  TcpLine line_;
  std::unique_ptr<modbus_t, FreeContext> context_;
};

class ModbusTcp final : public ModbusLine {
 public:
  ModbusTcp(std::unique_ptr<FrameConnection> connection, std::string place, const ModbusLink& link, const Clock* clock)
      : connection_(std::move(connection)),
        place_(std::move(place)),
        timeout_(link.timeout),
        is_numbered_(!link.returns_other_transaction),
        clock_(clock),
        late_answers_(Duration::zero(), clock),
        pace_(link, clock) {}

  Result<ModbusAnswer> try_request(ModbusRequest& request, const Deadline& deadline) override {
    if (const auto pause = pace_.left(); pause > Duration::zero()) {
      if (pause >= deadline.left())
        return failure(FaultKind::timeout, "", "no time left for the pause that the unit needs");
      rest(pause);
    }
    if (auto ready = is_numbered_ ? open(deadline) : open_silent(deadline); !ready)
      return failure(std::move(ready.error()));
    request.transaction = ++transaction_;
    pace_.note_start();
    late_answers_ = Deadline(2 * timeout_, clock_);
    auto answer = connection_->send(encode_request(request)).and_then([&] { return receive(request, deadline); });
    pace_.note_end(request);
    if (!answer) drop();
    return answer;
  }

  void rest(Duration time) override {
    if (!connection_->is_silent_for(time)) drop();
  }
  std::string place() const override { return place_; }

 private:
  [[nodiscard]] Result<void> open(const Deadline& deadline) {
    if (connection_->is_open()) return {};
    return connection_->open(std::min(timeout_, deadline.left()));
  }

  /// Opens a connection on which no answer to an older request can arrive, for replies without transaction numbers.
  /// After a failure or unsolicited bytes, a new connection must be silent for a whole timeout, and at least until
  /// twice the timeout has passed since the last request.
  [[nodiscard]] Result<void> open_silent(const Deadline& deadline) {
    while (true) {
      if (connection_->is_open() && !connection_->is_silent_for(Duration::zero())) drop();
      if (auto opened = open(deadline); !opened) return opened;
      if (!answer_may_come_late_) return {};
      const auto silence = std::max(timeout_, late_answers_.left());
      if (silence >= deadline.left())
        return failure(FaultKind::timeout, "", "no time left to wait for silence on the connection");
      if (connection_->is_silent_for(silence)) {
        answer_may_come_late_ = false;
        return {};
      }
      drop();
    }
  }

  void drop() {
    connection_->close();
    answer_may_come_late_ = true;
  }

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
  /// Replies contain the transaction number of their request.
  bool is_numbered_;
  const Clock* clock_;
  /// True at the start, because another client may have used the unit.
  bool answer_may_come_late_ = true;
  /// End of the time in which an answer to the last request may arrive.
  Deadline late_answers_;
  Pace pace_;
  /// Latest transaction number. It is not reset when the connection is.
  std::uint16_t transaction_ = 0;
};

}  // namespace

std::unique_ptr<ModbusLine> make_modbus_tcp(std::unique_ptr<FrameConnection> connection, std::string place,
                                            const ModbusLink& link, const Clock* clock) {
  return std::make_unique<ModbusTcp>(std::move(connection), std::move(place), link, clock);
}

std::unique_ptr<FrameConnection> make_modbus_connection(const TcpLine& line) {
  return std::make_unique<LibmodbusConnection>(line);
}

namespace {

using std::chrono::milliseconds;

constexpr int kFixedSilenceBaud = 19200;
constexpr Duration kFixedSilence = std::chrono::microseconds(1750);
/// Maximum number of received bytes: an answer and the noise around it.
constexpr std::size_t kBufferSize = 3 * kLongestRtuFrame;
constexpr int kLeastPieceGapInCharacters = 4;

constexpr const char* kEchoMessage =
    "the line or its adapter echoes the request; set echo = true in the link table of the rig "
    "file";

/// Returns whether `whole` is longer than `part` and begins with it.
bool is_proper_prefix(std::span<const std::byte> part, std::span<const std::byte> whole) {
  return part.size() < whole.size() && std::ranges::equal(part, whole.first(part.size()));
}

bool contains(std::span<const std::byte> bytes, std::span<const std::byte> part) {
  return !std::ranges::search(bytes, part).empty();
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
        stream_removes_echo_(link.echo),
        has_no_echo_(link.echo),
        clock_(clock),
        late_answers_(Duration::zero(), clock),
        pace_(link, clock) {}

  Result<ModbusAnswer> try_request(ModbusRequest& request, const Deadline& deadline) override {
    auto answer = exchange_after_silence(request, deadline);
    if (!answer && answer.error().kind == FaultKind::disconnected) has_no_echo_ = stream_removes_echo_;
    return answer;
  }

  Result<void> send_unconfirmed(ModbusRequest& request, const Deadline& deadline) override {
    rest(std::min(std::max(silence_, pace_.left()), deadline.left()));
    const auto sent = stream_->write(encode_rtu_request(request), deadline.left());
    if (!sent && sent.error().kind == FaultKind::disconnected) return sent;
    pace_.note_start();
    answer_may_come_late_ = true;
    late_answers_ = Deadline(2 * timeout_, clock_);
    rest(std::min(timeout_, deadline.left()));
    pace_.note_end(request);
    return {};
  }

  void rest(Duration time) override {
    std::array<std::byte, kBufferSize> stale;
    const Deadline deadline(time, clock_);
    while (!deadline.has_passed()) {
      const auto size = stream_->read(stale, deadline.left());
      if (size) answer_may_come_late_ = true;
      if (!size && size.error().kind != FaultKind::timeout) return;  // the next attempt reports it
    }
  }

  void end_rest() override { stream_->end_rest(); }

  std::string place() const override { return place_; }

 private:
  [[nodiscard]] Result<ModbusAnswer> exchange_after_silence(const ModbusRequest& request, const Deadline& deadline) {
    const bool could_answer_be_late = answer_may_come_late_;
    if (auto silent = wait_for_silence(deadline); !silent) return failure(std::move(silent.error()));
    if (loop_back_ && (could_answer_be_late || answer_may_come_late_))
      if (auto found = resynchronise(deadline); !found) return failure(std::move(found.error()));
    auto answer = exchange(request, deadline);
    if (answer && !has_no_echo_)
      if (auto verified = verify_no_echo(request, deadline); !verified) return failure(std::move(verified.error()));
    return answer;
  }

  /// Discards arriving bytes until the line has been silent for the required time.
  [[nodiscard]] Result<void> wait_for_silence(const Deadline& deadline) {
    std::array<std::byte, kBufferSize> stale;
    std::size_t stray = 0;
    while (true) {
      const auto pause = std::max(silence_, pace_.left());
      const auto silence = answer_may_come_late_ ? std::max({timeout_, late_answers_.left(), pause}) : pause;
      const auto left = deadline.left();
      const auto size = stream_->read(stale, std::min(silence, left));
      if (!size && size.error().kind != FaultKind::timeout) return failure(size.error());
      if (!size && left >= silence) return {};
      if (!size) return failure(FaultKind::timeout, "", "no time left to wait for silence on the line");
      if (deadline.has_passed()) return failure(FaultKind::corrupted, "", "the line does not become silent");
      stray += *size;
      answer_may_come_late_ = answer_may_come_late_ || stray >= kShortestRtuAnswer;  // fewer are noise
    }
  }

  /// Sends a number that was not used before with function 8. An answer with this number is not an older one.
  [[nodiscard]] Result<void> resynchronise(const Deadline& deadline) {
    const ModbusRequest query{
        .unit = unit_, .function = ModbusFunction::loop_back, .count = 1, .words = {++last_number_}};
    auto answer = exchange(query, deadline);
    if (!answer) return failure(std::move(answer.error()));
    if (answer->exception == 0) return wait_for_silence(deadline);
    return failure(FaultKind::corrupted, "", "the unit does not return the data of a loop-back request (function 8)");
  }

  /// Verifies that the answer to a write, which equals its request, was not an echo: reads the same address, because
  /// the answer to a read differs from the request.
  [[nodiscard]] Result<void> verify_no_echo(const ModbusRequest& written, const Deadline& deadline) {
    if (auto silent = wait_for_silence(deadline); !silent) return silent;
    const bool is_coil = written.function == ModbusFunction::write_coil || is_bit_read(written.function);
    const ModbusRequest query{.unit = unit_,
                              .function = is_coil ? ModbusFunction::read_coils : ModbusFunction::read_holding,
                              .address = written.address,
                              .count = 1};
    const auto answer = exchange(query, deadline);
    if (has_no_echo_) return {};
    if (answer || answer.error().what == kEchoMessage) return failure(FaultKind::corrupted, "", kEchoMessage);
    return failure(answer.error().kind, "", "the reply equals the request, perhaps an echo: " + answer.error().what);
  }

  [[nodiscard]] Result<ModbusAnswer> exchange(const ModbusRequest& request, const Deadline& deadline) {
    const auto frame = encode_rtu_request(request);
    auto sent = stream_->write(frame, deadline.left());
    if (!sent && sent.error().kind == FaultKind::disconnected) return failure(std::move(sent.error()));
    pace_.note_start();
    answer_may_come_late_ = true;
    late_answers_ = Deadline(2 * timeout_, clock_);
    auto answer = sent ? receive(request, frame, deadline) : Result<ModbusAnswer>(failure(std::move(sent.error())));
    pace_.note_end(request);
    return answer;
  }

  /// Reads bytes until they contain a frame that answers the request.
  [[nodiscard]] Result<ModbusAnswer> receive(const ModbusRequest& request, std::span<const std::byte> sent,
                                             const Deadline& deadline) {
    std::array<std::byte, kBufferSize> buffer;
    std::size_t size = 0;
    RtuFinding found;
    const Deadline reply(std::min(timeout_, deadline.left()), clock_);
    while (size < buffer.size()) {
      const auto within = found.has_partial_frame ? std::min(piece_gap_, reply.left()) : reply.left();
      const auto more = stream_->read(std::span(buffer).subspan(size), within);
      if (!more && more.error().kind != FaultKind::timeout) return failure(more.error());
      if (!more) return finish_reply(std::move(found), std::span<const std::byte>(buffer).first(size), sent);
      size += *more;
      const auto bytes = std::span<const std::byte>(buffer).first(size);
      found = find_rtu_answer(request, bytes);
      if (is_echo(request, found, bytes, sent)) return failure(FaultKind::corrupted, "", kEchoMessage);
      if (found.answer && (has_no_echo_ || !is_proper_prefix(frame_bytes(bytes, found), sent)))
        return accept(std::move(found), bytes, sent);
    }
    return failure(FaultKind::corrupted, "", fmt::format("no reply among {} bytes", size));
  }

  [[nodiscard]] static std::span<const std::byte> frame_bytes(std::span<const std::byte> bytes,
                                                              const RtuFinding& found) {
    return bytes.subspan(found.begin, found.end - found.begin);
  }

  /// Returns whether `bytes` contain an echo of the request. If the answer equals the request, as for some writes, the
  /// first matching frame is an echo only if a second one, from the unit, follows.
  [[nodiscard]] bool is_echo(const ModbusRequest& request, const RtuFinding& found, std::span<const std::byte> bytes,
                             std::span<const std::byte> sent) const {
    if (!found.answer || !std::ranges::equal(frame_bytes(bytes, found), sent)) return contains(bytes, sent);
    return !has_no_echo_ && find_rtu_answer(request, bytes.subspan(found.end)).answer.has_value();
  }

  /// Evaluates the received bytes when no more bytes arrived in time.
  [[nodiscard]] Result<ModbusAnswer> finish_reply(RtuFinding found, std::span<const std::byte> bytes,
                                                  std::span<const std::byte> sent) {
    if (found.answer) return accept(std::move(found), bytes, sent);
    if (bytes.empty())
      return failure(FaultKind::timeout, "", fmt::format("no reply in {} ms", timeout_ / milliseconds(1)));
    if (found.has_partial_frame || found.fault.what.empty())
      return failure(FaultKind::corrupted, "", fmt::format("the reply ends after {} bytes", bytes.size()));
    return failure(std::move(found.fault));
  }

  /// Accepts an answer. If at least as many bytes as the shortest answer follow it, an older answer may be among them.
  [[nodiscard]] Result<ModbusAnswer> accept(RtuFinding found, std::span<const std::byte> bytes,
                                            std::span<const std::byte> sent) {
    const auto frame = frame_bytes(bytes, found);
    has_no_echo_ = has_no_echo_ || !std::ranges::equal(frame, sent.first(std::min(frame.size(), sent.size())));
    answer_may_come_late_ = bytes.size() - found.end >= kShortestRtuAnswer;
    return std::move(*found.answer);
  }

  std::unique_ptr<ByteStream> stream_;
  std::string place_;
  std::uint8_t unit_;
  Duration timeout_, piece_gap_, silence_;
  bool loop_back_;
  /// The line echoes requests, and the stream discards the echo.
  bool stream_removes_echo_;
  /// An answer has shown that the line does not echo, or the stream removes the echo.
  bool has_no_echo_;
  const Clock* clock_;
  /// True at the start, because another client may have used the line.
  bool answer_may_come_late_ = true;
  /// End of the time in which an answer to the last request may arrive.
  Deadline late_answers_;
  Pace pace_;
  /// Number sent in the latest loop-back request.
  std::uint16_t last_number_ = 0;
};

}  // namespace

Duration silence_between_frames(const ModbusLink& link) {
  if (link.gap > Duration::zero()) return link.gap;
  if (link.serial.baud > kFixedSilenceBaud) return kFixedSilence;
  return 7 * character_time(link.serial) / 2;
}

std::unique_ptr<ModbusLine> make_modbus_rtu(std::unique_ptr<ByteStream> stream, std::string place,
                                            const ModbusLink& link, const Clock* clock) {
  return std::make_unique<ModbusRtu>(std::move(stream), std::move(place), link, clock);
}

}  // namespace gyrotherm::drivers
