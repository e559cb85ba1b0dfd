// SPDX-License-Identifier: Apache-2.0
/// Which columns of a table say when its rows were written, and how.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/exchange/table_sample.hpp"

namespace gyrotherm::exchange {

/// The [time] of a first map.
struct TimeGuess {
  std::string text{};                  ///< with its head
  std::vector<std::size_t> columns{};  ///< that are used by it, or would be if they were understood
};

/// Guesses by names, by how the texts are written, and by how the numbers go on. Where two readings are as likely, or a
/// column looks like a date that is not known, the map lacks a key, so that no import goes on before people have said
/// which it is. `thermometers` are columns of temperatures, by whose pace seconds and milliseconds are told apart.
[[nodiscard]] TimeGuess guess_time(const TableSample& sample, const std::vector<std::size_t>& thermometers);

/// Columns as a map calls them: "column = "T1"", or "column_number = 3" with their name behind; of a table without a
/// header "column = 3".
[[nodiscard]] std::string reference(const TableSample& sample, std::size_t column, const std::string& key = "column");

/// A text in quotes, as TOML reads it.
[[nodiscard]] std::string toml_text(std::string_view text);

}  // namespace gyrotherm::exchange
