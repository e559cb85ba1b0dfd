// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/series.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <random>

#include "apps/monitor/run_feed.hpp"
#include "tests/apps/monitor/small_run.hpp"
#include "tests/support/folder.hpp"

namespace gyrotherm::monitor {
namespace {

// After the set point and the chamber's two channels.
constexpr std::size_t kThermometer = 3;
constexpr std::size_t kRate = 4;

TEST(Buckets, HaveLowestAndHighestValue) {
  Buckets buckets(1, 100, 10);
  for (const auto value : {3.0, -1.0, 2.0}) buckets.add(105, 0, value);
  buckets.add(131, 0, 7);
  ASSERT_EQ(buckets.size(), 4u);
  EXPECT_EQ(buckets.lowest(0, 0), -1);
  EXPECT_EQ(buckets.highest(0, 0), 3);
  EXPECT_TRUE(std::isnan(buckets.lowest(1, 0)));
  EXPECT_EQ(buckets.lowest(3, 0), 7);
}

TEST(Buckets, HaveMeanOfValuesAndNotOfRange) {
  Buckets buckets(2, 0, 4);
  for (const auto value : {0.0, 0.0, 0.0, 8.0}) buckets.add(1, 0, value);
  buckets.add(5, 0, 4);
  buckets.add(6, 1, -2.5);
  EXPECT_EQ(buckets.mean(0, 0), 2);
  EXPECT_TRUE(std::isnan(buckets.mean(0, 1)));
  EXPECT_EQ(buckets.mean(1, 0), 4);
  EXPECT_EQ(buckets.last_slot(), 6);
  buckets.merge_pairs();
  EXPECT_EQ(buckets.mean(0, 0), 12.0 / 5) << "weighted by the counts";
  EXPECT_EQ(buckets.mean(0, 1), -2.5);
  EXPECT_EQ(buckets.last_slot(), 6);
}

TEST(Buckets, HaveMeanOfQuantisedRampThatRisesSteadily) {
  Buckets buckets(1, 0, 100);
  for (std::int64_t slot = 0; slot < 1000; ++slot)
    buckets.add(slot, 0, std::round(20 + static_cast<double>(slot) / 500));
  ASSERT_EQ(buckets.size(), 10u);
  EXPECT_EQ(buckets.mean(0, 0), 20);
  EXPECT_NEAR(buckets.mean(2, 0), 20.5, 0.01);
  EXPECT_EQ(buckets.mean(4, 0), 21);
}

TEST(Buckets, AreEqualWhenCoarsened) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  Buckets fine(2, 0, 4), wide(2, 0, 16);
  for (std::int64_t slot = 0; slot < 1000; ++slot)
    for (std::size_t channel = 0; channel < 2; ++channel) {
      const double value = random() % 5 == 0 ? NAN : normal(random);
      fine.add(slot, channel, value);
      wide.add(slot, channel, value);
    }
  fine.merge_pairs();
  fine.merge_pairs();
  ASSERT_EQ(fine.size(), wide.size());
  for (std::size_t bucket = 0; bucket < wide.size(); ++bucket) {
    EXPECT_EQ(fine.lowest(bucket, 1), wide.lowest(bucket, 1)) << bucket;
    EXPECT_EQ(fine.highest(bucket, 1), wide.highest(bucket, 1)) << bucket;
    EXPECT_NEAR(fine.mean(bucket, 1), wide.mean(bucket, 1), 1e-12) << bucket;
  }
}

class SeriesOfARun : public ::testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(folder_ / "");
    write_small_run(folder_ / "run.db", kSeconds, 3000, 3999, {17});
    run_ = found_in(folder_ / "");
    ASSERT_TRUE(run_.info);
  }
  static constexpr std::int64_t kSeconds = 40'000;
  tests::TestFolder folder_;
  FoundRun run_;
  SeriesCache cache_;
};

