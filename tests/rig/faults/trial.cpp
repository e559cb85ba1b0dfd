#include "tests/rig/faults/trial.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>

#include "acquisition/record.hpp"
#include "acquisition/sqlite.hpp"
#include "acquisition/status.hpp"
#include "core/text_file.hpp"

namespace gyrotherm {
namespace {

constexpr Duration kSecond = std::chrono::seconds(1);
constexpr std::int64_t kTriesAgainAfter = 30;  ///< a program that could not begin

template <class T>
T expected(Result<T> result) {
  if (result) return std::move(*result);
  fmt::print(stderr, "{}\n", text(result.error()));
  std::abort();
}

std::string from(const std::string& path) { return std::string(GYROTHERM_SOURCE_DIR "/") + path; }

class Trial {
 public:
  Trial(const TrialGround& ground, const TrialSetting& setting);
  ~Trial() { std::filesystem::remove(path_), std::filesystem::remove(status_path(path_)); }
  Trial(const Trial&) = delete;
  Trial& operator=(const Trial&) = delete;

  TrialReport run();

 private:
  void second();
  void pass_second();
  void obey(const Mishap& mishap);
  void begin_life();
  [[nodiscard]] bool take_up(std::int64_t& first);
  void end_life(std::int64_t down);
  void tick();
  void end(Ending ending);
  [[nodiscard]] std::int64_t clock_second() const { return clock_.now().since_start / kSecond; }
  void judge_record();
  void ask_record(const std::string& question, std::int64_t expected_answer);

