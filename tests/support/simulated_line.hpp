// SPDX-License-Identifier: Apache-2.0
/// Simulated line on which bytes arrive at scheduled times. Its virtual clock advances only while read() waits.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "core/clock.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm::tests {

class SimulatedLine final : public drivers::ByteStream {
 public:
  using Bytes = std::vector<std::byte>;
  /// Called with each request. Calls arrive() to schedule the reply of the instrument.
  std::function<void(std::span<const std::byte> request)> heard = [](auto) {};

  explicit SimulatedLine(VirtualClock& clock) : clock_(clock) {}

  void arrive(Duration after, Bytes bytes) {
    if (!ended_) coming_.emplace(now() + after, std::move(bytes));
  }
  /// Schedules the last bytes. Drops all later ones, including those of further calls of arrive().
  void arrive_last(Duration after, Bytes bytes) {
    const auto at = now() + after;
    coming_.erase(coming_.upper_bound(at), coming_.end());
    coming_.emplace(at, std::move(bytes));
    ended_ = true;
  }
  void disconnect() { gone_ = true; }
  /// Drops all bytes that have not arrived yet, as a closed connection does.
  void lose_pending() { coming_.clear(); }
  void recover() { gone_ = false; }
  [[nodiscard]] bool empty() const { return coming_.empty(); }
  [[nodiscard]] Duration now() const { return clock_.now().since_start; }

  Result<std::size_t> read(std::span<std::byte> buffer, Duration within) override {
    if (gone_) return failure(FaultKind::disconnected, "line", "gone");
    if (coming_.empty() || coming_.begin()->first > now() + within) {
      clock_.advance(within);
      return failure(FaultKind::timeout, "line", "nothing came");
    }
    if (const auto wait = coming_.begin()->first - now(); wait > Duration::zero()) clock_.advance(wait);
    std::size_t size = 0;
    while (size < buffer.size() && !coming_.empty() && coming_.begin()->first <= now())
      size += take(buffer.subspan(size));
    return size;
  }

  Result<void> write(std::span<const std::byte> bytes, Duration) override {
    if (gone_) return failure(FaultKind::disconnected, "line", "gone");
    heard(bytes);
    return {};
  }

 private:
  /// Moves bytes of the earliest arrival into the buffer, as many as fit. Returns their number.
  std::size_t take(std::span<std::byte> buffer) {
    auto& bytes = coming_.begin()->second;
    const auto size = std::min(buffer.size(), bytes.size());
    std::copy_n(bytes.begin(), size, buffer.begin());
    bytes.erase(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
    if (bytes.empty()) coming_.erase(coming_.begin());
    return size;
  }

  VirtualClock& clock_;
  std::multimap<Duration, Bytes> coming_;
  bool gone_ = false, ended_ = false;
};

}  // namespace gyrotherm::tests
