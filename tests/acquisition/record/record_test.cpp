// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/record.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "acquisition/record/chain.hpp"
#include "acquisition/record/csv.hpp"
#include "acquisition/record/run_info.hpp"
#include "acquisition/record/sqlite.hpp"
#include "acquisition/record/status.hpp"
#include "tests/acquisition/record/runs.hpp"

namespace gyrotherm::record {
namespace {

TEST(Record, RestoresDescriptionOfRun) {
  const Folder folder;
  store_with(folder / "run.db", 0).reset();
  const RunInfo info = read_record(folder / "run.db").value().info;
  const RunInfo given = two_thermometers();
  EXPECT_EQ(info.id, given.id);
  EXPECT_EQ(info.profile_text, given.profile_text);
  EXPECT_EQ(info.rig_text, given.rig_text);
  EXPECT_EQ(info.gyro_model, given.gyro_model);
  EXPECT_EQ(info.gyro_film, given.gyro_film);
  EXPECT_EQ(info.gyro_model_text, given.gyro_model_text);
  EXPECT_EQ(info.seed, given.seed);
  EXPECT_EQ(info.days_later, 365u);
  EXPECT_TRUE(info.virtual_rig);
  EXPECT_FALSE(info.imported);
  EXPECT_EQ(info.started_utc, given.started_utc);
  ASSERT_EQ(info.thermometers.size(), 2u);
  EXPECT_EQ(info.thermometers[1].name, "shell-1.b");
  EXPECT_EQ(info.thermometers[1].instrument, "another");
  EXPECT_EQ(info.thermometers[1].offset, Kelvins{-0.25});
  EXPECT_EQ(info.units[0].axes[0].kind, GyroKind::pulse_count);
  EXPECT_EQ(info.units[0].axes[0].scale, 0.1);
  EXPECT_EQ(info.units[0].axes[0].earth_rate, DegreesPerHour{10.636});
  EXPECT_EQ(info.units[0].gradients, given.units[0].gradients);
  EXPECT_EQ(info.units[0].three_point, given.units[0].three_point);
  EXPECT_EQ(info.cycles, given.cycles);
  ASSERT_EQ(info.segments.size(), 2u);
  EXPECT_EQ(info.segments[0].name, "warm up");
  EXPECT_FALSE(info.segments[0].hold);
  EXPECT_EQ(info.segments[0].rate, CelsiusPerMinute{5});
  EXPECT_EQ(info.segments[1].cycle, 1);
}

/// Returns the start of a run if its samples show a clock that started `late` after the time in the description.
Duration start_time(RunInfo info, Duration late, std::int64_t samples) {
  const Folder folder;
  auto store = Store::create(folder / "run.db", info);
  EXPECT_TRUE(store);
  for (std::int64_t slot = 0; slot < samples; ++slot) {
    auto sample = sample_at(slot);
    sample.at.utc += late + slot * std::chrono::milliseconds(2);  // the two clocks differ in rate
    EXPECT_TRUE((*store)->append(sample, {}));
  }
  EXPECT_TRUE((*store)->sync());
  store->reset();
  return read_record(folder / "run.db").value().info.started_utc;
}

/// Writes a description into a new record, changes the record by `edit`, and reads it.
RunInfo description_after(const RunInfo& info, const char* edit = "") {
  const Folder folder;
  EXPECT_TRUE(Store::create(folder / "run.db", info).has_value());
  if (*edit != '\0') {
    auto database = Database::open(folder / "run.db", Access::read_write, 0).value();
    EXPECT_TRUE(database.execute(edit));
  }
  return read_info(folder / "run.db").value();
}

TEST(Record, RestoresVirtualInstrumentsOfRealRig) {
  auto mixed = two_thermometers();
  mixed.virtual_rig = false;
  mixed.identities = {{"chamber", "a real one"}, {"thermometer 2", "PT12 VIRTUAL1"}};
  EXPECT_FALSE(is_simulated(description_after(mixed)));
  EXPECT_EQ(describe_simulation(mixed), "");
  mixed.virtual_instruments = {"chamber", "thermometer 2"};
  const auto back = description_after(mixed);
  EXPECT_FALSE(back.virtual_rig) << "its time is real";
  EXPECT_EQ(back.virtual_instruments, mixed.virtual_instruments);
  EXPECT_TRUE(is_simulated(back));
  EXPECT_EQ(describe_simulation(back), "these instruments were virtual: chamber, thermometer 2");
  EXPECT_EQ(describe_simulation(description_after(two_thermometers())), "the instruments were virtual");
}

/// A record of an earlier version has no list of virtual instruments, even if its instruments were virtual.
TEST(Record, ReadsDescriptionWithoutVirtualInstruments) {
  auto served = two_thermometers();
  served.virtual_rig = false;
  served.identities = {{"thermometer 1", "LSCI,MODEL218S,VIRTUAL1,010126"}};
  served.virtual_instruments = {"thermometer 1"};
  const auto old = description_after(served, "DELETE FROM list WHERE name = 'virtual_instruments'");
  EXPECT_EQ(old.identities, served.identities);
  EXPECT_FALSE(is_simulated(old));
  EXPECT_TRUE(is_simulated(description_after(two_thermometers(), "DELETE FROM list")));
}

TEST(Record, TakesStartOfRealRunFromFirstSample) {
  constexpr Duration kLate = std::chrono::milliseconds(5300);
  auto real = two_thermometers();
  real.virtual_rig = false;
  EXPECT_EQ(start_time(real, kLate, 3), real.started_utc + kLate);
  EXPECT_EQ(start_time(real, kLate, 0), real.started_utc) << "while there is no sample";
  auto foreign = real;
  foreign.imported = true;
  EXPECT_EQ(start_time(foreign, kLate, 3), foreign.started_utc);
  EXPECT_EQ(start_time(two_thermometers(), kLate, 3), real.started_utc) << "a virtual one";
  auto served = real;
  served.virtual_instruments = {"chamber"};
  EXPECT_EQ(start_time(served, kLate, 3), real.started_utc + kLate) << "virtual instruments in real time";
}

TEST(Record, KeepsKnownTrueBias) {
  const Folder folder;
  {
    auto store = store_with(folder / "run.db", 0);
    auto sample = sample_at(0);
    sample.units[0].true_bias = {DegreesPerHour{-0.0123}};
    ASSERT_TRUE(store->append(sample, {}));
    ASSERT_TRUE(store->append(sample_at(1), {}));
    ASSERT_TRUE(store->sync());
  }
  const auto record = read_record(folder / "run.db").value();
  ASSERT_EQ(record.units[0].true_bias_deg_per_h[0].size(), 2u);
  EXPECT_EQ(record.units[0].true_bias_deg_per_h[0][0], -0.0123);
  EXPECT_TRUE(std::isnan(record.units[0].true_bias_deg_per_h[0][1])) << "a real gyro does not report it";
}

TEST(Record, KeepsUnknownEarthRateUnknown) {
  const Folder folder;
  RunInfo info = two_thermometers();
  info.units[0].axes[0].earth_rate.reset();
  ASSERT_TRUE(Store::create(folder / "run.db", info));
  EXPECT_FALSE(read_record(folder / "run.db").value().info.units[0].axes[0].earth_rate);
}

TEST(Record, KeepsCalibrationsAndGyroStream) {
  const Folder folder;
  RunInfo info = two_thermometers();
  info.units[0].stream_text = "schema = \"gyrotherm-gyro-stream/1\"\n";
  info.thermometers[0].polynomial = {0.1, 1 + 1e-15, -2.5e-7};
  info.thermometers[1].certificate = "2025-0815 \"b\"";
  info.thermometers[1].due = parse_day("2027-03-01");
  info.thermometers[1].certificate_file = CertificateFile{.name = "t 1.dcc.xml",
                                                          .sha256 = std::string(64, '0'),
                                                          .issuer = "Thermo \"Lab\"",
                                                          .signer = "CN=Seal,O=Thermo Lab",
                                                          .expanded = {0.1 / 3},
                                                          .coverage_factor = 2.05,
                                                          .lowest = {-40},
                                                          .highest = {60.125}};
  ASSERT_TRUE(Store::create(folder / "run.db", info));
  const auto back = read_record(folder / "run.db").value().info;
  EXPECT_EQ(back.units[0].stream_text, info.units[0].stream_text);
  for (std::size_t i = 0; i < info.thermometers.size(); ++i) {
    EXPECT_EQ(back.thermometers[i].offset, info.thermometers[i].offset);
    EXPECT_EQ(back.thermometers[i].polynomial, info.thermometers[i].polynomial) << "to the bit";
    EXPECT_EQ(back.thermometers[i].certificate, info.thermometers[i].certificate);
    EXPECT_EQ(back.thermometers[i].due, info.thermometers[i].due);
    EXPECT_EQ(back.thermometers[i].certificate_file, info.thermometers[i].certificate_file);
  }
}

TEST(Record, KeepsUncertaintiesOfThermometersAndGyro) {
  const Folder folder;
  RunInfo info = two_thermometers();
  info.thermometers[1].uncertainty = {.calibration = Kelvins{0.1 / 3},
                                      .rectangular = true,
                                      .drift_in_a_year = Kelvins{0.05},
                                      .calibrated = parse_day("2025-12-25")};
  info.units[0].axes[0].uncertainty = {.latitude_deg = 47.3769,
                                       .azimuth_deg = -1.0 / 3,
                                       .elevation_deg = 90,
                                       .latitude_uncertainty_deg = 0.01,
                                       .tilt_uncertainty_deg = 0.0,
                                       .fixture_azimuth_deg = -120.1,
                                       .fixture_elevation_deg = 0.0,
                                       .roll_uncertainty_deg = 1.0 / 7,
                                       .turn_on_repeatability_deg_per_h = 1e-3};
  ASSERT_TRUE(Store::create(folder / "run.db", info));
  const auto back = read_record(folder / "run.db").value().info;
  EXPECT_EQ(back.thermometers[0].uncertainty, ThermometerUncertainty{});
  EXPECT_EQ(back.thermometers[1].uncertainty, info.thermometers[1].uncertainty) << "to the bit";
  EXPECT_EQ(back.units[0].axes[0].uncertainty, info.units[0].axes[0].uncertainty);
}

TEST(Record, HasNoUncertaintiesWhenRigStatesNone) {
  const Folder folder;
  ASSERT_TRUE(Store::create(folder / "run.db", two_thermometers()));
  const auto back = read_record(folder / "run.db").value().info;
  for (const Channel& channel : back.thermometers) EXPECT_EQ(channel.uncertainty, ThermometerUncertainty{});
  EXPECT_EQ(back.units[0].axes[0].uncertainty, GyroUncertainty{});
}

TEST(Record, KeepsStateOfEachSecond) {
  const Folder folder;
  auto store = store_with(folder / "run.db", 1);
  Sample sample = sample_at(1);
  sample.state = RunState::suspended;
  ASSERT_TRUE(store->append(sample, {}));
  ASSERT_TRUE(store->finish());
  EXPECT_EQ(read_record(folder / "run.db")->state, (std::vector{RunState::execute, RunState::suspended}));
  EXPECT_EQ(read_status(folder / "run.db")->overview.state, RunState::suspended);
}

TEST(Record, RestoresEachSampleExactly) {
  const Folder folder;
  store_with(folder / "run.db", 50).reset();
  const Record record = read_record(folder / "run.db").value();
  ASSERT_EQ(record.slot.size(), 50u);
  const Sample sample = sample_at(49);
  EXPECT_EQ(record.slot[49], 49);
  EXPECT_EQ(record.time_s[49], 49.0);
  EXPECT_EQ(record.set_point_c[49], 22.5);
  EXPECT_EQ(record.chamber_air_c[49], sample.chamber.value->air.value);
  EXPECT_EQ(record.chamber_set_point_c[49], 21.0);
  EXPECT_EQ(record.thermometers_c[0][49], sample.thermometers[0].value->value);
  EXPECT_EQ(record.thermometers_c[1][49], -0.1);
  EXPECT_EQ(record.units[0].rotation[0][49], -951.0);
  EXPECT_DOUBLE_EQ(record.units[0].interval_s[49], 1.000000001);
  EXPECT_EQ(record.progress[49], sample.progress);
}

TEST(Record, HasNoValueWhenReadingIsFault) {
  const Folder folder;
  auto store = store_with(folder / "run.db", 1);
  Sample sample = sample_at(1);
  sample.chamber.value = failure(FaultKind::timeout, "chamber", "no reply in 500 ms");
  sample.thermometers[0].value = failure(FaultKind::out_of_range, "A", "open input");
  ASSERT_TRUE(store->append(sample, {}));
  sample = sample_at(2);
  sample.units[0].count.value = failure(FaultKind::corrupted, "gyro", "3 frames lost");
  ASSERT_TRUE(store->append(sample, {}));
  ASSERT_TRUE(store->finish());
  store.reset();
  const Record record = read_record(folder / "run.db").value();
  EXPECT_TRUE(std::isnan(record.chamber_air_c[1]) && std::isnan(record.chamber_set_point_c[1]));
  EXPECT_TRUE(std::isnan(record.thermometers_c[0][1]));
  EXPECT_FALSE(std::isnan(record.thermometers_c[1][1]) || std::isnan(record.units[0].rotation[0][1]));
  EXPECT_TRUE(std::isnan(record.units[0].rotation[0][2]) && std::isnan(record.units[0].interval_s[2]));
  EXPECT_EQ(record.set_point_c[1], 22.5) << "the requested value is known nevertheless";
}

TEST(Record, RestoresSubjectOfEvent) {
  const Folder folder;
  auto store = Store::create(folder / "run.db", two_thermometers()).value();
  const EventSubject about{.interlock = "door", .reaction = "suspend", .segment = 1, .channel = "chamber"};
  ASSERT_TRUE(store->append(sample_at(0), std::vector<Event>{{sample_at(0).at, EventKind::interlock, "x", about},
                                                             {sample_at(0).at, EventKind::note, "y"}}));
  ASSERT_TRUE(store->finish());
  store.reset();
  const auto events = read_record(folder / "run.db").value().events;
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(events[0].event.about.interlock, "door");
  EXPECT_EQ(events[0].event.about.reaction, "suspend");
  EXPECT_EQ(events[0].event.about.segment, 1);
  EXPECT_EQ(events[0].event.about.channel, "chamber");
  EXPECT_FALSE(events[1].event.about.segment);
}

/// Returns the name, unit and unit under test of each channel.
std::string channels_in(const std::string& path) {
  auto database = open_record(path).value();
  auto query = database.prepare("SELECT name, unit, unit_under_test FROM channel ORDER BY position").value();
  std::string channels;
  while (query.step().value()) channels += fmt::format("{}|{}|{}\n", query.text(0), query.text(1), query.text(2));
  return channels;
}

TEST(Record, ListsAllChannels) {
  const Folder folder;
  auto store = Store::create(folder / "run.db", two_thermometers()).value();
  ASSERT_TRUE(store->finish());
  store.reset();
  EXPECT_EQ(channels_in(folder / "run.db"),
            "chamber_air_c|°C|\nchamber_set_point_c|°C|\nA|°C|gyro\nshell-1.b|°C|gyro\n"
            "pulses|pulse|gyro\ninterval_ns|ns|gyro\ntrue_bias_deg_per_h|°/h|gyro\n");
  const RunInfo info = read_record(folder / "run.db").value().info;
  ASSERT_EQ(info.thermometers.size(), 2u);
  EXPECT_EQ(info.chamber_instrument, two_thermometers().chamber_instrument);
  EXPECT_EQ(info.units[0].instrument, two_thermometers().units[0].instrument);
}

TEST(Record, KeepsHumidityOfChamberIfItIsMeasured) {
  const Folder folder;
  auto given = two_thermometers();
  given.has_humidity = given.has_dew_point = true;
  given.warm_up = {.at_least = {16.8}, .air = {25}, .rate = {1.7}};
  auto store = Store::create(folder / "run.db", given).value();
  for (std::int64_t slot = 0; slot < 3; ++slot) {
    auto sample = sample_at(slot);
    if (slot > 0) sample.chamber.value->humidity_percent = 41.5;
    if (slot > 0) sample.chamber.value->dew_point = Celsius{-3.25};
    ASSERT_TRUE(store->append(sample, {}));
  }
  ASSERT_TRUE(store->finish());
  store.reset();
  EXPECT_TRUE(channels_in(folder / "run.db")
                  .starts_with("chamber_air_c|°C|\nchamber_set_point_c|°C|\nchamber_humidity_percent|%|\n"
                               "chamber_dew_point_c|°C|\nA|°C|gyro\n"));
  const auto files = find_files_to_read(folder / "run.db");
  ASSERT_TRUE(files);
  const auto record = read_verified_record(*files);
  ASSERT_TRUE(record) << text(record.error());
  EXPECT_TRUE(record->info.has_humidity && record->info.has_dew_point);
  EXPECT_EQ(record->info.warm_up, given.warm_up);
  EXPECT_EQ(record->info.thermometers.size(), 2u) << "they are no inputs of models";
  EXPECT_TRUE(std::isnan(record->chamber_humidity_percent[0]) && std::isnan(record->chamber_dew_point_c[0]));
  EXPECT_EQ(record->chamber_humidity_percent[2], 41.5);
  EXPECT_EQ(record->chamber_dew_point_c[2], -3.25);
  const auto csv = to_csv(*record);
  EXPECT_NE(csv.find("chamber humidity [%],chamber dew point [°C],A [°C]"), std::string::npos) << csv;
  EXPECT_NE(csv.find(",41.5,-3.25,"), std::string::npos) << csv;
}

TEST(Record, RestoresEventsInOrder) {
  const Folder folder;
  auto store = Store::create(folder / "run.db", two_thermometers()).value();
  ASSERT_TRUE(store->append_event({{}, EventKind::started, "by hand"}));
  const std::vector<Event> events{{sample_at(0).at, EventKind::segment, "22 °C"},
                                  {sample_at(0).at, EventKind::note, "x"}};
  ASSERT_TRUE(store->append(sample_at(0), events));
  ASSERT_TRUE(store->append_event({sample_at(0).at, EventKind::finished, ""}));
  ASSERT_TRUE(store->finish());
  store.reset();
  const auto recorded = read_record(folder / "run.db").value().events;
  ASSERT_EQ(recorded.size(), 4u);
  EXPECT_EQ(recorded[0].slot, -1);
  EXPECT_EQ(recorded[1].event.kind, EventKind::segment);
  EXPECT_EQ(recorded[1].event.text, "22 °C");
  EXPECT_EQ(recorded[1].event.at.utc, kVirtualEpoch);
  EXPECT_EQ(recorded[3].slot, 0);
  EXPECT_EQ(recorded[3].event.kind, EventKind::finished);
}

TEST(Record, RefusesOtherFiles) {
  const Folder folder;
  std::ofstream(folder / "text") << std::string(5000, 'x');
  for (const char* file : {"text", "missing"}) {
    const auto record = read_record(folder / file);
    ASSERT_FALSE(record) << file;
    EXPECT_EQ(record.error().kind, FaultKind::bad_file) << file;
    EXPECT_EQ(record.error().where, folder / file);
  }
}

TEST(Record, RefusesDamagedFile) {
  const Folder folder;
  auto store = store_with(folder / "run.db", 2000);
  ASSERT_TRUE(store->finish());
  store.reset();
  std::filesystem::resize_file(folder / "run.db", std::filesystem::file_size(folder / "run.db") / 2);
  const auto record = read_record(folder / "run.db");
  ASSERT_FALSE(record);
  EXPECT_EQ(record.error().kind, FaultKind::bad_file);
}

TEST(Record, ReadsRecordOfQualification) {
  constexpr std::int64_t kSlots = 221'600;
  const Folder folder;
  RunInfo info = two_thermometers();
  info.thermometers.clear();
  for (int i = 0; i < 9; ++i) info.thermometers.push_back({"T" + std::to_string(i), "", {}});
  auto store = Store::create(folder / "run.db", info).value();
  Sample sample = sample_at(0);
  sample.thermometers.resize(9, {Celsius{20.123456}, {}});
  for (sample.slot = 0; sample.slot < kSlots; ++sample.slot) ASSERT_TRUE(store->append(sample, {}));
  ASSERT_TRUE(store->finish());
  store.reset();
  EXPECT_EQ(read_record(folder / "run.db").value().slot.size(), static_cast<std::size_t>(kSlots));
}

}  // namespace
}  // namespace gyrotherm::record
