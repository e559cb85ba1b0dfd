// SPDX-License-Identifier: Apache-2.0
/// Reads any bytes as a DataFlash log, with and without preceding formats that may match them.
#include <cstddef>
#include <cstdint>
#include <string>

#include "acquisition/exchange/dataflash.hpp"
#include "tests/acquisition/exchange/foreign.hpp"
#include "tests/acquisition/exchange/fuzz.hpp"
#include "tests/support/fuzz_target.hpp"

namespace gyrotherm::exchange {

namespace {

ImportMap dataflash_map(bool together) {
  ImportMap map = rate_map();
  map.format = FileFormat::dataflash;
  map.time.reset();
  if (together) map.every = std::chrono::milliseconds(5);
  map.thermometer_columns[0].column.name = "IMU.T";
  map.axis_columns[0].name = "IMU.GyrX";
  return map;
}

std::string build_log(const std::string& bytes) {
  DataflashText log;
  log.format(9, "IMU", "QBfc", "TimeUS,I,GyrX,T", 18).format(10, "FMTU", "QBNN", "TimeUS,FmtType,UnitIds,MultIds", 44);
  for (std::size_t i = 0; i + 16 < bytes.size(); i += 16) {
    const std::string what = bytes.substr(i + 1, 15);
    switch (bytes[i] & 7) {
      case 0: log.format(9, "IMU", what, "TimeUS,I,GyrX,T", static_cast<std::uint8_t>(what[0])); break;
      case 1: log.stray(what); break;
      case 2:
        log.message(10, std::string(8, '\0') + '\x09' + DataflashText::padded(what, 16) + std::string(16, '\0'));
        break;
      default: log.message(9, what.substr(0, 4) + std::string(4, '\0') + what.substr(4, 7)); break;
    }
  }
  return log.text();
}

}  // namespace

FUZZ_TARGET(dataflash, const std::uint8_t* data, std::size_t size) {
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  for (const std::string& log : {bytes, DataflashText().text() + bytes, build_log(bytes)}) {
    for (const bool together : {false, true}) require_rows_or_a_fault(log, dataflash_map(together));
    (void)read_dataflash_columns(Bytes(log, "fuzz"));
  }
  return 0;
}

}  // namespace gyrotherm::exchange