  const TrialGround& ground_;
  const RigFile& file_;
  const TrialSetting& setting_;
  std::string path_;
  TrialClock clock_;
  Plant plant_;
  Disturbance disturbance_;
  Laws laws_;
  LogHash hash_;
  std::int64_t second_ = 0, down_ = 0, late_ = 0, lives_ = 0, acknowledged_ = -1;
  bool recorded_ = false;
  std::optional<Ending> ending_;
  std::optional<MemoryWires> wires_;
  std::unique_ptr<Rig> rig_;
  std::unique_ptr<WitnessStore> store_;
  State state_;
  std::optional<Experiment> experiment_;
};

Trial::Trial(const TrialGround& ground, const TrialSetting& setting)
    : ground_(ground),
      file_(setting.seed % 2 == 0 ? ground.tcp : ground.rtu),
      setting_(setting),
      path_(fmt::format("{}/trial-{}.db", setting.folder, setting.seed)),
      plant_(file_, ground.world, clock_, setting.seed),
      disturbance_(setting.schedule, plant_, clock_),
      laws_(ground.profile, file_, plant_, disturbance_) {
  std::filesystem::remove(path_);
}

RunInfo info_of(const TrialGround& ground, const RigFile& file) {
  RunInfo info;
  info.id = "0";
  info.profile_name = ground.profile.name;
  info.profile_text = ground.profile.text;
  info.rig_text = file.text;
  info.chamber_map_text = file.chamber_map.text;
  info.simulated = true;
  info.started_utc = kVirtualEpoch;
  info.thermometers = channels_of(file);
  info.gyro = file.gyro.info;
  return info;
}

void Trial::pass_second() {
  clock_.advance(kSecond);
  plant_.pass_second();
}

/// Where the record ends, and how the profile goes on from there.
bool Trial::take_up(std::int64_t& first) {
  const auto record = read_record(path_);
  if (!record) return laws_.broken("record", second_, text(record.error())), false;
  const auto last_row = record->slot.empty() ? -1 : record->slot.back();
  const auto last_gap = record->gaps.empty() ? -1 : record->gaps.back().last;
  const auto recorded = std::max(last_row, last_gap);
  if (recorded < acknowledged_)
    laws_.broken("P1", second_, fmt::format("the record ends at {}, {} was acknowledged", recorded, acknowledged_));
  state_ = begin(ground_.profile);
  if (last_row >= 0) {
    const auto last = state_of(ground_.profile, record->progress.back());
    if (!last) return laws_.broken("I16", second_, text(last.error())), false;
    const Celsius air{record->chamber_air_c.back()};
    state_ = next(ground_.profile, *last,
                  {.elapsed = kSecond, .air = air.value == air.value ? std::optional(air) : std::nullopt});
  }
  laws_.life_begins(recorded);
  first = recorded + 1;
  return true;
}

void Trial::begin_life() {
  std::int64_t first = 0;
  if (!recorded_) {
    clock_.restart_at(-kSecond);
    state_ = begin(ground_.profile);
  } else if (!take_up(first)) {
    return end(Ending::never_began);
  }
  wires_.emplace(plant_, clock_);
  rig_ = Rig::assemble(file_, *wires_);
  plant_.chamber().forget();
  if (const auto prepared = rig_->prepare(command(ground_.profile, state_)); !prepared)
    return end_life(kTriesAgainAfter);
  ++second_;  // preparing takes one
  auto store = recorded_ ? Store::reopen(path_) : Store::create(path_, info_of(ground_, file_));
  if (!store) return laws_.broken("record", second_, text(store.error())), end(Ending::never_began);
  store_ = std::make_unique<WitnessStore>(std::move(*store), hash_);
  recorded_ = true;
  ++lives_;
  const auto now = clock_second();
  if (now > first)
    if (auto gap = store_->append_gap(first, now - 1, "the program was not running"); !gap)
      laws_.broken("record", second_, text(gap.error()));
  experiment_.emplace(ground_.profile, *rig_, *store_, state_, now);
}

/// What was not synced is lost with it.
void Trial::end_life(std::int64_t down) {
  if (store_) acknowledged_ = store_->acknowledged();
  experiment_.reset();
  store_.reset();
  rig_.reset();
  wires_.reset();
  down_ = std::max<std::int64_t>(down, 1);
  late_ = 0;
  laws_.no_tick();
}

void Trial::end(Ending ending) {
  if (!ending_) ending_ = ending;
}

void Trial::obey(const Mishap& mishap) {
  if (!experiment_) return;
  switch (mishap.kind) {
    case MishapKind::program_late: late_ = std::max(late_, mishap.lasts); return;
    case MishapKind::program_stopped:
      if (!store_->append_event({clock_.now(), EventKind::interrupted, "stopped by a signal"}) || !store_->sync())
        laws_.broken("record", second_, "a signal could not be recorded");
      return end_life(mishap.lasts);
    case MishapKind::program_crashes: return end_life(mishap.lasts);
    default: return;
  }
}

void Trial::tick() {
  laws_.before_tick();
  const auto slot = clock_second() - 1;
  const auto outcome = experiment_->tick(slot);
  if (!outcome) return laws_.broken("tick", second_, text(outcome.error())), end(Ending::stopped);
  laws_.after_tick(second_, *store_);
  store_->forget();
  const bool ended = *outcome != Outcome::going_on;
  if (ended || slot % setting_.sync_every == setting_.sync_every - 1)
    if (auto synced = store_->sync(); !synced) laws_.broken("record", second_, text(synced.error()));
  if (*outcome == Outcome::complete) {
    laws_.completed(second_);
    if (auto finished = store_->finish(); !finished) laws_.broken("record", second_, text(finished.error()));
    end(Ending::complete);
  }
  if (*outcome == Outcome::made_safe) end(Ending::made_safe);
}

void Trial::second() {
  for (const auto& mishap : disturbance_.pass(second_)) obey(mishap);
  ++second_;
  if (!experiment_) {
    if (--down_ <= 0) return begin_life();
    return pass_second();
  }
  rig_->let_pass(1);
  if (late_ > 0) {
    --late_;
    return laws_.no_tick();
  }
  tick();
}

void Trial::ask_record(const std::string& question, std::int64_t expected_answer) {
  auto database = Database::open(path_, Access::read_only, 0);
  const auto found = database ? database->ask_integer(question, -1) : Result<std::int64_t>(-1);
  if (!found || *found != expected_answer)
    laws_.broken("I10", second_,
                 fmt::format("\"{}\" is {}, expected {}", question, found ? *found : -2, expected_answer));
}

/// What the record really holds, against what it was given.
void Trial::judge_record() {
  if (!recorded_) return;
  const auto rows = static_cast<std::int64_t>(laws_.rows().size());
  ask_record("SELECT count(*) FROM sample", rows);
  ask_record("SELECT coalesce(sum(last - first + 1), 0) FROM gap", laws_.gap_seconds());
  if (rows > 0)
    ask_record("SELECT max(max(slot), coalesce((SELECT max(last) FROM gap), -1)) + 1 FROM sample",
               rows + laws_.gap_seconds());
}

TrialReport Trial::run() {
  Duration planned{};
  for (const auto& segment : ground_.profile.segments) planned += shortest(segment);
  const auto longest = 2 * (planned / kSecond) + 4 * 3600;
  down_ = 1;
  while (!ending_ && second_ < longest) second();
  if (store_ && !ending_) (void)store_->sync();
  experiment_.reset();
  rig_.reset();
  store_.reset();
  judge_record();
  return {.violations = laws_.violations(),
          .ending = ending_.value_or(Ending::ran_out_of_time),
          .seconds = second_,
          .lives = lives_,
          .log_hash = hash_.value(),
          .seconds_in_state = laws_.seconds_in_state(),
          .rows = laws_.rows()};
}

}  // namespace

TrialGround trial_ground(const std::string& profile) {
  const auto rig_path = from("profiles/rigs/virtual-reference.toml");
  const auto rig_text = expected(read_text_file(rig_path));
  const auto map_text = expected(read_text_file(from("tests/rig/faults/chamber.toml")));
  TrialGround ground;
  ground.profile = expected(parse_profile(expected(read_text_file(from(profile))), profile));
  ground.tcp = expected(parse_rig(rig_text, rig_path, {.chamber_map = map_text, .gyro_model = {}}));
  ground.rtu = ground.tcp;
  ground.rtu.chamber_map = expected(on_link(ground.tcp.chamber_map, LinkKind::rtu));
  ground.world = expected(parse_world(rig_text, rig_path));
  return ground;
}

const char* name(Ending ending) {
  switch (ending) {
    case Ending::complete: return "complete";
    case Ending::made_safe: return "made safe";
    case Ending::stopped: return "stopped";
    case Ending::ran_out_of_time: return "ran out of time";
    case Ending::never_began: return "never began";
  }
  return "?";
}

TrialReport carry_out(const TrialGround& ground, const TrialSetting& setting) { return Trial(ground, setting).run(); }

}  // namespace gyrotherm
