// SPDX-License-Identifier: Apache-2.0
#include "tests/sequencer/faults/broken_things.hpp"

#include <string>
#include <utility>

#include "core/file.hpp"
#include "drivers/supply/supply_description.hpp"

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

void set_condition(D& d, double code) { d.plant().write("condition", code); }
constexpr double kGood = 0, kDoorOpen = 1, kLimiterTripped = 2, kEmergencyStop = 4, kSupplyLost = 5;
void clear_condition(D& d) { set_condition(d, kGood); }

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
void remove_laboratory_faults(D& d) {
  plant(d, [](simulator::LaboratoryFaults& faults) { faults = {}; });
}

Setting with(std::function<void(rig::RigFile&)> rig, const char* segments = kSteps) {
  return {.segments = segments, .rig = std::move(rig)};
}

void open_door(D& d) {
  plant(d, [](simulator::LaboratoryFaults& faults) { faults.plant.door_open = true; });
  set_condition(d, kDoorOpen);
}

std::vector<BrokenThing> aborting_faults() {
  return {{.name = "HeatersStuckAboveAirLimit",
           .cause = interlocks::InterlockId::air_limit,
           .reaction = interlocks::Reaction::abort,
           .at = kFirstHold,
           .breaks = [](D& d) { output(d, 1); },
           .acts_within = 60,
           .setting = with([](rig::RigFile& file) { file.limits.air_highest = {25}; })},
          {.name = "ThermometerOutsideLimit",
           .cause = interlocks::InterlockId::thermometer_limit,
           .reaction = interlocks::Reaction::abort,
           .at = kHold,
           .breaks = [](D& d) { thermometer_off_by(d, 80); },
           .acts_within = 2},
          {.name = "TrippedLimiter",
           .cause = interlocks::InterlockId::chamber_alarm,
           .reaction = interlocks::Reaction::abort,
           .at = kRamp,
           .breaks = [](D& d) { set_condition(d, kLimiterTripped); },
           .acts_within = 3},
          {.name = "EmergencyStop",
           .cause = interlocks::InterlockId::emergency_stop,
           .reaction = interlocks::Reaction::abort,
           .at = kRamp,
           .breaks = [](D& d) { set_condition(d, kEmergencyStop); },
           .acts_within = 3},
          {.name = "SoakThatNeverCounts",
           .cause = interlocks::InterlockId::deadline,
           .reaction = interlocks::Reaction::abort,
           .at = kFirstHold,
           .breaks = [](D& d) { thermometer_off_by(d, 14); },
           .acts_within = 1200,
           .setting = {.segments = kSoak},
           .also = {interlocks::InterlockId::drifting}},
          {.name = "ProgramEndedAtPanel",
           .cause = interlocks::InterlockId::program,
           .reaction = interlocks::Reaction::abort,
           .at = kRamp,
           .breaks = [](D& d) { d.plant().write("stop", 1); },
           .acts_within = 90,
           .setting = {.chamber_map = "profiles/chambers/binder_mb2.toml", .by_the_controller = true}}};
}

std::vector<BrokenThing> chamber_sensor_faults() {
  return {{.name = "ChamberSensorDetached",
           .cause = interlocks::InterlockId::chamber_sensor,
           .reaction = interlocks::Reaction::abort,
           .at = kFirstHold,
           .breaks = sensor_detached,
           .acts_within = 30},
          {.name = "ChamberSensorDiffersFromAirThermometer",
           .cause = interlocks::InterlockId::chamber_sensor,
           .reaction = interlocks::Reaction::abort,
           .at = kFirstHold,
           .breaks = sensor_detached,
           .acts_within = 3600,
           .setting = with([](rig::RigFile& file) { file.limits.air_thermometers = {8}; }, kAtRest)}};
}

