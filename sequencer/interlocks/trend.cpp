#include "sequencer/interlocks/trend.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gyrotherm {
namespace {

constexpr Kelvins kChange{0.001};

}  // namespace

void Trend::add(std::optional<Celsius> value) {
  newest_ = (newest_ + 1) % static_cast<int>(ring_.size());
  ring_[static_cast<std::size_t>(newest_)] = value ? value->value : std::numeric_limits<double>::quiet_NaN();
  filled_ = std::min(filled_ + 1, static_cast<int>(ring_.size()));
  if (!value) return;
  if (still_ && abs(*value - *still_) < kChange) {
    ++unchanged_;
  } else {
    still_ = value;
    unchanged_ = 1;
    others_then_.reset();
    others_moved_ = {};
  }
}

void Trend::forget() { *this = {}; }

std::optional<CelsiusPerMinute> Trend::rate() const {
  if (filled_ < static_cast<int>(ring_.size())) return std::nullopt;
  const auto size = static_cast<int>(ring_.size());
  const auto now = ring_[static_cast<std::size_t>(newest_)];
  const auto then = ring_[static_cast<std::size_t>((newest_ + 1) % size)];
  if (std::isnan(now) || std::isnan(then)) return std::nullopt;
  return CelsiusPerMinute{now - then};
}

void Trend::compare(std::optional<Celsius> others) {
  if (!others) return;
  if (!others_then_) others_then_ = others;
  others_moved_ = abs(*others - *others_then_);
}

}  // namespace gyrotherm
