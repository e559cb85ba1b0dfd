// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/ulog.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/acquisition/exchange/foreign.hpp"
#include "tests/support/hex_bytes.hpp"

namespace gyrotherm::exchange {
namespace {

using std::chrono::microseconds, std::chrono::milliseconds, std::chrono::seconds;

ImportMap ulog_map(const std::string& rate = "sensor_gyro.x",
                   const std::string& temperature = "sensor_baro.temperature") {
  ImportMap map = rate_map();
  map.format = FileFormat::ulog;
  map.time.reset();
  map.axis_columns[0].name = rate;
  map.thermometer_columns[0].column.name = temperature;
  return map;
}

constexpr const char* kGyro =
    "sensor_gyro:uint64_t timestamp;uint32_t device_id;float x;float temperature;uint8_t[4] _padding0;";
std::string gyro(std::uint64_t us, float x, float temperature) {
  return little(us) + little(std::uint32_t{9}) + little(x) + little(temperature);
}
constexpr const char* kBaro = "sensor_baro:uint64_t timestamp;float temperature;";
std::string baro(std::uint64_t us, float temperature) { return little(us) + little(temperature); }

UlogText two_series() {
  UlogText log;
  log.format(kGyro).format(kBaro).subscribe(0, "sensor_gyro").subscribe(1, "sensor_baro");
  return log;
}

/// The bytes are written by hand from the description of the format.
TEST(Ulog, ReadsGoldenLogExactly) {
  const auto bytes = tests::parse_hex_bytes(
      "55 4C 6F 67 01 12 35 01 40 42 0F 00 00 00 00 00"  // magic, version 1, started at 1,000,000 us
      "28 00 42"
      "00 00 00 00 00 00 00 00"
      "00 00 00 00 00 00 00 00"  // B: no flags
      "00 00 00 00 00 00 00 00"
      "00 00 00 00 00 00 00 00"
      "00 00 00 00 00 00 00 00"
      "24 00 46"
      "67 3A 75 69 6E 74 36 34 5F 74 20 74 69 6D 65 73 74 61 6D 70 3B"  // F: "g:uint64_t timestamp;
      "69 6E 74 31 36 5F 74 5B 32 5D 20 61 3B"
      "20 20"  // int16_t[2] a;  "
      "04 00 41"
      "00 05 00 67"  // A: sensor 0, id 5, "g"
      "0E 00 44"
      "05 00"
      "80 84 1E 00 00 00 00 00"
      "FE FF"
      "07 00");  // D: id 5, 2,000,000 us, -2, 7
  std::string log(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  log.replace(log.find(";  "), 3, ";");
  // Reduce the size of the format by the two blanks.
  log[16 + 43] = 0x22;
  const auto rows = read_rows(log, ulog_map("g.a[0]", "g.a[1]"), "f");
  ASSERT_TRUE(rows) << text(rows.error());
  EXPECT_EQ(rows->columns[0], std::vector<double>{7});
  EXPECT_EQ(rows->columns[1], std::vector<double>{-2});
  EXPECT_TRUE(rows->notes.empty());
}

TEST(Ulog, HasNoRowWhenTimesAreImpossible) {
  UlogText log = two_series();
  constexpr std::uint64_t kNever = 1ull << 62;  // us
  log.data(0, gyro(kNever, 0.5F, 30)).data(0, gyro(kNever + 4000, 0.25F, 31));
  const auto rows = read_rows(log.text(), ulog_map("sensor_gyro.x", "sensor_gyro.temperature"), "f");
  ASSERT_FALSE(rows);
  EXPECT_NE(rows.error().what.find("expected at least one message"), std::string::npos);
}

/// A field of any size, in any number of series, takes one step.
TEST(Ulog, SkipsPaddingAndText) {
  constexpr int kBeginnings = 3000;
  for (const char* field : {"uint8_t[65000] _padding0", "char[65000] name", "uint64_t[8000] _padding1"}) {
    UlogText log;
    log.format(std::string("g:uint64_t timestamp;float x;float t;") + field + ";").format(kBaro);
    for (int i = 0; i < kBeginnings; ++i) log.subscribe(0, "g");
    EXPECT_TRUE(read_ulog_columns(Bytes(log.text(), "f")).has_value()) << field;
  }
}

/// A few bytes that expand to many fields are refused without much work.
TEST(Ulog, RefusesSeriesWithTooManyFields) {
  const auto nested = [](std::string name, int depth, const std::string& innermost) {
    UlogText log;
    log.format(name + "0:" + innermost);
    for (int i = 1; i <= depth; ++i)
      log.format(name + std::to_string(i) + ":" + name + std::to_string(i - 1) + "[4] y;");
    log.format("g:uint64_t timestamp;" + name + std::to_string(depth) + " x;");
    return log;
  };
  UlogText without_time, wide;
  without_time.format("g:uint8_t[65000] x;");
  wide.format("g:uint64_t timestamp;uint8_t[65000] x;uint8_t[65000] y;");
  for (UlogText log : {without_time, wide, nested("n", 6, "uint8_t[14] a;char[1] b;"), nested("m", 6, "char[3] a;")}) {
    for (int i = 0; i < 3000; ++i) log.subscribe(0, "g");
    const auto read = read_ulog_columns(Bytes(log.text(), "f"));
    ASSERT_FALSE(read);
    EXPECT_EQ(read.error().kind, FaultKind::bad_file);
  }
}

TEST(Ulog, KeepsTimesOfSingleSeries) {
  UlogText log = two_series();
  log.data(0, gyro(2'000'000, 0.5F, 30)).data(1, baro(2'000'500, 20)).data(0, gyro(2'004'000, 0.25F, 31));
  const auto rows = read_rows(log.text(), ulog_map("sensor_gyro.x", "sensor_gyro.temperature"), "f");
  ASSERT_TRUE(rows) << text(rows.error());
  EXPECT_EQ(rows->time, (std::vector<Duration>{{}, milliseconds(4)}));
  EXPECT_EQ(rows->columns[0], (std::vector<double>{30, 31}));
  EXPECT_EQ(rows->columns[1], (std::vector<double>{0.5, 0.25}));
}

TEST(Ulog, CombinesSeveralSeries) {
  UlogText log = two_series();
  for (unsigned i = 0; i < 3000; ++i) {
    log.data(0, gyro(1'000'000 + 1000 * i, static_cast<float>(i / 1000), 30));
    if (i % 100 == 0) log.data(1, baro(1'000'000 + 1000 * i - 200, static_cast<float>(20 + i / 1000)));
  }
  ImportMap map = ulog_map();
  EXPECT_EQ(
      text(read_rows(log.text(), map, "f").error()),
      "f: the map's columns come from several messages, expected every = \"1 s\" (or another interval) in [time], "
      "which combines them");
  map.every = seconds(1);
  const auto rows = read_rows(log.text(), map, "f");
  ASSERT_TRUE(rows) << text(rows.error());
  ASSERT_EQ(rows->time, (std::vector<Duration>{{}, seconds(1), seconds(2), seconds(3)}));
  EXPECT_EQ(rows->columns[1][1], 0);
  EXPECT_EQ(rows->columns[1][2], 1);
  EXPECT_NEAR(rows->columns[0][1], 20.1, 0.01) << "the barometer's first message is stamped in the second before";
}

TEST(Ulog, SeparatesSensorsOfOneKind) {
  UlogText log;
  log.format(kGyro).subscribe(0, "sensor_gyro").subscribe(1, "sensor_gyro", 1);
  log.data(0, gyro(1000, 1, 30)).data(1, gyro(1500, 2, 40)).data(0, gyro(2000, 3, 31)).data(1, gyro(2500, 4, 41));
  const auto rows = read_rows(log.text(), ulog_map("sensor_gyro[1].x", "sensor_gyro[1].temperature"), "f");
  ASSERT_TRUE(rows) << text(rows.error());
  EXPECT_EQ(rows->columns[1], (std::vector<double>{2, 4}));
}

TEST(Ulog, ExpandsNestedFormats) {
  UlogText log;
  log.format("point:float x;bool good;uint8_t[3] _padding0;")
      .format("path:uint64_t timestamp;char[4] name;point[2] at;double last;");
  log.subscribe(3, "path");
  const std::string point = little(1.5F) + '\1' + std::string(3, '\0');
  log.data(3, little(std::uint64_t{1000}) + "name" + point + little(2.5F) + '\0' + std::string(3, '\0') + little(7.25));
  const auto rows = read_rows(log.text(), ulog_map("path.at[1].x", "path.last"), "f");
  ASSERT_TRUE(rows) << text(rows.error());
  EXPECT_EQ(rows->columns[1], std::vector<double>{2.5});
  EXPECT_EQ(rows->columns[0], std::vector<double>{7.25});
}

TEST(Ulog, NamesMissingAndExistingColumns) {
  const UlogText log = two_series();
  EXPECT_EQ(text(read_rows(log.text(), ulog_map("sensor_gyro.y"), "f").error()),
            "f: no column \"sensor_gyro.y\", expected one of: \"sensor_gyro.timestamp\", \"sensor_gyro.device_id\", "
            "\"sensor_gyro.x\", \"sensor_gyro.temperature\"");
  EXPECT_EQ(
      text(read_rows(log.text(), ulog_map("gyro.x", "sensor_gyro[1].temperature"), "f").error()),
      "f: no columns \"sensor_gyro[1].temperature\", \"gyro.x\", expected one of: \"sensor_gyro\", \"sensor_baro\"");
}

TEST(Ulog, SkipsAndReportsDamage) {
  UlogText log = two_series();
  log.data(0, gyro(1000, 1, 30)).message('O', little(std::uint16_t{120})).message('!', "what?");
  log.data(0, gyro(2000, 1, 30).substr(0, 15)).data(9, "nobody's").data(0, gyro(3000, std::nanf(""), 31));
  const auto rows =
      read_rows(log.text() + std::string("\x20\0D\0\0", 5), ulog_map("sensor_gyro.x", "sensor_gyro.temperature"), "f");
  ASSERT_TRUE(rows) << text(rows.error());
  EXPECT_EQ(rows->columns[0], (std::vector<double>{30, 31}));
  EXPECT_TRUE(std::isnan(rows->columns[1][1]));
  EXPECT_EQ(rows->notes,
            (Notes{"1 drop-outs of the log, 120 ms in all", "1 messages of an unknown kind were skipped",
                   "1 messages are damaged and were left out", "the log ends within a message, 5 bytes of it"}));
}

/// The time of the first message decides whether times are counted since 1970.
TEST(Ulog, RefusesLogIfFirstTimeContradictsOthers) {
  constexpr std::uint64_t kSince1970_us = 1'772'352'000'000'000;
  for (const bool is_first_since_1970 : {true, false})
    for (const unsigned others : {1u, 2u, 100u}) {
      UlogText log = two_series();
      log.data(0, gyro(is_first_since_1970 ? kSince1970_us : 5'000'000, 1, 30));
      for (unsigned i = 0; i < others; ++i)
        log.data(0, gyro(1'000'000ull * (6 + i) + (is_first_since_1970 ? 0 : kSince1970_us), 1, 30));
      const auto rows = read_rows(log.text(), ulog_map("sensor_gyro.x", "sensor_gyro.temperature"), "f");
      EXPECT_EQ(rows.has_value(), others == 1) << others;
      if (!rows) EXPECT_NE(rows.error().what.find("impossible time"), std::string::npos) << text(rows.error());
    }
}

TEST(Ulog, RefusesMalformedArrays) {
  for (const char* type : {"[", "float[", "float[3", "[]", "float[]", "float[0]", "float[-1]",
                           "float[99999999999999999999]", "float[3]]", "float[[3]"}) {
    UlogText log;
    log.format(fmt::format("path:uint64_t timestamp;{} x;", type)).subscribe(3, "path");
    log.data(3, little(std::uint64_t{1000}) + std::string(40, '\0'));
    EXPECT_FALSE(read_rows(log.text(), ulog_map("path.x", "path.x"), "f")) << type;
  }
}

TEST(LogColumn, RequiresInstanceNumber) {
  EXPECT_EQ(parse_log_column("sensor_gyro[4294967295].x")->instance, 4294967295u);
  for (const char* name : {"sensor_gyro[4294967296].x", "sensor_gyro[99999999999].x", "sensor_gyro[].x", "[].x",
                           "sensor_gyro[-1].x", "sensor_gyro[1 ].x"})
    EXPECT_FALSE(parse_log_column(name)) << name;
}

/// Returns a log of 200 messages and the position of each.
std::pair<std::string, std::vector<std::size_t>> long_log() {
  UlogText log = two_series();
  std::vector<std::size_t> begins;
  for (unsigned i = 0; i < 200; ++i) {
    begins.push_back(log.text().size());
    log.data(0, gyro(1'000'000ull * i, static_cast<float>(i), 30));
  }
  return {log.text(), begins};
}

TEST(Ulog, ContinuesAfterDamage) {
  for (const std::string& damage :
       {std::string(512, '\0'), std::string(512, '\xFF'), std::string(100, 'D'), std::string("x")}) {
    auto [log, begins] = long_log();
    log.replace(begins[100] + 5, damage.size(), damage);
    const std::size_t touched = (damage.size() + 4) / (begins[1] - begins[0]) + 1;
    const auto rows = read_rows(log, ulog_map("sensor_gyro.x", "sensor_gyro.temperature"), "f");
    ASSERT_TRUE(rows) << text(rows.error());
    EXPECT_GE(rows->time.size(), 200 - touched - 1) << damage.size();
    EXPECT_EQ(rows->columns[1].back(), 199);
    if (damage.size() == 1) continue;
    for (const double temperature : rows->columns[0]) EXPECT_EQ(temperature, 30) << "data before damage is discarded";
  }
}

TEST(Ulog, ContinuesAfterMissingOrExtraBytes) {
  for (const int shift : {-310, -7, 5, 400}) {
    auto [log, begins] = long_log();
    if (shift < 0)
      log.erase(begins[50] + 3, static_cast<std::size_t>(-shift));
    else
      log.insert(begins[50] + 3, std::string(static_cast<std::size_t>(shift), '\x7A'));
    const auto rows = read_rows(log, ulog_map("sensor_gyro.x", "sensor_gyro.temperature"), "f");
    ASSERT_TRUE(rows) << text(rows.error());
    EXPECT_GE(rows->time.size(), 184u) << shift;
    EXPECT_EQ(rows->columns[1].back(), 199);
    EXPECT_FALSE(rows->notes.empty());
  }
}

TEST(Ulog, ReadsTimestampsSince1970) {
  for (const std::uint64_t start : {1'772'352'000'000'000ull, 1'000'000'000'000'000ull, 4'000'000'000'000'000ull}) {
    UlogText log = two_series();
    log.data(1, baro(start - 3'000'000, 20));
    for (unsigned i = 0; i < 5; ++i)
      log.data(0, gyro(start + 1'000'000ull * i, 1, 30)).data(1, baro(start + 1'000'000ull * i, 21));
    log.data(0, gyro(17, 9, 9));
    ImportMap map = ulog_map();
    map.every = seconds(1);
    const auto rows = read_rows(log.text(), map, "f");
    ASSERT_TRUE(rows) << text(rows.error());
    ASSERT_EQ(rows->time.size(), 6u);
    EXPECT_EQ(rows->time.back(), seconds(7));
    EXPECT_EQ(rows->utc.back(), microseconds(start + 4'000'000));
    EXPECT_EQ(rows->notes, Notes{"1 messages are damaged and were left out"});
  }
}

TEST(Ulog, AcceptsLateTopics) {
  for (const unsigned late : {1u, 3u, 4u}) {
    UlogText log = two_series();
    for (unsigned i = 0; i < 20; ++i) {
      log.data(0, gyro(1'000'000ull * i, static_cast<float>(i), 30));
      if (i >= late) log.data(1, baro(1'000'000ull * (i - late), static_cast<float>(20 + i - late)));
    }
    ImportMap map = ulog_map();
    map.every = seconds(1);
    const auto rows = read_rows(log.text(), map, "f");
    ASSERT_TRUE(rows) << text(rows.error());
    EXPECT_EQ(rows->columns[0][3], 23);
    EXPECT_EQ(rows->columns[1][3], 3);
  }
}

TEST(Ulog, ReadsDataAppendedAfterCrash) {
  const auto log_with = [](std::uint64_t offset) {
    UlogText log;
    log.message('B', std::string(8, '\0') + '\1' + std::string(7, '\0') + little(offset) + std::string(16, '\0'));
    log.format(kGyro).subscribe(0, "sensor_gyro").data(0, gyro(1000, 1, 30));
    return log.text() + std::string("\x40\0D\0\0cut off", 12);
  };
  const std::string before = log_with(log_with(0).size());
  UlogText after;
  const std::string header = after.text();
  after.data(0, gyro(2000, 2, 31));
  const auto rows =
      read_rows(before + after.text().substr(header.size()), ulog_map("sensor_gyro.x", "sensor_gyro.temperature"), "f");
  ASSERT_TRUE(rows) << text(rows.error());
  EXPECT_EQ(rows->columns[1], (std::vector<double>{1, 2}));
  EXPECT_TRUE(rows->notes.empty());
}

TEST(Ulog, RefusesLaterVersionAndOtherFiles) {
  std::string log = two_series().text();
  log[7] = 2;
  EXPECT_EQ(text(read_rows(log, ulog_map(), "f").error()), "f: ULog of version 2, expected at most 1");
  EXPECT_EQ(text(read_rows("t,T,w\n", ulog_map(), "f").error()),
            "f: not a ULog file, expected one (format = \"ulog\" in the map)");
  UlogText flags;
  flags.message('B', std::string(8, '\0') + '\2' + std::string(31, '\0'));
  EXPECT_FALSE(read_rows(flags.text(), ulog_map(), "f"));
  EXPECT_EQ(text(read_rows(two_series().text(), rate_map(), "f").error()),
            "f: the file is ulog, the map reads text; expected format = \"ulog\" in [file]");
}

TEST(Ulog, RefusesRecursiveFormats) {
  UlogText log;
  log.format("a:a[65535] a;uint64_t timestamp;").format("c:d[65535] x;uint64_t timestamp;").format("d:");
  log.format("e:uint64_t timestamp;uint8_t[65535] x;").subscribe(1, "a").subscribe(2, "c").subscribe(3, "e");
  EXPECT_FALSE(read_rows(log.text(), ulog_map(), "f"));
}

}  // namespace
}  // namespace gyrotherm::exchange
