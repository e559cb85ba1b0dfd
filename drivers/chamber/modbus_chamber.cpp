// SPDX-License-Identifier: Apache-2.0
#include "drivers/chamber/modbus_chamber.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <functional>
#include <limits>
#include <string_view>
#include <utility>

#include "core/humidity.hpp"
#include "drivers/chamber/item_exchange.hpp"
#include "drivers/chamber/program.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/chamber/status_turns.hpp"
#include "drivers/chamber/text_registers.hpp"

namespace gyrotherm::drivers {
namespace {

/// Replaces underscores: "door_open" → "door open".
std::string replace_underscores(std::string name) {
  std::ranges::replace(name, '_', ' ');
  return name;
}

/// Returns the text of an alarm: the rule's text, or the names of the item's codes or bits.
std::string alarm_text(const AlarmRule& rule, const RegisterItem& item, double value) {
  if (!rule.text.empty()) return rule.text;
  if (item.flags.empty())
    return fmt::format("{}: {}", replace_underscores(item.name), replace_underscores(meaning(item, value)));
  const auto word = lower_bits(value).value_or(0) & rule.when.bits;
  std::vector<std::string> names;
  for (const auto& [name, bit] : item.flags)
    if ((word >> bit & 1U) != 0) names.push_back(replace_underscores(name));
  return fmt::format("{}", fmt::join(names, ", "));
}

struct ChamberStatus {
  ChamberActivity activity = ChamberActivity::unknown;
  std::string unmatched;            ///< values that fit no state
  std::vector<std::string> alarms;  ///< most severe first
  bool must_stop{};
  std::optional<double> humidity_percent;
  std::optional<Celsius> dew_point;  ///< measured, not computed
};

/// Returns the value of the item with this name, or nothing if the value is unknown. Rules about an unknown value do
/// not apply.
using ItemValue = std::function<std::optional<double>(const std::string&)>;

/// Describes the values of the items in the rules of the states, each once: "mode 7, run \"AUTO\" (no name in codes)".
std::string describe_state_values(const RegisterMap& map, const ItemValue& value) {
  std::vector<std::string> names, texts;
  for (const auto& rule : map.states) {
    const auto& name = rule.when.item;
    const auto found = value(name);
    if (!found || std::ranges::find(names, name) != names.end()) continue;
    names.push_back(name);
    const auto& item = *map.find(name);
    texts.push_back(
        fmt::format("{} {}", name, item.codes.empty() ? fmt::format("{:g}", *found) : meaning(item, *found)));
  }
  return fmt::format("{}", fmt::join(texts, ", "));
}

/// Fails with corrupted if a rule cannot be evaluated, because the value of its item has no bits.
Result<void> check_values(const RegisterMap& map, const ItemValue& value) {
  const auto check = [&](const Condition& when) -> Result<void> {
    const auto found = value(when.item);
    if (!found) return {};
    const auto fits = evaluate(when, *map.find(when.item), *found);
    return fits ? Result<void>{} : failure(fits.error());
  };
  for (const auto& rule : map.states)
    if (auto good = check(rule.when); !good) return good;
  for (const auto& rule : map.alarms)
    if (auto good = check(rule.when); !good) return good;
  return {};
}

ChamberStatus evaluate_rules(const RegisterMap& map, const ItemValue& value) {
  ChamberStatus status;
  const auto fits = [&](const StateRule& rule) {
    const auto found = value(rule.when.item);
    return found && holds(rule.when, *found);
  };
  const auto state = std::ranges::find_if(map.states, fits);
  if (state != map.states.end())
    status.activity = state->activity;
  else
    status.unmatched = describe_state_values(map, value);
  std::vector<std::pair<AlarmSeverity, std::string>> raised;
  for (const auto& rule : map.alarms) {
    const auto found = value(rule.when.item);
    if (found && holds(rule.when, *found))
      raised.emplace_back(rule.severity, alarm_text(rule, *map.find(rule.when.item), *found));
  }
  std::ranges::stable_sort(raised, [](const auto& a, const auto& b) { return a.first > b.first; });
  for (auto& [severity, text] : raised) {
    status.must_stop = status.must_stop || severity == AlarmSeverity::stop;
    status.alarms.push_back(std::move(text));
  }
  return status;
}

/// Evaluates the items of the humidity. Values outside their range are unknown.
void evaluate_humidity(const RegisterMap& map, const ItemValue& value, ChamberStatus& status) {
  constexpr double kMostPercent = 105, kDriestC = -90, kWettestC = 100;
  if (!map.reads_humidity) return;
  if (const auto found = map.find("humidity") ? value("humidity") : std::nullopt)
    if (*found > 0 && *found <= kMostPercent) status.humidity_percent = *found;
  if (const auto found = map.find("dew_point") ? value("dew_point") : std::nullopt)
    if (*found >= kDriestC && *found <= kWettestC) status.dew_point = Celsius{*found};
}

/// Returns the items that evaluate_rules() and evaluate_humidity() read, each once.
std::vector<const RegisterItem*> status_items(const RegisterMap& map) {
  std::vector<const RegisterItem*> items;
  const auto add = [&](const std::string& name) {
    const auto* item = map.find(name);
    if (item && item->readable && std::ranges::find(items, item) == items.end()) items.push_back(item);
  };
  for (const auto& rule : map.states) add(rule.when.item);
  for (const auto& rule : map.alarms) add(rule.when.item);
  if (map.reads_humidity) {
    add("humidity");
    add("dew_point");
  }
  return items;
}

/// Maximum duration of a reading. The caller does not wait longer.
constexpr Duration kLongestReading = std::chrono::milliseconds(900);
/// Duration of an exchange from which a line is slow. On a slow line, units and decimals are not read again for a set
/// point that is sent in the same second.
constexpr Duration kSlowExchange = std::chrono::milliseconds(50);
/// Maximum number of consecutive stray zeros. A further zero is accepted as a value.
constexpr int kMaxStrayZeros = 6;
/// A zero or tiny value this close to the previous air temperature is accepted.
constexpr double kNearZeroK = 2;
/// Limits of the air temperature. A value outside them has another word order or unit, or is corrupted.
constexpr double kColdestAirC = -120, kWarmestAirC = 250;
/// A smaller non-zero value indicates a wrong word order.
constexpr double kTinyValueC = 1e-4;
/// A larger magnitude of the set point is a corrupted number.
constexpr double kLargestSetPointC = 1000;
/// Maximum instantaneous change of the air temperature, and its maximum rate; sufficient for thermal shock chambers.
constexpr double kJumpK = 10, kFastestKPerS = 5;
/// Number of readings after which a value that jumped and persists is accepted as the sensor's output.
constexpr int kReadingsToAcceptJump = 3;

/// Returns whether a command stops the chamber or its program. Such a command tries every step.
bool ends_something(std::string_view command) { return command == "stop" || command == "stop_program"; }

class ModbusChamber final : public Chamber {
 public:
  ModbusChamber(RegisterMap map, std::unique_ptr<Registers> registers, std::unique_ptr<Pauses> pauses,
                const ControllerSettings& before);

