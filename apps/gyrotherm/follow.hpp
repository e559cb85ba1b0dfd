// SPDX-License-Identifier: Apache-2.0
/// Printing of a running record, row by row, through its live copy.
#pragma once

#include <string>

#include "apps/console/console.hpp"
#include "core/result.hpp"

namespace gyrotherm::app {

/// Prints the existing rows in the format of `export`, then each new second, until the run has ended or Ctrl-C is
/// pressed. A closed record is printed completely. `path` may also be the path of the live copy. Fails like
/// read_record(), also if a record that is being written has no live copy of its run, and with bad_file if another run
/// replaces it meanwhile.
[[nodiscard]] Result<void> follow_record(Console& console, const std::string& path);

}  // namespace gyrotherm::app
