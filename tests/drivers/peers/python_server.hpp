// SPDX-License-Identifier: Apache-2.0
/// Runs tests/drivers/peers/pymodbus_server.py as a child process.
#pragma once

#include <signal.h>
#include <stdio.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <stdexcept>
#include <string>

namespace gyrotherm::drivers {

[[nodiscard]] inline bool pymodbus_is_installed() {
  return std::system("/usr/bin/python3 -c 'import pymodbus.server' > /dev/null 2>&1") == 0;
}

class PythonServer {
 public:
  /// Starts the server. `kind` is "tcp", or "rtu" with a device.
  explicit PythonServer(const std::string& kind, const std::string& device = "") {
    std::array<int, 2> out{};
    if (pipe(out.data()) != 0) throw std::runtime_error("no pipe");
    child_ = fork();
    if (child_ == 0) {
      dup2(out[1], STDOUT_FILENO);
      for (int other = 3; other < 256; ++other) close(other);
      const auto* script = GYROTHERM_SOURCE_DIR "/tests/drivers/peers/pymodbus_server.py";
      execl("/usr/bin/python3", "python3", script, kind.c_str(), device.c_str(), nullptr);
      _exit(127);
    }
    close(out[1]);
    auto* lines = fdopen(out[0], "r");
    int port = 0;
    if (fscanf(lines, "READY %d", &port) != 1) throw std::runtime_error("the pymodbus server did not start");
    fclose(lines);
    port_ = static_cast<std::uint16_t>(port);
  }
  ~PythonServer() {
    kill(child_, SIGKILL);
    waitpid(child_, nullptr, 0);
  }
  PythonServer(const PythonServer&) = delete;
  PythonServer& operator=(const PythonServer&) = delete;

  [[nodiscard]] std::uint16_t port() const { return port_; }

 private:
  pid_t child_ = -1;
  std::uint16_t port_{};
};

/// Returns the content of a register in that server.
[[nodiscard]] inline std::uint16_t pymodbus_register(unsigned address) {
  return static_cast<std::uint16_t>(address * 40503u);
}

}  // namespace gyrotherm::drivers
