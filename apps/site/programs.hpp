// SPDX-License-Identifier: Apache-2.0
/// Common parts of both programs of a site: parsing of the command line, and exit codes.
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <optional>
#include <span>
#include <string>

#include "core/program_start.hpp"
#include "core/result.hpp"
#include "core/text.hpp"

namespace gyrotherm::site {

inline constexpr int kDoneExit = 0, kUsageExit = 2, kConnectionExit = 3, kFileExit = 4, kInterruptedExit = 5;

/// Parses the command line. Returns the exit code if the program must end now, otherwise nothing.
[[nodiscard]] inline std::optional<int> parse_command_line(CLI::App& cli, int argc, char** argv) {
  refuse_invalid_values(cli);
  try {
    cli.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return cli.exit(error);
    const auto cause = find_error_cause(error.what(), cli, std::span(argv, static_cast<std::size_t>(argc)));
    write_to_stderr(fmt::format("{}: {}\nRun with --help for more information.\n", cli.get_name(), cause));
    return kUsageExit;
  }
  return std::nullopt;
}

/// Prints a fault and returns its exit code.
[[nodiscard]] inline int report_fault(const std::string& program, const Fault& fault) {
  if (fault.kind == FaultKind::interrupted) return kInterruptedExit;
  write_to_stderr(fmt::format("{}: {}\n", program, plain(text(fault), Blanks::kept)));
  switch (fault.kind) {
    case FaultKind::usage: return kUsageExit;
    case FaultKind::disconnected:
    case FaultKind::timeout: return kConnectionExit;
    default: return kFileExit;
  }
}

}  // namespace gyrotherm::site
