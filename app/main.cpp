/// The gyrotherm program: reads the command line, runs one command, ends with its exit code.
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "app/command.hpp"
#include "app/interrupt.hpp"
#include "core/nearest.hpp"

namespace gyrotherm {
namespace {

void add_commands(Program& program) {
  add_qualify(program);
  add_run(program);
  add_resume(program);
  add_status(program);
  add_tell(program);
  add_simulate(program);
  add_check(program);
  add_devices(program);
  add_import(program);
  add_export(program);
  add_thermal(program);
  add_train(program);
  add_verify(program);
  add_placement(program);
  add_reduce(program);
  add_compensate(program);
  add_export_model(program);
  add_report(program);
}

/// What to say of a first word that is no command, or "" if it is one or there is none.
std::string unknown_command(const CLI::App& cli, int argc, char** argv) {
  std::vector<std::string> known;
  for (const auto* command : cli.get_subcommands({})) known.push_back(command->get_name());
  if (argc < 2 || argv[1][0] == '-' || std::find(known.begin(), known.end(), argv[1]) != known.end()) return {};
  const auto near = nearest(argv[1], known);
  return near.empty() ? fmt::format("\"{}\" is none of the commands {}", argv[1], fmt::join(known, ", "))
                      : fmt::format("\"{}\" is no command. Did you mean \"{}\"?", argv[1], near);
}

/// Whether whoever read our data has had enough of it, as `head` has.
bool reader_has_left() {
  pollfd out{STDOUT_FILENO, POLLOUT, 0};
  return ::poll(&out, 1, 0) == 1 && (out.revents & POLLERR) != 0;
}

int run(int argc, char** argv) {
  Program program;
  program.cli->description("gyrotherm runs a gyroscope through a temperature program and makes its bias compensation.");
  program.cli->name("gyrotherm");
  program.cli->require_subcommand(1);
  program.cli->set_version_flag("--version", std::string("gyrotherm ") + GYROTHERM_VERSION);
  add_commands(program);
  try {
    program.cli->parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return program.cli->exit(error);
    const auto unknown = unknown_command(*program.cli, argc, argv);
    fmt::print(stderr, "gyrotherm: {}\n", unknown.empty() ? error.what() : unknown);
    fmt::print(stderr, "Run with --help for more information.\n");
    return static_cast<int>(Exit::usage);
  }
  const bool lost = std::ferror(stdout) != 0 || program.console.data_was_lost();
  if (program.outcome && lost && !reader_has_left())
    program.outcome = failure(FaultKind::storage, "stdout", "cannot be written");
  if (program.outcome) return static_cast<int>(*program.outcome);
  program.console.complain(program.outcome.error());
  return static_cast<int>(exit_for(program.outcome.error()));
}

}  // namespace
}  // namespace gyrotherm

int main(int argc, char** argv) {
  gyrotherm::ignore_closed_pipes();
  return gyrotherm::run(argc, argv);
}
