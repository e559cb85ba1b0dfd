// SPDX-License-Identifier: Apache-2.0
#include "tests/sequencer/faults/broken_things.hpp"

namespace gyrotherm::faults {
namespace {

using D = BreakableRun;

/// Seconds of the test profile.
constexpr int kEarly = 10, kFirstHold = 60, kRamp = 400, kHold = 900;

constexpr const char* kCold = R"(
[[segment]]
kind = "hold"
at = 20
time = "1 min"
[[segment]]
kind = "ramp"
to = -20
rate = 5
[[segment]]
kind = "hold"
time = "40 min"
)";
constexpr int kInTheCold = 660;

constexpr const char* kAtRest = R"(
[[segment]]
kind = "hold"
at = 20
time = "2 h"
)";

/// A soak on a thermometer of the unit under test.
constexpr const char* kSoak = R"(
[[segment]]
kind = "hold"
at = 20
time = "10 min"
guaranteed_soak = true
soak_sensor = "A"
soak_band = 10
deadline = "20 min"
[[segment]]
kind = "hold"
time = "10 min"
)";

void condition(D& d, double code) { d.plant().write("condition", code); }
constexpr double kGood = 0, kDoorOpen = 1, kLimiterTripped = 2, kEmergencyStop = 4, kSupplyLost = 5;
void well(D& d) { condition(d, kGood); }

template <class Fault>
void plant(D& d, Fault fault) {
  d.break_plant([&](simulator::LaboratoryFaults& faults) { fault(faults); });
}
void thermometer_off_by(D& d, double kelvins) {
  plant(d, [=](simulator::LaboratoryFaults& faults) { faults.thermometers[0].error_k = kelvins; });
}
void output(D& d, std::optional<double> stuck) {
  plant(d, [=](simulator::LaboratoryFaults& faults) { faults.plant.stuck_output = stuck; });
}
/// The sensor shows too little, and the controller heats until it shows the set point.
void sensor_detached(D& d) {
  plant(d, [](simulator::LaboratoryFaults& faults) { faults.plant.sensor_error_k = -15; });
}
void all_sound(D& d) {
  plant(d, [](simulator::LaboratoryFaults& faults) { faults = {}; });
}

Setting with(std::function<void(rig::RigFile&)> rig, const char* segments = kSteps) {
  return {.segments = segments, .rig = std::move(rig)};
}

void open_door(D& d) {
  plant(d, [](simulator::LaboratoryFaults& faults) { faults.plant.door_open = true; });
  condition(d, kDoorOpen);
}

std::vector<BrokenThing> what_ends_a_run() {
  return {{.shows = "HeatersStuckBeyondTheAirsLimit",
           .cause = interlocks::InterlockId::air_limit,
           .reaction = interlocks::Reaction::abort,
           .at = kFirstHold,
           .breaks = [](D& d) { output(d, 1); },
           .acts_within = 60,
           .setting = with([](rig::RigFile& file) { file.limits.air_highest = {30}; })},
          {.shows = "AThermometerBeyondItsLimit",
           .cause = interlocks::InterlockId::thermometer_limit,
           .reaction = interlocks::Reaction::abort,
           .at = kHold,
           .breaks = [](D& d) { thermometer_off_by(d, 80); },
           .acts_within = 2},
          {.shows = "ATrippedLimiter",
           .cause = interlocks::InterlockId::chamber_alarm,
           .reaction = interlocks::Reaction::abort,
           .at = kRamp,
           .breaks = [](D& d) { condition(d, kLimiterTripped); },
           .acts_within = 3},
          {.shows = "AnEmergencyStop",
           .cause = interlocks::InterlockId::emergency_stop,
           .reaction = interlocks::Reaction::abort,
           .at = kRamp,
           .breaks = [](D& d) { condition(d, kEmergencyStop); },
           .acts_within = 3},
          {.shows = "ASoakThatNeverCounts",
           .cause = interlocks::InterlockId::deadline,
           .reaction = interlocks::Reaction::abort,
           .at = kFirstHold,
           .breaks = [](D& d) { thermometer_off_by(d, 14); },
           .acts_within = 1200,
           .setting = {.segments = kSoak},
           .also = {interlocks::InterlockId::drifting}},
          {.shows = "AProgramEndedAtThePanel",
           .cause = interlocks::InterlockId::program,
           .reaction = interlocks::Reaction::abort,
           .at = kRamp,
           .breaks = [](D& d) { d.plant().write("stop", 1); },
           .acts_within = 90,
           .setting = {.chamber_map = "profiles/chambers/binder_mb2.toml", .by_the_controller = true}}};
}

