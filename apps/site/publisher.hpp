// SPDX-License-Identifier: Apache-2.0
/// Sends the runs of a rig and the documents next to them to the store. Active runs are sent second by second from
/// their live copies. The publisher only reads files and does not open a record that is being written. It keeps no
/// local state: it queries the position of each run from the store. So it may be killed at any time, and two publishers
/// may send the same run.
///
/// A fault of one run or document is reported once, and the run or document is retried after a pause. After any fault
/// of the store except a refusal, the publisher connects again, after increasing waits. Used by one thread.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "acquisition/record/run_info.hpp"
#include "acquisition/record/run_source.hpp"
#include "acquisition/record/status_file.hpp"
#include "apps/site/check_histories.hpp"
#include "apps/site/run_text.hpp"
#include "apps/site/site_file.hpp"
#include "apps/site/store.hpp"
#include "core/deadline.hpp"
#include "core/file.hpp"
#include "core/quantity.hpp"
#include "core/random.hpp"
#include "core/result.hpp"

namespace gyrotherm::site {

/// The position of one run on the rig and in the store.
struct RunLag {
  std::string name;
  /// State of the run on the rig.
  std::string state{};
  /// Last slot on the rig.
  std::int64_t slot_on_rig{-1};
  /// Last slot in the store.
  std::int64_t slot_in_store{-1};
  bool finished_in_store{};
  /// Reason why the status of the run cannot be read; empty: none.
  std::string error{};

  [[nodiscard]] std::int64_t seconds() const { return slot_on_rig - slot_in_store; }
};

/// Computes the wait before a retry: twice as long each time, up to `longest`. Part of each wait is random, so the rigs
/// of a site do not all reconnect in the same second.
class Backoff {
 public:
  explicit Backoff(Duration longest, std::uint64_t seed) : longest_(longest), generator_(seed) {}

  /// Returns a random time between half of the current wait and all of it. Doubles the next wait.
  [[nodiscard]] Duration next() {
    const auto whole = std::min(wait_, longest_);
    wait_ = std::min(wait_ * 2, longest_);
    return std::chrono::duration_cast<Duration>(whole * (0.5 + 0.5 * uniform(generator_)));
  }
  /// Resets the wait after a success.
  void reset() { wait_ = kFirstWait; }

 private:
  static constexpr Duration kFirstWait = std::chrono::milliseconds(250);
  Duration longest_;
  Duration wait_ = kFirstWait;
  std::mt19937_64 generator_;
};

/// A document that is sent whenever it has changed. If the store has refused it, it is also sent again after a pause,
/// because the reason may be removed in the meantime.
class WatchedFile {
 public:
  /// Returns whether the file in the state `now` must be sent.
  [[nodiscard]] bool is_due(const FileState& now) const {
    return tried_state_ != now || (retry_at_ && retry_at_->has_passed());
  }
  /// Notes that the file was sent or has a fault of its own, so only a change makes it due.
  void note_done(const FileState& state) {
    tried_state_ = state;
    retry_at_.reset();
  }
  /// Notes that the store has refused the file.
  void note_refusal(const FileState& state, Duration pause) {
    tried_state_ = state;
    retry_at_.emplace(pause);
  }
  /// Fault that was last reported.
  std::string reported_fault{};

 private:
  std::optional<FileState> tried_state_{};
  std::optional<Deadline> retry_at_{};
};

class Publisher {
 public:
  /// Creates a publisher. `report` receives a line for each stored run and document, and for each connection.
  /// `report_fault` receives each fault once. The descriptor `stop` becomes readable when the publisher must stop.
  Publisher(SiteSettings settings, int stop, std::function<void(const std::string&)> report,
            std::function<void(const Fault&)> report_fault);

  /// Sends until `stop` is readable. Fails with bad_file or usage if the first connection fails with one of these,
  /// because a retry would fail again.
  [[nodiscard]] Result<void> serve();
  /// Sends all data that exist now. Fails with the first fault that prevents a file from being sent.
  [[nodiscard]] Result<void> send_once();
  /// Returns the position of each run on the rig and in the store, after a line for each folder that cannot be read.
  /// Sends nothing.
  [[nodiscard]] Result<std::vector<RunLag>> read_lags();
  /// Fails with bad_file, which names the first folder that is missing or cannot be read.
  [[nodiscard]] Result<void> check_folders() const;

