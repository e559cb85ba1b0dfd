// SPDX-License-Identifier: Apache-2.0
/// Sends the samples, events and status of a run to its watchers as messages, each once and in order. One thread reads
/// the new rows of the watched runs. A watcher whose position is before the rows in memory reads the older rows itself.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "apps/monitor/run_catalogue.hpp"
#include "core/quantity.hpp"

namespace gyrotherm::monitor {

/// Position of a watcher in the feed of a run.
struct FeedPosition {
  /// Slot of the last sample, number of the last event, and version of the last status.
  std::int64_t slot{-1};
  std::int64_t event{-1};
  std::int64_t status_version{-1};
  /// Id of the run. If the record of another run replaces it, the feed restarts.
  std::string run{};
  /// Omits the samples before those in memory.
  bool skips_old_samples{};
};

/// A sample or an event as one line of JSON. The values of a sample are in the order of series_channels(); null for a
/// fault.
struct FeedRow {
  /// Slot of a sample, or number of an event.
  std::int64_t number{};
  std::string text;
};
/// Reads at most `max_rows` samples after `slot`. Fails with storage or bad_file.
[[nodiscard]] Result<std::vector<FeedRow>> read_samples_after(const FoundRun& run, std::int64_t slot,
                                                              std::int64_t max_rows);
/// Reads at most `max_rows` events after the event `number`. Fails like read_samples_after().
[[nodiscard]] Result<std::vector<FeedRow>> read_events_after(const FoundRun& run, std::int64_t number,
                                                             std::int64_t max_rows);
/// Returns the status as JSON, with additional data for the page: key, name, age, profile and rig.
[[nodiscard]] std::string status_text(const FoundRun& run);

class RunFeed {
 public:
  explicit RunFeed(const RunCatalogue& catalogue) : catalogue_(catalogue) {}

  /// Registers a watcher of a run. The registration ends when this object is destroyed.
  class Watch {
   public:
    Watch(RunFeed& feed, std::string key);
    ~Watch();
    Watch(const Watch&) = delete;
    Watch& operator=(const Watch&) = delete;
    /// Waits for messages after `position`, advances `position`, and returns the messages as text of an event stream:
    /// at most a few hundred, or an empty text if none arrives in time.
    [[nodiscard]] std::string wait_for_messages(FeedPosition& position, Duration timeout);

   private:
    RunFeed& feed_;
    std::string key_;
  };

  /// Reads new rows of each watched run. Called by one thread, a few times a second.
  void read();
  /// Wakes all watchers. Later calls of wait_for_messages() return immediately.
  void stop();
  /// Returns the number of watchers of all runs.
  [[nodiscard]] int watchers() const;

 private:
  /// Position up to which a run has been read.
  struct ReadPosition {
    /// Last slot and event; −1: none yet.
    std::int64_t slot{-1}, event{-1};
    bool has_begun{};
    /// The run has ended, and all its rows have been read.
    bool is_complete{};
  };
  struct Run {
    int watchers{};
    /// Id of the run to which the rows belong.
    std::string id{};
    /// The last rows, without gaps.
    std::deque<FeedRow> samples{};
    std::deque<FeedRow> events{};
    ReadPosition read{};
    std::int64_t status_version{-1};
    std::string status{};
  };
  /// Rows of a run after the position up to which it has been read.
  struct NewRows {
    std::vector<FeedRow> samples, events;
    bool has_run_ended{};
    /// The samples begin after the position: the run is too fast to be read completely.
    bool has_skipped{};
  };
  [[nodiscard]] std::optional<ReadPosition> update_status(const FoundRun& found);
  [[nodiscard]] static std::optional<NewRows> read_new_rows(const FoundRun& found, const ReadPosition& position);
  void add_new_rows(const std::string& key, NewRows rows);
  [[nodiscard]] static bool has_all_after(const Run& run, const FeedPosition& position);
  [[nodiscard]] static std::string next_messages(const Run& run, FeedPosition& position);
  [[nodiscard]] std::string read_older_messages(const std::string& key, FeedPosition& position) const;

  const RunCatalogue& catalogue_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::map<std::string, Run> runs_;
  bool stopped_{};
};

}  // namespace gyrotherm::monitor
