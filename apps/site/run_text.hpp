// SPDX-License-Identifier: Apache-2.0
/// Converts a run and the documents next to it to the arguments of the store's functions (apps/site/migrations): the
/// run as JSON, its rows as text of PostgreSQL arrays. Only reads files. A record is open only during a call, because a
/// program cannot resume the run while the record is open.
///
/// The functions that read a record fail with storage if a program is writing it or if it is damaged, and with bad_file
/// if one of its files is missing or is not a record.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/record/alarms.hpp"
#include "acquisition/record/run_info.hpp"
#include "acquisition/record/run_source.hpp"
#include "core/result.hpp"

namespace gyrotherm::site {

/// A column of the record's table `sample` that the store keeps, one number per row.
struct StoredChannel {
  std::string name;
  std::string unit{};
  std::string measures{};
  std::string unit_under_test{};  ///< label; empty: the rig
  /// Meanings of the values 0, 1, …; empty: the values are plain numbers.
  std::vector<std::string> keywords{};
  /// Points into the RunInfo; null: not a thermometer.
  const record::Channel* thermometer = nullptr;
};

/// Returns all columns except slot and UTC, in the order of the table. The result points into `info`.
[[nodiscard]] std::vector<StoredChannel> stored_channels(const record::RunInfo& info);

/// Returns the argument of add_run().
[[nodiscard]] std::string run_as_json(const record::RunInfo& info);

/// Returns the segments of a run: the argument of add_segments().
[[nodiscard]] std::string segments_as_json(const record::RunInfo& info);

/// The state of a run, its cause, and its alarms: the arguments of Store::update_state().
struct LiveState {
  std::string state{}, cause{}, alarms{};
  bool operator==(const LiveState&) const = default;
};

/// Returns a JSON list of the alarms, in the form of a status file.
[[nodiscard]] std::string alarms_as_json(const std::vector<record::Alarm>& alarms);

/// The position of a run in the store.
struct RunPosition {
  std::int64_t slot{-1};
  std::int64_t event{};
  std::int64_t gap{-1};
  bool finished{};
  bool dropped{};
  /// State that was last sent on this connection.
  LiveState sent_state{};
  /// Number of segments that were sent on this connection; empty if unknown.
  std::optional<std::size_t> sent_segments{};
  /// Returns true if the store accepts no more data for the run.
  [[nodiscard]] bool is_closed() const { return finished || dropped; }
};

/// The rows after a slot: the arguments of add_rows().
struct RowBatch {
  std::int64_t after{-1};
  std::int64_t last{-1};
  std::size_t rows{};
  std::string slots{"{"}, utcs{"{"}, numbers{"{"};
};

inline constexpr std::int64_t kBatchRows = 1000;

/// Reads at most `most` rows after the slot `after`. A keyword that this version does not know becomes NULL, like a
/// missing number.
[[nodiscard]] Result<RowBatch> read_rows(const record::RecordFiles& files, const std::vector<StoredChannel>& channels,
                                         std::int64_t after, std::int64_t most = kBatchRows);

/// Events or gaps: the arguments of add_events() and add_gaps(). `text` is empty if there are none.
struct JsonBatch {
  std::int64_t last{};
  std::size_t rows{};
  std::string text{};
};
/// Read the events after a number, and the gaps after a slot.
[[nodiscard]] Result<JsonBatch> read_events(const record::RecordFiles& files, std::int64_t after);
[[nodiscard]] Result<JsonBatch> read_gaps(const record::RecordFiles& files, std::int64_t after);

/// The end of a run that no program executes any more.
struct RunEnd {
  bool finished{};
  std::string state;  ///< keyword of the RunState
  std::string cause;
  std::string alarms;  ///< see LiveState
  std::int64_t ended_ns{};
  std::int64_t rows{}, events{}, gaps{};
  std::string chain_head;
};
/// Reads the end of a run from all files of its record.
[[nodiscard]] Result<RunEnd> read_end(const record::RunInfo& info, const record::RecordFiles& files);

/// A file of a finished run.
struct RunFileDigest {
  std::string path, name, sha256;
  std::uint64_t bytes{};
};

/// Returns the argument of finish_run().
[[nodiscard]] std::string end_as_json(const RunEnd& end, const std::vector<RunFileDigest>& files);

/// A document that gyrotherm has written next to a record: the arguments of add_document().
struct Document {
  std::string kind;  ///< calibration, model or report
  std::string name;
  std::string text;
};

/// Reads a JSON file. Returns nothing if its schema is not one of a calibration, a model or a report. Fails with
/// bad_file if it cannot be read.
[[nodiscard]] Result<std::optional<Document>> read_document(const std::string& path);

}  // namespace gyrotherm::site
