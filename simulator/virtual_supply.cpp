// SPDX-License-Identifier: Apache-2.0
#include "simulator/virtual_supply.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <variant>

namespace gyrotherm::simulator {
namespace {

using drivers::FieldValue;
using drivers::FieldValues;
using drivers::SupplyItem;

bool is_trip(const std::string& name) { return name.ends_with("trip") && name != drivers::kClearTrip; }

/// Returns the protection that an item with codes reports: "over_current" for over_current_trip, any for "trip".
std::string protection(const std::string& item) {
  constexpr std::string_view kEnd = "_trip";
  return item.ends_with(kEnd) ? item.substr(0, item.size() - kEnd.size()) : std::string();
}

bool has_code(const SupplyItem& item, const char* code, const FieldValues& fields) {
  const auto value = fields.find(drivers::kTextValueField);
  const auto* text = value == fields.end() ? nullptr : std::get_if<std::string>(&value->second);
  const auto texts = item.codes.find(code);
  return text && texts != item.codes.end() && std::ranges::count(texts->second, *text) > 0;
}

}  // namespace

Result<VirtualSupply> VirtualSupply::make(VirtualSupplyOptions options, const VirtualLaboratory& laboratory) {
  VirtualSupply supply;
  supply.outputs_.resize(options.description.outputs.size());
  for (const auto& wired : options.outputs) {
    const auto& settings = wired.settings;
    if (settings.output >= supply.outputs_.size())
      return failure(FaultKind::usage, "virtual supply", fmt::format("has no output {}", settings.output + 1));
    auto& output = supply.outputs_[settings.output];
    output.is_on = true;
    output.values = {{drivers::kSetVoltage, settings.voltage_v}, {drivers::kSetCurrent, settings.current_a}};
    if (settings.over_voltage_v) output.values[drivers::kOverVoltage] = *settings.over_voltage_v;
    if (settings.over_current_a && options.description.trips_at_current_limit())
      output.trips_at_limit = true;
    else if (settings.over_current_a)
      output.values[drivers::kOverCurrent] = *settings.over_current_a;
    for (const auto& name : wired.units) {
      const auto found = std::ranges::find(laboratory.units(), name);
      if (found == laboratory.units().end())
        return failure(FaultKind::usage, "virtual supply", fmt::format("\"{}\" is no unit of the laboratory", name));
      output.units.push_back(static_cast<std::size_t>(found - laboratory.units().begin()));
    }
    supply.wired_.push_back(settings.output);
  }
  supply.description_ = std::move(options.description);
  return supply;
}

void VirtualSupply::connect(VirtualLaboratory& laboratory, std::size_t number) {
  laboratory_ = &laboratory;
  number_ = number;
  for (const auto index : wired_) apply(index);
}

std::optional<std::string> VirtualSupply::answer(const std::string& line) {
  if (line == description_.unit.text_link->identity_question)
    return description_.unit.text_link->identity_answers.front().format(
        {{drivers::kTextValueField, description_.simulated.identity}});
  for (const auto& step : description_.preparation) {
    if (step.line != line) continue;
    if (step.answers.empty()) return std::nullopt;
    FieldValues values;
    if (!step.field.empty()) values[step.field] = step.required;
    return step.answers.front().format(values);
  }
  for (std::size_t i = 0; i < description_.outputs.size(); ++i) {
    const auto& output = description_.outputs[i];
    for (std::size_t k = 0; k < output.questions.size(); ++k)
      if (output.questions[k].ask == line) return answer_question(i, k);
    for (const auto& [name, item] : output.items) {
      if (!item.command) continue;
      if (std::ranges::count(item.command->then, line) > 0) return std::nullopt;
      const auto fields = item.command->tell.match(line);
      if (!fields || !carry_out(i, name, item, *fields)) continue;
      const auto& acknowledged = item.command->acknowledged;
      return acknowledged.empty() ? std::nullopt : std::optional(acknowledged.front().format({}));
    }
  }
  const auto& unknown = description_.simulated.unknown;
  return unknown.empty() ? std::nullopt : std::optional(unknown);
}

bool VirtualSupply::carry_out(std::size_t index, const std::string& name, const SupplyItem& item,
                              const FieldValues& fields) {
  if (ignores_commands_) return true;
  auto& output = outputs_[index];
  if (name == drivers::kClearTrip) {
    output.trips.clear();
    return true;
  }
  if (!item.codes.empty()) {
    const bool on = has_code(item, drivers::kOnCode, fields);
    if (!on && !has_code(item, drivers::kOffCode, fields)) return false;
    if (name == drivers::kOverCurrent) output.trips_at_limit = on;
    if (name == drivers::kOutputState) output.is_on = on && output.trips.empty();
  } else {
    const auto value = fields.find(drivers::kTextValueField);
    const auto* number = value == fields.end() ? nullptr : std::get_if<double>(&value->second);
    if (!number) return false;
    output.values[name] = *number;
  }
  protect(index);
  return true;
}

VirtualSupply::Measurement VirtualSupply::measure(const Output& output) const {
  if (!output.is_on) return {};
  const auto value = [&](const char* name) {
    const auto found = output.values.find(name);
    return found == output.values.end() ? 0.0 : found->second;
  };
  double conductance = 0;
  for (const auto unit : output.units) conductance += 1 / laboratory_->load_ohm(unit);
  Measurement measured{.voltage_v = value(drivers::kSetVoltage)};
  measured.current_a = measured.voltage_v * conductance;
  const double limit_a = value(drivers::kSetCurrent);
  if (measured.current_a > limit_a) measured = {limit_a / conductance, limit_a, true};
  return measured;
}

void VirtualSupply::protect(std::size_t index) {
  auto& output = outputs_[index];
  const auto measured = measure(output);
  const auto exceeds = [&](const char* name, double value) {
    const auto level = output.values.find(name);
    return output.is_on && level != output.values.end() && value > level->second;
  };
  if (exceeds(drivers::kOverVoltage, measured.voltage_v)) output.trips.insert(drivers::kOverVoltage);
  if (exceeds(drivers::kOverCurrent, measured.current_a) || (output.trips_at_limit && measured.is_limited))
    output.trips.insert(drivers::kOverCurrent);
  if (!output.trips.empty()) output.is_on = false;
  apply(index);
}

void VirtualSupply::apply(std::size_t index) {
  for (const auto unit : outputs_[index].units)
    laboratory_->feed(unit, number_ * drivers::kMostSupplyOutputs + index, outputs_[index].is_on);
}

void VirtualSupply::advance_second() {
  for (const auto index : wired_) protect(index);
}

void VirtualSupply::replay(std::size_t wired, bool on) {
  outputs_[wired_.at(wired)].is_on = on;
  apply(wired_[wired]);
}

FieldValue VirtualSupply::value_of(std::size_t index, const std::string& name, const SupplyItem& item) const {
  const auto& output = outputs_[index];
  const auto measured = measure(output);
  if (name == drivers::kMeasuredVoltage) return measured.voltage_v;
  if (name == drivers::kMeasuredCurrent) return measured.current_a;
  if (!item.flags.empty()) {
    std::uint32_t bits = 0;
    for (const auto& [flag, bit] : item.flags)
      if (output.trips.contains(flag)) bits |= 1U << bit;
    return static_cast<double>(bits);
  }
  const auto code = [&](bool is_second, const char* first, const char* second) {
    return item.codes.at(is_second ? second : first).front();
  };
  if (is_trip(name))
    return code(protection(name).empty() ? !output.trips.empty() : output.trips.contains(protection(name)),
                drivers::kClearCode, drivers::kTrippedCode);
  if (!item.codes.empty())
    return code(name == drivers::kOutputState ? output.is_on : output.trips_at_limit, drivers::kOffCode,
                drivers::kOnCode);
  const auto found = output.values.find(name);
  return found == output.values.end() ? 0.0 : found->second;
}

std::string VirtualSupply::answer_question(std::size_t index, std::size_t question) const {
  const auto& output = description_.outputs[index];
  FieldValues values;
  for (const auto& [name, item] : output.items)
    if (item.question == question) values[item.field] = value_of(index, name, item);
  return output.questions[question].answers.front().format(values);
}

}  // namespace gyrotherm::simulator
