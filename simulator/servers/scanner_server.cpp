// SPDX-License-Identifier: Apache-2.0
#include "simulator/servers/scanner_server.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "simulator/servers/text_unit_session.hpp"

namespace gyrotherm::simulator {
namespace {

constexpr Celsius kAbsoluteZero{-kZeroCelsiusInKelvin};

class ScannerSession final : public TextUnitSession {
 public:
  ScannerSession(const VirtualLaboratory& laboratory, const drivers::ThermometerDescription& description,
                 std::vector<std::size_t> inputs)
      : TextUnitSession(description.unit.link),
        laboratory_(laboratory),
        description_(description),
        inputs_(std::move(inputs)) {}

 private:
  std::optional<std::string> answer_line(const std::string& line) override {
    if (line == description_.unit.text_link->identity_question)
      return description_.unit.text_link->identity_answers.front().format(
          {{drivers::kReadingField, description_.simulated.identity}});
    for (const auto& step : description_.preparation)
      if (step.line == line) return answer_step(step);
    for (const auto* questions : {&description_.readings, &description_.statuses})
      for (const auto& question : *questions) {
        if (std::ranges::find(question.before, line) != question.before.end()) {
          received_.insert(line);
          return std::nullopt;
        }
        if (question.ask == line && is_prepared_for(question)) return answer_question(question, questions);
      }
    const auto& unknown = description_.simulated.unknown;
    return unknown.empty() ? std::nullopt : std::optional(unknown);
  }

  std::optional<std::string> answer_step(const drivers::PreparationStep& step) {
    received_.insert(step.line);
    if (step.answers.empty()) return std::nullopt;
    drivers::FieldValues values;
    if (!step.field.empty()) values[step.field] = step.required;
    return step.answers.front().format(values);
  }

  [[nodiscard]] bool is_prepared_for(const drivers::InputQuestion& question) const {
    return std::ranges::all_of(description_.preparation,
                               [&](const auto& step) { return received_.contains(step.line); }) &&
           std::ranges::all_of(question.before, [&](const auto& line) { return received_.contains(line); });
  }

  std::string answer_question(const drivers::InputQuestion& question,
                              const std::vector<drivers::InputQuestion>* questions) {
    for (const auto& line : question.before) received_.erase(line);
    const auto& answer = question.answers.front();
    const bool is_status = questions == &description_.statuses;
    drivers::FieldValues values;
    for (const auto& field : answer.fields()) {
      if (field.name == "_") continue;
      std::vector<std::string> texts;
      for (std::size_t i = 0; i < question.count; ++i) {
        const bool wants_status = is_status || field.name == drivers::kReadingStatusField;
        texts.push_back(wants_status ? status_text(question.first + i) : reading_text(question.first + i, field.form));
      }
      values[field.name] = fmt::format("{}", fmt::join(texts, std::string(1, field.form.separator)));
    }
    return answer.format(values);
  }

  /// Returns the reading at an input, or nothing if the input has no thermometer or a dead one.
  [[nodiscard]] std::optional<Celsius> reading(std::size_t input) const {
    if (input >= inputs_.size()) return std::nullopt;
    const double celsius = laboratory_.thermometers_as_measured_c()[inputs_[input]];
    return std::isnan(celsius) ? std::nullopt : std::optional(Celsius{celsius});
  }

  [[nodiscard]] std::string reading_text(std::size_t input, drivers::FieldForm form) const {
    const auto celsius = reading(input);
    const auto& simulated = description_.simulated;
    if (!celsius && !simulated.invalid.empty()) return simulated.invalid;
    const double number = to_number(description_, celsius.value_or(kAbsoluteZero));
    if (!simulated.number.empty()) return fmt::format(fmt::runtime("{:" + simulated.number + "}"), number);
    form.count = 0;
    return drivers::format_field(form, number);
  }

  [[nodiscard]] std::string status_text(std::size_t input) const {
    return std::to_string(reading(input) ? 0 : description_.simulated.invalid_status);
  }

  const VirtualLaboratory& laboratory_;
  drivers::ThermometerDescription description_;
  std::vector<std::size_t> inputs_;
  /// Lines of the preparation, and commands that precede a question that was not asked yet.
  std::set<std::string> received_;
};

}  // namespace

std::unique_ptr<Session> make_scanner_session(const VirtualLaboratory& laboratory,
                                              const drivers::ThermometerDescription& description,
                                              std::vector<std::size_t> inputs) {
  return std::make_unique<ScannerSession>(laboratory, description, std::move(inputs));
}

}  // namespace gyrotherm::simulator
