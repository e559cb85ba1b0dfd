// SPDX-License-Identifier: Apache-2.0
/// Stream sockets with names in the abstract namespace (unix(7)). A name exists as long as its socket, and depends on
/// no folder and no permission.
#pragma once

#include <sys/socket.h>
#include <sys/un.h>

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "core/file.hpp"

namespace gyrotherm {

struct AbstractAddress {
  sockaddr_un text{};
  socklen_t size{};
  [[nodiscard]] const sockaddr* pointer() const { return reinterpret_cast<const sockaddr*>(&text); }
};

/// Returns the address of a name, which is given without its leading zero byte. Only its first 107 bytes count.
[[nodiscard]] AbstractAddress make_abstract_address(std::string_view name);

/// Returns a text for a name. A text of more than `longest` bytes is replaced by its hash and its last `longest` - 20
/// bytes. `longest` must be at least 20.
[[nodiscard]] std::string shorten_for_name(const std::string& text, std::size_t longest);

/// Opens a stream socket that never blocks. Returns a closed descriptor if that fails.
[[nodiscard]] Descriptor open_stream_socket();

/// Returns the process and user at the other end of a connected local socket; nothing for another descriptor.
/// For a client, they are those that called listen().
[[nodiscard]] std::optional<ucred> read_peer(int socket);

}  // namespace gyrotherm
