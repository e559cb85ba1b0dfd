// SPDX-License-Identifier: Apache-2.0
/// The noise of a channel, learned from its own readings, and how improbable it is that noise alone leaves readings
/// identical. Values; any thread.
#pragma once

#include <limits>
#include <optional>

namespace gyrotherm::interlocks {

class Noise {
 public:
  /// Adds a reading. `at_rest`: the quantity is not asked to change, so that what changes is noise.
  void add(double value, bool at_rest);

  /// Returns how many readings have been identical to the one before them, up to the last one.
  [[nodiscard]] int identical() const { return identical_; }
  /// Returns −ln of the probability that noise alone makes so many readings identical; 0 while no noise is known.
  [[nodiscard]] double improbability() const;

 private:
  std::optional<double> last_;
  double last_change_{};
  /// The smallest change seen: the resolution, or more.
  double step_ = std::numeric_limits<double>::infinity();
  /// The share of readings at rest that reverse the last change by two steps or more. Noise of such a size does not
  /// vanish between two steps of the resolution, wherever the quantity is.
  double share_{};
  int identical_{}, identical_at_rest_{};
};

}  // namespace gyrotherm::interlocks
