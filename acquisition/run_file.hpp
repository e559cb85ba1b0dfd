/// The open file of a run: one connection with the settings that make a commit durable, and one prepared statement per
/// kind of row. What may be written when is the business of Store and of import; here a row is a row.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "acquisition/run_info.hpp"
#include "acquisition/sqlite.hpp"
#include "acquisition/wal_guard.hpp"
#include "core/result.hpp"
#include "core/sample.hpp"

namespace gyrotherm {

inline constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

/// A row of the table `sample`; NaN or nothing is stored as NULL.
struct SampleRow {
  std::int64_t slot{};
  Duration monotonic{};
  std::optional<Duration> utc{};
  double chamber_air_c{kMissing};
  double chamber_set_point_c{kMissing};
  std::span<const double> thermometers_c{};
  double gyro{kMissing};
  std::optional<Duration> interval{};
  std::optional<Progress> progress{};
};

class RunFile {
 public:
  /// Makes a new file with its schema and `info`, durable when this returns. Fails with storage if the file exists,
  /// with bad_file if a channel's name cannot be a column. After a failure there is no file.
  [[nodiscard]] static Result<RunFile> create(const std::string& path, const RunInfo& info);
  /// Takes up an unfinished run, folding in the log of a writer that died. Fails like Store::reopen().
  [[nodiscard]] static Result<RunFile> reopen(const std::string& path);

  [[nodiscard]] Result<void> begin();
  /// Ends the transaction; once this returns it is on the disk, in a log that is still in its place.
  [[nodiscard]] Result<void> commit();

  [[nodiscard]] Result<void> insert(const SampleRow& row);
  [[nodiscard]] Result<void> insert_fault(std::int64_t slot, std::string_view channel, const Fault& fault);
  [[nodiscard]] Result<void> insert_event(std::int64_t slot, const Event& event);
  [[nodiscard]] Result<void> insert_gap(std::int64_t first, std::int64_t last, std::string_view cause);
  /// Of the whole run so far; a record of an older program has no place for it.
  [[nodiscard]] Result<void> replace_frames(const FrameCount& frames);

  /// Outside a transaction: marks the run as finished and makes the file a single one. Only destruction may follow.
  [[nodiscard]] Result<void> finish();

  [[nodiscard]] const RunInfo& info() const { return info_; }
  [[nodiscard]] Database& database() { return database_; }

 private:
  struct Statements {
    Statement begin, commit, sample, fault, event, gap;
    std::optional<Statement> frames;
  };
  RunFile(Database database, Statements statements, WalGuard guard, std::string path, RunInfo info)
      : database_(std::move(database)),
        statements_(std::move(statements)),
        guard_(std::move(guard)),
        path_(std::move(path)),
        info_(std::move(info)) {}
  [[nodiscard]] static Result<Statements> prepare(Database& database, const RunInfo& info);
  [[nodiscard]] static Result<RunFile> ready(Database database, const std::string& path, RunInfo info);

  Database database_;
  std::optional<Statements> statements_;  ///< gone after finish()
  WalGuard guard_;
  std::string path_;
  RunInfo info_;
};

}  // namespace gyrotherm
