// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "acquisition/record/csv.hpp"
#include "acquisition/record/record.hpp"
#include "core/file.hpp"
#include "tests/acquisition/record/runs.hpp"

namespace gyrotherm::record {
namespace {

std::string content(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(file), {});
}

Record small_record() {
  Record record;
  record.info = two_thermometers();
  record.info.segments[1].name = "hold, \"hot\"";
  record.finished = true;
  record.slot = {0, 3};
  record.time_s = {0, 3};
  record.set_point_c = {22.5, 22.5};
  record.chamber_air_c = {20.1, NAN};
  record.chamber_set_point_c = {21, NAN};
  record.thermometers_c = {{19.5, -0.1}, {NAN, 1e-9}};
  record.units = {
      {.rotation = {{-1000, NAN}}, .interval_s = {1, NAN}, .values = {}, .true_bias_deg_per_h = {{0.02, NAN}}}};
  record.progress = {{.segment = 0, .cycle = 0, .set_point = {}},
                     {.segment = 1, .phase = Phase::holding, .set_point = {}}};
  return record;
}

TEST(Export, TitlesColumnsAndLeavesMissingValuesEmpty) {
  EXPECT_EQ(to_csv(small_record()),
            "# SIMULATED: the instruments were virtual\n"
            "# run 0123456789abcdef0123456789abcdef of a profile on a rig\n"
            "# axis gyro: scale 0.1, earth rate 10.636\n"
            "# unit gyro: gradients shell-1.b, A\n"
            "# unit gyro: three point A, A, shell-1.b\n"
            "# thermometer A: offset 0.1\n"
            "# thermometer shell-1.b: offset -0.25\n"
            "slot,time [s],set point [°C],chamber air [°C],chamber set point [°C],A [°C],shell-1.b [°C],"
            "gyro [pulses of 0.1 arcsec],gyro interval [s],segment,cycle,phase,true bias [°/h]\n"
            "0,0,22.5,20.1,21,19.5,,-1000,1,warm up,first,ramping,0.02\n"
            "3,3,22.5,,,-0.1,1e-09,,,\"hold, \"\"hot\"\"\",,holding,\n");
}

TEST(Export, NamesThermometersOfEachUnit) {
  Record record = small_record();
  record.info.units.push_back(record.info.units.front());
  record.units.push_back(record.units.front());
  record.info.units[0].name = "u-1";
  record.info.units[0].three_point.clear();
  record.info.units[1].name = "u-2";
  record.info.units[1].gradients = {"A"};
  const std::string table = to_csv(record);
  EXPECT_NE(table.find("# unit u-1: gradients shell-1.b, A\n# unit u-2: gradients A\n# unit u-2: three point A, A, "
                       "shell-1.b\n# thermometer A"),
            std::string::npos)
      << table;
  for (auto& unit : record.info.units) unit.gradients = unit.three_point = {};
  EXPECT_EQ(to_csv(record).find("# unit"), std::string::npos);
}

TEST(Export, NamesVirtualInstrumentsOfRealRig) {
  Record record = small_record();
  record.info.virtual_rig = false;
  EXPECT_TRUE(to_csv(record).starts_with("# run "));
  record.info.virtual_instruments = {"chamber", "gyro a\nb"};
  EXPECT_TRUE(to_csv(record).starts_with("# SIMULATED: these instruments were virtual: chamber, gyro a b\n# run "))
      << to_csv(record);
}

/// The column determines the sign of the Earth rate. It is empty while an operator turns the unit.
TEST(Export, MarksRowsWithTurnedUnit) {
  Record record = small_record();
  EXPECT_EQ(to_csv(record).find("turned"), std::string::npos);
  record.info.segments[1].prompt = "turn it around";
  record.info.segments[1].unit.turned = true;
  const auto rows_end_with = [&](const char* turned) {
    const std::string table = to_csv(record);
    EXPECT_NE(table.find(",phase,turned,true bias [°/h]\n"), std::string::npos) << table;
    EXPECT_NE(table.find("ramping,0,0.02\n"), std::string::npos) << table;
    return table.ends_with(fmt::format("holding,{},\n", turned));
  };
  EXPECT_TRUE(rows_end_with(""));
  record.progress[1].in_segment = kSecond;
  EXPECT_TRUE(rows_end_with("1"));
}

TEST(Export, MarksUnfinishedRun) {
  Record record = small_record();
  record.info.virtual_rig = false;
  record.finished = false;
  record.info.profile_name = "two\nlines";
  EXPECT_EQ(
      to_csv(record).rfind("# run 0123456789abcdef0123456789abcdef of two lines on a rig, not finished\n# axis", 0),
      0u);
}

TEST(Export, WritesScaleAndEarthRateExactly) {
  Record record = small_record();
  auto& axis = record.info.units[0].axes[0];
  axis = {.kind = GyroKind::rate, .scale = 206264.806247};
  const std::string table = to_csv(record);
  EXPECT_NE(table.find("# axis gyro: scale 206264.806247\n"), std::string::npos) << table;
  EXPECT_NE(table.find(",gyro [206264.806247 °/h],"), std::string::npos) << table;
  record.info.imported = true;
  EXPECT_NE(to_csv(record).find("# axis gyro: scale 206264.806247, nothing removed\n"), std::string::npos);
  axis.earth_rate = DegreesPerHour{0};
  EXPECT_NE(to_csv(record).find("# axis gyro: scale 206264.806247, earth rate 0\n"), std::string::npos);
}

TEST(Export, WritesCalibrations) {
  Record record = small_record();
  record.info.thermometers[0].offset = Kelvins{-0.012};
  record.info.thermometers[1].polynomial = {0.1, 1.001};
  const std::string table = to_csv(record);
  EXPECT_NE(table.find("# thermometer A: offset -0.012\n"), std::string::npos) << table;
  EXPECT_NE(table.find("# thermometer shell-1.b: polynomial 0.1 1.001\n"), std::string::npos) << table;
}

TEST(LiveRowsOfExport, ReadOnlyChosenColumns) {
  std::vector<std::string> said;
  LiveRows rows("test", [&](const std::vector<std::string>& header, const std::vector<std::string>& comments) {
    said = comments;
    return Result<std::vector<std::size_t>>(std::vector<std::size_t>{header.size() - 1, 1});
  });
  ASSERT_TRUE(rows.take("# a comment\nslot,time,words,bias\n0,1,\"hold, hot\",0.5\n1,2,,\n"));
  EXPECT_EQ(said, std::vector<std::string>{"a comment"});
  ASSERT_EQ(rows.numbers().size(), 4u);
  EXPECT_EQ(rows.numbers()[0], 0.5);
  EXPECT_EQ(rows.numbers()[1], 1);
  EXPECT_TRUE(std::isnan(rows.numbers()[2]));
}

Result<void> export_record(const std::string& record_path, const std::string& csv_path) {
  return read_record(record_path).and_then([&](const Record& record) {
    return replace_text_file(csv_path, to_csv(record));
  });
}

TEST(Export, WritesWholeFileOrNone) {
  const Folder folder;
  auto store = store_with(folder / "run.db", 3);
  ASSERT_TRUE(store->finish());
  store.reset();
  std::ofstream(folder / "run.csv") << "old";
  ASSERT_TRUE(export_record(folder / "run.db", folder / "run.csv"));
  EXPECT_EQ(content(folder / "run.csv"), to_csv(read_record(folder / "run.db").value()));
  EXPECT_FALSE(std::filesystem::exists(folder / "run.csv.new"));
  EXPECT_EQ(export_record(folder / "run.db", folder / "no/such/folder.csv").error().kind, FaultKind::storage);
  EXPECT_EQ(export_record(folder / "missing.db", folder / "run.csv").error().kind, FaultKind::bad_file);
}

}  // namespace
}  // namespace gyrotherm::record