  Result<std::string> identify() override {
    items_.accept_unit();
    limits_.reset();
    if (std::exchange(is_new_, false))
      turns_.schedule_full_round();
    else
      turns_.begin_new_round();  // no time within a tick
    auto found = items_.identify(air_);
    if (!found) return failure(std::move(found.error()));
    if (auto fits = check_resolution(); !fits) return failure(std::move(fits.error()));
    if (auto fits = check_word_order(*found); !fits) return failure(std::move(fits.error()));
    verification_ = {std::move(found->verified), std::move(found->not_verified)};
    return std::move(found->who);
  }

  Result<std::string> recognise() override {
    items_.accept_unit();
    return items_.recognise(air_).map([](IdentityFound found) { return std::move(found.who); });
  }

  IdentityReport verification() const override { return verification_; }

  std::uint64_t breaks() const override { return registers_->breaks(); }

  /// Reads the state. After a failure activity and humidity are unknown, but the alarms remain until the status is read
  /// again.
  Result<ChamberState> read() override {
    auto state = read_state();
    if (state && turns_.is_overdue()) return status_fault("the state and alarms could not be read for a minute");
    if (state) return state;
    turns_.begin_new_round();
    status_.activity = ChamberActivity::unknown;
    status_.humidity_percent.reset();
    status_.dew_point.reset();
    status_known_ = false;
    return state;
  }

