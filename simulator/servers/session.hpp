// SPDX-License-Identifier: Apache-2.0
/// One client's session with a virtual instrument as a function of bytes: no socket, no clock.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/file.hpp"
#include "core/result.hpp"

namespace gyrotherm::simulator {

class Session {
 public:
  virtual ~Session() = default;
  /// Consumes bytes from the client, in pieces of any size, and appends the instrument's answer. Returns false if the
  /// bytes violate the protocol; the client must then be dropped.
  [[nodiscard]] virtual bool feed(std::span<const std::byte> bytes, std::vector<std::byte>& reply) = 0;
};

using MakeSession = std::function<std::unique_ptr<Session>()>;

/// The laboratory's thermometers on an instrument's inputs, by index; empty for an input without a thermometer.
template <std::size_t kCount>
using Inputs = std::array<std::optional<std::size_t>, kCount>;

/// A session of text commands. A command of more than 64 characters is skipped to its end.
class TextSession : public Session {
 public:
  [[nodiscard]] bool feed(std::span<const std::byte> bytes, std::vector<std::byte>& reply) final;

 protected:
  /// Creates a session whose commands end with `end`. Blanks, CR and LF around a command are ignored.
  explicit TextSession(char end) : end_(end) {}

 private:
  /// Returns the whole reply with its terminator, or "" for no reply.
  [[nodiscard]] virtual std::string answer(std::string_view command) const = 0;

  char end_;
  /// Beginning of a command.
  std::string line_;
  /// Set while the remainder of an overlong command is skipped.
  bool line_too_long_{};
};

/// Characters around a command and its argument that are ignored.
inline constexpr std::string_view kBlanks = " \r\n";

// System calls for the lines of virtual instruments: sockets on loopback and pseudo-terminals. None of them blocks.

/// Listens on 127.0.0.1. Port 0 selects a free one. Fails with disconnected.
[[nodiscard]] Result<Descriptor> listen_on_loopback(std::uint16_t port);
/// Returns the next waiting client, or a closed socket if there is none.
[[nodiscard]] Descriptor accept_client(const Descriptor& listener);
/// Sends all bytes without waiting. Returns false if the client has closed or is too slow.
[[nodiscard]] bool send_now(const Descriptor& client, std::span<const std::byte> bytes);

/// A pseudo-terminal: bytes written to one end are read at the other.
struct Pty {
  Descriptor ours;
  /// Kept open, so the line exists without a client.
  Descriptor theirs;
  /// Path of the client's end: "/dev/pts/3".
  std::string path;
};
/// Opens a pseudo-terminal in raw mode without echo. Fails with disconnected.
[[nodiscard]] Result<Pty> open_pty();
/// Sends to the client's end. If the line is full because no client reads, its content is lost, as on a serial line.
void send_now(const Pty& pty, std::span<const std::byte> bytes);

}  // namespace gyrotherm::simulator
