// SPDX-License-Identifier: Apache-2.0
/// The job commands of gyrotherm-site: `train`, `seeds`, `leave-one-out` and `placement` create a job and distribute
/// it, `job` prints its progress or continues it, and `task` runs one task.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"

namespace gyrotherm::site {

/// The action of a command line. Returns the exit code.
using Action = std::function<Result<int>()>;

/// Adds the job commands. `task_arguments` are the arguments after "--", which are passed to the commands of the tasks.
/// Parsing sets `action` to the action of the given command.
void add_job_commands(CLI::App& program, std::vector<std::string> task_arguments, Action& action);

/// Returns whether a command passes the arguments after "--" to the commands of its tasks.
[[nodiscard]] bool passes_arguments(std::string_view command);

}  // namespace gyrotherm::site
