// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "app/command.hpp"
#include "core/process.hpp"

namespace gyrotherm::app {
namespace {

constexpr const char* kThermalProgram = "gyrotherm-thermal";

/// Becomes the program that has the finite elements; this one, which commands chambers, has none.
Result<Exit> become_thermal_program(const std::vector<std::string>& words) {
  std::vector<std::string> line{kThermalProgram, "image"};
  line.insert(line.end(), words.begin(), words.end());
  std::vector<char*> arguments;
  for (auto& word : line) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const auto program = program_beside_this_one(kThermalProgram);
  ::execv(program.c_str(), arguments.data());
  return failure(FaultKind::bad_file, program, std::generic_category().message(errno));
}

}  // namespace

void add_thermal(Program& program) {
  add_forwarded(program, "thermal",
                "The finite-element thermal image of the working gyro at rest: gyrotherm-thermal image.",
                "gyrotherm thermal --mesh medium --out image", become_thermal_program);
}

}  // namespace gyrotherm::app
