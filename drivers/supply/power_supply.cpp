// SPDX-License-Identifier: Apache-2.0
#include "drivers/supply/power_supply.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <utility>
#include <variant>

#include "core/deadline.hpp"
#include "core/text.hpp"
#include "drivers/chamber/register_item.hpp"

namespace gyrotherm::drivers {
namespace {

/// Time for switching in one read; an instrument is read within a second.
constexpr Duration kSwitchingTime = std::chrono::milliseconds(400);
/// Larger magnitudes are no measurement: SCPI instruments send 9.9E37 for a missing value.
constexpr double kLargestReading = 1e5;
/// Permitted deviation of the measured voltage from the set voltage.
constexpr double kVoltageBand = 0.05, kSmallestVoltageBand = 0.3;

using ItemValues = std::map<std::string, FieldValue>;

double voltage_band(double voltage_v) { return std::max(kVoltageBand * std::abs(voltage_v), kSmallestVoltageBand); }

bool has_code(const SupplyItem& item, const char* code, const std::string& text) {
  const auto found = item.codes.find(code);
  return found != item.codes.end() && std::ranges::count(found->second, text) > 0;
}

bool is_trip_item(const std::string& name) { return name.ends_with("trip") && name != kClearTrip; }

/// One number that is written and read back.
struct Setting {
  const char* item;
  std::optional<double> value;
  const char* unit;
};

std::array<Setting, 4> list_settings(const OutputSettings& output) {
  return {Setting{kOverVoltage, output.over_voltage_v, "V"}, Setting{kOverCurrent, output.over_current_a, "A"},
          Setting{kSetVoltage, output.voltage_v, "V"}, Setting{kSetCurrent, output.current_a, "A"}};
}

class TextSupply final : public PowerSupply {
 public:
  TextSupply(SupplyDescription description, std::vector<OutputSettings> outputs, std::unique_ptr<ByteStream> stream,
             std::string place, const Clock* clock)
      : description_(std::move(description)),
        outputs_(std::move(outputs)),
        place_(place),
        clock_(clock),
        is_live_(outputs_.size()),
        instrument_(description_, std::move(stream), std::move(place), clock) {}

  Result<std::string> identify() override { return instrument_.identify(); }
  Result<std::string> recognise() override { return instrument_.recognise(); }
  std::uint64_t breaks() const override { return instrument_.breaks(); }

  void demand(PowerDemand demand) override {
    const std::scoped_lock lock(mutex_);
    demanded_ = demand;
    ++demands_;
  }

  SupplyReadings read() override {
    SupplyReadings readings;
    if (auto ready = instrument_.make_ready(); ready)
      carry_out();
    else
      trouble_ = text(ready.error());
    readings.outputs = read_outputs();
    const std::scoped_lock lock(mutex_);
    readings.pending = demanded_;
    readings.trouble = demanded_ == PowerDemand::keep ? "" : trouble_;
    readings.gave_up = demanded_ != PowerDemand::keep && gave_up_ && begun_ == demands_;
    return readings;
  }

  std::vector<Result<OutputInspection>> inspect() override {
    std::vector<Result<OutputInspection>> all;
    if (auto ready = instrument_.make_ready(); !ready) return {outputs_.size(), failure(std::move(ready.error()))};
    for (const auto& output : outputs_) all.push_back(inspect(output));
    return all;
  }

 private:
  [[nodiscard]] const SupplyOutput& lines(const OutputSettings& output) const {
    return description_.outputs[output.output];
  }
  [[nodiscard]] std::string where(const OutputSettings& output) const {
    return fmt::format("{}, output {}", place_, output.output + 1);
  }
  [[nodiscard]] tl::unexpected<Fault> mismatch(const OutputSettings& output, std::string what) const {
    return failure(FaultKind::mismatch, where(output), std::move(what));
  }

  // ---- exchanges

  /// Notes that the instrument may have lost its preparation. A refusal is an answer.
  Fault noted(Fault fault) {
    if (fault.kind != FaultKind::refused) instrument_.forget_preparation();
    return fault;
  }

  /// Asks each question of the named items once. Items that the supply does not have, or cannot read, are left out.
  Result<ItemValues> read_items(const OutputSettings& output, const std::vector<std::string>& names) {
    std::map<std::size_t, FieldValues> answers;
    ItemValues values;
    for (const auto& name : names) {
      const auto* item = lines(output).find(name);
      if (!item || !item->question) continue;
      if (!answers.contains(*item->question)) {
        auto answer = ask(lines(output).questions[*item->question]);
        if (!answer) return failure(noted(std::move(answer.error())));
        answers[*item->question] = std::move(*answer);
      }
      if (const auto& fields = answers[*item->question]; fields.contains(item->field))
        values[name] = fields.at(item->field);
    }
    return values;
  }

