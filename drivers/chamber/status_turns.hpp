// SPDX-License-Identifier: Apache-2.0
/// Which pieces of a chamber's status one reading asks for. What a chamber says of itself beside its air and set point
/// may take many exchanges; on a slow line they do not fit into a second, and are asked for in turn. Pure.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/quantity.hpp"
#include "drivers/chamber/register_item.hpp"

namespace gyrotherm::drivers {

/// Registers that are read by one exchange.
struct ReadSpan {
  ReadFunction function{};
  std::uint16_t first{};
  std::uint16_t count{};
  bool operator==(const ReadSpan&) const = default;
};

[[nodiscard]] ReadFunction read_function(const RegisterItem& item);
/// The span of one item.
[[nodiscard]] ReadSpan span_of(const RegisterItem& item);
/// Spans of `items`, each item's registers in one; in order of function and address. With `holes`, spans are merged,
/// with what lies between them, as long as they are no longer than `at_most`.
[[nodiscard]] std::vector<ReadSpan> plan_reads(std::span<const RegisterItem* const> items, bool holes,
                                               std::uint16_t at_most);

/// Words as they were found.
class Snapshot {
 public:
  void clear() { found_.clear(); }
  void add(const ReadSpan& span, std::vector<std::uint16_t> words) { found_.push_back({span, std::move(words)}); }
  /// The words of an item, or none if they were not read.
  [[nodiscard]] std::span<const std::uint16_t> words_of(const RegisterItem& item) const;

 private:
  struct Found {
    ReadSpan span;
    std::vector<std::uint16_t> words;
  };
  std::vector<Found> found_;
};

class StatusTurns {
 public:
  /// A round asks for all pieces; the next one begins `every` readings after it began, or when it is over if that is
  /// later. 0: no round begins by itself.
  StatusTurns(std::vector<ReadSpan> pieces, int every) : pieces_(std::move(pieces)), every_(every) {}

  /// What was found is forgotten, and a new round begins with the next reading.
  void begin_anew();
  /// … which asks for all of it, however long that takes: not for use within a tick.
  void begin_anew_at_once();

  /// Once at the start of each reading.
  void begin_reading();
  /// The piece to be asked for now; null: none in this reading. `spent`: on this reading so far; `exchange`: how long
  /// one takes on this line. Room is left for a set point that is sent and read back in the same second; every fifth
  /// reading asks for one piece even so.
  [[nodiscard]] const ReadSpan* next(Duration spent, Duration exchange);
  /// The words of the piece that next() gave.
  void found(std::vector<std::uint16_t> words);
  /// The unit says that it does not have that piece: it is never asked for again, unless it was there before. Returns
  /// whether the next one can be asked for.
  bool refused();
  /// That piece did not come, for now; `spent`: on this reading. One that made a reading late is asked for by every
  /// fifth alone until it comes: the others are to be in time.
  void lost(Duration spent);

  /// Whether the round is complete now; then its snapshot is handed out, once.
  [[nodiscard]] bool is_complete() const { return under_way_ && at_ == pieces_.size(); }
  [[nodiscard]] Snapshot take();

  /// For more than 60 readings after one was due no round was completed.
  [[nodiscard]] bool is_overdue() const;
  [[nodiscard]] int pieces() const { return static_cast<int>(pieces_.size()); }

 private:
  std::vector<ReadSpan> pieces_;
  std::vector<bool> had_ = std::vector<bool>(pieces_.size());  ///< of each piece: whether it was ever found
  int every_;
  std::size_t at_ = 0;      ///< the piece that is next
  Snapshot so_far_;         ///< of the round under way
  int until_round_ = 0;     ///< readings until the next one begins
  int since_round_ = 0;     ///< readings since one was completed
  int since_piece_ = 0;     ///< readings since a piece was asked for
  bool under_way_ = false;  ///< a round is
  bool at_once_ = false;    ///< the next reading asks for all
  bool unhurried_ = false;  ///< the present one does
  bool delays_ = false;     ///< the piece that is next made a reading late
};

}  // namespace gyrotherm::drivers