  /// Retries lost pieces of the status a few times. Waits a second after a stray zero, as a run does.
  Result<ChamberState> inspect() override {
    constexpr int kMaxTries = 3;
    unhurried_ = true;
    status_known_ = false;
    Result<ChamberState> state;
    for (int i = 0; i < kMaxTries + zeros_ && !(state && status_known_); ++i) {
      if (zeros_ > 0) pauses_->rest(std::chrono::seconds(1));
      turns_.schedule_full_round();
      state = read_state();
      status_known_ = status_known_ || turns_.pieces() == 0;
    }
    unhurried_ = false;
    if (state && !status_known_) return status_fault("the activity could not be read");
    return state;
  }

  /// Ends a running program before the first set point, because a program started at the panel, or by this host before
  /// a restart, would override the set point.
  Result<void> send_set_point(Celsius target) override {
    items_.accept_unit();
    if (auto allowed = check_limits(target); !allowed) return allowed;
    if (auto ready = prepare(); !ready) return ready;
    if (std::isnan(sent_c_)) {
      if (auto free = end_program(); !free) return free;
      if (auto sound = confirm_air(); !sound) return sound;
    }
    if (auto free = end_known_program(); !free) return free;
    auto done = items_.write(set_point_, target.value);
    if (done) sent_c_ = target.value;
    if (done) note_sent(target);
    return done;
  }

  /// Starts temperature control and restores the set point, which a finished program may have changed. The stored
  /// activity "off" is discarded, because on a slow line the next query takes a while.
  Result<void> start() override {
    items_.accept_unit();
    turns_.begin_new_round();
    if (status_.activity == ChamberActivity::off) status_.activity = ChamberActivity::unknown;
    if (!map_.sequences.contains("start")) return map_.control ? write_control_code(map_.control->on) : Result<void>{};
    if (auto ready = prepare(); !ready) return ready;
    if (auto started = perform("start"); !started) return started;
    if (std::isnan(sent_c_)) return {};
    if (!set_point_.readable) return send_set_point({sent_c_});  // may be ignored while off
    const auto now = items_.read(set_point_);
    if (!now && now.error().kind != FaultKind::out_of_range) return failure(now.error());
    const bool kept = now && std::abs(*now - sent_c_) <= set_point_tolerance(map_).value;
    return kept ? Result<void>{} : send_set_point({sent_c_});
  }

  Result<void> stop() override {
    items_.accept_unit();
    if (map_.sequences.contains("stop")) return perform("stop");
    if (map_.control) return write_control_code(map_.control->off);
    return failure(FaultKind::refused, "chamber stop", "its register map has neither a command \"stop\" nor [control]");
  }

  Result<void> perform(const std::string& command) override {
    items_.accept_unit();
    turns_.begin_new_round();
    const auto found = map_.sequences.find(command);
    if (found == map_.sequences.end())
      return failure(FaultKind::refused, "chamber " + command,
                     fmt::format("its register map has no command \"{}\"", command));
    return ends_something(command) ? items_.perform_every_step(found->second) : items_.perform(found->second, {});
  }

  void end_rest() override { registers_->end_rest(); }

  Result<void> send_set_point_immediately(Celsius target) override {
    items_.accept_unit();
    end_rest();
    items_.fall_back();
    (void)prepare();  // a unit that needs no preparation now takes the set point anyway
    const auto free = end_known_program();
    auto seen_at_once = set_point_;
    seen_at_once.seen_later = false;
    auto done = items_.write_persistently(seen_at_once, target.value);
    const bool may_run_program = !done && done.error().kind == FaultKind::refused;
    if (may_run_program && end_program()) done = items_.write_persistently(seen_at_once, target.value);
    if (done) sent_c_ = target.value;
    to_be_shown_.clear();
    return done ? free : done;
  }

