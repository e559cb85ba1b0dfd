// SPDX-License-Identifier: Apache-2.0
/// The lead of a run's chamber: this program sends each set point (HostLead), or the chamber's own controller carries
/// out the profile as a program (ControllerLead). A run has one lead from its start. The run controller calls it once a
/// second, in the thread of the tick.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "acquisition/io/instrument_io.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"
#include "core/sample.hpp"
#include "drivers/chamber/program.hpp"
#include "sequencer/interlocks/interlocks.hpp"
#include "sequencer/profile/profile.hpp"
#include "sequencer/rig/rig_file.hpp"
#include "sequencer/run/operator_requests.hpp"
#include "sequencer/run/set_point_path.hpp"
#include "sequencer/watchdog/air_watch.hpp"

namespace gyrotherm::run {

/// The inputs of a lead for one second of a run.
struct LeadSecond {
  const Sample& sample;
  /// The profile's set point.
  Celsius goal;
  /// Run time at the end of this second.
  Duration at{};
  /// Time without ticks before this second.
  Duration missed{};
  /// The profile is in its last segment. The chamber's program may end before the profile, or after it.
  bool in_last_segment{};
  /// The profile is in its last segment, and that is a hold.
  bool in_last_hold{};
  /// True if the last reading shows a change that this program did not make; see is_changed_externally().
  bool changed_by_another{};
  /// Set point of the last segment.
  Celsius end{};
  /// Latest air temperature that was known before this second.
  std::optional<Celsius> air_before{};
};

class ChamberLead {
 public:
  virtual ~ChamberLead() = default;

  /// Returns true if the chamber follows the profile without this program: during its pauses and after its end.
  [[nodiscard]] virtual bool can_continue_alone() const = 0;
  /// Returns the reason why this lead cannot carry out an operator's command; empty if it can.
  [[nodiscard]] virtual std::string refusal_reason(OperatorCommand command) const = 0;

  /// Sets the values with which the interlocks compare the chamber.
  virtual void fill_inputs(const LeadSecond& second, interlocks::InterlockInputs& inputs) = 0;
  /// Returns the interlocks' demand as adjusted by this lead: milder, or more severe for a reason that only the lead
  /// knows.
  [[nodiscard]] virtual interlocks::InterlockDemand adjust_demand(interlocks::InterlockDemand demand,
                                                                  const LeadSecond& second) = 0;
  /// Returns true if set point and air permit the profile's clock to run.
  [[nodiscard]] virtual bool is_in_place(const LeadSecond& second) const = 0;
  /// Ends an approach to the profile. The profile's clock then runs again.
  virtual void end_approach() = 0;
  /// Permits the next command to overwrite a foreign set point. Called when an operator requests it.
  virtual void allow_takeover() = 0;
  /// Leaves the chamber of a stopped run at the profile's current set point. Fails if the chamber may not stay there.
  [[nodiscard]] virtual Result<void> send_last_set_point(io::InstrumentIo& io, const LeadSecond& second) = 0;

  /// Returns the reason why a profile at its end is not complete: the chamber is not in the state that the profile
  /// requires. Empty if it is complete.
  [[nodiscard]] virtual std::string incomplete_reason(const LeadSecond&) const { return {}; }

  /// Commands the chamber in this second of a run in `state`. `returning` is true if the run is on its way back to the
  /// profile. Returns the text of a failure for the record, or nothing.
  [[nodiscard]] virtual std::optional<std::string> send_set_point(io::InstrumentIo& io, const LeadSecond& second,
                                                                  RunState state, bool returning,
                                                                  const interlocks::InterlockMemory& memory) = 0;
  /// Returns the number of set points that the chamber refused so far.
  [[nodiscard]] virtual std::int64_t missed_set_points() const = 0;
  [[nodiscard]] virtual std::int64_t unconfirmed_set_points() const = 0;
};

/// Returns true if the last reading shows a foreign set point or program, or a mode that does not follow the set point.
[[nodiscard]] bool is_changed_externally(const interlocks::InterlockMemory& memory);

/// Sends each set point along a path without jumps. After a deviation, waits for the air before the profile continues.
class HostLead final : public ChamberLead {
 public:
  /// `here` is the set point that the chamber accepted at the run time `at`.
  HostLead(const rig::RigFile& rig, Celsius here, Duration at);

  /// Starts with the chamber away from the profile. The profile's clock is stopped until the air is within kResumeBand
  /// of the set point, or of `air_before`, the air temperature when the run stopped.
  void begin_away(std::optional<Celsius> air_before);

