// SPDX-License-Identifier: Apache-2.0
/// Recognises the tables that gyrotherm itself exported, and assigns their columns without a guess.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/exchange/netcdf_table.hpp"
#include "acquisition/record/run_info.hpp"

namespace gyrotherm::exchange {

/// The columns of an exported table, by their names.
struct OwnColumns {
  std::string time{};
  struct Thermometer {
    std::string name{}, column{};
    /// °C = number × scale + offset
    double scale = 1, offset = 0;
    /// The correction has terms of a higher order, which a map cannot state.
    bool is_nonlinear = false;
  };
  std::vector<Thermometer> thermometers{};
  struct Axis {
    /// "u1", or "u1.x" if the unit has several axes.
    std::string label{}, column{};
    record::GyroKind kind{};
    /// °/h or arcsec per number.
    std::string scale{};
    /// °/h; empty if nothing is removed.
    std::string earth_rate{};
    /// The column with the counting times of the unit; empty if there is none.
    std::string interval{};
    /// The thermometers of the unit's gradients and of its three points; empty if the table does not state them.
    std::vector<std::string> gradients{}, three_point{};
  };
  std::vector<Axis> axes{};
  struct Value {
    /// The name starts with that of its unit, "u1.die".
    std::string name{}, column{}, unit{};
  };
  std::vector<Value> values{};
  /// The unit was turned during the run, which changes the sign of the Earth rate.
  bool has_turned = false;
};

/// Returns the columns of a text table with the given titles and comments. Returns nothing if gyrotherm did not export
/// it, or if it has no rate.
[[nodiscard]] std::optional<OwnColumns> find_own_columns(const std::vector<std::string>& titles,
                                                         const std::vector<std::string>& comments);

/// Returns the columns of a NetCDF file with the given variables; nothing if it has no rate.
[[nodiscard]] std::optional<OwnColumns> find_own_columns(const std::vector<NetcdfVariable>& variables);

/// Returns the sections [time], [[thermometer]], [gyro] or [[gyro]], and [analysis] of a map.
[[nodiscard]] std::string own_sections(const OwnColumns& columns);

}  // namespace gyrotherm::exchange
