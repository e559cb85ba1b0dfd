/// How a temperature has moved: over the last minute, and whether it moves at all.
#pragma once

#include <array>
#include <optional>

#include "core/quantity.hpp"

namespace gyrotherm {

class Trend {
 public:
  /// One second's value, or nothing.
  void add(std::optional<Celsius> value);
  /// Time has passed unseen.
  void forget();

  /// Of the last minute; nothing before it is known at both ends.
  [[nodiscard]] std::optional<CelsiusPerMinute> rate() const;

  /// `others`: what the rest shows now. How long the value has not changed by a millikelvin, and how far the others
  /// have moved meanwhile.
  void compare(std::optional<Celsius> others);
  [[nodiscard]] int unchanged_samples() const { return unchanged_; }
  [[nodiscard]] Kelvins others_moved() const { return others_moved_; }

 private:
  static constexpr int kSeconds = 60;
  std::array<double, kSeconds + 1> ring_{};  ///< NaN: not known
  int filled_ = 0, newest_ = -1;
  std::optional<Celsius> still_;  ///< the value that does not change
  int unchanged_ = 0;
  std::optional<Celsius> others_then_;
  Kelvins others_moved_{};
};

}  // namespace gyrotherm
