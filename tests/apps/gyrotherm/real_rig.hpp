// SPDX-License-Identifier: Apache-2.0
/// A virtual laboratory in a process of its own, and a real rig file of its lines.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "tests/apps/gyrotherm/program.hpp"

namespace gyrotherm::app {

class RealLaboratory {
 public:
  /// `simulate` serves the default rig; its files are in `folder`.
  explicit RealLaboratory(const std::string& folder);
  /// False if it could not be started; then nothing else is to be used.
  [[nodiscard]] bool serves() const { return !rig_.empty(); }
  [[nodiscard]] const std::string& rig() const { return rig_; }
  [[nodiscard]] const std::string& chamber_port() const { return chamber_port_; }
  /// As mbpoll reads it from the chamber; nothing if it cannot.
  [[nodiscard]] std::optional<double> set_point() const;
  /// Waits until the chamber's set point is `wanted`; how long that took, or nothing after `seconds`.
  [[nodiscard]] std::optional<double> wait_for_set_point(double wanted, double seconds) const;

 private:
  std::unique_ptr<Background> simulate_;
  std::string chamber_port_;
  std::string rig_;
};

/// Where the instrument of that name is served, out of what `simulate` printed: the port, or "".
std::string port_of(const std::string& instrument, const std::string& output);

}  // namespace gyrotherm::app
