// SPDX-License-Identifier: Apache-2.0
#include "rig/inquiry.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "drivers/chamber/register_map.hpp"

namespace gyrotherm::rig {
namespace {

constexpr std::size_t kCalls = 10;
constexpr int kSeconds = 2;

double in_ms(Duration time) { return to_seconds(time) * 1e3; }

Result<std::vector<std::uint16_t>> words_of(const drivers::RegisterItem& item, drivers::Registers& registers) {
  const auto count = std::max<std::uint16_t>(item.read_count, word_count(item.type));
  return registers.read(item.read_function.value_or(drivers::ReadFunction::holding_registers), item.address, count);
}

}  // namespace

RoundTrips time_calls(const std::function<void()>& call, const Clock& clock) {
  std::array<Duration, kCalls> times{};
  for (auto& time : times) {
    const auto before = clock.now().since_start;
    call();
    time = clock.now().since_start - before;
  }
  std::ranges::sort(times);
  return {.least = times.front(), .median = (times[kCalls / 2 - 1] + times[kCalls / 2]) / 2, .most = times.back()};
}

std::string text(const RoundTrips& trips) {
  return fmt::format("{} reads: {:.3f}, {:.3f}, {:.3f} ms (least, median, most)", kCalls, in_ms(trips.least),
                     in_ms(trips.median), in_ms(trips.most));
}

/// The same shares of a second as in drivers/chamber/status_turns.cpp.
std::string in_words(const drivers::ChamberEffort& effort) {
  constexpr double kSecondsWork = 0.95;
  constexpr int kReadingsAPiece = 5;
  if (effort.each_second == 0 || effort.longest == Duration{}) return {};
  const double exchange = to_seconds(effort.longest);
  const int needed = effort.each_second + effort.new_set_point;
  const auto spare = static_cast<int>((kSecondsWork - needed * exchange) / exchange);
  const int status_s = spare > 0 ? (effort.status + spare - 1) / spare : effort.status * kReadingsAPiece;
  const auto status = effort.status == 0 ? std::string()
                                         : fmt::format("; its state and alarms, {} more, are read in turn within {} s",
                                                       effort.status, std::max(status_s, 1));
  const auto what = fmt::format("{} exchanges of {:.3f} s for air, set point and a new one", needed, exchange);
  if (needed * exchange <= kSecondsWork) return what + " fit into a second" + status;
  return fmt::format(
      "WARNING: {} do NOT fit into a second{}. Readings and set points will be missing: use Modbus TCP or a faster "
      "serial line; where the unit allows it, let its register map say one_block or holes (fewer reads), or seen_later "
      "for the set point",
      what, status);
}

Result<std::string> ask_word_order(const drivers::RegisterMap& map, drivers::Registers& registers) {
  const auto* air = map.find("air_temperature");
  const auto* set_point = map.find("set_point");
  if (!air || !set_point || !set_point->readable) return std::string();
  if (word_count(air->type) < 2 || word_count(set_point->type) < 2) return std::string();
  const auto air_words = words_of(*air, registers);
  if (!air_words) return failure(air_words.error());
  const auto set_point_words = words_of(*set_point, registers);
  if (!set_point_words) return failure(set_point_words.error());
  return in_words(probe_word_order(*air, *air_words, *set_point, *set_point_words));
}

Result<std::string> ask_chamber(drivers::Chamber& chamber, const Clock& clock) {
  const auto name = chamber.identify();
  if (!name) return failure(name.error());
  const auto state = chamber.inspect();
  if (!state) return failure(state.error());
  const auto trips = time_calls([&] { (void)chamber.read(); }, clock);
  auto line = fmt::format("{}, air {:.2f} °C, set point {:.2f} °C", *name, state->air.value, state->set_point.value);
  if (state->activity != ChamberActivity::unknown) line += fmt::format(", {}", gyrotherm::name(state->activity));
  if (!state->alarms.empty()) line += fmt::format(", ALARMS: {}", fmt::join(state->alarms, "; "));
  for (const auto& one : chamber.missing()) line += "; WARNING: not watched, the unit does not have it: " + one;
  const auto effort = in_words(chamber.effort());
  return line + "; " + text(trips) + (effort.empty() ? "" : "; " + effort);
}

Result<std::string> ask_thermometer(drivers::Thermometer& thermometer, const std::vector<std::string>& channels,
                                    const Clock& clock) {
  const auto name = thermometer.identify();
  if (!name) return failure(name.error());
  auto line = *name;
  const auto readings = thermometer.read();
  for (std::size_t i = 0; i < channels.size(); ++i)
    line += readings[i] ? fmt::format(", {} {:.3f} °C", channels[i], readings[i]->value)
                        : fmt::format(", {} {}", channels[i], readings[i].error().what);
  return line + "; " + text(time_calls([&] { (void)thermometer.read(); }, clock));
}

Result<std::string> ask_analogue(drivers::AnalogueInputs& inputs, const std::vector<AnalogueReading>& channels,
                                 const Clock& clock) {
  const auto name = inputs.identify();
  if (!name) return failure(name.error());
  auto line = *name;
  const auto readings = inputs.read();
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const auto& [channel, unit, scale, offset] = channels[i];
    line += readings[i] ? fmt::format(", {} {:g} {}", channel, *readings[i] * scale + offset, unit)
                        : fmt::format(", {} {}", channel, readings[i].error().what);
  }
  return line + "; " + text(time_calls([&] { (void)inputs.read(); }, clock));
}

Result<std::string> ask_gyro(drivers::Gyro& gyro, const drivers::FrameFormat& frames,
                             const std::function<void()>& let_pass) {
  if (auto opened = gyro.open(); !opened) return failure(opened.error());
  let_pass();
  if (const auto origin = gyro.take_origin(); !origin) return failure(origin.error());
  const auto before = gyro.frames();
  std::vector<std::int64_t> sums(std::max<std::size_t>(frames.axes.size(), 1));
  Duration interval{};
  std::vector<double> values;
  for (int i = 0; i < kSeconds; ++i) {
    let_pass();
    const auto count = gyro.read(kSecond);
    if (!count) return failure(count.error());
    for (std::size_t axis = 0; axis < sums.size() && axis < count->pulses.size(); ++axis)
      sums[axis] += count->pulses[axis];
    interval += count->interval;
    values = count->values;
  }
  const auto after = gyro.frames();
  auto line = fmt::format("{} frames, {} counts in {:.6f} s", frames.name, fmt::join(sums, ", "), to_seconds(interval));
  const auto names = drivers::housekeeping_of(frames);
  for (std::size_t i = 0; i < names.size() && i < values.size(); ++i)
    line += fmt::format(", {} {:g} {}", names[i].name, values[i], names[i].unit);
  return line + fmt::format("; {} frames seen, {} lost, {} bad", after.seen - before.seen, after.lost - before.lost,
                            after.bad - before.bad);
}

}  // namespace gyrotherm::rig
