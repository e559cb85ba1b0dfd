// SPDX-License-Identifier: Apache-2.0
/// The tables of a record, schema gyrotherm-run/1.
///
///   meta     key → value: what the run knows before its first sample, and its outcome
///   unit     the units under test, each with its axes in `axis` and its own values in `unit_value`
///   channel  what is measured once a second, in the order of the sample's columns: unit, instrument, calibration, and
///            the unit under test that it belongs to, "" where it is the rig's
///   frames   one row: the frames of all gyros so far
///   segment  the expanded profile
///   list     short lists: cycles and analogue_map_texts; of each unit gradients, three_point
///   sample   one row per slot; NULL where a reading was a fault; raw values, never changed. A unit's own value is NULL
///            too where no frame of the second had it; what an analogue input measures of it has its own faults
///   fault    why a value of a sample is NULL
///   event    what happened, in order
///   gap      slots that have no sample, and why
///
/// The views of a record serve readers that use SQL alone: calibrated values in °C, °/h and UTC, and names in the place
/// of numbers. Names and columns of views that begin with v1 do not change.
///
///   v1_sample   a row a second: slot, time_s, utc, set point, the chamber's air and set point, each thermometer in °C
///               by its calibration, each axis' `rate_deg_per_h` (with the Earth's rate) and `interval_s`, the own
///               values of a unit, the names of segment and cycle, phase, state, a virtual gyro's true bias
///   v1_event    events with time_s, utc and the segment's name
///   v1_gap      gaps with their length in seconds
///   v1_channel  the measured columns of v1_sample, with their units, instruments and calibrations
///
/// A record that an earlier version made has no views.
///
/// sample, fault, event and gap have a column `chain` (chain.hpp); `frames` has the chain's head as of the last
/// commit, `meta` what it begins and ends with.
#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/record/row.hpp"
#include "acquisition/record/run_info.hpp"
#include "acquisition/record/sqlite.hpp"
#include "core/result.hpp"

namespace gyrotherm::record {

/// A name that cannot be one, and why.
struct NameTrouble {
  enum class Of { thermometer, unit, axis, value } of{};
  std::size_t unit{};   ///< of an axis or a value; the unit itself
  std::size_t index{};  ///< the thermometer; the axis or value of its unit
  std::string what;     ///< it is called, "thermometer "T?""
  std::string why;
};

/// Names become columns: those of thermometers are 1 to 64 of [A-Za-z0-9_ .-], those of units, axes and values of
/// [A-Za-z0-9_-], and no column has the name of another (letter case apart). All that are none: first those that are
/// badly made, then those that are taken; of a unit whose name is taken, the unit alone.
[[nodiscard]] std::vector<NameTrouble> name_troubles(const RunInfo& info);
/// Fails with bad_file naming the first.
[[nodiscard]] Result<void> check_channel_names(const RunInfo& info);

/// What no thermometer of a new record is called, whatever the rest of it is, in lower case.
[[nodiscard]] std::set<std::string> names_of_every_record();

/// Of what a record is made with: also thermometers with the name of a column that views, exports, Python or a model's
/// inputs put beside it. Records of before this was looked at are read all the same.
[[nodiscard]] std::vector<NameTrouble> new_name_troubles(const RunInfo& info);
/// Fails with bad_file naming the first.
[[nodiscard]] Result<void> check_new_channel_names(const RunInfo& info);

/// Returns the name of a measured column after calibration: "u1.x.rate_deg_per_h" for "u1.x.pulses", "u1.interval_s"
/// for "u1.interval_ns", and the column's own name for others.
[[nodiscard]] std::string calibrated_name(const ChannelColumn& column);

struct View {
  std::string name;
  std::string sql;  ///< the text in the schema of the file: "CREATE VIEW …"
  bool operator==(const View&) const = default;
};

/// Returns the views of a record with these channels, by name. They follow from `info` alone, so a file with other
/// views is not a record.
[[nodiscard]] std::vector<View> views_of(const RunInfo& info);

/// Makes the tables and views, and marks the file as a record. The names must be good.
[[nodiscard]] Result<void> create_schema(Database& database, const RunInfo& info);

inline constexpr std::int64_t kMostSlots = 100'000'000;  ///< three years of seconds

/// Checks that the file is a record of this version, and that it holds the tables of a record with their columns, all
/// of views_of() or no view, and no trigger, index, virtual table or computed column; that is looked at before any of
/// them is read. And that its slots are such as a run can have: from 0 to kMostSlots. Fails with bad_file if it is
/// none, or another version's; with storage if it is locked.
[[nodiscard]] Result<void> check_schema(Database& database, const std::string& path);

}  // namespace gyrotherm::record