  Result<void> send_safe_state_unconfirmed(Celsius target, bool off) override {
    end_rest();
    items_.fall_back();
    if (const auto found = map_.sequences.find("prepare"); found != map_.sequences.end())
      (void)items_.perform_unconfirmed(found->second);
    auto sent = items_.write_unconfirmed(set_point_, target.value);
    if (!off) return sent;
    Result<void> stopped;
    if (const auto found = map_.sequences.find("stop"); found != map_.sequences.end())
      stopped = items_.perform_unconfirmed(found->second);
    else if (map_.control)
      stopped = items_.write_unconfirmed(items_.item(map_.control->commanded), static_cast<double>(map_.control->off));
    return sent ? stopped : sent;
  }

  Result<void> end_program() override {
    if (!map_.sequences.contains("stop_program") || map_.states.empty()) return {};
    const auto state = inspect();
    if (!state) return failure(state.error());
    if (!is_program_activity(state->activity)) return {};
    return perform("stop_program").map([&] { program_runs_ = false; });
  }

  Result<SetPointRange> limits() override {
    limits_.reset();
    return read_limits().map([&] { return *limits_; });
  }

  ChamberEffort effort() const override {
    const bool seen_at_once = set_point_.readable && !set_point_.seen_later;
    return {.each_second = static_cast<int>(core_plan_.size()),
            .new_set_point = seen_at_once ? 2 : 1,
            .status = turns_.pieces(),
            .longest = exchange_};
  }

  std::vector<std::string> missing() const override { return missing_; }
  std::string unmatched_state() const override { return status_.unmatched; }
  ControllerSettings settings() const override { return items_.latest_settings(); }

  Result<std::string> upload(const ChamberProgram& program) override {
    if (!map_.sequences.contains("start_program") || !map_.sequences.contains("stop_program"))
      return failure(FaultKind::refused, "chamber upload",
                     "its register map must have the commands \"start_program\" and \"stop_program\"");
    for (const auto& step : program.steps)
      for (const auto target : {step.start, step.target})
        if (auto allowed = check_limits(target); !allowed) return failure(allowed.error());
    const auto report = upload_program(map_, items_, *registers_, *pauses_, program);
    if (!report) return failure(report.error());
    uploaded_program_ = report->program;
    return describe(*report);
  }

  Result<void> start_program() override {
    if (!uploaded_program_) return failure(FaultKind::refused, "chamber start_program", "no program was uploaded");
    items_.accept_unit();
    turns_.begin_new_round();
    auto started = items_.perform(map_.sequences.at("start_program"),
                                  {.program = *uploaded_program_, .step = map_.memory->first_step});
    // Set even after a failure, because the program may have started; send_set_point() must end it.
    program_runs_ = true;
    return started;
  }

 private:
  /// Carries out the sequence "prepare", once on each connection, because a unit may lose its mode with its power.
  Result<void> prepare() {
    const auto found = map_.sequences.find("prepare");
    const auto connection = registers_->breaks();
    if (found == map_.sequences.end() || prepared_after_ == connection) return {};
    return items_.perform(found->second, {}).map([&] { prepared_after_ = connection; });
  }

  /// Returns the items that each read() needs.
  [[nodiscard]] std::vector<const RegisterItem*> core_items() const {
    std::vector<const RegisterItem*> core{&air_};
    if (set_point_.readable) core.push_back(&set_point_);
    if (map_.one_block && identity_) core.push_back(identity_);
    const auto context = items_.find_context_items(core);
    core.insert(core.end(), context.begin(), context.end());
    return core;
  }

