/// The few calls the virtual instruments need for their lines: sockets on loopback, pseudo-terminals; never blocking.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "core/result.hpp"
#include "drivers/line/descriptor.hpp"

namespace gyrotherm {

/// Listens on 127.0.0.1; port 0 takes any free one. Fails with disconnected.
[[nodiscard]] Result<Descriptor> listen_on_loopback(std::uint16_t port);
[[nodiscard]] std::uint16_t port_of(const Descriptor& listener);
/// The next client that waits, or a closed socket if none does.
[[nodiscard]] Descriptor accept_client(const Descriptor& listener);
/// Sends all at once; false if the client is gone or too slow to take it.
[[nodiscard]] bool send_now(const Descriptor& client, std::span<const std::byte> bytes);

/// A serial line in software: what is written to one end comes out of the other.
struct Pty {
  Descriptor ours;
  Descriptor theirs;  ///< kept open, so that the line stands while no client does
  std::string path;   ///< of their end, "/dev/pts/3"
};
/// Raw, no echo. Fails with disconnected.
[[nodiscard]] Result<Pty> open_pty();
/// Sends to their end. What nobody took for so long that the line is full is lost, as on a serial line.
void send_now(const Pty& pty, std::span<const std::byte> bytes);

}  // namespace gyrotherm