TEST_F(SeriesOfARun, ShowsSingleSecondUnchanged) {
  const auto made = cache_.buckets(run_, {.channels = {kThermometer, kRate}, .from = 10, .to = 19});
  ASSERT_TRUE(made) << text(made.error());
  EXPECT_EQ(made->width(), 1);
  ASSERT_EQ(made->size(), 10u);
  EXPECT_FLOAT_EQ(made->lowest(2, 0), 0.12f);
  EXPECT_TRUE(std::isnan(made->lowest(7, 0))) << "the fault of second 17";
  EXPECT_FLOAT_EQ(made->lowest(7, 1), 2.5f) << "50 pulses of 0.1\" in 2 s";
}

TEST_F(SeriesOfARun, HasAtMostRequestedBucketsWithEachValueInOne) {
  for (const std::int64_t most : {1, 7, 100, 2000, 4000, 7, 100}) {
    if (most == 2000) cache_.update_overviews();
    const auto made =
        cache_.buckets(run_, {.channels = {kThermometer}, .from = 0, .to = kSeconds - 1, .buckets = most});
    ASSERT_TRUE(made);
    EXPECT_LE(made->size(), static_cast<std::size_t>(most));
    for (std::size_t bucket = 0; bucket < made->size(); ++bucket) {
      const auto first = made->first() + static_cast<std::int64_t>(bucket) * made->width(),
                 last = std::min(first + made->width(), kSeconds) - 1;
      if (last >= 3000 && first < 4000) continue;
      EXPECT_FLOAT_EQ(made->lowest(bucket, 0), static_cast<float>(first) / 100) << most << " " << bucket;
      EXPECT_FLOAT_EQ(made->highest(bucket, 0), static_cast<float>(last) / 100) << most << " " << bucket;
    }
  }
}

TEST_F(SeriesOfARun, HasMeanOfEachBucket) {
  for (const std::int64_t most : {3, 500, 4000}) {
    const auto made =
        cache_.buckets(run_, {.channels = {kThermometer}, .from = 0, .to = kSeconds - 1, .buckets = most});
    ASSERT_TRUE(made);
    ASSERT_GT(made->width(), 1);
    for (std::size_t bucket = 0; bucket < made->size(); ++bucket) {
      double sum = 0, count = 0;
      const auto first = made->first() + static_cast<std::int64_t>(bucket) * made->width();
      for (auto slot = first; slot < std::min(first + made->width(), kSeconds); ++slot) {
        if (slot == 17 || (slot >= 3000 && slot <= 3999)) continue;
        sum += static_cast<double>(slot) / 100;
        count += 1;
      }
      if (count > 0)
        EXPECT_NEAR(made->mean(bucket, 0), sum / count, 1e-5) << most << " " << bucket;
      else
        EXPECT_TRUE(std::isnan(made->mean(bucket, 0))) << most << " " << bucket;
    }
    EXPECT_EQ(made->last_slot(), kSeconds - 1) << most;
  }
}

TEST_F(SeriesOfARun, ShowsGap) {
  const auto whole = cache_.buckets(run_, {.channels = {kThermometer}, .from = 0, .to = kSeconds - 1, .buckets = 1000});
  ASSERT_TRUE(whole);
  const auto inside = static_cast<std::size_t>(3500 / whole->width());
  EXPECT_TRUE(std::isnan(whole->lowest(inside, 0)));
  const auto near = cache_.buckets(run_, {.channels = {kThermometer}, .from = 2990, .to = 4010});
  ASSERT_TRUE(near);
  EXPECT_FALSE(std::isnan(near->lowest(9, 0)));
  EXPECT_TRUE(std::isnan(near->lowest(10, 0)));
  EXPECT_FALSE(std::isnan(near->lowest(1010, 0)));
}

