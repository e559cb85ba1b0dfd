// SPDX-License-Identifier: Apache-2.0
#include "apps/console/command.hpp"

namespace gyrotherm::app {
namespace {

/// Becomes the program that has the finite elements; this one, which commands chambers, has none.
Result<Exit> become_thermal_program(const std::vector<std::string>& words) {
  std::vector<std::string> line{"image"};
  line.insert(line.end(), words.begin(), words.end());
  return become_program("gyrotherm-thermal", std::move(line));
}

}  // namespace

void add_thermal(Program& program) {
  add_forwarded(program, "thermal",
                "The finite-element thermal image of the working gyro at rest: gyrotherm-thermal image.",
                "gyrotherm thermal --mesh medium --out image", become_thermal_program);
}

}  // namespace gyrotherm::app
