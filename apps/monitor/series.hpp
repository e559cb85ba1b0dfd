// SPDX-License-Identifier: Apache-2.0
/// Data of charts: the minimum, maximum and mean of each channel in at most some thousand time buckets of equal width.
/// A bucket may have no value of a channel, so gaps are visible.
///
/// The cache keeps an overview of each viewed run, with buckets of 16 s (wider for a very long run or many channels). A
/// chart of many hours is made from the overview and reads only rows that are new. A chart of a shorter interval is
/// read from the rows.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "acquisition/record/run_info.hpp"
#include "apps/monitor/run_catalogue.hpp"
#include "core/result.hpp"

namespace gyrotherm::monitor {

/// A curve of a chart: a column of the record, or a rate that is computed from pulses and their interval.
struct SeriesChannel {
  std::string name;
  std::string unit;
  /// Empty for a channel of the rig.
  std::string unit_under_test;
  /// SQL expression of the value, in a row of the table `sample`.
  std::string sql;
};
/// Returns the channels of a run: the set point of the profile, the chamber's air and its own set point, thermometers,
/// and the measurements of each unit.
[[nodiscard]] std::vector<SeriesChannel> series_channels(const record::RunInfo& info);

/// Minimum, maximum and mean of some channels in buckets of equal width; NaN if a bucket has no value. Positions and
/// widths are in slots.
class Buckets {
 public:
  Buckets(std::size_t channels, std::int64_t first, std::int64_t width);

  /// Adds a value. Ignores NaN. `slot` must not be below first().
  void add(std::int64_t slot, std::size_t channel, double value);
  /// Adds all values of a channel that a bucket of `other` contains to the bucket of `slot`.
  void merge(std::int64_t slot, std::size_t channel, const Buckets& other, std::size_t bucket,
             std::size_t other_channel);
  /// Adds empty buckets up to the one that contains `slot`, which becomes last_slot() unless a later one is.
  void extend_to(std::int64_t slot);
  /// Merges each pair of adjacent buckets, which doubles the width.
  void merge_pairs();

  /// Slot at which the first bucket begins.
  [[nodiscard]] std::int64_t first() const { return first_; }
  /// Last slot that extend_to() or add() has received; first() − 1 if there is none. Later slots may be in no bucket
  /// yet.
  [[nodiscard]] std::int64_t last_slot() const { return last_slot_; }
  [[nodiscard]] std::int64_t width() const { return width_; }
  [[nodiscard]] std::size_t size() const { return count_; }
  [[nodiscard]] std::size_t channels() const { return channels_; }
  [[nodiscard]] float lowest(std::size_t bucket, std::size_t channel) const { return cell(bucket, channel).low; }
  [[nodiscard]] float highest(std::size_t bucket, std::size_t channel) const { return cell(bucket, channel).high; }
  [[nodiscard]] double mean(std::size_t bucket, std::size_t channel) const;
  [[nodiscard]] std::size_t bytes() const { return cells_.capacity() * sizeof(Cell); }
  /// Returns the memory of this number of buckets, without reserves.
  [[nodiscard]] std::size_t bytes_for(std::size_t buckets) const { return buckets * channels_ * sizeof(Cell); }

 private:
  /// The values of a channel in a bucket.
  struct Cell {
    double sum{};
    float low{std::numeric_limits<float>::quiet_NaN()}, high{std::numeric_limits<float>::quiet_NaN()};
    std::uint32_t count{};
  };
  [[nodiscard]] Cell& cell_at(std::int64_t slot, std::size_t channel);
  [[nodiscard]] const Cell& cell(std::size_t bucket, std::size_t channel) const {
    return cells_[bucket * channels_ + channel];
  }
  static void merge(Cell& into, const Cell& other);

  std::size_t channels_;
  std::int64_t first_, width_, last_slot_;
  std::size_t count_{};
  /// For each bucket, the cells of all channels.
  std::vector<Cell> cells_;
};

/// A request for a chart.
struct SeriesRequest {
  /// Indices in series_channels().
  std::vector<std::size_t> channels;
  /// First and last slot.
  std::int64_t from{}, to{};
  /// Largest number of buckets.
  std::int64_t buckets = 2000;
};
inline constexpr std::int64_t kMaxBuckets = 4000;

/// Overviews of the recently viewed runs. Usable from any thread.
class SeriesCache {
 public:
  /// Creates a cache. If the overviews exceed `max_bytes` in total, the least recently used ones are removed.
  explicit SeriesCache(std::size_t max_bytes = kDefaultBytes) : max_bytes_(max_bytes) {}

  /// Returns the buckets of a chart. Fails with storage or bad_file.
  [[nodiscard]] Result<Buckets> buckets(const FoundRun& run, const SeriesRequest& request);
  [[nodiscard]] std::size_t bytes() const;
  /// Updates the overviews that lack many rows. One thread calls this at intervals. Until then, charts of such a run
  /// are read from the rows, which is faster for a single chart.
  void update_overviews();

 private:
  static constexpr std::size_t kDefaultBytes = 20'000'000;
  struct Overview {
    std::mutex mutex;
    /// Key and id of the run. The record of another run may replace it under the same key.
    std::string run;
    Buckets buckets;
    /// The run as of the last request.
    FoundRun found;
    /// Last slot in the overview.
    std::int64_t last_slot{-1};
    Overview(std::string run_id, Buckets empty) : run(std::move(run_id)), buckets(std::move(empty)) {}
  };
  [[nodiscard]] std::shared_ptr<Overview> find_or_add_overview(const FoundRun& run, std::size_t channels);
  [[nodiscard]] Result<void> update(Overview& overview, const FoundRun& run) const;
  [[nodiscard]] static bool is_far_behind(const Overview& overview, const FoundRun& run);
  void remove_least_recent();

  std::size_t max_bytes_;
  mutable std::mutex mutex_;
  /// The most recently used first.
  std::list<std::shared_ptr<Overview>> overviews_;
};

/// Returns the number of the first row of an imported record at or after `time`, or of the last row if there is none.
/// Fails with storage or bad_file.
[[nodiscard]] Result<std::int64_t> find_imported_row(const FoundRun& run, Duration time);
/// Returns the time of the first row of each bucket of an imported record, in s since its first row; NaN if the bucket
/// has no row. Fails with storage or bad_file.
[[nodiscard]] Result<std::vector<double>> imported_times_s(const FoundRun& run, const Buckets& buckets);

/// Returns JSON: {"from", "step", "count", "last", "channels": [{"name", "unit", "low": […], "high": […], "mean":
/// […]}]}, and "times_s" unless `times_s` is empty. "high" and "mean" are omitted for buckets of one slot.
[[nodiscard]] std::string series_text(const Buckets& buckets, const std::vector<SeriesChannel>& channels,
                                      const std::vector<double>& times_s = {});

}  // namespace gyrotherm::monitor
