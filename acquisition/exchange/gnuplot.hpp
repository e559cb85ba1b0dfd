// SPDX-License-Identifier: Apache-2.0
/// A record as a script for gnuplot that has its data in it: temperatures above, rates below, against hours.
#pragma once

#include <string>

#include "acquisition/record/record.hpp"

namespace gyrotherm::exchange {

/// The script; `gnuplot -p FILE` shows it. One of virtual instruments says SIMULATED in its title. Names of channels
/// and of the profile are text in it and nothing else.
[[nodiscard]] std::string gnuplot_script(const record::Record& record);

}  // namespace gyrotherm::exchange
