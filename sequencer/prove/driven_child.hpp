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

class DrivenChild {
 public:
  /// Starts a child that takes the chamber's lock, arms the guard, sends the set point, and then reads the chamber each
  /// second with a heartbeat. Waits until it drives. Fails with the child's fault. `record` names the files of the
  /// guard; no record is written. The child dies with this process.
  [[nodiscard]] static Result<DrivenChild> start(const rig::RigFile& rig, const std::string& record, Celsius set_point);

  /// Kills the child by SIGKILL. The guard then makes the chamber safe.
  void kill() { child_.reset(); }

 private:
  explicit DrivenChild(std::unique_ptr<ChildProcess> child) : child_(std::move(child)) {}
  std::unique_ptr<ChildProcess> child_;
};

/// Forwards connections on a port of this machine to a TCP line, in a process of its own.
class CuttableLine {
 public:
  /// Fails with disconnected if no port is available.
  [[nodiscard]] static Result<CuttableLine> open(const drivers::TcpLine& to);
  [[nodiscard]] std::uint16_t port() const;
  /// From now on no byte is forwarded, as on a line that was pulled out: connections are accepted and stay silent.
  void cut();
  /// Drops all connections and forwards new ones.
  void restore();

 private:
  CuttableLine(Descriptor listener, drivers::TcpLine to) : listener_(std::move(listener)), to_(std::move(to)) {}
  void forward();

  Descriptor listener_;
  drivers::TcpLine to_;
  std::unique_ptr<ChildProcess> forwarder_;
  pid_t pid_ = -1;
};

}  // namespace gyrotherm::prove
