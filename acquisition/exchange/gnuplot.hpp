// SPDX-License-Identifier: Apache-2.0
/// Exports a record as a gnuplot script that includes its data: temperatures above, rates below, over hours.
#pragma once

#include <string>

#include "acquisition/record/record.hpp"

namespace gyrotherm::exchange {

/// Returns the script; `gnuplot -p FILE` shows it. The title of a simulated record contains SIMULATED. Names of
/// channels and of the profile are quoted, so they cannot contain commands.
[[nodiscard]] std::string gnuplot_script(const record::Record& record);

}  // namespace gyrotherm::exchange
