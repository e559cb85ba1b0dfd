// SPDX-License-Identifier: Apache-2.0
/// Reads NetCDF and HDF5 files of other programs as rows: variables along the dimension of their time.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "acquisition/exchange/confined_rows.hpp"
#include "acquisition/exchange/foreign_row.hpp"
#include "acquisition/exchange/import_map.hpp"
#include "core/result.hpp"

namespace gyrotherm::exchange {

/// Passes on a row for each value of the time variable. The attribute `units` of the variable is a unit of time, with
/// or without a reference instant ("hours since 2026-03-01 12:00", in the standard calendar, in UTC unless it names a
/// zone). If the variable has no units, the map supplies them.
/// Columns are variables along only this dimension; a second dimension of length 1 is allowed, because MATLAB writes
/// it. `scale_factor`, `add_offset`, `_FillValue` and `missing_value` are applied as CF defines them.
/// The library reads in a child process with limits (confined_rows.hpp). Fails with bad_file if the file has another
/// format, lacks a variable (the fault lists the existing ones), or cannot be read within the limits. Fails as `take`
/// does.
[[nodiscard]] Result<void> read_netcdf(const std::string& path, const ImportMap& map, const TakeRow& take,
                                       const ReadingLimits& limits = {});

/// Returns the global attribute `source` of the file at `path`; an empty text if there is none. Fails as read_netcdf()
/// does if the library cannot read the file.
[[nodiscard]] Result<std::string> read_netcdf_source(const std::string& path);

/// A variable of a NetCDF file that gyrotherm exported. Attributes that it does not have are empty.
struct NetcdfVariable {
  std::string name{}, units{}, long_name{}, channel{};
  /// The thermometers of the unit's gradients and of its three points, separated by ", ".
  std::string gradients{}, three_point{};
  /// The Earth rate that gyrotherm removes from the bias, °/h, and the scale of a number of pulses, both as text.
  std::string earth_rate{}, arcsec_per_pulse{};
};

/// Returns the variables along the time of a file that gyrotherm exported; nothing for any other file. Fails as
/// read_netcdf() does if the library cannot read the file.
[[nodiscard]] Result<std::vector<NetcdfVariable>> list_own_variables(const std::string& path);

/// Returns whether a file with this beginning is NetCDF: classic, or HDF5, which netCDF-4 and MATLAB 7.3 write. MATLAB
/// writes a 512-byte block before the HDF5 content.
[[nodiscard]] bool is_netcdf(std::string_view beginning);

}  // namespace gyrotherm::exchange