  Result<FieldValues> ask(const SupplyQuestion& question) {
    if (question.is_asked_twice)
      if (auto first = instrument_.client().ask(question.ask, question.answers); !first)
        return failure(std::move(first.error()));
    auto answer = instrument_.client().ask(question.ask, question.answers);
    if (!answer) return failure(std::move(answer.error()));
    return std::move(answer->fields);
  }

  Result<void> tell(const SupplyCommand& command, const FieldValue& value) {
    auto sent = instrument_.client().tell(command.tell.format({{kTextValueField, value}}), command.acknowledged);
    for (std::size_t i = 0; sent && i < command.then.size(); ++i) sent = instrument_.client().tell(command.then[i]);
    if (!sent) return failure(noted(std::move(sent.error())));
    return {};
  }

  static std::optional<double> number(const ItemValues& values, const std::string& name) {
    const auto found = values.find(name);
    const auto* value = found == values.end() ? nullptr : std::get_if<double>(&found->second);
    return value ? std::optional(*value) : std::nullopt;
  }
  static std::string code_text(const ItemValues& values, const std::string& name) {
    const auto found = values.find(name);
    const auto* value = found == values.end() ? nullptr : std::get_if<std::string>(&found->second);
    return value ? *value : std::string();
  }

  // ---- state

  Result<OutputReading> read_state(const OutputSettings& output) {
    std::vector<std::string> names{kOutputState, kMeasuredVoltage, kMeasuredCurrent};
    for (const auto& [name, item] : lines(output).items)
      if (is_trip_item(name)) names.push_back(name);
    const auto values = read_items(output, names);
    if (!values) return failure(values.error());
    OutputReading reading{.voltage_v = number(*values, kMeasuredVoltage).value_or(NAN),
                          .current_a = number(*values, kMeasuredCurrent).value_or(NAN)};
    for (const double value : {reading.voltage_v, reading.current_a})
      if (!(std::abs(value) < kLargestReading))
        return failure(FaultKind::out_of_range, where(output), fmt::format("{:g} is no measurement", value));
    const auto* state = lines(output).find(kOutputState);
    const auto shown = code_text(*values, kOutputState);
    reading.is_on = state->question ? has_code(*state, kOnCode, shown)
                                    : std::abs(reading.voltage_v) > voltage_band(output.voltage_v);
    if (state->question && !reading.is_on && !has_code(*state, kOffCode, shown))
      return failure(FaultKind::corrupted, where(output), fmt::format("\"{}\" is no state", plain(shown)));
    if (auto known = add_trips(output, *values, reading); !known) return failure(known.error());
    return reading;
  }

  Result<void> add_trips(const OutputSettings& output, const ItemValues& values, OutputReading& reading) const {
    for (const auto& [name, item] : lines(output).items) {
      if (!is_trip_item(name)) continue;
      const auto word = number(values, name).value_or(0);
      const auto bits = lower_bits(word);
      if (!bits) return failure(FaultKind::corrupted, where(output), fmt::format("{:g} is no trip state", word));
      for (const auto& [flag, bit] : item.flags)
        if ((*bits >> bit & 1U) != 0) reading.trips.push_back(flag);
      if (item.codes.empty()) continue;
      const auto shown = code_text(values, name);
      if (has_code(item, kTrippedCode, shown))
        reading.trips.push_back(name == "trip" ? name : name.substr(0, name.size() - std::string("_trip").size()));
      else if (!has_code(item, kClearCode, shown))
        return failure(FaultKind::corrupted, where(output), fmt::format("\"{}\" is no trip state", plain(shown)));
    }
    return {};
  }

  std::vector<Result<OutputReading>> read_outputs() {
    std::vector<Result<OutputReading>> readings;
    if (auto ready = instrument_.make_ready(); !ready) return {outputs_.size(), failure(std::move(ready.error()))};
    for (const auto& output : outputs_) {
      readings.push_back(read_state(output));
      if (readings.back() || readings.back().error().kind == FaultKind::refused) continue;
      // The remaining outputs are on the same silent line.
      const auto fault = readings.back().error();
      if (fault.kind != FaultKind::out_of_range) readings.resize(outputs_.size(), failure(fault));
      if (readings.size() == outputs_.size()) break;
    }
    return readings;
  }

