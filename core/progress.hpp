/// How a long computation tells where it stands, and is asked to stop.
#pragma once

#include <functional>
#include <string_view>

namespace gyrotherm {

/// Called now and then with a stage name and the fraction done (0…1); returning false asks for a clean stop,
/// upon which the computation fails with FaultKind::interrupted. May be called from any thread, never from two at once.
using ProgressSink = std::function<bool(std::string_view stage, double fraction)>;

[[nodiscard]] inline bool keep_going(const ProgressSink& sink, std::string_view stage, double fraction) {
  return !sink || sink(stage, fraction);
}

}  // namespace gyrotherm