std::vector<BrokenThing> what_the_chambers_sensor_does() {
  return {{.shows = "TheChambersSensorDetached",
           .cause = interlocks::InterlockId::chamber_sensor,
           .reaction = interlocks::Reaction::abort,
           .at = kFirstHold,
           .breaks = sensor_detached,
           .acts_within = 30},
          {.shows = "TheChambersSensorApartFromAThermometerInTheAir",
           .cause = interlocks::InterlockId::chamber_sensor,
           .reaction = interlocks::Reaction::abort,
           .at = kFirstHold,
           .breaks = sensor_detached,
           .acts_within = 3600,
           .setting = with([](rig::RigFile& file) { file.limits.air_thermometers = {8}; }, kAtRest)}};
}

std::vector<BrokenThing> what_falls_silent() {
  return {{.shows = "TheChambersLineCut",
           .cause = interlocks::InterlockId::chamber_silent,
           .reaction = interlocks::Reaction::suspend,
           .at = kRamp,
           .breaks = [](D& d) { d.plant().chamber().line().trouble.gone = true; },
           .acts_within = 6,
           .repairs = [](D& d) { d.plant().chamber().line().trouble.gone = false; }},
          {.shows = "AThermometersLineCut",
           .cause = interlocks::InterlockId::thermometers_lost,
           .reaction = interlocks::Reaction::suspend,
           .at = kRamp,
           .breaks = [](D& d) { d.plant().thermometer(0).trouble.gone = true; },
           .acts_within = 6,
           .repairs = [](D& d) { d.plant().thermometer(0).trouble.gone = false; },
           .setting = with([](rig::RigFile& file) {
             file.limits.thermometers_needed = 5;
             for (auto& unit : file.limits.units) unit.thermometers.clear();
           }),
           .also = {interlocks::InterlockId::channel_lost}},
          {.shows = "AThermometersLineCutThatTheAnalysisNeeds",
           .cause = interlocks::InterlockId::needed_channel_lost,
           .reaction = interlocks::Reaction::suspend,
           .at = kRamp,
           .breaks = [](D& d) { d.plant().thermometer(1).trouble.gone = true; },
           .acts_within = 6,
           .repairs = [](D& d) { d.plant().thermometer(1).trouble.gone = false; },
           .also = {interlocks::InterlockId::channel_lost}},
          {.shows = "TheGyrosLineCut",
           .cause = interlocks::InterlockId::gyro_silent,
           .reaction = interlocks::Reaction::suspend,
           .at = kRamp,
           .breaks = [](D& d) { d.plant().gyro().line().trouble.gone = true; },
           .acts_within = 8,
           .repairs = [](D& d) { d.plant().gyro().line().trouble.gone = false; }}};
}

