// SPDX-License-Identifier: Apache-2.0
/// Small runs for the tests of records.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <string>

#include "acquisition/record/record.hpp"
#include "acquisition/record/record_files.hpp"
#include "acquisition/record/store.hpp"

namespace gyrotherm::record {

/// A temporary folder, removed by the destructor.
class Folder {
 public:
  Folder() {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    path_ = std::filesystem::temp_directory_path() / (std::string("gyrotherm-") + test->test_suite_name() + "." +
                                                      test->name() + "-" + std::to_string(::getpid()));
    std::filesystem::create_directories(path_);
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  [[nodiscard]] std::string operator/(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

/// Returns the number of the last file of the run; 1 if there is only one.
inline int last_part(const std::string& path) { return find_record_files(path).value().parts.back().continuation.part; }

inline RunInfo two_thermometers() {
  RunInfo info;
  info.id = "0123456789abcdef0123456789abcdef";
  info.program_version = "0.1.0";
  info.profile_name = "a profile";
  info.profile_text = "schema = \"gyrotherm-profile/1\"\n# 5 °C/min\n";
  info.rig_name = "a rig";
  info.rig_text = std::string("text with a zero \0 in it", 24);
  info.virtual_rig = true;
  info.gyro_model = "calibrated";
  info.gyro_film = "chamber";
  info.gyro_model_text = "schema = \"gyrotherm-reduced-gyro/1\"\n";
  info.seed = 0xfedcba9876543210u;
  info.days_later = 365;
  info.started_utc = kVirtualEpoch;
  info.thermometers = {{"A", "a bridge", Kelvins{0.1}}, {"shell-1.b", "another", Kelvins{-0.25}}};
  info.chamber_instrument = "a controller";
  info.units = {{.instrument = "a counter",
                 .axes = {{.kind = GyroKind::pulse_count, .scale = 0.1, .earth_rate = DegreesPerHour{10.636}}},
                 .gradients = {"shell-1.b", "A"},
                 .three_point = {"A", "A", "shell-1.b"}}};
  info.cycles = {"first", "second"};
  info.segments = {{"warm up", false, Celsius{70}, CelsiusPerMinute{5}, 0}, {"hold", true, Celsius{70}, {}, 1}};
  return info;
}

inline Sample sample_at(std::int64_t slot) {
  const Instant at{std::chrono::seconds(slot), kVirtualEpoch + std::chrono::seconds(slot)};
  const auto s = static_cast<double>(slot);
  Sample sample;
  sample.slot = slot;
  sample.at = at;
  sample.chamber = {ChamberState{Celsius{20 + 0.1 * s}, Celsius{21}}, at};
  sample.thermometers = {{Celsius{19.5 + 1e-9 * s}, at}, {Celsius{-0.1}, at}};
  sample.units = {{.count = {GyroCount{{-1000 + slot}, std::chrono::nanoseconds(1'000'000'001)}, at}}};
  sample.progress = {.segment = 1,
                     .cycle = 1,
                     .phase = Phase::waiting_for_soak,
                     .in_segment = std::chrono::seconds(slot),
                     .soaked = std::chrono::nanoseconds(7),
                     .set_point = Celsius{22.5}};
  return sample;
}

/// A time limit that allows for the disk of a busy machine.
inline constexpr auto kLong = std::chrono::seconds(20);

/// Returns a store with slots 0…count−1 appended and synced.
inline std::unique_ptr<Store> store_with(const std::string& path, std::int64_t count) {
  auto store = Store::create(path, two_thermometers());
  EXPECT_TRUE(store) << text(store.error());
  for (std::int64_t slot = 0; slot < count; ++slot) EXPECT_TRUE((*store)->append(sample_at(slot), {}));
  EXPECT_EQ((*store)->sync().value_or(-2), count - 1);
  return std::move(*store);
}

}  // namespace gyrotherm::record
