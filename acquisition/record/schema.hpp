// SPDX-License-Identifier: Apache-2.0
/// The tables of a record, schema gyrotherm-run/1.
///
///   meta     key → value: the description of the run before its first sample, and its outcome
///   unit     the units under test, each with its axes in `axis` and its own values in `unit_value`
///   channel  the channels in the order of the sample's columns: unit, instrument, calibration, and the unit under test
///            that each belongs to; "" for the rig
///   frames   one row: the frames of all gyros so far
///   segment  the expanded profile
///   list     short lists: cycles, analogue_map_texts, thermometer_texts and supply_texts; gradients and three_point of
///            each unit
///   sample   one row per slot; NULL if a reading was a fault; raw values, never changed. A value that a unit sends is
///            also NULL if no frame of the second had it; a value that an analogue input measures has its own faults
///   fault    the reason for each NULL in a sample
///   event    the events, in order
///   gap      the slots without a sample, and the cause
///
/// The views of a record serve readers that use only SQL: calibrated values in °C, °/h and UTC, and names instead of
/// numbers. Names and columns of views that begin with v1 do not change.
///
///   v1_sample   a row a second: slot, time_s, utc, set point, the chamber's air and set point, each thermometer in °C
///               by its calibration, each axis' `rate_deg_per_h` (with the Earth's rate) and `interval_s`, the own
///               values of a unit, the names of segment and cycle, phase, state, a virtual gyro's true bias
///   v1_event    events with time_s, utc and the segment's name
///   v1_gap      gaps with their length in seconds
///   v1_channel  the measured columns of v1_sample, with their units, instruments and calibrations
///
/// A record of an earlier version may have no views.
///
/// The tables sample, fault, event and gap have a column `chain` (chain.hpp). `frames` contains the head of the chain
/// at the last commit, `meta` its first and its final hash.
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

/// A name that is not allowed, and the reason.
struct NameTrouble {
  enum class Of { thermometer, unit, axis, value } of{};
  /// The index of the unit; also set for an axis or a value.
  std::size_t unit{};
  /// The index of the thermometer, or the index of the axis or value in its unit.
  std::size_t index{};
  /// Kind and name of the object, such as `thermometer "T?"`.
  std::string what;
  std::string why;
};

/// Finds all names that are not allowed. Names become column names. The name of a thermometer has 1 to 64 characters of
/// [A-Za-z0-9_ .-]; the name of a unit, axis or value has 1 to 64 characters of [A-Za-z0-9_-]. Two column names must
/// differ in more than letter case. Lists malformed names first, then duplicate ones. For a unit with a duplicate name,
/// lists only the unit.
[[nodiscard]] std::vector<NameTrouble> name_troubles(const RunInfo& info);
/// Fails with bad_file, naming the first of name_troubles().
[[nodiscard]] Result<void> check_channel_names(const RunInfo& info);

/// Returns the column names, in lower case, that every record has. No thermometer of a new record may have one of them.
[[nodiscard]] std::set<std::string> reserved_channel_names();

/// Finds all names that are not allowed in a new record. These are the names that name_troubles() finds, and
/// thermometers with the name of a column that views, exports, Python or the inputs of a model add. Older records with
/// such thermometers can still be read.
[[nodiscard]] std::vector<NameTrouble> new_name_troubles(const RunInfo& info);
/// Fails with bad_file, naming the first of new_name_troubles().
[[nodiscard]] Result<void> check_new_channel_names(const RunInfo& info);

/// Returns the name of a measured column after calibration: "u1.x.rate_deg_per_h" for "u1.x.pulses", "u1.interval_s"
/// for "u1.interval_ns", and the column's own name for others.
[[nodiscard]] std::string calibrated_name(const ChannelColumn& column);

struct View {
  std::string name;
  /// The SQL text of the view as stored in the file: "CREATE VIEW …".
  std::string sql;
  bool operator==(const View&) const = default;
};

/// Returns the views of a record with these channels, ordered by name. They depend only on `info`. A file with other
/// views is therefore not a record.
[[nodiscard]] std::vector<View> record_views(const RunInfo& info);

/// Creates the tables and views, and marks the file as a record. The names must be allowed.
[[nodiscard]] Result<void> create_schema(Database& database, const RunInfo& info);

inline constexpr std::int64_t kMaxSlots = 100'000'000;  ///< three years of seconds

/// Checks that the file is a record of this version. It must have the tables of a record with their columns, all of
/// record_views() or no view, and no trigger, index, virtual table or computed column; this is checked before any table
/// is read. Its slots must be between 0 and kMaxSlots. Fails with bad_file if any check fails, and with storage if the
/// file is locked.
[[nodiscard]] Result<void> check_schema(Database& database, const std::string& path);

}  // namespace gyrotherm::record
