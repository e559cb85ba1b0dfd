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

/// Returns the fault of opening the relay; empty if it reads open.
std::string open_relay(const drivers::RelaySettings& settings) {
  ChildWork work([&](const ChildWork::SendLine& send_line) {
    const auto relay = drivers::make_safety_relay(settings);
    const auto opened = drivers::switch_relay(*relay, drivers::RelayPosition::open,
                                              [](Duration time) { std::this_thread::sleep_for(time); });
    send_line(opened ? kOpened : text(opened.error()));
  });
  const auto line = work.next(kRelayWithin);
  if (!line) return "it did not answer in time";
  return *line == kOpened ? "" : *line;
}

}  // namespace

RelayDue is_relay_due(const RescueResult& result) {
  if (result.in_use || result.reached == SafeStage::all) return RelayDue::never;
  if (result.is_ineffective) return RelayDue::now;
  return result.has_shown_commands ? RelayDue::never : RelayDue::in_time;
}

Duration RelayRescue::left() const {
  if (!settings_ || is_open_) return Duration::max();
  const auto left = settings_->after - clock_.now().since_start;
  return left > Duration::zero() ? left : Duration::max();
}

std::optional<std::string> RelayRescue::advance(RelayDue due) {
  if (!settings_ || is_open_ || due == RelayDue::never) return std::nullopt;
  if (due == RelayDue::in_time && clock_.now().since_start < settings_->after) return std::nullopt;
  const auto fault = open_relay(*settings_);
  is_open_ = fault.empty();
  auto words = is_open_ ? fmt::format(
                              "the relay of [safe.also] was opened at {} and reads open; a person must close it "
                              "with \"gyrotherm prove RIG --close-relay\"",
                              civil_time(clock_.now().utc))
                        : fmt::format("the relay of [safe.also] is NOT open: {}", fault);
  if (words == last_) return std::nullopt;
  return last_ = std::move(words);
}

}  // namespace gyrotherm::watchdog
