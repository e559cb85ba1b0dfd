// SPDX-License-Identifier: Apache-2.0
// Each shipped register map, on each of its links, drives the virtual rig through the qualification profile, shortened
// to an hour. Client and virtual unit read the same file.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/dry_run.hpp"

namespace gyrotherm::rig {
namespace {

drivers::RegisterMap read_map(const std::string& name) {
  const auto text = read_text_file(GYROTHERM_SOURCE_DIR "/profiles/chambers/" + name + ".toml");
  return drivers::parse_register_map(text.value(), name + ".toml").value();
}

/// Returns the names of all maps. Parses no map, because each test process calls it.
std::vector<std::string> all_maps() {
  std::vector<std::string> all;
  for (const auto& file : std::filesystem::directory_iterator(GYROTHERM_SOURCE_DIR "/profiles/chambers"))
    if (file.path().extension() == ".toml") all.push_back(file.path().stem().string());
  std::ranges::sort(all);
  return all;
}

/// Returns a map on each of its links. On the virtual rig every line is a TCP line, so RTU and RTU over TCP are equal.
std::vector<drivers::RegisterMap> on_each_link(const std::string& name) {
  std::vector<drivers::RegisterMap> all;
  const auto map = read_map(name);
  for (const auto& link : map.links)
    if (link.kind != drivers::LinkKind::rtu_over_tcp) all.push_back(select_link(map, link.kind).value());
  return all;
}

class EveryMap : public testing::TestWithParam<std::string> {};

void run_short_qualification(drivers::RegisterMap map) {
  tests::DryRun dry_run(GYROTHERM_SOURCE_DIR "/tests/profiles/qualification-hour.toml");
  const double step = map.find("set_point")->resolution;
  // With RTU the first request waits for twice this time, because the line may carry answers to another client.
  map.link.modbus.timeout = std::min<Duration>(map.link.modbus.timeout, std::chrono::milliseconds(400));
  map.limits.every = Duration{};
  dry_run.file().chamber_map = std::move(map);
  ASSERT_EQ(dry_run.run(), run::RunOutcome::complete);

  const auto record = record::read_record(dry_run.path());
  ASSERT_TRUE(record) << text(record.error());
  ASSERT_EQ(record->slot.size(), 3600u);
  double furthest = 0;
  for (std::size_t i = 0; i < record->slot.size(); ++i) {
    ASSERT_NEAR(record->chamber_set_point_c[i], record->set_point_c[i], 0.51 * step + 1e-4) << "second " << i;
    furthest = std::max(furthest, std::abs(record->chamber_air_c[i] - record->set_point_c[i]));
  }
  EXPECT_LT(furthest, 4.0) << "the air follows the set point at 5 °C/min";
  for (const auto& event : record->events) EXPECT_NE(event.event.kind, EventKind::fault) << event.event.text;
}

TEST_P(EveryMap, RunsShortQualification) {
  for (const auto& map : on_each_link(GetParam())) {
    SCOPED_TRACE(name(map.link.kind));
    run_short_qualification(map);
  }
}

TEST(SetPoints, AreSentAtMostAsOftenAsMapAllows) {
  tests::DryRun dry_run(GYROTHERM_SOURCE_DIR "/tests/profiles/qualification-hour.toml");
  auto map = read_map("csz_ezt570i");
  map.link.modbus.timeout = std::chrono::milliseconds(400);
  ASSERT_EQ(map.limits.every, std::chrono::seconds(2));
  dry_run.file().chamber_map = map;
  dry_run.run(600);
  const auto record = record::read_record(dry_run.path());
  ASSERT_TRUE(record) << text(record.error());
  const auto& sent = record->chamber_set_point_c;
  std::size_t last = 0, changes = 0;
  for (std::size_t i = 1; i < sent.size(); ++i) {
    if (sent[i] == sent[i - 1]) continue;
    EXPECT_GE(i - last, 2u) << "second " << i;
    last = i;
    ++changes;
    ASSERT_NEAR(sent[i], record->set_point_c[i], 0.26) << "the set points form a staircase";
  }
  EXPECT_GT(changes, 100u) << "five minutes of a ramp at 5 °C/min";
}

INSTANTIATE_TEST_SUITE_P(Shipped, EveryMap, testing::ValuesIn(all_maps()), [](const auto& one) { return one.param; });

TEST(Humidity, IsRecordedOnEachLinkOfItsMaps) {
  std::set<std::string> seen;
  for (const auto& one : all_maps())
    for (const auto& on_link : on_each_link(one)) {
      auto map = select_humidity(on_link);
      if (!map) continue;
      seen.insert(one);
      SCOPED_TRACE(one + " " + name(on_link.link.kind));
      tests::DryRun dry_run(GYROTHERM_SOURCE_DIR "/tests/profiles/ten-seconds.toml");
      dry_run.file().chamber_map = std::move(*map);
      ASSERT_EQ(dry_run.run(), run::RunOutcome::complete);
      const auto record = record::read_record(dry_run.path());
      ASSERT_TRUE(record) << text(record.error());
      ASSERT_FALSE(record->chamber_humidity_percent.empty());
      EXPECT_NEAR(record->chamber_humidity_percent.back(), 60, 1) << "50 % at 23 °C is 60 % at 20 °C";
      EXPECT_NEAR(record->chamber_dew_point_c.back(), 12, 0.5);
    }
  EXPECT_EQ(seen.size(), 15u) << fmt::format("{}", fmt::join(seen, " "));
}

}  // namespace
}  // namespace gyrotherm::rig
