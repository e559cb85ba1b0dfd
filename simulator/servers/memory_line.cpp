// SPDX-License-Identifier: Apache-2.0
#include "simulator/servers/memory_line.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <utility>

namespace gyrotherm::simulator {
namespace {

constexpr const char* kLineName = "virtual line";

tl::unexpected<Fault> timeout_fault(Duration within) {
  return failure(FaultKind::timeout, kLineName, fmt::format("no data in {:.3f} s", to_seconds(within)));
}

tl::unexpected<Fault> closed_fault() {
  return failure(FaultKind::disconnected, kLineName, "the peer closed the connection");
}

class SendingLine final : public drivers::ByteStream {
 public:
  explicit SendingLine(ConnectInMemory connect) : connect_(std::move(connect)) {}

  Result<std::size_t> read(std::span<std::byte> buffer, Duration within) override {
    ensure_connection();
    if (const auto size = connection_->to_client.take(buffer); size > 0) return size;
    if (connection_->open) return timeout_fault(within);
    connection_.reset();
    return closed_fault();
  }

  Result<void> write(std::span<const std::byte> bytes, Duration) override {
    ensure_connection();
    if (connection_->open && connection_->to_instrument.put(bytes)) return {};
    connection_.reset();
    return closed_fault();
  }

 private:
  void ensure_connection() {
    if (!connection_) connection_ = connect_();
  }

  ConnectInMemory connect_;
  std::shared_ptr<MemoryConnection> connection_;
};

class AnsweringLine final : public drivers::ByteStream {
 public:
  AnsweringLine(MakeSession make_session, std::mutex& laboratory_guard)
      : make_session_(std::move(make_session)), laboratory_guard_(laboratory_guard) {}

  Result<std::size_t> read(std::span<std::byte> buffer, Duration within) override {
    if (const auto size = answers_.take(buffer); size > 0) return size;
    if (std::exchange(broken_, false)) return closed_fault();
    return timeout_fault(within);
  }

  /// Feeds the session. Bytes that violate the protocol break the line; the next use creates a new session.
  Result<void> write(std::span<const std::byte> bytes, Duration) override {
    answer_.clear();
    const std::scoped_lock lock(laboratory_guard_);
    if (!session_) session_ = make_session_();
    broken_ = !session_->feed(bytes, answer_) || !answers_.put(answer_);
    if (broken_) session_.reset();
    return {};
  }

 private:
  MakeSession make_session_;
  std::mutex& laboratory_guard_;
  std::unique_ptr<Session> session_;
  std::vector<std::byte> answer_;
  MemoryPipe answers_;
  bool broken_{};
};

}  // namespace

bool MemoryPipe::put(std::span<const std::byte> bytes) {
  if (size() + bytes.size() > kCapacity) return false;
  if (taken_ == bytes_.size() || taken_ >= kCapacity) {
    bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(taken_));
    taken_ = 0;
  }
  bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  return true;
}

std::size_t MemoryPipe::take(std::span<std::byte> buffer) {
  const auto count = std::min(buffer.size(), size());
  if (count > 0) std::memcpy(buffer.data(), bytes_.data() + taken_, count);
  taken_ += count;
  return count;
}

std::unique_ptr<drivers::ByteStream> make_memory_line(ConnectInMemory connect) {
  return std::make_unique<SendingLine>(std::move(connect));
}

std::unique_ptr<drivers::ByteStream> make_answering_line(MakeSession make_session, std::mutex& laboratory_guard) {
  return std::make_unique<AnsweringLine>(std::move(make_session), laboratory_guard);
}

}  // namespace gyrotherm::simulator
