// SPDX-License-Identifier: Apache-2.0
/// A first map of a foreign file, for people to correct.
#pragma once

#include <string>
#include <string_view>

#include "core/result.hpp"

namespace gyrotherm::exchange {

/// The text of an import map, guessed from the names of a file's columns and from the first rows of a table: how the
/// table is written, which column is the time and in which unit, which are thermometers, which are a gyro's axes. It
/// has a comment wherever a guess may be wrong, and all columns that the file has. Fails with bad_file if the file
/// cannot be read, or is neither a text table of two columns or more nor a log that is known.
[[nodiscard]] Result<std::string> guess_map(const std::string& path);

/// The same of a file in memory, which `name` stands for in the map and in faults.
[[nodiscard]] Result<std::string> guess_map_of(std::string_view bytes, const std::string& name);

}  // namespace gyrotherm::exchange
