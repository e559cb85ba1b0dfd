// SPDX-License-Identifier: Apache-2.0
/// One client's conversation with a virtual instrument, as a function of bytes: no socket, no clock.
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
  /// Takes what came from the client, in any pieces, and appends what the instrument answers. False: what came cannot
  /// be the protocol, and the client is to be dropped.
  [[nodiscard]] virtual bool feed(std::span<const std::byte> bytes, std::vector<std::byte>& reply) = 0;
};

using MakeSession = std::function<std::unique_ptr<Session>()>;

/// Which of the world's thermometers are on an instrument's inputs, by index; nothing: no thermometer.
template <std::size_t kCount>
using Inputs = std::array<std::optional<std::size_t>, kCount>;

/// A command of more than 64 characters is skipped to its end.
class TextSession : public Session {
 public:
  [[nodiscard]] bool feed(std::span<const std::byte> bytes, std::vector<std::byte>& reply) final;

 protected:
  /// Commands end with `end`; blanks, CR and LF around them do not count.
  explicit TextSession(char end) : end_(end) {}

 private:
  /// The whole reply with its terminator; "": there is none.
  [[nodiscard]] virtual std::string answer(std::string_view command) const = 0;

  char end_;
  std::string line_;      ///< the beginning of a command
  bool line_too_long_{};  ///< what is left of it is skipped
};

/// Around a command and its argument.
inline constexpr std::string_view kBlanks = " \r\n";

// The few calls the virtual instruments need for their lines: sockets on loopback, pseudo-terminals; never blocking.

/// Listens on 127.0.0.1; port 0 takes any free one. Fails with disconnected.
[[nodiscard]] Result<Descriptor> listen_on_loopback(std::uint16_t port);
/// The next client that waits, or a closed socket if none does.
[[nodiscard]] Descriptor accept_client(const Descriptor& listener);
/// A connection within this process: its two ends. Fails with disconnected.
[[nodiscard]] Result<std::pair<Descriptor, Descriptor>> connect_here();
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

}  // namespace gyrotherm::simulator
