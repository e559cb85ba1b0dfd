// SPDX-License-Identifier: Apache-2.0
/// Files of other programs for the tests: maps, rows read with them, and logs built message by message.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/exchange/import.hpp"

namespace gyrotherm::exchange {

/// The rows read from a file, as columns.
struct ReadRows {
  std::vector<Duration> time{}, interval{};
  std::vector<std::optional<Duration>> utc{};
  /// One column per column of the map.
  std::vector<std::vector<double>> columns{};
  Notes notes{};
};

inline Result<ReadRows> read_rows(std::string_view bytes, const ImportMap& map, const std::string& name) {
  ReadRows rows;
  rows.columns.resize(map.columns().size());
  auto notes = read_foreign_text(bytes, name, map, [&](const ImportedRow& row) -> Result<void> {
    rows.time.push_back(row.time);
    rows.interval.push_back(row.interval);
    rows.utc.push_back(row.utc);
    for (std::size_t i = 0; i < rows.columns.size(); ++i) rows.columns[i].push_back(row.numbers[i]);
    return {};
  });
  if (!notes) return failure(notes.error());
  rows.notes = *notes;
  return rows;
}

/// Returns the map of a table with a time in milliseconds, a thermometer and a rate.
inline ImportMap rate_map() {
  ImportMap map;
  map.name = "bench";
  map.text = "the map";
  map.time = ColumnName{"t"};
  map.time_unit = std::chrono::milliseconds(1);
  map.thermometers = {"die"};
  map.thermometer_columns = {{{"T"}, 0.5, -1}};
  map.units = {{.axes = {{.kind = record::GyroKind::rate, .scale = 219.5}}}};
  map.axis_columns = {{"w"}};
  return map;
}

/// Returns the bytes of a number in a log, the least significant first.
template <class T>
[[nodiscard]] std::string little(T number) {
  std::string bytes(sizeof number, '\0');
  // Assumes a little-endian machine.
  std::memcpy(bytes.data(), &number, sizeof number);
  return bytes;
}

/// A ULog file, built message by message.
class UlogText {
 public:
  UlogText() : text_("\x55\x4C\x6F\x67\x01\x12\x35\x01" + little(std::uint64_t{1'000'000})) {}
  UlogText& message(char kind, const std::string& what) {
    text_ += little(static_cast<std::uint16_t>(what.size())) + kind + what;
    return *this;
  }
  UlogText& format(const std::string& what) { return message('F', what); }
  UlogText& subscribe(std::uint16_t id, const std::string& name, std::uint8_t instance = 0) {
    return message('A', little(instance) + little(id) + name);
  }
  UlogText& data(std::uint16_t id, const std::string& what) { return message('D', little(id) + what); }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string text_;
};

/// A DataFlash log, built message by message.
class DataflashText {
 public:
  DataflashText() { format(128, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns", 89); }
  DataflashText& format(std::uint8_t kind, const std::string& name, const std::string& format,
                        const std::string& labels, std::uint8_t size) {
    return message(128, little(kind) + little(size) + padded(name, 4) + padded(format, 16) + padded(labels, 64));
  }
  DataflashText& message(std::uint8_t kind, const std::string& what) {
    text_ += "\xA3\x95" + little(kind) + what;
    return *this;
  }
  DataflashText& stray(const std::string& bytes) {
    text_ += bytes;
    return *this;
  }
  [[nodiscard]] static std::string padded(std::string text, std::size_t size) {
    text.resize(size, '\0');
    return text;
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string text_{};
};

}  // namespace gyrotherm::exchange
