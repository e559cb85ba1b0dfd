// SPDX-License-Identifier: Apache-2.0
/// Foreign records in: the map that says what a text table's columns are, the table's rows, and the record made of
/// them.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/record/run_info.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm::record {

// How a foreign text table is to be read: which column is the time, which are thermometers, which are the gyros'
// axes and own values, and in what units (`profiles/imports/*.toml`, schema gyrotherm-import/1).

inline constexpr const char* kImportSchema = "gyrotherm-import/1";

/// A column by its name in the header (blanks at either end do not count), or by its number from 1 in a file without
/// one.
struct ColumnName {
  std::string name{};
  std::size_t number{};
};

struct ImportMap {
  std::string name;
  std::string text;  ///< the map itself, kept with the record

  char separator = ',';  ///< comma, semicolon, tab or blank (any run of them)
  std::string comment;   ///< lines that begin with it do not count; empty: there are none
  bool header = true;
  std::size_t skip{};  ///< lines after the header (or from the start) that are no rows

  /// Rows have their own time, in units of `time_unit`; or each row lasts `interval`.
  std::optional<ColumnName> time;
  Duration time_unit{};
  Duration interval{};

  /// A column of something that is stored in a unit of its own: number × scale + offset.
  struct ScaledColumn {
    ColumnName column;
    double scale = 1;
    double offset = 0;
  };
  std::vector<std::string> thermometers;
  std::vector<ScaledColumn> thermometer_columns;  ///< of each, in °C

  /// The units under test of the file, each with its axes and values. An axis' number is stored as it is: rate: `scale`
  /// °/h per unit; pulse_count (increments): `scale` arcsec per unit; all of them are the one or the other.
  std::vector<UnitInfo> units;
  std::vector<ColumnName> axis_columns;     ///< of all units' axes, in order
  std::vector<ScaledColumn> value_columns;  ///< … and values
};

/// Fails with bad_file: all mistakes at once, each with file:line:column.
[[nodiscard]] Result<ImportMap> parse_import_map(std::string_view text, const std::string& file);

/// Fails also if the file cannot be read.
[[nodiscard]] Result<ImportMap> load_import_map(const std::string& path);

// A foreign text table, read by its map.

/// Columns of equal length, one row per row of the file.
struct ForeignRows {
  std::vector<Duration> time;                       ///< since the first row, strictly increasing
  std::vector<Duration> interval;                   ///< what a gyro's number covers
  std::vector<std::vector<double>> thermometers_c;  ///< per thermometer of the map
  std::vector<std::vector<double>> rotation;        ///< per axis of the map, as in the file
  std::vector<std::vector<double>> values;          ///< per value of the map
};

/// Reads every row. Lines may end with LF or CRLF, a byte order mark is allowed, empty lines do not count; numbers have
/// a decimal point. A row's interval is the map's; where rows have times of their own it is their median spacing for a
/// rate, and for an increment the time since the row before (the first row: the median). Fails with bad_file at the
/// first mistake, as `file:line:column: what, what was expected`; also if there is no row, or where a line has more
/// than kLongestLine bytes or kMostFields fields (csv.hpp).
[[nodiscard]] Result<ForeignRows> parse_foreign_rows(std::string_view text, const ImportMap& map,
                                                     const std::string& file);

/// Spacings longer than 10 times the median one: the record misses rows there.
struct Silences {
  Duration median;  ///< spacing
  std::size_t count{};
  Duration total{};           ///< the sum of these spacings
  std::size_t first_after{};  ///< the row, from 0, after which the first of them comes
  Duration first{};
};
[[nodiscard]] Silences find_silences(const std::vector<Duration>& time);

// How a foreign table becomes a record.

struct ImportSummary {
  std::size_t rows{};
  Duration span{};         ///< from the first row to the last
  std::size_t silences{};  ///< spacings longer than 10 times the median one
};

/// Makes a finished record at `record_path` of the text table at `table_path`, as the map at `map_path` says: each row
/// at its own time, its slot the row's number from 0, no segments and no cycles; missing stretches are told in an
/// event. Fails with bad_file (`file:line:column: what, what was expected`) or storage (the record exists); then
/// nothing is left.
[[nodiscard]] Result<ImportSummary> import_record(const std::string& table_path, const std::string& map_path,
                                                  const std::string& record_path, const std::string& program_version);

}  // namespace gyrotherm::record
