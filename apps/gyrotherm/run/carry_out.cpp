// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/run/carry_out.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <thread>
#include <utility>

#include "acquisition/record/record.hpp"
#include "acquisition/record/record_files.hpp"
#include "acquisition/record/run_info.hpp"
#include "acquisition/record/sqlite.hpp"
#include "acquisition/record/status.hpp"
#include "acquisition/record/store.hpp"
#include "apps/console/interrupt.hpp"
#include "apps/gyrotherm/run/checked_profile.hpp"
#include "apps/gyrotherm/run/confirmed_commands.hpp"
#include "apps/gyrotherm/run/readiness.hpp"
#include "core/clock.hpp"
#include "core/deadline.hpp"
#include "core/file.hpp"
#include "core/process.hpp"
#include "core/shipped.hpp"
#include "sequencer/rig/rig.hpp"
#include "sequencer/run/chamber_ownership.hpp"
#include "sequencer/run/resume.hpp"
#include "sequencer/run/run_controller.hpp"
#include "sequencer/watchdog/safe_state_file.hpp"

namespace gyrotherm::app {
namespace {

constexpr Duration kLongestLastWrite = std::chrono::seconds(3);  ///< to the disk, of what must be there before going on

constexpr Duration kLongestReading = std::chrono::seconds(60);
constexpr Duration kLookForReaders = std::chrono::milliseconds(100);

/// Whoever began to read the record when its program had died keeps the run from going on, but not for good: the fault
/// after the longest wait is one that systemd tries again, and not so soon that it gives up.
Result<void> await_readers(Console& console, const std::string& path) {
  if (const auto status = record::read_status(path); status && status->finished) return {};  // it cannot go on anyway
  const auto files = record::find_record_files(path);
  const auto file = files ? files->parts.back().path : path;
  bool told = false;
  for (const Deadline limit(kLongestReading); record::is_being_read(file);
       std::this_thread::sleep_for(kLookForReaders)) {
    if (!std::exchange(told, true))
      console.say(fmt::format("{}: {}; the run goes on once that has ended", path, record::kBeingRead));
    if (interrupted()) return failure(FaultKind::interrupted, path, "stopped before it went on");
    if (limit.over()) return failure(FaultKind::timeout, path, record::kBeingRead);
  }
  return {};
}

/// Prints what a person must know of the run, however it ended.
void say_summary(const UnderWay& run) {
  run.console.say(fmt::format("{}: {}", run.path, in_words(run.run_controller.tally(), run.store.alarms().count())));
}

/// Ends a run as its outcome says.
Result<void> conclude(const UnderWay& run, run::RunOutcome outcome) {
  run.ownership.release();  // complete, or the chamber has shown its safe set point
  if (outcome == run::RunOutcome::made_safe) {
    await_disk(run);
    say_summary(run);
    return failure(FaultKind::interlock, run.path, run.run_controller.end_cause());
  }
  if (outcome == run::RunOutcome::stopped)
    run.console.say(fmt::format("{}: {}", run.path, run.run_controller.end_cause()));
  if (auto finished = run.store.finish(); !finished) return finished;
  run.console.say(fmt::format("{}: recorded, {} s from start to end", run.path, run.run_controller.next_slot()));
  say_summary(run);
  return {};
}

/// A signal has stopped it: the chamber stays where it is, or was sent to its safe set point and remains guarded.
tl::unexpected<Fault> interrupted_run(const UnderWay& run) {
  say_summary(run);
  if (!run.rig.file().simulated && run.run_controller.run_state() == RunState::aborting)
    return failure(FaultKind::interrupted, run.path,
                   fmt::format("stopped after {} s: {}; its guard remains until that is confirmed; \"gyrotherm resume "
                               "{}\" continues",
                               run.run_controller.next_slot(), run.run_controller.end_cause(), run.path));
  if (const auto foreign = run.run_controller.foreign_hold(); !foreign.empty() && !run.rig.file().simulated)
    return failure(
        FaultKind::interrupted, run.path,
        fmt::format("stopped after {} s: {}; the guard, gyrotherm-make-safe, sends it to {:g} °C and watches "
                    "it; \"gyrotherm resume {} --accept\" continues",
                    run.run_controller.next_slot(), foreign, run.rig.file().safe_set_point.value, run.path));
  run.ownership.release();
  const auto chamber =
      run.run_controller.is_left_to_the_controller() ? "goes on with its program" : "holds its set point";
  return failure(FaultKind::interrupted, run.path,
                 fmt::format("stopped after {} s, the chamber {}; \"gyrotherm resume {}\" goes on",
                             run.run_controller.next_slot(), chamber, run.path));
}

Result<void> drive(const UnderWay& run) {
  const auto outcome = run.rig.file().simulated ? drive_virtual(run) : drive_real(run);
  const bool goes_to_its_end =
      outcome && *outcome != run::RunOutcome::made_safe;  // and is told there what is wrong with it
  if (const auto damage = run.store.health().damage; !damage.empty() && !goes_to_its_end)
    run.console.say("warning: " + damage);
  if (outcome) return conclude(run, *outcome);
  if (outcome.error().kind == FaultKind::interrupted) return interrupted_run(run);
  if (outcome.error().kind != FaultKind::interlock) run.run_controller.make_safe(text(outcome.error()));
  if (run.run_controller.is_safe()) run.ownership.release();
  return failure(outcome.error().kind, run.path, run.run_controller.end_cause());
}

/// Returns how long the run was down.
run::Downtime downtime_of(const record::Record& record, const std::string& path, const ResumeOptions& options) {
  if (record.info.simulated) return options.gap;
  const auto where = record::status_path(path);
  const auto status =
      read_text_file(where).and_then([&](const std::string& text) { return record::parse_status(text, where); });
  return run::downtime_of(record, status ? std::optional(*status) : std::nullopt,
                          {.utc = SteadyClock().now().utc, .since_boot = since_boot(), .boot = boot_id()});
}

/// Stores the rig's commands as confirmed for a later resume. Prints a warning if that fails.
void confirm(Console& console, const std::string& rig_file, const rig::RigFile& rig) {
  if (const auto kept = confirm_commands(rig_file, rig); !kept)
    console.say(fmt::format("warning: {}; a resume will want --trust-commands", text(kept.error())));
}

/// Checks the programs that a record names as drivers, or stores them as confirmed if they are trusted.
Result<void> admit_commands(Console& console, const record::RunInfo& info, const rig::RigFile& rig, bool trusted) {
  if (!trusted) return check_commands(info.rig_file, rig);
  confirm(console, info.rig_file, rig);
  return {};
}

/// Prints a warning for each process that holds the chamber's name without being allowed to.
void say_strangers(Console& console, const run::ChamberOwnership& ownership) {
  for (const auto& stranger : ownership.strangers())
    console.say(
        fmt::format("warning: {} holds the chamber's lock and is not waited for: its user is neither root nor a "
                    "member of gyrotherm or dialout",
                    stranger));
}

/// Of a real rig, before the first of them is waited for.
void say_connecting(Console& console, const rig::RigFile& rig) {
  if (rig.simulated) return;
  auto words = fmt::format("connecting to the {} at {}", rig.chamber_map.name, rig.chamber_line);
  for (const auto& thermometer : rig.thermometers)
    words += fmt::format(", {} thermometers at {}", thermometer.channels.size(), thermometer.line);
  for (const auto& line : rig.gyro_lines) words += ", gyro at " + line.line;
  for (const auto& inputs : rig.analogue_inputs) words += ", analogue inputs at " + inputs.line;
  console.say(words);
}

/// Tells what becomes of a rig that could not be prepared: if its chamber is as it was found nobody need make it safe,
/// but where a program had died and left it so.
tl::unexpected<Fault> not_begun(run::ChamberOwnership& ownership, const rig::Rig& rig, Fault why) {
  if (rig.is_as_found() && ownership.took_over())
    why.what += "; the chamber is as it was when its program had died, and is made safe";
  else if (rig.is_as_found())
    ownership.release();
  else
    why.what += "; the chamber could not be put back to where it was found, and is made safe";
  return failure(std::move(why));
}

/// The resume rule, carried out: where the run goes on from; what it leaves to people is theirs to allow.
Result<run::EntryPoint> reentry(const run::RunContinuation& on, const ChamberState& now, const std::string& path,
                                bool accepted) {
  const auto goal = demanded_set_point(on.profile, on.state);
  const bool has_not_begun = on.last_slot < 0 && on.stood.strangers.empty();
  const auto verdict = has_not_begun ? run::ReentryDecision{} : judge_reentry(on.stood, on.rig.safe_set_point, now.air);
  if (verdict.way == run::Reentry::ask && !accepted)
    return failure(FaultKind::interrupted, path,
                   fmt::format("{}; look at the chamber, then \"gyrotherm resume {} --accept\"", verdict.why, path));
  return run::entry_at(goal, now.air, run::is_in_place(now.air, goal, on.stood.air), on.rig.chamber_limits);
}

/// Says, here and in the record, which calibrations are past their day, and what of the chamber nobody watches.
void warn(Console& console, run::RunController& run_controller, const rig::Rig& rig,
          const std::vector<std::string>& missing) {
  const auto channels = channels_of(rig.file());
  auto lines = overdue_calibrations(channels, rig.clock().now().utc);
  for (const auto& one : missing) lines.push_back("chamber: not watched, the unit does not have it: " + one);
  for (const auto& line : lines) {
    console.say("warning: " + line);
    run_controller.note(EventKind::note, line);
  }
}

/// The rig's fastest rates are this program's to keep: a controller knows those of its profile alone.
Fault begins_elsewhere(Celsius goal, Celsius air) {
  return {
      FaultKind::usage, "--upload",
      fmt::format("the air is at {:.2f} °C, and a controller goes to the {:g} °C of the profile's beginning at once; "
                  "\"gyrotherm go\" brings it there by a ramp",
                  air.value, goal.value)};
}

/// Returns the identity that the chamber reported; empty: none.
std::string chamber_of(const std::map<std::string, std::string>& identities) {
  const auto who = identities.find(rig::kChamberTitle);
  return who == identities.end() ? "" : who->second;
}

/// Guards a chamber that a program left when it died, although the run cannot be resumed: then it is made safe. A run
/// that waits for an operator's word leaves it as it is.
void guard_what_was_left(run::ChamberOwnership& ownership, const record::RunInfo& info, const Fault& why) {
  if (!ownership.is_armed() && why.kind != FaultKind::interrupted)
    static_cast<void>(ownership.arm(chamber_of(info.identities)));
}

/// The trace that gyrotherm-make-safe left beside the record.
void remove_trace(const std::string& path) {
  std::error_code error;
  std::filesystem::remove(watchdog::made_safe_path(path), error);
}

/// What gyrotherm-make-safe did while nobody else was there belongs into the record.
Result<void> recall_guard(Console& console, record::Store& store, const Instant& now, const std::string& path) {
  const auto trace = watchdog::read_trace(path);
  const auto words = trace ? (*trace ? watchdog::describe(**trace) : "") : text(trace.error());
  if (words.empty()) return {};
  console.say(path + ": " + words);
  if (auto noted = store.append_event({now, EventKind::note, words}); !noted) return noted;
  if (!store.settle(kLongestLastWrite)) return {};  // the trace stays for the next time
  remove_trace(path);
  return {};
}

/// What it holds is its description alone.
void remove_unbegun(std::unique_ptr<record::Store> store, const std::string& path) {
  store.reset();
  record::remove_record(path);
}

/// A virtual run that is over in a moment is not worth a copy, and is written too fast for more than one a second; what
/// its status file says is old in a moment, too.
record::StoreOptions store_options(bool simulated) {
  using std::chrono_literals::operator""ms;
  const record::LiveCopyOptions of_real{}, of_virtual{.pause = 1000ms, .begins_after = 1500ms};
  return {.background = !simulated,
          .tells_every = simulated ? Duration(100ms) : Duration::zero(),
          .live_copy = simulated ? of_virtual : of_real};
}

Result<void> record_absence(record::Store& store, const run::InterruptedRun& stood, std::int64_t first,
                            std::int64_t last) {
  if (last < first) return {};
  const auto cause = stood.why_unknown.empty() ? "" : "; " + stood.why_unknown;
  return store.append_gap(first, last, "the program was not running" + cause);
}

}  // namespace

void add_days_later(CLI::App& command, std::uint64_t& days) {
  command
      .add_option("--days-later", days,
                  "of a virtual rig: its gyro and its thermometers are so many days older than on day 0 (default: 0)")
      ->check(CLI::Range(std::uint64_t{0}, simulator::kMostDaysLater));
}

void add_json_of_run(CLI::App& command, std::string& json) {
  command.remove_option(command.get_option("--json"));
  command
      .add_flag("--json{facts}", json,
                "print facts as JSON: how far the record is on the disk; --json=samples: each second, too")
      ->check(CLI::IsMember({"facts", "samples"}));
}

void apply_json_of_run(Console& console, const std::string& json) {
  console.json = !json.empty();
  console.samples = json == "samples";
}

Result<void> start_run(Console& console, const profile::Profile& profile, const rig::RigFile& file,
                       const std::string& path, const StartOptions& options) {
  if (!file.simulated && options.days_later > 0)
    return failure(FaultKind::usage, "--days-later", "this rig is real; only a virtual gyro grows older by command");
  const bool upload = options.upload;
  if (path == record::kInMemory) return failure(FaultKind::usage, "record", record::kNoNameOfAFile);
  if (!file.simulated) console.never_wait();
  if (auto free = record::check_name_of_new_record(path); !free) return free;  // before anything moves
  auto ownership = run::ChamberOwnership::take(file, path, upload);
  if (!ownership) return failure(ownership.error());
  say_strangers(console, *ownership);
  const auto first = begin(profile);
  const simulator::LaboratorySeed seed{
      .gyro = options.seed, .run = run::run_number(profile.text), .days_later = options.days_later};
  auto rig = rig::Rig::assemble(
      file, {.seed = seed, .already = {}, .replay = {}, .first_set_point = demanded_set_point(profile, first)});
  if (!rig) return failure(rig.error());
  if (upload && !file.chamber_map.memory)
    return failure(FaultKind::usage, "--upload",
                   fmt::format("the register map of the {} describes no profile memory", file.chamber_map.name));
  const auto program = upload ? run::program_of(profile) : Result<drivers::ChamberProgram>();
  if (!program) return failure(program.error());
  run::EntryPoint entry;
  std::vector<std::string> missing;
  Result<std::unique_ptr<record::Store>> store = nullptr;
  const auto entrance = [&](const rig::ChamberAsFound& found) -> Result<Celsius> {
    missing = found.missing;
    if (auto good = check_controller(found.limits, profile, file); !good) return failure(good.error());
    const auto goal = demanded_set_point(profile, first), air = found.state.air;
    entry = run::entry_at(goal, air, run::is_in_place(air, goal, {}), file.chamber_limits);
    if (upload && entry.away) return failure(begins_elsewhere(goal, air));
    auto info =
        run::run_info(GYROTHERM_VERSION, profile, file, options.seed, (*rig)->will_start_utc(), options.days_later);
    info.identities = found.identities;
    store = record::Store::create(path, info, store_options(file.simulated));
    if (!store) return failure(store.error());
    remove_trace(path);  // of an earlier record of that name
    return ownership->arm(chamber_of(found.identities), found.settings).map([&] { return entry.set_point; });
  };
  say_readiness(console, file, check_readiness(file, path, (*rig)->will_start_utc()));
  say_connecting(console, file);
  confirm(console, file.file, file);
  const auto names = (*rig)->prepare(entrance, upload ? &*program : nullptr);
  if (!names) {
    auto why = not_begun(*ownership, **rig, names.error());
    if (store && *store) remove_unbegun(std::move(*store), path);
    return why;
  }
  ownership->heartbeat({});
  for (const auto& who : *names) console.detail(who);
  run::RunController run_controller(profile, **rig, **store, first, 0);
  run_controller.note(EventKind::started, profile.name);
  if (entry.away) run_controller.begin_away(entry.set_point, "the air is not where the profile begins", {});
  if (upload) {
    run_controller.leave_to_the_controller();
    run_controller.note(EventKind::note, "the controller carries the profile out: " + names->back());
  }
  warn(console, run_controller, **rig, missing);
  return drive({console, profile, run_controller, **rig, **store, *ownership, path});
}

Result<void> resume_run(Console& console, const std::string& path, const ResumeOptions& options) {
  if (auto alone = await_readers(console, path); !alone) return alone;
  const auto files = record::find_files_to_read(path);
  if (!files) return failure(files.error());
  const auto record = record::read_proved_record(*files);
  if (!record) return failure(record.error());
  auto on = run::continuation_of(*record, path, downtime_of(*record, path, options),
                                 run::run_number(record->info.profile_text));
  if (!on) return failure(on.error());
  if (auto admitted = admit_commands(console, record->info, on->rig, options.trust_commands); !admitted)
    return admitted;
  const auto lost = record::lost_end(*files);  // before the record is written again
  const auto stood = record::read_status(*files);
  auto tally = run::tally_of(*record, stood ? stood->faults : 0);
  if (!on->rig.simulated) console.never_wait();
  auto ownership = run::ChamberOwnership::take(on->rig, path);
  if (!ownership) return failure(ownership.error());
  say_strangers(console, *ownership);
  auto rig = rig::Rig::assemble(on->rig, on->start);
  if (!rig) return failure(rig.error());
  run::EntryPoint entry;
  std::vector<std::string> missing;
  Result<std::unique_ptr<record::Store>> store = nullptr;
  const auto entrance = [&](const rig::ChamberAsFound& found) -> Result<Celsius> {
    missing = found.missing;
    on->stood.strangers = run::strangers_among(record->info.identities, found.identities);
    const auto at = reentry(*on, found.state, path, options.accept);
    if (!at) return failure(at.error());
    entry = *at;
    if (auto good = check_controller(found.limits, on->profile, on->rig); !good) return failure(good.error());
    store = record::Store::reopen(path, store_options(on->rig.simulated));
    if (!store) return failure(store.error());
    return ownership->arm(chamber_of(found.identities), found.settings).map([&] { return entry.set_point; });
  };
  say_connecting(console, on->rig);
  if (auto names = (*rig)->prepare(entrance, nullptr); !names) {
    guard_what_was_left(*ownership, record->info, names.error());
    return not_begun(*ownership, **rig, names.error());
  }
  ownership->heartbeat({});
  const auto first = (*rig)->clock().now().since_start / std::chrono::seconds(1);
  if (auto recorded = record_absence(**store, on->stood, on->recorded + 1, first - 1); !recorded) return recorded;
  if (first > on->recorded + 1) tally.see_gap(on->recorded + 1, first - 1);
  run::RunController run_controller(on->profile, **rig, **store, on->state, first);
  run_controller.leave_out(on->start.dropped_units);
  run_controller.continue_tally(tally);
  const auto text = fmt::format("resumed after {}; it had stopped: {}", down_in_words(on->stood), on->why_stopped);
  console.say(fmt::format("{}: {} at second {}", path, text, first));
  run_controller.note(EventKind::resumed, text);
  if (!on->stood.strangers.empty()) run_controller.note(EventKind::note, "accepted: " + on->stood.strangers);
  if (entry.away) run_controller.begin_away(entry.set_point, on->why_stopped, on->stood.air);
  if (lost && *lost) {
    console.say(fmt::format("warning: {}: {}", path, record::describe(**lost)));
    run_controller.note(EventKind::fault, "the record " + describe(**lost));
  }
  warn(console, run_controller, **rig, missing);
  if (auto told = recall_guard(console, **store, (*rig)->clock().now(), path); !told) return told;
  return drive({console, on->profile, run_controller, **rig, **store, *ownership, path});
}

}  // namespace gyrotherm::app
