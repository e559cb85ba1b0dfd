// SPDX-License-Identifier: Apache-2.0
/// `gyrotherm manual`, which the build makes the manual pages with; help does not show it.
#include "apps/console/manual.hpp"

#include <fmt/format.h>

#include "apps/console/command.hpp"
#include "core/file.hpp"

namespace gyrotherm::app {
namespace {

struct ManualArguments {
  std::string command, prose, date, name;
};

Result<Exit> print_page(Program& program, const ManualArguments& options) {
  auto prose = options.prose.empty() ? Result<std::string>("") : read_text_file(options.prose);
  if (!prose) return failure(prose.error());
  const ManualText text{.prose = std::move(*prose), .date = options.date, .version = GYROTHERM_VERSION};
  if (!options.name.empty()) {
    program.console.data(manual_page(options.name, text));
    return Exit::done;
  }
  const auto commands = describe_commands(program.cli);
  const CommandInfo* wanted = options.command.empty() ? &commands : nullptr;
  for (const auto& command : commands.below)
    if (command.path.back() == options.command) wanted = &command;
  if (wanted == nullptr)
    return failure(FaultKind::usage, "manual", fmt::format("\"{}\" is no command", options.command));
  program.console.data(manual_page(*wanted, text));
  return Exit::done;
}

}  // namespace

void add_manual(Program& program) {
  const auto options = std::make_shared<ManualArguments>();
  auto& command = add_command(program, "manual", "Prints the manual page of a command in the macros of man(7).",
                              "gyrotherm manual run --prose docs/man/gyrotherm-run.md");
  command.group("");
  command.add_option("command", options->command, "the command; without it the program");
  command.add_option("--prose", options->prose, "what the page says beside the options");
  command.add_option("--name", options->name, "of a page that is prose alone, of another program");
  command.add_option("--date", options->date, "of the release");
  command.callback([&program, options] { program.outcome = print_page(program, *options); });
}

}  // namespace gyrotherm::app
