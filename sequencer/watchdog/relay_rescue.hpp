// SPDX-License-Identifier: Apache-2.0
/// Opens the relay of [safe.also] when the chamber was not made safe in time. The relay is never closed here: only a
/// person closes it.
#pragma once

#include <optional>
#include <string>

#include "core/clock.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"
#include "drivers/supply/safety_relay.hpp"
#include "sequencer/watchdog/safe_attempt.hpp"

namespace gyrotherm::watchdog {

enum class RelayDue {
  never,    ///< the chamber is safe so far
  in_time,  ///< once the time has passed
  now,      ///< the chamber cannot be made safe
};
/// Returns whether the result of an attempt requires the relay.
[[nodiscard]] RelayDue is_relay_due(const RescueResult& result);

/// Opens the relay and reads it back. Blocks for as long as the line takes.
[[nodiscard]] Result<void> open_relay(const drivers::RelaySettings& settings);
/// Describes the relay after an attempt to open it.
[[nodiscard]] std::string describe_relay(const Result<void>& opened);

class RelayRescue {
 public:
  /// Starts the waiting time. advance(RelayDue::never) restarts it. Without settings, the relay is never due.
  explicit RelayRescue(std::optional<drivers::RelaySettings> settings) : settings_(std::move(settings)) {}

  /// Returns the time until the relay may be due. Returns the largest duration if the relay is open or overdue, or if
  /// there is none.
  [[nodiscard]] Duration left() const;
  /// Opens the relay if it is due, in a separate process, and reads it back. Returns a description if the state has
  /// changed: the relay is open, or the reason why it is not. A failed attempt is repeated by the next call.
  [[nodiscard]] std::optional<std::string> advance(RelayDue due);
  [[nodiscard]] bool is_open() const { return is_open_; }

 private:
  std::optional<drivers::RelaySettings> settings_;
  SteadyClock clock_;
  /// Start, or the last time at which the relay was not due.
  Duration began_{};
  bool is_open_ = false;
  std::string last_;
};

}  // namespace gyrotherm::watchdog
