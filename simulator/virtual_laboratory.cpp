// SPDX-License-Identifier: Apache-2.0
#include "simulator/virtual_laboratory.hpp"

#include <array>
#include <cassert>
#include <optional>
#include <utility>

#include "simulator/chamber_plant.hpp"
#include "simulator/gyro_ageing.hpp"
#include "simulator/gyro_readout.hpp"
#include "simulator/lumped_gyro.hpp"
#include "simulator/thermometer_bank.hpp"
#include "simulator/virtual_gyro.hpp"

namespace gyrotherm::simulator {
namespace {

const std::vector<std::string> kThermometerNames(kPlaceNames.begin(), kPlaceNames.end());

std::unique_ptr<VirtualGyro> make_gyro(const LumpedGyroParameters& p, LaboratorySeed /*seed*/) {
  return std::make_unique<LumpedGyro>(p);
}
std::unique_ptr<VirtualGyro> make_gyro(const ReducedGyroParameters& p, LaboratorySeed seed) {
  return std::make_unique<ReducedGyro>(p, past_of(p.storage, seed));
}

}  // namespace

struct VirtualLaboratory::Parts {
  Parts(const LaboratoryParameters& drawn, LaboratorySeed seed);
  void measure_air();
  void show_thermometers();

  PlantParameters plant_parameters;
  ChamberPlant plant;
  std::unique_ptr<VirtualGyro> gyro;
  DegreesPerHour true_bias;  ///< in the second that has passed
  ThermometerBank thermometers;
  GyroReadout readout;
  RandomStream air_noise;
  Celsius set_point;
  bool on = false;
  UnitState unit;
  Celsius measured_air;
  std::optional<std::array<ThermometerFault, kThermalPlaces>> thermometer_faults;
  std::array<double, kThermalPlaces> shown_with_faults_c{};  ///< by thermometers with faults
};

VirtualLaboratory::Parts::Parts(const LaboratoryParameters& drawn, LaboratorySeed seed)
    : plant_parameters(drawn.plant),
      plant(drawn.plant),
      gyro(std::visit([&](const auto& body) { return make_gyro(body, seed); }, drawn.body)),
      true_bias(gyro->bias()),
      thermometers(drawn.thermometers, gyro->places_c(), noise_seed(seed)),
      readout(drawn.gyro, noise_seed(seed)),
      air_noise(noise_seed(seed), RandomPurpose::air_noise),
      set_point{drawn.plant.start_c} {
  measure_air();
}

void VirtualLaboratory::Parts::measure_air() {
  const double shown_c = plant.sensed().value + plant_parameters.sensor_noise_k * air_noise.normal();
  measured_air = {to_resolution(shown_c, plant_parameters.sensor_resolution_k)};
}

void VirtualLaboratory::Parts::show_thermometers() {
  const auto sound_c = thermometers.readings_c();
  for (std::size_t i = 0; i < shown_with_faults_c.size(); ++i) {
    const auto& fault = (*thermometer_faults)[i];
    shown_with_faults_c[i] = fault.shown_c.value_or(sound_c[fault.place] + fault.error_k);
  }
}

VirtualLaboratory::VirtualLaboratory(const LaboratoryParameters& parameters, LaboratorySeed seed)
    : parts_(std::make_unique<Parts>(aged(draw_gyro(parameters, seed.gyro), seed), seed)) {}
VirtualLaboratory::~VirtualLaboratory() = default;
VirtualLaboratory::VirtualLaboratory(VirtualLaboratory&&) noexcept = default;
VirtualLaboratory& VirtualLaboratory::operator=(VirtualLaboratory&&) noexcept = default;

bool VirtualLaboratory::accepts(Celsius set_point) const {
  const auto& plant = parts_->plant_parameters;
  return set_point.value >= plant.lowest_c && set_point.value <= plant.highest_c;
}

void VirtualLaboratory::command(Celsius set_point) {
  assert(accepts(set_point));
  parts_->set_point = set_point;
}

void VirtualLaboratory::switch_on(bool on) { parts_->on = on; }

void VirtualLaboratory::bring_unit_to(const UnitState& state) {
  auto& p = *parts_;
  const auto before = std::exchange(p.unit, state);
  if (before.off == state.off) return;
  p.gyro->switch_on(!state.off);
  if (!state.off) p.readout.start_anew();
}

void VirtualLaboratory::step() {
  auto& p = *parts_;
  p.true_bias = p.gyro->bias();
  if (!p.unit.off) p.readout.step(p.true_bias, p.gyro->block(), p.unit.turned);
  p.gyro->step(p.plant.air(), p.plant.output_percent() / 100);
  p.plant.step(p.set_point, p.on);
  p.thermometers.step(p.gyro->places_c());
  p.measure_air();
  if (p.thermometer_faults) p.show_thermometers();
}

void VirtualLaboratory::inject(const LaboratoryFaults& faults) {
  parts_->plant.inject(faults.plant);
  parts_->thermometer_faults = faults.thermometers;
  parts_->show_thermometers();
}

Celsius VirtualLaboratory::set_point() const { return parts_->set_point; }
bool VirtualLaboratory::is_on() const { return parts_->on; }
const UnitState& VirtualLaboratory::unit() const { return parts_->unit; }
Celsius VirtualLaboratory::air_as_measured() const { return parts_->measured_air; }
double VirtualLaboratory::output_percent() const { return parts_->plant.output_percent(); }
std::span<const double> VirtualLaboratory::thermometers_as_measured_c() const {
  if (parts_->thermometer_faults) return parts_->shown_with_faults_c;
  return parts_->thermometers.readings_c();
}
const std::vector<std::string>& VirtualLaboratory::thermometer_names() const { return kThermometerNames; }
std::int64_t VirtualLaboratory::pulses() const { return parts_->readout.pulses(); }
std::int64_t VirtualLaboratory::device_time_us() const { return parts_->readout.device_time_us(); }
double VirtualLaboratory::arcsec_per_pulse() const { return parts_->readout.arcsec_per_pulse(); }
DegreesPerHour VirtualLaboratory::true_bias() const { return parts_->true_bias; }
DegreesPerHour VirtualLaboratory::drift() const { return parts_->readout.drift(); }

}  // namespace gyrotherm::simulator
