// SPDX-License-Identifier: Apache-2.0
/// Fake registers and byte streams. They work until a member function makes them fail.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "drivers/wires.hpp"

namespace gyrotherm::tests {

[[nodiscard]] inline std::vector<std::byte> bytes_of(std::string_view text) {
  const auto* first = reinterpret_cast<const std::byte*>(text.data());
  return {first, first + text.size()};
}

/// Registers of a Modbus unit. An address that was never set is refused as illegal.
class FakeRegisters final : public drivers::Registers {
 public:
  std::map<std::uint16_t, std::uint16_t> words;
  int reads = 0;

  void fall_silent() { broken_ = FaultKind::timeout; }
  void disconnect() { broken_ = FaultKind::disconnected; }
  void recover() { broken_ = kWell, late_ = deaf_ = false; }
  /// Executes writes, but their acknowledgements time out.
  void answer_late() { late_ = true; }
  /// Acknowledges writes without executing them.
  void ignore_writes() { deaf_ = true; }

  Result<std::vector<std::uint16_t>> read(drivers::ReadFunction, std::uint16_t address, std::uint16_t count) override {
    ++reads;
    if (broken_ != kWell) return failure(broken_, "fake", "broken");
    std::vector<std::uint16_t> found;
    for (std::uint16_t i = 0; i < count; ++i) {
      const auto word = words.find(static_cast<std::uint16_t>(address + i));
      if (word == words.end()) return failure(FaultKind::refused, "fake", "exception 2, illegal data address");
      found.push_back(word->second);
    }
    return found;
  }

  Result<void> write(drivers::WriteFunction, std::uint16_t address, std::span<const std::uint16_t> values) override {
    if (broken_ != kWell) return failure(broken_, "fake", "broken");
    for (std::size_t i = 0; i < values.size() && !deaf_; ++i)
      words[static_cast<std::uint16_t>(address + i)] = values[i];
    if (late_) return failure(FaultKind::timeout, "fake", "late");
    return {};
  }

 private:
  /// No failure. Wires never return this kind.
  static constexpr FaultKind kWell = FaultKind::interrupted;
  FaultKind broken_ = kWell;
  bool late_ = false;
  bool deaf_ = false;
};

/// Byte stream to a fake instrument. write() passes the bytes to `instrument` and queues its answer for read(). No call
/// waits.
class FakeStream final : public drivers::ByteStream {
 public:
  std::function<std::string(std::string_view)> instrument = [](std::string_view) { return std::string(); };
  std::vector<std::string> heard;

  void say(std::string_view text) { say(bytes_of(text)); }
  void say(const std::vector<std::byte>& bytes) { waiting_.insert(waiting_.end(), bytes.begin(), bytes.end()); }
  void limit_read_size(std::size_t size) { piece_ = size; }
  void fall_silent() { silent_ = true; }
  /// Answers each query with the answer to the previous one.
  void answer_late() { late_ = true; }
  void garble() { garbled_ = true; }  ///< inverts the top bits
  void disconnect() { gone_ = true; }
  void recover() { silent_ = late_ = garbled_ = gone_ = false; }

  Result<std::size_t> read(std::span<std::byte> buffer, Duration) override {
    if (gone_) return failure(FaultKind::disconnected, "fake", "gone");
    if (waiting_.empty()) return failure(FaultKind::timeout, "fake", "nothing came");
    const auto size = std::min({buffer.size(), piece_, waiting_.size()});
    std::copy_n(waiting_.begin(), size, buffer.begin());
    waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(size));
    return size;
  }

  Result<void> write(std::span<const std::byte> bytes, Duration) override {
    if (gone_) return failure(FaultKind::disconnected, "fake", "gone");
    heard.emplace_back(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (silent_) return {};
    auto answer = bytes_of(instrument(heard.back()));
    for (auto& byte : answer) byte ^= garbled_ ? std::byte{0x80} : std::byte{0};
    if (late_) std::swap(answer, delayed_);
    say(answer);
    return {};
  }

 private:
  std::vector<std::byte> waiting_, delayed_;
  std::size_t piece_ = SIZE_MAX;
  bool silent_ = false, late_ = false, garbled_ = false, gone_ = false;
};

}  // namespace gyrotherm::tests
