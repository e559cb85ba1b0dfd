// SPDX-License-Identifier: Apache-2.0
/// Makes the chamber of a run safe: sends the safe set point, sees to the mode that follows it, switches the chamber
/// off if the rig file demands it or all else has failed, and watches the air until it shows the effect.
#pragma once

#include <optional>
#include <string>

#include "acquisition/io/instrument_io.hpp"
#include "core/quantity.hpp"
#include "core/sample.hpp"
#include "sequencer/rig/rig_file.hpp"
#include "sequencer/watchdog/safe_evidence.hpp"

namespace gyrotherm::run {

/// The name of the alarm that a chamber raises which is commanded to be safe and is not.
inline constexpr const char* kSafeIneffective = "safe_ineffective";

class SafeSequence {
 public:
  explicit SafeSequence(const rig::RigFile& rig);

  /// One try, at `at` of the run; what was done before is not done again unless the chamber shows otherwise. A line
  /// that rests is tried all the same: in each of the first ten seconds, then once in ten. Returns what the operator is
  /// to be told, or nothing: the first failure, and then one a minute.
  [[nodiscard]] std::optional<std::string> attempt(io::InstrumentIo& io, Duration at);
  /// Takes the reading of the second that ends at `at`. is_confirmed() is true afterwards if the chamber has shown set
  /// point, mode and air since it was commanded.
  void see(const Reading<ChamberState>& chamber, Duration at);

  [[nodiscard]] bool is_confirmed() const { return confirmed_; }
  [[nodiscard]] bool is_ineffective() const { return evidence_.is_ineffective(); }
  /// "the chamber was sent to 20 °C (set point read back; …)", "the chamber could NOT be sent to 20 °C (…)"
  [[nodiscard]] std::string describe() const;

 private:
  [[nodiscard]] Result<void> carry_out(io::InstrumentIo& io, bool at_once);
  [[nodiscard]] bool is_only_being_watched() const;

  Celsius target_;
  watchdog::SafeEvidence evidence_;
  bool confirmed_ = false;
  std::optional<Duration> began_, told_, insisted_;
  std::string trouble_;
};

}  // namespace gyrotherm::run
