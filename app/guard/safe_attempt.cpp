#include "app/guard/safe_attempt.hpp"

#include <fmt/format.h>

#include <cmath>

#include "drivers/chamber/chamber_lock.hpp"
#include "drivers/chamber/modbus_chamber.hpp"
#include "drivers/chamber/set_point_tolerance.hpp"
#include "drivers/line/line_address.hpp"
#include "drivers/line/modbus.hpp"

namespace gyrotherm {
namespace {

constexpr Duration kBetweenTries = std::chrono::seconds(2);
constexpr Duration kLastTryBefore = std::chrono::seconds(7);

/// What the chamber says once it has taken the safe set point.
Result<std::string> try_once(Chamber& chamber, const SafeGoal& goal) {
  if (auto sent = chamber.head_for(goal.set_point); !sent) return failure(sent.error());
  const auto off = goal.switch_off ? chamber.stop() : Result<void>();
  const auto state = chamber.read();
  if (!state) return failure(state.error());
  if (!std::isnan(state->set_point.value) && abs(state->set_point - goal.set_point) > goal.tolerance)
    return failure(FaultKind::mismatch, "chamber set point",
                   fmt::format("reads {:g} after {:g} was written", state->set_point.value, goal.set_point.value));
  if (!off) return failure(off.error());
  return fmt::format("set point read back, air {:.2f} °C{}", state->air.value,
                     goal.switch_off ? ", conditioning switched off" : "");
}

}  // namespace

SafeAttempt attempt_safe(const SafeGoal& goal, const AttemptMeans& means) {
  SafeAttempt attempt;
  const auto began = means.clock.now().since_start;
  while (attempt.tries < kSafeTries && means.clock.now().since_start - began < kLastTryBefore) {
    if (attempt.tries++ > 0) means.wait(kBetweenTries);
    const auto answer = try_once(*means.connect(), goal);
    attempt.confirmed = answer.has_value();
    attempt.details = answer ? *answer : text(answer.error());
    if (attempt.confirmed) break;
  }
  return attempt;
}

Result<ArmedChamber> chamber_of(const Armed& armed) {
  const auto where = armed_path(armed.record);
  const auto line = parse_line(armed.line);
  if (!line || !carries_bytes(*line)) return failure(FaultKind::bad_file, where, "its line leads to no chamber");
  auto map = parse_register_map(armed.map_text, where + " (register map)", armed.word_order);
  if (!map) return failure(map.error());
  const auto linked = on_link(std::move(*map), armed.link);
  if (!linked) return failure(FaultKind::bad_file, where, linked.error().what);
  return ArmedChamber{.place = chamber_place(*line, linked->link.modbus.port, linked->link.modbus.unit),
                      .goal = {armed.safe_set_point, set_point_tolerance(*linked), armed.switch_off},
                      .connect = [map = *linked, line = *line] {
                        return make_modbus_chamber(map, make_modbus(line, map.link.modbus));
                      }};
}

}  // namespace gyrotherm