  /// Compares the settings that can be read with the required ones. Returns the differences.
  Result<std::string> compare_settings(const OutputSettings& output) {
    const auto values = read_items(output, {kOverVoltage, kOverCurrent, kSetVoltage, kSetCurrent});
    if (!values) return failure(values.error());
    std::vector<std::string> differences;
    for (const auto& setting : list_settings(output))
      if (auto what = difference(output, setting, *values); !what.empty()) differences.push_back(std::move(what));
    return fmt::format("{}", fmt::join(differences, ", "));
  }

  [[nodiscard]] std::string difference(const OutputSettings& output, const Setting& setting,
                                       const ItemValues& values) const {
    const auto* item = lines(output).find(setting.item);
    if (!setting.value || !item || !values.contains(setting.item)) return {};
    if (!item->codes.empty())
      return has_code(*item, kOnCode, code_text(values, setting.item)) ? "" : fmt::format("{} is off", setting.item);
    const auto read = number(values, setting.item);
    if (read && std::abs(*read - *setting.value) <= item->tolerance) return {};
    return fmt::format("{} is {:g} {} instead of {:g} {}", setting.item, read.value_or(NAN), setting.unit,
                       *setting.value, setting.unit);
  }

  Result<OutputInspection> inspect(const OutputSettings& output) {
    auto state = read_state(output);
    if (!state) return failure(state.error());
    const auto values = read_items(output, {kOverVoltage, kOverCurrent, kSetVoltage, kSetCurrent});
    if (!values) return failure(values.error());
    OutputInspection inspection{.state = std::move(*state)};
    std::vector<std::string> shown, differences;
    for (const auto& setting : list_settings(output)) {
      if (const auto read = number(*values, setting.item))
        shown.push_back(fmt::format("{} {:g} {}", setting.item, *read, setting.unit));
      if (auto what = difference(output, setting, *values); !what.empty()) differences.push_back(std::move(what));
    }
    inspection.settings = fmt::format("{}", fmt::join(shown, ", "));
    inspection.difference = fmt::format("{}", fmt::join(differences, ", "));
    return inspection;
  }

  // ---- switching

  void carry_out() {
    PowerDemand demanded{};
    std::uint64_t number{};
    {
      const std::scoped_lock lock(mutex_);
      demanded = demanded_;
      number = demands_;
    }
    if (demanded == PowerDemand::keep) return;
    if (number != begun_) {
      begun_ = number;
      gave_up_ = false;
      may_clear_.assign(outputs_.size(), demanded == PowerDemand::on_after_trip);
      steps_ = demanded == PowerDemand::off ? steps_off() : steps_on();
      next_ = 0;
    }
    if (gave_up_ || !perform_steps()) return;
    const std::scoped_lock lock(mutex_);
    if (number == demands_) demanded_ = PowerDemand::keep;
  }

  /// Performs the next steps. Returns whether all steps are done. After a failure the next call begins again.
  bool perform_steps() {
    trouble_.clear();
    const Deadline end(kSwitchingTime, clock_);
    while (next_ < steps_.size()) {
      if (auto done = steps_[next_](); !done) {
        trouble_ = text(done.error());
        next_ = 0;
        return false;
      }
      if (++next_ < steps_.size() && end.has_passed()) return false;
    }
    next_ = 0;
    return true;
  }

  using Step = std::function<Result<void>()>;

  std::vector<Step> steps_on() {
    std::vector<Step> steps;
    for (std::size_t i = 0; i < outputs_.size(); ++i) {
      steps.emplace_back([this, i] { return look_at(i); });
      for (const auto& setting : list_settings(outputs_[i]))
        if (setting.value)
          steps.emplace_back([this, i, setting] { return is_live_[i] ? Result<void>() : set(i, setting); });
      steps.emplace_back([this, i] { return is_live_[i] ? Result<void>() : confirm_settings(i); });
    }
    for (std::size_t i = 0; i < outputs_.size(); ++i)
      steps.emplace_back([this, i] { return is_live_[i] ? Result<void>() : switch_output(outputs_[i], true); });
    for (std::size_t i = 0; i < outputs_.size(); ++i)
      steps.emplace_back([this, i] { return verify(outputs_[i], true); });
    return steps;
  }

  /// Each output is switched off even if another one fails.
  std::vector<Step> steps_off() {
    std::vector<Step> steps;
    steps.emplace_back([this] {
      Result<void> done;
      for (auto output = outputs_.rbegin(); output != outputs_.rend(); ++output)
        if (auto one = switch_output(*output, false); !one && done) done = std::move(one);
      return done;
    });
    for (const auto& output : outputs_) steps.emplace_back([this, &output] { return verify(output, false); });
    return steps;
  }

