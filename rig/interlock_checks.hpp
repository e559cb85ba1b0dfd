/// What the interlocks look for in one sample; parts of judge(), and pure like it.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "rig/interlocks.hpp"

namespace gyrotherm {

struct Finding {
  std::string text;
  bool grave = false;  ///< ends the run whatever the policy is
};
using Findings = std::array<std::optional<Finding>, kCauses>;

/// The trends with this sample in them.
void remember(const InterlockLimits& limits, const Sample& sample, Duration elapsed, const Circumstances& circumstances,
              InterlockMemory& memory);

/// `memory` remembers this sample too, but for chamber_answered and the clocks, which are the sample before's.
[[nodiscard]] Findings look_for_causes(const InterlockLimits& limits, const InterlockMemory& memory,
                                       const Sample& sample, const Circumstances& circumstances);

}  // namespace gyrotherm
