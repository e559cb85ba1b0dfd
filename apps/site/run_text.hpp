// SPDX-License-Identifier: Apache-2.0
/// A run, and the documents beside it, as the functions of the store take them (apps/site/migrations): the run as JSON,
/// its rows as arrays in text. Reads files and nothing else. A record is open only while one call lasts, because no
/// writer can begin meanwhile.
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

/// A number of each row: a column of the record's table `sample`.
struct StoredChannel {
  std::string name;
  std::string unit{};
  std::string measures{};
  std::string unit_under_test{};                 ///< its label; empty: the rig's
  std::vector<std::string> words{};              ///< what its numbers stand for, from 0; empty: they are numbers
  const record::Channel* thermometer = nullptr;  ///< of the same RunInfo
};

/// All columns but slot and UTC, in the order of the table. Points into `info`.
[[nodiscard]] std::vector<StoredChannel> stored_channels(const record::RunInfo& info);

/// What add_run() takes.
[[nodiscard]] std::string run_as_json(const record::RunInfo& info);

/// The state of a run, its cause, and its alarms as say_state() takes them.
struct RunNow {
  std::string state{}, cause{}, alarms{};
  bool operator==(const RunNow&) const = default;
};

/// Returns a JSON list with each alarm as a status file has it.
[[nodiscard]] std::string alarms_as_json(const std::vector<record::Alarm>& alarms);

/// The position of a run in the store.
struct RunPosition {
  std::int64_t slot{-1};
  std::int64_t event{};
  std::int64_t gap{-1};
  bool finished{};
  bool dropped{};
  /// Sent last over this connection; empty before the first time.
  RunNow sent{};
  /// Returns true if the store takes nothing more of the run.
  [[nodiscard]] bool is_closed() const { return finished || dropped; }
};

/// Rows behind a slot, as add_rows() takes them.
struct RowBatch {
  std::int64_t after{-1};
  std::int64_t last{-1};
  std::size_t rows{};
  std::string slots{"{"}, utcs{"{"}, numbers{"{"};
};

inline constexpr std::int64_t kBatchRows = 1000;

/// The next rows, at most so many. Fails with storage while somebody else writes the record, with bad_file if it is
/// damaged.
[[nodiscard]] Result<RowBatch> next_rows(const record::RecordFiles& files, const std::vector<StoredChannel>& channels,
                                         std::int64_t after, std::int64_t most = kBatchRows);

/// The next events, or gaps, as add_events() and add_gaps() take them; `text` is empty if there are none. Fails
/// likewise.
struct JsonBatch {
  std::int64_t last{};
  std::size_t rows{};
  std::string text{};
};
[[nodiscard]] Result<JsonBatch> next_events(const record::RecordFiles& files, std::int64_t after);
[[nodiscard]] Result<JsonBatch> next_gaps(const record::RecordFiles& files, std::int64_t after);

/// How a run that no program carries out any more stands, by its record.
struct RunEnd {
  bool finished{};
  std::string state;  ///< as in RunState; imported: "complete"
  std::string cause;
  std::string alarms;  ///< as in RunNow
  std::int64_t ended_ns{};
  std::int64_t rows{}, events{}, gaps{};
  std::string chain_head;
};
/// Reads how a run ended from the files of its record. Fails like read_record().
[[nodiscard]] Result<RunEnd> end_of(const record::RunInfo& info, const record::RecordFiles& files);

/// A file of a finished run.
struct RunFileDigest {
  std::string path, name, sha256;
  std::uint64_t bytes{};
};

/// What finish_run() takes.
[[nodiscard]] std::string end_as_json(const RunEnd& end, const std::vector<RunFileDigest>& files);

/// A document of Gyrotherm beside records, as add_document() takes it.
struct Document {
  std::string kind;  ///< calibration, model or report
  std::string name;
  std::string text;
};

/// Reads a JSON file. Returns nothing if its schema is not one of a calibration, a model or a report. Fails with
/// bad_file if it cannot be read.
[[nodiscard]] Result<std::optional<Document>> read_document(const std::string& path);

}  // namespace gyrotherm::site
