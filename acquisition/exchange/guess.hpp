// SPDX-License-Identifier: Apache-2.0
/// The format of a foreign file, and a first map of it for people to correct.
#pragma once

#include <string>
#include <string_view>

#include "acquisition/exchange/bytes.hpp"
#include "acquisition/exchange/import_map.hpp"
#include "core/result.hpp"

namespace gyrotherm::exchange {

/// Detects the format of a file by its first bytes, without passing them. Returns FileFormat::text for an unknown one.
/// Fails with bad_file if the file cannot be read, or has a known format that is not read here; the fault says how to
/// convert it.
[[nodiscard]] Result<FileFormat> detect_format(Bytes& bytes);

/// Returns the text of an import map, guessed from the names of a file's columns and from the first rows of a table:
/// the notation of the table, the column of the time and its unit, the thermometers, the axes of the gyro. The map has
/// a comment wherever a guess may be wrong, and all columns that the file has. Fails as detect_format() does, and with
/// bad_file if the file is neither a text table of two columns or more nor a log.
[[nodiscard]] Result<std::string> guess_map(const std::string& path);

/// Does the same for a file in memory. `name` stands for its file in the map and in faults.
[[nodiscard]] Result<std::string> guess_map_of(std::string_view bytes, const std::string& name);

}  // namespace gyrotherm::exchange
