// SPDX-License-Identifier: Apache-2.0
#include "sequencer/interlocks/noise.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace gyrotherm::interlocks {
namespace {

constexpr double kWeight = 1.0 / 300;  ///< weight of one reading
constexpr double kTwoSteps = 1.5;      ///< steps, less rounding
constexpr double kMostShare = 0.9;     ///< largest share that is used

}  // namespace

void Noise::add(double value, bool at_rest) {
  const double change = last_ ? value - *last_ : 0;
  const bool is_first = !last_;
  last_ = value;
  if (is_first) return;
  if (change == 0) {
    ++identical_;
    identical_at_rest_ += at_rest ? 1 : 0;
    return;
  }
  // Readings that were identical count once they have ended: a frozen channel does not unlearn its noise.
  share_ *= std::pow(1 - kWeight, std::exchange(identical_at_rest_, 0));
  const bool is_noise = last_change_ * change < 0 && std::abs(change) > kTwoSteps * step_;
  if (at_rest) share_ += kWeight * ((is_noise ? 1 : 0) - share_);
  step_ = std::min(step_, std::abs(change));
  last_change_ = change;
  identical_ = 0;
}

double Noise::improbability() const { return -identical_ * std::log1p(-std::min(share_, kMostShare)); }

}  // namespace gyrotherm::interlocks
