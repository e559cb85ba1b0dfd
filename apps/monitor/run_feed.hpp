// SPDX-License-Identifier: Apache-2.0
/// Sends the samples, events and status of a run to its watchers as messages, each once and in order. One thread reads
/// the watched runs. Watchers wait for it; a watcher that is behind reads the missing rows itself.
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

/// Position of a watcher in the feed.
struct FeedPosition {
  /// Slot of the last sample, number of the last event, and version of the last status.
  std::int64_t slot{-1};
  std::int64_t event{-1};
  std::int64_t status_version{-1};
  /// Id of the run. If another run's record replaces it, the feed restarts.
  std::string run{};
};

/// The text of a sample, an event or a status for the page: one line of JSON. The values of a sample are in the order
/// of series_channels(); null for a fault.
struct FeedRow {
  /// Slot of a sample, or number of an event.
  std::int64_t number{};
  std::string text;
};
/// Returns at most `most` samples after `slot`. Fails with storage or bad_file.
[[nodiscard]] Result<std::vector<FeedRow>> read_samples_after(const FoundRun& run, std::int64_t slot,
                                                              std::int64_t most);
/// Returns at most `most` events after the one with `number`. Fails like read_samples_after().
[[nodiscard]] Result<std::vector<FeedRow>> read_events_after(const FoundRun& run, std::int64_t number,
                                                             std::int64_t most);
/// Returns the status with additional data for the page: key, name, age, profile and rig.
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
    /// Returns the messages after `position` as text of an event stream, and advances `position`. Waits at most
    /// `patience` for the first message. Returns an empty text if there is none. Returns at most a few hundred messages
    /// per call.
    [[nodiscard]] std::string next(FeedPosition& position, Duration patience);

   private:
    RunFeed& feed_;
    std::string key_;
  };

  /// Reads new rows of each watched run. Called by one thread, a few times a second.
  void read();
  /// Wakes all watchers. Later calls of next() do not wait.
  void stop();
  [[nodiscard]] int watchers() const;

 private:
  /// Position up to which a run has been read.
  struct ReadPosition {
    /// Last slot and event; −1: none yet.
    std::int64_t slot{-1}, event{-1};
    bool has_begun{};
    /// The run has ended; no rows follow.
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
  /// Rows of a run after a position.
  struct NewRows {
    std::vector<FeedRow> samples, events;
    bool has_run_ended{};
  };
  [[nodiscard]] std::optional<ReadPosition> update_status(const FoundRun& found);
  [[nodiscard]] static std::optional<NewRows> read_new_rows(const FoundRun& found, const ReadPosition& position);
  void add_new_rows(const std::string& key, NewRows news);
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
