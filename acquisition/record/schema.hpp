/// The tables of a record, schema gyrotherm-run/2. Schema gyrotherm-run/1 is read, and gone on with, as it is: it lacks
/// the column `state` and the chain.
///
///   meta     key → value: what the run knows before its first sample, and its outcome
///   channel  the thermometers, in the order of the sample's columns
///   calibration  of those channels that have more of it than an offset (older records lack it)
///   frames   one row: the gyro's frames so far (likewise)
///   segment  the expanded profile
///   list     short lists of names: cycles, gradients, three_point
///   sample   one row per slot; NULL where a reading was a fault; raw values, never changed
///   fault    why a value of a sample is NULL
///   event    what happened, in order
///   gap      slots that have no sample, and why
///
/// sample, fault, event and gap have a column `chain` (row_chain.hpp); `frames` has the chain's head as of the last
/// commit, `meta` what it begins and ends with.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "acquisition/record/run_info.hpp"
#include "acquisition/record/sqlite.hpp"
#include "core/result.hpp"

namespace gyrotherm {

/// A thermometer's name becomes a column: 1 to 64 of [A-Za-z0-9_ .-], unlike every other column of the sample (letter
/// case apart). Fails with bad_file naming the channel.
[[nodiscard]] Result<void> check_channel_names(const std::vector<Channel>& channels);

/// Makes the tables and marks the file as a record. The names must be good.
[[nodiscard]] Result<void> create_schema(Database& database, const std::vector<Channel>& channels);

inline constexpr int kFirstChained = 2;
inline constexpr std::int64_t kMostSlots = 100'000'000;  ///< three years of seconds

/// The version of the record's schema. Fails with bad_file if the file is no record, or a later program's; with storage
/// if it is locked.
[[nodiscard]] Result<int> schema_version(Database& database, const std::string& path);
/// Also that the file holds the tables of that version with their columns, and no view, trigger, index, virtual table
/// or computed column; that is looked at before any of them is read. And that its slots are such as a run can have:
/// from 0 to kMostSlots.
[[nodiscard]] Result<void> check_schema(Database& database, const std::string& path);

/// The part of check_schema() that looks at the tables.
[[nodiscard]] Result<void> check_tables(Database& database, const std::string& path, int version);

/// A table that older records lack.
[[nodiscard]] Result<bool> has_table(Database& database, const char* name);

/// The sample's columns in the order of SampleRow, quoted, separated by commas; those of version 1 lack the last.
[[nodiscard]] std::string sample_columns(const std::vector<Channel>& channels, int version = 2);

}  // namespace gyrotherm
