// SPDX-License-Identifier: Apache-2.0
/// The questions about a new rig, in their order. A question may depend on the answers before it.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "apps/gyrotherm/new_rig/rig_answers.hpp"
#include "core/result.hpp"

namespace gyrotherm::app {

struct Question {
  /// Option of the command line that gives the answer: "--latitude".
  std::string option;
  std::string text;
  /// Answer if none is given; absent if an answer is required.
  std::optional<std::string> fallback{};
  Result<void> (*accept)(RigAnswers& answers, const std::string& text) = nullptr;
  /// Lines printed before the question is asked: choices and explanations.
  std::vector<std::string> notes{};
};

/// Returns a question, or nothing if it does not apply to the answers so far.
using MakeQuestion = std::optional<Question> (*)(const RigAnswers& answers);

/// Questions before those about the thermometers, about one scanner, and after the thermometers.
[[nodiscard]] std::span<const MakeQuestion> chamber_questions();
[[nodiscard]] std::span<const MakeQuestion> scanner_questions();
[[nodiscard]] std::span<const MakeQuestion> gyro_questions();

/// Option that gives a whole scanner. It may be repeated.
inline constexpr const char* kThermometerOption = "--thermometer";
/// Answer that ends the list of scanners.
inline constexpr const char* kNoMore = "none";

}  // namespace gyrotherm::app