 private:
  struct Run {
    /// Identity of the record from which the other members were read.
    FileState file;
    record::RunInfo info;
    /// States of the run's files when its id was last read.
    std::vector<FileState> states{};
    std::vector<StoredChannel> channels{};
    /// Position in the store; empty if it must be queried.
    std::optional<RunPosition> position{};
    std::optional<record::NamedHistory> history{};  ///< check runs of its rig
  };
  /// States of a run's files. A run that was sent completely is read again only if they change.
  struct FileStates {
    FileState record, status, live_copy;
    bool operator==(const FileStates&) const = default;
  };
  /// Pause after a fault of a run. A fault of the files does not pause a run whose files change.
  struct Pause {
    Deadline until;
    /// States of the files at the fault; empty after a refusal of the store.
    std::optional<FileStates> files{};
  };
  struct WatchedRun {
    std::optional<Run> run;
    /// States of the files when they were last looked at.
    FileStates files;
    /// States of the files when the run was last sent completely. While they do not change, nothing is sent.
    std::optional<FileStates> sent_files;
    std::optional<Pause> pause;
    std::string reported_fault;  ///< last reported
  };
  /// States whether a run has more rows to send. A long run is sent in turns, so the other runs need not wait for it.
  enum class Backlog { none, some };

  [[nodiscard]] Result<void> connect();
  void disconnect(const Fault& why);
  void find_files();
  /// Reports each folder that cannot be read, once until it can be read again.
  void report_folders();
  /// Sends one turn of each run, and the new documents. Returns Backlog::some if a run has more rows.
  [[nodiscard]] Result<Backlog> run_round();
  /// Sends one turn of a run. Skips a run that was sent completely and has not changed, or that is paused.
  [[nodiscard]] Result<Backlog> send_run(const std::string& path, WatchedRun& watched);
  [[nodiscard]] static bool is_paused(const WatchedRun& watched);
  /// Pauses a run after its fault, unless the fault is that the run is being written.
  static void pause_run(WatchedRun& watched, const Fault& fault);
  /// Reads the header of the record into `watched` unless it contains this run already. Returns false if the program of
  /// the run has not written the start yet. `is_written`: a program is writing the record.
  [[nodiscard]] static Result<bool> open_run(const record::RecordFiles& files, bool is_written, WatchedRun& watched);
  /// Sends the rows of one turn. If no rows remain, also sends events and gaps. Sends nothing to a closed run.
  [[nodiscard]] Result<Backlog> send_recorded(const record::RecordFiles& files, Run& run);
  [[nodiscard]] Result<void> query_position(Run& run);
  /// Sends the segments of a run that ends by itself if decisions have added some.
  [[nodiscard]] Result<void> send_segments(Run& run);
  [[nodiscard]] Result<Backlog> send_rows(const record::RecordFiles& files, Run& run);
  [[nodiscard]] Result<void> send_events_and_gaps(const record::RecordFiles& files, Run& run);
  /// Sends state, cause and alarms of the status file, if it belongs to this run.
  [[nodiscard]] Result<void> send_live_state(const std::optional<record::RunStatus>& status, Run& run);
  /// Sends state, cause and alarms if they have changed since they were last sent.
  [[nodiscard]] Result<void> send_state(Run& run, const LiveState& now);
  /// Verifies and archives the files of a finished run and closes the run in the store. For an interrupted run, only
  /// sends the last state.
  [[nodiscard]] Result<void> end_run(const record::RecordFiles& files, Run& run);
  /// Sends a document. Ignores a JSON file that is not a document.
  [[nodiscard]] Result<void> send_document(const std::string& path);
  /// Calls `send` if the file is due. Fails only if no other file can be sent either.
  [[nodiscard]] Result<void> send_if_due(WatchedFile& file, const std::string& path,
                                         const std::function<Result<void>()>& send);
  /// Sends the charts of each history of check runs that a record names, if the file has changed.
  [[nodiscard]] Result<void> send_check_standards();
  /// If a fault concerns only one file, reports it once and returns true.
  [[nodiscard]] bool report_file_fault(const Fault& fault, const std::string& path, std::string& reported);

  SiteSettings settings_;
  WaitLimits limits_;
  std::function<void(const std::string&)> report_;
  std::function<void(const Fault&)> report_fault_;
  std::optional<Store> store_;
  bool has_sent_ = false;             ///< a round has succeeded
  std::string reported_store_fault_;  ///< empty while connected
  /// Key: path of the record.
  std::map<std::string, WatchedRun> runs_;
  /// The last reported fault of each folder, by path; empty if it can be read.
  std::map<std::string, std::string> folder_faults_;
  /// The JSON files, by path.
  std::map<std::string, WatchedFile> documents_;
  std::set<std::string> found_documents_;
  /// The histories of check runs, by path.
  std::map<std::string, WatchedFile> histories_;
  /// First fault that concerns one file, in all rounds of send_once().
  std::optional<Fault> first_file_fault_;
};

}  // namespace gyrotherm::site
