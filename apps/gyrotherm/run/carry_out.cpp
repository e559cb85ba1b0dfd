// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/run/carry_out.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "acquisition/record/record.hpp"
#include "acquisition/record/record_files.hpp"
#include "acquisition/record/run_info.hpp"
#include "acquisition/record/sqlite.hpp"
#include "acquisition/record/status.hpp"
#include "acquisition/record/store.hpp"
#include "apps/console/interrupt.hpp"
#include "apps/gyrotherm/release/program_register.hpp"
#include "apps/gyrotherm/run/checked_profile.hpp"
#include "apps/gyrotherm/run/confirmed_commands.hpp"
#include "apps/gyrotherm/run/operator_mark.hpp"
#include "apps/gyrotherm/run/readiness.hpp"
#include "apps/gyrotherm/run/run_decider.hpp"
#include "core/clock.hpp"
#include "core/count_text.hpp"
#include "core/deadline.hpp"
#include "core/file.hpp"
#include "core/process.hpp"
#include "core/shipped.hpp"
#include "sequencer/prove/make_safe_proof.hpp"
#include "sequencer/rig/rig.hpp"
#include "sequencer/rig/unit_serials.hpp"
#include "sequencer/run/chamber_ownership.hpp"
#include "sequencer/run/resume.hpp"
#include "sequencer/run/run_controller.hpp"
#include "sequencer/watchdog/safe_state_file.hpp"

