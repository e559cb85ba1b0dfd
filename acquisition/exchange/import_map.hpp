// SPDX-License-Identifier: Apache-2.0
/// The map of a foreign file: which of its columns is the time, which are thermometers, which are the gyros' axes and
/// own values, and in what units. `docs/importing.md` explains every key.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/record/run_info.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm::exchange {

inline constexpr const char* kImportSchema = "gyrotherm-import/1";

/// What a foreign file is: a text table, a log of PX4 (ULog), a log of ArduPilot (DataFlash), or a NetCDF file.
enum class FileFormat { text, ulog, dataflash, netcdf };

/// The word for it in a map.
[[nodiscard]] const char* name(FileFormat format);

/// A column by its name in the header (blanks at either end do not count), or by its number from 1 in a text table
/// without one. That of a log is called by its message: "sensor_gyro.x", "sensor_gyro[1].x", "IMU.GyrX".
struct ColumnName {
  std::string name{};
  std::size_t number{};
};

/// How the rows' own times are written.
enum class TimeForm { number, civil };

struct ImportMap {
  std::string name;
  std::string text;  ///< the map itself, kept with the record

  FileFormat format{};
  char separator = ',';              ///< comma, semicolon, tab or blank (any run of them)
  char decimal = '.';                ///< point or comma
  std::string comment;               ///< lines that begin with it do not count; empty: there are none
  std::vector<std::string> missing;  ///< fields that stand for a value which is not there
  bool header = true;
  std::size_t skip{};  ///< lines after the header (or from the start) that are no rows: empty ones too, no comments

  /// Rows of a text table have their own time, in units of `time_unit` (since `since`, where that is known) or as a
  /// civil time, of `zone` where its text names none; or each row lasts `interval`.
  std::optional<ColumnName> time;
  TimeForm time_form{};
  Duration time_unit{};
  std::optional<Duration> since{};  ///< a UTC
  std::optional<Duration> zone{};
  Duration interval{};

  Duration every{};                 ///< rows are put together into one for each stretch of this length; 0: they are not
  bool skips_out_of_order = false;  ///< rows that are not after the one before are left out, not refused

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
  std::vector<record::UnitInfo> units;
  std::vector<ColumnName> axis_columns;     ///< of all units' axes, in order
  std::vector<ScaledColumn> value_columns;  ///< … and values

  /// Whether the axes give increments, which are added where rows are put together, and not rates.
  [[nodiscard]] bool counts_increments() const;
  /// All that is read of a row beside its time: thermometers, axes, values, in that order.
  [[nodiscard]] std::vector<ColumnName> columns() const;
};

/// Fails with bad_file: all mistakes at once, each with file:line:column.
[[nodiscard]] Result<ImportMap> parse_import_map(std::string_view text, const std::string& file);

/// Fails also if the file cannot be read.
[[nodiscard]] Result<ImportMap> load_import_map(const std::string& path);

/// What a record says of a map's channels, all of them read by `instrument`.
[[nodiscard]] std::vector<record::Channel> channels_of(const ImportMap& map, const std::string& instrument);

/// "no column "w", expected one of: "t", "T", "x"": names that a map has and a file has not, and those that it has, of
/// which a long list is cut short.
[[nodiscard]] std::string describe_missing_columns(const std::vector<std::string>& missing,
                                                   const std::vector<std::string>& there);

}  // namespace gyrotherm::exchange
