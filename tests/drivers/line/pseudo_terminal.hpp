// SPDX-License-Identifier: Apache-2.0
/// A pair of pseudo-terminals: the test holds one end, and the driver opens the other.
#pragma once

#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <stdexcept>
#include <string>
#include <string_view>

namespace gyrotherm::drivers {

class PseudoTerminal {
 public:
  PseudoTerminal() : master_(posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC)) {
    std::array<char, 64> name;
    if (master_ < 0 || grantpt(master_) != 0 || unlockpt(master_) != 0 ||
        ptsname_r(master_, name.data(), name.size()) != 0)
      throw std::runtime_error("no pseudo-terminal");
    device_ = name.data();
    termios raw{};
    tcgetattr(master_, &raw);
    cfmakeraw(&raw);
    tcsetattr(master_, TCSANOW, &raw);
  }
  ~PseudoTerminal() { unplug(); }
  PseudoTerminal(const PseudoTerminal&) = delete;
  PseudoTerminal& operator=(const PseudoTerminal&) = delete;

  [[nodiscard]] const std::string& device() const { return device_; }
  [[nodiscard]] int master() const { return master_; }
  void say(std::string_view text) const { (void)!write(master_, text.data(), text.size()); }
  /// Returns the bytes written to the other end, until `ms` pass without one.
  [[nodiscard]] std::string hear(int ms = 200) const {
    std::string heard;
    std::array<char, 4096> buffer;
    pollfd line{master_, POLLIN, 0};
    while (poll(&line, 1, ms) > 0) {
      const auto size = read(master_, buffer.data(), buffer.size());
      if (size <= 0) break;
      heard.append(buffer.data(), static_cast<std::size_t>(size));
    }
    return heard;
  }
  /// Makes the other end see a line with an unplugged adapter.
  void unplug() {
    if (master_ >= 0) close(master_);
    master_ = -1;
  }

 private:
  int master_;
  std::string device_;
};

}  // namespace gyrotherm::drivers