namespace gyrotherm::app {
namespace {

/// Longest wait for a write that must be on the disk before the run continues.
constexpr Duration kLongestLastWrite = std::chrono::seconds(3);

constexpr Duration kLongestWaitForReaders = std::chrono::seconds(60);
constexpr Duration kReaderPollInterval = std::chrono::milliseconds(100);

/// Waits for programs that read the record, because a reader may lock it after the writer has died. Fails with timeout
/// after the longest wait, and with interrupted on Ctrl-C. systemd then starts the resume again, at a rate below its
/// start limit.
Result<void> await_readers(Console& console, const std::string& path) {
  if (const auto status = record::read_status(path); status && status->finished)
    return {};  // a finished run is not resumed
  const auto files = record::find_record_files(path);
  const auto file = files ? files->parts.back().path : path;
  bool reported = false;
  for (const Deadline limit(kLongestWaitForReaders); record::is_being_read(file);
       std::this_thread::sleep_for(kReaderPollInterval)) {
    if (!std::exchange(reported, true))
      console.print_message(
          fmt::format("{}: {}; the run continues when the record is released", path, record::kBeingRead));
    if (interrupted()) return failure(FaultKind::interrupted, path, "stopped before the run was resumed");
    if (limit.has_passed()) return failure(FaultKind::timeout, path, record::kBeingRead);
  }
  return {};
}

/// Prints the summary of a run, however it ended, and a warning if the unit is too cold to open the door.
void print_summary(const ActiveRun& run) {
  if (const auto cold = run.run_controller.describe_cold_unit(); !cold.empty())
    run.console.print_message(fmt::format("warning: {}: {}", run.path, cold));
  run.console.print_message(
      fmt::format("{}: {}", run.path, describe(run.run_controller.tally(), run.store.alarms().count())));
}

/// Describes the chamber that a completed real run leaves; empty if it is unknown or virtual.
std::string describe_left_chamber(const ActiveRun& run) {
  const auto& chamber = run.run_controller.last().chamber.value;
  if (run.rig.file().simulated || !chamber) return {};
  if (chamber->activity == ChamberActivity::off) return "the chamber is switched off";
  // The last sample was read before the profile's last set point was sent, and the controller may round a set point.
  return fmt::format("the chamber stays on; its last command was {:g} °C; no program monitors it from now on",
                     run.run_controller.profile().segments.back().target.value);
}

/// Releases the chamber, closes the record unless the chamber was made safe, and prints the outcome. Fails with
/// interlock if the chamber was made safe, or with storage.
Result<void> finish_run(const ActiveRun& run, run::RunOutcome outcome) {
  run.ownership.release();  // complete, or safe set point confirmed
  const auto cause = outcome == run::RunOutcome::complete ? "the profile is complete" : run.run_controller.end_cause();
  const bool is_on_disk = await_end_on_disk(run);
  if (outcome == run::RunOutcome::made_safe) {
    if (is_on_disk) remove_operator_mark(run.path);
    print_summary(run);
    return failure(FaultKind::interlock, run.path, cause);
  }
  if (outcome == run::RunOutcome::stopped) run.console.print_message(fmt::format("{}: {}", run.path, cause));
  auto finished = is_on_disk ? run.store.finish()
                             : failure(FaultKind::storage, run.path, cause + ", but the record lacks its last seconds");
  if (finished) {
    remove_operator_mark(run.path);
    run.console.print_message(
        fmt::format("{}: recorded, {} s from start to end", run.path, run.run_controller.next_slot()));
  }
  print_summary(run);
  if (const auto left = describe_left_chamber(run); outcome == run::RunOutcome::complete && !left.empty())
    run.console.print_message(fmt::format("{}: {}", run.path, left));
  return finished;
}

/// Returns the fault of a run that a signal stopped. Releases the chamber if it holds its set point; otherwise the
/// guard continues to make it safe.
tl::unexpected<Fault> interruption_fault(const ActiveRun& run) {
  print_summary(run);
  if (!run.rig.file().simulated && run.run_controller.run_state() == RunState::aborting)
    return failure(FaultKind::interrupted, run.path,
                   fmt::format("interrupted after {} s: {}; the guard remains until the chamber confirms the safe set "
                               "point; \"gyrotherm resume "
                               "{}\" continues",
                               run.run_controller.next_slot(), run.run_controller.end_cause(), run.path));
  auto why = run.run_controller.describe_external_change();
  if (why.empty()) why = run.run_controller.leaving_refusal();
  if (!why.empty() && !run.rig.file().simulated)
    return failure(
        FaultKind::interrupted, run.path,
        fmt::format("interrupted after {} s: {}; the guard, gyrotherm-make-safe, sends the chamber to {:g} °C and "
                    "monitors it; \"gyrotherm resume {} --accept\" continues",
                    run.run_controller.next_slot(), why, run.rig.file().safe_set_point.value, run.path));
  run.ownership.release();
  const auto chamber = run.run_controller.is_led_by_controller() ? "continues its program" : "holds its set point";
  return failure(FaultKind::interrupted, run.path,
                 fmt::format("interrupted after {} s, the chamber {}; \"gyrotherm resume {}\" continues the run",
                             run.run_controller.next_slot(), chamber, run.path));
}

Result<void> drive(const ActiveRun& run) {
  const auto outcome = run.rig.file().simulated ? drive_virtual(run) : drive_real(run);
  // Store::finish() reports the damage of a record that it closes, so it is reported here only for other outcomes.
  const bool reaches_its_end = outcome && *outcome != run::RunOutcome::made_safe;
  if (const auto damage = run.store.health().damage; !damage.empty() && !reaches_its_end)
    run.console.print_message("warning: " + damage);
  if (outcome) return finish_run(run, *outcome);
  if (outcome.error().kind == FaultKind::interrupted) return interruption_fault(run);
  if (outcome.error().kind != FaultKind::interlock) run.run_controller.make_safe(text(outcome.error()));
  if (run.run_controller.is_safe()) run.ownership.release();
  return failure(outcome.error().kind, run.path, run.run_controller.end_cause());
}

/// Returns the duration of the interruption.
run::Downtime measure_downtime(const record::Record& record, const std::string& path, const ResumeOptions& options) {
  if (record.info.virtual_rig) return options.gap;
  const auto where = record::status_path(path);
  const auto status =
      read_text_file(where).and_then([&](const std::string& text) { return record::parse_status(text, where); });
  return run::compute_downtime(record, status ? std::optional(*status) : std::nullopt,
                               {.utc = SteadyClock().now().utc, .since_boot = since_boot(), .boot = boot_id()});
}

/// Stores the rig's commands as confirmed for a later resume. Prints a warning if that fails.
void store_confirmations(Console& console, const std::string& rig_file, const rig::RigFile& rig) {
  if (const auto kept = confirm_commands(rig_file, rig); !kept)
    console.print_message(fmt::format("warning: {}; a resume will require --trust-commands", text(kept.error())));
}

/// Checks the programs that a record names as drivers, or stores them as confirmed if they are trusted.
Result<void> admit_commands(Console& console, const record::RunInfo& info, const rig::RigFile& rig, bool trusted) {
  if (!trusted) return check_commands(info.rig_file, rig);
  store_confirmations(console, info.rig_file, rig);
  return {};
}

/// Prints a warning for each lock of the chamber that was ignored because its holder may not drive chambers.
void warn_about_ignored_holders(Console& console, const run::ChamberOwnership& ownership) {
  for (const auto& stranger : ownership.unauthorised_holders())
    console.print_message(
        fmt::format("warning: ignored {}, which holds the lock of the chamber: its user is neither root nor a member "
                    "of gyrotherm or dialout",
                    stranger));
}

/// Prints the guards of dead runs that wait for the chamber.
void print_waiting_guards(Console& console, const run::ChamberOwnership& ownership) {
  for (const auto& guard : ownership.waiting_guards())
    console.print_message(
        fmt::format("warning: {}, has not ended; it ends once this run drives the chamber", guard.words));
}

/// Records the guards of dead runs from which this run takes the chamber over.
void note_waiting_guards(run::RunController& run_controller, const run::ChamberOwnership& ownership) {
  for (const auto& guard : ownership.waiting_guards())
    run_controller.note(EventKind::note, "takes the chamber over from " + guard.words);
}

/// Prints the instruments of a real rig and their lines. Called before connecting, which may take long.
void print_connecting(Console& console, const rig::RigFile& rig) {
  if (rig.simulated) return;
  auto words = fmt::format("connecting to the {} at {}", rig.chamber_map.name, rig.chamber_line);
  for (const auto& thermometer : rig.thermometers)
    words += fmt::format(", {} at {}", format_count(thermometer.channels.size(), "thermometer"), thermometer.line);
  for (const auto& line : rig.gyro_lines) words += ", gyro at " + line.line;
  for (const auto& inputs : rig.analogue_inputs) words += ", analogue inputs at " + inputs.line;
  for (const auto& supply : rig.supplies) words += ", supply at " + supply.line;
  console.print_message(words);
}

/// Returns the fault of a rig that could not be prepared. Releases the chamber if it is unchanged and was not left
/// behind by a program that died. Otherwise the watchdog makes it safe.
tl::unexpected<Fault> preparation_fault(run::ChamberOwnership& ownership, const rig::Rig& rig, Fault why) {
  if (rig.is_as_found() && ownership.took_over())
    why.what += "; the chamber is unchanged since its program died and is made safe";
  else if (rig.is_as_found())
    ownership.release();
  else
    why.what += "; the chamber could not be restored to its initial state and is made safe";
  return failure(std::move(why));
}

/// Applies the resume rule: returns the entry point, or fails with interrupted if an operator must accept the situation
/// first.
Result<run::EntryPoint> find_entry(const run::RunContinuation& on, const ChamberState& now, const std::string& path,
                                   bool accepted) {
  const auto goal = demanded_set_point(on.profile, on.state);
  const bool has_not_begun = on.last_slot < 0 && on.interruption.mismatched_instruments.empty();
  auto interruption = on.interruption;
  const auto trace = watchdog::read_trace(path);
  if (trace && *trace) interruption.given_up = (*trace)->given_up;
  // The guard switches a chamber off that does not obey.
  const bool may_be_off = on.rig.safe_off || (trace && *trace);
  interruption.end_lost = !on.rig.simulated && has_lost_end(path, interruption.end_recorded);
  interruption.found_off = !on.rig.simulated && now.activity == ChamberActivity::off && !may_be_off;
  const auto verdict =
      has_not_begun ? run::ReentryDecision{} : judge_reentry(interruption, on.rig.safe_set_point, now.air);
  if (verdict.way == run::Reentry::ask && !accepted)
    return failure(FaultKind::interrupted, path,
                   fmt::format("{}; check the chamber, then run \"gyrotherm resume {} --accept\"", verdict.why, path));
  const auto entry =
      run::entry_at(goal, now.air, run::is_in_place(now.air, goal, on.interruption.air), on.rig.chamber_limits);
  if (on.rig.simulated) return entry;  // its runs keep the rows of earlier versions
  return run::avoid_step(entry, now, on.rig.chamber_limits, run::EntryClock::runs);
}

/// Reports overdue calibrations and chamber quantities that are not monitored, as messages and as events of the record.
void warn_at_start(Console& console, run::RunController& run_controller, const rig::Rig& rig,
                   const std::vector<std::string>& missing) {
  const auto channels = list_channels(rig.file());
  auto lines = overdue_calibrations(channels, rig.clock().now().utc);
  for (const auto& one : missing)
    lines.push_back("chamber: not monitored, because the unit does not provide it: " + one);
  for (const auto& line : lines) {
    console.print_message("warning: " + line);
    run_controller.note(EventKind::note, line);
  }
}

/// Returns the fault of a start while the chamber reports an alarm that would end the run in its first second.
std::optional<Fault> find_alarm_fault(const ChamberState& found, FaultKind kind, const std::string& next) {
  if (!found.must_stop) return {};
  return Fault{kind, "chamber",
               fmt::format("it still reports the alarm \"{}\", which ends a run; remove its cause, reset it at the "
                           "chamber, then {}",
                           found.alarms.empty() ? "unnamed" : found.alarms.front(), next)};
}

/// Returns the fault of an upload that starts away from the profile's first set point. The controller knows only the
/// rates of its profile; the limits of the rig are enforced by this program.
Fault start_elsewhere_fault(Celsius goal, Celsius air) {
  return {FaultKind::usage, "--upload",
          fmt::format("the air is at {:.2f} °C, but the controller steps to the first set point of the profile, {:g} "
                      "°C; ramp there first with \"gyrotherm go\"",
                      air.value, goal.value)};
}

/// Returns the identity that the chamber reported, or an empty string.
std::string chamber_identity(const std::map<std::string, std::string>& identities) {
  const auto who = identities.find(rig::kChamberTitle);
  return who == identities.end() ? "" : who->second;
}

/// Arms the watchdog to make the chamber of a dead run safe if the run cannot be resumed. Leaves the chamber unchanged
/// if the run only needs an operator's acceptance.
void guard_abandoned_chamber(run::ChamberOwnership& ownership, const record::RunInfo& info, const Fault& why) {
  if (!ownership.is_armed() && why.kind != FaultKind::interrupted)
    static_cast<void>(ownership.arm(chamber_identity(info.identities)));
}

/// Removes the trace that gyrotherm-make-safe left next to the record.
void remove_trace(const std::string& path) {
  std::error_code error;
  std::filesystem::remove(watchdog::made_safe_path(path), error);
}

/// Copies the trace of gyrotherm-make-safe, if there is one, into the record and removes it.
Result<void> record_guard_trace(Console& console, record::Store& store, const Instant& now, const std::string& path) {
  const auto trace = watchdog::read_trace(path);
  const auto words = trace ? (*trace ? watchdog::describe(**trace) : "") : text(trace.error());
  if (words.empty()) return {};
  console.print_message(path + ": " + words);
  if (auto noted = store.append_event({now, EventKind::note, words}); !noted) return noted;
  // If the event is not yet on the disk, the trace remains for the next resume.
  if (!store.settle(kLongestLastWrite)) return {};
  remove_trace(path);
  return {};
}

/// Removes a record that contains only its description.
void remove_empty_record(std::unique_ptr<record::Store> store, const std::string& path) {
  store.reset();
  record::remove_record(path);
}

/// Returns the store's options. A virtual run that ends within moments needs no live copy; a longer one is copied at
/// most once a second and updates its status file ten times a second. A person may watch a run up to x60, so it
/// continues in a new part if its file is moved or fails, like a run of a real rig. A faster run would seem to be
/// behind its disk.
record::StoreOptions store_options(bool simulated, double pace) {
  using std::chrono_literals::operator""ms;
  constexpr double kFastestWatched = 60;
  const record::LiveCopyOptions of_real{}, of_virtual{.pause = 1000ms, .begins_after = 1500ms};
  return {.background = !simulated || (pace > 0 && pace <= kFastestWatched),
          .status_interval = simulated ? Duration(100ms) : Duration::zero(),
          .live_copy = simulated ? of_virtual : of_real};
}

Result<void> append_absence(record::Store& store, const run::InterruptedRun& interruption, std::int64_t first,
                            std::int64_t last) {
  if (last < first) return {};
  const auto cause = interruption.why_unknown.empty() ? "" : "; " + interruption.why_unknown;
  return store.append_gap(first, last, "the program was not running, or its rows did not reach the disk" + cause);
}

// A run begins or resumes in two steps: prepare_opening() acquires the chamber and assembles the rig; the rig then
// calls enter_run() or reenter_run() with the state in which it found the chamber, before any set point is sent.

/// The parts of a run that is about to begin or to resume.
struct Opening {
  run::ChamberOwnership ownership;
  std::unique_ptr<rig::Rig> rig;

