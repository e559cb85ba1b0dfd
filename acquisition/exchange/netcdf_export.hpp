// SPDX-License-Identifier: Apache-2.0
/// Exports a record as a NetCDF file for other tools: xarray, MATLAB, Octave and all readers of HDF5.
#pragma once

#include <string>

#include "acquisition/exchange/export_choice.hpp"
#include "acquisition/record/record.hpp"
#include "core/result.hpp"

namespace gyrotherm::exchange {

/// Writes netCDF-4 that follows CF-1.10, with the dimension `time`. It contains the rows of the record that `choice`
/// selects, and a row of missing values for each slot of a gap.
/// Every variable has `units` and `long_name`. `time` is in seconds since the start of the run in UTC, or since the
/// first row of an imported record without UTC. Thermometers are calibrated, in °C, with flags of their readings as
/// `ancillary_variables`. Each axis has its rate in °/h and its counts. `segment`, `cycle` and `phase` are flags with
/// `flag_meanings`. If the record has the latitude, the file is a timeSeries with `latitude`. The global attributes of
/// a simulated record contain SIMULATED.
/// The file appears atomically. Fails with storage.
[[nodiscard]] Result<void> export_netcdf(const record::Record& record, const ExportChoice& choice,
                                         const std::string& path);

}  // namespace gyrotherm::exchange
