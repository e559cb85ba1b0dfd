// SPDX-License-Identifier: Apache-2.0
/// Selects the columns whose numbers are added when rows are combined: the increments of gyros, and the times over
/// which they were counted.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "acquisition/exchange/import_map.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm::exchange {

/// The increments of a row and their counting times. A row is one number per column of ImportMap::columns().
class IncrementColumns {
 public:
  explicit IncrementColumns(const ImportMap& map);

  /// Returns whether the numbers of a column are added when rows are combined.
  [[nodiscard]] bool is_summed(std::size_t column) const {
    return column < columns_.size() && columns_[column].is_summed;
  }
  /// Returns whether any column is summed.
  [[nodiscard]] bool has_any() const { return has_any_; }
  /// Returns the column with the counting times of a summed column, if the map has one.
  [[nodiscard]] std::optional<std::size_t> find_counting_times(std::size_t column) const {
    return columns_[column].interval;
  }
  /// Returns whether a row belongs to the sum of a summed column. A row without a counting time does not: neither its
  /// increment nor its time is known, so the sums of both cover the other rows.
  [[nodiscard]] bool is_counted(std::size_t column, std::span<const double> numbers) const;
  /// Sets the increments of a unit to missing if its counting time is missing. Fails with bad_file, without a position,
  /// if a counting time is not positive or exceeds ten years.
  [[nodiscard]] Result<void> check(std::span<double> numbers) const;
  /// Returns the counting time of a unit in a row, or nothing if it is missing or exceeds ten years. If the map has no
  /// column of the unit's counting times, returns `fallback`.
  [[nodiscard]] std::optional<Duration> counting_time(std::size_t unit, std::span<const double> numbers,
                                                      Duration fallback) const;

 private:
  struct Column {
    bool is_summed = false;
    /// The index of the column with the counting times.
    std::optional<std::size_t> interval{};
  };
  std::vector<Column> columns_{};
  /// The index of each unit's column of counting times, and its name.
  std::vector<std::optional<std::size_t>> unit_intervals_{};
  std::vector<ColumnName> names_{};
  bool has_any_ = false;
};

}  // namespace gyrotherm::exchange
