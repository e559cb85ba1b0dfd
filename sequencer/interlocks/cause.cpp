#include "sequencer/interlocks/cause.hpp"

namespace gyrotherm {
namespace {

struct Row {
  InterlockId cause;
  const char* name;
  Reaction usual;
  bool chosen;  ///< by the rig file, if it likes
};

constexpr std::array<Row, kCauses> kTable{{
    {InterlockId::air_limit, "air_limit", Reaction::abort, false},
    {InterlockId::thermometer_limit, "thermometer_limit", Reaction::abort, false},
    {InterlockId::chamber_alarm, "chamber_alarm", Reaction::abort, false},
    {InterlockId::emergency_stop, "emergency_stop", Reaction::abort, false},
    {InterlockId::deadline, "deadline", Reaction::abort, false},
    {InterlockId::program, "program", Reaction::abort, false},
    {InterlockId::chamber_sensor, "chamber_sensor", Reaction::abort, true},
    {InterlockId::chamber_silent, "chamber_silent", Reaction::suspend, true},
    {InterlockId::thermometers_lost, "thermometers_lost", Reaction::suspend, true},
    {InterlockId::needed_channel_lost, "needed_channel_lost", Reaction::suspend, true},
    {InterlockId::gyro_silent, "gyro_silent", Reaction::suspend, true},
    {InterlockId::door, "door", Reaction::suspend, true},
    {InterlockId::supply, "supply", Reaction::suspend, true},
    {InterlockId::air_rate, "air_rate", Reaction::suspend, true},
    {InterlockId::thermometer_rate, "thermometer_rate", Reaction::suspend, true},
    {InterlockId::following, "following", Reaction::suspend, true},
    {InterlockId::foreign_set_point, "foreign_set_point", Reaction::suspend, true},
    {InterlockId::restarted, "restarted", Reaction::suspend, true},
    {InterlockId::not_taken, "not_taken", Reaction::suspend, true},
    {InterlockId::slept, "slept", Reaction::hold, true},
    {InterlockId::storage, "storage", Reaction::warn, true},
    {InterlockId::record_damaged, "record_damaged", Reaction::warn, true},
    {InterlockId::unguarded, "unguarded", Reaction::warn, true},
    {InterlockId::channel_lost, "channel_lost", Reaction::warn, true},
    {InterlockId::disagreement, "disagreement", Reaction::warn, true},
    {InterlockId::stuck, "stuck", Reaction::warn, true},
    {InterlockId::wall_clock, "wall_clock", Reaction::warn, true},
}};

const Row& row(InterlockId cause) { return kTable[static_cast<std::size_t>(cause)]; }

constexpr bool in_order() {
  for (std::size_t i = 0; i < kCauses; ++i)
    if (static_cast<std::size_t>(kTable[i].cause) != i) return false;
  return true;
}
static_assert(in_order(), "the table is in the order of the causes");

}  // namespace

Reaction usual_reaction(InterlockId cause) { return row(cause).usual; }
bool may_be_chosen(InterlockId cause) { return row(cause).chosen; }
const char* name(InterlockId cause) { return row(cause).name; }

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
