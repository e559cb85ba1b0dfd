#include "drivers/chamber/modbus_chamber.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "drivers/chamber/chamber_status.hpp"
#include "drivers/chamber/item_exchange.hpp"
#include "drivers/chamber/set_point_tolerance.hpp"
#include "drivers/chamber/upload.hpp"

namespace gyrotherm {

namespace {

class ModbusChamber final : public Chamber {
 public:
  ModbusChamber(RegisterMap map, std::unique_ptr<Registers> registers, std::unique_ptr<Pauses> pauses);

  Result<std::string> identify() override;
  Result<ChamberState> read() override;
  Result<void> head_for(Celsius target) override;
  Result<void> start() override;
  Result<void> stop() override;
  Result<void> perform(const std::string& command) override;
  void insist() override { registers_->insist(); }
  Result<std::string> upload(const ChamberProgram& program) override;
  Result<void> start_program() override;

 private:
  [[nodiscard]] std::vector<const RegisterItem*> core_items() const;
  [[nodiscard]] Result<void> check_number(double found) const;
  [[nodiscard]] Result<ChamberState> look();
  [[nodiscard]] Result<Snapshot> look_at_status();
  [[nodiscard]] ChamberStatus judge(const Snapshot& core, const Snapshot& more) const;
  [[nodiscard]] Result<void> learn_limits();
  [[nodiscard]] Result<void> check_limits(Celsius target);
  [[nodiscard]] Result<void> end_foreign_program();
  [[nodiscard]] Result<void> switch_to(std::int64_t code);

