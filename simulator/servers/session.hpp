/// One client's conversation with a virtual instrument, as a function of bytes: no socket, no clock.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace gyrotherm {

class Session {
 public:
  virtual ~Session() = default;
  /// Takes what came from the client, in any pieces, and appends what the instrument answers. False: what came cannot
  /// be the protocol, and the client is to be dropped.
  [[nodiscard]] virtual bool feed(std::span<const std::byte> bytes, std::vector<std::byte>& reply) = 0;
};

using MakeSession = std::function<std::unique_ptr<Session>()>;

}  // namespace gyrotherm