TEST_F(SeriesOfARun, LimitsBytesOfOverview) {
  SeriesCache small(20'000);
  const auto made = small.buckets(run_, {.channels = {kThermometer}, .from = 0, .to = kSeconds - 1, .buckets = 100});
  ASSERT_TRUE(made) << text(made.error());
  EXPECT_LE(small.bytes(), 20'000u);
  EXPECT_FLOAT_EQ(made->highest(made->size() - 1, 0), static_cast<float>(kSeconds - 1) / 100);
}

TEST_F(SeriesOfARun, LeavesNoFilesNextToRecord) {
  const auto names = [&] {
    std::vector<std::string> found;
    for (const auto& entry : std::filesystem::directory_iterator(folder_ / ""))
      found.push_back(entry.path().filename());
    std::sort(found.begin(), found.end());
    return found;
  };
  const auto before = names();
  ASSERT_TRUE(cache_.buckets(run_, {.channels = {kThermometer}, .from = 0, .to = kSeconds - 1}));
  ASSERT_TRUE(read_samples_after(run_, 100, 10));
  ASSERT_TRUE(read_events_after(run_, -1, 10));
  EXPECT_EQ(names(), before);
}

TEST_F(SeriesOfARun, WritesNullForMissingValues) {
  const auto made = cache_.buckets(run_, {.channels = {kThermometer}, .from = 16, .to = 18});
  ASSERT_TRUE(made);
  EXPECT_EQ(series_text(*made, {series_channels(*run_.info)[kThermometer]}),
            R"({"from":16,"step":1,"count":3,"last":18,"channels":[{"name":"A","unit":"°C","low":[0.16,null,0.18]}]})");
}

TEST_F(SeriesOfARun, WritesMeanBesideLowestAndHighestValue) {
  const auto made = cache_.buckets(run_, {.channels = {kThermometer}, .from = 16, .to = 19, .buckets = 2});
  ASSERT_TRUE(made);
  EXPECT_EQ(series_text(*made, {series_channels(*run_.info)[kThermometer]}, {1.5, std::nan("")}),
            R"({"from":16,"step":2,"count":2,"last":19,"times_s":[1.5,null],"channels":[{"name":"A","unit":"°C",)"
            R"("low":[0.16,0.18],"high":[0.16,0.19],"mean":[0.16,0.185]}]})");
}

class ImportedSeries : public ::testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(folder_ / "");
    write_imported_run(folder_ / "run.db", kRows);
    run_ = found_in(folder_ / "");
    ASSERT_TRUE(run_.info);
  }
  static constexpr std::int64_t kRows = 360;
  tests::TestFolder folder_;
  FoundRun run_;
  SeriesCache cache_;
};

TEST_F(ImportedSeries, FindsRowOfTime) {
  using std::chrono_literals::operator""s;
  const std::vector<std::pair<Duration, std::int64_t>> rows{{0s, 0},      {5s, 1},      {10s, 1},     {990s, 99},
                                                            {1000s, 100}, {4600s, 100}, {4601s, 101}, {99'999s, 359}};
  for (const auto& [time, row] : rows) EXPECT_EQ(find_imported_row(run_, time).value_or(-1), row) << to_seconds(time);
}

TEST_F(ImportedSeries, HasTimeOfEachBucket) {
  for (const std::int64_t most : {4000, 100, 7}) {
    const auto made = cache_.buckets(run_, {.channels = {kThermometer}, .from = 3, .to = kRows - 1, .buckets = most});
    ASSERT_TRUE(made);
    const auto times_s = imported_times_s(run_, *made);
    ASSERT_TRUE(times_s) << text(times_s.error());
    ASSERT_EQ(times_s->size(), made->size());
    for (std::size_t i = 0; i < made->size(); ++i) {
      const auto row = made->first() + static_cast<std::int64_t>(i) * made->width();
      EXPECT_EQ((*times_s)[i], to_seconds(imported_time(row))) << most << " " << row;
    }
  }
}

TEST_F(SeriesOfARun, SendsSamplesAndEventsOnceInOrder) {
  std::int64_t slot = 2990, count = 0;
  for (;;) {
    const auto rows = read_samples_after(run_, slot, 300);
    ASSERT_TRUE(rows);
    if (rows->empty()) break;
    for (const auto& row : *rows) {
      EXPECT_GT(row.number, slot);
      slot = row.number;
      ++count;
    }
  }
  EXPECT_EQ(slot, kSeconds - 1);
  EXPECT_EQ(count, kSeconds - 2991 - 1000);
  const auto events = read_events_after(run_, -1, 1000);
  ASSERT_TRUE(events);
  EXPECT_EQ(events->size(), 78u) << "one in 500 s, but two in the gap";
}

}  // namespace
}  // namespace gyrotherm::monitor