  [[nodiscard]] Result<ChamberState> read_state() {
    const auto began = pauses_->now();
    const auto core = read_core_items(began);
    if (!core) return failure(core.error());
    if (map_.one_block && identity_) {
      const auto same = items_.value_in(*core, *identity_).and_then([&](double found) {
        return check_fingerprint(map_, *map_.identity, found);
      });
      if (!same) return failure(same.error());
    }
    const auto air = evaluate_air(*core);
    if (!air) return failure(air.error());
    const auto set_point = evaluate_set_point(*core);
    if (!set_point) return failure(set_point.error());
    read_status_pieces(*core, began);
    const auto dew = status_.humidity_percent ? dew_point(Celsius{*air}, *status_.humidity_percent) : std::nullopt;
    return ChamberState{{*air},
                        {*set_point},
                        status_.activity,
                        status_.alarms,
                        status_.must_stop,
                        status_.humidity_percent,
                        status_.dew_point ? status_.dew_point : dew};
  }

  /// Reads the core items. Fails at the first span that fails, or with timeout if the reading takes too long.
  [[nodiscard]] Result<Snapshot> read_core_items(Duration began) {
    Snapshot core;
    for (const auto& span : core_plan_) {
      const auto before = pauses_->now();
      if (before - began >= kLongestReading && !unhurried_)
        return failure(FaultKind::timeout, place(air_),
                       "the line is too slow or too unreliable for one reading per second");
      auto words = registers_->read(span.function, span.first, span.count);
      if (!words && items_.can_skip(span)) continue;
      if (!words) return failure(std::move(words.error()));
      exchange_ = std::max(pauses_->now() - before, exchange_ * 3 / 4);
      core.add(span, std::move(*words));
    }
    items_.cache_latest_settings(core);
    items_.keep_snapshot(exchange_ >= kSlowExchange ? core : Snapshot());
    return core;
  }

  /// Returns the air temperature. A zero that is far from the previous value may be a stray zero; a genuine 0 °C is
  /// close to the previous value.
  [[nodiscard]] Result<double> evaluate_air(const Snapshot& core) {
    const auto air = items_.value_in(core, air_);
    if (!air) return air;
    if (auto sound = check_air(*air); !sound) return failure(std::move(sound.error()));
    const bool is_near = std::abs(*air - last_air_c_) <= kNearZeroK;
    if (air_.stray_zeros && *air == 0 && !is_near && zeros_ < kMaxStrayZeros) {
      ++zeros_;
      return failure(FaultKind::out_of_range, place(air_), "the unit returned a stray zero instead of a value");
    }
    zeros_ = 0;
    last_air_c_ = *air;
    last_air_at_ = pauses_->now();
    return air;
  }

  /// Reads the air temperature twice more if no other value confirms its word order, because in a wrong order a single
  /// reading may be plausible by chance. Called before the first set point.
  [[nodiscard]] Result<void> confirm_air() {
    constexpr int kReadings = 2;
    if (set_point_.readable || map_.text_link || word_count(air_.type) < 2) return {};
    for (int good = 0; good < kReadings;) {
      pauses_->rest(std::chrono::seconds(1));
      const auto state = read_state();
      if (!state && zeros_ == 0) return failure(state.error());  // retry after a stray zero
      if (state) ++good;
    }
    return {};
  }

  /// Fails with out_of_range for an impossible air temperature.
  [[nodiscard]] Result<void> check_air(double air_c) {
    const auto refuse = [&](const char* why) {
      return failure(FaultKind::out_of_range, place(air_), fmt::format("reads {:g} °C, {}", air_c, why));
    };
    if (!(air_c >= kColdestAirC && air_c <= kWarmestAirC))
      return refuse("which is impossible for a chamber; check word order and unit");
    const double moved = std::abs(air_c - last_air_c_);
    if (air_c != 0 && std::abs(air_c) < kTinyValueC && !(moved <= kNearZeroK))
      return refuse("which is almost zero; check the word order");
    const double reach = kJumpK + kFastestKPerS * to_seconds(pauses_->now() - last_air_at_);
    if (std::isnan(last_air_c_) || moved <= reach || (air_.stray_zeros && air_c == 0)) {
      jumps_ = 0;
      return {};
    }
    jumps_ = jumps_ > 0 && std::abs(air_c - jumped_to_c_) <= kJumpK ? jumps_ + 1 : 1;
    jumped_to_c_ = air_c;
    if (jumps_ < kReadingsToAcceptJump) return refuse("a faster change since the last reading than air can make");
    jumps_ = 0;
    return {};
  }

