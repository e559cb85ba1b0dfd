/// How a foreign text table is to be read: which column is the time, which are thermometers, which is the gyro, and in
/// what units (`profiles/imports/*.toml`, schema gyrotherm-import/1).
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/record/run_info.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm {

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

  struct ThermometerColumn {
    std::string name;
    ColumnName column;
    double scale = 1;     ///< °C per unit of the file
    double offset_c = 0;  ///< reading = number × scale + offset
  };
  std::vector<ThermometerColumn> thermometers;

  /// The number is stored as it is. rate: `scale` °/h per unit; pulse_count (increments): `scale` arcsec per unit.
  ColumnName gyro;
  GyroInfo gyro_info;

  std::vector<std::string> gradients;
  std::vector<std::string> three_point;
};

/// Fails with bad_file: all mistakes at once, each with file:line:column.
[[nodiscard]] Result<ImportMap> parse_import_map(std::string_view text, const std::string& file);

/// Fails also if the file cannot be read.
[[nodiscard]] Result<ImportMap> load_import_map(const std::string& path);

}  // namespace gyrotherm
