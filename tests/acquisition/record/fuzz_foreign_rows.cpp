// SPDX-License-Identifier: Apache-2.0
/// Any bytes as a foreign table: rows of equal length whose numbers are finite and whose time increases, or a fault
/// with its place.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "acquisition/record/import.hpp"

namespace gyrotherm::record {

namespace {

/// The first byte chooses the map, so that every separator and both kinds of time are reached.
ImportMap chosen_map(std::uint8_t choice) {
  constexpr char kSeparators[] = {',', ';', '\t', ' '};
  ImportMap map;
  map.separator = kSeparators[choice & 3];
  map.header = (choice & 4) != 0;
  map.skip = (choice & 8) != 0 ? 1 : 0;
  map.comment = (choice & 16) != 0 ? "%" : "";
  if ((choice & 32) != 0) map.time = ColumnName{"a", 1};
  map.time_unit = std::chrono::milliseconds(1);
  map.interval = std::chrono::seconds(1);
  map.thermometers = {"T"};
  map.thermometer_columns = {{{"b", 2}, 2, 1}};
  map.units = {{.axes = {AxisInfo{}}}};
  map.axis_columns = {{"b", 2}};
  return map;
}

void require(bool condition) {
  if (!condition) std::abort();
}

void run(const ImportMap& map, const std::string& bytes) {
  const auto rows = parse_foreign_rows(bytes, map, "fuzz");
  if (!rows) return require(rows.error().kind == FaultKind::bad_file && rows.error().where.starts_with("fuzz:"));
  const auto& rotation = rows->rotation.front();
  require(!rotation.empty() && rotation.size() == rows->time.size() && rotation.size() == rows->interval.size());
  for (const double number : rotation) require(std::isfinite(number));
  for (std::size_t i = 1; i < rows->time.size(); ++i) require(rows->time[i] > rows->time[i - 1]);
  (void)find_silences(rows->time);
}

/// A row, then a line of the same over and over.
std::string drawn_out(const std::string& bytes) {
  constexpr std::size_t kTooLong = 70'000;
  std::string text = bytes + "\n";
  while (text.size() < kTooLong) text += bytes.substr(0, bytes.find('\n')) + ",";
  return text;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const ImportMap map = chosen_map(data[0]);
  const std::string bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  run(map, bytes);
  if (data[0] % 8 == 0) run(map, drawn_out(bytes));
  return 0;
}

}  // namespace gyrotherm::record
