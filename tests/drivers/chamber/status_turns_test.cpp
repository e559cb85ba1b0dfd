// SPDX-License-Identifier: Apache-2.0
/// Tests of the scheduling of status reads.
#include "drivers/chamber/status_turns.hpp"

#include <gtest/gtest.h>

namespace gyrotherm::drivers {
namespace {

using std::chrono_literals::operator""ms;

std::vector<ReadSpan> pieces(int count) {
  std::vector<ReadSpan> all;
  for (int i = 0; i < count; ++i)
    all.push_back({ReadFunction::holding_registers, static_cast<std::uint16_t>(10 * i), 1});
  return all;
}

/// Simulates a reading of the chamber after `spent`, with exchanges of that duration. Returns the number of pieces
/// read.
int reading(StatusTurns& turns, Duration spent, Duration exchange) {
  turns.begin_reading();
  int asked = 0;
  for (; turns.next(spent, exchange) != nullptr; spent += exchange, ++asked) turns.store({0});
  return asked;
}

TEST(StatusTurns, ReadAllPiecesOnFastLine) {
  StatusTurns turns(pieces(6), 3);
  for (int round = 0; round < 3; ++round) {
    EXPECT_EQ(reading(turns, 10ms, 5ms), 6);
    EXPECT_TRUE(turns.is_complete());
    static_cast<void>(turns.take_snapshot());
    EXPECT_EQ(reading(turns, 10ms, 5ms), 0);
    EXPECT_EQ(reading(turns, 10ms, 5ms), 0);
  }
}

TEST(StatusTurns, ReserveTimeForSetPointOnSlowLine) {
  StatusTurns turns(pieces(6), 3);
  EXPECT_EQ(reading(turns, 300ms, 100ms), 4)
      << "300 ms for air, set point and unit, 400 for these, 200 for a set point";
  EXPECT_FALSE(turns.is_complete());
  EXPECT_EQ(reading(turns, 300ms, 100ms), 2);
  EXPECT_TRUE(turns.is_complete());
}

TEST(StatusTurns, ReadPieceInEveryFifthReadingOnSlowLine) {
  StatusTurns turns(pieces(2), 1);
  int asked = 0;
  for (int i = 0; i < 20; ++i) asked += reading(turns, 900ms, 300ms);
  EXPECT_EQ(asked, 2 + 0) << "then the round is complete and waits to be taken";
  static_cast<void>(turns.take_snapshot());
  for (int i = 0; i < 5; ++i) asked += reading(turns, 900ms, 300ms);
  EXPECT_EQ(asked, 3);
}

TEST(StatusTurns, RetryLostPiece) {
  StatusTurns turns(pieces(2), 1);
  turns.begin_reading();
  EXPECT_EQ(turns.next(0ms, 1ms)->first, 0);
  turns.store({1});
  // The piece is not answered.
  EXPECT_EQ(turns.next(0ms, 1ms)->first, 10);
  turns.begin_reading();
  EXPECT_EQ(turns.next(0ms, 1ms)->first, 10);
}

TEST(StatusTurns, RemoveMissingPiece) {
  StatusTurns turns(pieces(3), 1);
  turns.begin_reading();
  static_cast<void>(turns.next(0ms, 1ms));
  EXPECT_TRUE(turns.note_refused());
  EXPECT_EQ(turns.next(0ms, 1ms)->first, 10);
  turns.store({1}), turns.store({1});
  EXPECT_TRUE(turns.is_complete());
  static_cast<void>(turns.take_snapshot());
  EXPECT_EQ(reading(turns, 0ms, 1ms), 2);
}

TEST(StatusTurns, KeepPieceThatWasReadBefore) {
  StatusTurns turns(pieces(2), 1);
  EXPECT_EQ(reading(turns, 0ms, 1ms), 2);
  static_cast<void>(turns.take_snapshot());
  turns.begin_reading();
  EXPECT_EQ(turns.next(0ms, 1ms)->first, 0);
  EXPECT_FALSE(turns.note_refused()) << "an exception now does not mean that there is no such register";
  EXPECT_EQ(turns.pieces(), 2);
  turns.begin_reading();
  EXPECT_EQ(turns.next(0ms, 1ms)->first, 0);
}

TEST(StatusTurns, RetryLatePieceInEveryFifthReading) {
  StatusTurns turns(pieces(2), 1);
  int asked = 0;
  for (int i = 0; i < 20; ++i) {
    turns.begin_reading();
    if (turns.next(10ms, 5ms) == nullptr) continue;
    turns.note_lost(1500ms);
    ++asked;
  }
  EXPECT_EQ(asked, 4);
  for (int i = 0; i < 5; ++i) asked += reading(turns, 10ms, 5ms);
  EXPECT_EQ(asked, 4 + 2) << "it came, and the next one is asked for at once";
}

TEST(StatusTurns, DiscardWordsAtNewRound) {
  StatusTurns turns(pieces(6), 1);
  EXPECT_EQ(reading(turns, 400ms, 100ms), 3);
  turns.begin_new_round();
  turns.begin_reading();
  EXPECT_EQ(turns.next(0ms, 100ms)->first, 0);
}

TEST(StatusTurns, ReadAllPiecesInOneFullRound) {
  StatusTurns turns(pieces(6), 1);
  turns.schedule_full_round();
  EXPECT_EQ(reading(turns, 400ms, 200ms), 6);
  static_cast<void>(turns.take_snapshot());
  EXPECT_LT(reading(turns, 400ms, 200ms), 6);
}

TEST(StatusTurns, AreOverdueAfterAMinute) {
  StatusTurns turns(pieces(1), 3);
  for (int i = 0; i < 60 + 3; ++i) {
    turns.begin_reading();
    EXPECT_FALSE(turns.is_overdue()) << i;
  }
  turns.begin_reading();
  EXPECT_TRUE(turns.is_overdue());
  StatusTurns none({}, 3);
  for (int i = 0; i < 100; ++i) none.begin_reading();
  EXPECT_FALSE(none.is_overdue()) << "there is nothing to ask for";
}

}  // namespace
}  // namespace gyrotherm::drivers