std::vector<BrokenThing> what_the_chamber_does() {
  return {
      {.shows = "AnOpenDoor",
       .cause = interlocks::InterlockId::door,
       .reaction = interlocks::Reaction::suspend,
       .at = kHold,
       .breaks = open_door,
       .acts_within = 3,
       .repairs =
           [](D& d) {
             all_sound(d);
             well(d);
           },
       .over_within = 300},
      {.shows = "TheSupplyLost",
       .cause = interlocks::InterlockId::supply,
       .reaction = interlocks::Reaction::suspend,
       .at = kHold,
       .breaks = [](D& d) { condition(d, kSupplyLost); },
       .acts_within = 3,
       .repairs = well},
      {.shows = "ADoorThatNoSwitchTells",
       .cause = interlocks::InterlockId::air_rate,
       .reaction = interlocks::Reaction::suspend,
       .at = kInTheCold,
       .breaks = [](D& d) { plant(d, [](simulator::LaboratoryFaults& faults) { faults.plant.door_open = true; }); },
       .acts_within = 60,
       .repairs = all_sound,
       .over_within = 300,
       .setting = with([](rig::RigFile& file) { file.limits.air_fastest = {12}; }, kCold)},
      {.shows = "HeatersStuckWarmTheArticle",
       .cause = interlocks::InterlockId::thermometer_rate,
       .reaction = interlocks::Reaction::suspend,
       .at = kFirstHold,
       .breaks = [](D& d) { output(d, 1); },
       .acts_within = 120,
       .repairs = [](D& d) { output(d, {}); },
       .over_within = 300,
       .setting = with([](rig::RigFile& file) { file.limits.thermometers_fastest = {2}; })},
      {.shows = "HeatersWithoutPower",
       .cause = interlocks::InterlockId::following,
       .reaction = interlocks::Reaction::suspend,
       .at = kRamp - 60,
       .breaks = [](D& d) { plant(d, [](simulator::LaboratoryFaults& faults) { faults.plant.heating_share = 0; }); },
       .acts_within = 900,
       .repairs = all_sound,
       .over_within = 600},
      {.shows = "HeatersWithoutPowerNearALimit",
       .cause = interlocks::InterlockId::following,
       .reaction = interlocks::Reaction::abort,
       .at = kRamp - 80,
       .breaks = [](D& d) { plant(d, [](simulator::LaboratoryFaults& faults) { faults.plant.heating_share = 0; }); },
       .acts_within = 900,
       .setting = with([](rig::RigFile& file) { file.limits.air_lowest = {19.5}; })}};
}

/// Freezes the first `count` thermometers at their current readings.
void freeze_thermometers(D& d, std::size_t count) {
  const auto shown = d.plant().laboratory().thermometers_as_measured_c();
  plant(d, [&](simulator::LaboratoryFaults& faults) {
    for (std::size_t i = 0; i < count; ++i) faults.thermometers[i].shown_c = shown[i];
  });
}

std::vector<BrokenThing> what_no_longer_measures() {
  return {{.shows = "AFrozenScanner",
           .cause = interlocks::InterlockId::frozen,
           .reaction = interlocks::Reaction::suspend,
           .at = kHold,
           .breaks = [](D& d) { freeze_thermometers(d, 8); },
           .acts_within = 130,
           .repairs = all_sound},
          {.shows = "AFrozenSensorOfTheAir",
           .cause = interlocks::InterlockId::frozen,
           .reaction = interlocks::Reaction::suspend,
           .at = kHold,
           .breaks = [](D& d) { plant(d, [](simulator::LaboratoryFaults& faults) { faults.air_is_frozen = true; }); },
           .acts_within = 400,
           .repairs = all_sound},
          {.shows = "AGyroThatCountsNothing",
           .cause = interlocks::InterlockId::gyro_dead,
           .reaction = interlocks::Reaction::suspend,
           .at = kRamp,
           .breaks = [](D& d) { d.plant().gyro().trouble.dead = true; },
           .acts_within = 65,
           .repairs = [](D& d) { d.plant().gyro().trouble.dead = false; }},
          {.shows = "ThermometersOutsideTheChamber",
           .cause = interlocks::InterlockId::no_thermal_response,
           .reaction = interlocks::Reaction::hold,
           .at = kFirstHold,
           .breaks = [](D& d) { freeze_thermometers(d, 9); },
           .acts_within = 1000,
           .repairs = all_sound,
           .setting = with([](rig::RigFile& file) {
             file.limits.frozen_after = std::chrono::hours(10);
             file.limits.response_step = {15};
             file.limits.response_time = std::chrono::minutes(5);
             file.limits.thermometers_fastest = {1000};
           })}};
}

