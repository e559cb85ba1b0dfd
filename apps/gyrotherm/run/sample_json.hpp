// SPDX-License-Identifier: Apache-2.0
/// A second of a run as one line of JSON: what `run --json=samples` prints.
#pragma once

#include <span>
#include <string>

#include "acquisition/record/run_info.hpp"
#include "apps/console/command.hpp"
#include "core/sample.hpp"

namespace gyrotherm::app {

/// Raw readings as they came, null where there is none; keys say the unit. `events`: those of this second.
[[nodiscard]] std::string sample_json(const Sample& sample, std::span<const Event> events, const record::RunInfo& info);

/// The option --json of a command that carries a run out, in the place of the one that every command has: it may ask
/// for `samples`.
void add_json_of_run(CLI::App& command, std::string& json);
/// Does what that option asked for.
void apply_json_of_run(Console& console, const std::string& json);

}  // namespace gyrotherm::app
