// SPDX-License-Identifier: Apache-2.0
/// In-memory lines between a virtual instrument and its single client, without descriptors, waiting or system calls.
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

/// A buffer of bytes in one direction.
class MemoryPipe {
 public:
  /// Capacity in bytes, about as large as a socket's buffer.
  static constexpr std::size_t kCapacity = std::size_t{1} << 18;

  [[nodiscard]] std::size_t size() const { return bytes_.size() - taken_; }
  /// Appends all bytes. Returns false and appends nothing if they do not fit.
  [[nodiscard]] bool put(std::span<const std::byte> bytes);
  /// Moves bytes into `buffer` up to its size. Returns their number.
  std::size_t take(std::span<std::byte> buffer);

 private:
  std::vector<std::byte> bytes_;
  /// Bytes already taken from the front.
  std::size_t taken_{};
};

/// State shared by the two ends of a line: both directions, and whether the instrument is open.
struct MemoryConnection {
  MemoryPipe to_client, to_instrument;
  bool open = true;
};

/// Makes the instrument's end of a new connection. Called at the first use of a line, and again after the line has
/// broken.
using ConnectInMemory = std::function<std::shared_ptr<MemoryConnection>()>;

/// Returns a line to an instrument that sends and receives when time passes. Reading does not wait: missing bytes
/// arrive only when time passes. Use it on the thread that advances the time.
[[nodiscard]] std::unique_ptr<drivers::ByteStream> make_memory_line(ConnectInMemory connect);

/// Returns a line to an instrument that answers on the calling thread before the write returns. The session is made and
/// fed while `laboratory_guard` is held. `laboratory_guard` must outlive the line.
[[nodiscard]] std::unique_ptr<drivers::ByteStream> make_answering_line(MakeSession make_session,
                                                                       std::mutex& laboratory_guard);

}  // namespace gyrotherm::simulator
