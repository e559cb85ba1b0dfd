// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/netcdf_table.hpp"

#include <gtest/gtest.h>
#include <netcdf.h>

#include <array>
#include <chrono>
#include <cmath>
#include <fstream>
#include <random>

#include "acquisition/exchange/guess.hpp"
#include "tests/acquisition/exchange/classic_netcdf.hpp"
#include "tests/support/folder.hpp"

namespace gyrotherm::exchange {
namespace {

/// Reads the bytes as a file and returns the last number of w.
Result<double> last_rate(const std::string& bytes, const ReadingLimits& limits, std::size_t* rows = nullptr) {
  const tests::TestFolder folder;
  std::ofstream(folder / "file.nc", std::ios::binary) << bytes;
  double last = 0;
  const auto read = read_netcdf(
      folder / "file.nc", netcdf_map(),
      [&](const ForeignRow& row) -> Result<void> {
        EXPECT_EQ(row.numbers.size(), 2u);
        last = row.numbers[1];
        if (rows != nullptr) ++*rows;
        return {};
      },
      limits);
  return read ? Result<double>(last) : failure(read.error());
}

const ReadingLimits kSmall{.memory_bytes = 256 << 20, .processor_time = std::chrono::seconds(1)};

TEST(NetcdfTable, ReadsClassicFileRowByRow) {
  std::size_t rows = 0;
  EXPECT_EQ(last_rate(ClassicNetcdf(5).text(), {}, &rows), 1.0);
  EXPECT_EQ(rows, 5u);
}

/// The file is larger than the memory limit of the child.
TEST(NetcdfTable, ReadsLargeFileWithinLimits) {
  std::size_t rows = 0;
  const ReadingLimits small{.memory_bytes = 16 << 20, .processor_time = std::chrono::seconds(1)};
  EXPECT_EQ(last_rate(ClassicNetcdf(1'000'000).text(), small, &rows), 249'999.75);
  EXPECT_EQ(rows, 1'000'000u);
}

/// The library crashes on some of these files, and runs for a minute on others.
TEST(NetcdfTable, RefusesCountsLargerThanFile) {
  const ClassicNetcdf good(3);
  ASSERT_EQ(good.counts().size(), 6u);
  for (const std::size_t at : good.counts())
    for (const std::uint32_t count : {0x80000002U, 0xFFFFFFFFU, 0x7FFFFFFFU}) {
      SCOPED_TRACE("count " + std::to_string(count) + " at byte " + std::to_string(at));
      const auto read = last_rate(good.with(at, count), kSmall);
      ASSERT_FALSE(read);
      EXPECT_EQ(read.error().kind, FaultKind::bad_file);
      EXPECT_NE(read.error().where.find("file.nc"), std::string::npos) << text(read.error());
    }
}

/// Truncates files at each position and changes a few bytes in their headers.
TEST(NetcdfTable, ReadsOrRefusesDamagedFiles) {
  const ClassicNetcdf good(3);
  int refused = 0;
  for (std::size_t size = 0; size < good.header(); size += 7)
    refused += last_rate(good.text().substr(0, size), kSmall).has_value() ? 0 : 1;
  EXPECT_GT(refused, 20);
  for (unsigned seed = 0; seed < 60; ++seed) {
    std::mt19937 random(seed);
    std::string bytes = good.text();
    for (int i = 0; i < 3; ++i) bytes[4 + random() % (good.header() - 4)] = static_cast<char>(random());
    const auto read = last_rate(bytes, kSmall);
    if (!read) {
      EXPECT_EQ(read.error().kind, FaultKind::bad_file) << "seed " << seed;
    }
  }
}

/// A file of three rows with the CF attributes for validity and units.
struct CfFile {
  std::vector<std::pair<std::string, std::vector<double>>> valid{};
  std::string temperature_units{}, rate_units{};

  [[nodiscard]] std::string write_file(const std::string& path) const {
    int file = 0, rows = 0, time = 0, temperature = 0, rate = 0;
    const double times[] = {0, 1, 2}, temperatures[] = {20, 999, -999}, rates[] = {1, 2, 3};
    EXPECT_EQ(nc_create(path.c_str(), NC_CLOBBER, &file), NC_NOERR);
    nc_def_dim(file, "time", 3, &rows);
    nc_def_var(file, "t", NC_DOUBLE, 1, &rows, &time);
    nc_def_var(file, "T", NC_DOUBLE, 1, &rows, &temperature);
    nc_def_var(file, "w", NC_DOUBLE, 1, &rows, &rate);
    nc_put_att_text(file, time, "units", 7, "seconds");
    for (const auto& [name, bounds] : valid)
      nc_put_att_double(file, temperature, name.c_str(), NC_DOUBLE, bounds.size(), bounds.data());
    if (!temperature_units.empty())
      nc_put_att_text(file, temperature, "units", temperature_units.size(), temperature_units.c_str());
    if (!rate_units.empty()) nc_put_att_text(file, rate, "units", rate_units.size(), rate_units.c_str());
    nc_enddef(file);
    nc_put_var_double(file, time, times);
    nc_put_var_double(file, temperature, temperatures);
    nc_put_var_double(file, rate, rates);
    nc_close(file);
    return path;
  }
};

Result<std::vector<double>> calibrated_temperatures(const CfFile& file, double scale = 1, double offset = 0,
                                                    double rate = 1) {
  const tests::TestFolder folder;
  ImportMap map = netcdf_map();
  map.thermometer_columns[0] = {{"T"}, scale, offset, {}};
  map.axis_columns[0] = {"w"};
  map.units[0].axes[0].kind = record::GyroKind::rate;
  map.units[0].axes[0].scale = rate;
  std::vector<double> read;
  const auto done = read_netcdf(file.write_file(folder / "cf.nc"), map, [&](const ForeignRow& row) -> Result<void> {
    read.push_back(row.numbers[0]);
    return {};
  });
  return done ? Result<std::vector<double>>(read) : failure(done.error());
}

TEST(NetcdfTable, RequiresCountingTimesInSeconds) {
  const tests::TestFolder folder;
  ImportMap map = netcdf_map();
  map.thermometer_columns[0] = {{"T"}, 1, 0, {}};
  map.axis_columns[0] = {"w"};
  map.interval_columns = {ColumnName{"w"}};
  const auto can_read = [&](const char* units) {
    CfFile file;
    file.rate_units = units;
    const auto read =
        read_netcdf(file.write_file(folder / "cf.nc"), map, [](const ForeignRow&) { return Result<void>(); });
    EXPECT_TRUE(read || read.error().kind == FaultKind::bad_file);
    return read.has_value();
  };
  EXPECT_TRUE(can_read("") && can_read("s") && can_read("seconds"));
  EXPECT_FALSE(can_read("ms") || can_read("degC"));
}

TEST(NetcdfTable, TreatsNumbersOutsideValidRangeAsMissing) {
  const auto is_missing = [](const CfFile& file) {
    const auto read = calibrated_temperatures(file);
    EXPECT_TRUE(read) << text(read.error());
    std::vector<bool> missing;
    for (const double number : read.value_or(std::vector<double>{})) missing.push_back(std::isnan(number));
    return missing;
  };
  EXPECT_EQ(is_missing({.valid = {{"valid_range", {-60, 120}}}}), (std::vector<bool>{false, true, true}));
  EXPECT_EQ(is_missing({.valid = {{"valid_max", {120}}}}), (std::vector<bool>{false, true, false}));
  EXPECT_EQ(is_missing({.valid = {{"valid_min", {-60}}}}), (std::vector<bool>{false, false, true}));
  EXPECT_EQ(is_missing({}), (std::vector<bool>{false, false, false}));
}

TEST(NetcdfTable, ComparesUnitsWithMap) {
  for (const char* units : {"K", "kelvin", "degree_F"}) {
    const auto read = calibrated_temperatures({.temperature_units = units});
    ASSERT_FALSE(read) << units;
    EXPECT_NE(read.error().what.find("expected scale"), std::string::npos) << text(read.error());
  }
  EXPECT_TRUE(calibrated_temperatures({.temperature_units = "K"}, 1.01, -272.6)) << "calibrated";
  EXPECT_TRUE(calibrated_temperatures({.temperature_units = "degree_Celsius"}));
  for (const char* units : {"rad s-1", "deg/s", "mdps"})
    EXPECT_FALSE(calibrated_temperatures({.rate_units = units})) << units;
  EXPECT_TRUE(calibrated_temperatures({.rate_units = "rad s-1"}, 1, 0, 206264.8));
  EXPECT_TRUE(calibrated_temperatures({.rate_units = "counts"}));
}

/// An HDF5 file with vectors as MATLAB writes them: each has rank 2, one dimension of 1, and no units.
struct Vectors {
  /// The vectors are 4×1 instead of 1×4.
  bool in_columns = false;
  /// The number of bytes before the HDF5 signature.
  std::size_t block{};
  [[nodiscard]] std::string write_file(const std::string& path) const {
    int file = 0, one = 0, many = 0, three = 0, id = 0;
    nc_create(path.c_str(), NC_NETCDF4 | NC_CLOBBER, &file);
    nc_def_dim(file, "one", 1, &one);
    nc_def_dim(file, "many", 4, &many);
    nc_def_dim(file, "three", 3, &three);
    const std::array<int, 2> vector{in_columns ? many : one, in_columns ? one : many}, table{many, three};
    const std::array<double, 4> times{0, 10, 20, 30}, temperatures{20, 21, 22, 23}, rates{1, 2, 3, 4};
    for (const auto& [name, numbers] :
         {std::pair("time", times), std::pair("T", temperatures), std::pair("w", rates)}) {
      nc_def_var(file, name, NC_DOUBLE, 2, vector.data(), &id);
      nc_put_var_double(file, id, numbers.data());
    }
    nc_def_var(file, "matrix", NC_DOUBLE, 2, table.data(), &id);
    nc_close(file);
    std::ifstream in(path, std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(in)), {});
    std::ofstream(path, std::ios::binary) << std::string(block, ' ') << bytes;
    return path;
  }
};

ImportMap vector_map(const std::string& unit, const std::string& rate = "w") {
  const auto map =
      parse_import_map("schema = \"gyrotherm-import/1\"\nname = \"m\"\n[file]\nformat = \"netcdf\"\n[time]\n" +
                           (unit.empty() ? unit : "unit = \"" + unit + "\"\n") +
                           "[[thermometer]]\nname = \"T\"\ncolumn = \"T\"\n[gyro]\ncolumn = \"" + rate +
                           "\"\nkind = \"rate\"\nscale = 1\n",
                       "map");
  EXPECT_TRUE(map) << text(map.error());
  return map.value_or(ImportMap{});
}

TEST(NetcdfTable, ReadsVectorsOfHdf5) {
  const tests::TestFolder folder;
  for (const Vectors& file :
       {Vectors{}, Vectors{.in_columns = true}, Vectors{.block = 512}, Vectors{.in_columns = true, .block = 512}}) {
    std::vector<double> times, numbers;
    std::optional<Duration> utc;
    const auto done = read_netcdf(file.write_file(folder / "m.mat"), vector_map("minutes since 2026-03-01"),
                                  [&](const ForeignRow& row) -> Result<void> {
                                    times.push_back(to_seconds(row.time));
                                    numbers.insert(numbers.end(), row.numbers.begin(), row.numbers.end());
                                    if (!utc) utc = row.utc;
                                    return {};
                                  });
    ASSERT_TRUE(done) << text(done.error());
    EXPECT_EQ(times, (std::vector<double>{0, 600, 1200, 1800}));
    EXPECT_EQ(numbers, (std::vector<double>{20, 1, 21, 2, 22, 3, 23, 4}));
    EXPECT_EQ(utc, std::chrono::sys_days(std::chrono::year(2026) / 3 / 1).time_since_epoch());
  }
}

TEST(NetcdfTable, RequiresUnitsWhenHdf5HasNone) {
  const tests::TestFolder folder;
  const auto said = [&](const ImportMap& map) {
    const auto read =
        read_netcdf(Vectors{}.write_file(folder / "m.mat"), map, [](const ForeignRow&) { return Result<void>{}; });
    return read ? "" : text(read.error());
  };
  EXPECT_NE(said(vector_map("")).find("\"time\" has no units, expected unit = \"s\""), std::string::npos);
  EXPECT_NE(said(vector_map("fortnights")).find("not a unit of time"), std::string::npos);
  EXPECT_NE(said(vector_map("s", "matrix")).find("no column \"matrix\""), std::string::npos);
  EXPECT_EQ(said(vector_map("s")), "");
  auto map = vector_map("s");
  map.time->name = "t";
  const auto twice =
      read_netcdf(CfFile{}.write_file(folder / "cf.nc"), map, [](const ForeignRow&) { return Result<void>{}; });
  ASSERT_FALSE(twice);
  EXPECT_NE(text(twice.error()).find("expected no unit in the map"), std::string::npos) << text(twice.error());
}

/// Writes a file like those of MATLAB's -v7.3: a struct with vectors, a matrix, and optionally a vector.
void write_struct(const std::string& path, bool has_vector) {
  int file = 0, group = 0, one = 0, rows = 0, columns = 0, id = 0;
  ASSERT_EQ(nc_create(path.c_str(), NC_NETCDF4, &file), NC_NOERR);
  nc_def_dim(file, "one", 1, &one);
  nc_def_dim(file, "rows", 20, &rows);
  nc_def_dim(file, "columns", 3, &columns);
  nc_def_grp(file, "rec", &group);
  const std::array<int, 2> vector{one, rows}, matrix{columns, rows};
  nc_def_var(group, "t", NC_DOUBLE, 2, vector.data(), &id);
  nc_def_var(file, "data", NC_DOUBLE, 2, matrix.data(), &id);
  if (has_vector) nc_def_var(file, "w", NC_DOUBLE, 2, vector.data(), &id);
  nc_close(file);
}

TEST(NetcdfTable, NamesGroupsAndMatricesThatItCannotRead) {
  const tests::TestFolder folder;
  for (const bool has_vector : {false, true}) {
    const auto path = folder / (has_vector ? "with.mat" : "without.mat");
    write_struct(path, has_vector);
    ImportMap map = netcdf_map();
    map.time = ColumnName{"rec/t"};
    const auto read = read_netcdf(path, map, [](const ForeignRow&) { return Result<void>(); });
    ASSERT_FALSE(read);
    const auto& what = read.error().what;
    EXPECT_NE(what.find("no column \"rec/t\""), std::string::npos) << what;
    EXPECT_EQ(what.find("expected one of: \"w\"") != std::string::npos, has_vector) << what;
    EXPECT_NE(what.find("the group \"rec\" (\"t\" 1×20), \"data\" 3×20"), std::string::npos) << what;
    const auto guessed = guess_map(path);
    ASSERT_FALSE(guessed);
    EXPECT_NE(guessed.error().what.find("\"data\" 3×20"), std::string::npos) << guessed.error().what;
    EXPECT_EQ(guessed.error().what.find("\"w\"") != std::string::npos, has_vector) << guessed.error().what;
  }
}

}  // namespace
}  // namespace gyrotherm::exchange
