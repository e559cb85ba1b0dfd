#include "sequencer/interlocks/interlocks.hpp"

#include <fmt/format.h>

#include <utility>

#include "sequencer/interlocks/interlock_checks.hpp"

namespace gyrotherm {
namespace {

/// How long, and in how many samples, a cause is there before it acts.
struct Confirmation {
  Duration after{};
  int samples = 1;
};

Confirmation confirmation(const InterlockLimits& limits, InterlockId cause) {
  using std::chrono::seconds;
  switch (cause) {
    case InterlockId::air_limit:
    case InterlockId::thermometer_limit: return {{}, limits.confirming_samples};
    case InterlockId::chamber_silent:
    case InterlockId::thermometers_lost:
    case InterlockId::needed_channel_lost:
    case InterlockId::gyro_silent: return {limits.suspend_after, 1};
    case InterlockId::foreign_set_point: return {{}, 2};
    case InterlockId::chamber_sensor: return {seconds(30), 2};
    case InterlockId::air_rate:
    case InterlockId::thermometer_rate: return {seconds(5), 5};
    case InterlockId::disagreement: return {seconds(60), 60};
    case InterlockId::following: return {limits.follow_time, 2};
    default: return {};
  }
}

/// Silence that ends the run.
std::optional<Duration> lost_after(const InterlockLimits& limits, InterlockId cause) {
  switch (cause) {
    case InterlockId::chamber_silent: return limits.chamber_lost;
    case InterlockId::thermometers_lost: return limits.thermometers_lost;
    case InterlockId::gyro_silent: return limits.gyro_lost;
    default: return std::nullopt;
  }
}

/// What the cause asks for, now that it acts.
Reaction reaction_to(const InterlockLimits& limits, InterlockId cause, const CheckResult& finding, Duration stands) {
  const auto lost = lost_after(limits, cause);
  if (finding.grave || (lost && stands >= *lost)) return Reaction::abort;
  return limits.policy[static_cast<std::size_t>(cause)];
}

/// What is not there, or can no longer be seen.
void clear_in_time(const InterlockLimits& limits, InterlockId cause, Duration elapsed, InterlockMemory::Watch& memory,
                   std::vector<InterlockAlarm>& cleared) {
  memory.gone += elapsed;
  if (!memory.raised || memory.gone < limits.clear_after) return;
  memory.raised = false;
  cleared.push_back({cause, Reaction::go_on, memory.text});
}

/// A reading that is lost is no sign that a cause has gone: it stands as it was last seen, and what was counted stays
/// counted. A longer silence is judged as one.
void wait_unseen(const InterlockLimits& limits, InterlockId cause, Duration elapsed, InterlockResult& judged) {
  auto& memory = judged.memory.watches[static_cast<std::size_t>(cause)];
  memory.unseen += elapsed;
  if (memory.unseen > limits.suspend_after) return clear_in_time(limits, cause, elapsed, memory, judged.cleared);
  if (memory.reaction > judged.demand.reaction) judged.demand = {memory.reaction, memory.text};
}

/// One cause, one second on.
void watch(const InterlockLimits& limits, InterlockId cause, const CheckResults& findings, Duration elapsed,
           InterlockResult& judged) {
  const auto index = static_cast<std::size_t>(cause);
  const auto& finding = findings.found[index];
  auto& memory = judged.memory.watches[index];
  if (!finding && findings.hidden[index] && memory.samples > 0) return wait_unseen(limits, cause, elapsed, judged);
  const auto unseen = std::exchange(memory.unseen, Duration{});
  memory.reaction = {};
  if (!finding) {
    memory.standing = {};
    memory.samples = 0;
    return clear_in_time(limits, cause, elapsed, memory, judged.cleared);
  }
  memory.gone = {};
  memory.standing += elapsed + (unseen <= limits.suspend_after ? unseen : Duration{});
  ++memory.samples;
  memory.column = finding->column;
  memory.text = finding->text;
  const auto needs = confirmation(limits, cause);
  if (memory.standing < needs.after || memory.samples < needs.samples) return;
  memory.reaction = reaction_to(limits, cause, *finding, memory.standing);
  if (lost_after(limits, cause)) memory.text += " for " + spoken(memory.standing);
  if (!std::exchange(memory.raised, true)) judged.raised.push_back({cause, memory.reaction, memory.text});
  if (memory.reaction > judged.demand.reaction) judged.demand = {memory.reaction, memory.text};
}

}  // namespace

InterlockResult judge(const InterlockLimits& limits, InterlockMemory memory, const Sample& sample, Duration elapsed,
                      const InterlockInputs& inputs) {
  remember(limits, sample, elapsed, inputs, memory);
  const auto findings = run_checks(limits, memory, sample, inputs);
  memory.utc_minus_run = sample.at.utc - sample.at.since_start;
  const auto& chamber = sample.chamber.value;
  memory.chamber_answered = chamber.has_value();
  memory.activity_seen = chamber && (memory.activity_seen || chamber->activity != ChamberActivity::unknown);
  InterlockResult judged{.demand = {}, .memory = std::move(memory), .raised = {}, .cleared = {}};
  for (std::size_t i = 0; i < kCauses; ++i) watch(limits, static_cast<InterlockId>(i), findings, elapsed, judged);
  return judged;
}

std::vector<std::string> standing(const InterlockMemory& memory) {
  std::vector<std::string> lines;
  for (const auto& watch : memory.watches)
    if (watch.raised) lines.push_back(watch.text);
  return lines;
}

}  // namespace gyrotherm
