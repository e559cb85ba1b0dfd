// SPDX-License-Identifier: Apache-2.0
/// Checks the documented properties of the gyro on the default rig, over the four ramp cycles in the air of the
/// simulated chamber and without noise.
#include <gtest/gtest.h>

#include <cmath>

#include "simulator/chamber_plant.hpp"
#include "simulator/gyro_readout.hpp"
#include "simulator/virtual_gyro.hpp"
#include "tests/simulator/shipped_rigs.hpp"
#include "tests/support/statistics.hpp"

namespace gyrotherm::simulator {
namespace {

struct PartSeries {
  std::vector<double> gas_flow, deformation, temperature, backscatter, hysteresis, total;

  void add(const BiasParts& parts, DegreesPerHour sum) {
    gas_flow.push_back(parts.gas_flow);
    deformation.push_back(parts.deformation);
    temperature.push_back(parts.temperature);
    backscatter.push_back(parts.backscatter);
    hysteresis.push_back(parts.hysteresis);
    total.push_back(sum.value);
  }
};

double deviation(const std::vector<double>& one_second) {
  return tests::standard_deviation(tests::clusters_of(one_second));
}

const PartSeries& rate_cycles() {
  static const PartSeries series = [] {
    const auto laboratory = laboratory_of_rig("virtual");
    ChamberPlant plant(laboratory.plant);
    ReducedGyro gyro(std::get<ReducedGyroParameters>(laboratory.body));
    PartSeries all;
    for (const double rate : {1.0, 2.0, 3.0, 5.0})
      for (const double set_point_c : rate_cycle_c(rate)) {
        all.add(gyro.bias_parts(), gyro.bias());
        gyro.step(plant.air(), plant.output_percent() / 100);
        plant.step({set_point_c}, true);
      }
    return all;
  }();
  return series;
}

/// The paper states 0.0258 °/h. The noise of 100 s means is subtracted in quadrature.
TEST(DefaultRig, HasDeviationOfPaper) {
  EXPECT_NEAR(deviation(rate_cycles().total), std::sqrt(0.0258 * 0.0258 - 0.0019 * 0.0019), 0.0003);
}

TEST(DefaultRig, IsDominatedByGradientsAndGasFlow) {
  const auto& parts = rate_cycles();
  const double least = std::min(deviation(parts.gas_flow), deviation(parts.deformation));
  for (const auto* other : {&parts.temperature, &parts.backscatter, &parts.hysteresis})
    EXPECT_LT(deviation(*other), least);
}

/// The rig file states ±0.0008 °/h between heating and cooling.
TEST(DefaultRig, HasStatedHysteresis) {
  double largest = 0;
  for (const double part : rate_cycles().hysteresis) largest = std::max(largest, std::abs(part));
  EXPECT_NEAR(largest, 8e-4, 1e-5);
}

/// The noise floor is computed from differences of adjacent means, as for a record. It equals the 0.0019 °/h of the
/// reference simulation.
TEST(DefaultRig, HasNoiseFloorOfReference) {
  const auto readout_of = [](const char* rig) { return GyroReadout(laboratory_of_rig(rig).gyro, 1); };
  for (const auto* rig : {"virtual", "virtual-reference"}) {
    auto readout = readout_of(rig);
    double squares = 0;
    constexpr int kMeans = 4000;
    double before = 0;
    std::int64_t last = 0;
    for (int i = 0; i <= kMeans; ++i) {
      for (int t = 0; t < 100; ++t) readout.step({});
      const double mean = 0.1 * static_cast<double>(readout.pulses() - last) / 100;
      last = readout.pulses();
      if (i > 0) squares += (mean - before) * (mean - before);
      before = mean;
    }
    EXPECT_NEAR(std::sqrt(squares / 2 / kMeans), 0.0019, 4 * 0.0019 / std::sqrt(2.0 * kMeans)) << rig;
  }
}

}  // namespace
}  // namespace gyrotherm::simulator
