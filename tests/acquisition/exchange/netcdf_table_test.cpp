// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/netcdf_table.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <random>

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

/// More bytes than the child may take of memory.
TEST(NetcdfTable, ReadsLargeFileWithinLimits) {
  std::size_t rows = 0;
  const ReadingLimits small{.memory_bytes = 16 << 20, .processor_time = std::chrono::seconds(1)};
  EXPECT_EQ(last_rate(ClassicNetcdf(1'000'000).text(), small, &rows), 249'999.75);
  EXPECT_EQ(rows, 1'000'000u);
}

/// The library crashes on some of these, and runs for a minute on others.
TEST(NetcdfTable, RefusesCountsThatAreNotThoseOfTheFile) {
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

/// Files cut off anywhere, and files with a few other bytes in their header, are read or refused.
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

}  // namespace
}  // namespace gyrotherm::exchange
