// SPDX-License-Identifier: Apache-2.0
#include "sequencer/watchdog/relay_rescue.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <thread>

#include "sequencer/watchdog/child_work.hpp"

namespace gyrotherm::watchdog {
namespace {

constexpr Duration kRelayWithin = std::chrono::seconds(8);
constexpr const char* kOpened = "open";

/// Opens the relay in a separate process, which is ended if it takes too long.
Result<void> open_relay_in_time(const drivers::RelaySettings& settings) {
  ChildWork work([&](const ChildWork::SendLine& send_line) {
    const auto opened = open_relay(settings);
    send_line(opened ? kOpened : text(opened.error()));
  });
  const auto line = work.next(kRelayWithin);
  if (!line) return failure(FaultKind::timeout, "", "it did not answer in time");
  if (*line != kOpened) return failure(FaultKind::mismatch, "", *line);
  return {};
}

}  // namespace

Result<void> open_relay(const drivers::RelaySettings& settings) {
  const auto relay = drivers::make_safety_relay(settings);
  return drivers::switch_relay(*relay, drivers::RelayPosition::open,
                               [](Duration time) { std::this_thread::sleep_for(time); });
}

std::string describe_relay(const Result<void>& opened) {
  if (!opened) return fmt::format("the relay of [safe.also] is NOT open: {}", text(opened.error()));
  return fmt::format(
      "the relay of [safe.also] was opened at {} and read open; only \"gyrotherm prove RIG --close-relay\" closes it",
      civil_time(SteadyClock().now().utc));
}

RelayDue is_relay_due(const RescueResult& result) {
  if (result.in_use || result.reached == SafeStage::all) return RelayDue::never;
  if (result.is_ineffective) return RelayDue::now;
  return result.has_shown_commands ? RelayDue::never : RelayDue::in_time;
}

Duration RelayRescue::left() const {
  if (!settings_ || is_open_) return Duration::max();
  const auto left = settings_->after - (clock_.now().since_start - began_);
  return left > Duration::zero() ? left : Duration::max();
}

std::optional<std::string> RelayRescue::advance(RelayDue due) {
  if (due == RelayDue::never) began_ = clock_.now().since_start;
  if (!settings_ || is_open_ || due == RelayDue::never) return std::nullopt;
  if (due == RelayDue::in_time && clock_.now().since_start - began_ < settings_->after) return std::nullopt;
  const auto opened = open_relay_in_time(*settings_);
  is_open_ = opened.has_value();
  auto words = describe_relay(opened);
  if (words == last_) return std::nullopt;
  return last_ = std::move(words);
}

}  // namespace gyrotherm::watchdog
