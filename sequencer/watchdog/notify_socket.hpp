/// What a service tells systemd that started it, in the few words of sd_notify(3), over the socket that it was given.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "drivers/line/descriptor.hpp"

namespace gyrotherm {

class NotifySocket {
 public:
  /// Of the environment (NOTIFY_SOCKET); nothing where systemd did not start this program.
  [[nodiscard]] static std::optional<NotifySocket> from_environment();
  /// At `address`: a path, or "@NAME" for an abstract one. Nothing if it is too long.
  [[nodiscard]] static std::optional<NotifySocket> at(std::string address);

  /// "READY=1", "WATCHDOG=1", "STATUS=…", "STOPPING=1". Never blocks; what cannot be told is not told.
  void tell(std::string_view state);

 private:
  NotifySocket(Descriptor socket, std::string address) : socket_(std::move(socket)), address_(std::move(address)) {}
  Descriptor socket_;
  std::string address_;
};

}  // namespace gyrotherm
