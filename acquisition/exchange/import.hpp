// SPDX-License-Identifier: Apache-2.0
/// How a foreign file becomes a record.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/exchange/bytes.hpp"
#include "acquisition/exchange/channel_summary.hpp"
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
  std::size_t rows{};       ///< in the record
  std::size_t file_rows{};  ///< in the file
  std::size_t lines_left_out{}, rows_left_out{};
  Duration span{};                    ///< from the first row to the last
  Duration step{};                    ///< usual spacing of the record's rows
  std::optional<Duration> started{};  ///< UTC of the first row
  std::size_t silences{};             ///< stretches that miss rows
  Notes notes{};                      ///< sentences for people
  std::vector<ChannelSummary> channels{};
};

/// Makes a finished record at `record_path` of the file at `path`, as the map at `map_path` says: each row at its own
/// time, its slot the row's number from 0, no segments and no cycles; in UTC where the file knows it. Missing stretches
/// (spacings longer than 10 times the usual one; where rows are put together, stretches without any), what was passed
/// over, and what values each channel has, are told in events of the last row. `goes_on` is asked at each row, `utc` is
/// the time of the import. Fails with bad_file (`file:line:column: what, what was expected`), also where the values, or
/// the time by another column of dates, show that the map is not the file's; with storage (the record exists) or
/// interrupted; then nothing is left.
[[nodiscard]] Result<ImportSummary> import_record(
    const std::string& path, const std::string& map_path, const std::string& record_path,
    const std::string& program_version, const std::function<bool()>& goes_on = [] { return true; },
    std::optional<Duration> utc = {});

}  // namespace gyrotherm::exchange
