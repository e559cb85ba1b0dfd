// SPDX-License-Identifier: Apache-2.0
/// A line in memory that carries bytes, and what can be wrong with it. The simulator's sessions answer at its other
/// end.
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

/// By default nothing. A share is the probability for one answer.
struct LineTrouble {
  bool gone{};          ///< unplugged, or the connection refused
  bool silent{};        ///< what is sent does not arrive
  bool answers_lost{};  ///< what is sent is carried out, and the answer does not come
  double lost{};        ///< what is sent, or its answer
  double garbled{}, cut{}, doubled{};
  Duration late{};  ///< answers come so much later
};

/// The other end of a line, which outlives the programs that open it.
class LineEnd {
 public:
  /// Takes what was sent, appends the answer.
  using Answer = std::function<void(std::span<const std::byte> sent, Bytes& answer)>;
  /// Breaks an answer so that its receiver can see it.
  using Garble = std::function<void(Bytes& answer, std::mt19937_64& random)>;

  LineEnd(const Clock& rig, std::uint64_t seed, Answer answer, Garble garble)
      : line_clock_(rig), random_(seed), answer_(std::move(answer)), garble_(std::move(garble)) {}
  LineEnd(const LineEnd&) = delete;

  LineTrouble trouble;

  [[nodiscard]] const LineClock& line_clock() const { return line_clock_; }
  [[nodiscard]] LineClock& line_clock() { return line_clock_; }
  [[nodiscard]] std::mt19937_64& random() { return random_; }
  [[nodiscard]] bool happens(double share) {
    return share > 0 && std::uniform_real_distribution<>(0, 1)(random_) < share;
  }

  /// What becomes of one exchange on a line that loses some.
  enum class Loss { none, of_request, of_answer };
  [[nodiscard]] Loss loss() {
    if (!happens(trouble.lost)) return Loss::none;
    return random_() % 2 == 0 ? Loss::of_request : Loss::of_answer;
  }

  void open() { coming_.clear(), next_ = 0, open_ = true; }
  void close() { open_ = false; }
  /// What the instrument sends by itself; lost where nobody has the line open.
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
  std::deque<Piece> coming_;  ///< in order of time
  std::size_t next_ = 0;      ///< byte of the first piece
  bool open_ = false;
  Bytes answered_;
};

/// What a program has of a line. Opening it forgets what was on its way.
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

/// A top bit that no text has, and no parity lets pass.
void garble_text(Bytes& answer, std::mt19937_64& random);
/// Up to 16 neighbouring bits, which every check of 16 bits sees. Not the check's first byte along with the one before:
/// they are no neighbours where the check is sent low byte first.
void garble_burst(Bytes& answer, std::mt19937_64& random);

}  // namespace gyrotherm::faults
