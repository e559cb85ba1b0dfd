#include "app/command.hpp"

namespace gyrotherm {

Exit exit_for(const Fault& fault) {
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

CLI::App* add_command(Program& program, const std::string& name, const std::string& description,
                      const std::string& example) {
  auto* command = program.cli.add_subcommand(name, "Example: " + example + "\n\n" + description);
  command->add_flag("--json", program.console.json, "print facts as JSON");
  command->add_flag("-v,--verbose", program.console.verbose, "say more");
  command->add_flag("--quiet", program.console.quiet, "say nothing but faults");
  return command;
}

void set_action(CLI::App* command, Program& program, std::function<Result<Exit>()> action) {
  command->callback([&program, action = std::move(action)] { program.outcome = action(); });
}

}  // namespace gyrotherm
