// SPDX-License-Identifier: Apache-2.0
/// Other programs, begun without a shell and waited for. For any thread.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm {

/// Where a program stands, and where what it says goes; empty: as with this one.
struct Surroundings {
  std::string folder{};
  std::string output{};  ///< a file that is made anew
  std::string log{};     ///< stderr, and stdout where there is no `output`, at the end of this file
};

/// Begins a program, which is looked for in the path unless its name has a slash, with nothing to read and no signal
/// held back. Fails with refused.
[[nodiscard]] Result<pid_t> start(const std::vector<std::string>& command, const Surroundings& in = {});

/// How it ended: its exit code, or 128 and the number of the signal.
[[nodiscard]] int wait_for(pid_t child);

/// Both; the exit code.
[[nodiscard]] Result<int> run_to_its_end(const std::vector<std::string>& command, const Surroundings& in = {});

/// What a program prints at its stdout, if it ends with 0. Fails with refused and with what it said at its stderr – at
/// its stdout, if that was nothing – or with timeout: it is killed then.
[[nodiscard]] Result<std::string> printed_by(const std::vector<std::string>& command, Duration within);

}  // namespace gyrotherm
