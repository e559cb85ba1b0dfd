// SPDX-License-Identifier: Apache-2.0
#include "tests/sequencer/faults/fault_injector.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gyrotherm::faults {
namespace {

using Kind = InjectedFaultKind;

constexpr double kOpenC = 850, kShortC = -200, kBrokenC = 1000, kNoNumber = std::numeric_limits<double>::quiet_NaN();
constexpr double kOwnIdentity = 21868, kAnotherIdentity = 21869;
/// Seconds without an instrument, before and after another one takes its place.
constexpr std::int64_t kUnplugged = 4;
constexpr double kManual = 2, kDoorOpen = 1, kLimiterTripped = 2, kFilterDirty = 3;

bool is_thermometer_line_fault(Kind kind) {
  return kind >= Kind::thermometer_silent && kind <= Kind::thermometer_doubled;
}
bool changes_over_time(const InjectedFault& fault) {
  return fault.kind == Kind::thermometer_alternates || fault.kind == Kind::chamber_exchanged ||
         fault.kind == Kind::thermometer_exchanged;
}
bool is_gyro_fault(Kind kind) { return kind >= Kind::gyro_silent && kind <= Kind::gyro_restarts; }

}  // namespace

bool concerns_record(InjectedFaultKind kind) { return kind >= Kind::file_removed && kind <= Kind::file_overwritten; }

bool concerns_program(InjectedFaultKind kind) {
  return kind >= Kind::program_late || kind == Kind::machine_sleeps || kind == Kind::disk_fails_once ||
         concerns_record(kind);
}

std::vector<InjectedFault> FaultInjector::pass(std::int64_t second) {
  std::vector<InjectedFault> of_program;
  second_ = second;
  const auto before = active_.size();
  for (std::size_t i = active_.size(); i-- > 0;) {
    if (active_[i].at + active_[i].lasts > second) continue;
    active_.erase(active_.begin() + static_cast<std::ptrdiff_t>(i));
    shown_then_.erase(shown_then_.begin() + static_cast<std::ptrdiff_t>(i));
  }
  bool changed = active_.size() != before;
  for (; next_ < schedule_.size() && schedule_[next_].at <= second; ++next_) {
    const auto& fault = schedule_[next_];
    last_change_ = second;
    if (concerns_program(fault.kind)) {
      of_program.push_back(fault);
      if (fault.kind != Kind::machine_sleeps && fault.kind != Kind::outputs_blocked) continue;
    }
    changed = true;
    if (fault.lasts == 0) {
      start_event(fault);
      if (fault.kind != Kind::thermometer_spike) continue;
    }
    auto lasting = fault;
    lasting.at = second;
    lasting.lasts = std::max<std::int64_t>(lasting.lasts, 1);
    const auto shown = plant_.laboratory().thermometers_as_measured_c();
    shown_then_.emplace_back(shown.begin(), shown.end()).push_back(plant_.laboratory().air_as_measured().value);
    active_.push_back(lasting);
  }
  if (changed) last_change_ = second;
  if (changed || std::ranges::any_of(active_, changes_over_time)) update_plant();
  return of_program;
}

std::size_t FaultInjector::gyro_index(const InjectedFault& fault) const {
  return static_cast<std::size_t>(fault.target) % plant_.gyro_count();
}

/// Carries out a fault that is an event and not a state.
void FaultInjector::start_event(const InjectedFault& fault) {
  auto& laboratory = plant_.laboratory();
  switch (fault.kind) {
    case Kind::chamber_restarts:
      plant_.restart_chamber({fault.size}, fault.target != 1);
      if (fault.target == 2) plant_.write("control_mode", kManual);
      return;
    case Kind::chamber_switched_off: return laboratory.switch_on(false);
    case Kind::chamber_manual: return plant_.write("control_mode", kManual);
    case Kind::panel_set_point: return laboratory.change_set_point({fault.size});
    case Kind::limiter_trips: return plant_.write("condition", kLimiterTripped);
    case Kind::gyro_restarts: return plant_.gyro(gyro_index(fault)).restart();
    case Kind::wall_clock_steps: return clock_.step_utc(from_seconds(fault.size));
    default: return;
  }
}

