#include "app/command.hpp"

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>

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

Program::Program() : cli(std::make_unique<CLI::App>()) {}
Program::~Program() = default;

Option& Option::required() {
  option_->required();
  return *this;
}

Option& Option::one_of(const std::vector<std::string>& words) {
  option_->check(CLI::IsMember(words));
  return *this;
}

Option& Option::within(double least, double most) {
  option_->check(CLI::Range(least, most));
  return *this;
}

Option& Option::not_negative() {
  const auto judge = [](const std::string& text) { return std::string(text.starts_with('-') ? "is negative" : ""); };
  option_->check(judge, "NONNEGATIVE");
  return *this;
}

Option& Option::not_with(const Option& other) {
  option_->excludes(other.option_);
  return *this;
}

template <typename Value>
Option Command::option(const std::string& name, Value& into, const std::string& what) {
  return Option(app_->add_option(name, into, what));
}

template Option Command::option(const std::string&, std::string&, const std::string&);
template Option Command::option(const std::string&, std::vector<std::string>&, const std::string&);
template Option Command::option(const std::string&, int&, const std::string&);
template Option Command::option(const std::string&, std::uint16_t&, const std::string&);
template Option Command::option(const std::string&, std::uint64_t&, const std::string&);
template Option Command::option(const std::string&, double&, const std::string&);
template Option Command::option(const std::string&, std::optional<int>&, const std::string&);
template Option Command::option(const std::string&, std::optional<double>&, const std::string&);

void Command::flag(const std::string& name, bool& into, const std::string& what) { app_->add_flag(name, into, what); }

void Command::action(std::function<Result<Exit>()> action) {
  app_->callback([&program = program_, action = std::move(action)] { program.outcome = action(); });
}

Command add_command(Program& program, const std::string& name, const std::string& description,
                    const std::string& example) {
  Command command(program, program.cli->add_subcommand(name, "Example: " + example + "\n\n" + description));
  command.flag("--json", program.console.json, "print facts as JSON");
  command.flag("-v,--verbose", program.console.verbose, "say more");
  command.flag("--quiet", program.console.quiet, "say nothing but faults");
  return command;
}

}  // namespace gyrotherm
