// SPDX-License-Identifier: Apache-2.0
#include "drivers/chamber/status_turns.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

namespace gyrotherm::drivers {
namespace {

using std::chrono::milliseconds;

/// Maximum duration of a reading, less than the timeout of InstrumentIo.
constexpr Duration kMaxReadingTime = milliseconds(850);
constexpr Duration kMaxTickTime = milliseconds(950);
constexpr int kExchangesOfASetPoint = 2;
constexpr int kReadingsWithoutAPiece = 5;
constexpr int kReadingsWithoutARound = 60;

}  // namespace

ReadFunction read_function(const RegisterItem& item) {
  return item.read_function.value_or(ReadFunction::holding_registers);
}

ReadSpan read_span(const RegisterItem& item) {
  return {read_function(item), item.address, std::max(word_count(item), item.read_count)};
}

std::vector<ReadSpan> plan_reads(std::span<const RegisterItem* const> items, bool holes, std::uint16_t at_most) {
  std::vector<ReadSpan> wanted;
  for (const auto* item : items) wanted.push_back(read_span(*item));
  std::ranges::sort(wanted, [](const auto& a, const auto& b) {
    return std::tuple(a.function, a.first, -a.count) < std::tuple(b.function, b.first, -b.count);
  });
  std::vector<ReadSpan> plan;
  for (const auto& span : wanted) {
    const int end = span.first + span.count;
    const bool is_same_table = !plan.empty() && plan.back().function == span.function;
    if (is_same_table && end <= plan.back().first + plan.back().count) continue;
    if (is_same_table && holes && end - plan.back().first <= at_most)
      plan.back().count = static_cast<std::uint16_t>(end - plan.back().first);
    else
      plan.push_back(span);
  }
  return plan;
}

std::span<const std::uint16_t> Snapshot::find_words(const RegisterItem& item) const {
  const auto function = read_function(item);
  const int count = word_count(item);
  for (const auto& [span, words] : found_)
    if (span.function == function && item.address >= span.first && item.address + count <= span.first + span.count)
      return std::span(words).subspan(static_cast<std::size_t>(item.address - span.first),
                                      static_cast<std::size_t>(count));
  return {};
}

void StatusTurns::begin_new_round() {
  so_far_.clear();
  at_ = 0;
  is_in_progress_ = false;
  is_late_ = false;
  until_round_ = 0;
}

void StatusTurns::schedule_full_round() {
  begin_new_round();
  reads_all_next_ = true;
}

void StatusTurns::begin_reading() {
  unhurried_ = std::exchange(reads_all_next_, false);
  const bool has_work = (every_ > 0 || unhurried_) && !pieces_.empty();
  if (has_work && !is_in_progress_ && until_round_ <= 0) {
    is_in_progress_ = true;
    until_round_ = every_;
  }
  --until_round_;
  ++since_piece_;
  since_round_ = has_work ? since_round_ + 1 : 0;
}

const ReadSpan* StatusTurns::next(Duration spent, Duration exchange) {
  if (!is_in_progress_ || at_ == pieces_.size()) return nullptr;
  const bool is_due = since_piece_ >= kReadingsWithoutAPiece;
  const bool has_time = !is_late_ && spent + exchange <= kMaxReadingTime &&
                        spent + exchange + kExchangesOfASetPoint * exchange <= kMaxTickTime;
  if (!unhurried_ && !is_due && !has_time) return nullptr;
  since_piece_ = 0;
  return &pieces_[at_];
}

void StatusTurns::store(std::vector<std::uint16_t> words) {
  was_read_[at_] = true;
  is_late_ = false;
  so_far_.add(pieces_[at_++], std::move(words));
}

void StatusTurns::skip() {
  is_late_ = false;
  ++at_;
}

bool StatusTurns::note_refused() {
  is_late_ = false;
  if (was_read_[at_]) return false;
  pieces_.erase(pieces_.begin() + static_cast<std::ptrdiff_t>(at_));
  was_read_.erase(was_read_.begin() + static_cast<std::ptrdiff_t>(at_));
  return true;
}

void StatusTurns::note_lost(Duration spent) { is_late_ = spent > kMaxReadingTime; }

Snapshot StatusTurns::take_snapshot() {
  at_ = 0;
  since_round_ = 0;
  is_in_progress_ = false;
  return std::exchange(so_far_, {});
}

bool StatusTurns::is_overdue() const { return since_round_ > kReadingsWithoutARound + every_; }

}  // namespace gyrotherm::drivers
