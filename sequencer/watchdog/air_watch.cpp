// SPDX-License-Identifier: Apache-2.0
#include "sequencer/watchdog/air_watch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/clock.hpp"

namespace gyrotherm::watchdog {
namespace {

/// Distance in K that counts as moving away. It exceeds the overshoot of a chamber that changes direction.
constexpr double kAwayDistanceK = 3;
/// Distance in K that counts as an approach. It exceeds a sensor's noise and is less than the slowest chamber moves in
/// a quarter of an hour.
constexpr double kApproachDistanceK = 1;
/// Range of ambient temperatures.
constexpr double kColdestRoomC = 10, kWarmestRoomC = 35;
constexpr Duration kLongestPause = std::chrono::seconds(30), kSparseInterval = std::chrono::seconds(5);
/// Time in the band after which the air has settled. Air that only passes the set point leaves the band sooner.
constexpr Duration kSettledTime = std::chrono::seconds(60);
/// Drift in K away from the set point, in a minute, that ambient temperature alone does not cause once the air has been
/// watched. A heater or a valve that remains on causes it.
constexpr double kFastDriftK = 1.2;
constexpr Duration kDriftTime = std::chrono::minutes(1);
constexpr Duration kStationaryFor = std::chrono::minutes(15);
constexpr int kStationaryFactor = 3;

double median(double a, double b, double c) { return std::max(std::min(a, b), std::min(std::max(a, b), c)); }

}  // namespace

void AirWatch::begin(AirSource source) {
  *this = AirWatch(set_point_, observe_);
  source_ = source;
}

/// Returns the distance from the set point. If nothing conditions the air, returns the distance from the range that
/// includes the set point and ambient temperatures.
double AirWatch::distance(double air_c) const {
  const double at = set_point_.value;
  if (source_ == AirSource::controller) return std::abs(air_c - at);
  const double lowest = std::min(at, kColdestRoomC), highest = std::max(at, kWarmestRoomC);
  return std::max({lowest - air_c, air_c - highest, 0.0});
}

/// Returns true if nothing should condition the air, and it nevertheless moves quickly away from the set point.
bool AirWatch::drifts_off_quickly(double air_c) const {
  if (source_ == AirSource::controller || last_minute_.empty()) return false;
  const double now = std::abs(air_c - set_point_.value);
  return now > kSafeBand.value && now - std::abs(last_minute_.front().second - set_point_.value) > kFastDriftK;
}

AirVerdict AirWatch::judge(double air_c) const {
  const double now = distance(air_c);
  if (now > std::max(nearest_k_, kSafeBand.value) + kAwayDistanceK) return AirVerdict::moves_away;
  if (observe_ <= Duration{}) return AirVerdict::shown;
  if (watched_ < observe_) return AirVerdict::watching;
  const bool is_staying = near_since_ && watched_ - *near_since_ >= std::min(observe_, kSettledTime);
  const bool is_approaching = farthest_k_ - now >= kApproachDistanceK && now <= nearest_k_ + kApproachDistanceK;
  const bool behaves = is_staying || is_approaching || source_ == AirSource::seen_off;
  if (behaves && !drifts_off_quickly(air_c)) return AirVerdict::shown;
  return watched_ >= std::max(observe_ * kStationaryFactor, kStationaryFor) ? AirVerdict::does_not_move
                                                                            : AirVerdict::watching;
}

AirVerdict AirWatch::add_reading(Celsius air, Duration at) {
  // Readings that are far apart are used without a median.
  const bool is_sparse = last_at_ && at - *last_at_ > kSparseInterval;
  const double oldest = is_sparse ? air.value : before_c_.value_or(air.value);
  const double middle = is_sparse ? air.value : last_c_.value_or(air.value);
  now_c_ = median(oldest, middle, air.value);
  before_c_ = middle;
  last_c_ = air.value;
  const double k = distance(now_c_);
  if (!last_at_) {
    first_c_ = now_c_;
    nearest_k_ = farthest_k_ = k;
  } else {
    watched_ += std::min(at - *last_at_, kLongestPause);
  }
  last_at_ = at;
  last_minute_.emplace_back(watched_, now_c_);
  while (last_minute_.front().first + kDriftTime < watched_) last_minute_.pop_front();
  if (k > kSafeBand.value)
    near_since_.reset();
  else if (!near_since_)
    near_since_ = watched_;
  nearest_k_ = std::min(nearest_k_, k);
  farthest_k_ = std::max(farthest_k_, k);
  return verdict_ = judge(now_c_);
}

std::string AirWatch::describe() const {
  if (!last_at_) return "the air has not been read";
  if (observe_ <= Duration{}) return fmt::format("air {:.2f} °C, not watched", now_c_);
  const auto seen = watched_ < kSecond
                        ? fmt::format("air {:.2f} °C", now_c_)
                        : fmt::format("air {:.2f} °C, {:.2f} °C {} before", now_c_, first_c_,
                                      format_duration(std::chrono::floor<std::chrono::seconds>(watched_)));
  switch (verdict_) {
    case AirVerdict::moves_away: return fmt::format("{}: moves AWAY from {:g} °C", seen, set_point_.value);
    case AirVerdict::does_not_move: return fmt::format("{}: does NOT move towards {:g} °C", seen, set_point_.value);
    case AirVerdict::watching: return seen + ": being watched";
    case AirVerdict::shown: break;
  }
  const bool is_near = std::abs(now_c_ - set_point_.value) <= kSafeBand.value;
  if (is_near) return fmt::format("{}: near {:g} °C", seen, set_point_.value);
  if (source_ != AirSource::controller) return seen + ": drifts as in a switched-off chamber";
  return fmt::format("{}: moves towards {:g} °C", seen, set_point_.value);
}

std::string AirWatch::describe_past() const {
  const bool moves = verdict_ == AirVerdict::moves_away;
  if (!moves && verdict_ != AirVerdict::does_not_move) return {};
  return fmt::format("{} {:g} °C, from {:.2f} °C to {:.2f} °C within {}",
                     moves ? "moved AWAY from" : "did NOT move towards", set_point_.value, first_c_, now_c_,
                     format_duration(std::chrono::floor<std::chrono::seconds>(watched_)));
}

}  // namespace gyrotherm::watchdog
