// SPDX-License-Identifier: Apache-2.0
#include "simulator/virtual_laboratory.hpp"

#include <algorithm>
#include <cassert>
#include <map>
#include <optional>
#include <utility>

#include "simulator/added_heat.hpp"
#include "simulator/chamber_plant.hpp"
#include "simulator/gyro_ageing.hpp"
#include "simulator/laboratory_file.hpp"
#include "simulator/thermometer_bank.hpp"
#include "simulator/virtual_unit.hpp"

namespace gyrotherm::simulator {
namespace {

/// Seconds between updates of the gap-air conductivity if there are many bodies. Compared with the ten seconds of a
/// single body, this changes a thermometer by less than 17 mK and the bias by less than 2e-5 °/h at a chamber ramp of 5
/// K/min. It saves more than half of the time of a step, which is spent reading tables of 1 MB per body.
/// Load of a unit without [[virtual.load]]: 0.5 A at 24 V.
constexpr double kUsualLoadOhm = 48, kLeastLoadOhm = 1e-3;
constexpr int kManyBodiesUpdateSeconds = 30;

DrawnAxis draw_axis(LaboratoryParameters type, LaboratorySeed seed) {
  return {.gyro = age_gyro(draw_gyro(std::move(type), seed.gyro), seed), .seed = seed};
}

DrawnAxis draw_axis(LaboratoryParameters type, const UnitParameters& unit, const AxisParameters& axis,
                    LaboratorySeed seed) {
  type.gyro.earth_rate_deg_per_h = axis.earth_rate_deg_per_h;
  type.gyro.crosswise_earth_rate_deg_per_h = axis.crosswise_earth_rate_deg_per_h;
  type.thermometers.failing = axis.failing;
  if (auto* body = std::get_if<ReducedGyroParameters>(&type.body)) body->seconds_per_update = kManyBodiesUpdateSeconds;
  auto drawn = draw_axis(std::move(type), derive_seed(seed, axis_name(unit.name, axis.name)));
  drawn.hop = axis.hop;
  return drawn;
}

double start_c(const LaboratoryParameters& gyro) {
  if (const auto* body = std::get_if<ReducedGyroParameters>(&gyro.body)) return body->start_c;
  return std::get<LumpedGyroParameters>(gyro.body).network.start_c;
}

/// Drawn parameters of a unit.
struct DrawnUnit {
  std::string name;
  LaboratorySeed seed;
  std::vector<std::string> axis_names;
  std::vector<DrawnAxis> axes;
};

std::vector<DrawnUnit> draw_units(const LaboratoryParameters& type, LaboratorySeed seed) {
  if (type.units.empty()) return {{.name = kPlainUnit, .seed = seed, .axis_names{""}, .axes{draw_axis(type, seed)}}};
  std::vector<DrawnUnit> units;
  for (const auto& unit : type.units) {
    assert(!unit.axes.empty());
    units.push_back({.name = unit.name, .seed = derive_seed(seed, unit.name), .axis_names{}, .axes{}});
    for (const auto& axis : unit.axes) {
      units.back().axis_names.push_back(axis.name);
      units.back().axes.push_back(draw_axis(type, unit, axis, seed));
    }
  }
  return units;
}

/// Starts the bodies on a bracket at their steady-state temperatures. Returns the bracket's temperature.
Celsius start_on_bracket(std::vector<DrawnUnit>& units, const BracketParameters& bracket) {
  std::vector<DrawnAxis*> bodies;
  for (const auto unit : bracket.units)
    for (auto& axis : units[unit].axes) bodies.push_back(&axis);
  const Celsius air{start_c(bodies.front()->gyro)};
  const auto bracket_start = bracket_at_rest(bracket.share, air, [&](Celsius seen) {
    double sum_c = 0;
    for (const auto* body : bodies) sum_c += cabinet_at_rest(*body, seen).value;
    return Celsius{sum_c / static_cast<double>(bodies.size())};
  });
  for (auto* body : bodies)
    body->gyro = soak_at(std::move(body->gyro), Bracket(bracket, bracket_start).effective_air(air));
  return bracket_start;
}

}  // namespace

struct VirtualLaboratory::Parts {
  Parts(const LaboratoryParameters& type, LaboratorySeed seed);
  void make_units(const LaboratoryParameters& type, LaboratorySeed seed);
  void measure_air();
  void show_thermometers();
  void apply_state(std::size_t index);
  [[nodiscard]] Celsius mean_cabinet_temperature(const BracketParameters& bracket) const;
  [[nodiscard]] Celsius air_around(std::size_t unit) const;

