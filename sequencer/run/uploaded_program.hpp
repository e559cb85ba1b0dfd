// SPDX-License-Identifier: Apache-2.0
/// A profile that the chamber's controller carries out by itself: what it is given, and the lead that watches it.
#pragma once

#include <string>

#include "core/result.hpp"
#include "core/sample.hpp"
#include "drivers/chamber/program.hpp"
#include "sequencer/profile/profile.hpp"
#include "sequencer/run/chamber_lead.hpp"

namespace gyrotherm::run {

/// The profile, segment by segment, as a program. Its name is that of the profile, in capitals, letters and digits
/// alone. Fails with usage if its guaranteed soaks have different bands: a controller has one.
[[nodiscard]] Result<drivers::ChamberProgram> program_of(const profile::Profile& profile);

/// Leaves the chamber to its controller: no set points are sent, time goes on while an instrument is silent, and a
/// controller that no longer carries its program out ends the run. It cannot be paused from here.
class ControllerLead final : public ChamberLead {
 public:
  [[nodiscard]] bool goes_on_by_itself() const override { return true; }
  [[nodiscard]] std::string objection(OperatorCommand command) const override;
  void inform(const LeadSecond& second, interlocks::InterlockInputs& inputs) override;
  /// What a controller does by itself goes on while an instrument is silent: only what aborts is left.
  [[nodiscard]] interlocks::InterlockDemand weigh(interlocks::InterlockDemand demand,
                                                  const LeadSecond& second) override;
  [[nodiscard]] bool is_in_place(const LeadSecond&) const override { return true; }
  void arrived() override {}
  void take_over() override {}
  /// A run that is stopped leaves the chamber at the profile's present set point.
  [[nodiscard]] std::optional<std::string> command(io::InstrumentIo& io, const LeadSecond& second, RunState state,
                                                   bool returning, const interlocks::InterlockMemory& memory) override;
  [[nodiscard]] std::int64_t missed_set_points() const override { return 0; }

 private:
  /// Why the run cannot go on, or nothing. A controller that does not answer, or whose map names no states, is not
  /// judged, nor one that may have finished before the profile's last segment ends.
  [[nodiscard]] std::string judge(const LeadSecond& second);

  Duration gone_{};  ///< how long the controller has not carried its program out
};

}  // namespace gyrotherm::run
