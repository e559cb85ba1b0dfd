// SPDX-License-Identifier: Apache-2.0
/// What happens in a run, as messages for whoever watches it: its samples, events and status, each once and in order.
/// One thread reads the runs that are watched; watchers wait for it, and one that is behind reads what it missed
/// itself.
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

/// How far a watcher has come.
struct FeedPlace {
  std::int64_t slot{-1};            ///< of the last sample that it has
  std::int64_t event{-1};           ///< the last event, by its number in the record
  std::int64_t status_version{-1};  ///< of the last status
  std::string run{};                ///< its id; once another one's record lies there, this begins anew
};

/// The text of a sample, an event and a status as the page gets them: one line of JSON. The values of a sample stand in
/// the order of series_channels(); null where an instrument gave a fault.
struct FeedRow {
  std::int64_t number{};  ///< slot, or the number of an event
  std::string text;
};
/// The samples after `slot`, at most `most`. Fails with storage or bad_file.
[[nodiscard]] Result<std::vector<FeedRow>> samples_after(const FoundRun& run, std::int64_t slot, std::int64_t most);
/// The events after the one with that number, at most `most`.
[[nodiscard]] Result<std::vector<FeedRow>> events_after(const FoundRun& run, std::int64_t number, std::int64_t most);
/// The status with what the page needs beside it: key, name, channels, age, and when the run will end.
[[nodiscard]] std::string status_text(const FoundRun& run);

class RunFeed {
 public:
  explicit RunFeed(const RunCatalogue& catalogue) : catalogue_(catalogue) {}

  /// Counts the watchers of a run as long as it lives.
  class Watch {
   public:
    Watch(RunFeed& feed, std::string key);
    ~Watch();
    Watch(const Watch&) = delete;
    Watch& operator=(const Watch&) = delete;
    /// The messages after `place`, as text of an event stream, and the place after them; waits at most `patience` for
    /// the first. Empty: nothing happened. At most a few hundred at once.
    [[nodiscard]] std::string next(FeedPlace& place, Duration patience);

   private:
    RunFeed& feed_;
    std::string key_;
  };

  /// Reads what is new in each run that is watched. One thread calls it, a few times a second.
  void read();
  /// Wakes every watcher, for good.
  void stop();
  [[nodiscard]] int watchers() const;

 private:
  /// How far a run has been read.
  struct ReadPosition {
    std::int64_t slot{-1}, event{-1};  ///< last ones read; −1: none yet
    bool has_begun{};
    bool is_complete{};  ///< no rows follow: the run is over
  };
  struct Run {
    int watchers{};
    std::string id{};               ///< of the run whose rows these are
    std::deque<FeedRow> samples{};  ///< the last ones, without a hole
    std::deque<FeedRow> events{};
    ReadPosition read{};
    std::int64_t status_version{-1};
    std::string status{};
  };
  /// The rows of a run after a position.
  struct News {
    std::vector<FeedRow> samples, events;
    bool run_is_over{};
  };
  [[nodiscard]] std::optional<ReadPosition> take_status(const FoundRun& found);
  [[nodiscard]] static std::optional<News> read_news(const FoundRun& found, const ReadPosition& position);
  void take_news(const std::string& key, News news);
  [[nodiscard]] static bool holds_all_after(const Run& run, const FeedPlace& place);
  [[nodiscard]] static std::string take_messages(const Run& run, FeedPlace& place);
  [[nodiscard]] std::string read_missed(const std::string& key, FeedPlace& place) const;

  const RunCatalogue& catalogue_;
  mutable std::mutex mutex_;
  std::condition_variable something_;
  std::map<std::string, Run> runs_;
  bool stopped_{};
};

}  // namespace gyrotherm::monitor
