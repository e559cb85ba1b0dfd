// SPDX-License-Identifier: Apache-2.0
/// The map of a foreign file: which of its columns is the time, which are thermometers, which are the gyros' axes and
/// own values, and in what units. `docs/importing.md` explains every key.
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

/// What a foreign file is: a text table, a log of PX4 (ULog), a log of ArduPilot (DataFlash), or a NetCDF file.
enum class FileFormat { text, ulog, dataflash, netcdf };

/// The word for it in a map.
[[nodiscard]] const char* name(FileFormat format);

/// A column by its name in the header (blanks at either end do not count), or by its number from 1 in a text table,
/// which counts where it is not 0 and the name is empty or the table has no header. That of a log is called by its
/// message: "sensor_gyro.x", "sensor_gyro[1].x", "IMU.GyrX".
struct ColumnName {
  std::string name{};
  std::size_t number{};
};

/// The column as people call it: its name, or "column 3".
[[nodiscard]] std::string in_words(const ColumnName& column);

/// The notation of a row's time: a number of units; ISO 8601; a date and a time of day as one of the world's
/// locales writes them; a time of day alone.
enum class TimeForm { number, civil, date, clock };

/// Treatment of a row whose time is not after the row before: refuse the file, leave the row out, or continue after the
/// row before as if the clock had been set back.
enum class OutOfOrder { refuse, skip, go_on };

/// Values that a column can have, in the numbers of the file; any other is missing.
struct ValidRange {
  double low{}, high{};
};

struct ImportMap {
  std::string name;
  std::string text;  ///< the map itself, kept with the record

  FileFormat format{};
  char separator = ',';              ///< comma, semicolon, tab or blank (any run of them)
  char decimal = '.';                ///< point or comma
  std::string comment;               ///< lines that begin with it do not count; empty: there are none
  std::vector<std::string> missing;  ///< fields that stand for a value which is not there
  bool header = true;
  std::size_t preamble{};  ///< lines before the header
  std::size_t skip{};      ///< lines after the header (or from the start) that are no rows: empty ones too, no comments
  char thousands{};        ///< separator of thousands; 0: none
  std::vector<std::string> cell_units;  ///< texts allowed behind numbers: "°C"
  bool leaves_out_damaged = false;      ///< counts unreadable lines, refuses none

  /// Rows of a text table have their own time, in units of `time_unit` (since `since`, where that is known) or as a
  /// civil time, of `zone` where its text names none; or each row lasts `interval`.
  std::optional<ColumnName> time;
  std::string file_units{};  ///< units of a NetCDF or HDF5 time whose file has none; empty: the file has them
  TimeForm time_form{};
  Duration time_unit{};
  std::optional<CountedTime> since{};  ///< after 1970
  std::optional<Duration> zone{};
  bool counts_local_days = false;  ///< `since` is local time of `zone`
  bool counts_gps = false;         ///< time without leap seconds
  DateOrder date_order{};
  std::optional<ColumnName> clock{};  ///< separate time of day
  std::optional<ColumnName> week{};   ///< GPS week
  std::optional<CountedTime> wrap{};  ///< after so long the counter begins at 0 again
  Duration interval{};

  bool ignores_other_clocks = false;  ///< no other column with dates is compared with the time
  Duration every{};  ///< rows are put together into one for each stretch of this length; 0: they are not
  OutOfOrder out_of_order{};

  /// A column of something that is stored in a unit of its own: number × scale + offset.
  struct ScaledColumn {
    ColumnName column;
    double scale = 1;
    double offset = 0;
    std::optional<ValidRange> valid{};
  };
  std::vector<std::string> thermometers;
  std::vector<ScaledColumn> thermometer_columns;  ///< of each, in °C

  /// The units under test of the file, each with its axes and values. An axis' number is stored as it is: rate: `scale`
  /// °/h per unit; pulse_count (increments): `scale` arcsec per unit; all of them are the one or the other.
  std::vector<record::UnitInfo> units;
  std::vector<ColumnName> axis_columns;               ///< of all units' axes, in order
  std::vector<std::optional<ValidRange>> axis_valid;  ///< of each; may be shorter
  std::vector<ScaledColumn> value_columns;            ///< … and values

  /// Whether the axes give increments, which are added where rows are put together, and not rates.
  [[nodiscard]] bool counts_increments() const;
  /// All that is read of a row beside its time: thermometers, axes, values, in that order.
  [[nodiscard]] std::vector<ColumnName> columns() const;
  /// What their numbers can be, of each.
  [[nodiscard]] std::vector<std::optional<ValidRange>> valid_ranges() const;
};

/// Fails with bad_file: all mistakes at once, each with file:line:column.
[[nodiscard]] Result<ImportMap> parse_import_map(std::string_view text, const std::string& file);

/// Fails also if the file cannot be read.
[[nodiscard]] Result<ImportMap> load_import_map(const std::string& path);

/// What a record says of a map's channels, all of them read by `instrument`. A thermometer belongs to the one unit of
/// the file; of several units to the one that names it alone, else to all of them.
[[nodiscard]] std::vector<record::Channel> channels_of(const ImportMap& map, const std::string& instrument);

/// "no column "w", expected one of: "t", "T", "x"": names that a map has and a file has not, and those that it has, of
/// which a long list is cut short.
[[nodiscard]] std::string describe_missing_columns(const std::vector<std::string>& missing,
                                                   const std::vector<std::string>& there);

}  // namespace gyrotherm::exchange
