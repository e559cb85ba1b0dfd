// SPDX-License-Identifier: Apache-2.0
#include "apps/console/command.hpp"

namespace gyrotherm::app {
namespace {

/// Becomes the program that speaks to the store; this one, which commands chambers, links no data base.
Result<Exit> become_site_program(const std::vector<std::string>& words) {
  return become_program("gyrotherm-site", words);
}

}  // namespace

void add_site(Program& program) {
  add_forwarded(program, "site", "Asks the store of a site of rigs, and makes it: gyrotherm-site.",
                "gyrotherm site rigs --site site.toml", become_site_program);
}

}  // namespace gyrotherm::app
