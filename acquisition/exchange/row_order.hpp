// SPDX-License-Identifier: Apache-2.0
/// Puts the rows of a file of another program in order of time, as the map requires.
#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/exchange/foreign_row.hpp"
#include "acquisition/exchange/import_map.hpp"
#include "acquisition/exchange/increment_columns.hpp"
#include "core/result.hpp"

namespace gyrotherm::exchange {

/// Returns the fault for a row that is earlier than the row before it by `back`. The fault names the map key that can
/// help.
[[nodiscard]] Fault out_of_order(const ImportMap& map, Duration back, std::optional<Duration> utc);

/// Returns the note about rows, at least one, that were left out because of their time.
[[nodiscard]] std::string describe_rows_left_out(std::size_t rows);

/// Orders the rows of one file.
class RowOrder {
 public:
  RowOrder(const ImportMap& map, TakeRow take);

  /// Passes rows on in order of time. Rows with equal times are in order only if the map combines rows. A row out of
  /// order is treated as the map requires:
  /// - refuse: fails with bad_file, without a position, at the first such row.
  /// - skip: drops the fewest rows such that the remaining rows of each window of 33 rows are in order. Adds the
  ///   increments of a dropped row, and their counting time, to the next row.
  /// - continue: shifts the times of the row and of all later rows, such that the row follows its predecessor at the
  ///   last spacing. Fails with bad_file, without a position, if the row is then more than ten years after the first
  ///   one or after 2116.
  /// Fails as `take` does.
  [[nodiscard]] Result<void> push(const ForeignRow& row);
  [[nodiscard]] Result<void> finish();
  /// Adds notes about rows that were left out or moved.
  void note(Notes& notes) const;
  [[nodiscard]] std::size_t skipped_rows() const { return left_out_; }

 private:
  struct Held {
    Duration time{};
    std::optional<Duration> utc{};
    std::vector<double> numbers{};
  };
  [[nodiscard]] bool is_after(Duration time, Duration before) const {
    return is_grouped_ ? time >= before : time > before;
  }
  [[nodiscard]] bool is_front_in_order() const;
  [[nodiscard]] Result<void> pop();
  [[nodiscard]] Result<void> pass_on(const ForeignRow& row);
  void leave_out(const ForeignRow& row);

  const ImportMap& map_;
  TakeRow take_;
  bool is_grouped_;
  IncrementColumns increments_;
  std::deque<Held> held_{};
  std::vector<double> carried_{}, added_{};  ///< increments of rows left out
  bool carries_ = false;
  /// The time of the last row passed on.
  std::optional<Duration> last_{};
  /// The last positive spacing.
  Duration step_{};
  /// Current shift of the times because the clock was set back.
  Duration moved_{};
  std::size_t left_out_{}, set_back_{};
  Duration first_back_{};
};

}  // namespace gyrotherm::exchange