  /// Returns NaN if the unit answers that it has no set point, as some do while they are off.
  [[nodiscard]] Result<double> evaluate_set_point(const Snapshot& core) {
    if (set_point_.readable && has_no_value(map_, set_point_, core.find_words(set_point_)))
      return std::numeric_limits<double>::quiet_NaN();
    const auto set_point = set_point_.readable ? items_.value_in(core, set_point_) : Result<double>(sent_c_);
    if (!set_point) return set_point;
    if (std::abs(*set_point) > kLargestSetPointC)
      return failure(FaultKind::out_of_range, place(set_point_),
                     fmt::format("reads {:g} °C, which is impossible; check word order and unit", *set_point));
    if (!is_expected(*set_point))
      return failure(FaultKind::mismatch, place(set_point_),
                     fmt::format("reads {:.6g} after {:.6g} was written", *set_point, sent_c_));
    return set_point;
  }

  /// Notes a set point that later readings verify.
  void note_sent(Celsius target) {
    if (set_point_.seen_later && set_point_.readable) to_be_shown_.push_back({pauses_->now(), target.value});
  }

  /// Returns whether the unit may show this set point. A unit that lags may show any set point that it was sent within
  /// the lag, and before the first of them its former one. The last one is verified until it was shown.
  [[nodiscard]] bool is_expected(double shown_c) {
    if (to_be_shown_.empty()) return true;
    const auto now = pauses_->now();
    const auto has_come = [&](const SentSetPoint& sent) { return now >= sent.at + set_point_.seen_within; };
    while (to_be_shown_.size() > 1 && has_come(to_be_shown_[1])) to_be_shown_.pop_front();
    const double as_written = set_point_.tolerance.value_or(std::max(finest_step(set_point_), 1e-3));
    const auto is_shown = [&](const SentSetPoint& sent) { return std::abs(shown_c - sent.value_c) <= as_written; };
    const bool may_be_former = !has_come(to_be_shown_.front());
    const bool is_last = is_shown(to_be_shown_.back());
    const bool is_one = is_last || may_be_former || std::ranges::any_of(to_be_shown_, is_shown);
    if (is_last || !is_one) to_be_shown_.clear();
    return is_one;
  }

  /// Reads as many pieces of the status as there is time for. A lost piece is retried by a later reading. The status is
  /// updated only after all pieces were read.
  void read_status_pieces(const Snapshot& core, Duration began) {
    turns_.begin_reading();
    while (const auto* next = turns_.next(pauses_->now() - began, exchange_)) {
      const auto span = *next;
      auto words = registers_->read(span.function, span.first, span.count);
      if (words) {
        turns_.store(std::move(*words));
      } else if (words.error().kind == FaultKind::refused && turns_.note_refused()) {
        missing_.push_back(fmt::format("{} ({})", fmt::join(find_status_names(span), ", "), words.error().what));
      } else if (has_only_humidity(span)) {
        turns_.skip();
      } else {
        turns_.note_lost(pauses_->now() - began);
        lost_ = text(words.error());
        return;
      }
    }
    if (!turns_.is_complete()) return;
    auto status = evaluate_status(core, turns_.snapshot());
    if (!status) {
      lost_ = text(status.error());
      turns_.begin_new_round();
      return;
    }
    lost_.clear();
    (void)turns_.take_snapshot();
    status_ = std::move(*status);
    status_known_ = true;
  }

  /// Returns the names of the status items in a span.
  [[nodiscard]] std::vector<std::string> find_status_names(const ReadSpan& span) const {
    std::vector<std::string> names;
    for (const auto* item : status_items_)
      if (read_function(*item) == span.function && item->address >= span.first &&
          item->address < span.first + span.count)
        names.push_back(item->name);
    return names;
  }

  [[nodiscard]] tl::unexpected<Fault> status_fault(const char* what) const {
    return failure(FaultKind::timeout, place(air_), lost_.empty() ? what : fmt::format("{}: {}", what, lost_));
  }

