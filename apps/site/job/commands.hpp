// SPDX-License-Identifier: Apache-2.0
/// What gyrotherm-site does with jobs: `train`, `seeds`, `leave-one-out` and `placement` make one and hand it out,
/// `job` says how far one is or goes on with it, `task` carries out one task.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

#include "core/result.hpp"

namespace gyrotherm::site {

/// What a command line asks for; the exit code.
using Action = std::function<Result<int>()>;

/// `words` are those behind "--", which are passed on to the commands of the tasks.
void add_job_commands(CLI::App& program, std::vector<std::string> words, Action& action);

}  // namespace gyrotherm::site
