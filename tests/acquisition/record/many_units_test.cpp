// SPDX-License-Identifier: Apache-2.0
/// Tests records of several units under test, each with its own axes and values.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "acquisition/record/chain.hpp"
#include "acquisition/record/csv.hpp"
#include "acquisition/record/record.hpp"
#include "acquisition/record/run_file.hpp"
#include "acquisition/record/schema.hpp"
#include "acquisition/record/status.hpp"
#include "tests/acquisition/record/runs.hpp"

namespace gyrotherm::record {
namespace {

AxisInfo make_axis(const std::string& name, double scale) {
  return {.name = name,
          .scale = scale,
          .earth_rate = DegreesPerHour{scale},
          .direction = {{0.6, 0, -0.8}},
          .uncertainty = {.latitude_deg = 45, .tilt_uncertainty_deg = 1.0 / 3}};
}

/// Returns a unit with three axes and two values, and one with a single axis.
RunInfo two_units() {
  RunInfo info = two_thermometers();
  info.units = {{.name = "u1",
                 .serial_number = "V-0001 \"b\"",
                 .model = "triad",
                 .instrument = "a counter",
                 .stream_text = "schema = \"gyrotherm-gyro-stream/1\"\n",
                 .axes = {make_axis("x", 0.1), make_axis("y", 0.2), make_axis("z", 0.3)},
                 .values = {{"temperature", "°C", true}, {"discharge_current_a", "mA", false}},
                 .gradients = {"A", "shell-1.b"},
                 .three_point = {}},
                {.name = "u-2", .axes = {{.scale = 0.4}}, .gradients = {"shell-1.b"}}};
  return info;
}

Sample sample_of_two(std::int64_t slot) {
  Sample sample = sample_at(slot);
  const Instant at = sample.at;
  sample.units = {{.count = {GyroCount{{slot, -slot, 7}, std::chrono::nanoseconds(999'999'999), {25.5, NAN}}, at},
                   .frames = {.seen = 10, .lost = 1, .bad = 2},
                   .true_bias = {{0.1}, {0.2}, {0.3}}},
                  {.count = {GyroCount{{100 + slot}, kSecond}, at}, .frames = {.seen = 20}}};
  return sample;
}

TEST(ManyUnits, AreRestoredWithAxesAndValues) {
  const Folder folder;
  {
    auto store = Store::create(folder / "run.db", two_units()).value();
    ASSERT_TRUE(store->append(sample_of_two(0), {}));
    ASSERT_TRUE(store->append(sample_of_two(1), {}));
    ASSERT_TRUE(store->finish());
  }
  const auto record = read_record(folder / "run.db").value();
  const RunInfo given = two_units();
  ASSERT_EQ(record.info.units.size(), 2u);
  const UnitInfo &first = record.info.units[0], &said = given.units[0];
  EXPECT_EQ(first.name, "u1");
  EXPECT_EQ(first.serial_number, said.serial_number);
  EXPECT_EQ(first.model, said.model);
  EXPECT_EQ(first.instrument, said.instrument);
  EXPECT_EQ(first.stream_text, said.stream_text);
  EXPECT_EQ(first.values, said.values);
  EXPECT_EQ(first.gradients, said.gradients);
  EXPECT_EQ(record.info.units[1].gradients, given.units[1].gradients) << "each unit has its own";
  ASSERT_EQ(first.axes.size(), 3u);
  EXPECT_EQ(first.axes[1].name, "y");
  EXPECT_EQ(first.axes[1].scale, 0.2);
  EXPECT_EQ(first.axes[2].earth_rate, DegreesPerHour{0.3});
  EXPECT_EQ(first.axes[0].direction, said.axes[0].direction);
  EXPECT_EQ(first.axes[0].uncertainty, said.axes[0].uncertainty) << "to the bit";
  EXPECT_FALSE(record.info.units[1].axes[0].direction);

  EXPECT_EQ(record.units[0].rotation, (std::vector<std::vector<double>>{{0, 1}, {0, -1}, {7, 7}}));
  EXPECT_EQ(record.units[0].interval_s, (std::vector{0.999999999, 0.999999999}));
  EXPECT_EQ(record.units[0].values[0], (std::vector{25.5, 25.5}));
  EXPECT_TRUE(std::isnan(record.units[0].values[1][0])) << "no frame had it";
  EXPECT_EQ(record.units[0].true_bias_deg_per_h[2], (std::vector{0.3, 0.3}));
  EXPECT_EQ(record.units[1].rotation[0], (std::vector<double>{100, 101}));
  EXPECT_TRUE(std::isnan(record.units[1].true_bias_deg_per_h[0][0]));
  EXPECT_TRUE(verify_record(folder / "run.db"));
}

TEST(ManyUnits, AreReadSeparately) {
  const Folder folder;
  {
    auto store = Store::create(folder / "run.db", two_units()).value();
    ASSERT_TRUE(store->append(sample_of_two(0), {}));
    ASSERT_TRUE(store->append(sample_of_two(1), {}));
    ASSERT_TRUE(store->finish());
  }
  const auto whole = read_record(folder / "run.db").value(), part = read_record(folder / "run.db", "u-2").value();
  EXPECT_EQ(part.info.units.size(), 2u) << "the data of the run are present";
  EXPECT_EQ(read_info(folder / "run.db")->id, whole.info.id);
  EXPECT_EQ(part.slot, whole.slot);
  EXPECT_EQ(part.chamber_air_c, whole.chamber_air_c);
  EXPECT_TRUE(part.thermometers_c[0].empty()) << "A is not a thermometer of the unit";
  EXPECT_EQ(part.thermometers_c[1], whole.thermometers_c[1]);
  EXPECT_TRUE(part.units[0].rotation[0].empty() && part.units[0].interval_s.empty() && part.units[0].values[0].empty());
  EXPECT_EQ(part.units[1].rotation, whole.units[1].rotation);
  EXPECT_EQ(part.units[1].interval_s, whole.units[1].interval_s);
}

TEST(ManyUnits, LoseOnlyChannelsOfSilentUnit) {
  const Folder folder;
  {
    auto store = Store::create(folder / "run.db", two_units()).value();
    auto sample = sample_of_two(0);
    sample.units[0].count.value = failure(FaultKind::timeout, "gyro", "nothing came");
    ASSERT_TRUE(store->append(sample, {}));
    ASSERT_TRUE(store->sync());
    EXPECT_EQ(read_status(folder / "run.db")->frames, (FrameCount{.seen = 30, .lost = 1, .bad = 2})) << "of both";
    ASSERT_TRUE(store->finish());
  }
  auto database = open_record(folder / "run.db").value();
  EXPECT_EQ(database.query_text("SELECT group_concat(channel) FROM fault").value(), "u1");
  const auto record = read_open_record(database).value();
  for (const auto& axis : record.units[0].rotation) EXPECT_TRUE(std::isnan(axis[0]));
  EXPECT_TRUE(std::isnan(record.units[0].interval_s[0]) && std::isnan(record.units[0].values[0][0]));
  EXPECT_EQ(record.units[1].rotation[0][0], 100);
}

/// Returns these units with analogue inputs: they measure the second value of the first unit and the only one of the
/// second.
RunInfo with_analogue_inputs() {
  RunInfo info = two_units();
  info.analogue_map_texts = {"schema = \"gyrotherm-analogue-inputs/1\"\n", "another"};
  info.thermometer_texts = {"schema = \"gyrotherm-text/1\"\n"};
  info.supply_texts = {"kind = \"supply\"\n"};
  info.units[0].values[1].instrument = "AI-4 at tcp://10.0.0.7, input 1";
  info.units[1].values = {{.name = "voltage", .unit = "V", .instrument = "AI-4 at tcp://10.0.0.7, input 2"}};
  return info;
}

Sample with_analogue(std::int64_t slot) {
  Sample sample = sample_of_two(slot);
  sample.units[0].count.value->values = {25.5};
  sample.units[0].analogue = {{1.5, sample.at}};
  sample.units[1].analogue = {{-0.25, sample.at}};
  return sample;
}

TEST(ManyUnits, StoreAnalogueValuesAfterSentValues) {
  const Folder folder;
  {
    auto store = Store::create(folder / "run.db", with_analogue_inputs()).value();
    ASSERT_TRUE(store->append(with_analogue(0), {}));
    auto silent = with_analogue(1);
    silent.units[0].count.value = failure(FaultKind::timeout, "gyro", "nothing came");
    ASSERT_TRUE(store->append(silent, {}));
    auto lost = with_analogue(2);
    lost.units[0].analogue[0].value = failure(FaultKind::out_of_range, "analogue input 1", "burn_out");
    ASSERT_TRUE(store->append(lost, {}));
    ASSERT_TRUE(store->finish());
  }
  auto database = open_record(folder / "run.db").value();
  EXPECT_EQ(database.query_text("SELECT group_concat(slot || ' ' || channel) FROM fault").value(),
            "1 u1,2 u1.discharge_current_a");
  const auto record = read_open_record(database).value();
  const auto& values = record.units[0].values;
  EXPECT_EQ(values[0][0], 25.5);
  EXPECT_TRUE(std::isnan(values[0][1]));
  EXPECT_EQ(values[1][0], 1.5);
  EXPECT_EQ(values[1][1], 1.5) << "the silence concerns only the gyro";
  EXPECT_TRUE(std::isnan(values[1][2]));
  EXPECT_EQ(values[0][2], 25.5);
  EXPECT_EQ(record.units[1].values[0], (std::vector{-0.25, -0.25, -0.25}));
  EXPECT_EQ(record.info.units[0].values, with_analogue_inputs().units[0].values);
  EXPECT_EQ(record.info.units[1].values, with_analogue_inputs().units[1].values);
  EXPECT_EQ(record.info.analogue_map_texts, with_analogue_inputs().analogue_map_texts);
  EXPECT_EQ(record.info.thermometer_texts, with_analogue_inputs().thermometer_texts);
  EXPECT_EQ(record.info.supply_texts, with_analogue_inputs().supply_texts);
  EXPECT_EQ(database.query_text("SELECT instrument FROM channel WHERE name = 'u-2.voltage'").value(),
            "AI-4 at tcp://10.0.0.7, input 2");
  EXPECT_TRUE(verify_record(folder / "run.db"));
}

TEST(ManyUnits, HaveNeitherReadingNorFaultWhenDropped) {
  const Folder folder;
  {
    auto store = Store::create(folder / "run.db", two_units()).value();
    auto sample = sample_of_two(0);
    sample.units[0].count.value = GyroCount{};
    ASSERT_TRUE(store->append(sample, {}));
    ASSERT_TRUE(store->finish());
  }
  auto database = open_record(folder / "run.db").value();
  EXPECT_EQ(database.query_integer("SELECT count(*) FROM fault", -1).value(), 0);
  EXPECT_EQ(database.query_integer("SELECT count(*) FROM sample WHERE \"u1.interval_ns\" IS NULL", -1).value(), 1);
}

TEST(ManyUnits, AreColumnsWithTheirLabels) {
  std::string names;
  for (const auto& column : channel_columns(two_units())) names += column.name + " ";
  EXPECT_EQ(names,
            "A shell-1.b u1.x.pulses u1.y.pulses u1.z.pulses u1.interval_ns u1.temperature u1.discharge_current_a "
            "u-2.pulses u-2.interval_ns u1.x.true_bias_deg_per_h u1.y.true_bias_deg_per_h u1.z.true_bias_deg_per_h "
            "u-2.true_bias_deg_per_h ");
}

TEST(ManyUnits, AreColumnsOfTextTable) {
  Record record;
  record.info = two_units();
  const auto csv = to_csv(record);
  const auto header = csv.substr(csv.find("slot,"));
  EXPECT_EQ(header,
            "slot,time [s],set point [°C],chamber air [°C],chamber set point [°C],A [°C],shell-1.b [°C],"
            "u1.x [pulses of 0.1 arcsec],u1.y [pulses of 0.2 arcsec],u1.z [pulses of 0.3 arcsec],u1 interval [s],"
            "u1.temperature [°C],u1.discharge_current_a [mA],u-2 [pulses of 0.4 arcsec],u-2 interval [s],"
            "segment,cycle,phase,u1.x true bias [°/h],u1.y true bias [°/h],u1.z true bias [°/h],u-2 true bias [°/h]\n");
}

TEST(ManyUnits, HaveValidColumnNames) {
  const auto refused = [](const auto& change) {
    RunInfo info = two_units();
    change(info);
    const auto good = check_channel_names(info);
    return good ? std::string() : text(good.error());
  };
  EXPECT_EQ(refused([](RunInfo&) {}), "");
  EXPECT_EQ(refused([](RunInfo& info) { info.units[1].name = "u\"2"; }),
            "gyro \"u\"2\": expected only letters, digits and _ -");
  EXPECT_EQ(refused([](RunInfo& info) { info.units[0].axes[1].name = ""; }), "axis \"\": expected 1 to 64 characters");
  EXPECT_EQ(refused([](RunInfo& info) { info.units[0].values[0].name = "a b"; }),
            "value \"a b\": expected only letters, digits and _ -");
  EXPECT_EQ(refused([](RunInfo& info) { info.units[1].name = "U1"; }),
            "channel \"U1.interval_ns\": the name is already in use, expected a unique one");
  EXPECT_EQ(refused([](RunInfo& info) { info.thermometers[0].name = "u1.Temperature"; }),
            "thermometer \"u1.Temperature\": the name is already in use, expected a unique one");
}

TEST(ManyUnits, HaveSerialNumbersOrderAndEmptyPositions) {
  const Folder folder;
  RunInfo info = two_units();
  ASSERT_TRUE(Store::create(folder / "plain.db", info).value()->finish());
  info.units[0].serial_number = "0042";
  info.order_number = "2026-17";
  info.unused_units = {info.units[1].name};
  ASSERT_TRUE(Store::create(folder / "lot.db", info).value()->finish());
  const auto lot = read_info(folder / "lot.db").value(), plain = read_info(folder / "plain.db").value();
  EXPECT_EQ(lot.units[0].serial_number, "0042");
  EXPECT_EQ(lot.order_number, "2026-17");
  EXPECT_EQ(lot.unused_units, info.unused_units);
  EXPECT_TRUE(is_unused(lot, info.units[1].name));
  EXPECT_FALSE(is_unused(lot, info.units[0].name));
  EXPECT_EQ(plain.order_number, "");
  EXPECT_TRUE(plain.unused_units.empty());
  auto database = Database::open(folder / "plain.db", Access::read_only, 0).value();
  EXPECT_EQ(database.query_integer("SELECT count(*) FROM meta WHERE key = 'order_number'", -1).value_or(-1), 0)
      << "a record without an order is as before";
}

TEST(ManyUnits, RefuseThermometerWithNameOfColumn) {
  for (const char* name : {"time", "time_s", "UTC", "bias", "self", "u1.x.rate_deg_per_h", "u1.x.bias_deg_per_h",
                           "u1.interval_s", "u-2.bias_deg_per_h", "Set Point", "chamber air"}) {
    RunInfo info = two_units();
    info.thermometers[0].name = name;
    const auto good = check_new_channel_names(info);
    ASSERT_FALSE(good) << name;
    EXPECT_EQ(text(good.error()),
              std::string("thermometer \"") + name + "\": the name is already in use, expected a unique one");
    EXPECT_TRUE(check_channel_names(info)) << "an existing record with the name can be read";
  }
  RunInfo one = two_thermometers();
  EXPECT_TRUE(check_new_channel_names(one));
  one.thermometers[0].name = "slot";
  EXPECT_EQ(new_name_troubles(one).size(), 1u) << "reported once";
  one.thermometers[0].name = "bias_deg_per_h";
  EXPECT_FALSE(check_new_channel_names(one));
  EXPECT_FALSE(RunFile::create_at_once(kInMemory, one));
}

TEST(ManyUnits, RefuseRowsOfMissingUnit) {
  const Folder folder;
  ASSERT_TRUE(Store::create(folder / "run.db", two_units()).value()->finish());
  auto database = Database::open(folder / "run.db", Access::read_write, 0).value();
  ASSERT_TRUE(database.execute("INSERT INTO axis(unit, position, name, kind, scale) VALUES(7, 0, 'x', 'rate', 1)"));
  const auto info = read_run_info(database);
  ASSERT_FALSE(info);
  EXPECT_EQ(info.error().what, "a row refers to a unit under test that does not exist");
}

TEST(ManyUnits, ContinueInSecondFile) {
  Record a, b;
  const Folder folder;
  {
    auto store = Store::create(folder / "run.db", two_units()).value();
    for (int slot = 0; slot < 3; ++slot) ASSERT_TRUE(store->append(sample_of_two(slot), {}));
    ASSERT_TRUE(store->sync());
  }
  auto store = Store::reopen(folder / "run.db").value();
  ASSERT_TRUE(store->append(sample_of_two(3), {}));
  ASSERT_TRUE(store->finish());
  store.reset();
  const auto record = read_record(folder / "run.db").value();
  EXPECT_EQ(record.units[0].rotation[1], (std::vector<double>{0, -1, -2, -3}));
}

}  // namespace
}  // namespace gyrotherm::record