/// Resets the plant to a state without faults, then applies all active faults.
void FaultInjector::update_plant() {
  plant_.faults = simulator::LaboratoryFaults(plant_.faults.thermometers.size());
  plant_.chamber().trouble = {};
  plant_.chamber().line().trouble = {};
  for (std::size_t i = 0; i < plant_.gyro_count(); ++i) plant_.gyro(i).trouble = {}, plant_.gyro(i).line().trouble = {};
  for (std::size_t i = 0; i < plant_.thermometer_count(); ++i) {
    plant_.thermometer(i).trouble = {};
    plant_.exchange_thermometer(i, false);
  }
  bool tripped = false;
  for (const auto& fault : schedule_)
    tripped = tripped || (fault.kind == Kind::limiter_trips && fault.at <= last_change_);
  for (std::size_t i = 0; i < active_.size(); ++i) apply_fault(active_[i]);
  for (std::size_t i = 0; i < active_.size(); ++i) {
    const auto target = static_cast<std::size_t>(active_[i].target);
    const auto channel = target % simulator::kThermalLocations;
    const auto& then = shown_then_[i];
    auto& shown_c = plant_.faults.plant.sensor_c;
    if (active_[i].kind == Kind::air_sensor_frozen && !shown_c) {  // a broken sensor shows its error
      shown_c = then.back();
      plant_.faults.air_is_frozen = true;
    }
    if (active_[i].kind == Kind::thermometer_stuck) plant_.faults.thermometers[channel].shown_c = then[channel];
    if (active_[i].kind != Kind::thermometers_frozen) continue;
    for (const auto place : plant_.places(target % plant_.thermometer_count()))
      plant_.faults.thermometers[place].shown_c = then[place];
  }
  plant_.write("identity", plant_.chamber().trouble.exchanged ? kAnotherIdentity : kOwnIdentity);
  double condition = 0;  // one code: the most severe
  for (const auto& fault : active_)
    if (fault.kind == Kind::filter_dirty) condition = kFilterDirty;
  if (plant_.faults.plant.door_open) condition = kDoorOpen;
  if (tripped) condition = kLimiterTripped;
  plant_.write("condition", condition);
  plant_.apply_faults();
}

void FaultInjector::apply_fault(const InjectedFault& fault) {
  if (fault.kind == Kind::machine_sleeps) {
    for (std::size_t i = 0; i < plant_.gyro_count(); ++i) plant_.gyro(i).line().trouble.gone = true;
    return;
  }
  if (concerns_program(fault.kind)) return;
  if (fault.kind <= Kind::chamber_wrong_number) return apply_to_line(fault);
  if (fault.kind <= Kind::air_sensor_broken) return apply_to_chamber(fault);
  if (is_thermometer_line_fault(fault.kind) || is_gyro_fault(fault.kind)) return apply_to_line(fault);
  apply_to_thermometer(fault);
}

/// No instrument answers while the line is being reconnected from one instrument to another.
void FaultInjector::exchange(const InjectedFault& fault, LineEnd& line) {
  const bool is_unplugged = second_ - fault.at < kUnplugged || fault.at + fault.lasts - second_ <= kUnplugged;
  if (is_unplugged)
    line.trouble.gone = true;
  else if (fault.kind == Kind::chamber_exchanged)
    plant_.chamber().trouble.exchanged = true;
  else
    plant_.exchange_thermometer(static_cast<std::size_t>(fault.target) % plant_.thermometer_count(), true);
}

