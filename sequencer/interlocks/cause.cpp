#include "sequencer/interlocks/cause.hpp"

namespace gyrotherm {
namespace {

struct Row {
  Cause cause;
  const char* name;
  Reaction usual;
  bool chosen;  ///< by the rig file, if it likes
};

constexpr std::array<Row, kCauses> kTable{{
    {Cause::air_limit, "air_limit", Reaction::abort, false},
    {Cause::thermometer_limit, "thermometer_limit", Reaction::abort, false},
    {Cause::chamber_alarm, "chamber_alarm", Reaction::abort, false},
    {Cause::emergency_stop, "emergency_stop", Reaction::abort, false},
    {Cause::deadline, "deadline", Reaction::abort, false},
    {Cause::program, "program", Reaction::abort, false},
    {Cause::chamber_sensor, "chamber_sensor", Reaction::abort, true},
    {Cause::chamber_silent, "chamber_silent", Reaction::suspend, true},
    {Cause::thermometers_lost, "thermometers_lost", Reaction::suspend, true},
    {Cause::needed_channel_lost, "needed_channel_lost", Reaction::suspend, true},
    {Cause::gyro_silent, "gyro_silent", Reaction::suspend, true},
    {Cause::door, "door", Reaction::suspend, true},
    {Cause::supply, "supply", Reaction::suspend, true},
    {Cause::air_rate, "air_rate", Reaction::suspend, true},
    {Cause::thermometer_rate, "thermometer_rate", Reaction::suspend, true},
    {Cause::following, "following", Reaction::suspend, true},
    {Cause::foreign_set_point, "foreign_set_point", Reaction::suspend, true},
    {Cause::restarted, "restarted", Reaction::suspend, true},
    {Cause::not_taken, "not_taken", Reaction::suspend, true},
    {Cause::slept, "slept", Reaction::hold, true},
    {Cause::storage, "storage", Reaction::warn, true},
    {Cause::record_damaged, "record_damaged", Reaction::warn, true},
    {Cause::unguarded, "unguarded", Reaction::warn, true},
    {Cause::channel_lost, "channel_lost", Reaction::warn, true},
    {Cause::disagreement, "disagreement", Reaction::warn, true},
    {Cause::stuck, "stuck", Reaction::warn, true},
    {Cause::wall_clock, "wall_clock", Reaction::warn, true},
}};

const Row& row(Cause cause) { return kTable[static_cast<std::size_t>(cause)]; }

constexpr bool in_order() {
  for (std::size_t i = 0; i < kCauses; ++i)
    if (static_cast<std::size_t>(kTable[i].cause) != i) return false;
  return true;
}
static_assert(in_order(), "the table is in the order of the causes");

}  // namespace

Reaction usual_reaction(Cause cause) { return row(cause).usual; }
bool may_be_chosen(Cause cause) { return row(cause).chosen; }
const char* name(Cause cause) { return row(cause).name; }

Policy usual_policy() {
  Policy policy{};
  for (std::size_t i = 0; i < kCauses; ++i) policy[i] = kTable[i].usual;
  return policy;
}

const char* name(Reaction reaction) {
  switch (reaction) {
    case Reaction::go_on: return "go_on";
    case Reaction::warn: return "warn";
    case Reaction::suspend: return "suspend";
    case Reaction::hold: return "hold";
    case Reaction::abort: return "abort";
  }
  return "";
}

}  // namespace gyrotherm
