// SPDX-License-Identifier: Apache-2.0
#include "apps/console/command.hpp"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <new>
#include <optional>
#include <span>
#include <system_error>

#include "apps/console/interrupt.hpp"
#include "core/process.hpp"
#include "core/program_start.hpp"

namespace gyrotherm::app {

Exit exit_code_for(const Fault& fault) {
  switch (fault.kind) {
    case FaultKind::timeout:
    case FaultKind::disconnected:
    case FaultKind::refused:
    case FaultKind::corrupted:
    case FaultKind::out_of_range:
    case FaultKind::mismatch: return Exit::instrument;
    case FaultKind::interlock: return Exit::interlock;
    case FaultKind::bad_file:
    case FaultKind::storage:
    case FaultKind::numeric: return Exit::file;
    case FaultKind::interrupted: return Exit::interrupted;
    case FaultKind::usage: return Exit::usage;
  }
  return Exit::usage;
}

Program::Program(const std::string& name, const std::string& description) : cli(description, name) {
  cli.require_subcommand(1);
  cli.set_version_flag("--version", name + " " + GYROTHERM_VERSION);
}

CLI::App& add_command(Program& program, const std::string& name, const std::string& description,
                      const std::string& example) {
  return add_subcommand(program, program.cli, name, description, example);
}

CLI::App& add_subcommand(Program& program, CLI::App& parent, const std::string& name, const std::string& description,
                         const std::string& example) {
  auto& command = *parent.add_subcommand(name, "Example: " + example + "\n\n" + description);
  command.add_flag("--json", program.console.json, "print facts as JSON");
  command.add_flag("-v,--verbose", program.console.verbose, "print more details");
  command.add_flag("--quiet", program.console.quiet, "print no messages and no progress, only results and errors");
  return command;
}

void add_outside_option(CLI::App& command, std::string& outside, const std::string& refused) {
  command
      .add_option("--outside", outside,
                  fmt::format("inputs outside the trained range: continue (default: the linear part extrapolates, the "
                              "remainder keeps its value at the end of the range), refuse ({}) or extrapolate",
                              refused))
      ->type_name("WORD:{continue,refuse,extrapolate}");
}

CLI::Validator not_negative() {
  const auto check = [](const std::string& text) { return std::string(text.starts_with('-') ? "is negative" : ""); };
  return {check, "NONNEGATIVE"};
}

CLI::Validator reject_dash() {
  const auto check = [](const std::string& text) {
    return std::string(text == "-" ? "\"-\" is not a file name here; for a file with this name write ./-" : "");
  };
  return {check, ""};
}

void add_forwarding_subcommand(Program& program, const std::string& name, const std::string& description,
                               const std::string& example,
                               std::function<Result<Exit>(const std::vector<std::string>& arguments)> action) {
  auto* app = program.cli.add_subcommand(name, "Example: " + example + "\n\n" + description);
  app->prefix_command();
  app->set_help_flag();
  app->callback([&program, app, action = std::move(action)] { program.outcome = action(app->remaining()); });
}

Result<Exit> exec_sibling_program(const std::string& name, std::vector<std::string> arguments) {
  std::string own_name = name;
  std::vector<char*> argv{own_name.data()};
  for (auto& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  const auto program = sibling_program_path(name);
  ::execv(program.c_str(), argv.data());
  return failure(FaultKind::bad_file, program, std::generic_category().message(errno));
}

namespace {

/// Replaces "help COMMAND" by "COMMAND --help" and "version" by "--version", unless the program has such a command.
std::vector<char*> replace_spoken_options(const CLI::App& program, std::span<char*> words) {
  static std::string help = "--help", version = "--version";
  std::vector<char*> replaced(words.begin(), words.end());
  if (words.size() < 2) return replaced;
  const std::string_view first = words[1];
  const auto is_command = [&](std::string_view word) {
    return !program.get_subcommands([&](const CLI::App* each) { return each->get_name() == word; }).empty();
  };
  if (is_command(first)) return replaced;
  if (first == "version" && words.size() == 2) replaced[1] = version.data();
  if (first != "help") return replaced;
  replaced.erase(replaced.begin() + 1);
  if (words.size() == 2 || is_command(words[2])) replaced.push_back(help.data());
  return replaced;
}

}  // namespace

int run(Program& program, int argc, char** argv) {
  ignore_write_signals();
  const std::string name = program.cli.get_name();
  auto words = replace_spoken_options(program.cli, std::span(argv, static_cast<std::size_t>(argc)));
  refuse_invalid_values(program.cli);
  try {
    program.cli.parse(static_cast<int>(words.size()), words.data());
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return program.cli.exit(error);
    const auto cause = find_error_cause(error.what(), program.cli, std::span<char* const>(words));
    write_to_stderr(fmt::format("{}: {}\nRun with --help for more information.\n", name, cause));
    return static_cast<int>(Exit::usage);
  } catch (const std::bad_alloc&) {
    program.outcome = failure(FaultKind::storage, "memory", "not enough memory for this command");
  }
  if (program.outcome && program.console.has_lost_data() && !is_stdout_closed())
    program.outcome = failure(FaultKind::storage, "stdout", "cannot be written");
  if (program.outcome) return static_cast<int>(*program.outcome);
  program.console.print_fault(name, program.outcome.error());
  return static_cast<int>(exit_code_for(program.outcome.error()));
}

double peak_memory_mb() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

}  // namespace gyrotherm::app
