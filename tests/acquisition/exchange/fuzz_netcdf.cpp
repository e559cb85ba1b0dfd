// SPDX-License-Identifier: Apache-2.0
/// Reads any bytes as a NetCDF file, and as a valid file whose header they overwrite. The result must be rows or a
/// fault of the file, whatever the NetCDF library does.
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <fstream>
#include <string>

#include "acquisition/exchange/netcdf_table.hpp"
#include "tests/acquisition/exchange/classic_netcdf.hpp"
#include "tests/acquisition/exchange/fuzz.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/fuzz_target.hpp"

namespace gyrotherm::exchange {
namespace {

void require_rows_or_fault(const std::string& bytes) {
  static const tests::TestFolder folder;
  static const ImportMap map = netcdf_map();
  const std::string path = folder / ("file" + std::to_string(::getpid()) + ".nc");
  std::ofstream(path, std::ios::binary) << bytes;
  const ReadingLimits limits{.memory_bytes = 256 << 20, .processor_time = std::chrono::seconds(1)};
  std::size_t rows = 0;
  const auto read = read_netcdf(
      path, map,
      [&](const ForeignRow& row) -> Result<void> {
        require(row.numbers.size() == map.columns().size());
        return ++rows < 100'000 ? Result<void>() : failure(FaultKind::bad_file, path, "rows enough");
      },
      limits);
  if (!read) require(read.error().kind == FaultKind::bad_file && read.error().where.starts_with(path));
}

}  // namespace

FUZZ_TARGET(netcdf, const std::uint8_t* data, std::size_t size) {
  static const ClassicNetcdf good(3);
  static unsigned turn = 0;
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  // Skip most inputs, because each one starts a process.
  if (++turn % 32 != 0) return 0;
  require_rows_or_fault("CDF\x01" + bytes);
  std::string mutant = good.text();
  for (std::size_t i = 0; i + 2 < size && i < 12; i += 3)
    mutant[4 + (bytes[i] + 256U * static_cast<unsigned char>(bytes[i + 1])) % (good.header() - 4)] = bytes[i + 2];
  require_rows_or_fault(mutant);
  return 0;
}

}  // namespace gyrotherm::exchange
