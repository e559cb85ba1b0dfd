// SPDX-License-Identifier: Apache-2.0
/// A program that drives the chamber under its own guard until it is killed, and a line to the chamber that can be cut.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <memory>
#include <string>

#include "core/child_process.hpp"
#include "core/file.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"
#include "drivers/instruments.hpp"
#include "drivers/line/line_address.hpp"
#include "drivers/wires.hpp"
#include "sequencer/rig/rig_file.hpp"

namespace gyrotherm::prove {

/// Opens a connection to the chamber of a real rig, as its registers and as a chamber.
[[nodiscard]] std::unique_ptr<drivers::Registers> connect_registers(const rig::RigFile& rig);
[[nodiscard]] std::unique_ptr<drivers::Chamber> connect_chamber(const rig::RigFile& rig);

/// A chamber and the registers below it, on one connection, because a serial line can be opened only once and some
/// controllers accept only one client.
struct ChamberConnection {
  std::shared_ptr<drivers::Registers> registers;
  std::unique_ptr<drivers::Chamber> chamber;
};
[[nodiscard]] ChamberConnection connect_with_registers(const rig::RigFile& rig);

/// Returns whether only one program at a time can use the chamber's line.
[[nodiscard]] bool is_exclusive_line(const rig::RigFile& rig);

class DrivenChild {
 public:
  /// Starts a child that takes the chamber's lock, arms the guard, sends the set point, and then reads the chamber each
  /// second with a heartbeat. Waits until the chamber shows the child this set point. Fails with the child's fault.
  /// `record` names the files of the guard; no record is written. The child dies with this process.
  [[nodiscard]] static Result<DrivenChild> start(const rig::RigFile& rig, const std::string& record, Celsius set_point);

  /// Kills the child by SIGKILL. The guard then makes the chamber safe.
  void kill() { child_.reset(); }

 private:
  explicit DrivenChild(std::unique_ptr<ChildProcess> child) : child_(std::move(child)) {}
  std::unique_ptr<ChildProcess> child_;
};

/// Forwards connections on a port of this machine to a TCP line, in a process of its own. If this process dies, the
/// forwarder ends a cut and continues, because a guard may still need the line; it ends when the line was not used for
/// some minutes.
class CuttableLine {
 public:
  /// Fails with disconnected if no port or process is available.
  [[nodiscard]] static Result<CuttableLine> open(const drivers::TcpLine& to);
  /// Ends the forwarder.
  ~CuttableLine();
  CuttableLine(CuttableLine&&) noexcept = default;
  CuttableLine& operator=(CuttableLine&&) = delete;

  [[nodiscard]] std::uint16_t port() const { return port_; }
  /// From now on no byte is forwarded, as on a line that was pulled out: connections are accepted and stay silent.
  void cut();
  /// Drops all connections and forwards new ones.
  void restore();
  /// Leaves the forwarder to a guard that still needs the line. It ends when the line was not used for some minutes.
  void leave_to_guard() { control_.close(); }

 private:
  CuttableLine(Descriptor control, pid_t pid, std::uint16_t port)
      : control_(std::move(control)), pid_(pid), port_(port) {}
  void send(char command);

  Descriptor control_;
  pid_t pid_ = -1;
  std::uint16_t port_{};
};

}  // namespace gyrotherm::prove
