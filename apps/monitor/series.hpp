// SPDX-License-Identifier: Apache-2.0
/// Data of charts: the lowest and the highest value of each channel in each of at most some thousand buckets of equal
/// length. A bucket without a value of a channel stays empty, so gaps are visible.
///
/// An overview of each viewed run, with buckets of 16 s (longer for a very long or wide run), stays in memory and grows
/// with the run. A chart of hours then reads only the new rows. Charts of shorter ranges are read from the rows.
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "acquisition/record/run_info.hpp"
#include "apps/monitor/run_catalogue.hpp"
#include "core/result.hpp"

namespace gyrotherm::monitor {

/// A curve of a chart: a column of the record, or the rate computed from pulses and their interval.
struct SeriesChannel {
  std::string name;
  std::string unit;
  /// Empty for a channel of the rig.
  std::string unit_under_test;
  /// Expression for the value in a row of `sample`.
  std::string sql;
};
/// Returns the channels of a run: the set point of the profile, the chamber's air and its own set point, thermometers,
/// and the measurements of each unit.
[[nodiscard]] std::vector<SeriesChannel> series_channels(const record::RunInfo& info);

/// Lowest and highest values of some channels in buckets of equal length. Positions and lengths are in slots. NaN if
/// there is no value.
class Buckets {
 public:
  Buckets(std::size_t channels, std::int64_t first, std::int64_t width);

  /// Adds a value. NaN changes nothing. The slot must not be before the first.
  void take(std::int64_t slot, std::size_t channel, double value);
  /// Adds empty buckets up to this slot.
  void reach(std::int64_t slot);
  /// Doubles the width.
  void coarsen();

  [[nodiscard]] std::int64_t first() const { return first_; }
  [[nodiscard]] std::int64_t width() const { return width_; }
  [[nodiscard]] std::size_t size() const { return count_; }
  [[nodiscard]] std::size_t channels() const { return channels_; }
  [[nodiscard]] float lowest(std::size_t bucket, std::size_t channel) const {
    return low_[bucket * channels_ + channel];
  }
  [[nodiscard]] float highest(std::size_t bucket, std::size_t channel) const {
    return high_[bucket * channels_ + channel];
  }
  [[nodiscard]] std::size_t bytes() const { return (low_.capacity() + high_.capacity()) * sizeof(float); }

 private:
  std::size_t channels_;
  std::int64_t first_, width_;
  std::size_t count_{};
  /// The values of all channels for the first bucket, then for the next one.
  std::vector<float> low_, high_;
};

/// A request for a chart: channels by their positions in series_channels(), the slots `from` to `to`, and the largest
/// number of buckets.
struct SeriesRequest {
  std::vector<std::size_t> channels;
  std::int64_t from{}, to{};
  std::int64_t buckets = 2000;
};
inline constexpr std::int64_t kMaxBuckets = 4000;

/// The overviews of the recently viewed runs. Usable from any thread.
class SeriesCache {
 public:
  /// Creates a cache. `max_bytes` limits the total size of all overviews; the least recently used one is removed
  /// first.
  explicit SeriesCache(std::size_t max_bytes = kDefaultBytes) : max_bytes_(max_bytes) {}

  /// Returns the requested buckets, at least one slot wide. Fails with storage or bad_file.
  [[nodiscard]] Result<Buckets> buckets(const FoundRun& run, const SeriesRequest& request);
  [[nodiscard]] std::size_t bytes() const;
  /// Updates overviews that are far behind. Called by one thread at intervals. Until an overview is updated, charts of
  /// its run are read from the rows of the requested channels, which is faster for a single chart.
  void catch_up();

 private:
  static constexpr std::size_t kDefaultBytes = 20'000'000;
  struct Overview {
    std::mutex mutex;
    /// Key and id of the run. The key is not sufficient, because another record may replace the run's under the same
    /// name.
    std::string run;
    Buckets buckets;
    /// The run at the last request.
    FoundRun found;
    /// Last slot contained in the overview.
    std::int64_t read{-1};
    explicit Overview(std::string of, Buckets empty) : run(std::move(of)), buckets(std::move(empty)) {}
  };
  [[nodiscard]] std::shared_ptr<Overview> find_or_add_overview(const FoundRun& run, std::size_t channels);
  [[nodiscard]] Result<void> catch_up(Overview& overview, const FoundRun& run) const;
  [[nodiscard]] static bool is_far_behind(const Overview& overview, const FoundRun& run);
  void evict();

  std::size_t max_bytes_;
  mutable std::mutex mutex_;
  /// The most recently used first.
  std::list<std::shared_ptr<Overview>> overviews_;
};

/// Returns JSON: {"from", "step", "count", "channels": [{"name", "unit", "low": […], "high": […]}]}. "high" is omitted
/// for buckets of one slot.
[[nodiscard]] std::string series_text(const Buckets& buckets, const std::vector<SeriesChannel>& channels);

}  // namespace gyrotherm::monitor
