// SPDX-License-Identifier: Apache-2.0
/// `gyrotherm site` and `gyrotherm thermal`, which start other programs. This program controls chambers and links
/// neither a database nor the finite elements.
#include <string>
#include <utility>
#include <vector>

#include "apps/console/command.hpp"

namespace gyrotherm::app {
namespace {

Result<Exit> become_site_program(const std::vector<std::string>& arguments) {
  return exec_sibling_program("gyrotherm-site", arguments);
}

/// Carries out the command of gyrotherm-thermal that the first argument names; without one, `image`.
Result<Exit> become_thermal_program(const std::vector<std::string>& arguments) {
  std::vector<std::string> forwarded;
  if (arguments.empty() || arguments.front().starts_with('-')) forwarded.emplace_back("image");
  forwarded.insert(forwarded.end(), arguments.begin(), arguments.end());
  return exec_sibling_program("gyrotherm-thermal", std::move(forwarded));
}

}  // namespace

void add_site(Program& program) {
  add_forwarding_subcommand(program, "site", "Creates and queries the store of a site of rigs (gyrotherm-site).",
                            "gyrotherm site rigs --site site.toml", become_site_program);
}

void add_thermal(Program& program) {
  add_forwarding_subcommand(
      program, "thermal",
      "Computes the finite-element thermal image of the working gyro at rest (gyrotherm-thermal image).",
      "gyrotherm thermal --mesh medium --out image", become_thermal_program);
}

}  // namespace gyrotherm::app
