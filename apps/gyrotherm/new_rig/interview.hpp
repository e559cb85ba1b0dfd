// SPDX-License-Identifier: Apache-2.0
/// Collects the answers about a new rig: from options of the command line, from a person, or from fallbacks.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "apps/gyrotherm/new_rig/rig_answers.hpp"
#include "core/result.hpp"

namespace gyrotherm::app {

/// Answers that the command line gives, by option: {"--latitude", "47.4"}. "--thermometer" is in `scanners`.
struct GivenAnswers {
  std::map<std::string, std::string> values;
  std::vector<std::string> scanners;
};

/// Functions that print to a person and question the person. Both are absent without a person.
struct Person {
  /// Prints a line.
  std::function<void(const std::string& line)> tell;
  /// Asks a question and returns the answer; nothing at the end of the input.
  std::function<std::optional<std::string>(const std::string& question)> ask;
};

/// Collects all answers for the rig file `file`. An answer of the command line must be right. A wrong answer of a
/// person is asked again with the reason; the answer "back" returns to the previous question. Without a person,
/// fallbacks are used. Fails with usage, naming the options, if an answer is missing, is wrong, or does not apply, and
/// at the end of the input.
[[nodiscard]] Result<RigAnswers> collect_answers(const std::string& file, const GivenAnswers& given,
                                                 const Person& person);

}  // namespace gyrotherm::app
