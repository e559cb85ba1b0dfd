// SPDX-License-Identifier: Apache-2.0
/// Opens the relay of [safe.also] while the program of the run is alive, by the same rules as its guard. The relay is
/// never closed here: only a person closes it.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/quantity.hpp"
#include "core/result.hpp"
#include "drivers/supply/safety_relay.hpp"
#include "sequencer/watchdog/relay_rescue.hpp"

namespace gyrotherm::run {

class SafeRelay {
 public:
  /// Opens a relay and reads it back. Called in a thread of its own, which may outlive the SafeRelay.
  using Open = std::function<Result<void>(const drivers::RelaySettings&)>;

  /// Without settings, nothing is ever due.
  explicit SafeRelay(std::optional<drivers::RelaySettings> settings, Open open = watchdog::open_relay);

  /// Begins to open the relay if it is due at run time `at`. The time of [safe.also] begins with the first call, and
  /// again whenever the relay is not due. Repeats a failed attempt after ten seconds. Never waits for the relay.
  /// Returns a description if its state has changed.
  [[nodiscard]] std::optional<std::string> advance(watchdog::RelayDue due, Duration at);
  /// Returns the last description; empty if the relay was never due.
  [[nodiscard]] const std::string& words() const { return words_; }

 private:
  struct Work;

  /// Returns a description if an attempt has ended with another result than the previous one.
  [[nodiscard]] std::optional<std::string> take_result();

  std::optional<drivers::RelaySettings> settings_;
  Open open_;
  std::shared_ptr<Work> work_;
  std::optional<Duration> began_, tried_;
  bool is_open_ = false;
  std::string words_;
};

}  // namespace gyrotherm::run
