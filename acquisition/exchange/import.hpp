// SPDX-License-Identifier: Apache-2.0
/// How a foreign file becomes a record.
#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "acquisition/exchange/bytes.hpp"
#include "acquisition/exchange/foreign_row.hpp"
#include "acquisition/exchange/grouping.hpp"
#include "acquisition/exchange/import_map.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm::exchange {

/// Reads a foreign file as its map says, whatever it is, and hands on the rows that a record of it has: in order of
/// time, with intervals, put together. Memory does not grow with the file. Notes say what was passed over. Fails with
/// bad_file, and as `take` does.
[[nodiscard]] Result<Notes> read_foreign_file(const std::string& path, const ImportMap& map, const TakeImported& take);

/// The same of a file's text in memory, which `name` stands for in faults; not of NetCDF, which is read by a library.
[[nodiscard]] Result<Notes> read_foreign_text(std::string_view text, const std::string& name, const ImportMap& map,
                                              const TakeImported& take);

struct ImportSummary {
  std::size_t rows{};
  Duration span{};         ///< from the first row to the last
  std::size_t silences{};  ///< stretches that miss rows
  Notes notes{};           ///< what was passed over
};

/// Makes a finished record at `record_path` of the file at `path`, as the map at `map_path` says: each row at its own
/// time, its slot the row's number from 0, no segments and no cycles; in UTC where the file knows it. Missing stretches
/// (spacings longer than 10 times the usual one; where rows are put together, stretches without any) and what was
/// passed over are told in events of the last row. `goes_on` is asked at each row. Fails with bad_file
/// (`file:line:column: what, what was expected`), storage (the record exists) or interrupted; then nothing is left.
[[nodiscard]] Result<ImportSummary> import_record(
    const std::string& path, const std::string& map_path, const std::string& record_path,
    const std::string& program_version, const std::function<bool()>& goes_on = [] { return true; });

}  // namespace gyrotherm::exchange