std::vector<BrokenThing> what_becomes_of_set_points() {
  return {{.shows = "ASetPointFromThePanel",
           .cause = interlocks::InterlockId::foreign_set_point,
           .reaction = interlocks::Reaction::suspend,
           .at = kHold,
           .breaks = [](D& d) { d.plant().laboratory().change_set_point({45}); },
           .acts_within = 2,
           .repairs = [](D& d) { d.plant().laboratory().change_set_point({40}); }},
          {.shows = "SwitchedOffAtThePanel",
           .cause = interlocks::InterlockId::foreign_set_point,
           .reaction = interlocks::Reaction::suspend,
           .at = kHold,
           .breaks = [](D& d) { d.plant().laboratory().switch_on(false); },
           .acts_within = 5,
           .repairs = [](D& d) { d.plant().laboratory().switch_on(true); }},
          {.shows = "ManualMode",
           .cause = interlocks::InterlockId::not_following,
           .reaction = interlocks::Reaction::suspend,
           .at = kHold,
           .breaks = [](D& d) { d.plant().write("control_mode", 2); },
           .acts_within = 5,
           .repairs = [](D& d) { d.plant().write("control_mode", 1); }},
          {.shows = "APowerCutOfTheChamber",
           .cause = interlocks::InterlockId::restarted,
           .reaction = interlocks::Reaction::suspend,
           .at = kHold,
           .breaks =
               [](D& d) {
                 d.plant().chamber().line().trouble.gone = true;
                 d.seconds(2);
                 d.plant().restart_chamber({20}, true);
                 d.plant().chamber().line().trouble.gone = false;
               },
           .acts_within = 5,
           .over_within = 600,
           .brought_back = true},
          {.shows = "AChamberTakenOffTheMains",
           .cause = interlocks::InterlockId::restarted_off,
           .reaction = interlocks::Reaction::hold,
           .at = kHold,
           .breaks =
               [](D& d) {
                 d.plant().chamber().line().trouble.gone = true;
                 d.seconds(2);
                 d.plant().restart_chamber({40}, false);
                 d.plant().chamber().line().trouble.gone = false;
               },
           .acts_within = 5,
           .repairs = [](D& d) { d.plant().laboratory().switch_on(true); }},
          {.shows = "AnotherChamberAtTheAddress",
           .cause = interlocks::InterlockId::another_instrument,
           .reaction = interlocks::Reaction::hold,
           .at = kHold,
           .breaks =
               [](D& d) {
                 d.plant().chamber().line().trouble.gone = true;
                 d.seconds(2);
                 d.plant().write("identity", 4711);
                 d.plant().chamber().line().trouble.gone = false;
               },
           .acts_within = 2,
           .repairs = [](D& d) { d.plant().write("identity", 21868); }},
          {.shows = "SetPointsAcknowledgedAndNotApplied",
           .cause = interlocks::InterlockId::not_taken,
           .reaction = interlocks::Reaction::suspend,
           .at = kRamp,
           .breaks = [](D& d) { d.plant().chamber().trouble.ignores_writes = true; },
           .acts_within = 5,
           .repairs = [](D& d) { d.plant().chamber().trouble.ignores_writes = false; },
           .over_within = 120}};
}

