// SPDX-License-Identifier: Apache-2.0
#include "app/command.hpp"
#include "report/views.hpp"

namespace gyrotherm::app {
namespace {

struct ReportArguments {
  std::string folder;
};

Result<Exit> rebuild(Console& console, const ReportArguments& options) {
  const auto report = options.folder + "/report";
  if (auto rebuilt = report::rebuild_report(report); !rebuilt) return failure(rebuilt.error());
  console.say(report + "/report.html");
  return Exit::done;
}

}  // namespace

void add_report(Program& program) {
  auto [command, options] = add_command(program, "report", "Rebuilds the report from what qualify left in a folder.",
                                        "gyrotherm report out", rebuild);
  command.add_option("dir", options.folder, "the folder that qualify wrote")->required();
}

}  // namespace gyrotherm::app
