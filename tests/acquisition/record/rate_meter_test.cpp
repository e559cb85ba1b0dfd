// SPDX-License-Identifier: Apache-2.0
/// Tests the rate of each axis in the status of a run.
#include "acquisition/record/rate_meter.hpp"

#include <gtest/gtest.h>

#include "acquisition/record/status.hpp"
#include "tests/acquisition/record/runs.hpp"

namespace gyrotherm::record {
namespace {

using std::chrono_literals::operator""s;

Sample make_sample(std::vector<std::int64_t> pulses, Duration interval = 1s) {
  Sample sample;
  sample.units.resize(1);
  sample.units[0].count.value = GyroCount{.pulses = std::move(pulses), .interval = interval};
  return sample;
}

UnitInfo unit(std::vector<AxisInfo> axes) { return {.name = "u1", .axes = std::move(axes)}; }

TEST(RateMeters, ShowEachAxisInDegreesPerHour) {
  const AxisInfo pulses{.name = "x", .kind = GyroKind::pulse_count, .scale = 0.5, .earth_rate = DegreesPerHour{10}};
  const AxisInfo rate{.name = "y", .kind = GyroKind::rate, .scale = 1e-3};
  const AxisInfo other_way{.name = "z", .kind = GyroKind::pulse_count, .scale = -0.5, .earth_rate = DegreesPerHour{-5}};
  RateMeters meters({unit({pulses, rate, other_way})});
  EXPECT_FALSE(meters.rates()[0].rate_deg_per_h);
  meters.add(make_sample({22, 12'600, 12}));
  meters.add(make_sample({52, 12'400, 12}, 2s));
  const auto rates = meters.rates();
  ASSERT_EQ(rates.size(), 3u);
  EXPECT_EQ(rates[0].axis, "u1.x");
  EXPECT_NEAR(*rates[0].rate_deg_per_h, 13, 1e-12) << "52 pulses of 0.5 arcsec in 2 s";
  EXPECT_NEAR(*rates[0].mean_deg_per_h, 37.0 / 3, 1e-12) << "weighted by the intervals";
  EXPECT_EQ(rates[0].earth_rate_deg_per_h, 10) << "not subtracted";
  EXPECT_NEAR(*rates[1].rate_deg_per_h, 12.4, 1e-12) << "a rate gyro's number is a rate";
  EXPECT_FALSE(rates[1].earth_rate_deg_per_h);
  EXPECT_NEAR(*rates[2].rate_deg_per_h, -3, 1e-12);
}

TEST(RateMeters, ForgetRatesOlderThanHundredSeconds) {
  RateMeters meters({unit({{.kind = GyroKind::pulse_count, .scale = 1}})});
  meters.add(make_sample({1'000'000}));
  for (int i = 0; i < 100; ++i) meters.add(make_sample({7}));
  EXPECT_NEAR(*meters.rates()[0].mean_deg_per_h, 7, 1e-12);
  meters.add(make_sample({9}));
  EXPECT_NEAR(*meters.rates()[0].rate_deg_per_h, 9, 1e-12) << "the newest, whatever its position in the ring";
}

TEST(RateMeters, ShowNoRateWhenReadingIsFault) {
  RateMeters meters({unit({{.kind = GyroKind::pulse_count, .scale = 1}})});
  meters.add(make_sample({7}));
  Sample silent = make_sample({});
  meters.add(silent);
  silent.units[0].count.value = failure(FaultKind::timeout, "gyro", "silent");
  meters.add(silent);
  EXPECT_FALSE(meters.rates()[0].rate_deg_per_h);
  EXPECT_NEAR(*meters.rates()[0].mean_deg_per_h, 7, 1e-12);
}

TEST(RateMeters, AreInStatusFile) {
  RunStatus status = make_first_status("run.db", two_thermometers());
  status.gyro_rates = {{.axis = "gyro", .rate_deg_per_h = 12.5, .mean_deg_per_h = 12.25, .earth_rate_deg_per_h = 11.2},
                       {.axis = "y", .rate_deg_per_h = {}, .mean_deg_per_h = {}, .earth_rate_deg_per_h = {}}};
  const auto read = parse_status(to_json(status), "run.db.status");
  ASSERT_TRUE(read) << text(read.error());
  EXPECT_EQ(read->gyro_rates, status.gyro_rates);
  EXPECT_EQ(describe(status.gyro_rates[0]),
            "gyro: 12.5000 °/h in the last second, 12.2500 °/h mean of 100 s, Earth rate 11.2000 °/h");
}

}  // namespace
}  // namespace gyrotherm::record