  /// Determines whether the output is on with the right settings. Clears a trip if the demand permits it.
  Result<void> look_at(std::size_t index) {
    const auto& output = outputs_[index];
    auto state = read_state(output);
    if (!state) return failure(state.error());
    const auto* clear = lines(output).find(kClearTrip);
    if (!state->trips.empty() && clear && may_clear_[index]) {
      if (auto cleared = tell(*clear->command, FieldValue()); !cleared) return cleared;
      may_clear_[index] = false;
      state = read_state(output);
      if (!state) return failure(state.error());
    }
    if (!state->trips.empty()) return give_up(output, *state);
    is_live_[index] = state->is_on;
    if (!state->is_on) return {};
    const auto differences = compare_settings(output);
    if (!differences) return failure(differences.error());
    if (differences->empty()) return {};
    return mismatch(output, fmt::format("it is on, but {}; a live output is not changed: switch it off, or correct the "
                                        "rig file",
                                        *differences));
  }

  tl::unexpected<Fault> give_up(const OutputSettings& output, const OutputReading& state) {
    gave_up_ = true;
    return mismatch(output, fmt::format("it has tripped ({}), and is not switched on", fmt::join(state.trips, ", ")));
  }

  Result<void> set(std::size_t index, const Setting& setting) {
    const auto* item = lines(outputs_[index]).find(setting.item);
    if (!item || !item->command) return {};
    if (!item->codes.empty()) return tell(*item->command, item->codes.at(kOnCode).front());
    return tell(*item->command, *setting.value);
  }

  /// Reads all settings back. A level that was refused because of the former voltage is written once more.
  Result<void> confirm_settings(std::size_t index) {
    auto differences = compare_settings(outputs_[index]);
    if (differences && !differences->empty()) {
      for (const auto& setting : list_settings(outputs_[index]))
        if (auto done = setting.value ? set(index, setting) : Result<void>(); !done) return done;
      differences = compare_settings(outputs_[index]);
    }
    if (!differences) return failure(differences.error());
    if (differences->empty()) return {};
    return mismatch(outputs_[index],
                    fmt::format("{} after it was written; the output is not switched on", *differences));
  }

  Result<void> switch_output(const OutputSettings& output, bool on) {
    const auto* item = lines(output).find(kOutputState);
    return tell(*item->command, item->codes.at(on ? kOnCode : kOffCode).front());
  }

  /// Compares the reported state and the measured voltage with the required state.
  Result<void> verify(const OutputSettings& output, bool on) {
    const auto state = read_state(output);
    if (!state) return failure(state.error());
    if (on && !state->trips.empty()) return give_up(output, *state);
    if (state->is_on != on)
      return mismatch(output,
                      fmt::format("it is {} although it was switched {}", on ? "off" : "on", on ? "on" : "off"));
    const double expected = on ? output.voltage_v : 0;
    if (std::abs(state->voltage_v - expected) <= voltage_band(output.voltage_v)) return {};
    return mismatch(output, fmt::format("it was switched {}, but {:.2f} V and {:.3f} A are measured", on ? "on" : "off",
                                        state->voltage_v, state->current_a));
  }

  SupplyDescription description_;
  std::vector<OutputSettings> outputs_;
  std::string place_;
  const Clock* clock_;

  std::mutex mutex_;  ///< guards `demanded_` and `demands_`
  PowerDemand demanded_ = PowerDemand::keep;
  std::uint64_t demands_ = 0;

  /// Number of the demand whose steps are being performed.
  std::uint64_t begun_ = 0;
  std::vector<Step> steps_;
  std::size_t next_ = 0;
  std::string trouble_;
  bool gave_up_ = false;
  /// Outputs with a trip that the present demand may still clear.
  std::vector<bool> may_clear_;
  /// Outputs that were on with the right settings before the switch.
  std::vector<bool> is_live_;
  TextInstrument instrument_;
};

}  // namespace

std::unique_ptr<PowerSupply> make_text_supply(SupplyDescription description, std::vector<OutputSettings> outputs,
                                              std::unique_ptr<ByteStream> stream, std::string place,
                                              const Clock* clock) {
  return std::make_unique<TextSupply>(std::move(description), std::move(outputs), std::move(stream), std::move(place),
                                      clock);
}

}  // namespace gyrotherm::drivers
