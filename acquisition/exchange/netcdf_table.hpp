// SPDX-License-Identifier: Apache-2.0
/// NetCDF and HDF5 files of others as rows: variables along the dimension of their time.
#pragma once

#include <string>
#include <string_view>

#include "acquisition/exchange/confined_rows.hpp"
#include "acquisition/exchange/foreign_row.hpp"
#include "acquisition/exchange/import_map.hpp"
#include "core/result.hpp"

namespace gyrotherm::exchange {

/// Hands on a row for each value of the time variable, whose units are a unit of time, or one since an instant ("hours
/// since 2026-03-01 12:00", by the usual calendar, in UTC unless it names a zone). The map says the units of a variable
/// that has none. Columns are variables along the same dimension and no other, but for one of length 1, which MATLAB
/// gives each vector; `scale_factor`, `add_offset`, `_FillValue` and `missing_value` are taken as CF means them. The
/// library reads in a child process with limits (confined_rows.hpp). Fails with bad_file if it is no such file, lacks a
/// variable (those that it has are named), or cannot be read within the limits; and as `take` does.
[[nodiscard]] Result<void> read_netcdf(const std::string& path, const ImportMap& map, const TakeRow& take,
                                       const ReadingLimits& limits = {});

/// Returns true if a file that begins so is one: a classic one, or HDF5, which netCDF-4 and MATLAB 7.3 write, also
/// behind the latter's block of 512 bytes.
[[nodiscard]] bool is_netcdf(std::string_view beginning);

}  // namespace gyrotherm::exchange
