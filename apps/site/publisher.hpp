// SPDX-License-Identifier: Apache-2.0
/// Sends the runs of a rig to the store: finished ones whole, running ones second by second from their live copies, and
/// the documents next to them. It only reads files, and never opens a record that is being written. It stores nothing
/// locally: the store returns the position of each run. The publisher may therefore be killed at any time, and two
/// publishers may send the same run.
///
/// A refusal of the store is reported once, and the run waits until its files change. Every other fault is followed by
/// a retry, after increasing waits. One thread.
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
  /// Reason why the run is not sent; empty: none.
  std::string trouble{};

  [[nodiscard]] std::int64_t seconds() const { return slot_on_rig - slot_in_store; }
};

/// Computes the wait before a failed attempt is repeated: twice as long each time, up to a longest wait. A part of each
/// wait is random, so that a hundred rigs that lost their store together do not all return in the same second.
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
  void reset() { wait_ = kFirst; }

 private:
  static constexpr Duration kFirst = std::chrono::milliseconds(250);
  Duration longest_;
  Duration wait_ = kFirst;
  std::mt19937_64 generator_;
};

class Publisher {
 public:
  /// `report` receives a line for each change of state, `complain` each fault, once. The publisher stops once `stop` is
  /// readable.
  Publisher(SiteSettings settings, int stop, std::function<void(const std::string&)> report,
            std::function<void(const Fault&)> complain);

  /// Sends until `stop` is readable. Fails with bad_file or usage if the first connection fails with one of these,
  /// because waiting does not help then.
  [[nodiscard]] Result<void> serve();
  /// Sends everything that exists now. Fails with the first fault that prevents a file from being sent.
  [[nodiscard]] Result<void> once();
  /// Returns the position of each run in the store. Sends nothing.
  [[nodiscard]] Result<std::vector<RunLag>> lags();

 private:
  struct Run {
    /// File from which the other members were read.
    FileState file;
    record::RunInfo info;
    /// The run's files when its id was last read.
    std::vector<FileState> states{};
    std::vector<StoredChannel> channels{};
    /// Position in the store; queried again on a new connection.
    std::optional<RunPosition> position{};
  };
  /// The state of a run's files. A run that was sent completely is read again only when this state changes.
  struct Stamp {
    FileState record, status, live_copy;
    bool operator==(const Stamp&) const = default;
  };
  struct Watched {
    std::optional<Run> run;
    std::optional<Stamp> settled;
    /// Pause after the store's refusal.
    std::optional<Deadline> paused_until;
    std::string trouble;  ///< last reported trouble
  };
  /// Indicates whether more rows can be sent immediately. Sending a long run is interrupted for the other runs.
  enum class Backlog { none, some };

  [[nodiscard]] Result<void> connect();
  void disconnect(const Fault& why);
  void find_files();
  /// Sends the rows of one turn for each run found, and the new documents. Returns Backlog::some if a run has more
  /// rows.
  [[nodiscard]] Result<Backlog> round();
  /// Sends the rows of one turn for one run. Skips it if its files are unchanged since it was sent whole, or if the
  /// store refused it a short time ago.
  [[nodiscard]] Result<Backlog> send_run(const std::string& path, Watched& watched);
  /// Reads the run of the files into `watched` if it is not the run that `watched` contains. Returns false while that
  /// run is being prepared. `is_written`: a program is writing the record.
  [[nodiscard]] static Result<bool> open_run(const record::RecordFiles& files, bool is_written, Watched& watched);
  /// Sends the rows of a turn and, if these are all, the events and gaps. Sends nothing to a closed run.
  [[nodiscard]] Result<Backlog> send_recorded(const record::RecordFiles& files, Run& run);
  [[nodiscard]] Result<void> query_position(Run& run);
  [[nodiscard]] Result<Backlog> send_rows(const record::RecordFiles& files, Run& run);
  [[nodiscard]] Result<void> send_events_and_gaps(const record::RecordFiles& files, Run& run);
  /// Sends state, cause and alarms from a status file, if it belongs to this run.
  [[nodiscard]] Result<void> send_live_state(const std::optional<record::RunStatus>& status, Run& run);
  /// Sends state, cause and alarms if one of them differs from the last that were sent.
  [[nodiscard]] Result<void> send_state(Run& run, const LiveState& now);
  /// Archives the files of a finished run and closes it in the store. Sends the last state of an interrupted run.
  [[nodiscard]] Result<void> end_run(const record::RecordFiles& files, Run& run);
  [[nodiscard]] Result<void> send_document(const std::string& path);
  /// Returns true if the fault concerns this file only, and reports it once.
  [[nodiscard]] bool report_file_fault(const Fault& fault, const std::string& path, std::string& reported);

  SiteSettings settings_;
  WaitLimits limits_;
  std::function<void(const std::string&)> report_;
  std::function<void(const Fault&)> complain_;
  std::optional<Store> store_;
  bool has_sent_ = false;      ///< a round has succeeded
  std::string store_trouble_;  ///< last reported trouble
  /// Key: path of the record.
  std::map<std::string, Watched> runs_;
  /// Files that were sent, or that are not documents.
  std::map<std::string, FileState> documents_;
  std::set<std::string> found_documents_;
  /// First fault of this round that concerns one file.
  std::optional<Fault> first_trouble_;
};

}  // namespace gyrotherm::site
