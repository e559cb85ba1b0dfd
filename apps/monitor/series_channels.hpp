// SPDX-License-Identifier: Apache-2.0
/// What of a run can be drawn, and how its rows give it.
#pragma once

#include <string>
#include <vector>

#include "acquisition/record/run_info.hpp"

namespace gyrotherm::monitor {

/// Something that can be drawn: a column of the record, or the rate that pulses and their interval make.
struct SeriesChannel {
  std::string name;
  std::string unit;
  std::string unit_under_test;  ///< empty: the rig's
  std::string sql;              ///< its value in a row of `sample`
};
/// The set point that the profile asks for, then the chamber's own two, thermometers, and what each unit measured.
[[nodiscard]] std::vector<SeriesChannel> series_channels(const record::RunInfo& info);

}  // namespace gyrotherm::monitor
