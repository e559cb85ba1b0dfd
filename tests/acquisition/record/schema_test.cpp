// SPDX-License-Identifier: Apache-2.0
/// Tests that the SQL views of a record agree with the program.
#include "acquisition/record/schema.hpp"

#include <gtest/gtest.h>

#include "acquisition/record/row.hpp"
#include "tests/acquisition/record/runs.hpp"

namespace gyrotherm::record {
namespace {

/// Makes a record of two thermometers, one with a polynomial, with a fault, an event and a gap.
void make_run_with_views(const std::string& path) {
  RunInfo info = two_thermometers();
  info.thermometers[1].polynomial = {-0.5, 1.001, 1e-5};
  auto store = Store::create(path, info);
  ASSERT_TRUE(store) << text(store.error());
  const Event noted{{std::chrono::seconds(1), kVirtualEpoch + std::chrono::seconds(1)}, EventKind::note, "hello"};
  for (int slot = 0; slot < 3; ++slot) {
    Sample sample = sample_at(slot);
    if (slot == 2) sample.thermometers[1].value = failure(FaultKind::timeout, "bridge", "no reply");
    ASSERT_TRUE((*store)->append(sample, slot == 1 ? std::vector<Event>{noted} : std::vector<Event>{}));
  }
  ASSERT_TRUE((*store)->append_gap(3, 7, "power"));
  ASSERT_TRUE((*store)->finish());
}

std::vector<std::string> query_rows(Database& database, const std::string& sql) {
  std::vector<std::string> rows;
  EXPECT_TRUE(database.each_row(sql, [&](const Statement& row) { rows.emplace_back(row.text(0)); })) << sql;
  return rows;
}

TEST(Views, CalibrateSamplesInDegreesPerHourAndUtc) {
  const Folder folder;
  make_run_with_views(folder / "run.db");
  const Record record = read_record(folder / "run.db").value();
  auto database = open_record(folder / "run.db").value();
  std::size_t at = 0;
  ASSERT_TRUE(database.each_row(
      "SELECT A, \"shell-1.b\", rate_deg_per_h, interval_s, utc, segment, cycle, time_s FROM v1_sample",
      [&](const Statement& row) {
        const auto& channels = record.info.thermometers;
        EXPECT_EQ(row.real(0), calibrated(channels[0], {record.thermometers_c[0][at]}).value);
        if (at == 2)
          EXPECT_TRUE(row.null(1));
        else
          EXPECT_DOUBLE_EQ(row.real(1), calibrated(channels[1], {record.thermometers_c[1][at]}).value);
        EXPECT_DOUBLE_EQ(row.real(2), 0.1 * record.units[0].rotation[0][at] / record.units[0].interval_s[at]);
        EXPECT_EQ(row.real(3), record.units[0].interval_s[at]);
        EXPECT_EQ(row.text(4), "2026-01-01T00:00:0" + std::to_string(at) + ".000Z");
        EXPECT_EQ(row.text(5), "hold");
        EXPECT_EQ(row.text(6), "second");
        EXPECT_EQ(row.real(7), static_cast<double>(at++));
      }));
  EXPECT_EQ(at, 3u);
}

TEST(Views, ShowNamesInEventsGapsAndChannels) {
  const Folder folder;
  make_run_with_views(folder / "run.db");
  auto database = open_record(folder / "run.db").value();
  EXPECT_EQ(query_rows(database, "SELECT utc || ' ' || kind || ' ' || text FROM v1_event WHERE kind = 'note'"),
            std::vector<std::string>{"2026-01-01T00:00:01.000Z note hello"});
  EXPECT_EQ(query_rows(database, "SELECT first || ' ' || last || ' ' || seconds || ' ' || cause FROM v1_gap"),
            std::vector<std::string>{"3 7 5 power"});
  EXPECT_EQ(query_rows(database, "SELECT name || ' ' || unit FROM v1_channel ORDER BY position"),
            (std::vector<std::string>{"chamber_air_c °C", "chamber_set_point_c °C", "A °C", "shell-1.b °C",
                                      "rate_deg_per_h °/h", "interval_s s", "true_bias_deg_per_h °/h"}));
}

TEST(Views, HaveColumnForEachChannel) {
  const Folder folder;
  make_run_with_views(folder / "run.db");
  auto database = open_record(folder / "run.db").value();
  EXPECT_EQ(
      query_rows(database,
                 "SELECT name FROM v1_channel WHERE name NOT IN (SELECT name FROM pragma_table_info('v1_sample'))"),
      std::vector<std::string>{});
}

TEST(Views, ShowNullWhenReadingIsMissingDespiteConstant) {
  RunInfo info = two_thermometers();
  info.thermometers[0].polynomial = {21};
  EXPECT_NE(record_views(info).back().sql.find("21.0 + 0.0 * \"A\" AS \"A\""), std::string::npos)
      << record_views(info).back().sql;
}

}  // namespace
}  // namespace gyrotherm::record
