// SPDX-License-Identifier: Apache-2.0
/// Scheduling of a chamber's status reads. Status and alarms may take more exchanges than fit into one second on a slow
/// line, so they are read in turns. Pure functions.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/quantity.hpp"
#include "drivers/chamber/register_item.hpp"

namespace gyrotherm::drivers {

/// Adjacent registers that one exchange reads.
struct ReadSpan {
  ReadFunction function{};
  std::uint16_t first{};
  std::uint16_t count{};
  bool operator==(const ReadSpan&) const = default;
};

[[nodiscard]] ReadFunction read_function(const RegisterItem& item);
/// Returns the registers of one item.
[[nodiscard]] ReadSpan span_of(const RegisterItem& item);
/// Returns spans that cover `items`, each item within one span, sorted by function and address. With `holes`, spans are
/// merged, including the registers between them, up to a length of `at_most`.
[[nodiscard]] std::vector<ReadSpan> plan_reads(std::span<const RegisterItem* const> items, bool holes,
                                               std::uint16_t at_most);

/// Words read from a unit.
class Snapshot {
 public:
  void clear() { found_.clear(); }
  void add(const ReadSpan& span, std::vector<std::uint16_t> words) { found_.push_back({span, std::move(words)}); }
  /// Returns the words of an item, or an empty span if they were not read.
  [[nodiscard]] std::span<const std::uint16_t> words_of(const RegisterItem& item) const;

 private:
  struct Found {
    ReadSpan span;
    std::vector<std::uint16_t> words;
  };
  std::vector<Found> found_;
};

/// Rounds of status reads; each round reads every piece once.
class StatusTurns {
 public:
  /// Makes rounds over `pieces`. The next round begins `every` readings after the start of the previous one, or at its
  /// end if that is later. With 0 no round begins by itself.
  StatusTurns(std::vector<ReadSpan> pieces, int every) : pieces_(std::move(pieces)), every_(every) {}

  /// Discards the words read so far and begins a new round with the next reading.
  void begin_new_round();
  /// Does the same as begin_new_round(), but the next reading reads all pieces, regardless of time. Not for use
  /// within a tick.
  void schedule_full_round();

  /// Begins a reading of the chamber.
  void begin_reading();
  /// Returns the piece to read now, or null if no further piece is to be read in this reading. `spent` is the time used
  /// in this reading, and `exchange` the duration of one exchange. Time is reserved for sending and reading back a set
  /// point in the same second, except that every fifth reading reads one piece in any case.
  [[nodiscard]] const ReadSpan* next(Duration spent, Duration exchange);
  /// Stores the words of the piece that next() returned.
  void found(std::vector<std::uint16_t> words);
  /// Notes that the unit refused the piece as non-existent. The piece is not read again, unless it was read
  /// successfully before. Returns true if it was removed; next() then returns the following piece.
  bool refused();
  /// Notes that the piece could not be read. `spent` is the time used in this reading. If the piece delayed the
  /// reading, it is retried only at every fifth reading. The readings in between remain on time.
  void lost(Duration spent);

  /// Returns whether the round is complete. take() then returns its snapshot once.
  [[nodiscard]] bool is_complete() const { return under_way_ && at_ == pieces_.size(); }
  [[nodiscard]] Snapshot take();

  /// Returns whether the completion of a round is overdue by more than 60 readings.
  [[nodiscard]] bool is_overdue() const;
  [[nodiscard]] int pieces() const { return static_cast<int>(pieces_.size()); }

 private:
  std::vector<ReadSpan> pieces_;
  /// True for each piece that was read successfully before.
  std::vector<bool> had_ = std::vector<bool>(pieces_.size());
  int every_;
  std::size_t at_ = 0;
  /// Words read in the current round.
  Snapshot so_far_;
  /// Number of readings until the next round begins, since a round was completed, and since a piece was read.
  int until_round_ = 0;
  int since_round_ = 0;
  int since_piece_ = 0;
  bool under_way_ = false;  ///< a round is in progress
  /// The next reading (`at_once_`) or the current one (`unhurried_`) reads all pieces, regardless of time.
  bool at_once_ = false;
  bool unhurried_ = false;
  /// The next piece delayed a reading.
  bool delays_ = false;
};

}  // namespace gyrotherm::drivers
