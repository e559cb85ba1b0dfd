// SPDX-License-Identifier: Apache-2.0
/// The views of a record, for whoever reads it with SQL alone: calibrated, in °C, °/h and UTC, with names for numbers.
/// What they are called and what their columns are stays as it is as long as their names begin with v1.
///
///   v1_sample   a row a second: slot, time_s, utc, set point, the chamber's air and set point, each thermometer in °C
///               by its calibration, each axis' `rate_deg_per_h` (the Earth's rate is in it) and `interval_s`, what a
///               unit tells of itself, the names of segment and cycle, phase, state, a virtual gyro's true bias
///   v1_event    events with time_s, utc and the segment's name
///   v1_gap      gaps with their length in seconds
///   v1_channel  the measured columns of v1_sample, with their units, instruments and calibrations
#pragma once

#include <string>
#include <vector>

#include "acquisition/record/row.hpp"
#include "acquisition/record/run_info.hpp"

namespace gyrotherm::record {

/// What a measured column of a record is called once it is calibrated: "u1.x.rate_deg_per_h" of "u1.x.pulses",
/// "u1.interval_s" of "u1.interval_ns"; any other keeps its name.
[[nodiscard]] std::string calibrated_name(const ChannelColumn& column);

struct View {
  std::string name;
  std::string sql;  ///< as the file's schema has it: "CREATE VIEW …"
  bool operator==(const View&) const = default;
};

/// The views of a record with these channels, by name. They depend on nothing but `info`, so that a record which has
/// others is none of ours.
[[nodiscard]] std::vector<View> views_of(const RunInfo& info);

}  // namespace gyrotherm::record
