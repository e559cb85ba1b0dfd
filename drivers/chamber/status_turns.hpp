// SPDX-License-Identifier: Apache-2.0
/// Scheduling of a chamber's status reads. On a slow line, status and alarms may need more exchanges than fit into one
/// second, so they are read in pieces. Pure functions.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/quantity.hpp"
#include "drivers/chamber/register_item.hpp"

namespace gyrotherm::drivers {

/// Adjacent registers that are read by one exchange.
struct ReadSpan {
  ReadFunction function{};
  std::uint16_t first{};
  std::uint16_t count{};
  bool operator==(const ReadSpan&) const = default;
};

[[nodiscard]] ReadFunction read_function(const RegisterItem& item);
/// Returns the registers of one item.
[[nodiscard]] ReadSpan read_span(const RegisterItem& item);
/// Returns spans that cover `items`, sorted by function and address. Each item is within one span. If `holes`, spans
/// are merged together with the registers between them, up to a length of `at_most`.
[[nodiscard]] std::vector<ReadSpan> plan_reads(std::span<const RegisterItem* const> items, bool holes,
                                               std::uint16_t at_most);

/// Words read from a unit.
class Snapshot {
 public:
  void clear() { found_.clear(); }
  void add(const ReadSpan& span, std::vector<std::uint16_t> words) { found_.push_back({span, std::move(words)}); }
  /// Returns the words of an item, or an empty span if it was not read.
  [[nodiscard]] std::span<const std::uint16_t> find_words(const RegisterItem& item) const;

 private:
  struct Found {
    ReadSpan span;
    std::vector<std::uint16_t> words;
  };
  std::vector<Found> found_;
};

/// Schedules the reads of the status in rounds. Each round reads every piece once.
class StatusTurns {
 public:
  /// The next round begins `every` readings after the start of the previous one, or at its end if that is later. If
  /// `every` is 0, only schedule_full_round() begins a round.
  StatusTurns(std::vector<ReadSpan> pieces, int every) : pieces_(std::move(pieces)), every_(every) {}

  /// Discards the words read so far and begins a new round with the next reading.
  void begin_new_round();
  /// Begins a new round as begin_new_round() does, but the next reading reads all pieces, regardless of time. Not for
  /// use within a tick.
  void schedule_full_round();

  /// Begins a reading of the chamber.
  void begin_reading();
  /// Returns the piece to read now, or null if this reading has no time for another piece. `spent` is the time used in
  /// this reading, and `exchange` the duration of one exchange. Time is reserved for sending and reading back a set
  /// point in the same second. Regardless of time, every fifth reading reads at least one piece.
  [[nodiscard]] const ReadSpan* next(Duration spent, Duration exchange);
  /// Stores the words of the piece that next() returned.
  void store(std::vector<std::uint16_t> words);
  /// Leaves out the piece that next() returned in this round. Its items are then unknown.
  void skip();
  /// Notes that the unit refused the piece as non-existent. Unless the piece was read successfully before, removes it
  /// and returns true; next() then returns the following piece.
  bool note_refused();
  /// Notes that the piece could not be read. `spent` is the time used in this reading. A piece that made the reading
  /// late is retried only at every fifth reading, so the other readings remain on time.
  void note_lost(Duration spent);

  /// Returns whether the round is complete. take_snapshot() then returns its snapshot once.
  [[nodiscard]] bool is_complete() const { return is_in_progress_ && at_ == pieces_.size(); }
  [[nodiscard]] Snapshot take_snapshot();
  /// Returns the words read so far in this round.
  [[nodiscard]] const Snapshot& snapshot() const { return so_far_; }

  /// Returns whether no round was completed in the last 60 + `every` readings.
  [[nodiscard]] bool is_overdue() const;
  [[nodiscard]] int pieces() const { return static_cast<int>(pieces_.size()); }

 private:
  std::vector<ReadSpan> pieces_;
  /// True for each piece that was read successfully before.
  std::vector<bool> was_read_ = std::vector<bool>(pieces_.size());
  int every_;
  std::size_t at_ = 0;
  /// Words read in the current round.
  Snapshot so_far_;
  /// Number of readings until the next round begins, since a round was completed, and since a piece was read.
  int until_round_ = 0;
  int since_round_ = 0;
  int since_piece_ = 0;
  bool is_in_progress_ = false;  ///< a round is in progress
  /// The next reading (`reads_all_next_`) or the current one (`unhurried_`) reads all pieces, regardless of time.
  bool reads_all_next_ = false;
  bool unhurried_ = false;
  /// The next piece made a reading late.
  bool is_late_ = false;
};

}  // namespace gyrotherm::drivers
