// SPDX-License-Identifier: Apache-2.0
/// Listening TCP sockets. No function waits for a client.
#pragma once

#include <cstdint>
#include <string>

#include "core/file.hpp"
#include "core/result.hpp"

namespace gyrotherm {

/// Returns a non-blocking socket that listens at `address`, which is a numeric address or a host name of this machine.
/// Port 0 selects a free port. `backlog` is the maximum number of connections that wait to be accepted. Fails with
/// disconnected if the address or the port is not available.
[[nodiscard]] Result<Descriptor> listen_on_tcp(const std::string& address, std::uint16_t port, int backlog);

/// Returns the port of a listening socket, IPv4 or IPv6.
[[nodiscard]] std::uint16_t listening_port(const Descriptor& listener);

/// Returns the next waiting connection as a non-blocking socket. If no connection waits, returns a closed descriptor
/// with errno set.
[[nodiscard]] Descriptor accept_connection(const Descriptor& listener);

}  // namespace gyrotherm
