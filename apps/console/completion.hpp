// SPDX-License-Identifier: Apache-2.0
/// What a shell needs to complete the commands of a program, their options and values: a script for each shell, of the
/// description that the parser has. Names of shipped files are asked for when they are needed, by `completion --names`.
#pragma once

#include <string>

#include "apps/console/command_info.hpp"

namespace gyrotherm::app {

[[nodiscard]] std::string bash_completion(const CommandInfo& program);
[[nodiscard]] std::string zsh_completion(const CommandInfo& program);
[[nodiscard]] std::string fish_completion(const CommandInfo& program);

}  // namespace gyrotherm::app
