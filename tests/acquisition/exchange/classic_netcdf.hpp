// SPDX-License-Identifier: Apache-2.0
/// Builds NetCDF files of the classic format (NetCDF User's Guide, "File Format Specifications").
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "acquisition/exchange/import_map.hpp"
#include "tests/acquisition/exchange/foreign.hpp"

namespace gyrotherm::exchange {

/// A file with the variables t, T and w along one dimension, as doubles.
class ClassicNetcdf {
 public:
  explicit ClassicNetcdf(std::uint32_t rows) {
    text_ = "CDF\x01";
    number(0);  // records
    list(10, 1);
    name("t");
    number(rows);
    list(0, 0);  // no attributes of the file
    list(11, 3);
    std::vector<std::size_t> begins;
    for (const char* variable : {"t", "T", "w"}) {
      name(variable);
      number(1);  // dimension
      number(0);
      if (*variable == 't') {
        list(12, 1);
        attribute("units", "seconds since 2026-01-01");
      } else {
        list(12, 1);
        attribute("long_name", variable);
      }
      number(6);  // double
      number(rows * 8);
      begins.push_back(text_.size());
      number(0);
    }
    for (const std::size_t at : begins) {
      replace(at, static_cast<std::uint32_t>(text_.size() + (at == begins[0]   ? 0
                                                             : at == begins[1] ? rows * 8
                                                                               : rows * 16)));
    }
    header_ = text_.size();
    for (int variable = 0; variable < 3; ++variable)
      for (std::uint32_t row = 0; row < rows; ++row) real(variable == 0 ? row : variable == 1 ? 20.5 : 0.25 * row);
  }

  /// Returns the file with the number at an offset of its header replaced.
  [[nodiscard]] std::string with(std::size_t at, std::uint32_t number) const {
    ClassicNetcdf other = *this;
    other.replace(at, number);
    return other.text_;
  }
  [[nodiscard]] const std::string& text() const { return text_; }
  /// Returns the size of the header.
  [[nodiscard]] std::size_t header() const { return header_; }
  /// Returns the offsets of the list lengths: dimensions, attributes of the file, variables, their attributes.
  [[nodiscard]] const std::vector<std::size_t>& counts() const { return counts_; }

 private:
  static std::string big(std::uint64_t number, int bytes) {
    std::string text;
    for (int i = bytes - 1; i >= 0; --i) text += static_cast<char>(number >> (8 * i) & 0xFF);
    return text;
  }
  void number(std::uint32_t number) { text_ += big(number, 4); }
  void real(double value) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    text_ += big(bits, 8);
  }
  void replace(std::size_t at, std::uint32_t number) { text_.replace(at, 4, big(number, 4)); }
  void list(std::uint32_t tag, std::uint32_t count) {
    number(tag);
    counts_.push_back(text_.size());
    number(count);
  }
  void name(const std::string& name) {
    number(static_cast<std::uint32_t>(name.size()));
    text_ += name + std::string((4 - name.size() % 4) % 4, '\0');
  }
  void attribute(const std::string& key, const std::string& value) {
    name(key);
    number(2);  // characters
    name(value);
  }

  std::string text_;
  std::size_t header_{};
  std::vector<std::size_t> counts_{};
};

/// Returns a map for such a file.
inline ImportMap netcdf_map() {
  ImportMap map = rate_map();
  map.format = FileFormat::netcdf;
  return map;
}

}  // namespace gyrotherm::exchange
