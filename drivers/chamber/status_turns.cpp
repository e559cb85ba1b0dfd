#include "drivers/chamber/status_turns.hpp"

#include <utility>

namespace gyrotherm {
namespace {

using std::chrono::milliseconds;

constexpr Duration kReading = milliseconds(850);  ///< of a second, less than the patience of InstrumentIo
constexpr Duration kSecondsWork = milliseconds(950);
constexpr int kExchangesOfASetPoint = 2;
constexpr int kReadingsWithoutAPiece = 5;
constexpr int kReadingsWithoutARound = 60;

}  // namespace

void StatusTurns::begin_anew() {
  so_far_.clear();
  at_ = 0;
  under_way_ = false;
  until_round_ = 0;
}

void StatusTurns::begin_anew_at_once() {
  begin_anew();
  at_once_ = true;
}

void StatusTurns::begin_reading() {
  unhurried_ = std::exchange(at_once_, false);
  const bool asks = (every_ > 0 || unhurried_) && !pieces_.empty();
  if (asks && !under_way_ && until_round_ <= 0) {
    under_way_ = true;
    until_round_ = every_;
  }
  --until_round_;
  ++since_piece_;
  since_round_ = asks ? since_round_ + 1 : 0;
}

const ReadSpan* StatusTurns::next(Duration spent, Duration exchange) {
  if (!under_way_ || at_ == pieces_.size()) return nullptr;
  const bool is_due = since_piece_ >= kReadingsWithoutAPiece;
  const bool has_time =
      spent + exchange <= kReading && spent + exchange + kExchangesOfASetPoint * exchange <= kSecondsWork;
  if (!unhurried_ && !is_due && !has_time) return nullptr;
  since_piece_ = 0;
  return &pieces_[at_];
}

void StatusTurns::found(std::vector<std::uint16_t> words) {
  had_[at_] = true;
  so_far_.add(pieces_[at_++], std::move(words));
}

bool StatusTurns::refused() {
  if (had_[at_]) return false;
  pieces_.erase(pieces_.begin() + static_cast<std::ptrdiff_t>(at_));
  had_.erase(had_.begin() + static_cast<std::ptrdiff_t>(at_));
  return true;
}

Snapshot StatusTurns::take() {
  at_ = 0;
  since_round_ = 0;
  under_way_ = false;
  return std::exchange(so_far_, {});
}

bool StatusTurns::is_overdue() const { return since_round_ > kReadingsWithoutARound + every_; }

}  // namespace gyrotherm
