// SPDX-License-Identifier: Apache-2.0
/// A record as a NetCDF file, for whoever analyses elsewhere: xarray, MATLAB, Octave and everything that reads HDF5.
#pragma once

#include <string>

#include "acquisition/exchange/export_choice.hpp"
#include "acquisition/record/record.hpp"
#include "core/result.hpp"

namespace gyrotherm::exchange {

/// Writes netCDF-4 after CF-1.10 with the dimension `time`. Rows are those of the record that `choice` picks; each slot
/// of a gap is a row of missing values. Every variable has `units` and `long_name`: `time` in seconds since a UTC (of
/// an imported record that knows none: since its first row), thermometers calibrated, in °C, with the flags of their
/// readings as `ancillary_variables`; of each axis the rate in °/h, with what was counted; `segment`, `cycle` and
/// `phase` as flags with `flag_meanings`. Where the record knows the latitude it is a timeSeries with `latitude`. A
/// record of virtual instruments says SIMULATED in its global attributes. The file appears as a whole. Fails with
/// storage.
[[nodiscard]] Result<void> export_netcdf(const record::Record& record, const ExportChoice& choice,
                                         const std::string& path);

}  // namespace gyrotherm::exchange
