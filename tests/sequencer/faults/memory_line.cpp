// SPDX-License-Identifier: Apache-2.0
#include "tests/sequencer/faults/memory_line.hpp"

#include <algorithm>

namespace gyrotherm::faults {

void LineEnd::arrive(Bytes bytes, Duration after) {
  if (!open_) return;
  const auto at = line_clock_.time() + after;
  auto place = coming_.end();
  while (place != coming_.begin() && std::prev(place)->at > at) --place;
  if (place == coming_.begin() && next_ > 0) ++place;  // the piece being read stays first
  coming_.insert(place, {at, std::move(bytes)});
}

/// Copies as many bytes of the first piece as fit into `room`.
std::size_t LineEnd::take(std::span<std::byte> room) {
  const auto& bytes = coming_.front().bytes;
  const auto size = std::min(room.size(), bytes.size() - next_);
  std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(next_), size, room.begin());
  next_ += size;
  if (next_ == bytes.size()) coming_.pop_front(), next_ = 0;
  return size;
}

Result<std::size_t> LineEnd::read(std::span<std::byte> buffer, Duration within) {
  if (trouble.gone) return failure(FaultKind::disconnected, "line", "the port was removed");
  const auto now = line_clock_.time();
  if (coming_.empty() || coming_.front().at > now + within) {
    line_clock_.pass(within);
    return failure(FaultKind::timeout, "line", "no data in 0.500 s");
  }
  if (coming_.front().at > now) line_clock_.pass(coming_.front().at - now);
  std::size_t size = 0;
  while (size < buffer.size() && !coming_.empty() && coming_.front().at <= line_clock_.time())
    size += take(buffer.subspan(size));
  return size;
}

Result<void> LineEnd::write(std::span<const std::byte> bytes) {
  if (trouble.gone) return failure(FaultKind::disconnected, "line", "the port was removed");
  const auto loss = this->loss();
  if (trouble.silent || loss == Loss::of_request) return {};
  answered_.clear();
  answer_(bytes, answered_);
  if (answered_.empty() || trouble.answers_lost || loss == Loss::of_answer) return {};
  if (draw_event(trouble.garbled)) garble_(answered_, random_);
  if (draw_event(trouble.cut)) answered_.resize(1 + random_() % answered_.size());
  arrive(answered_, trouble.late);
  if (draw_event(trouble.doubled)) arrive(answered_, trouble.late);
  return {};
}

void garble_text(Bytes& answer, std::mt19937_64& random) { answer[random() % answer.size()] |= std::byte{0x80}; }

void garble_burst(Bytes& answer, std::mt19937_64& random) {
  const auto at = random() % answer.size();
  answer[at] ^= static_cast<std::byte>(1 + random() % 255);
  if (at + 1 == answer.size()) return;
  const auto second = static_cast<std::byte>(random() % 256);
  const bool is_last_before_check = at + 3 == answer.size();
  if (!is_last_before_check) answer[at + 1] ^= second;
}

}  // namespace gyrotherm::faults
