// SPDX-License-Identifier: Apache-2.0
#include "apps/console/completion.hpp"

#include <fmt/format.h>

#include "apps/console/command.hpp"
#include "apps/console/value.hpp"

namespace gyrotherm::app {
namespace {

struct CompletionArguments {
  std::string shell, names;
};

Result<Exit> complete(Program& program, const CompletionArguments& options) {
  if (!options.names.empty()) {
    const auto* kind = value_kind(options.names);
    if (kind == nullptr || kind->shipped == nullptr)
      return failure(FaultKind::usage, "--names", fmt::format("\"{}\" has no shipped files", options.names));
    for (const auto& name : shipped_names(*kind->shipped)) program.console.data(name + "\n");
    return Exit::done;
  }
  if (options.shell.empty()) return failure(FaultKind::usage, "completion", "for which shell? bash, zsh or fish");
  const auto commands = describe_commands(program.cli);
  program.console.data(options.shell == "bash"  ? bash_completion(commands)
                       : options.shell == "zsh" ? zsh_completion(commands)
                                                : fish_completion(commands));
  return Exit::done;
}

}  // namespace

void add_completion(Program& program) {
  const auto options = std::make_shared<CompletionArguments>();
  const auto name = program.cli.get_name();
  auto& command = add_command(program, "completion",
                              "Prints what a shell needs to complete commands, options, and names of profiles and "
                              "rigs.",
                              fmt::format("{} completion bash", name));
  command.add_option("shell", options->shell, "bash, zsh or fish")
      ->type_name("SHELL")
      ->check(CLI::IsMember({"bash", "zsh", "fish"}));
  command.add_option("--names", options->names, "the shipped files of a kind, for these scripts")->group("");
  command.callback([&program, options] { program.outcome = complete(program, *options); });
}

}  // namespace gyrotherm::app
