// SPDX-License-Identifier: Apache-2.0
/// Reads any bytes as a text table, in any encoding.
#include <cstddef>
#include <cstdint>
#include <string>

#include "tests/acquisition/exchange/fuzz.hpp"
#include "tests/support/fuzz_target.hpp"

namespace gyrotherm::exchange {

namespace {

/// Chooses a map by the first byte. Together, the maps use every separator and every kind of time.
ImportMap choose_map(std::uint8_t choice) {
  constexpr char kSeparators[] = {',', ';', '\t', ' '};
  ImportMap map;
  map.separator = kSeparators[choice & 3];
  map.decimal = choice % 4 != 0 && (choice & 64) != 0 ? ',' : '.';
  map.header = (choice & 4) != 0;
  map.skip = (choice & 8) != 0 ? 1 : 0;
  map.comment = (choice & 16) != 0 ? "%" : "";
  map.leaves_out_damaged = (choice & 16) != 0;
  map.missing = {"", "x"};
  if ((choice & 32) != 0) map.time = ColumnName{"a", 1};
  map.time_form = (choice & 128) == 0 ? TimeForm::number : (choice & 8) != 0 ? TimeForm::clock : TimeForm::civil;
  if ((choice & 64) != 0) map.wrap = CountedTime{65, Duration(536'000'000)};
  map.time_unit = std::chrono::milliseconds(1);
  if (!map.time) map.interval = std::chrono::seconds(1);
  if ((choice & 64) != 0) map.every = std::chrono::seconds(2);
  map.out_of_order = (choice & 8) != 0 ? OutOfOrder::skip : OutOfOrder::refuse;
  map.thermometers = {"T"};
  map.thermometer_columns = {{{"b", 2}, 2, 1}};
  map.units = {{.axes = {record::AxisInfo{}}}};
  map.axis_columns = {{"b", 2}};
  return map;
}

/// Returns a row followed by many repetitions of a line. Such an input takes as much work as hundreds of others.
std::string append_repetitions(const std::string& bytes) {
  constexpr std::size_t kTooLong = 70'000;
  std::string text = bytes + "\n";
  while (text.size() < kTooLong) text += bytes.substr(0, bytes.find('\n')) + ",";
  return text;
}

/// Converts a text to UTF-16.
std::string to_utf16(const std::string& bytes) {
  std::string wide = "\xFF\xFE";
  for (const char byte : bytes) wide += {byte, byte == 'z' ? '\xD8' : '\0'};
  return wide;
}

}  // namespace

FUZZ_TARGET(text_table, const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const ImportMap map = choose_map(data[0]);
  const std::string bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  require_rows_or_a_fault(bytes, map);
  require_rows_or_a_fault(to_utf16(bytes), map);
  require_rows_or_a_fault((map.header ? "a,b\n" : "") + bytes, map);
  if (data[0] % 8 == 0 && bytes.size() % 32 == 1) require_rows_or_a_fault(append_repetitions(bytes), map);
  return 0;
}

}  // namespace gyrotherm::exchange
