/// What the interlocks look for in one sample; parts of judge(), and pure like it.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "sequencer/interlocks/interlocks.hpp"

namespace gyrotherm {

struct CheckResult {
  std::string text;
  bool grave = false;                      ///< ends the run whatever the policy is
  std::optional<std::size_t> column = {};  ///< of the thermometer that shows it
};
struct CheckResults {
  std::array<std::optional<CheckResult>, kCauses> found{};
  std::array<bool, kCauses> hidden{};  ///< what would show the cause, or that it has gone, was not read
};

/// The trends with this sample in them.
void remember(const InterlockLimits& limits, const Sample& sample, Duration elapsed, const InterlockInputs& inputs,
              InterlockMemory& memory);

/// `memory` remembers this sample too, but for chamber_answered and the clocks, which are the sample before's.
[[nodiscard]] CheckResults run_checks(const InterlockLimits& limits, const InterlockMemory& memory,
                                      const Sample& sample, const InterlockInputs& inputs);

}  // namespace gyrotherm
