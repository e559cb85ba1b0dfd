/// Independent pieces of work on several threads, with progress and a clean stop.
#pragma once

#include <cstddef>
#include <functional>
#include <string_view>

#include "core/result.hpp"

namespace gyrotherm {

/// Calls `work(i)` for each i below `count`, in any order, on at most `threads` threads (0: all there are). The sink is
/// asked from the calling thread alone; false if it asked to stop, and some of the work was then left out.
[[nodiscard]] bool in_parallel(std::size_t count, int threads, std::string_view stage, const ProgressSink& progress,
                               const std::function<void(std::size_t)>& work);

}  // namespace gyrotherm
