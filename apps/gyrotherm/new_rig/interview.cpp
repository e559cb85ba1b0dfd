// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/new_rig/interview.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <deque>
#include <set>
#include <utility>

#include "apps/gyrotherm/new_rig/rig_questions.hpp"
#include "core/text.hpp"

namespace gyrotherm::app {
namespace {

/// Options without which no rig file can be written.
constexpr std::array kRequired{"--chamber",        "--chamber-line", "--lowest",    "--highest", "--fastest",
                               kThermometerOption, "--gyro",         "--gyro-line", "--latitude"};

/// Answer that returns to the previous question.
constexpr const char* kBack = "back";

class Interview {
 public:
  Interview(const std::string& file, const GivenAnswers& given, const Person& person) : given_(given), person_(person) {
    answers_.file = file;
  }

  /// Holds the interview. If the person goes back, begins again and repeats the earlier answers.
  Result<RigAnswers> hold() {
    const auto file = answers_.file;
    while (true) {
      auto held = hold_once();
      if (!std::exchange(goes_back_, false)) return held;
      answers_ = {};
      answers_.file = file;
      used_.clear();
      repeated_ = std::exchange(history_, {});
    }
  }

 private:
  Result<RigAnswers> hold_once() {
    if (auto complete = check_required(); !complete) return failure(complete.error());
    if (auto done = settle_all(chamber_questions()); !done) return failure(done.error());
    if (auto done = settle_scanners(); !done) return failure(done.error());
    if (auto done = settle_all(gyro_questions()); !done) return failure(done.error());
    for (const auto& [option, value] : given_.values)
      if (!used_.contains(option)) return failure(FaultKind::usage, option, "does not apply to this chamber or gyro");
    return std::move(answers_);
  }

  Result<void> check_required() const {
    if (person_.ask) return {};
    std::vector<std::string> missing;
    for (const char* option : kRequired) {
      const bool is_given =
          option == std::string(kThermometerOption) ? !given_.scanners.empty() : given_.values.contains(option);
      if (!is_given) missing.emplace_back(option);
    }
    if (missing.empty()) return {};
    return failure(FaultKind::usage, fmt::format("{}", fmt::join(missing, ", ")),
                   "missing; give them as options, or answer the questions at a terminal, without --yes");
  }

  Result<void> settle_all(std::span<const MakeQuestion> questions) {
    for (const auto& make : questions)
      if (const auto question = make(answers_))
        if (auto settled = settle(*question); !settled) return settled;
    return {};
  }

  Result<void> settle(const Question& question) {
    if (const auto given = given_.values.find(question.option); given != given_.values.end()) {
      used_.insert(question.option);
      return accept(question, given->second);
    }
    if (person_.ask) return ask(question).map([](const std::string&) {});
    if (question.fallback) return accept(question, *question.fallback);
    return failure(FaultKind::usage, question.option, "missing: " + question.text);
  }

  Result<void> accept(const Question& question, const std::string& text) {
    return name_option(question.option, question.accept(answers_, text));
  }

  static Result<void> name_option(const std::string& option, Result<void> accepted) {
    if (accepted) return accepted;
    return failure(FaultKind::usage, option, text(accepted.error()));
  }

  /// Asks until the answer is accepted, and returns it. The answer kNoMore to a question with this fallback ends the
  /// list of scanners and is not passed on.
  Result<std::string> ask(const Question& question) {
    if (!repeated_.empty()) {
      auto answer = std::move(repeated_.front());
      repeated_.pop_front();
      if (is_end_of_list(question, answer) || question.accept(answers_, answer)) return remember(answer);
      repeated_.clear();  // the surroundings have changed: the question is asked again
    }
    for (const auto& note : question.notes) person_.tell(note);
    const auto shown =
        question.fallback ? fmt::format("{} [{}]: ", question.text, *question.fallback) : question.text + ": ";
    while (true) {
      const auto line = person_.ask(shown);
      if (!line)
        return failure(
            FaultKind::usage, question.option,
            fmt::format("the input ended before the answer to \"{}\"; nothing was written", trimmed(question.text)));
      std::string answer(trimmed(*line));
      if (answer == kBack && !history_.empty()) {
        history_.pop_back();
        goes_back_ = true;
        return failure(FaultKind::interrupted, question.option, "the previous question is asked again");
      }
      if (answer == kBack) {
        person_.tell("  this is the first question");
        continue;
      }
      if (answer.empty()) answer = question.fallback.value_or("");
      if (answer.empty()) {
        person_.tell("  an answer is needed here");
        continue;
      }
      if (is_end_of_list(question, answer)) return remember(answer);
      const auto accepted = question.accept(answers_, answer);
      if (accepted) return remember(answer);
      person_.tell(fmt::format("  {}; \"{}\" returns to the previous question", text(accepted.error()), kBack));
    }
  }

  std::string remember(const std::string& answer) { return history_.emplace_back(answer); }

  static bool is_end_of_list(const Question& question, const std::string& answer) {
    return answer == kNoMore && question.option == kThermometerOption &&
           question.accept == static_cast<decltype(question.accept)>(accept_scanner_kind);
  }

  Result<void> settle_scanners() {
    for (const auto& text : given_.scanners)
      if (auto accepted = name_option(kThermometerOption, accept_scanner(answers_, text)); !accepted) return accepted;
    while (given_.scanners.empty() && list_channel_names(answers_).size() < kMostChannels) {
      answers_.scanners.emplace_back();
      bool is_last = false;
      for (const auto& make : scanner_questions()) {
        const auto question = make(answers_);
        if (!question) continue;
        const auto answer = ask(*question);
        if (!answer) return failure(answer.error());
        is_last = is_end_of_list(*question, *answer);
        if (is_last) break;
      }
      if (!is_last) continue;
      answers_.scanners.pop_back();
      if (list_channel_names(answers_).size() >= kFewestChannels) break;
      person_.tell("  a rig has two thermometers at least");
    }
    if (list_channel_names(answers_).size() >= kFewestChannels) return {};
    return failure(FaultKind::usage, kThermometerOption, "a rig has two thermometers at least");
  }

  static constexpr std::size_t kFewestChannels = 2, kMostChannels = 256;

  const GivenAnswers& given_;
  const Person& person_;
  RigAnswers answers_;
  std::set<std::string> used_;
  /// Accepted answers of the person, in order.
  std::deque<std::string> history_;
  /// Answers to repeat after the person went back.
  std::deque<std::string> repeated_;
  bool goes_back_ = false;
};

}  // namespace

Result<RigAnswers> collect_answers(const std::string& file, const GivenAnswers& given, const Person& person) {
  return Interview(file, given, person).hold();
}

}  // namespace gyrotherm::app
