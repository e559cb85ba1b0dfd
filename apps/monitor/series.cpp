// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/series.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>

#include "acquisition/record/row.hpp"
#include "acquisition/record/run_source.hpp"
#include "core/json.hpp"

namespace gyrotherm::monitor {
namespace {

constexpr std::int64_t kMinOverviewWidth = 16;  ///< slots
/// Largest number of rows per query. The record is open during a query, and a program that resumes the run must wait
/// until it is closed.
constexpr std::int64_t kMaxRowsPerQuery = 20'000;

std::string quoted(const std::string& name) { return '"' + name + '"'; }

SeriesChannel chamber_channel(const char* column) { return {column, "°C", {}, quoted(column)}; }

/// Returns the channel of the measured rate of an axis, which includes the Earth rate.
SeriesChannel rate_channel(const record::ChannelColumn& column, const record::UnitInfo& unit,
                           const std::string& interval) {
  const auto& axis = unit.axes[column.index];
  // Length of the suffix "pulses".
  constexpr std::size_t kSuffixLength = 6;
  auto name = column.name.substr(0, column.name.size() - std::min(kSuffixLength, column.name.size())) + "rate";
  const bool is_pulse_count = axis.kind == record::GyroKind::pulse_count;
  auto sql = is_pulse_count
                 ? fmt::format("{} * {:.17e} / nullif({}, 0)", quoted(column.name), axis.scale * 1e9, interval)
                 : fmt::format("{} * {:.17e}", quoted(column.name), axis.scale);
  return {std::move(name), "°/h", unit.name, std::move(sql)};
}

}  // namespace

std::vector<SeriesChannel> series_channels(const record::RunInfo& info) {
  std::vector<SeriesChannel> channels{chamber_channel("set_point_c"), chamber_channel("chamber_air_c"),
                                      chamber_channel("chamber_set_point_c")};
  const auto columns = record::channel_columns(info);
  for (const auto& column : columns) {
    switch (column.measures) {
      case record::Measures::temperature: {
        const auto& thermometer = info.thermometers[column.index];
        channels.push_back({column.name, thermometer.unit, thermometer.unit_under_test, quoted(column.name)});
        break;
      }
      case record::Measures::rotation: {
        const auto interval = std::ranges::find_if(columns, [&](const auto& other) {
          return other.measures == record::Measures::interval && other.unit == column.unit;
        });
        if (interval != columns.end())
          channels.push_back(rate_channel(column, info.units[column.unit], quoted(interval->name)));
        break;
      }
      case record::Measures::value: {
        const auto& unit = info.units[column.unit];
        channels.push_back({column.name, unit.values[column.index].unit, unit.name, quoted(column.name)});
        break;
      }
      case record::Measures::true_bias:
        if (info.virtual_rig)
          channels.push_back({column.name, "°/h", info.units[column.unit].name, quoted(column.name)});
        break;
      case record::Measures::humidity: channels.push_back({column.name, "%", "", quoted(column.name)}); break;
      case record::Measures::dew_point: channels.push_back({column.name, "°C", "", quoted(column.name)}); break;
      case record::Measures::interval: break;
    }
  }
  return channels;
}

Buckets::Buckets(std::size_t channels, std::int64_t first, std::int64_t width)
    : channels_(channels), first_(first), width_(width), last_slot_(first - 1) {}

void Buckets::extend_to(std::int64_t slot) {
  last_slot_ = std::max(last_slot_, slot);
  const auto required = static_cast<std::size_t>((slot - first_) / width_ + 1);
  if (required <= count_) return;
  count_ = required;
  cells_.resize(count_ * channels_);
}

Buckets::Cell& Buckets::cell_at(std::int64_t slot, std::size_t channel) {
  extend_to(slot);
  return cells_[static_cast<std::size_t>((slot - first_) / width_) * channels_ + channel];
}

void Buckets::merge(Cell& into, const Cell& other) {
  if (other.count == 0) return;
  if (!(into.low <= other.low)) into.low = other.low;
  if (!(into.high >= other.high)) into.high = other.high;
  into.sum += other.sum;
  into.count += other.count;
}

void Buckets::add(std::int64_t slot, std::size_t channel, double value) {
  if (std::isnan(value)) return;
  const auto number = static_cast<float>(value);
  merge(cell_at(slot, channel), {.sum = value, .low = number, .high = number, .count = 1});
}

void Buckets::merge(std::int64_t slot, std::size_t channel, const Buckets& other, std::size_t bucket,
                    std::size_t other_channel) {
  const auto& from = other.cell(bucket, other_channel);
  if (from.count > 0) merge(cell_at(slot, channel), from);
}

double Buckets::mean(std::size_t bucket, std::size_t channel) const {
  const auto& [sum, low, high, count] = cell(bucket, channel);
  // Low and high are rounded to float, the mean is not.
  return count == 0 ? std::numeric_limits<double>::quiet_NaN()
                    : std::clamp(sum / count, static_cast<double>(low), static_cast<double>(high));
}

void Buckets::merge_pairs() {
  Buckets coarse(channels_, first_, 2 * width_);
  for (std::size_t bucket = 0; bucket < count_; ++bucket)
    for (std::size_t channel = 0; channel < channels_; ++channel)
      coarse.merge(first_ + static_cast<std::int64_t>(bucket) * width_, channel, *this, bucket, channel);
  if (count_ > 0) coarse.extend_to(first_ + static_cast<std::int64_t>(count_) * width_ - 1);
  coarse.last_slot_ = last_slot_;
  *this = std::move(coarse);
}

namespace {

std::string sql_columns(const std::vector<SeriesChannel>& channels, const std::vector<std::size_t>& selected) {
  std::string columns = "slot";
  for (const auto channel : selected) columns += ", " + channels[channel].sql;
  return columns;
}

std::vector<std::size_t> all_channels(std::size_t channels) {
  std::vector<std::size_t> all(channels);
  for (std::size_t i = 0; i < channels; ++i) all[i] = i;
  return all;
}

/// Adds the rows of the slots `from` to `to` to the buckets. Reads them in several queries. Returns the last slot read.
Result<std::int64_t> add_rows(const FoundRun& run, const std::vector<std::size_t>& channels, std::int64_t from,
                              std::int64_t to, const std::function<void(std::int64_t)>& before_row, Buckets& into) {
  const auto columns = sql_columns(series_channels(*run.info), channels);
  auto last = from - 1;
  for (std::int64_t row_count = kMaxRowsPerQuery; row_count == kMaxRowsPerQuery;) {
    const auto files = record::find_source_files(run.path, run.is_running());
    if (!files) return failure(files.error());
    row_count = 0;
    const auto read =
        record::each_row(*files, {.what = columns, .first = last + 1, .last = to, .most = kMaxRowsPerQuery},
                         [&](const record::Statement& row) {
                           last = row.integer(0);
                           ++row_count;
                           before_row(last);
                           into.extend_to(last);
                           for (std::size_t i = 0; i < channels.size(); ++i)
                             into.add(last, i, row.real(1 + static_cast<int>(i)));
                           return true;
                         });
    if (!read) return failure(read.error());
  }
  return last;
}

/// Makes the requested buckets from an overview. `width` is a multiple of the overview's width.
Buckets make_from_overview(const Buckets& overview, const SeriesRequest& request, std::int64_t width) {
  const auto first = request.from / overview.width() * overview.width();
  Buckets buckets(request.channels.size(), first, width);
  for (auto slot = first; slot <= request.to; slot += overview.width()) {
    const auto bucket = static_cast<std::size_t>((slot - overview.first()) / overview.width());
    if (bucket >= overview.size()) break;
    buckets.extend_to(std::min(slot + overview.width() - 1, overview.last_slot()));
    for (std::size_t i = 0; i < request.channels.size(); ++i)
      buckets.merge(slot, i, overview, bucket, request.channels[i]);
  }
  return buckets;
}

}  // namespace

Result<void> SeriesCache::update(Overview& overview, const FoundRun& run) const {
  const auto max_overview_bytes = max_bytes_ / 2;
  const auto limit_size = [&](std::int64_t slot) {
    auto& buckets = overview.buckets;
    const auto required_bytes = [&] { return buckets.bytes_for(static_cast<std::size_t>(slot / buckets.width() + 1)); };
    while (required_bytes() > max_overview_bytes) buckets.merge_pairs();
  };
  const auto read = add_rows(run, all_channels(overview.buckets.channels()), overview.last_slot + 1, record::kNoEnd - 1,
                             limit_size, overview.buckets);
  if (!read) return failure(read.error());
  overview.last_slot = *read;
  return {};
}

std::shared_ptr<SeriesCache::Overview> SeriesCache::find_or_add_overview(const FoundRun& run, std::size_t channels) {
  const std::lock_guard lock(mutex_);
  const auto run_id = run.key + run.status.id;
  auto found = std::ranges::find_if(overviews_, [&](const auto& overview) { return overview->run == run_id; });
  if (found == overviews_.end())
    overviews_.push_front(std::make_shared<Overview>(run_id, Buckets(channels, 0, kMinOverviewWidth)));
  else
    overviews_.splice(overviews_.begin(), overviews_, found);
  return overviews_.front();
}

void SeriesCache::remove_least_recent() {
  const std::lock_guard lock(mutex_);
  std::size_t sum = 0;
  for (auto overview = overviews_.begin(); overview != overviews_.end();) {
    if (const std::unique_lock in_use((*overview)->mutex, std::try_to_lock); in_use)
      sum += (*overview)->buckets.bytes();
    overview = sum > max_bytes_ && overview != overviews_.begin() ? overviews_.erase(overview) : std::next(overview);
  }
}

std::size_t SeriesCache::bytes() const {
  const std::lock_guard lock(mutex_);
  std::size_t sum = 0;
  for (const auto& overview : overviews_) {
    const std::lock_guard in_use(overview->mutex);
    sum += overview->buckets.bytes();
  }
  return sum;
}

bool SeriesCache::is_far_behind(const Overview& overview, const FoundRun& run) {
  constexpr std::int64_t kMaxLag = 2 * kMaxRowsPerQuery;
  return run.status.slot - overview.last_slot > kMaxLag;
}

void SeriesCache::update_overviews() {
  std::list<std::shared_ptr<Overview>> overviews;
  {
    const std::lock_guard lock(mutex_);
    overviews = overviews_;
  }
  for (const auto& overview : overviews) {
    const std::lock_guard lock(overview->mutex);
    if (is_far_behind(*overview, overview->found)) (void)update(*overview, overview->found);
  }
  remove_least_recent();
}

Result<Buckets> SeriesCache::buckets(const FoundRun& run, const SeriesRequest& request) {
  const auto slots = std::max<std::int64_t>(1, request.to - request.from + 1);
  const auto max_buckets = std::clamp<std::int64_t>(request.buckets, 1, kMaxBuckets);
  auto width = (slots + max_buckets - 1) / max_buckets;
  if (width >= kMinOverviewWidth) {
    const auto overview = find_or_add_overview(run, series_channels(*run.info).size());
    if (const std::unique_lock lock(overview->mutex, std::try_to_lock); lock) {
      overview->found = run;
      if (!is_far_behind(*overview, run)) {
        if (const auto read = update(*overview, run); !read) return failure(read.error());
        const auto finest = overview->buckets.width();
        width = std::max((width + finest - 1) / finest, std::int64_t{1}) * finest;
        return make_from_overview(overview->buckets, request, width);
      }
    }
  }
  Buckets buckets(request.channels.size(), request.from, width);
  const auto read = add_rows(
      run, request.channels, request.from, request.to, [](std::int64_t) {}, buckets);
  if (!read) return failure(read.error());
  return buckets;
}

namespace {

/// Adds an array of `count` numbers. `digits` is the number of significant digits.
void add_numbers(std::string& text, std::size_t count, int digits, const auto& number_at) {
  text += '[';
  for (std::size_t i = 0; i < count; ++i) {
    const double value = number_at(i);
    if (i > 0) text += ',';
    if (std::isfinite(value))
      fmt::format_to(std::back_inserter(text), "{:.{}g}", value, digits);
    else
      text += "null";
  }
  text += ']';
}

/// Adds a channel with its arrays. A bucket of one slot has one value.
void add_channel(std::string& text, const Buckets& buckets, std::size_t channel, const SeriesChannel& description) {
  constexpr int kDigits = 7;  // a float has no more
  const auto add = [&](const char* key, const auto& number_at) {
    text += fmt::format(R"(,"{}":)", key);
    add_numbers(text, buckets.size(), kDigits, number_at);
  };
  text += fmt::format(R"({{"name":{},"unit":{})", json_text(Json(description.name)), json_text(Json(description.unit)));
  add("low", [&](std::size_t i) { return static_cast<double>(buckets.lowest(i, channel)); });
  if (buckets.width() > 1) {
    add("high", [&](std::size_t i) { return static_cast<double>(buckets.highest(i, channel)); });
    add("mean", [&](std::size_t i) { return buckets.mean(i, channel); });
  }
  text += '}';
}

Result<Duration> read_row_time(const FoundRun& run, const record::RecordFiles& files, std::int64_t slot) {
  std::optional<Duration> time;
  const auto read = record::each_row(files, {.what = "slot, monotonic_ns", .first = slot, .last = slot},
                                     [&](const record::Statement& row) {
                                       time = Duration(row.integer(1));
                                       return true;
                                     });
  if (!read) return failure(read.error());
  if (!time) return failure(FaultKind::bad_file, run.path, fmt::format("row {} is missing", slot));
  return *time;
}

}  // namespace

/// Bisects, because the times of the rows increase and have no index.
Result<std::int64_t> find_imported_row(const FoundRun& run, Duration time) {
  const auto files = record::find_source_files(run.path, run.is_running());
  if (!files) return failure(files.error());
  std::int64_t low = 0, high = std::max<std::int64_t>(0, run.status.slot);
  while (low < high) {
    const auto middle = low + (high - low) / 2;
    const auto found = read_row_time(run, *files, middle);
    if (!found) return failure(found.error());
    if (*found < time)
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

Result<std::vector<double>> imported_times_s(const FoundRun& run, const Buckets& buckets) {
  std::vector<double> times_s(buckets.size(), std::numeric_limits<double>::quiet_NaN());
  if (times_s.empty()) return times_s;
  const auto files = record::find_source_files(run.path, run.is_running());
  if (!files) return failure(files.error());
  const auto last = buckets.first() + static_cast<std::int64_t>(buckets.size() - 1) * buckets.width();
  const auto first_rows = fmt::format(
      "(WITH RECURSIVE bucket(start) AS (SELECT {} UNION ALL SELECT start + {} FROM bucket WHERE start < {}) SELECT "
      "sample.slot AS slot, monotonic_ns FROM bucket CROSS JOIN sample ON sample.slot = bucket.start)",
      buckets.first(), buckets.width(), last);
  const auto read = record::each_row(
      *files, {.what = "slot, monotonic_ns", .table = first_rows, .first = buckets.first(), .last = last},
      [&](const record::Statement& row) {
        const auto bucket = static_cast<std::size_t>((row.integer(0) - buckets.first()) / buckets.width());
        times_s[bucket] = to_seconds(Duration(row.integer(1)));
        return true;
      });
  return read.map([&] { return std::move(times_s); });
}

std::string series_text(const Buckets& buckets, const std::vector<SeriesChannel>& channels,
                        const std::vector<double>& times_s) {
  auto text = fmt::format(R"({{"from":{},"step":{},"count":{},"last":{},)", buckets.first(), buckets.width(),
                          buckets.size(), buckets.last_slot());
  if (!times_s.empty()) {
    constexpr int kTimeDigits = 12;  // milliseconds of ten years
    text += R"("times_s":)";
    add_numbers(text, times_s.size(), kTimeDigits, [&](std::size_t i) { return times_s[i]; });
    text += ',';
  }
  text += R"("channels":[)";
  for (std::size_t i = 0; i < buckets.channels(); ++i) {
    if (i > 0) text += ',';
    add_channel(text, buckets, i, channels[i]);
  }
  return text + "]}";
}

}  // namespace gyrotherm::monitor
