// SPDX-License-Identifier: Apache-2.0
/// The gyrotherm-thermal program: images, calibration and reduction of the finite-element model of a gyro.
#include "apps/console/command.hpp"
#include "core/program_start.hpp"

namespace gyrotherm::app {

void add_thermal_figure(Program& program);
void add_thermal_fit(Program& program);
void add_thermal_image(Program& program);
void add_thermal_reduce(Program& program);

}  // namespace gyrotherm::app

int main(int argc, char** argv) {
  gyrotherm::open_standard_descriptors();
  gyrotherm::app::Program program("gyrotherm-thermal",
                                  "gyrotherm-thermal computes the temperature field of a working ring laser gyro.");
  gyrotherm::app::add_thermal_image(program);
  gyrotherm::app::add_thermal_figure(program);
  gyrotherm::app::add_thermal_fit(program);
  gyrotherm::app::add_thermal_reduce(program);
  add_completion(program);
  add_manual(program);
  return run(program, argc, argv);
}
