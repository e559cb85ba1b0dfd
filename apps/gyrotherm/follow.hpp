// SPDX-License-Identifier: Apache-2.0
/// A running record, followed row by row through its live copy.
#pragma once

#include <string>

#include "apps/console/console.hpp"
#include "core/result.hpp"

namespace gyrotherm::app {

/// Prints the rows that there are as `export` writes them, then each second's as it comes, until the run has ended or
/// Ctrl-C is pressed; the path of the live copy will do. A run that has ended already is printed whole. Fails like
/// read_record(), also where the record is being written and has no live copy of that run, and with bad_file if another
/// run takes its place meanwhile.
[[nodiscard]] Result<void> follow_record(Console& console, const std::string& path);

}  // namespace gyrotherm::app
