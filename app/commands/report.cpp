// SPDX-License-Identifier: Apache-2.0
#include "app/command.hpp"
#include "report/views.hpp"

namespace gyrotherm::app {

void add_report(Program& program) {
  auto folder = std::make_shared<std::string>();
  auto command =
      add_command(program, "report", "Rebuilds the report from what qualify left in a folder.", "gyrotherm report out");
  command.option("dir", *folder, "the folder that qualify wrote").required();
  command.action([&program, folder]() -> Result<Exit> {
    const auto report = *folder + "/report";
    if (auto rebuilt = report::rebuild_report(report); !rebuilt) return failure(rebuilt.error());
    program.console.say(report + "/report.html");
    return Exit::done;
  });
}

}  // namespace gyrotherm::app
