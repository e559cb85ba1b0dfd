// SPDX-License-Identifier: Apache-2.0
/// What every subcommand is made of: options, and an action that ends in an exit code or a fault; and what more than
/// one of them asks of the machine.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "app/console.hpp"
#include "core/result.hpp"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace gyrotherm::app {

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

/// A program of subcommands.
struct Program {
  Program(const std::string& name, const std::string& description);
  ~Program();

  std::unique_ptr<CLI::App> cli;
  Console console;
  Result<Exit> outcome = Exit::done;
};

/// One option or argument of a subcommand, while it is described.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}
  Option& required();
  Option& one_of(const std::vector<std::string>& words);
  Option& within(double least, double most);
  Option& not_negative();
  Option& not_with(const Option& other);

 private:
  CLI::Option* option_;
};

/// One subcommand, while it is described.
class Command {
 public:
  Command(Program& program, CLI::App* app) : program_(program), app_(app) {}
  /// An option "--name", or an argument "name". What it is read into lives as long as the command; it is a text, texts,
  /// a number, or an optional number.
  template <typename Value>
  Option option(const std::string& name, Value& into, const std::string& what);
  void flag(const std::string& name, bool& into, const std::string& what);
  /// What it does once its options have been read.
  void action(std::function<Result<Exit>()> action);

 private:
  Program& program_;
  CLI::App* app_;
};

/// Adds a subcommand whose help opens with an example.
Command add_command(Program& program, const std::string& name, const std::string& description,
                    const std::string& example);

/// Does the same, and has it carry out `what` with its options, in which defaults may be put first.
template <class Options>
std::pair<Command, Options&> add_command(Program& program, const std::string& name, const std::string& description,
                                         const std::string& example, Result<Exit> (*what)(Console&, const Options&)) {
  const auto options = std::make_shared<Options>();
  auto command = add_command(program, name, description, example);
  command.action([&program, options, what] { return what(program.console, *options); });
  return {command, *options};
}

/// Adds a subcommand that reads none of the words after it, options and --help among them, but hands them to `action`.
void add_forwarded(Program& program, const std::string& name, const std::string& description,
                   const std::string& example,
                   std::function<Result<Exit>(const std::vector<std::string>& words)> action);

/// Reads the command line, carries the subcommand out, says what became of it; returns the exit code.
[[nodiscard]] int run(Program& program, int argc, char** argv);

/// "profiles/rigs/virtual.toml" as the user would write it if it is there, else the copy that was built or installed
/// with the program.
[[nodiscard]] std::string shipped(const std::string& path);
/// The path that was given, else a shipped one.
[[nodiscard]] inline std::string given_or_shipped(const std::string& given, const std::string& path) {
  return given.empty() ? shipped(path) : given;
}

/// The most that the program has held so far.
[[nodiscard]] double peak_memory_mb();

}  // namespace gyrotherm::app
