// SPDX-License-Identifier: Apache-2.0
/// Reads rows, or a text, with a third-party library in a separate process with limits. A crash, a hang or excessive
/// memory use of the library becomes a fault.
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

/// Limits of a reader that reads in steps (see ReadInSteps). One step opens the file or reads part of one column. The
/// size of the file is not limited.
struct ReadingLimits {
  std::uint64_t memory_bytes = std::uint64_t{1} << 30;
  std::chrono::seconds processor_time{10};     ///< per step of the reader
  Duration silence = std::chrono::minutes(5);  ///< longest wait for the next row
};

/// Reads rows and passes them to `take`. Calls `step` at the start of each step.
using ReadInSteps = std::function<Result<void>(const TakeRow& take, const std::function<void()>& step)>;

/// Runs `read` for the file at `path` in a confined child process (core/child_process.hpp) and passes its rows to
/// `take`. Adds the position of the row to a fault of `take` that has none. Fails as `read` and `take` do. Fails with
/// bad_file, naming `library`, if the child crashed, exceeded a limit, wrote a file, or sent anything other than rows.
/// Fails with storage if no child process can be started.
[[nodiscard]] Result<void> read_confined(const std::string& path, const std::string& library, std::size_t columns,
                                         const ReadInSteps& read, const TakeRow& take,
                                         const ReadingLimits& limits = {});

/// Reads a text about a file, of at most 64 KiB. Calls `step` at the start of each step.
using ReadTextInSteps = std::function<Result<std::string>(const std::function<void()>& step)>;

/// Runs `read` for the file at `path` as read_confined() does, and returns its text. Fails as read_confined() does.
[[nodiscard]] Result<std::string> read_text_confined(const std::string& path, const std::string& library,
                                                     const ReadTextInSteps& read, const ReadingLimits& limits = {});

}  // namespace gyrotherm::exchange
