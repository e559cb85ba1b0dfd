// SPDX-License-Identifier: Apache-2.0
/// Imports a file of another program as a record.
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

/// Reads a file of another program, in any format, according to its map. Passes on the rows of the record: in order of
/// time, with intervals, and combined if the map requires it. The memory used does not depend on the size of the file.
/// The notes describe skipped content. Fails with bad_file, and as `take` does.
[[nodiscard]] Result<Notes> read_foreign_file(const std::string& path, const ImportMap& map, const TakeImported& take);

/// Does the same for a text in memory, called `name` in faults. Does not read NetCDF.
[[nodiscard]] Result<Notes> read_foreign_text(std::string_view text, const std::string& name, const ImportMap& map,
                                              const TakeImported& take);

/// The result of an import.
struct ImportSummary {
  std::size_t rows{};       ///< in the record
  std::size_t file_rows{};  ///< in the file
  std::size_t lines_left_out{}, rows_left_out{};
  /// Rows of the file with the time of the row before.
  std::size_t repeated_times{};
  /// The time from the first row to the last.
  Duration span{};
  /// The usual spacing of the record's rows.
  Duration step{};
  /// The usual spacing of the distinct times of the file's rows. Unknown for a single time, and for a log whose
  /// messages are combined.
  std::optional<Duration> file_step{};
  /// UTC of the first row.
  std::optional<Duration> started{};
  /// The number of gaps.
  std::size_t gaps{};
  /// Messages about skipped or suspicious content.
  Notes notes{};
  std::vector<ChannelSummary> channels{};
};

/// Imports the file at `path` as a finished record at `record_path`, according to the map at `map_path`. Each row keeps
/// its time, and its UTC if the file has it. The slot of a row is its number, counted from 0. There are no segments and
/// no cycles. Events of the last row report gaps (spacings longer than 10 times the usual one or, for combined rows,
/// stretches without rows), skipped content, and the values of each channel. The import calls `may_continue` for each
/// row and ends if it returns false. `utc` is the time of the import. Fails with bad_file (`file:line:column: what,
/// what was expected`), also if the values or another time column show that the map does not fit the file. Fails with
/// storage if the record exists, and with interrupted if `may_continue` returned false. After a failure no record
/// remains.
[[nodiscard]] Result<ImportSummary> import_record(
    const std::string& path, const std::string& map_path, const std::string& record_path,
    const std::string& program_version, const std::function<bool()>& may_continue = [] { return true; },
    std::optional<Duration> utc = {});

}  // namespace gyrotherm::exchange
