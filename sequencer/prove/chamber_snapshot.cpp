// SPDX-License-Identifier: Apache-2.0
#include "sequencer/prove/chamber_snapshot.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "drivers/chamber/text_registers.hpp"
#include "sequencer/prove/drill.hpp"

namespace gyrotherm::prove {
namespace {

bool is_kept(const drivers::RegisterItem& item) {
  return item.readable && item.writable && !item.self_clearing && item.type != drivers::RegisterType::date_time;
}

std::string words_text(const std::vector<std::uint16_t>& words) { return fmt::format("{:04X}", fmt::join(words, " ")); }

}  // namespace

Result<ChamberSnapshot::Words> ChamberSnapshot::read(drivers::Registers& registers,
                                                     const drivers::RegisterItem& item) const {
  return registers.read(item.read_function.value_or(drivers::ReadFunction::holding_registers), item.address,
                        word_count(item));
}

Result<ChamberSnapshot> ChamberSnapshot::take(const drivers::RegisterMap& map, drivers::Registers& registers,
                                              drivers::Chamber& chamber) {
  ChamberSnapshot snapshot(map);
  const auto state = chamber.inspect();
  if (!state) return failure(state.error());
  snapshot.state_ = *state;
  for (const auto& item : map.items) {
    if (!is_kept(item)) continue;
    const auto words = snapshot.read(registers, item);
    if (words && !has_no_value(map, item, *words)) snapshot.found_[item.name] = *words;
    if (!words && words.error().kind != FaultKind::refused && words.error().kind != FaultKind::out_of_range)
      return failure(words.error());
  }
  return snapshot;
}

Result<std::vector<ProofRegister>> ChamberSnapshot::compare(drivers::Registers& registers) const {
  std::vector<ProofRegister> all;
  for (const auto& [name, before] : found_) {
    const auto words = read(registers, *map_->find(name));
    if (!words) return failure(words.error());
    all.push_back({name, words_text(before), words_text(*words)});
  }
  return all;
}

Result<void> ChamberSnapshot::restore(drivers::Registers& registers, drivers::Chamber& chamber) const {
  const bool was_off = state_.activity == ChamberActivity::off;
  if (was_off)
    if (const auto stopped = chamber.stop(); !stopped) return stopped;
  if (!was_off && !std::isnan(state_.set_point.value))
    if (const auto sent = chamber.send_set_point_immediately(state_.set_point); !sent) return sent;
  const auto now = chamber.inspect();
  if (!now) return failure(now.error());
  if (!was_off && now->activity != state_.activity)
    if (const auto started = chamber.start(); !started) return started;
  for (const auto& [name, before] : found_) {
    const auto& item = *map_->find(name);
    const auto words = read(registers, item);
    if (!words) return failure(words.error());
    if (*words == before) continue;
    if (const auto written = registers.write(write_function(item.write_function, before.size()), item.address, before);
        !written)
      return written;
    const auto shown = read(registers, item);
    if (!shown) return failure(shown.error());
    if (*shown != before)
      return failure(FaultKind::mismatch, place(item),
                     fmt::format("reads {} after {} was restored", words_text(*shown), words_text(before)));
  }
  return {};
}

std::string ChamberSnapshot::describe_lost_state(Celsius safe) const {
  if (!std::isnan(state_.set_point.value)) return "";
  const bool is_unknown = state_.activity == ChamberActivity::unknown;
  return fmt::format("the chamber does not show its set point{}: it is left at the safe set point of {:g} °C",
                     is_unknown ? " and its mode" : "", safe.value);
}

std::string refusal_reason(const ChamberState& state) {
  if (has_alarm(state))
    return fmt::format("the chamber reports an alarm: {}", state.alarms.empty() ? "unnamed" : state.alarms.front());
  if (state.activity == ChamberActivity::running && std::isnan(state.set_point.value))
    return "the chamber runs and does not show its set point, which could not be restored; switch it off first";
  switch (state.activity) {
    case ChamberActivity::off:
    case ChamberActivity::running:
    case ChamberActivity::unknown: return "";
    default:
      return fmt::format("the chamber reports \"{}\"; expected that it is off or follows its set point",
                         name(state.activity));
  }
}

}  // namespace gyrotherm::prove
