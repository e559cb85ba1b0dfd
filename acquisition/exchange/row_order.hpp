// SPDX-License-Identifier: Apache-2.0
/// Rows of a foreign file in order of time, by what the map says of those that are not.
#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <vector>

#include "acquisition/exchange/foreign_row.hpp"
#include "acquisition/exchange/import_map.hpp"
#include "core/result.hpp"

namespace gyrotherm::exchange {

/// The fault of a row whose time goes back so far, or stands still, with the key of the map that helps.
[[nodiscard]] Fault out_of_order(const ImportMap& map, Duration back, std::optional<Duration> utc);

class RowOrder {
 public:
  RowOrder(const ImportMap& map, TakeRow take);

  /// Hands rows on in order of time; where the map puts rows together, of several with the same time too. A map that
  /// refuses: fails with bad_file and no place at the first row that goes back or, unless they are put together, stands
  /// still. One that skips: leaves out the fewest of 33 rows that follow each other, so that the others are in order;
  /// their increments count in the row after. One that continues: moves such a row, and all after it, behind the row
  /// before, by the last spacing. Fails as `take` does.
  [[nodiscard]] Result<void> push(const ForeignRow& row);
  [[nodiscard]] Result<void> finish();
  /// What was done, for the record.
  void note(Notes& notes) const;
  [[nodiscard]] std::size_t left_out() const { return left_out_; }

 private:
  struct Held {
    Duration time{};
    std::optional<Duration> utc{};
    std::vector<double> numbers{};
  };
  [[nodiscard]] bool follows(Duration time, Duration before) const {
    return is_grouped_ ? time >= before : time > before;
  }
  [[nodiscard]] bool is_front_good() const;
  [[nodiscard]] Result<void> pop();
  [[nodiscard]] Result<void> hand_on(const ForeignRow& row);
  void leave_out(const ForeignRow& row);

  const ImportMap& map_;
  TakeRow take_;
  bool is_grouped_;
  std::size_t first_sum_{}, end_of_sums_{};  ///< the columns that are increments
  std::deque<Held> held_{};
  std::vector<double> carried_{}, added_{};  ///< increments of rows that were left out
  bool carries_ = false;
  std::optional<Duration> last_{};  ///< that was handed on
  Duration step_{};                 ///< the last that was positive
  Duration moved_{};                ///< rows that follow a clock that was set back
  std::size_t left_out_{}, set_back_{};
  Duration first_back_{};
};

}  // namespace gyrotherm::exchange