  // Set by enter_run() and reenter_run().
  run::EntryPoint entry{};
  /// Quantities of the chamber that are not monitored because it does not provide them.
  std::vector<std::string> missing{};
  /// Contradiction between the chamber's air and the thermometers; empty: none.
  std::string air_mismatch{};
  std::unique_ptr<record::Store> store{};
};

Result<Opening> prepare_opening(Console& console, const rig::RigFile& file, const std::string& path,
                                const rig::RigStart& start, bool by_program) {
  auto ownership = run::ChamberOwnership::take(file, path, by_program);
  if (!ownership) return failure(ownership.error());
  warn_about_ignored_holders(console, *ownership);
  print_waiting_guards(console, *ownership);
  auto rig = rig::Rig::assemble(file, start);
  if (!rig) return failure(rig.error());
  return Opening{.ownership = std::move(*ownership), .rig = std::move(*rig)};
}

/// Keeps the store and arms the guard: the last step before the chamber moves. Returns the first set point.
Result<Celsius> open_run(Opening& opening, Result<std::unique_ptr<record::Store>> store,
                         const rig::FoundChamber& found) {
  if (!store) return failure(store.error());
  opening.store = std::move(*store);
  return opening.ownership.arm(chamber_identity(found.identities), found.settings).map([&] {
    return opening.entry.set_point;
  });
}

// ---- a new run

struct NewRun {
  const profile::Profile& profile;
  const rig::RigFile& file;
  const std::string& path;
  const StartOptions& options;
  profile::ProfileState first;  ///< at the first second
  std::vector<record::ProgramRelease> releases;
};

rig::RigStart make_rig_start(const NewRun& plan) {
  return {.seed = {.gyro = plan.options.seed,
                   .run = run::run_number(plan.profile.text),
                   .days_later = plan.options.days_later},
          .elapsed = {},
          .replay = {},
          .first_set_point = demanded_set_point(plan.profile, plan.first),
          .power = run::power_at_start(plan.profile),
          .dropped_units = plan.file.identification.unused};
}

/// Returns the profile as a program of the chamber's controller; nothing without --upload.
Result<std::optional<drivers::ChamberProgram>> program_to_upload(const NewRun& plan) {
  if (!plan.options.upload) return std::nullopt;
  if (!plan.file.chamber_map.memory)
    return failure(FaultKind::usage, "--upload",
                   fmt::format("the register map of the {} describes no profile memory", plan.file.chamber_map.name));
  auto program = run::make_chamber_program(plan.profile);
  if (!program) return failure(program.error());
  return std::move(*program);
}

/// Fails with mismatch if a chamber at rest contradicts all thermometers. While a chamber conditions, a heavy unit may
/// be far from the air.
Result<void> check_air(const rig::FoundChamber& found, bool is_accepted) {
  if (found.air_mismatch.empty() || is_accepted || found.state.activity != ChamberActivity::off) return {};
  return failure(
      FaultKind::mismatch, "chamber",
      fmt::format("NO-GO: {}. The run was not started; if the display of the chamber shows this air, and the "
                  "thermometers are right, start it with --accept-air",
                  found.air_mismatch));
}

/// Computes the entry point of a new run from the state of the chamber, and creates its record. Returns the first set
/// point.
Result<Celsius> enter_run(const NewRun& plan, Opening& opening, const rig::FoundChamber& found) {
  opening.missing = found.missing;
  opening.air_mismatch = found.air_mismatch;
  if (auto good = check_air(found, plan.options.accept_air); !good) return failure(good.error());
  if (auto alarm = find_alarm_fault(found.state, FaultKind::refused, "start the run again"))
    return failure(std::move(*alarm));
  if (auto good = check_controller(found.limits, plan.profile, plan.file); !good) return failure(good.error());
  const auto goal = demanded_set_point(plan.profile, plan.first), air = found.state.air;
  opening.entry = run::entry_at(goal, air, run::is_in_place(air, goal, {}), plan.file.chamber_limits);
  if (!plan.options.upload && !plan.file.simulated)
    opening.entry = run::avoid_step(opening.entry, found.state, plan.file.chamber_limits, run::EntryClock::waits);
  if (plan.options.upload && opening.entry.away) return failure(start_elsewhere_fault(goal, air));
  auto info = run::run_info(GYROTHERM_VERSION, plan.profile, plan.file, plan.options.seed,
                            opening.rig->will_start_utc(), plan.options.days_later, plan.options.goal);
  info.identities = found.identities;
  info.virtual_instruments = found.virtual_instruments;
  info.releases = plan.releases;
  auto store = record::Store::create(plan.path, info, store_options(plan.file.simulated, plan.options.pace));
  if (store) remove_trace(plan.path);  // trace of an earlier record
  if (store) remove_operator_mark(plan.path);
  return open_run(opening, std::move(store), found);
}

/// Prints which instruments are virtual, if any is.
void print_simulation(Console& console, const record::RunInfo& info) {
  if (info.virtual_instruments.empty()) return;
  console.print_message(fmt::format("SIMULATED: these instruments are virtual: {}; every result of this run is marked",
                                    fmt::join(info.virtual_instruments, ", ")));
}

/// Notes how the run begins. `names` are the lines that prepare() returned. After an upload, the last line is the name
/// of the uploaded program.
void note_start(const NewRun& plan, const Opening& opening, const std::vector<std::string>& names,
                run::RunController& run_controller) {
  run_controller.note(EventKind::started, plan.profile.name);
  if (!opening.air_mismatch.empty()) run_controller.note(EventKind::note, opening.air_mismatch);
  if (const auto& goal = plan.options.goal) run_controller.note(EventKind::note, describe_goal(plan.profile, *goal));
  for (const auto& release : plan.releases)
    if (!release.unreleased.empty()) run_controller.note(EventKind::note, describe(release));
  for (const auto& unit : plan.file.identification.unused)
    run_controller.note(EventKind::note, fmt::format("position {} is empty", unit), {.channel = unit});
  if (opening.entry.away)
    run_controller.begin_away(opening.entry.set_point, "the air is not at the first set point of the profile", {});
  if (!plan.options.upload) return;
  run_controller.hand_over_to_controller();
  run_controller.note(EventKind::note, "the controller carries out the profile: " + names.back());
}

// ---- a resumed run

struct StoppedRun {
  const std::string& path;
  record::RunInfo info;
  run::RunContinuation on;
  Result<std::optional<record::LostEnd>> lost;  ///< lost end of the record
  std::vector<std::string> missing;             ///< lost files of the record
  run::RunTally tally;
  record::Record history;
};

/// Reads the record of a stopped run and decides whether the run can be resumed. The record is not changed.
Result<StoppedRun> find_interrupted(Console& console, const std::string& path, const ResumeOptions& options) {
  if (auto alone = await_readers(console, path); !alone) return failure(alone.error());
  const auto files = record::find_files_to_read(path);
  if (!files) return failure(files.error());
  auto record = record::read_verified_record(*files);
  if (!record) return failure(record.error());
  auto missing = record::missing_files(*files);
  if (!missing) return failure(missing.error());
  if (!missing->empty() && !options.accept)
    return failure(FaultKind::interrupted, path,
                   fmt::format("{}; \"gyrotherm resume {} --accept\" resumes the run without the seconds in them",
                               record::describe_missing(*missing), path));
  auto on = run::plan_continuation(*record, path, measure_downtime(*record, path, options),
                                   run::run_number(record->info.profile_text));
  if (!on) return failure(on.error());
  for (const auto& unit : options.units)
    if (auto same = rig::parse_unit_serial(unit, on->rig).and_then([&](const rig::UnitSerial& serial) {
          return rig::compare_with_record(serial, record->info, path);
        });
        !same)
      return failure(same.error());
  if (auto admitted = admit_commands(console, record->info, on->rig, options.trust_commands); !admitted)
    return failure(admitted.error());
  auto lost = record::lost_end(*files);
  const auto status = record::read_status(*files);
  return StoppedRun{
      .path = path,
      .info = record->info,
      .on = std::move(*on),
      .lost = std::move(lost),
      .missing = std::move(*missing),
      .tally = run::count_tally(*record, status ? status->faults : 0, status ? status->faults_while_off : 0),
      .history = std::move(*record)};
}

/// Fails with interrupted if a run that began on real instruments would continue on virtual ones. Its description
/// cannot be changed, so the rows would not be marked as SIMULATED.
Result<void> check_still_real(const StoppedRun& run, const rig::FoundChamber& found) {
  if (is_simulated(run.info) || found.virtual_instruments.empty()) return {};
  return failure(
      FaultKind::interrupted, run.path,
      fmt::format("{} {} now virtual, but the run is not marked as SIMULATED; connect the real instruments "
                  "and resume the run again, or start a new run",
                  fmt::join(found.virtual_instruments, ", "), found.virtual_instruments.size() == 1 ? "is" : "are"));
}

/// Applies the resume rule to the present state of the chamber, and reopens the record. Returns the first set point.
Result<Celsius> reenter_run(StoppedRun& run, const ResumeOptions& options, Opening& opening,
                            const rig::FoundChamber& found) {
  run::RunContinuation& on = run.on;
  opening.missing = found.missing;
  on.interruption.mismatched_instruments = run::compare_identities(run.info.identities, found.identities);
  const auto next = fmt::format("run \"gyrotherm resume {} --accept\"", run.path);
  if (auto alarm = find_alarm_fault(found.state, FaultKind::interrupted, next)) return failure(std::move(*alarm));
  if (auto real = check_still_real(run, found); !real) return failure(real.error());
  const auto entry = find_entry(on, found.state, run.path, options.accept);
  if (!entry) return failure(entry.error());
  opening.entry = *entry;
  if (auto good = check_controller(found.limits, on.profile, on.rig); !good) return failure(good.error());
  return open_run(opening, record::Store::reopen(run.path, store_options(on.rig.simulated, options.pace)), found);
}

/// Prints and records how the run resumes. `first` is its next second.
void note_resumption(Console& console, const StoppedRun& run, const run::EntryPoint& entry, std::int64_t first,
                     run::RunController& run_controller) {
  const run::RunContinuation& on = run.on;
  const auto text = fmt::format("resumed after {}; cause of the interruption: {}", describe_downtime(on.interruption),
                                on.why_stopped);
  console.print_message(fmt::format("{}: {}; continues at second {}", run.path, text, first));
  run_controller.note(EventKind::resumed, text);
  if (!on.interruption.mismatched_instruments.empty())
    run_controller.note(EventKind::note, "accepted: " + on.interruption.mismatched_instruments);
  if (entry.away) run_controller.begin_away(entry.set_point, on.why_stopped, on.interruption.air);
  if (entry.behind) run_controller.begin_behind(entry.set_point);
  if (!run.missing.empty()) {
    const auto accepted = fmt::format("resumed without the seconds in {}", fmt::join(run.missing, " and "));
    console.print_message(fmt::format("warning: {}: {}", run.path, accepted));
    run_controller.note(EventKind::fault, accepted);
  }
  if (!run.lost || !*run.lost) return;
  console.print_message(fmt::format("warning: {}: {}", run.path, record::describe(**run.lost)));
  run_controller.note(EventKind::fault, "the record " + describe(**run.lost));
}

}  // namespace

void add_accept_air_option(CLI::App& command, bool& accept) {
  command.add_flag("--accept-air", accept,
                   "start although the air that the switched-off chamber shows contradicts all thermometers");
}

void add_days_later_option(CLI::App& command, std::uint64_t& days) {
  command
      .add_option("--days-later", days, "age of the gyro and the thermometers of a virtual rig, in days (default: 0)")
      ->check(CLI::Range(std::uint64_t{0}, simulator::kMaxDaysLater));
}

void add_run_json_option(CLI::App& command, std::string& json) {
  command.remove_option(command.get_option("--json"));
  command
      .add_flag("--json{facts}", json,
                "print facts as JSON: the last second that is on disk; --json=samples: also each sample")
      ->check(CLI::IsMember({"facts", "samples"}));
}

void apply_run_json(Console& console, const std::string& json) {
  console.json = !json.empty();
  console.samples = json == "samples";
}

Result<void> check_may_start(const rig::RigFile& rig, const std::string& path, const StartOptions& options) {
  if (!rig.simulated && options.days_later > 0)
    return failure(FaultKind::usage, "--days-later", "only valid on a virtual rig");
  if (path == record::kInMemory) return failure(FaultKind::usage, "record", record::kNotAFileName);
  return record::check_name_of_new_record(path);
}

Result<void> start_run(Console& console, const profile::Profile& profile, const rig::RigFile& file,
                       const std::string& path, const StartOptions& options) {
  if (auto may = check_may_start(file, path, options); !may) return may;
  if (auto may = check_goal(profile, options.goal, options.upload); !may) return may;
  if (auto may = check_protection(file); !may) return may;
  if (!file.simulated) console.never_wait();
  auto releases = check_releases(profile, file);
  if (!releases) return failure(releases.error());
  const NewRun plan{profile, file, path, options, begin(profile), std::move(*releases)};
  for (const auto& release : plan.releases)
    if (!release.unreleased.empty()) console.print_message(describe(release));
  auto opening = prepare_opening(console, file, path, make_rig_start(plan), options.upload);
  if (!opening) return failure(opening.error());
  const auto program = program_to_upload(plan);
  if (!program) return failure(program.error());
  print_readiness(console, file, check_readiness(file, path, opening->rig->will_start_utc()));
  print_connecting(console, file);
  store_confirmations(console, file.file, file);
  const auto entrance = [&](const rig::FoundChamber& found) { return enter_run(plan, *opening, found); };
  const auto names = opening->rig->prepare(entrance, *program ? &**program : nullptr);
  if (!names) {
    auto why = preparation_fault(opening->ownership, *opening->rig, names.error());
    if (opening->store) remove_empty_record(std::move(opening->store), path);
    return why;
  }
  opening->ownership.heartbeat({});
  for (const auto& line : *names) console.print_detail(line);
  run::RunController run_controller(profile, *opening->rig, *opening->store, plan.first, 0);
  if (!opening->air_mismatch.empty()) console.print_message(opening->air_mismatch);
  print_simulation(console, opening->store->info());
  note_start(plan, *opening, *names, run_controller);
  note_waiting_guards(run_controller, opening->ownership);
  warn_at_start(console, run_controller, *opening->rig, opening->missing);
  record::Record history;
  history.info = opening->store->info();
  const auto decider = RunDecider::make(std::move(history), !file.simulated);
  if (!decider) return failure(decider.error());
  return drive({console, run_controller.profile(), run_controller, *opening->rig, *opening->store, opening->ownership,
                path, decider->get(), options.pace});
}

Result<void> resume_run(Console& console, const std::string& path, const ResumeOptions& options) {
  auto run = find_interrupted(console, path, options);
  if (!run) return failure(run.error());
  run::RunContinuation& on = run->on;
  if (const auto why = on.rig.simulated ? "" : prove::relay_refusal_reason(on.rig, run->info.rig_file); !why.empty())
    return failure(FaultKind::refused, path, why);
  if (!on.rig.simulated) console.never_wait();
  auto opening = prepare_opening(console, on.rig, path, on.start, false);
  if (!opening) return failure(opening.error());
  print_connecting(console, on.rig);
  const auto entrance = [&](const rig::FoundChamber& found) { return reenter_run(*run, options, *opening, found); };
  if (auto names = opening->rig->prepare(entrance, nullptr); !names) {
    guard_abandoned_chamber(opening->ownership, run->info, names.error());
    return preparation_fault(opening->ownership, *opening->rig, names.error());
  }
  opening->ownership.heartbeat({});
  const auto first = opening->rig->clock().now().since_start / std::chrono::seconds(1);
  if (auto recorded = append_absence(*opening->store, on.interruption, on.recorded + 1, first - 1); !recorded)
    return recorded;
  if (first > on.recorded + 1) run->tally.count_gap(on.recorded + 1, first - 1);
  run::RunController run_controller(on.profile, *opening->rig, *opening->store, on.state, first);
  run_controller.leave_out(on.start.dropped_units);
  run_controller.continue_tally(run->tally);
  print_simulation(console, run->info);
  note_resumption(console, *run, opening->entry, first, run_controller);
  note_waiting_guards(run_controller, opening->ownership);
  warn_at_start(console, run_controller, *opening->rig, opening->missing);
  if (auto recalled = record_guard_trace(console, *opening->store, opening->rig->clock().now(), path); !recalled)
    return recalled;
  const auto decider = RunDecider::make(std::move(run->history), !on.rig.simulated);
  if (!decider) return failure(decider.error());
  return drive({console, run_controller.profile(), run_controller, *opening->rig, *opening->store, opening->ownership,
                path, decider->get(), options.pace});
}

}  // namespace gyrotherm::app