std::vector<BrokenThing> what_computers_do() {
  return {{.shows = "AMachineThatSlept",
           .cause = interlocks::InterlockId::slept,
           .reaction = interlocks::Reaction::hold,
           .at = kHold,
           .breaks = [](D& d) { d.sleep(121); },
           .acts_within = 1},
          {.shows = "AFullDisk",
           .cause = interlocks::InterlockId::storage,
           .reaction = interlocks::Reaction::warn,
           .at = kEarly,
           .breaks = [](D& d) { d.fill_disk(); },
           .acts_within = 62,
           .repairs = [](D& d) { d.make_room_on_disk(); },
           .over_within = 11,
           .setting = {.rows_on_disk = 14'400}},
          {.shows = "AFullDiskForLongerThanTheMemoryHolds",
           .cause = interlocks::InterlockId::storage,
           .reaction = interlocks::Reaction::warn,
           .at = kEarly,
           .breaks = [](D& d) { d.fill_disk(); },
           .acts_within = 60,
           .repairs = [](D& d) { d.make_room_on_disk(); },
           .over_within = 11,
           .setting = {.rows_on_disk = 40}}};
}

std::vector<BrokenThing> what_only_warns() {
  return {{.shows = "AThermometersLineCutThatTheAnalysisDoesNotNeed",
           .cause = interlocks::InterlockId::channel_lost,
           .reaction = interlocks::Reaction::warn,
           .at = kRamp,
           .breaks = [](D& d) { d.plant().thermometer(1).trouble.gone = true; },
           .acts_within = 1,
           .repairs = [](D& d) { d.plant().thermometer(1).trouble.gone = false; },
           .setting = with([](rig::RigFile& file) {
             for (auto& unit : file.limits.units) unit.thermometers.clear();
           })},
          {.shows = "TheLineCutOfOneOfTwoGyros",
           .cause = interlocks::InterlockId::unit_silent,
           .reaction = interlocks::Reaction::warn,
           .at = kRamp,
           .breaks = [](D& d) { d.plant().gyro(1).line().trouble.gone = true; },
           .acts_within = 8,
           .repairs = [](D& d) { d.plant().gyro(1).line().trouble.gone = false; },
           .setting = with([](rig::RigFile& file) {
             file.units.push_back(file.units.front());
             file.units.back().info.name = "other";
             file.gyro_lines.push_back(file.gyro_lines.front());
             file.gyro_lines.back().shares.front().unit = 1;
             file.limits.units.push_back(file.limits.units.front());
             file.limits.units.back() = {.name = "other", .continue_when_silent = true};
           })},
          {.shows = "ARecordWhoseFileIsTakenAway",
           .cause = interlocks::InterlockId::record_damaged,
           .reaction = interlocks::Reaction::warn,
           .at = kEarly,
           .breaks = [](D& d) { d.take_record_away(); },
           .acts_within = 2,
           .setting = {.rows_on_disk = 14'400},
           .for_good = true},
          {.shows = "AGuardThatHasEnded",
           .cause = interlocks::InterlockId::unguarded,
           .reaction = interlocks::Reaction::warn,
           .at = kEarly,
           .breaks =
               [](D& d) {
                 d.run_controller().set_guard_troubles({{"guard", "the guard has ended"}});
               },
           .acts_within = 1,
           .repairs = [](D& d) { d.run_controller().set_guard_troubles({}); }},
          {.shows = "AThermometerApartFromTheOthers",
           .cause = interlocks::InterlockId::disagreement,
           .reaction = interlocks::Reaction::warn,
           .at = kFirstHold,
           .breaks = [](D& d) { thermometer_off_by(d, 40); },
           .acts_within = 61,
           .repairs = all_sound,
           .over_within = 11,
           .setting = with([](rig::RigFile& file) {
             file.limits.disagreement = {30};
             file.limits.thermometers_fastest = {50};
           }),
           .also = {interlocks::InterlockId::drifting}},
          {.shows = "AThermometerThatJumps",
           .cause = interlocks::InterlockId::drifting,
           .reaction = interlocks::Reaction::warn,
           .at = kFirstHold,
           .breaks = [](D& d) { thermometer_off_by(d, 3); },
           .acts_within = 31,
           .repairs = all_sound,
           .over_within = 12},
          {.shows = "AFrozenThermometer",
           .cause = interlocks::InterlockId::stuck,
           .reaction = interlocks::Reaction::warn,
           .at = kRamp,
           .breaks =
               [](D& d) {
                 const auto shown = d.plant().laboratory().thermometers_as_measured_c()[0];
                 plant(d, [=](simulator::LaboratoryFaults& faults) { faults.thermometers[0].shown_c = shown; });
               },
           .acts_within = 600,
           .repairs = all_sound,
           .over_within = 11},
          {.shows = "AStepOfTheTimeOfDay",
           .cause = interlocks::InterlockId::wall_clock,
           .reaction = interlocks::Reaction::warn,
           .at = kRamp,
           .breaks = [](D& d) { d.clock().step_utc(std::chrono::hours(-1)); },
           .acts_within = 1,
           .over_within = 11}};
}

}  // namespace

const std::vector<BrokenThing>& broken_things() {
  static const std::vector<BrokenThing> all = [] {
    std::vector<BrokenThing> things;
    for (const auto& some :
         {what_ends_a_run(), what_the_chambers_sensor_does(), what_falls_silent(), what_no_longer_measures(),
          what_the_chamber_does(), what_becomes_of_set_points(), what_computers_do(), what_only_warns()})
      things.insert(things.end(), some.begin(), some.end());
    return things;
  }();
  return all;
}

}  // namespace gyrotherm::faults
