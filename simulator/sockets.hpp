/// The few socket calls the virtual instruments need: loopback, never blocking, TCP_NODELAY.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/result.hpp"

namespace gyrotherm {

/// A file descriptor that closes itself.
class Socket {
 public:
  explicit Socket(int descriptor = -1) : descriptor_(descriptor) {}
  ~Socket();
  Socket(Socket&& other) noexcept;
  Socket& operator=(Socket&& other) noexcept;

  [[nodiscard]] bool is_open() const { return descriptor_ >= 0; }
  [[nodiscard]] int descriptor() const { return descriptor_; }

 private:
  int descriptor_;
};

/// Listens on 127.0.0.1; port 0 takes any free one. Fails with disconnected.
[[nodiscard]] Result<Socket> listen_on_loopback(std::uint16_t port);
[[nodiscard]] std::uint16_t port_of(const Socket& listener);
/// The next client that waits, or a closed socket if none does.
[[nodiscard]] Socket accept_client(const Socket& listener);
/// Sends all at once; false if the client is gone or too slow to take it.
[[nodiscard]] bool send_now(const Socket& client, std::span<const std::byte> bytes);

}  // namespace gyrotherm
