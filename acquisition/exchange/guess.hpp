// SPDX-License-Identifier: Apache-2.0
/// Detects the format of a file of another program, and drafts an import map that users can correct.
#pragma once

#include <string>
#include <string_view>

#include "acquisition/exchange/bytes.hpp"
#include "acquisition/exchange/import_map.hpp"
#include "core/result.hpp"

namespace gyrotherm::exchange {

/// Detects the format of a file from its first bytes, without advancing. Returns FileFormat::text for an unknown one.
/// Fails with bad_file if the file cannot be read or has a known format that is not supported. In the second case the
/// fault explains how to convert the file.
[[nodiscard]] Result<FileFormat> detect_format(Bytes& bytes);

/// Returns the text of a draft map, detected from the names of a file's columns and from the first rows of a table: the
/// notation of the table, the time column and its unit, the thermometers, the axes of the gyro. The map has a comment
/// at each uncertain line, and lists all columns of the file. Fails as detect_format() does, and with bad_file if the
/// file is neither a log nor a text table with at least two columns.
[[nodiscard]] Result<std::string> guess_map(const std::string& path);

/// Does the same for a file in memory. `name` is the file's name in the map and in faults.
[[nodiscard]] Result<std::string> guess_map_from_bytes(std::string_view bytes, const std::string& name);

}  // namespace gyrotherm::exchange