void FaultInjector::apply_to_line(const InjectedFault& fault) {
  auto& chamber = plant_.chamber();
  auto& gyro = plant_.gyro(gyro_index(fault));
  auto& line = is_gyro_fault(fault.kind) ? gyro.line()
               : is_thermometer_line_fault(fault.kind)
                   ? plant_.thermometer(static_cast<std::size_t>(fault.target) % plant_.thermometer_count())
                   : chamber.line();
  const auto code = static_cast<std::uint8_t>(fault.size);
  switch (fault.kind) {
    case Kind::chamber_silent:
    case Kind::thermometer_silent:
    case Kind::gyro_silent: line.trouble.silent = true; return;
    case Kind::chamber_gone:
    case Kind::thermometer_gone:
    case Kind::gyro_gone: line.trouble.gone = true; return;
    case Kind::chamber_exchanged:
    case Kind::thermometer_exchanged: return exchange(fault, line);
    case Kind::chamber_answers_lost: line.trouble.answers_lost = true; return;
    case Kind::chamber_lossy:
    case Kind::thermometer_lossy: line.trouble.lost = fault.size; return;
    case Kind::chamber_late:
    case Kind::thermometer_late: line.trouble.late = from_seconds(fault.size); return;
    case Kind::chamber_doubled:
    case Kind::thermometer_doubled: line.trouble.doubled = fault.size; return;
    case Kind::chamber_noise:
    case Kind::thermometer_noise: line.trouble.garbled = fault.size; return;
    case Kind::chamber_cut: line.trouble.cut = fault.size; return;
    case Kind::chamber_half_open: chamber.trouble.half_open = chamber.line().trouble.silent = true; return;
    case Kind::chamber_exception: chamber.trouble.exception = code, chamber.trouble.only_writes = false; return;
    case Kind::chamber_write_exception:  // ignored below a general exception
      if (chamber.trouble.exception == 0) chamber.trouble.exception = code, chamber.trouble.only_writes = true;
      return;
    case Kind::chamber_foreign_unit: chamber.trouble.foreign_unit = true; return;
    case Kind::chamber_wrong_number: chamber.trouble.wrong_number = true; return;
    case Kind::gyro_garbled: gyro.trouble.garbled = fault.size; return;
    case Kind::gyro_loses_frames: gyro.trouble.lost = fault.size; return;
    case Kind::gyro_bursts: gyro.trouble.held_back = true; return;
    case Kind::gyro_dead: gyro.trouble.dead = true; return;
    default: return;
  }
}

void FaultInjector::apply_to_chamber(const InjectedFault& fault) {
  auto& plant = plant_.faults.plant;
  switch (fault.kind) {
    case Kind::chamber_ignores_writes: plant_.chamber().trouble.ignores_writes = true; return;
    case Kind::chamber_clamps: plant_.chamber().trouble.clamps_at = {fault.size}; return;
    case Kind::heater_weak: plant.heating_share = fault.size; return;
    case Kind::cooler_weak: plant.cooling_share = fault.size; return;
    case Kind::machinery_stuck: plant.stuck_output = fault.size; return;
    case Kind::door_open: plant.door_open = true; return;
    case Kind::air_sensor_error: plant.sensor_error_k = fault.size; return;
    case Kind::air_sensor_broken: plant.sensor_c = kBrokenC; return;
    default: return;
  }
}

void FaultInjector::apply_to_thermometer(const InjectedFault& fault) {
  auto& thermometers = plant_.faults.thermometers;
  const auto channel = static_cast<std::size_t>(fault.target) % simulator::kThermalLocations;
  auto& shown = thermometers[channel];
  switch (fault.kind) {
    case Kind::thermometer_open: shown.shown_c = kOpenC; return;
    case Kind::thermometer_short: shown.shown_c = kShortC; return;
    case Kind::thermometer_lost: shown.shown_c = kNoNumber; return;
    case Kind::thermometer_alternates:
      if (second_ % 2 == 0) shown.shown_c = fault.size;
      return;
    case Kind::thermometer_spike:
    case Kind::thermometer_drift: shown.error_k += fault.size; return;
    case Kind::thermometers_swapped:
      std::swap(shown.location, thermometers[(channel + 1) % simulator::kThermalLocations].location);
      return;
    default: return;
  }
}

}  // namespace gyrotherm::faults
