// SPDX-License-Identifier: Apache-2.0
/// TCP sockets that listen. No call waits for a client.
#pragma once

#include <cstdint>
#include <string>

#include "core/file.hpp"
#include "core/result.hpp"

namespace gyrotherm {

/// Returns a socket that listens at `address`, a numeric address or a name of this machine, and does not block. Port 0
/// takes any free port. `backlog`: the most connections that wait to be accepted. Fails with disconnected if the
/// address or the port is not available.
[[nodiscard]] Result<Descriptor> listen_on_tcp(const std::string& address, std::uint16_t port, int backlog);

/// Returns the port of a socket that listens, IPv4 or IPv6.
[[nodiscard]] std::uint16_t port_of(const Descriptor& listener);

/// Returns the next connection that waits, as a socket that does not block; a closed one with errno if none does.
[[nodiscard]] Descriptor accept_connection(const Descriptor& listener);

}  // namespace gyrotherm
