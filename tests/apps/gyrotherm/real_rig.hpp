// SPDX-License-Identifier: Apache-2.0
/// Virtual laboratory in a process of its own, and a real rig file with its lines.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "tests/apps/gyrotherm/program.hpp"

namespace gyrotherm::app {

class RealLaboratory {
 public:
  /// Starts `simulate` with the default rig. Puts its files into `folder`.
  explicit RealLaboratory(const std::string& folder);
  /// Returns whether it was started. If not, use no other function.
  [[nodiscard]] bool serves() const { return !rig_.empty(); }
  [[nodiscard]] const std::string& rig() const { return rig_; }
  [[nodiscard]] const std::string& chamber_port() const { return chamber_port_; }
  /// Returns the chamber's set point as mbpoll reads it, or nothing if that fails.
  [[nodiscard]] std::optional<double> set_point() const;
  /// Waits until the chamber's set point is `wanted`. Returns the duration, or nothing after `seconds`.
  [[nodiscard]] std::optional<double> wait_for_set_point(double wanted, double seconds) const;

 private:
  std::unique_ptr<Background> simulate_;
  std::string chamber_port_;
  std::string rig_;
};

/// Returns the port of an instrument in the output of `simulate`, or "".
std::string find_port(const std::string& instrument, const std::string& output);

}  // namespace gyrotherm::app
