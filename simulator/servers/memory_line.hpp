// SPDX-License-Identifier: Apache-2.0
/// Lines within the process, from attended instruments to their one client: no descriptor, no wait and no system call.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "drivers/wires.hpp"
#include "simulator/servers/session.hpp"

namespace gyrotherm::simulator {

/// Bytes on their way in one direction.
class MemoryPipe {
 public:
  /// As much as a socket holds.
  static constexpr std::size_t kRoom = std::size_t{1} << 18;

  [[nodiscard]] std::size_t size() const { return bytes_.size() - taken_; }
  /// False, and nothing is taken over, if it has no room for all of them.
  [[nodiscard]] bool put(std::span<const std::byte> bytes);
  /// As many as there are room for in `buffer`; how many that is.
  std::size_t take(std::span<std::byte> buffer);

 private:
  std::vector<std::byte> bytes_;
  std::size_t taken_{};  ///< of them, from the front
};

/// Both directions, and whether the instrument is still there: what the two ends of a line share.
struct MemoryConnection {
  MemoryPipe to_client, to_instrument;
  bool open = true;
};

/// Makes the instrument's end of a new connection; called at the first use of a line and after it broke.
using ConnectInMemory = std::function<std::shared_ptr<MemoryConnection>()>;

/// A line to an instrument that sends when time passes, and hears then what it was sent. Nothing is waited for: what
/// has not come yet will not come before time passes. Used in the thread that lets time pass.
[[nodiscard]] std::unique_ptr<drivers::ByteStream> make_memory_line(ConnectInMemory connect);

/// A line to an instrument that answers in the thread that asks, before the writing returns. The session is made and
/// fed with `laboratory_guard`, which outlives the line, held.
[[nodiscard]] std::unique_ptr<drivers::ByteStream> make_answering_line(MakeSession make_session,
                                                                       std::mutex& laboratory_guard);

}  // namespace gyrotherm::simulator
