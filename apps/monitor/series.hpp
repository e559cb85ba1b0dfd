// SPDX-License-Identifier: Apache-2.0
/// What a chart draws: of each channel the lowest and the highest value in each of at most some thousand buckets of
/// equal length. A bucket in which a channel has no value has none: a gap is seen as a gap.
///
/// Of a run that is looked at an overview of 16-s buckets (longer ones of a very long or wide run) stays in memory and
/// grows with the run, so that no chart of hours reads more rows than have come since; shorter stretches are read from
/// the rows themselves.
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

/// A curve of a chart: a column of the record, or the rate from pulses and their interval.
struct SeriesChannel {
  std::string name;
  std::string unit;
  std::string unit_under_test;  ///< empty: of the rig
  std::string sql;              ///< value in a row of `sample`
};
/// Returns the channels of a run: the set point of the profile, the chamber's air and its own set point, thermometers,
/// and the measurements of each unit.
[[nodiscard]] std::vector<SeriesChannel> series_channels(const record::RunInfo& info);

/// Lowest and highest of some channels in buckets of one length, in slots. NaN where there is none.
class Buckets {
 public:
  Buckets(std::size_t channels, std::int64_t first, std::int64_t width);

  /// Takes a value; NaN changes nothing. The slot must not lie before the first.
  void take(std::int64_t slot, std::size_t channel, double value);
  /// There are buckets up to this slot, with values or without.
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
  std::vector<float> low_, high_;  ///< bucket by bucket
};

/// Which channels, by their places in series_channels(); slots from `from` to `to`; at most so many buckets.
struct SeriesWish {
  std::vector<std::size_t> channels;
  std::int64_t from{}, to{};
  std::int64_t buckets = 2000;
};
inline constexpr std::int64_t kMostBuckets = 4000;

/// The overviews of the runs that were looked at last. Any thread.
class SeriesCache {
 public:
  /// `most_bytes` of all overviews; the one that was asked for longest ago goes first.
  explicit SeriesCache(std::size_t most_bytes = kUsualBytes) : most_bytes_(most_bytes) {}

  /// The buckets of the wish, at least one slot wide. Fails with storage or bad_file.
  [[nodiscard]] Result<Buckets> buckets(const FoundRun& run, const SeriesWish& wish);
  [[nodiscard]] std::size_t bytes() const;
  /// Reads on the overviews that are far behind. Until that is done, which one thread does now and then, charts of
  /// their runs are made of the rows: of the channels that are wanted, which is faster once.
  void catch_up();

 private:
  static constexpr std::size_t kUsualBytes = 20'000'000;
  struct Overview {
    std::mutex mutex;
    std::string run;  ///< key, and id of the run, for another record may take a name
    Buckets buckets;
    FoundRun found;         ///< as it was last asked for
    std::int64_t read{-1};  ///< the last slot that is in it
    explicit Overview(std::string of, Buckets empty) : run(std::move(of)), buckets(std::move(empty)) {}
  };
  [[nodiscard]] std::shared_ptr<Overview> overview_of(const FoundRun& run, std::size_t channels);
  [[nodiscard]] Result<void> catch_up(Overview& overview, const FoundRun& run) const;
  [[nodiscard]] static bool is_far_behind(const Overview& overview, const FoundRun& run);
  void make_room();

  std::size_t most_bytes_;
  mutable std::mutex mutex_;
  std::list<std::shared_ptr<Overview>> overviews_;  ///< the last asked for first
};

/// As JSON: {"from", "step", "count", "channels": [{"name", "unit", "low": […], "high": […]}]}; of buckets of one slot
/// "high" is left out.
[[nodiscard]] std::string series_text(const Buckets& buckets, const std::vector<SeriesChannel>& channels);

}  // namespace gyrotherm::monitor