  RegisterMap map_;
  std::unique_ptr<Registers> registers_;
  std::unique_ptr<Pauses> pauses_;
  ItemExchange items_;
  const RegisterItem& air_;
  const RegisterItem& set_point_;
  const RegisterItem* identity_;
  std::vector<ReadSpan> core_plan_;
  std::vector<ReadSpan> status_plan_;  ///< without what the unit refused
  int until_status_ = 0;               ///< reads until the status is asked for
  ChamberStatus status_;
  std::optional<Celsius> lowest_, highest_;  ///< as the controller has them
  bool limits_known_ = false;
  std::optional<int> uploaded_;  ///< number of the program
  bool program_runs_ = false;    ///< that was started from here
  bool to_be_seen_ = false;      ///< the set point that was sent shall show at the next reading
  double sent_c_ = std::numeric_limits<double>::quiet_NaN();  ///< the last set point that was acknowledged
};

ModbusChamber::ModbusChamber(RegisterMap map, std::unique_ptr<Registers> registers, std::unique_ptr<Pauses> pauses)
    : map_(std::move(map)),
      registers_(std::move(registers)),
      pauses_(std::move(pauses)),
      items_(map_, *registers_, *pauses_),
      air_(items_.item("air_temperature")),
      set_point_(items_.item("set_point")),
      identity_(map_.identity ? &items_.item(map_.identity->item) : nullptr) {
  const auto at_most = map_.link.modbus.read_at_most;
  core_plan_ = plan_reads(core_items(), map_.one_block || map_.holes, at_most);
  auto status = status_items(map_);
  const auto context = items_.needed_by(status);
  status.insert(status.end(), context.begin(), context.end());
  status_plan_ = plan_reads(status, map_.holes, at_most);
}

/// What each read() wants.
std::vector<const RegisterItem*> ModbusChamber::core_items() const {
  std::vector<const RegisterItem*> core{&air_};
  if (set_point_.readable) core.push_back(&set_point_);
  if (map_.one_block && identity_) core.push_back(identity_);
  const auto context = items_.needed_by(core);
  core.insert(core.end(), context.begin(), context.end());
  return core;
}

Result<void> ModbusChamber::check_number(double found) const {
  const auto& print = *map_.identity;
  const auto masked = [&](double value) {
    return static_cast<std::uint32_t>(static_cast<std::int64_t>(value)) & print.mask;
  };
  constexpr std::uint32_t kAllBits = 0xFFFFFFFF;
  if (print.mask == kAllBits ? found == print.value : masked(found) == masked(print.value)) return {};
  return failure(FaultKind::mismatch, place(*identity_),
                 fmt::format("holds {}, expected {} of a {} {}", found, print.value, map_.vendor, map_.name));
}

Result<std::string> ModbusChamber::identify() {
  limits_known_ = false;
  until_status_ = 0;
  const auto who = fmt::format("{} {}", map_.vendor, map_.name);
  if (identity_ && identity_->type == RegisterType::text) {
    const auto found = items_.read_text(*identity_);
    if (!found) return found;
    if (matches(map_.identity->pattern, *found)) return fmt::format("{} ({} = {})", who, identity_->name, *found);
    return failure(FaultKind::mismatch, place(*identity_),
                   fmt::format("reads \"{}\", expected \"{}\"", *found, map_.identity->pattern));
  }
  const auto found = items_.read(identity_ ? *identity_ : air_);
  if (!found) return failure(found.error());
  if (!identity_) return who + " (its map has no fingerprint to check)";
  if (auto same = check_number(*found); !same) return failure(std::move(same.error()));
  return fmt::format("{} ({} = {})", who, identity_->name, *found);
}

Result<Snapshot> ModbusChamber::look_at_status() {
  Snapshot found;
  for (auto span = status_plan_.begin(); span != status_plan_.end();) {
    auto words = registers_->read(span->function, span->first, span->count);
    if (!words && words.error().kind == FaultKind::refused) {
      span = status_plan_.erase(span);
      continue;
    }
    if (!words) return failure(std::move(words.error()));
    found.add(*span, std::move(*words));
    ++span;
  }
  return found;
}

ChamberStatus ModbusChamber::judge(const Snapshot& core, const Snapshot& more) const {
  return status_of(map_, [&](const std::string& name) -> std::optional<double> {
    const auto& item = items_.item(name);
    for (const auto* snapshot : {&more, &core}) {
      if (snapshot->words_of(item).empty()) continue;
      const auto value = items_.value_in(*snapshot, item);
      return value ? std::optional(*value) : std::nullopt;
    }
    return std::nullopt;
  });
}

Result<ChamberState> ModbusChamber::look() {
  const auto core = items_.look(core_plan_);
  if (!core) return failure(core.error());
  if (map_.one_block && identity_) {
    const auto same = items_.value_in(*core, *identity_).and_then([&](double found) { return check_number(found); });
    if (!same) return failure(same.error());
  }
  const auto air = items_.value_in(*core, air_);
  if (!air) return failure(air.error());
  const auto set_point = set_point_.readable ? items_.value_in(*core, set_point_) : Result<double>(sent_c_);
  if (!set_point) return failure(set_point.error());
  const double as_written = set_point_.tolerance.value_or(std::max(finest_step(set_point_), 1e-3));
  if (std::exchange(to_be_seen_, false) && std::abs(*set_point - sent_c_) > as_written)
    return failure(FaultKind::mismatch, place(set_point_),
                   fmt::format("reads {} after {} was written", *set_point, sent_c_));
  const bool asks = map_.status_every > 0 && !(map_.states.empty() && map_.alarms.empty());
  if (asks && until_status_-- <= 0) {
    const auto more = look_at_status();
    if (!more) return failure(more.error());
    status_ = judge(*core, *more);
    until_status_ = map_.status_every - 1;
  }
  return ChamberState{{*air}, {*set_point}, status_.activity, status_.alarms, status_.must_stop};
}

Result<ChamberState> ModbusChamber::read() {
  auto state = look();
  if (!state) until_status_ = 0;
  return state;
}

Result<void> ModbusChamber::learn_limits() {
  if (limits_known_) return {};
  const auto limit = [&](const std::string& name, std::optional<Celsius> fixed) -> Result<std::optional<Celsius>> {
    if (name.empty()) return fixed;
    const auto found = items_.read(items_.item(name));
    if (!found) return failure(found.error());
    return std::optional(Celsius{*found});
  };
  const auto lowest = limit(map_.limits.lowest_item, map_.limits.lowest);
  if (!lowest) return failure(lowest.error());
  const auto highest = limit(map_.limits.highest_item, map_.limits.highest);
  if (!highest) return failure(highest.error());
  lowest_ = *lowest;
  highest_ = *highest;
  limits_known_ = true;
  return {};
}

Result<void> ModbusChamber::check_limits(Celsius target) {
  if (auto known = learn_limits(); !known) return known;
  const auto refuse = [&](const char* side, Celsius limit) {
    return failure(FaultKind::out_of_range, place(set_point_),
                   fmt::format("{:g} °C is {} the controller's limit of {:g} °C", target.value, side, limit.value));
  };
  if (lowest_ && target < *lowest_) return refuse("below", *lowest_);
  if (highest_ && target > *highest_) return refuse("above", *highest_);
  return {};
}

/// Before the first set point: a program that somebody else started (or this program, before it was restarted) would
/// overrule it.
Result<void> ModbusChamber::end_foreign_program() {
  if (!std::isnan(sent_c_) || !map_.sequences.contains("stop_program") || map_.states.empty()) return {};
  until_status_ = 0;
  const auto state = look();
  if (!state) return failure(state.error());
  switch (state->activity) {
    case ChamberActivity::program:
    case ChamberActivity::ramping:
    case ChamberActivity::soaking:
    case ChamberActivity::waiting:
    case ChamberActivity::holding: return perform("stop_program");
    default: return {};
  }
}

Result<void> ModbusChamber::head_for(Celsius target) {
  if (auto allowed = check_limits(target); !allowed) return allowed;
  if (auto free = end_foreign_program(); !free) return free;
  if (program_runs_) {
    if (auto ended = perform("stop_program"); !ended) return ended;
    program_runs_ = false;
  }
  auto done = items_.write(set_point_, target.value);
  if (done) sent_c_ = target.value;
  to_be_seen_ = done && set_point_.seen_later && set_point_.readable;
  return done;
}

Result<void> ModbusChamber::switch_to(std::int64_t code) {
  auto commanded = items_.item(map_.control->commanded);
  commanded.seen_in = map_.control->active;
  return items_.write(commanded, static_cast<double>(code));
}

/// A program that ran in the controller may have taken the set point with it.
Result<void> ModbusChamber::start() {
  if (!map_.sequences.contains("start")) return map_.control ? switch_to(map_.control->on) : Result<void>{};
  if (auto started = perform("start"); !started) return started;
  if (!set_point_.readable || std::isnan(sent_c_)) return {};
  const auto now = items_.read(set_point_);
  if (!now) return failure(now.error());
  const bool kept = std::abs(*now - sent_c_) <= set_point_tolerance(map_).value;
  return kept ? Result<void>{} : head_for({sent_c_});
}

Result<void> ModbusChamber::stop() {
  if (map_.sequences.contains("stop")) return perform("stop");
  if (map_.control) return switch_to(map_.control->off);
  return failure(FaultKind::refused, "chamber stop", "its register map has neither a command \"stop\" nor [control]");
}

Result<void> ModbusChamber::perform(const std::string& command) {
  until_status_ = 0;
  const auto found = map_.sequences.find(command);
  if (found != map_.sequences.end()) return items_.perform(found->second, {});
  return failure(FaultKind::refused, "chamber " + command,
                 fmt::format("its register map has no command \"{}\"", command));
}

Result<std::string> ModbusChamber::upload(const ChamberProgram& program) {
  if (!map_.sequences.contains("start_program") || !map_.sequences.contains("stop_program"))
    return failure(FaultKind::refused, "chamber upload",
                   "its register map does not say how a program is started and ended");
  for (const auto& step : program.steps)
    for (const auto target : {step.start, step.target})
      if (auto allowed = check_limits(target); !allowed) return failure(allowed.error());
  const auto report = upload_program(map_, items_, *registers_, *pauses_, program);
  if (!report) return failure(report.error());
  uploaded_ = report->program;
  return in_words(*report);
}

Result<void> ModbusChamber::start_program() {
  if (!uploaded_) return failure(FaultKind::refused, "chamber start_program", "no program was uploaded");
  until_status_ = 0;
  auto started =
      items_.perform(map_.sequences.at("start_program"), {.program = *uploaded_, .step = map_.memory->first_step});
  program_runs_ = true;  // even if it only may: head_for() is to end it
  return started;
}

}  // namespace

std::unique_ptr<Chamber> make_modbus_chamber(RegisterMap map, std::unique_ptr<Registers> registers,
                                             std::unique_ptr<Pauses> pauses) {
  return std::make_unique<ModbusChamber>(std::move(map), std::move(registers), std::move(pauses));
}

}  // namespace gyrotherm
