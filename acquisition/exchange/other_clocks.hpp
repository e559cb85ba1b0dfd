// SPDX-License-Identifier: Apache-2.0
/// Columns with dates or times of day that a map does not name: what they say of how long a table lasts.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/exchange/foreign_row.hpp"

namespace gyrotherm::exchange {

class OtherClocks {
 public:
  struct Clock {
    std::size_t column{};
    std::string name{}, first{}, last{};
  };
  /// Keeps a column if its first text is a time; of a file with many such columns the first few.
  void begin(std::size_t column, const std::string& name, std::string_view first);
  [[nodiscard]] std::vector<Clock>& clocks() { return clocks_; }
  /// Puts the first of them that goes on into the findings.
  void report(Findings& findings) const;

 private:
  std::vector<Clock> clocks_{};
};

}  // namespace gyrotherm::exchange
