// SPDX-License-Identifier: Apache-2.0
/// The tables of a record, schema gyrotherm-run/1.
///
///   meta     key → value: what the run knows before its first sample, and its outcome
///   channel  what is measured once a second, in the order of the sample's columns: unit, instrument, calibration, and
///            the unit under test that it belongs to, "" where it is the rig's
///   frames   one row: the gyro's frames so far
///   segment  the expanded profile
///   list     short lists of names: cycles, gradients, three_point
///   sample   one row per slot; NULL where a reading was a fault; raw values, never changed
///   fault    why a value of a sample is NULL
///   event    what happened, in order
///   gap      slots that have no sample, and why
///
/// sample, fault, event and gap have a column `chain` (chain.hpp); `frames` has the chain's head as of the last
/// commit, `meta` what it begins and ends with.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/record/run_info.hpp"
#include "acquisition/record/sqlite.hpp"
#include "core/result.hpp"

namespace gyrotherm::record {

/// A thermometer's name becomes a column: 1 to 64 of [A-Za-z0-9_ .-], unlike every other column of the sample (letter
/// case apart). Fails with bad_file naming the channel.
[[nodiscard]] Result<void> check_channel_names(const std::vector<Channel>& channels);

/// Whether a column of the sample has this name whatever the thermometers are called.
[[nodiscard]] bool is_own_column(std::string_view name);

/// Makes the tables and marks the file as a record. The names must be good.
[[nodiscard]] Result<void> create_schema(Database& database, const std::vector<Channel>& channels);

inline constexpr std::int64_t kMostSlots = 100'000'000;  ///< three years of seconds

/// Checks that the file is a record of this version, and that it holds the tables of a record with their columns, and
/// no view, trigger, index, virtual table or computed column; that is looked at before any of them is read. And that
/// its slots are such as a run can have: from 0 to kMostSlots. Fails with bad_file if it is none, or another version's;
/// with storage if it is locked.
[[nodiscard]] Result<void> check_schema(Database& database, const std::string& path);

/// The sample's columns in the order of SampleRow, quoted, separated by commas.
[[nodiscard]] std::string sample_columns(const std::vector<Channel>& channels);

}  // namespace gyrotherm::record
