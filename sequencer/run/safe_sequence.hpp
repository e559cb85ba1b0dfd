// SPDX-License-Identifier: Apache-2.0
/// Makes the chamber of a run safe. Sends the safe set point, sets the mode that follows it, switches the chamber off
/// if the rig file requires it or if all else has failed, and watches the air until it shows the effect.
#pragma once

#include <optional>
#include <string>

#include "acquisition/io/instrument_io.hpp"
#include "core/quantity.hpp"
#include "core/sample.hpp"
#include "sequencer/rig/rig_file.hpp"
#include "sequencer/watchdog/relay_rescue.hpp"
#include "sequencer/watchdog/safe_evidence.hpp"

namespace gyrotherm::run {

/// Alarm that is raised if the chamber does not become safe although it was commanded to.
inline constexpr const char* kSafeIneffective = "safe_ineffective";

class SafeSequence {
 public:
  explicit SafeSequence(const rig::RigFile& rig);

  /// Makes one attempt at run time `at`. Skips steps that are done, unless the chamber shows otherwise. In each of the
  /// first ten seconds, and every ten seconds after that, sends even while a failed line pauses. Returns a text for the
  /// operator at the first failure, then at most once a minute; otherwise nothing. A chamber that gives no reading for
  /// some seconds is a failure.
  [[nodiscard]] std::optional<std::string> attempt(io::InstrumentIo& io, Duration at);
  /// Adds the reading of the second that ends at `at`. is_confirmed() then returns true if the chamber has shown set
  /// point, mode and air since it was commanded.
  void add_reading(const Reading<ChamberState>& chamber, Duration at);

  [[nodiscard]] bool is_confirmed() const { return confirmed_; }
  [[nodiscard]] bool is_ineffective() const { return evidence_.is_ineffective(); }
  /// Returns true if the last attempt failed, or had no effect, or the chamber cannot be read, or its air
  /// moves away although it is off.
  [[nodiscard]] bool is_failing() const;
  /// Returns whether the relay of [safe.also] must be opened, by the rules of the guard.
  [[nodiscard]] watchdog::RelayDue relay_due() const;
  /// Returns "the chamber was sent to 20 °C (set point read back; …)" "the chamber was sent to 20 °C, but its air
  /// does NOT follow (…)" or "the chamber could NOT be sent to 20 °C (…)".
  [[nodiscard]] std::string describe() const;

 private:
  [[nodiscard]] Result<void> carry_out(io::InstrumentIo& io, bool at_once);
  [[nodiscard]] bool is_only_being_watched() const;
  [[nodiscard]] std::string describe_commands() const;

  Celsius target_;
  watchdog::SafeEvidence evidence_;
  bool confirmed_ = false;
  std::optional<Duration> began_, reported_, forced_, now_;
  std::string trouble_;
  /// Fault of the last command that set the mode; empty: it succeeded.
  std::string mode_trouble_;
  /// Seconds in a row without a reading, and the fault of the last of them.
  int unread_ = 0;
  std::string read_trouble_;
};

}  // namespace gyrotherm::run
