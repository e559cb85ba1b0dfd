// SPDX-License-Identifier: Apache-2.0
/// How the chamber is made safe: the safe set point, read back, then, if the rig file says so, switched off; and, in a
/// later second, the chamber's own word that it is so.
#pragma once

#include <optional>
#include <string>

#include "acquisition/io/instrument_io.hpp"
#include "core/quantity.hpp"
#include "core/sample.hpp"
#include "rig/rig_file.hpp"

namespace gyrotherm::run {

class SafeSequence {
 public:
  explicit SafeSequence(const rig::RigFile& rig);

  /// One try, at `at` of the run; what was done before is not done again unless the chamber shows otherwise. A line
  /// that rests is tried all the same: in each of the first ten seconds, then once in ten. Returns what the operator is
  /// to be told, or nothing: the first failure, and then one a minute.
  [[nodiscard]] std::optional<std::string> attempt(io::InstrumentIo& io, Duration at);
  /// A second's reading. After it is_confirmed() says whether the chamber has shown the safe set point since it took
  /// it.
  void see(const Reading<ChamberState>& chamber);

  [[nodiscard]] bool is_confirmed() const { return confirmed_; }
  /// "the chamber was sent to 20 °C", "the chamber could NOT be sent to 20 °C (…)"
  [[nodiscard]] std::string describe() const;

 private:
  [[nodiscard]] Result<void> carry_out(io::InstrumentIo& io, bool at_once);

  Celsius target_;
  bool off_;
  Kelvins tolerance_;
  bool ends_programs_;  ///< the controller can be told to
  bool taken_ = false, switched_ = false, confirmed_ = false;
  std::optional<Duration> began_, told_, insisted_;
  std::string trouble_;
};

}  // namespace gyrotherm::run
