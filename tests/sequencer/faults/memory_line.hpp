// SPDX-License-Identifier: Apache-2.0
/// A line in memory that carries bytes, and its faults. The simulator's sessions answer at its other end.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <random>
#include <span>
#include <vector>

#include "drivers/wires.hpp"
#include "tests/sequencer/faults/line_clock.hpp"

namespace gyrotherm::faults {

using Bytes = std::vector<std::byte>;

/// Faults of a line; none by default. A share is the probability for one answer.
struct LineTrouble {
  /// The line is unplugged, or refuses the connection.
  bool gone{};
  bool silent{};  ///< nothing arrives
  /// Requests are carried out, but their answers are lost.
  bool answers_lost{};
  /// Share of lost requests and answers.
  double lost{};
  double garbled{}, cut{}, doubled{};
  Duration late{};  ///< delay of answers
};

/// The other end of a line, which outlives the programs that open it.
class LineEnd {
 public:
  /// Receives the bytes that were sent, and appends the answer.
  using Answer = std::function<void(std::span<const std::byte> sent, Bytes& answer)>;
  /// Damages an answer in a way that its receiver can detect.
  using Garble = std::function<void(Bytes& answer, std::mt19937_64& random)>;

  LineEnd(const Clock& rig, std::uint64_t seed, Answer answer, Garble garble)
      : line_clock_(rig), random_(seed), answer_(std::move(answer)), garble_(std::move(garble)) {}
  LineEnd(const LineEnd&) = delete;

  LineTrouble trouble;

  [[nodiscard]] const LineClock& line_clock() const { return line_clock_; }
  [[nodiscard]] LineClock& line_clock() { return line_clock_; }
  [[nodiscard]] std::mt19937_64& random() { return random_; }
  [[nodiscard]] bool draw_event(double share) {
    return share > 0 && std::uniform_real_distribution<>(0, 1)(random_) < share;
  }

  /// Part of an exchange that a lossy line loses.
  enum class Loss { none, of_request, of_answer };
  [[nodiscard]] Loss loss() {
    if (!draw_event(trouble.lost)) return Loss::none;
    if (random_() % 2 != 0) return Loss::of_answer;
    ++lost_requests_;
    return Loss::of_request;
  }
  [[nodiscard]] int lost_requests() const { return lost_requests_; }

  void open() { coming_.clear(), next_ = 0, open_ = true; }
  void close() { open_ = false; }
  /// Delivers bytes that the instrument sends by itself. They are lost if the line is not open.
  void arrive(std::span<const std::byte> bytes) { arrive(Bytes(bytes.begin(), bytes.end()), {}); }
  [[nodiscard]] Result<std::size_t> read(std::span<std::byte> buffer, Duration within);
  [[nodiscard]] Result<void> write(std::span<const std::byte> bytes);

 private:
  struct Piece {
    Duration at{};
    Bytes bytes;
  };
  void arrive(Bytes bytes, Duration after);
  [[nodiscard]] std::size_t take(std::span<std::byte> room);

  LineClock line_clock_;
  std::mt19937_64 random_;
  Answer answer_;
  Garble garble_;
  /// Pieces in order of arrival.
  std::deque<Piece> coming_;
  /// Next byte to be read from the first piece.
  std::size_t next_ = 0;
  bool open_ = false;
  Bytes answered_;
  int lost_requests_ = 0;
};

/// A program's end of a line. Opening it discards bytes that were on their way.
class MemoryStream final : public drivers::ByteStream {
 public:
  explicit MemoryStream(LineEnd& end) : end_(end) { end_.open(); }
  ~MemoryStream() override { end_.close(); }
  MemoryStream(const MemoryStream&) = delete;
  MemoryStream& operator=(const MemoryStream&) = delete;
  [[nodiscard]] Result<std::size_t> read(std::span<std::byte> buffer, Duration within) override {
    return end_.read(buffer, within);
  }
  [[nodiscard]] Result<void> write(std::span<const std::byte> bytes, Duration) override { return end_.write(bytes); }

 private:
  LineEnd& end_;
};

/// Sets a top bit. Text never has one, and parity detects it.
void garble_text(Bytes& answer, std::mt19937_64& random);
/// Garbles up to 16 neighbouring bits, which every 16-bit check detects. Never garbles the last byte before the check
/// together with the first byte of the check: these are not neighbours if the check is sent low byte first.
void garble_burst(Bytes& answer, std::mt19937_64& random);

}  // namespace gyrotherm::faults
