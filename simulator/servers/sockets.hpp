/// The few calls the virtual instruments need for their lines: sockets on loopback, pseudo-terminals; never blocking.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

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

/// A serial line in software: what is written to one end comes out of the other.
struct Pty {
  Socket ours;
  Socket theirs;     ///< kept open, so that the line stands while no client does
  std::string path;  ///< of their end, "/dev/pts/3"
};
/// Raw, no echo. Fails with disconnected.
[[nodiscard]] Result<Pty> open_pty();
/// Sends to their end. What nobody took for so long that the line is full is lost, as on a serial line.
void send_now(const Pty& pty, std::span<const std::byte> bytes);

}  // namespace gyrotherm