  /// Fails with corrupted if a rule of the state or an alarm cannot be evaluated.
  [[nodiscard]] Result<ChamberStatus> evaluate_status(const Snapshot& core, const Snapshot& more) const {
    const ItemValue value = [&](const std::string& name) -> std::optional<double> {
      const auto& item = items_.item(name);
      for (const auto* snapshot : {&more, &core}) {
        if (snapshot->find_words(item).empty()) continue;
        const auto found = items_.value_in(*snapshot, item);
        return found ? std::optional(*found) : std::nullopt;
      }
      return std::nullopt;
    };
    if (auto good = check_values(map_, value); !good) return failure(std::move(good.error()));
    auto status = evaluate_rules(map_, value);
    evaluate_humidity(map_, value, status);
    return status;
  }

  /// Returns whether a span contains no item of the state and alarm rules. If it cannot be read, only the humidity is
  /// unknown.
  [[nodiscard]] bool has_only_humidity(const ReadSpan& span) const {
    if (!map_.reads_humidity) return false;
    const auto names = find_status_names(span);
    return !names.empty() &&
           std::ranges::all_of(names, [](const auto& name) { return name == "humidity" || name == "dew_point"; });
  }

  [[nodiscard]] Result<void> read_limits() {
    if (limits_) return {};
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
    limits_ = SetPointRange{*lowest, *highest};
    // A map may state a limit beside that of the controller; the narrower one applies.
    const auto& fixed = map_.limits;
    if (fixed.lowest && limits_->lowest) limits_->lowest = std::max(*fixed.lowest, *limits_->lowest);
    if (fixed.highest && limits_->highest) limits_->highest = std::min(*fixed.highest, *limits_->highest);
    return {};
  }

  /// Fails with mismatch if the controller rounds set points more coarsely than its map states, because a rounded set
  /// point would be mistaken for one from another program.
  [[nodiscard]] Result<void> check_resolution() {
    if (set_point_.decimals.empty()) return {};
    const auto as_set = items_.resolve_context(set_point_);
    if (!as_set) return failure(as_set.error());
    constexpr double kRoundingFactor = 1.001;
    const double kept = finest_step(*as_set), expected = set_point_tolerance(map_).value;
    if (kept <= kRoundingFactor * expected) return {};
    return failure(
        FaultKind::mismatch, place(set_point_),
        fmt::format("the controller stores steps of {:g} K, expected {:g} K; set it to more decimals, set the "
                    "resolution in its map, or check that the controller is set to the data map of this file",
                    kept, expected));
  }

  /// Verifies the word order, which in some controllers is a setting that can only be inferred from the values.
  [[nodiscard]] Result<void> check_word_order(IdentityFound& found) {
    if (map_.text_link || word_count(air_) < 2 || word_count(set_point_) < 2) return {};
    if (!set_point_.readable) {
      found.not_verified.push_back("the word order (the set point cannot be read)");
      return {};
    }
    const auto air = read_span(air_), set_point = read_span(set_point_);
    const auto words = items_.read_spans(std::array{air, set_point});
    if (!words) return failure(words.error());
    const auto findings = probe_word_order(air_, words->find_words(air_), set_point_, words->find_words(set_point_));
    if (has_wrong_word_order(findings)) return failure(FaultKind::mismatch, place(air_), describe(findings));
    const bool is_only_one = std::ranges::count_if(findings, &OrderFinding::plausible) == 1;
    auto& list = findings.front().plausible && is_only_one ? found.verified : found.not_verified;
    list.push_back(fmt::format("word order {}", name(air_.order)));
    return {};
  }

  [[nodiscard]] Result<void> check_limits(Celsius target) {
    if (auto known = read_limits(); !known) return known;
    const auto refuse = [&](const char* side, Celsius limit) {
      return failure(FaultKind::out_of_range, place(set_point_),
                     fmt::format("{:g} °C is {} the controller's limit of {:g} °C", target.value, side, limit.value));
    };
    if (limits_->lowest && target < *limits_->lowest) return refuse("below", *limits_->lowest);
    if (limits_->highest && target > *limits_->highest) return refuse("above", *limits_->highest);
    return {};
  }

