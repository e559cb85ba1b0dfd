/// The gyrotherm-thermal program: the finite-element model of a gyro, its image, its calibration, its reduction.
#include "app/thermal/commands.hpp"

int main(int argc, char** argv) {
  gyrotherm::Program program("gyrotherm-thermal",
                             "gyrotherm-thermal computes where a working ring laser gyro is warm.");
  gyrotherm::add_thermal_image(program);
  gyrotherm::add_thermal_fit(program);
  gyrotherm::add_thermal_reduce(program);
  return run(program, argc, argv);
}
