// SPDX-License-Identifier: Apache-2.0
/// The power of the units under test during a run: compares the supplies with the state that the profile requires, and
/// requests switches. The run controller calls it once a second, in the thread of the tick.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "acquisition/io/instrument_io.hpp"
#include "core/quantity.hpp"
#include "sequencer/interlocks/interlocks.hpp"
#include "sequencer/profile/machine.hpp"
#include "sequencer/rig/rig_file.hpp"

namespace gyrotherm::run {

/// An output is switched only at the start of a segment that changes the power, by an operator's resume, and after an
/// abort. At any other time a difference is reported and not corrected, because a person may have caused it.
class UnitPower {
 public:
  /// `rig` must outlive this object.
  explicit UnitPower(const rig::RigFile& rig);

  /// Takes the required state from the profile. Requests a switch if the profile is at the start of a segment that
  /// changes the power. Call it before the first reading.
  void begin(io::InstrumentIo& io, const profile::Profile& profile, const profile::ProfileState& state);
  /// Evaluates the last readings of the supplies, which cover `elapsed`. Returns lines for the record: finished
  /// switches, and new reasons why a switch was not carried out.
  struct Report {
    std::vector<std::string> notes{}, faults{};
  };
  [[nodiscard]] Report observe(const io::InstrumentIo& io, Duration elapsed);
  /// Requests a switch of all supplies if the required state changes.
  void require(io::InstrumentIo& io, bool off);
  /// Requests the required state again, at an operator's request. Clears trips.
  void switch_again(io::InstrumentIo& io);
  /// Switches the supplies with `on_stop = "off"` off. May be called repeatedly.
  void stop(io::InstrumentIo& io);

  [[nodiscard]] const interlocks::PowerFaults& faults() const { return faults_; }
  /// Describes the switch that is being carried out; empty if there is none.
  [[nodiscard]] std::string wait() const;
  /// Returns whether a unit may be silent because it is being switched, is starting, or was switched off by stop().
  [[nodiscard]] bool may_be_silent() const;
  /// Returns whether no supply is being switched off after stop(), or the attempts have taken too long.
  [[nodiscard]] bool is_settled() const;
  /// Describes the supplies that stop() switches; empty if there is none.
  [[nodiscard]] std::string describe_stop() const;

 private:
  struct Supply {
    bool must_be_off = false;
    bool is_switching = false;
    std::string trouble{};
  };

  void request(io::InstrumentIo& io, std::size_t index, bool off, bool after_trip = false);
  void observe_supply(std::size_t index, const drivers::SupplyReadings& readings, Report& report);
  void observe_output(std::size_t index, const rig::SupplyOutput& output,
                      const Result<drivers::OutputReading>& reading);

  const rig::RigFile& rig_;
  std::vector<Supply> supplies_;
  interlocks::PowerFaults faults_;
  bool is_off_ = false;
  bool has_stopped_ = false;
  /// Time in which a unit that was switched on may still be silent.
  Duration boot_left_{};
  Duration since_stop_{};
};

}  // namespace gyrotherm::run
