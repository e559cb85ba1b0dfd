// SPDX-License-Identifier: Apache-2.0
/// Rows that a library of others reads, in a process of its own with limits: its crash, hang or hunger is one fault.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

#include "acquisition/exchange/foreign_row.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm::exchange {

/// Limits of a reader. A step lasts from one call of its function `step` to the next: it opens the file, or reads a
/// part of one column. Files may be larger than any of these limits.
struct ReadingLimits {
  std::uint64_t memory_bytes = std::uint64_t{1} << 30;
  std::chrono::seconds processor_time{10};     ///< for one step
  Duration silence = std::chrono::minutes(5);  ///< between two rows
};

/// Reads rows of `columns` numbers and hands them on; calls `step` before each step.
using ReadInSteps = std::function<Result<void>(const TakeRow& take, const std::function<void()>& step)>;

/// Has `read` read the file at `path` in a confined child (core/child_process.hpp) and hands its rows on to `take`,
/// each fault of `take` that has no place with the place of the row. Fails as `read` and `take` do; with bad_file,
/// naming `library`, if the child crashed, used more than its limits, wrote a file, was silent for too long, or wrote
/// something other than rows; with storage if no child can be started.
[[nodiscard]] Result<void> read_confined(const std::string& path, const std::string& library, std::size_t columns,
                                         const ReadInSteps& read, const TakeRow& take,
                                         const ReadingLimits& limits = {});

}  // namespace gyrotherm::exchange
