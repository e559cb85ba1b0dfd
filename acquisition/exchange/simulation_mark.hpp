// SPDX-License-Identifier: Apache-2.0
/// Reads the mark SIMULATED of a file that gyrotherm exported, so that a record imported from it has the mark, too.
#pragma once

#include <string>
#include <vector>

#include "acquisition/exchange/import_map.hpp"
#include "core/result.hpp"

namespace gyrotherm::exchange {

/// Returns the titles of the virtual instruments that a file of the given format names in its mark: the global
/// attribute `source` of a NetCDF file, or one of the first 50 lines of a text. Returns "all those of FILE" if the mark
/// names none, and nothing if the file has no mark. Fails with bad_file if the file cannot be read.
[[nodiscard]] Result<std::vector<std::string>> read_simulation_mark(const std::string& path, FileFormat format);

}  // namespace gyrotherm::exchange
