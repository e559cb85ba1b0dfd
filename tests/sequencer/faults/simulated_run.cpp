// SPDX-License-Identifier: Apache-2.0
#include "tests/sequencer/faults/simulated_run.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>

#include "acquisition/record/chain.hpp"
#include "acquisition/record/record.hpp"
#include "acquisition/record/record_files.hpp"
#include "core/clock.hpp"
#include "core/file.hpp"
#include "sequencer/run/block_choice.hpp"
#include "sequencer/run/resume.hpp"
#include "sequencer/run/set_point_path.hpp"

namespace gyrotherm::faults {

namespace {

template <class T>
T expected(Result<T> result) {
  if (result) return std::move(*result);
  fmt::print(stderr, "{}\n", text(result.error()));
  std::abort();
}

std::string from(const std::string& path) { return std::string(GYROTHERM_SOURCE_DIR "/") + path; }

}  // namespace

record::RunInfo make_run_info(const profile::Profile& profile, const rig::RigFile& file) {
  const auto goal = profile.until
                        ? std::optional(record::RunInfo::Goal{profile.until->u_deg_per_h, profile.until->mission, ""})
                        : std::nullopt;
  return run::run_info("", profile, file, 0, kVirtualEpoch, 0, goal);
}

SimulatedSetup simulated_setup(const std::string& profile, const std::string& rig) {
  const auto rig_path = from("profiles/rigs/" + rig + ".toml");
  const auto rig_text = expected(read_text_file(rig_path));
  const auto map_text = expected(read_text_file(from("tests/sequencer/faults/chamber.toml")));
  SimulatedSetup ground;
  ground.profile = expected(profile::parse_profile(expected(read_text_file(from(profile))), profile));
  ground.tcp = expected(rig::parse_rig(rig_text, rig_path, {.chamber_map = map_text, .gyro_model = {}}));
  ground.rtu = ground.tcp;
  ground.rtu.chamber_map = expected(select_link(ground.tcp.chamber_map, drivers::LinkKind::rtu));
  ground.laboratory = expected(simulator::parse_laboratory(rig_text, rig_path));
  return ground;
}

namespace {

/// Delay before a program that could not start is started again.
constexpr std::int64_t kTriesAgainAfter = 30;

bool has(const Schedule& schedule, InjectedFaultKind kind) {
  return std::ranges::any_of(schedule, [&](const auto& fault) { return fault.kind == kind; });
}

/// Returns true if the record must outlive its program. A record in memory ends with its store.
bool must_outlive_program(const Schedule& schedule) {
  return has_faults_of_disk(schedule) || has(schedule, InjectedFaultKind::program_crashes) ||
         has(schedule, InjectedFaultKind::program_stopped);
}

constexpr std::int64_t kShortBatch = 7;  ///< seconds, with a breaking disk
/// Most rows in memory, in the test of that bound.
constexpr std::int64_t kFewRows = 900;

class SimulatedRun {
 public:
  SimulatedRun(const SimulatedSetup& ground, const SimulatedRunSetting& setting);
  ~SimulatedRun() = default;
  SimulatedRun(const SimulatedRun&) = delete;
  SimulatedRun& operator=(const SimulatedRun&) = delete;

  SimulatedRunReport run();

 private:
  void second();
  void advance_second();
  void apply_program_fault(const InjectedFault& fault);
  void attack(const InjectedFault& fault);
  void check_attack_is_noticed();
  [[nodiscard]] Result<run::RunContinuation> prepare_continuation();
  [[nodiscard]] bool is_other_instrument_connected() const;
  void begin_run();
  void resume_run();
  void assemble();
  void live(std::unique_ptr<record::Store> store, const profile::ProfileState& state, std::int64_t first_free,
            const profile::Profile& profile);
  void end_life(std::int64_t down, bool power_cut = false);
  void tick();
  void decide();
  void end(Ending ending);
  [[nodiscard]] std::int64_t clock_second() const { return clock_.now().since_start / kSecond; }
  void judge_record();
  void close();
  [[nodiscard]] Result<record::Record> read_after_closing();
  void end_by_storage_fault(const char* invariant, const Fault& fault, bool excused);

