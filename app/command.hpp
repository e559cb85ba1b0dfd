/// What every subcommand is made of: options, and an action that ends in an exit code or a fault.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

#include "app/console.hpp"
#include "core/result.hpp"

namespace gyrotherm {

/// The exit codes that users rely on.
enum class Exit : int {
  done = 0,
  outside_limits = 1,
  usage = 2,
  instrument = 3,
  file = 4,
  interrupted = 5,
  interlock = 6,
};

[[nodiscard]] Exit exit_for(const Fault& fault);

struct Program {
  CLI::App cli;
  Console console;
  Result<Exit> outcome = Exit::done;
};

/// Adds a subcommand whose help opens with an example.
CLI::App* add_command(Program& program, const std::string& name, const std::string& description,
                      const std::string& example);
/// What it does once its options have been read.
void set_action(CLI::App* command, Program& program, std::function<Result<Exit>()> action);

void add_check(Program& program);
void add_compensate(Program& program);
void add_devices(Program& program);
void add_export(Program& program);
void add_export_model(Program& program);
void add_import(Program& program);
void add_placement(Program& program);
void add_qualify(Program& program);
void add_reduce(Program& program);
void add_report(Program& program);
void add_resume(Program& program);
void add_run(Program& program);
void add_simulate(Program& program);
void add_status(Program& program);
void add_tell(Program& program);
void add_thermal(Program& program);
void add_train(Program& program);
void add_verify(Program& program);

}  // namespace gyrotherm
