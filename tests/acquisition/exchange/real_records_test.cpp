// SPDX-License-Identifier: Apache-2.0
/// Imports public recordings if GYROTHERM_SHARED is the folder that contains `data/`. The README there has the
/// reference numbers.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <numeric>

#include "acquisition/exchange/import.hpp"
#include "acquisition/record/record.hpp"
#include "tests/support/folder.hpp"

namespace gyrotherm::exchange {
namespace {

using record::read_record, record::Record;

class RealRecord : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* shared = std::getenv("GYROTHERM_SHARED");
    if (shared == nullptr) GTEST_SKIP() << "GYROTHERM_SHARED is not set: the public recordings are not at hand";
    data_ = std::string(shared) + "/data/";
  }

  Record imported(const std::string& table, const std::string& map) {
    const tests::TestFolder folder;
    const auto summary =
        import_record(data_ + table, GYROTHERM_SOURCE_DIR "/profiles/imports/" + map, folder / "run.db", "0.1.0");
    EXPECT_TRUE(summary) << text(summary.error());
    return read_record(folder / "run.db").value_or(Record{});
  }

  std::string data_;
};

TEST_F(RealRecord, FreeImuIsImportedRowByRow) {
  const Record record = imported("freeimu_Tempdata01-02-14.csv", "freeimu.toml");
  ASSERT_EQ(record.slot.size(), 63'792u);
  EXPECT_DOUBLE_EQ(record.time_s.back(), 2157.971);
  const auto [low, high] = std::minmax_element(record.thermometers_c[0].begin(), record.thermometers_c[0].end());
  EXPECT_NEAR(*low, 10.383, 1e-3);
  EXPECT_NEAR(*high, 28.942, 1e-3);
  EXPECT_EQ(record.thermometers_c[1][0], 8.58);
  EXPECT_EQ(record.units[0].rotation[0][0], 8);
  EXPECT_NEAR(record.info.units[0].axes[0].scale, 219.512, 1e-3);
  EXPECT_EQ(record.info.units[0].gradients, (std::vector<std::string>{"die", "barometer"}));
  ASSERT_EQ(record.events.size(), 2u) << "the gaps, and the values of the channels";
  EXPECT_EQ(record.events[0].event.text.rfind("378 gaps", 0), 0u) << record.events[0].event.text;
}

TEST_F(RealRecord, FreeImuIsUnitWithThreeAxesAndTemperature) {
  const Record triad = imported("freeimu_Tempdata01-02-14.csv", "freeimu-triad.toml");
  ASSERT_EQ(triad.info.units.size(), 1u);
  ASSERT_EQ(triad.units[0].rotation.size(), 3u);
  EXPECT_EQ(triad.units[0].rotation[0][0], 8);
  EXPECT_EQ(triad.units[0].rotation[1][0], -4);
  EXPECT_EQ(triad.units[0].rotation[2][0], -19);
  ASSERT_EQ(triad.units[0].values.size(), 1u);
  EXPECT_TRUE(triad.info.units[0].values[0].is_temperature);
  EXPECT_NEAR(triad.units[0].values[0][0], -8884.0 / 340 + 36.53, 1e-9);
}

TEST_F(RealRecord, LaserGyroKeepsEveryIncrement) {
  const Record record = imported("lasergyro.imu", "lasergyro.toml");
  ASSERT_EQ(record.units[0].rotation[0].size(), 184'718u);
  EXPECT_EQ(std::accumulate(record.units[0].rotation[0].begin(), record.units[0].rotation[0].end(), 0.0), 154'367);
  EXPECT_EQ(record.info.units[0].axes[0].kind, record::GyroKind::pulse_count);
  EXPECT_EQ(record.units[0].interval_s[5], 0.01);
  EXPECT_TRUE(record.thermometers_c.empty());
}

TEST_F(RealRecord, TofuPilotKeepsTemperatures) {
  const Record record = imported("tofupilot_imu_raw_data.csv", "tofupilot.toml");
  ASSERT_EQ(record.units[0].rotation[0].size(), 8'400u);
  const auto& sensor_c = record.thermometers_c[0];
  EXPECT_EQ(std::min_element(sensor_c.begin(), sensor_c.end()) - sensor_c.begin(), 2692);
  EXPECT_NEAR(sensor_c[2692], -17.60306168, 1e-8);
  EXPECT_EQ(record.units[0].rotation[0][0], -0.04710827768);
}

}  // namespace
}  // namespace gyrotherm::exchange