std::vector<BrokenThing> silence_faults() {
  return {{.name = "ChamberLineCut",
           .cause = interlocks::InterlockId::chamber_silent,
           .reaction = interlocks::Reaction::suspend,
           .at = kRamp,
           .breaks = [](D& d) { d.plant().chamber().line().trouble.gone = true; },
           .acts_within = 6,
           .repairs = [](D& d) { d.plant().chamber().line().trouble.gone = false; }},
          {.name = "ThermometerLineCut",
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
          {.name = "NeededThermometerLineCut",
           .cause = interlocks::InterlockId::needed_channel_lost,
           .reaction = interlocks::Reaction::suspend,
           .at = kRamp,
           .breaks = [](D& d) { d.plant().thermometer(1).trouble.gone = true; },
           .acts_within = 6,
           .repairs = [](D& d) { d.plant().thermometer(1).trouble.gone = false; },
           .also = {interlocks::InterlockId::channel_lost}},
          {.name = "GyroLineCut",
           .cause = interlocks::InterlockId::gyro_silent,
           .reaction = interlocks::Reaction::suspend,
           .at = kRamp,
           .breaks = [](D& d) { d.plant().gyro().line().trouble.gone = true; },
           .acts_within = 8,
           .repairs = [](D& d) { d.plant().gyro().line().trouble.gone = false; }}};
}

std::vector<BrokenThing> chamber_faults() {
  return {
      {.name = "OpenDoor",
       .cause = interlocks::InterlockId::door,
       .reaction = interlocks::Reaction::suspend,
       .at = kHold,
       .breaks = open_door,
       .acts_within = 3,
       .repairs =
           [](D& d) {
             remove_laboratory_faults(d);
             clear_condition(d);
           },
       .clears_within = 300},
      {.name = "PowerSupplyLost",
       .cause = interlocks::InterlockId::supply,
       .reaction = interlocks::Reaction::suspend,
       .at = kHold,
       .breaks = [](D& d) { set_condition(d, kSupplyLost); },
       .acts_within = 3,
       .repairs = clear_condition},
      {.name = "OpenDoorWithoutSwitch",
       .cause = interlocks::InterlockId::air_rate,
       .reaction = interlocks::Reaction::suspend,
       .at = kInTheCold,
       .breaks = [](D& d) { plant(d, [](simulator::LaboratoryFaults& faults) { faults.plant.door_open = true; }); },
       .acts_within = 60,
       .repairs = remove_laboratory_faults,
       .clears_within = 300,
       .setting = with([](rig::RigFile& file) { file.limits.air_fastest = {12}; }, kCold)},
      {.name = "HeatersStuckWarmUnit",
       .cause = interlocks::InterlockId::thermometer_rate,
       .reaction = interlocks::Reaction::suspend,
       .at = kHold,
       .breaks = [](D& d) { output(d, 1); },
       .acts_within = 120,
       .repairs = [](D& d) { output(d, {}); },
       .clears_within = 300,
       .setting = with([](rig::RigFile& file) { file.limits.thermometers_fastest = {2}; })},
      {.name = "HeatersWithoutPower",
       .cause = interlocks::InterlockId::following,
       .reaction = interlocks::Reaction::suspend,
       .at = kRamp - 60,
       .breaks = [](D& d) { plant(d, [](simulator::LaboratoryFaults& faults) { faults.plant.heating_share = 0; }); },
       .acts_within = 900,
       .repairs = remove_laboratory_faults,
       .clears_within = 600},
      {.name = "HeatersWithoutPowerNearLimit",
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

std::vector<BrokenThing> frozen_instrument_faults() {
  return {{.name = "FrozenScanner",
           .cause = interlocks::InterlockId::frozen,
           .reaction = interlocks::Reaction::suspend,
           .at = kHold,
           .breaks = [](D& d) { freeze_thermometers(d, 8); },
           .acts_within = 130,
           .repairs = remove_laboratory_faults},
          {.name = "FrozenAirSensor",
           .cause = interlocks::InterlockId::frozen,
           .reaction = interlocks::Reaction::suspend,
           .at = kHold,
           .breaks = [](D& d) { plant(d, [](simulator::LaboratoryFaults& faults) { faults.air_is_frozen = true; }); },
           .acts_within = 400,
           .repairs = remove_laboratory_faults},
          {.name = "GyroWithoutCounts",
           .cause = interlocks::InterlockId::gyro_dead,
           .reaction = interlocks::Reaction::suspend,
           .at = kRamp,
           .breaks = [](D& d) { d.plant().gyro().trouble.dead = true; },
           .acts_within = 65,
           .repairs = [](D& d) { d.plant().gyro().trouble.dead = false; }},
          {.name = "ThermometersOutsideTheChamber",
           .cause = interlocks::InterlockId::no_thermal_response,
           .reaction = interlocks::Reaction::hold,
           .at = kFirstHold,
           .breaks = [](D& d) { freeze_thermometers(d, 9); },
           .acts_within = 1000,
           .repairs = remove_laboratory_faults,
           .setting = with([](rig::RigFile& file) {
             file.limits.frozen_after = std::chrono::hours(10);
             file.limits.response_step = {15};
             file.limits.response_time = std::chrono::minutes(5);
             file.limits.thermometers_fastest = {1000};
           })}};
}

std::vector<BrokenThing> set_point_faults() {
  return {{.name = "SetPointFromPanel",
           .cause = interlocks::InterlockId::foreign_set_point,
           .reaction = interlocks::Reaction::suspend,
           .at = kHold,
           .breaks = [](D& d) { d.plant().laboratory().change_set_point({45}); },
           .acts_within = 2,
           .repairs = [](D& d) { d.plant().laboratory().change_set_point({40}); }},
          {.name = "SwitchedOffAtPanel",
           .cause = interlocks::InterlockId::foreign_set_point,
           .reaction = interlocks::Reaction::suspend,
           .at = kHold,
           .breaks = [](D& d) { d.plant().laboratory().switch_on(false); },
           .acts_within = 5,
           .repairs = [](D& d) { d.plant().laboratory().switch_on(true); }},
          {.name = "ManualMode",
           .cause = interlocks::InterlockId::not_following,
           .reaction = interlocks::Reaction::suspend,
           .at = kHold,
           .breaks = [](D& d) { d.plant().write("control_mode", 2); },
           .acts_within = 5,
           .repairs = [](D& d) { d.plant().write("control_mode", 1); }},
          {.name = "ChamberPowerCut",
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
           .clears_within = 600,
           .returns_to_set_point = true},
          {.name = "ChamberDisconnectedFromMains",
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
          {.name = "OtherChamberAtAddress",
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
          {.name = "SetPointsAcknowledgedButNotApplied",
           .cause = interlocks::InterlockId::not_taken,
           .reaction = interlocks::Reaction::suspend,
           .at = kRamp,
           .breaks = [](D& d) { d.plant().chamber().trouble.ignores_writes = true; },
           .acts_within = 5,
           .repairs = [](D& d) { d.plant().chamber().trouble.ignores_writes = false; },
           .clears_within = 120}};
}

constexpr const char* kSwitchedOff = R"(
[[segment]]
kind = "hold"
at = 20
time = "1 min"
[[segment]]
kind = "hold"
time = "10 min"
power = "off"
[[segment]]
kind = "hold"
time = "40 min"
power = "on"
)";

/// Feeds the unit by the first output of a supply.
void add_supply(rig::RigFile& file) {
  const auto path = GYROTHERM_SOURCE_DIR "/profiles/supplies/rigol_dp800.toml";
  rig::SupplySettings supply{
      .line = "virtual",
      .description = drivers::parse_supply_description(read_text_file(path).value(), path).value(),
      .outputs = {}};
  supply.outputs.push_back({.settings = {.output = 0, .voltage_v = 24, .current_a = 1, .over_current_a = 0.9},
                            .name = "supply",
                            .shares = {{.unit = 0, .voltage = 0, .current = 1}},
                            .voltage = {.lowest = 23, .highest = 25}});
  file.supplies.push_back(std::move(supply));
  file.units[0].analogue_values = 2;
  for (const auto* name : {"supply_voltage_v", "supply_current_a"}) {
    file.units[0].info.values.push_back({.name = name, .unit = "V"});
    file.limits.units[0].analogue.emplace_back(name);
  }
}

/// A person at the panel of the supply.
void set_supply(D& d, const std::string& line) { (void)d.plant().supply().answer(line); }

std::vector<BrokenThing> power_faults() {
  return {{.name = "SupplyVoltageTooHigh",
           .cause = interlocks::InterlockId::power_limit,
           .reaction = interlocks::Reaction::hold,
           .at = kHold,
           .breaks = [](D& d) { set_supply(d, ":SOUR1:VOLT 26.000"); },
           .acts_within = 3,
           .repairs = [](D& d) { set_supply(d, ":SOUR1:VOLT 24.000"); },
           .setting = with(add_supply)},
          {.name = "SupplyTripped",
           .cause = interlocks::InterlockId::power_trip,
           .reaction = interlocks::Reaction::hold,
           .at = kHold,
           .breaks = [](D& d) { set_supply(d, ":OUTP:OCP:VAL CH1,0.100"); },
           .acts_within = 2,
           .repairs =
               [](D& d) {
                 set_supply(d, ":OUTP:OCP:VAL CH1,0.900");
                 set_supply(d, ":OUTP:OVP:CLE CH1;:OUTP:OCP:CLE CH1");
                 set_supply(d, ":OUTP CH1,ON");
               },
           .setting = with(add_supply)},
          {.name = "SupplySwitchedOffAtItsPanel",
           .cause = interlocks::InterlockId::power_changed,
           .reaction = interlocks::Reaction::hold,
           .at = kHold,
           .breaks = [](D& d) { set_supply(d, ":OUTP CH1,OFF"); },
           .acts_within = 3,
           .repairs = [](D& d) { set_supply(d, ":OUTP CH1,ON"); },
           .setting = with(add_supply)},
          {.name = "SupplyWithLockedPanel",
           .cause = interlocks::InterlockId::power_not_switched,
           .reaction = interlocks::Reaction::suspend,
           .at = kFirstHold - 5,
           .breaks = [](D& d) { d.plant().supply().ignore_commands(true); },
           .acts_within = 14,
           .repairs = [](D& d) { d.plant().supply().ignore_commands(false); },
           .setting = with(add_supply, kSwitchedOff)}};
}

std::vector<BrokenThing> computer_faults() {
  return {{.name = "MachineSlept",
           .cause = interlocks::InterlockId::slept,
           .reaction = interlocks::Reaction::hold,
           .at = kHold,
           .breaks = [](D& d) { d.sleep(121); },
           .acts_within = 1},
          {.name = "FullDisk",
           .cause = interlocks::InterlockId::storage,
           .reaction = interlocks::Reaction::warn,
           .at = kEarly,
           .breaks = [](D& d) { d.fill_disk(); },
           .acts_within = 62,
           .repairs = [](D& d) { d.free_disk_space(); },
           .clears_within = 11,
           .setting = {.rows_on_disk = 14'400}},
          {.name = "FullDiskLongerThanMemoryLasts",
           .cause = interlocks::InterlockId::storage,
           .reaction = interlocks::Reaction::warn,
           .at = kEarly,
           .breaks = [](D& d) { d.fill_disk(); },
           .acts_within = 60,
           .repairs = [](D& d) { d.free_disk_space(); },
           .clears_within = 11,
           .setting = {.rows_on_disk = 40}}};
}

std::vector<BrokenThing> warning_faults() {
  return {{.name = "UnneededThermometerLineCut",
           .cause = interlocks::InterlockId::channel_lost,
           .reaction = interlocks::Reaction::warn,
           .at = kRamp,
           .breaks = [](D& d) { d.plant().thermometer(1).trouble.gone = true; },
           .acts_within = 1,
           .repairs = [](D& d) { d.plant().thermometer(1).trouble.gone = false; },
           .setting = with([](rig::RigFile& file) {
             for (auto& unit : file.limits.units) unit.thermometers.clear();
           })},
          {.name = "LineOfOneOfTwoGyrosCut",
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
          {.name = "RecordFileMoved",
           .cause = interlocks::InterlockId::record_damaged,
           .reaction = interlocks::Reaction::warn,
           .at = kEarly,
           .breaks = [](D& d) { d.move_record(); },
           .acts_within = 2,
           .setting = {.rows_on_disk = 14'400},
           .is_permanent = true},
          {.name = "GuardEnded",
           .cause = interlocks::InterlockId::unguarded,
           .reaction = interlocks::Reaction::warn,
           .at = kEarly,
           .breaks =
               [](D& d) {
                 d.run_controller().set_guard_troubles({{"guard", "the guard had ended, and was replaced"}});
               },
           .acts_within = 1,
           .repairs = [](D& d) { d.run_controller().set_guard_troubles({}); }},
          {.name = "ThermometerFarFromOthers",
           .cause = interlocks::InterlockId::disagreement,
           .reaction = interlocks::Reaction::warn,
           .at = kFirstHold,
           .breaks = [](D& d) { thermometer_off_by(d, 40); },
           .acts_within = 61,
           .repairs = remove_laboratory_faults,
           .clears_within = 11,
           .setting = with([](rig::RigFile& file) {
             file.limits.disagreement = {30};
             file.limits.thermometers_fastest = {50};
           }),
           .also = {interlocks::InterlockId::drifting}},
          {.name = "ThermometerJumps",
           .cause = interlocks::InterlockId::drifting,
           .reaction = interlocks::Reaction::warn,
           .at = kFirstHold,
           .breaks = [](D& d) { thermometer_off_by(d, 3); },
           .acts_within = 31,
           .repairs = remove_laboratory_faults,
           .clears_within = 12},
          {.name = "FrozenThermometer",
           .cause = interlocks::InterlockId::stuck,
           .reaction = interlocks::Reaction::warn,
           .at = kRamp,
           .breaks =
               [](D& d) {
                 const auto shown = d.plant().laboratory().thermometers_as_measured_c()[0];
                 plant(d, [=](simulator::LaboratoryFaults& faults) { faults.thermometers[0].shown_c = shown; });
               },
           .acts_within = 600,
           .repairs = remove_laboratory_faults,
           .clears_within = 11},
          {.name = "HumidAir",
           .cause = interlocks::InterlockId::condensation,
           .reaction = interlocks::Reaction::warn,
           .at = kFirstHold,
           .breaks =
               [](D& d) { plant(d, [](simulator::LaboratoryFaults& faults) { faults.plant.humidity_percent = 100; }); },
           .acts_within = 35,
           .repairs = remove_laboratory_faults,
           .clears_within = 20,
           .setting = with([](rig::RigFile& file) {
             file.chamber_map = drivers::select_humidity(std::move(file.chamber_map)).value();
             file.limits.condensation_margin = {6};
           })},
          {.name = "DoorOpenedWhileUnitIsCold",
           .cause = interlocks::InterlockId::cold_at_door,
           .reaction = interlocks::Reaction::warn,
           .at = kFirstHold,
           .breaks = [](D& d) { set_condition(d, kDoorOpen); },
           .acts_within = 3,
           .repairs = [](D& d) { set_condition(d, kGood); },
           .clears_within = 15,
           .setting = with([](rig::RigFile& file) {
             file.limits.room = profile::RoomAir{.dew_point = {40}};
             file.limits.policy[static_cast<std::size_t>(interlocks::InterlockId::door)] = interlocks::Reaction::warn;
           }),
           .also = {interlocks::InterlockId::door}},
          {.name = "WallClockStep",
           .cause = interlocks::InterlockId::wall_clock,
           .reaction = interlocks::Reaction::warn,
           .at = kRamp,
           .breaks = [](D& d) { d.clock().step_utc(std::chrono::hours(-1)); },
           .acts_within = 1,
           .clears_within = 11}};
}

}  // namespace

const std::vector<BrokenThing>& broken_things() {
  static const std::vector<BrokenThing> all = [] {
    std::vector<BrokenThing> things;
    for (const auto& some : {aborting_faults(), chamber_sensor_faults(), silence_faults(), frozen_instrument_faults(),
                             chamber_faults(), set_point_faults(), power_faults(), computer_faults(), warning_faults()})
      things.insert(things.end(), some.begin(), some.end());
    return things;
  }();
  return all;
}

}  // namespace gyrotherm::faults