  [[nodiscard]] bool can_continue_alone() const override { return false; }
  [[nodiscard]] std::string refusal_reason(OperatorCommand) const override { return {}; }
  void fill_inputs(const LeadSecond& second, interlocks::InterlockInputs& inputs) override;
  /// Applies the resume rule after a pause of this program, as after a restart. If the air has moved away from the
  /// goal, the run is suspended until the air returns. The air must return even if another cause has already stopped
  /// the run.
  [[nodiscard]] interlocks::InterlockDemand adjust_demand(interlocks::InterlockDemand demand,
                                                          const LeadSecond& second) override;
  [[nodiscard]] bool is_in_place(const LeadSecond& second) const override;
  void end_approach() override;
  void allow_takeover() override { taking_over_ = true; }
  /// Fails if another program or a person has changed the chamber.
  [[nodiscard]] Result<void> send_last_set_point(io::InstrumentIo&, const LeadSecond& second) override;
  /// Sends nothing to a silent chamber, or to one with an unexplained set point.
  [[nodiscard]] std::optional<std::string> send_set_point(io::InstrumentIo& io, const LeadSecond& second,
                                                          RunState state, bool returning,
                                                          const interlocks::InterlockMemory& memory) override;
  [[nodiscard]] std::int64_t missed_set_points() const override { return path_.missed(); }
  [[nodiscard]] std::int64_t unconfirmed_set_points() const override { return path_.unconfirmed(); }

 private:
  [[nodiscard]] std::optional<std::string> take_over_chamber(io::InstrumentIo& io, const LeadSecond& second);
  [[nodiscard]] bool is_waiting_for_air(Celsius air) const;

  profile::ChamberLimits limits_;
  SetPointPath path_;
  /// The air must return before the profile continues.
  bool approaching_ = false;
  /// Air when the run stopped.
  std::optional<Celsius> air_before_;
  bool taking_over_ = false;
  /// Time without ticks since the air was last read.
  Duration unread_time_{};
};

// A profile that the chamber's controller carries out: its program, and the lead that watches it.

/// Converts the profile to a program, segment by segment. The program has the profile's name in capitals, reduced to
/// letters and digits. Fails with usage if a controller cannot carry out a segment, or if the guaranteed soaks have
/// different bands.
[[nodiscard]] Result<drivers::ChamberProgram> make_chamber_program(const profile::Profile& profile);

/// Leaves the chamber to its controller. Sends no set points, continues while an instrument is silent, and aborts the
/// run if the controller stops executing its program. The controller cannot be paused from here.
class ControllerLead final : public ChamberLead {
 public:
  explicit ControllerLead(Kelvins tolerance) : tolerance_(tolerance) {}

  [[nodiscard]] bool can_continue_alone() const override { return true; }
  [[nodiscard]] std::string refusal_reason(OperatorCommand command) const override;
  void fill_inputs(const LeadSecond& second, interlocks::InterlockInputs& inputs) override;
  /// Keeps only demands to abort: a controller continues by itself while an instrument is silent.
  [[nodiscard]] interlocks::InterlockDemand adjust_demand(interlocks::InterlockDemand demand,
                                                          const LeadSecond& second) override;
  [[nodiscard]] bool is_in_place(const LeadSecond&) const override { return true; }
  void end_approach() override {}
  void allow_takeover() override {}
  /// Sends the set point, which ends the controller's program.
  [[nodiscard]] Result<void> send_last_set_point(io::InstrumentIo& io, const LeadSecond& second) override;
  [[nodiscard]] std::optional<std::string> send_set_point(io::InstrumentIo&, const LeadSecond&, RunState, bool,
                                                          const interlocks::InterlockMemory&) override {
    return std::nullopt;
  }
  [[nodiscard]] std::int64_t missed_set_points() const override { return 0; }
  [[nodiscard]] std::int64_t unconfirmed_set_points() const override { return 0; }
  [[nodiscard]] std::string incomplete_reason(const LeadSecond& second) const override;

 private:
  /// Returns the reason why the run must end, or nothing. Returns nothing for a controller that does not answer, or
  /// whose map has no states. In the last segment, a controller at the final set point may have finished.
  [[nodiscard]] std::string judge(const LeadSecond& second);
  [[nodiscard]] bool may_have_finished(const LeadSecond& second) const;
  void watch_end(const LeadSecond& second);

  /// Tolerance of the set point that is read back.
  Kelvins tolerance_;
  /// Time since the controller last carried out its program.
  Duration gone_{};
  Duration silent_{};
  std::optional<watchdog::AirWatch> end_watch_;
  bool away_ = false;
};

}  // namespace gyrotherm::run