  /// Ends the controller's program if this driver started it or if the latest status reports one.
  [[nodiscard]] Result<void> end_known_program() {
    const bool foreign = status_known_ && is_program_activity(status_.activity);
    if (!program_runs_ && !(foreign && map_.sequences.contains("stop_program"))) return {};
    return perform("stop_program").map([&] {
      program_runs_ = false;
      status_.activity = ChamberActivity::unknown;
    });
  }

  [[nodiscard]] Result<void> write_control_code(std::int64_t code) {
    auto commanded = items_.item(map_.control->commanded);
    commanded.seen_in = map_.control->active;
    return items_.write(commanded, static_cast<double>(code));
  }

  RegisterMap map_;
  std::unique_ptr<Registers> registers_;
  std::unique_ptr<Pauses> pauses_;
  ItemExchange items_;
  const RegisterItem& air_;
  const RegisterItem& set_point_;
  const RegisterItem* identity_;
  std::vector<ReadSpan> core_plan_;
  StatusTurns turns_{{}, 0};
  /// Items in state and alarm rules, and the items for their decimals and units.
  std::vector<const RegisterItem*> status_items_;
  ChamberStatus status_;
  IdentityReport verification_;
  bool is_new_ = true;                ///< never identified
  std::vector<std::string> missing_;  ///< names of missing status items
  /// Fault of the latest piece of the status that could not be read.
  std::string lost_;
  /// True outside a tick, where time does not limit the number of exchanges.
  bool unhurried_ = false;
  /// The status was read completely since the last failed reading.
  bool status_known_ = false;
  Duration exchange_{};  ///< duration of one exchange
  /// Limits in the controller; empty before they are read.
  std::optional<SetPointRange> limits_;
  std::optional<int> uploaded_program_;  ///< program number
  /// True after the uploaded program was started.
  bool program_runs_ = false;
  struct SentSetPoint {
    Duration at{};
    double value_c{};
  };
  /// Sent set points that no reading has shown yet, and the one before them.
  std::deque<SentSetPoint> to_be_shown_;
  /// Number of broken connections before the one on which the unit was prepared.
  std::optional<std::uint64_t> prepared_after_;
  /// Latest acknowledged set point.
  double sent_c_ = std::numeric_limits<double>::quiet_NaN();
  double last_air_c_ = std::numeric_limits<double>::quiet_NaN();
  Duration last_air_at_{};
  int zeros_ = 0;  ///< consecutive stray zeros
  int jumps_ = 0;  ///< consecutive readings near `jumped_to_c_`
  double jumped_to_c_{};
};

ModbusChamber::ModbusChamber(RegisterMap map, std::unique_ptr<Registers> registers, std::unique_ptr<Pauses> pauses,
                             const ControllerSettings& before)
    : map_(std::move(map)),
      registers_(std::move(registers)),
      pauses_(std::move(pauses)),
      items_(map_, *registers_, *pauses_),
      air_(items_.item("air_temperature")),
      set_point_(items_.item("set_point")),
      identity_(map_.identity && map_.identity->pattern.empty() ? &items_.item(map_.identity->item) : nullptr) {
  items_.set_latest_settings(before);
  if (!before.empty()) items_.fall_back();
  const auto at_most = map_.link.modbus.read_at_most;
  core_plan_ = plan_reads(core_items(), map_.one_block || map_.holes, at_most);
  status_items_ = status_items(map_);
  const auto context = items_.find_context_items(status_items_);
  status_items_.insert(status_items_.end(), context.begin(), context.end());
  const bool is_polled = !(map_.states.empty() && map_.alarms.empty()) || map_.reads_humidity;
  turns_ = StatusTurns(plan_reads(status_items_, map_.holes, at_most), is_polled ? map_.status_every : 0);
}

}  // namespace

std::unique_ptr<Chamber> make_modbus_chamber(RegisterMap map, std::unique_ptr<Registers> registers,
                                             std::unique_ptr<Pauses> pauses, const ControllerSettings& before) {
  return std::make_unique<ModbusChamber>(std::move(map), std::move(registers), std::move(pauses), before);
}

}  // namespace gyrotherm::drivers
