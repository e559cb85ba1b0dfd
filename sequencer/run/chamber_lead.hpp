// SPDX-License-Identifier: Apache-2.0
/// Who leads the chamber along the profile: this program, set point by set point (HostLead), or the chamber's own
/// controller, which was given the profile as a program (ControllerLead). A run has one from its start; the run
/// controller calls it once a second, in the thread of the tick.
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

/// One second of a run, as its lead sees it.
struct LeadSecond {
  const Sample& sample;
  Celsius goal;                         ///< the profile's set point
  Duration at{};                        ///< the run's time when this second ends
  Duration missed{};                    ///< how long there was no tick before it
  bool in_last_segment{};               ///< the profile's own end may come before the chamber's, or after it
  bool in_last_hold{};                  ///< … and it is a hold
  bool changed_by_another{};            ///< another has changed the chamber
  Celsius end{};                        ///< set point when it ends
  std::optional<Celsius> air_before{};  ///< the air as it was last known before this second
};

class ChamberLead {
 public:
  virtual ~ChamberLead() = default;

  /// Returns true if the chamber continues along the profile when this program pauses or ends.
  [[nodiscard]] virtual bool can_continue_alone() const = 0;
  /// Returns why an operator's command cannot be carried out under this lead; empty if it can.
  [[nodiscard]] virtual std::string objection(OperatorCommand command) const = 0;

  /// Fills in the values that the interlocks compare the chamber with.
  virtual void fill_inputs(const LeadSecond& second, interlocks::InterlockInputs& inputs) = 0;
  /// Returns the interlocks' demand as it applies under this lead: reduced, or raised by a reason of the lead's own.
  [[nodiscard]] virtual interlocks::InterlockDemand adjust_demand(interlocks::InterlockDemand demand,
                                                                  const LeadSecond& second) = 0;
  /// Returns true if set point and air are where the profile's clock may run.
  [[nodiscard]] virtual bool is_in_place(const LeadSecond& second) const = 0;
  /// Ends an approach to the profile: the profile's clock runs.
  virtual void end_approach() = 0;
  /// Lets the next command take the chamber over from a set point that is not the run's own, as an operator has asked.
  virtual void allow_takeover() = 0;
  /// Leaves the chamber of a stopped run at the profile's present set point. Fails if the chamber may not stay there.
  [[nodiscard]] virtual Result<void> send_last_set_point(io::InstrumentIo& io, const LeadSecond& second) = 0;

  /// Returns why a profile at its end is not complete, because the chamber does something else than the profile has
  /// left it at; empty if it is complete.
  [[nodiscard]] virtual std::string objection_to_end(const LeadSecond&) const { return {}; }

  /// Commands the chamber in this second of a run in `state` (`returning`: on its way back to the profile). Returns the
  /// text of a failure for the record, or nothing.
  [[nodiscard]] virtual std::optional<std::string> send_set_point(io::InstrumentIo& io, const LeadSecond& second,
                                                                  RunState state, bool returning,
                                                                  const interlocks::InterlockMemory& memory) = 0;
  /// Counts the set points that the chamber did not take.
  [[nodiscard]] virtual std::int64_t missed_set_points() const = 0;
};

/// Returns true if the last reading shows another's set point or program, or a mode that does not follow.
[[nodiscard]] bool is_changed_by_another(const interlocks::InterlockMemory& memory);

/// Sends the set points itself: a path that nothing makes jump, and that waits until the air has followed.
class HostLead final : public ChamberLead {
 public:
  /// `here`: the set point that the chamber has taken at `at`, the time of the run.
  HostLead(const rig::RigFile& rig, Celsius here, Duration at);

  /// The run begins elsewhere than the profile. The profile's clock stands still until the air has followed, or is
  /// within kResumeBand of `air_before`, where it was when the run stopped.
  void begin_away(std::optional<Celsius> air_before);

