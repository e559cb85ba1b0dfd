// SPDX-License-Identifier: Apache-2.0
/// Prints the rows of a record while a run writes it, through its live copy.
#pragma once

#include <string>

#include "apps/console/console.hpp"
#include "core/result.hpp"

namespace gyrotherm::app {

/// Prints the existing rows in the format of `export`, then each new second, until the run has ended or Ctrl-C is
/// pressed. A closed record is printed completely. `path` may also be the path of the live copy. Fails like
/// read_record(), also if the record is being written and has no live copy. Fails with bad_file if another run replaces
/// the record meanwhile.
[[nodiscard]] Result<void> follow_record(Console& console, const std::string& path);

}  // namespace gyrotherm::app
