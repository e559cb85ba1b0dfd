// SPDX-License-Identifier: Apache-2.0
/// Reads any bytes after the header of a ULog file, with and without preceding formats that may match them.
#include <cstddef>
#include <cstdint>
#include <string>

#include "acquisition/exchange/ulog.hpp"
#include "tests/acquisition/exchange/foreign.hpp"
#include "tests/acquisition/exchange/fuzz.hpp"
#include "tests/support/fuzz_target.hpp"

namespace gyrotherm::exchange {

namespace {

ImportMap ulog_map(bool together) {
  ImportMap map = rate_map();
  map.format = FileFormat::ulog;
  map.time.reset();
  if (together) map.every = std::chrono::milliseconds(5);
  map.thermometer_columns[0].column.name = "g.t";
  map.axis_columns[0].name = "g.x[1]";
  return map;
}

/// Expands each byte to an element of the message grammar, so a few bytes give complete messages.
std::string build_ulog(const std::string& bytes) {
  UlogText log;
  log.format("g:uint64_t timestamp;float[2] x;int16_t t;").subscribe(7, "g");
  for (std::size_t i = 0; i + 20 < bytes.size(); i += 20) {
    const std::string what = bytes.substr(i + 1, 19);
    switch (bytes[i] & 7) {
      case 0: log.format("g:" + what); break;
      case 1: log.format("h:uint64_t timestamp;g[3] y;" + what.substr(0, 3) + " z;"); break;
      case 2: log.subscribe(7, (what[0] & 1) != 0 ? "h" : "g"); break;
      case 3:
        log.message('B', std::string(8, '\0') + std::string(1, what[0] & 1) + std::string(7, '\0') + what + what);
        break;
      case 4: log.message(what[0], what); break;
      default: log.data(7, what.substr(0, 4) + std::string(4, '\0') + what.substr(4, 10)); break;
    }
  }
  return log.text();
}

}  // namespace

FUZZ_TARGET(ulog, const std::uint8_t* data, std::size_t size) {
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  for (const std::string& log : {UlogText().text() + bytes, build_ulog(bytes), build_ulog(bytes + bytes) + bytes}) {
    for (const bool together : {false, true}) require_rows_or_a_fault(log, ulog_map(together));
    (void)read_ulog_columns(Bytes(log, "fuzz"));
  }
  return 0;
}

}  // namespace gyrotherm::exchange