  [[nodiscard]] bool can_continue_alone() const override { return false; }
  [[nodiscard]] std::string objection(OperatorCommand) const override { return {}; }
  void fill_inputs(const LeadSecond& second, interlocks::InterlockInputs& inputs) override;
  /// After a pause of the program the resume rule holds as after a restart: air that has left its place suspends, and
  /// has to come back whatever else has stopped the run.
  [[nodiscard]] interlocks::InterlockDemand adjust_demand(interlocks::InterlockDemand demand,
                                                          const LeadSecond& second) override;
  [[nodiscard]] bool is_in_place(const LeadSecond& second) const override;
  void end_approach() override;
  void allow_takeover() override { taking_over_ = true; }
  /// Fails for a chamber that another has changed.
  [[nodiscard]] Result<void> send_last_set_point(io::InstrumentIo&, const LeadSecond& second) override;
  /// A chamber that is silent, or has a set point that nobody understands, is sent nothing.
  [[nodiscard]] std::optional<std::string> send_set_point(io::InstrumentIo& io, const LeadSecond& second,
                                                          RunState state, bool returning,
                                                          const interlocks::InterlockMemory& memory) override;
  [[nodiscard]] std::int64_t missed_set_points() const override { return path_.missed(); }

 private:
  [[nodiscard]] std::optional<std::string> bring_back(io::InstrumentIo& io, const LeadSecond& second);
  [[nodiscard]] bool waits_for_air(Celsius air) const;

  profile::ChamberLimits limits_;
  SetPointPath path_;
  bool approaching_ = false;           ///< the air has to come back first
  std::optional<Celsius> air_before_;  ///< where it was when the run stopped
  bool taking_over_ = false;
  Duration unjudged_{};  ///< without ticks, since the air was last read
};

// A profile that the chamber's controller carries out by itself: what it is given, and the lead that watches it.

/// The profile, segment by segment, as a program. Its name is that of the profile, in capitals, letters and digits
/// alone. Fails with usage if its guaranteed soaks have different bands: a controller has one.
[[nodiscard]] Result<drivers::ChamberProgram> program_of(const profile::Profile& profile);

/// Leaves the chamber to its controller: no set points are sent, time goes on while an instrument is silent, and a
/// controller that no longer carries its program out ends the run. It cannot be paused from here.
class ControllerLead final : public ChamberLead {
 public:
  explicit ControllerLead(Kelvins tolerance) : tolerance_(tolerance) {}

  [[nodiscard]] bool can_continue_alone() const override { return true; }
  [[nodiscard]] std::string objection(OperatorCommand command) const override;
  void fill_inputs(const LeadSecond& second, interlocks::InterlockInputs& inputs) override;
  /// What a controller does by itself goes on while an instrument is silent: only what aborts is left.
  [[nodiscard]] interlocks::InterlockDemand adjust_demand(interlocks::InterlockDemand demand,
                                                          const LeadSecond& second) override;
  [[nodiscard]] bool is_in_place(const LeadSecond&) const override { return true; }
  void end_approach() override {}
  void allow_takeover() override {}
  /// The controller would go on with its program otherwise.
  [[nodiscard]] Result<void> send_last_set_point(io::InstrumentIo& io, const LeadSecond& second) override;
  [[nodiscard]] std::optional<std::string> send_set_point(io::InstrumentIo&, const LeadSecond&, RunState, bool,
                                                          const interlocks::InterlockMemory&) override {
    return std::nullopt;
  }
  [[nodiscard]] std::int64_t missed_set_points() const override { return 0; }
  [[nodiscard]] std::string objection_to_end(const LeadSecond& second) const override;

 private:
  /// Why the run cannot go on, or nothing. A controller that does not answer, or whose map names no states, is not
  /// judged. In the last segment one that holds the set point of the end may have finished.
  [[nodiscard]] std::string judge(const LeadSecond& second);
  [[nodiscard]] bool may_have_finished(const LeadSecond& second) const;
  void watch_end(const LeadSecond& second);

  Kelvins tolerance_;  ///< for the set point read back
  Duration gone_{};    ///< how long the controller has not carried its program out
  Duration silent_{};
  std::optional<watchdog::AirWatch> end_watch_;
  bool away_ = false;
};

}  // namespace gyrotherm::run
