#include "app/conduct.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>

#include "acquisition/calibration.hpp"
#include "acquisition/record.hpp"
#include "acquisition/store.hpp"
#include "app/drive.hpp"
#include "app/run_info.hpp"
#include "core/text_file.hpp"
#include "rig/experiment.hpp"
#include "rig/one_core.hpp"
#include "rig/rig.hpp"

namespace gyrotherm {
namespace {

constexpr Duration kLongestUnattendedGap = std::chrono::seconds(120);
constexpr Duration kShortestGap = std::chrono::seconds(1);  ///< preparing a rig takes a second
constexpr Kelvins kResumeBand{2};

/// Ends a run as its outcome says.
Result<void> conclude(Console& console, const Experiment& experiment, Store& store, const std::string& path,
                      Outcome outcome) {
  if (outcome == Outcome::made_safe) return failure(FaultKind::interlock, path, experiment.end_cause());
  if (auto finished = store.finish(); !finished) return finished;
  console.say(fmt::format("{}: recorded, {} s from start to end", path, experiment.next_slot()));
  return {};
}

Result<void> drive(Console& console, const Profile& profile, Experiment& experiment, Rig& rig, Store& store,
                   const std::string& path) {
  const auto outcome = rig.file().simulated ? drive_virtual(console, profile, experiment, rig, store)
                                            : drive_real(console, profile, experiment, rig, store);
  if (!outcome) {
    if (outcome.error().kind == FaultKind::interrupted)
      return failure(
          FaultKind::interrupted, path,
          fmt::format("stopped after {} s, the chamber {}; \"gyrotherm resume {}\" goes on", experiment.next_slot(),
                      experiment.is_left_to_the_controller() ? "goes on with its program" : "holds its set point",
                      path));
    experiment.make_safe(text(outcome.error()));
    return failure(outcome.error().kind, path, experiment.end_cause());
  }
  return conclude(console, experiment, store, path, *outcome);
}

/// The set point of every second up to and with `last`, as the chamber had it (where it did not answer: as the profile
/// asked). A gap was spent at the set point of the second that ended it.
std::vector<Celsius> set_points_of(const Record& record, std::int64_t last) {
  std::vector<Celsius> points;
  for (std::size_t i = 0; i < record.slot.size() && record.slot[i] <= last; ++i) {
    const auto read_back = record.chamber_set_point_c[i];
    points.resize(static_cast<std::size_t>(record.slot[i] + 1),
                  {std::isnan(read_back) ? record.set_point_c[i] : read_back});
  }
  return points;
}

/// How long ago the record's last second was.
Duration time_since_last(const Record& record) {
  const auto last = record.info.started_utc + from_seconds(record.time_s.empty() ? 0 : record.time_s.back());
  return std::max(Duration{}, SteadyClock().now().utc - last);
}

/// Where an interrupted run stood, and how it goes on.
struct Continuation {
  RigFile rig;
  Profile profile;
  State state;               ///< of the first second after the gap
  std::int64_t last_slot{};  ///< that has a sample; −1: none
  std::int64_t recorded{};   ///< the last that has a sample or lies in a gap; −1: none
  Celsius last_air{NAN};
  bool made_safe{};  ///< an interlock ended it
  Duration gap{};
  RigStart start;
};

/// Every second of the virtual world before the one that preparing takes: that first one of the run, the recorded ones,
/// the gap.
std::vector<Celsius> replay_of(const Record& record, const Continuation& on) {
  if (on.last_slot < 0) return {};
  auto points = set_points_of(record, on.last_slot);
  points.insert(points.begin(), record.set_point_c.empty() ? Celsius{} : Celsius{record.set_point_c.front()});
  points.resize(points.size() + static_cast<std::size_t>(on.gap / std::chrono::seconds(1)) - 1,
                command(on.profile, on.state));
  return points;
}

Result<Continuation> continuation(const std::string& path, const ResumeOptions& options) {
  const auto record = read_record(path);
  if (!record) return failure(record.error());
  if (record->finished) return failure(FaultKind::usage, path, "this run has finished; there is nothing to resume");
  if (record->info.imported) return failure(FaultKind::usage, path, "an imported record cannot be resumed");
  const auto& info = record->info;
  auto rig = parse_rig(
      info.rig_text, path + " (rig)",
      {.chamber_map = info.chamber_map_text, .gyro_model = info.gyro_model_text, .gyro_stream = info.gyro_stream_text});
  if (!rig) return failure(rig.error());
  auto profile = parse_profile(record->info.profile_text, path + " (profile)");
  if (!profile) return failure(profile.error());

  Continuation on{.rig = std::move(*rig), .profile = std::move(*profile), .state = {}, .start = {}};
  on.last_slot = record->slot.empty() ? -1 : record->slot.back();
  on.recorded = record->gaps.empty() ? on.last_slot : std::max(on.last_slot, record->gaps.back().last);
  on.made_safe = !record->events.empty() && record->events.back().event.kind == EventKind::interlock;
  on.state = begin(on.profile);
  if (on.last_slot >= 0) {
    const auto last = state_of(on.profile, record->progress.back());
    if (!last) return failure(last.error());
    on.last_air = {record->chamber_air_c.back()};
    const auto air = std::isnan(on.last_air.value) ? std::nullopt : std::optional(on.last_air);
    on.state = next(on.profile, *last, {.elapsed = std::chrono::seconds(1), .air = air});
  }
  const auto down = on.rig.simulated ? std::max(options.gap, kShortestGap) : time_since_last(*record);
  // A virtual world starts with its first second; a real run's clock has gone on since it was made.
  const bool not_begun = on.rig.simulated && on.last_slot < 0;
  on.gap = not_begun ? Duration{} : std::chrono::floor<std::chrono::seconds>(down);
  on.start.seed = {.gyro = record->info.seed, .run = run_number(record->info.profile_text)};
  const auto since_last = on.last_slot + 1 + on.gap / std::chrono::seconds(1);
  on.start.already = std::chrono::seconds(std::max(since_last, on.recorded + 1));
  if (on.rig.simulated) on.start.replay = replay_of(*record, on);
  return on;
}

/// The resume rule: only an operator goes on after a long gap, or with the air elsewhere.
Result<void> allow(const Continuation& on, const ChamberState& now, const std::string& path, bool accepted) {
  if (accepted || on.last_slot < 0) return {};
  const auto refuse = [&](std::string why) {
    return failure(FaultKind::interrupted, path,
                   std::move(why) + "; look at the chamber, then \"gyrotherm resume --accept\"");
  };
  if (on.made_safe) return refuse("an interlock ended this run");
  if (on.gap > kLongestUnattendedGap)
    return refuse(fmt::format("down for {}, longer than {}", spoken(on.gap), spoken(kLongestUnattendedGap)));
  if (!std::isnan(on.last_air.value) && abs(now.air - on.last_air) > kResumeBand)
    return refuse(fmt::format("the air is at {:.2f} °C, it was at {:.2f} °C", now.air.value, on.last_air.value));
  return {};
}

/// Says, here and in the record, which calibrations are past their day.
void warn_of_calibrations(Console& console, Experiment& experiment, const Rig& rig) {
  const auto channels = channels_of(rig.file());
  for (const auto& line : overdue_calibrations(channels, rig.clock().now().utc)) {
    console.say("warning: " + line);
    experiment.note(EventKind::note, line);
  }
}

Result<void> record_absence(Store& store, std::int64_t first, std::int64_t last) {
  return last < first ? Result<void>{} : store.append_gap(first, last, "the program was not running");
}

}  // namespace

Result<Profile> read_profile(const std::string& path, const ChamberLimits& limits) {
  const auto text = read_text_file(path);
  if (!text) return failure(text.error());
  auto profile = parse_profile(*text, path);
  if (!profile) return profile;
  if (auto checked = check_profile(*profile, limits); !checked) return failure(checked.error());
  return profile;
}

Result<void> start_run(Console& console, const Profile& profile, const RigFile& file, std::uint64_t seed,
                       const std::string& path, bool upload) {
  std::optional<OneCore> one_core;
  if (file.simulated) one_core.emplace();
  if (std::error_code error;
      std::filesystem::exists(path, error))  // before anything moves; Store::create would refuse too
    return failure(FaultKind::storage, path, "exists already, and a record is never overwritten");
  auto rig =
      Rig::assemble(file, {.seed = {.gyro = seed, .run = run_number(profile.text)}, .already = {}, .replay = {}});
  if (!rig) return failure(rig.error());
  if (upload && !file.chamber_map.memory)
    return failure(FaultKind::usage, "--upload",
                   fmt::format("the register map of the {} describes no profile memory", file.chamber_map.name));
  const auto first = begin(profile);
  const auto program = upload ? program_of(profile) : Result<ChamberProgram>();
  if (!program) return failure(program.error());
  const auto names = (*rig)->prepare(command(profile, first), {}, upload ? &*program : nullptr);
  if (!names) return failure(names.error());
  for (const auto& who : *names) console.detail(who);
  auto store = Store::create(path, run_info(profile, file, seed, (*rig)->clock().now().utc));
  if (!store) return failure(store.error());
  Experiment experiment(profile, **rig, **store, first, 0);
  experiment.note(EventKind::started, profile.name);
  if (upload) {
    experiment.leave_to_the_controller();
    experiment.note(EventKind::note, "the controller carries the profile out: " + names->back());
  }
  warn_of_calibrations(console, experiment, **rig);
  return drive(console, profile, experiment, **rig, **store, path);
}

Result<void> resume_run(Console& console, const std::string& path, const ResumeOptions& options) {
  auto on = continuation(path, options);
  if (!on) return failure(on.error());
  std::optional<OneCore> one_core;
  if (on->rig.simulated) one_core.emplace();
  auto rig = Rig::assemble(on->rig, on->start);
  if (!rig) return failure(rig.error());
  const auto permit = [&](const ChamberState& now) { return allow(*on, now, path, options.accept); };
  if (auto names = (*rig)->prepare(command(on->profile, on->state), permit); !names) return failure(names.error());
  auto store = Store::reopen(path);
  if (!store) return failure(store.error());
  const auto first = (*rig)->clock().now().since_start / std::chrono::seconds(1);
  if (auto recorded = record_absence(**store, on->recorded + 1, first - 1); !recorded) return recorded;
  Experiment experiment(on->profile, **rig, **store, on->state, first);
  const auto text = fmt::format("resumed after {}", spoken(on->gap));
  console.say(fmt::format("{}: {} at second {}", path, text, first));
  experiment.note(EventKind::resumed, text);
  warn_of_calibrations(console, experiment, **rig);
  return drive(console, on->profile, experiment, **rig, **store, path);
}

}  // namespace gyrotherm
