// SPDX-License-Identifier: Apache-2.0
/// The same virtual laboratory, measured by other instruments, gives the same record.
#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "tests/support/dry_run.hpp"

namespace gyrotherm::rig {
namespace {

constexpr std::int64_t kSeconds = 3000;

record::Record record_rig(const std::string& rig) {
  tests::DryRun dry_run(GYROTHERM_SOURCE_DIR "/tests/profiles/short-rate.toml", 1, rig);
  dry_run.run(kSeconds);
  auto record = record::read_record(dry_run.path());
  EXPECT_TRUE(record) << text(record.error());
  return std::move(*record);
}

const std::pair<record::Record, record::Record>& both_records() {
  static const std::pair<record::Record, record::Record> records{record_rig("virtual"), record_rig("virtual-mixed")};
  return records;
}

TEST(MixedRig, ReadsSameValuesWithinResolution) {
  const auto& [one, other] = both_records();
  ASSERT_EQ(one.slot.size(), static_cast<std::size_t>(kSeconds));
  ASSERT_EQ(other.slot.size(), one.slot.size());
  ASSERT_EQ(other.info.thermometers.size(), one.info.thermometers.size());
  for (std::size_t channel = 0; channel < one.thermometers_c.size(); ++channel) {
    EXPECT_EQ(other.info.thermometers[channel].name, one.info.thermometers[channel].name);
    for (std::size_t i = 0; i < one.slot.size(); ++i)
      ASSERT_NEAR(other.thermometers_c[channel][i], one.thermometers_c[channel][i], 5.1e-4)
          << one.info.thermometers[channel].name << " at second " << i;
  }
  for (std::size_t i = 0; i < one.slot.size(); ++i) {
    ASSERT_NEAR(other.chamber_air_c[i], one.chamber_air_c[i], 1e-4) << i;
    ASSERT_NEAR(other.chamber_set_point_c[i], one.chamber_set_point_c[i], 1e-4) << i;
  }
}

// The gyro of the mixed rig counts frames by its own clock, which is 5 ppm fast: 5e-5 °/h at an Earth rate of 10.6 °/h.
TEST(MixedRig, HasSameBiasWithinReadOutResolution) {
  const auto rate_deg_per_h = [](const record::Record& record, std::size_t i) {
    return record.info.units[0].axes[0].scale * record.units[0].rotation[0][i] / record.units[0].interval_s[i];
  };
  const auto& [one, other] = both_records();
  EXPECT_EQ(one.info.units[0].axes[0].earth_rate, other.info.units[0].axes[0].earth_rate);
  for (std::size_t i = 0; i < one.slot.size(); ++i)
    ASSERT_NEAR(rate_deg_per_h(other, i), rate_deg_per_h(one, i), 1.5e-4) << i;
}

}  // namespace
}  // namespace gyrotherm::rig
