// SPDX-License-Identifier: Apache-2.0
/// The map of a file of another program. It assigns columns to the time, to thermometers, and to the axes and values of
/// gyros, with their units. `docs/importing.md` explains every key.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/exchange/foreign_time.hpp"
#include "acquisition/record/run_info.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm::exchange {

inline constexpr const char* kImportSchema = "gyrotherm-import/1";

/// The format of a file: a text table, a log of PX4 (ULog), a log of ArduPilot (DataFlash), or a NetCDF file.
enum class FileFormat { text, ulog, dataflash, netcdf };

/// Returns the keyword of a format in a map.
[[nodiscard]] const char* name(FileFormat format);

/// A column, given by its name in the header (outer blanks are ignored) or by its number from 1 in a text table. The
/// number is used if it is not 0 and either the name is empty or the table has no header. The name of a log column
/// includes its message: "sensor_gyro.x", "sensor_gyro[1].x", "IMU.GyrX".
struct ColumnName {
  std::string name{};
  std::size_t number{};
};

/// Returns the column as messages to users name it: its name, or "column 3".
[[nodiscard]] std::string describe(const ColumnName& column);

/// The notation of a row's time: a number of units, ISO 8601, a date with a time of day in a local notation, or only a
/// time of day.
enum class TimeForm { number, civil, date, clock };

/// Treatment of a row that is not later than its predecessor: refuse the file, skip the row, or assume that the clock
/// was set back and shift this row and all later ones.
enum class OutOfOrder { refuse, skip, shift };

/// The range of valid values of a column, in the numbers of the file. Other values count as missing.
struct ValidRange {
  double low{}, high{};
};

/// The content of an import map.
struct ImportMap {
  std::string name;
  /// The text of the map, which is stored in the record.
  std::string text;

  FileFormat format{};
  char separator = ',';  ///< comma, semicolon, tab or blanks
  char decimal = '.';    ///< point or comma
  /// The beginning of comment lines; empty if there are none.
  std::string comment;
  /// Fields that mark a missing value.
  std::vector<std::string> missing;
  bool header = true;
  std::size_t preamble{};  ///< lines before the header
  /// The number of lines between the header (or the start of the file) and the first row. Empty lines are included,
  /// comments are not.
  std::size_t skip{};
  char thousands{};  ///< separator of thousands; 0: none
  /// Texts that may follow a number: "°C".
  std::vector<std::string> cell_units;
  /// The beginnings of the first and the last line of another header between rows; the line after it has the names.
  /// Empty if there is none.
  std::string segment_begin{}, segment_end{};
  /// The reader counts unreadable lines instead of failing.
  bool leaves_out_damaged = false;

  /// The column with a row's time; nothing if rows have a fixed `interval`. The column is either a number in units of
  /// `time_unit`, counted from `since` if that is known, or a calendar time. The calendar time is in `zone` unless its
  /// text names another zone.
  std::optional<ColumnName> time;
  /// The units of the time in a NetCDF or HDF5 file that does not state them; empty otherwise.
  std::string file_units{};
  TimeForm time_form{};
  Duration time_unit{};
  std::optional<CountedTime> since{};  ///< since 1970
  std::optional<Duration> zone{};
  /// `since` is local time in `zone`.
  bool counts_local_days = false;
  bool counts_gps = false;  ///< time without leap seconds
  DateOrder date_order{};
  std::optional<ColumnName> clock{};  ///< separate column: time of day
  std::optional<ColumnName> week{};   ///< GPS week
  /// The period after which the counter restarts at 0.
  std::optional<CountedTime> wrap{};
  Duration interval{};

  /// Other columns with dates are not compared with the time.
  bool ignores_other_clocks = false;
  /// The length of the stretches in which rows are combined; 0 if rows are not combined.
  Duration every{};
  OutOfOrder out_of_order{};

  /// A column with a unit of its own: value = number × scale + offset.
  struct ScaledColumn {
    ColumnName column;
    double scale = 1;
    double offset = 0;
    std::optional<ValidRange> valid{};
  };
  std::vector<std::string> thermometers;
  std::vector<ScaledColumn> thermometer_columns;  ///< one per thermometer, in °C

  /// The units under test of the file, each with its axes and values. Numbers of an axis are stored unchanged. The
  /// scale is in °/h per unit for a rate, and in arcsec per unit for pulse_count (increments). All axes of a unit are
  /// of the same kind.
  std::vector<record::UnitInfo> units;
  /// The columns of all units' axes, in order, and their valid ranges. The second list may be shorter.
  std::vector<ColumnName> axis_columns;
  std::vector<std::optional<ValidRange>> axis_valid;
  /// The columns of all units' values, in order.
  std::vector<ScaledColumn> value_columns;
  /// One per unit, or fewer: the column with the times in seconds over which its increments were counted. Without a
  /// column, an increment covers the time since the row before.
  std::vector<std::optional<ColumnName>> interval_columns;

  /// Returns true if the axes of a unit have increments, which are summed when rows are combined; false if they have
  /// rates.
  [[nodiscard]] bool counts_increments(std::size_t unit) const;
  /// Returns true if the axes of any unit have increments.
  [[nodiscard]] bool counts_increments() const;
  /// Returns all columns of a row except the time: thermometers, axes, values, counting times, in this order.
  [[nodiscard]] std::vector<ColumnName> columns() const;
  /// Returns the valid range of each of columns().
  [[nodiscard]] std::vector<std::optional<ValidRange>> valid_ranges() const;
};

/// Parses a map. Fails with bad_file and lists all errors, each with file:line:column.
[[nodiscard]] Result<ImportMap> parse_import_map(std::string_view text, const std::string& file);

/// Reads a map from a file. Fails also if the file cannot be read.
[[nodiscard]] Result<ImportMap> load_import_map(const std::string& path);

/// Returns the thermometer channels of a map, all with the instrument description `instrument`. If the file has one
/// unit, all thermometers belong to it. If it has several, a thermometer belongs to the unit that names it, or to all
/// units if none or more than one names it.
[[nodiscard]] std::vector<record::Channel> make_channels(const ImportMap& map, const std::string& instrument);

/// Describes columns of a map that a file does not have, and the alternatives: "no column "w", expected one of: "t",
/// "T", "x"". Truncates long lists.
[[nodiscard]] std::string describe_missing_columns(const std::vector<std::string>& missing,
                                                   const std::vector<std::string>& available);

}  // namespace gyrotherm::exchange