  const SimulatedSetup& ground_;
  const rig::RigFile& file_;
  const SimulatedRunSetting& setting_;
  const std::int64_t sync_every_;
  bool in_memory_;
  std::string path_;
  Disk disk_;
  SimulatedClock clock_;
  Plant plant_;
  FaultInjector injector_;
  Invariants invariants_;
  LogHash hash_;
  std::int64_t second_ = 0, down_ = 0, late_ = 0, asleep_ = 0, lives_ = 0, acknowledged_ = -1;
  bool recorded_ = false, accepted_ = false, left_unwritten_ = false;
  Operators operators_;
  std::vector<std::string> dropped_;               ///< before the resume
  std::map<std::string, std::string> identities_;  ///< at the run's start
  std::optional<Listener> listener_;
  const bool cuts_power_;
  /// Last acknowledged slot before a file was attacked, until the program has noticed it.
  std::optional<std::int64_t> attacked_at_;
  bool spoiled_ = false;  ///< a main file was attacked
  /// File that was attacked on a failing disk; the program may leave it.
  std::optional<int> part_of_failing_disk_;
  std::optional<Ending> ending_;
  std::int64_t longest_backlog_ = 0;
  std::map<std::pair<EventKind, std::string>, Event> events_;  ///< by kind and text
  int parts_ = 1;
  std::optional<MemoryWires> wires_;
  std::unique_ptr<rig::Rig> rig_;
  std::unique_ptr<RecordingStore> store_;
  std::optional<run::RunController> run_controller_;
  /// Second since which a decision is due.
  std::optional<std::int64_t> due_since_;
};

SimulatedRun::SimulatedRun(const SimulatedSetup& ground, const SimulatedRunSetting& setting)
    : ground_(ground),
      file_(setting.seed % 2 == 0 ? ground.tcp : ground.rtu),
      setting_(setting),
      sync_every_(has_faults_of_disk(setting.schedule) ? std::min(setting.sync_every, kShortBatch)
                                                       : setting.sync_every),
      in_memory_(!must_outlive_program(setting.schedule)),
      path_(in_memory_ ? record::kInMemory : fmt::format("{}/run-{}-{}.db", setting.folder, ::getpid(), setting.seed)),
      disk_(has_faults_of_disk(setting.schedule), path_,
            setting.seed % 3 == 0 ? kFewRows : record::StoreOptions().most_rows),
      plant_(file_, ground.laboratory, clock_, setting.seed),
      injector_(setting.schedule, plant_, clock_),
      invariants_(ground.profile, file_, plant_, injector_),
      cuts_power_(has(setting.schedule, InjectedFaultKind::power_cut)) {
  if (has(setting.schedule, InjectedFaultKind::outputs_blocked)) listener_.emplace();
}

void SimulatedRun::advance_second() {
  clock_.advance(kSecond);
  plant_.advance_second();
}

/// Reads the end of the record and prepares the continuation, as the program itself does.
Result<run::RunContinuation> SimulatedRun::prepare_continuation() {
  const auto record = record::read_record(path_);
  if (!record) return failure(record.error());
  const auto last_row = record->time_s.empty() ? Duration{} : from_seconds(record->time_s.back());
  auto on = run::plan_continuation(*record, path_, clock_.now().since_start - last_row, 0);
  if (!on) return on;
  identities_ = record->info.identities;
  if (on->recorded < acknowledged_)
    invariants_.report_violation(
        "P1", second_, fmt::format("the record ends at {}, {} was acknowledged", on->recorded, acknowledged_));
  if (on->profile.text != ground_.profile.text) invariants_.report_violation("I16", second_, "the profile has changed");
  invariants_.take_profile(on->profile);
  invariants_.begin_life(on->recorded);
  invariants_.judge_resume(second_, profile::profile_position(on->profile, on->state));
  return on;
}

/// Returns true if another instrument is connected. Then no operator starts a run.
bool SimulatedRun::is_other_instrument_connected() const {
  return invariants_.is_active(InjectedFaultKind::chamber_exchanged, InjectedFaultKind::chamber_exchanged) ||
         invariants_.is_active(InjectedFaultKind::thermometer_exchanged, InjectedFaultKind::thermometer_exchanged);
}

/// Starts the first program of a run. If it cannot start, it is started again after kTriesAgainAfter.
void SimulatedRun::begin_run() {
  if (disk_.hangs() || is_other_instrument_connected()) return end_life(kTriesAgainAfter);
  clock_.restart_at(-kSecond);
  assemble();
  const auto state = begin(ground_.profile);
  auto info = make_run_info(ground_.profile, file_);
  const auto entrance = [&](const rig::FoundChamber& found) -> Result<Celsius> {
    info.identities = found.identities;
    return demanded_set_point(ground_.profile, state);
  };
  if (const auto prepared = rig_->prepare(entrance, nullptr); !prepared) return end_life(kTriesAgainAfter);
  const bool excused = disk_.is_failing();
  auto store = disk_.create(info);
  if (!store) return end_by_storage_fault("record", store.error(), excused);
  recorded_ = true;
  live(std::move(*store), state, 0, ground_.profile);
}

/// Resumes the run. If the resume rule requires an operator, one inspects the chamber for a minute and accepts, unless
/// another instrument is connected.
void SimulatedRun::resume_run() {
  if (disk_.hangs()) return end_life(kTriesAgainAfter);
  const bool excused = disk_.is_failing();
  auto on = prepare_continuation();
  if (!on) return end_by_storage_fault("I16", on.error(), excused);
  clock_.restart_at(on->start.elapsed - kSecond);
  assemble();
  const auto goal = demanded_set_point(on->profile, on->state);
  run::EntryPoint entry;
  const auto entrance = [&](const rig::FoundChamber& found) -> Result<Celsius> {
    on->interruption.mismatched_instruments = run::compare_identities(identities_, found.identities);
    const auto verdict = judge_reentry(on->interruption, file_.safe_set_point, found.state.air);
    const bool asks = verdict.way == run::Reentry::ask;
    if (asks && (!on->interruption.mismatched_instruments.empty() || !std::exchange(accepted_, true)))
      return failure(FaultKind::interrupted, path_, verdict.why);
    entry = run::entry_at(goal, found.state.air, run::is_in_place(found.state.air, goal, on->interruption.air),
                          file_.chamber_limits);
    return entry.set_point;
  };
  if (const auto prepared = rig_->prepare(entrance, nullptr); !prepared)
    return end_life(prepared.error().kind == FaultKind::interrupted ? kOperatorComesAfter : kTriesAgainAfter);
  accepted_ = false;
  auto store = disk_.reopen();
  if (!store) return end_by_storage_fault("record", store.error(), excused);
  dropped_ = on->start.dropped_units;
  live(std::move(*store), on->state, on->recorded + 1, on->profile);
  if (entry.away) run_controller_->begin_away(entry.set_point, on->why_stopped, on->interruption.air);
}

void SimulatedRun::assemble() {
  wires_.emplace(plant_, clock_);
  rig_ = rig::Rig::assemble(file_, *wires_);
  plant_.chamber().forget();
}

void SimulatedRun::live(std::unique_ptr<record::Store> store, const profile::ProfileState& state,
                        std::int64_t first_free, const profile::Profile& profile) {
  due_since_.reset();
  invariants_.take_profile(profile);
  ++second_;  // preparation takes one second
  ++lives_;
  store_ = std::make_unique<RecordingStore>(std::move(store), hash_);
  const auto now = clock_second();
  if (now > first_free)
    if (auto gap = store_->append_gap(first_free, now - 1, "the program was not running"); !gap)
      invariants_.report_violation("record", second_, text(gap.error()));
  run_controller_.emplace(profile, *rig_, *store_, state, now);
  run_controller_->leave_out(dropped_);
}

/// Handles a storage fault. On a failing disk (`excused`) the fault is expected, and the program is started again
/// later.
void SimulatedRun::end_by_storage_fault(const char* invariant, const Fault& fault, bool excused) {
  if (excused) return end_life(kTriesAgainAfter);
  invariants_.report_violation(invariant, second_, text(fault));
  end(Ending::never_began);
}

/// Ends the life of a program. A power cut loses data that was not synced.
void SimulatedRun::end_life(std::int64_t down, bool power_cut) {
  if (store_) acknowledged_ = store_->acknowledged();
  if (store_ && attacked_at_) return end(Ending::lost_its_record);
  operators_.forget();
  disk_.leave(power_cut, static_cast<unsigned>(setting_.seed + 1000 * static_cast<std::uint64_t>(lives_)), [&] {
    run_controller_.reset();
    store_.reset();
  });
  rig_.reset();
  wires_.reset();
  down_ = std::max<std::int64_t>(down, 1);
  late_ = asleep_ = 0;
  invariants_.skip_tick();
}

void SimulatedRun::end(Ending ending) {
  if (!ending_) ending_ = ending;
}

void SimulatedRun::apply_program_fault(const InjectedFault& fault) {
  if (fault.kind == InjectedFaultKind::disk_fails_once) return disk_.fail_once(static_cast<std::int64_t>(fault.size));
  if (!run_controller_) return;
  switch (fault.kind) {
    case InjectedFaultKind::program_late: late_ = std::max(late_, fault.lasts); return;
    case InjectedFaultKind::machine_sleeps: asleep_ = std::max(asleep_, fault.lasts); return;
    case InjectedFaultKind::program_stopped:
      if (!store_->append_event({clock_.now(), EventKind::interrupted, "stopped by a signal"}) || !store_->sync())
        invariants_.report_violation("record", second_, "a signal could not be recorded");
      return end_life(fault.lasts);
    case InjectedFaultKind::program_crashes: return end_life(fault.lasts);
    case InjectedFaultKind::power_cut: return end_life(fault.lasts, true);
    default: break;
  }
  if (concerns_record(fault.kind)) return attack(fault);
  if (fault.kind == InjectedFaultKind::unit_dropped) {
    const auto unit = static_cast<std::size_t>(fault.target) % file_.units.size();
    return operators_.drop(file_.units[unit].info.name, fault.lasts, *run_controller_, second_);
  }
  operators_.submit(fault, *run_controller_, second_);
}

/// Attacks the record's files. Does nothing before a power cut, because the effect of the cut is only known for files
/// that no other program has changed.
void SimulatedRun::attack(const InjectedFault& fault) {
  if (cuts_power_) return;
  if (!disk_.attack(fault, store_->health().parts)) return;
  attacked_at_ = store_->sync().value_or(-1);
  part_of_failing_disk_ = disk_.is_failing() ? std::optional(store_->health().parts) : std::nullopt;
  if (fault.target == 0) spoiled_ = true;
}

/// P12: checks that the program reports an attack once it has continued in another file. If it had already left the
/// attacked file on a failing disk, no report is required yet: its rows are in memory, and the file is checked when the
/// record is closed.
void SimulatedRun::check_attack_is_noticed() {
  if (!attacked_at_ || store_->sync().value_or(-1) <= *attacked_at_) return;
  attacked_at_.reset();
  const bool was_left = part_of_failing_disk_ && store_->health().parts > *part_of_failing_disk_;
  if (store_->health().damage.empty() && !was_left)
    invariants_.report_violation("P12", second_, "an attack on a file of the record was not reported");
}

void SimulatedRun::tick() {
  operators_.resume_after_wait(*run_controller_, second_);
  invariants_.before_tick();
  const auto slot = clock_second() - 1;
  const auto outcome = run_controller_->tick(slot);
  if (!outcome) return invariants_.report_violation("tick", second_, text(outcome.error())), end(Ending::stopped);
  invariants_.after_tick(second_, *store_, operators_);
  if (const auto broken = operators_.broken_promise(run_controller_->run_state()))
    invariants_.report_violation("I22", second_, *broken);
  const auto health = store_->health();
  longest_backlog_ = std::max(longest_backlog_, health.backlog_s);
  parts_ = std::max(parts_, health.parts);
  if (severity(run_controller_->run_state()) > 0 && run_controller_->overview().cause.empty() &&
      *outcome != run::RunOutcome::complete)
    invariants_.report_violation("I20", second_,
                                 fmt::format("{}, and no reason for it", name(run_controller_->run_state())));
  for (const auto& event : store_->events()) events_.emplace(std::pair(event.kind, event.text), event);
  store_->forget();
  const bool ended = *outcome != run::RunOutcome::going_on;
  if (ended || slot % sync_every_ == sync_every_ - 1)
    if (auto synced = store_->sync(); !synced) invariants_.report_violation("record", second_, text(synced.error()));
  if (*outcome == run::RunOutcome::complete) {
    invariants_.completed(second_);
    end(Ending::complete);
  }
  if (*outcome == run::RunOutcome::made_safe) {
    invariants_.check_end_of_safe_run(second_);
    end(Ending::made_safe);
  }
  if (*outcome == run::RunOutcome::stopped) end(Ending::stopped);
  if (!ended) decide();
}

/// Decides how a run continues that ends by itself. The uncertainties depend only on the number of the decision. The
/// computation takes up to ten minutes, so a hold may have to continue.
void SimulatedRun::decide() {
  if (!run_controller_->awaits_decision()) return due_since_.reset();
  if (!due_since_) due_since_ = second_;
  const auto& profile = run_controller_->profile();
  const auto number = profile.added_blocks.size() + 1;
  constexpr std::int64_t kLongestComputation = 600;
  const auto delay = static_cast<std::int64_t>(setting_.seed * 97 + number * 131) % kLongestComputation;
  if (second_ - *due_since_ < delay) return;
  run::DecisionInputs inputs{.number = static_cast<int>(number),
                             .target_deg_per_h = profile.until->u_deg_per_h,
                             .u_now_deg_per_h = 0.1 / static_cast<double>(number),
                             .used = kSecond * run_controller_->next_slot(),
                             .hold_left = time_left(profile, run_controller_->state())};
  const auto blocks = profile.until->blocks.size();
  for (std::size_t i = 0; i < blocks; ++i)
    inputs.u_after_deg_per_h.push_back(
        inputs.u_now_deg_per_h *
        (0.5 + 0.4 * static_cast<double>((number * 5 + i * 3) % (blocks + 1)) / static_cast<double>(blocks + 1)));
  if (auto done = run_controller_->carry_out(run::decide(profile, inputs)); !done)
    return invariants_.report_violation("I29", second_, text(done.error()));
  due_since_.reset();
  invariants_.take_profile(run_controller_->profile());
}

void SimulatedRun::second() {
  for (const auto& fault : injector_.pass(second_)) apply_program_fault(fault);
  disk_.inject(injector_.active_faults());
  ++second_;
  if (!run_controller_) {
    if (--down_ <= 0) return recorded_ ? resume_run() : begin_run();
    return advance_second();
  }
  rig_->let_pass(1);
  if (asleep_ > 0) return --asleep_, invariants_.skip_tick();
  if (late_ > 0) {
    --late_;
    invariants_.skip_tick();
  } else {
    tick();
  }
  if (listener_) {
    listener_->write_second();
    if (!invariants_.is_active(InjectedFaultKind::outputs_blocked, InjectedFaultKind::outputs_blocked))
      listener_->read();
  }
  disk_.advance(second_);
  check_attack_is_noticed();
}

/// Compares the record with its input: each slot in one row or one gap, and all rows.
void SimulatedRun::judge_record() {
  constexpr std::uint64_t kReadBackEvery = 4;  // share of records in memory
  if (!store_ || (in_memory_ && setting_.seed / 2 % kReadBackEvery != 0)) return;
  if (ending_ == Ending::lost_its_record) return;
  const auto record = in_memory_ ? store_->read_back() : read_after_closing();
  if (attacked_at_) return;  // just before the end
  if (!record) return invariants_.report_violation("record", second_, text(record.error()));
  invariants_.judge_record(second_, *record, acknowledged_, left_unwritten_);
  if (in_memory_) return;
  if (const auto verified = record::verify_record(path_); !verified && !spoiled_)
    invariants_.report_violation("I17", second_, text(verified.error()));
  const bool closed_as_if_whole = record::path_exists(record::manifest_path(path_));
  if (spoiled_ && closed_as_if_whole && !record::verify_record(path_))
    invariants_.report_violation("P12", second_, "a damaged record has a manifest");
}

/// Closes the record as the program does: waits for the disk.
void SimulatedRun::close() {
  constexpr std::int64_t kLongestFinish = 30;
  const bool excused = disk_.is_failing();
  for (auto second = second_; second < second_ + kLongestFinish; ++second) disk_.advance(second);
  const auto synced = store_->sync();
  if (!synced && !excused) invariants_.report_violation("record", second_, text(synced.error()));
  acknowledged_ = store_->acknowledged();
  left_unwritten_ = store_->health().backlog_s > 0;
  if (left_unwritten_ && !excused) invariants_.report_violation("P13", second_, "rows wait although the disk works");
  if (ending_ != Ending::complete || left_unwritten_ || disk_.hangs()) return;
  if (const auto finished = store_->finish(); !finished && !excused && !spoiled_)
    invariants_.report_violation("record", second_, text(finished.error()));
}

Result<record::Record> SimulatedRun::read_after_closing() {
  run_controller_.reset();
  close();
  disk_.leave(false, 0, [&] { store_.reset(); });
  return record::read_record(path_);
}

SimulatedRunReport SimulatedRun::run() {
  Duration planned{};
  for (const auto& segment : ground_.profile.segments) planned += shortest(segment);
  if (ground_.profile.until) planned = ground_.profile.until->longest;
  const auto longest = 2 * (planned / kSecond) + 4 * 3600;
  down_ = 1;
  while (!ending_ && second_ < longest) second();
  if (store_ && (!ending_ || *ending_ != Ending::complete)) (void)store_->sync();
  judge_record();
  if (listener_)
    if (const auto missing = listener_->first_lost_message()) invariants_.report_violation("I23", second_, *missing);
  std::vector<Event> events;
  for (const auto& [key, event] : events_) events.push_back(event);
  return {.violations = invariants_.violations(),
          .ending = ending_.value_or(Ending::ran_out_of_time),
          .seconds = second_,
          .lives = lives_,
          .log_hash = hash_.value(),
          .longest_backlog = longest_backlog_,
          .parts = parts_,
          .seconds_in_state = invariants_.seconds_in_state(),
          .rows = invariants_.rows(),
          .events = std::move(events),
          .blocks = invariants_.profile().added_blocks};
}

}  // namespace

const char* name(Ending ending) {
  switch (ending) {
    case Ending::complete: return "complete";
    case Ending::made_safe: return "made safe";
    case Ending::stopped: return "stopped";
    case Ending::ran_out_of_time: return "ran out of time";
    case Ending::never_began: return "never began";
    case Ending::lost_its_record: return "lost its record";
  }
  return "?";
}

/// I19: a simulated run closes all files that it opened.
SimulatedRunReport carry_out(const SimulatedSetup& ground, const SimulatedRunSetting& setting) {
  const auto open_files = [] {
    const std::filesystem::directory_iterator files("/proc/self/fd");
    return std::distance(begin(files), end(files));
  };
  const auto before = open_files();
  auto report = SimulatedRun(ground, setting).run();
  if (const auto after = open_files(); after != before)
    report.violations.push_back(fmt::format("I19 at the end: {} open files, {} before", after, before));
  return report;
}

}  // namespace gyrotherm::faults