  PlantParameters plant_parameters;
  double arcsec_per_pulse;
  ChamberPlant plant;
  std::vector<std::string> names;
  std::vector<std::vector<std::string>> axis_names;
  std::vector<VirtualUnit> units;
  std::vector<char> silent;
  /// The sources of each unit's power, and whether each is on.
  std::vector<std::map<std::size_t, bool>> sources;
  std::vector<LoadParameters> loads;
  std::vector<BracketParameters> on_brackets;
  std::vector<Bracket> brackets;
  std::vector<std::optional<std::size_t>> bracket_indices;
  std::vector<std::string> thermometer_names;
  /// Readings without and with faults.
  std::vector<double> fault_free_c, shown_c;
  std::vector<ThermometerFault> thermometer_faults;
  bool air_is_frozen = false;
  RandomStream air_noise;
  Celsius set_point;
  bool on = false;
  bool is_cut = false;
  bool holds_output = false;
  UnitState unit;
  Celsius measured_air;
};

VirtualLaboratory::Parts::Parts(const LaboratoryParameters& type, LaboratorySeed seed)
    : plant_parameters(type.plant),
      arcsec_per_pulse(type.gyro.arcsec_per_pulse),
      plant(type.plant),
      on_brackets(type.brackets),
      thermometer_names(list_thermometer_names(type.units)),
      air_noise(noise_seed(seed), RandomPurpose::air_noise),
      set_point{type.plant.start_c} {
  make_units(type, seed);
  measure_air();
  show_thermometers();
}

void VirtualLaboratory::Parts::make_units(const LaboratoryParameters& type, LaboratorySeed seed) {
  auto drawn = draw_units(type, seed);
  bracket_indices.resize(drawn.size());
  for (const auto& bracket : on_brackets) {
    for (const auto member : bracket.units) bracket_indices[member] = brackets.size();
    brackets.emplace_back(bracket, start_on_bracket(drawn, bracket));
  }
  for (auto& one : drawn) {
    names.push_back(one.name);
    units.emplace_back(type, one.axes, one.seed);
    axis_names.push_back(std::move(one.axis_names));
  }
  silent.resize(units.size());
  sources.resize(units.size());
  for (const auto& name : names) {
    const auto found = std::ranges::find(type.loads, name, &LoadParameters::unit);
    loads.push_back(found != type.loads.end() ? *found : LoadParameters{.unit = name, .ohm_at_20_c = kUsualLoadOhm});
  }
  fault_free_c.resize(thermometer_names.size());
}

void VirtualLaboratory::Parts::measure_air() {
  const double measured_c = plant.sensed_air().value + plant_parameters.sensor_noise_k * air_noise.normal();
  if (!air_is_frozen) measured_air = {round_to_resolution(measured_c, plant_parameters.sensor_resolution_k)};
}

void VirtualLaboratory::Parts::show_thermometers() {
  auto next = fault_free_c.begin();
  for (const auto& one : units)
    for (const auto& axis : one.axes()) next = std::ranges::copy(axis.thermometers_c(), next).out;
  shown_c = fault_free_c;
  for (std::size_t i = 0; i < std::min(thermometer_faults.size(), shown_c.size()); ++i) {
    const auto& fault = thermometer_faults[i];
    shown_c[i] = fault.shown_c.value_or(fault_free_c[fault.location] + fault.error_k);
  }
}

Celsius VirtualLaboratory::Parts::mean_cabinet_temperature(const BracketParameters& bracket) const {
  double sum_c = 0;
  std::size_t bodies = 0;
  for (const auto member : bracket.units) {
    for (const auto& axis : units[member].axes()) sum_c += axis.cabinet().value;
    bodies += units[member].axes().size();
  }
  return {sum_c / static_cast<double>(bodies)};
}

Celsius VirtualLaboratory::Parts::air_around(std::size_t one) const {
  return bracket_indices[one] ? brackets[*bracket_indices[one]].effective_air(plant.air()) : plant.air();
}

VirtualLaboratory::VirtualLaboratory(const LaboratoryParameters& parameters, LaboratorySeed seed)
    : parts_(std::make_unique<Parts>(parameters, seed)) {}
VirtualLaboratory::~VirtualLaboratory() = default;
VirtualLaboratory::VirtualLaboratory(VirtualLaboratory&&) noexcept = default;
VirtualLaboratory& VirtualLaboratory::operator=(VirtualLaboratory&&) noexcept = default;

bool VirtualLaboratory::accepts(Celsius set_point) const {
  const auto& plant = parts_->plant_parameters;
  return set_point.value >= plant.lowest_c && set_point.value <= plant.highest_c;
}

void VirtualLaboratory::change_set_point(Celsius set_point) {
  assert(accepts(set_point));
  parts_->set_point = set_point;
}

void VirtualLaboratory::switch_on(bool on) { parts_->on = on; }

void VirtualLaboratory::cut_power(bool cut) { parts_->is_cut = cut; }

ChamberLimiter& VirtualLaboratory::limiter() { return parts_->plant.limiter(); }

void VirtualLaboratory::hold_output(std::optional<double> output) {
  parts_->holds_output = output.has_value();
  parts_->plant.hold_output(output);
}

void VirtualLaboratory::Parts::apply_state(std::size_t index) {
  const auto& own = sources[index];
  const bool has_power = std::ranges::all_of(own, [](const auto& source) { return source.second; });
  units[index].set_state({.off = own.empty() ? unit.off : !has_power, .turned = unit.turned});
}

void VirtualLaboratory::set_unit_state(const UnitState& state) {
  parts_->unit = state;
  for (std::size_t i = 0; i < parts_->units.size(); ++i) parts_->apply_state(i);
}

void VirtualLaboratory::feed(std::size_t unit, std::size_t source, bool on) {
  parts_->sources.at(unit)[source] = on;
  parts_->apply_state(unit);
}

void VirtualLaboratory::silence(std::size_t unit, bool silent) { parts_->silent.at(unit) = silent; }

void VirtualLaboratory::step() {
  auto& p = *parts_;
  for (std::size_t i = 0; i < p.units.size(); ++i) p.units[i].step(p.air_around(i), p.plant.output_percent() / 100);
  for (std::size_t i = 0; i < p.brackets.size(); ++i)
    p.brackets[i].follow(p.mean_cabinet_temperature(p.on_brackets[i]));
  p.plant.step(p.set_point, p.on && !p.is_cut);
  p.measure_air();
  p.show_thermometers();
}

void VirtualLaboratory::inject(const LaboratoryFaults& faults) {
  parts_->plant.inject(faults.plant);
  parts_->air_is_frozen = faults.air_is_frozen;
  parts_->thermometer_faults = faults.thermometers;
  parts_->show_thermometers();
}

Celsius VirtualLaboratory::set_point() const { return parts_->set_point; }
bool VirtualLaboratory::is_on() const { return parts_->on; }
bool VirtualLaboratory::holds_output() const { return parts_->holds_output; }
const UnitState& VirtualLaboratory::unit() const { return parts_->unit; }
Celsius VirtualLaboratory::air_as_measured() const { return parts_->measured_air; }
double VirtualLaboratory::humidity_percent() const { return parts_->plant.humidity_percent(); }
Celsius VirtualLaboratory::dew_point() const { return parts_->plant.dew_point(); }
double VirtualLaboratory::output_percent() const { return parts_->plant.output_percent(); }
std::span<const double> VirtualLaboratory::thermometers_as_measured_c() const { return parts_->shown_c; }
const std::vector<std::string>& VirtualLaboratory::thermometer_names() const { return parts_->thermometer_names; }

const std::vector<std::string>& VirtualLaboratory::units() const { return parts_->names; }
const std::vector<std::string>& VirtualLaboratory::axes(std::size_t unit) const { return parts_->axis_names.at(unit); }
bool VirtualLaboratory::is_silent(std::size_t unit) const { return parts_->silent.at(unit) != 0; }
bool VirtualLaboratory::is_off(std::size_t unit) const { return parts_->units.at(unit).state().off; }
double VirtualLaboratory::load_ohm(std::size_t unit) const {
  const auto& load = parts_->loads.at(unit);
  const double warmer_k = parts_->units.at(unit).axes().front().block().value - 20;
  return std::max(load.ohm_at_20_c * (1 + load.per_k * warmer_k), kLeastLoadOhm);
}
std::span<const std::int64_t> VirtualLaboratory::pulses(std::size_t unit) const {
  return parts_->units.at(unit).pulses();
}
std::int64_t VirtualLaboratory::device_time_us(std::size_t unit) const {
  return parts_->units.at(unit).device_time_us();
}
double VirtualLaboratory::arcsec_per_pulse() const { return parts_->arcsec_per_pulse; }
std::span<const UnitValue> VirtualLaboratory::values(std::size_t unit) const { return parts_->units.at(unit).values(); }
std::span<const DegreesPerHour> VirtualLaboratory::true_bias(std::size_t unit) const {
  return parts_->units.at(unit).true_bias();
}

std::vector<DegreesPerHour> VirtualLaboratory::drift(std::size_t unit) const {
  std::vector<DegreesPerHour> drift;
  for (const auto& axis : parts_->units.at(unit).axes()) drift.push_back(axis.drift());
  return drift;
}

std::optional<Celsius> VirtualLaboratory::bracket(std::size_t unit) const {
  const auto bracket = parts_->bracket_indices.at(unit);
  if (!bracket) return {};
  return parts_->brackets[*bracket].temperature();
}

}  // namespace gyrotherm::simulator
