// SPDX-License-Identifier: Apache-2.0
#include "drivers/thermometer/text_thermometer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "core/deadline.hpp"
#include "core/text.hpp"
#include "drivers/chamber/text_client.hpp"

namespace gyrotherm::drivers {
namespace {

/// Largest status; all flags are below it.
constexpr double kLargestStatus = 0xFFFFFFFF;
/// Characters of the identity that are compared, because a regular expression needs stack for each character.
constexpr std::size_t kLongestIdentity = 128;
/// A longer scan is a silent instrument.
constexpr Duration kLongestMeasuredScan = std::chrono::seconds(10);

/// Returns the numbers of a field: one, or those of a list. The result is empty if the answer does not have it.
std::vector<double> numbers_of(const FieldValues& fields, const char* field) {
  const auto found = fields.find(field);
  if (found == fields.end()) return {};
  if (const auto* list = std::get_if<std::vector<double>>(&found->second)) return *list;
  const auto* number = std::get_if<double>(&found->second);
  return number ? std::vector{*number} : std::vector<double>{};
}

class TextThermometer final : public Thermometer {
 public:
  TextThermometer(ThermometerDescription description, std::unique_ptr<ByteStream> stream, std::string place,
                  const Clock* clock)
      : description_(std::move(description)),
        place_(place),
        clock_(clock),
        client_(description_.unit, std::move(stream), std::move(place), clock) {}

  Result<std::string> identify() override {
    auto identity = ask_identity();
    if (!identity) return identity;
    if (auto prepared = prepare(); !prepared) return failure(std::move(prepared.error()));
    if (auto measured = measure_scan(); !measured) return failure(std::move(measured.error()));
    return identity;
  }
  Result<std::string> recognise() override { return ask_identity(); }
  std::uint64_t breaks() const override { return client_.breaks(); }

  std::vector<Result<Celsius>> read() override {
    std::vector<Result<Celsius>> readings;
    if (auto ready = make_ready(); !ready) return {description_.inputs, failure(std::move(ready.error()))};
    for (std::size_t i = 0; i < description_.readings.size(); ++i) {
      const auto& question = description_.readings[i];
      auto failed = ask_inputs(question, description_.statuses.empty() ? nullptr : &description_.statuses[i], readings);
      if (!failed) continue;
      const bool continues = failed->kind == FaultKind::refused;
      readings.resize(continues ? question.first + question.count : description_.inputs, failure(*failed));
      if (continues) continue;
      is_prepared_ = false;
      break;
    }
    return readings;
  }

 private:
  [[nodiscard]] bool is_recognised() const { return recognised_after_ == client_.breaks(); }

  Result<std::string> ask_identity() {
    const auto& text = *description_.unit.text_link;
    auto answer = client_.ask(text.identity_question, text.identity_answers);
    if (!answer) return failure(std::move(answer.error()));
    const auto* whole = std::get_if<std::string>(&answer->fields[kReadingField]);
    auto identity = whole ? whole->substr(0, kLongestIdentity) : std::string();
    if (const auto& pattern = description_.unit.identity->pattern; !fits_expression(pattern, identity)) {
      recognised_after_.reset();
      return failure(FaultKind::mismatch, place_,
                     fmt::format("the identity is \"{}\", which does not fit \"{}\"", plain(identity), pattern));
    }
    if (!is_recognised()) is_prepared_ = false;
    recognised_after_ = client_.breaks();
    return identity;
  }

  /// Identifies and prepares the instrument, unless this has been done on the present connection.
  Result<void> make_ready() {
    if (!is_recognised())
      if (auto identity = ask_identity(); !identity) return failure(std::move(identity.error()));
    return prepare();
  }

  Result<void> prepare() {
    if (is_prepared_) return {};
    for (const auto& step : description_.preparation)
      if (auto done = perform(step); !done) return done;
    is_prepared_ = true;
    return {};
  }

  /// Asks each question for readings once, with a generous time limit. Fails with timeout if an answer takes longer
  /// than the limit of the description, because all readings of a run would then be missing.
  Result<void> measure_scan() {
    if (is_scan_measured_) return {};
    for (const auto& question : description_.readings) {
      const Deadline deadline(kLongestMeasuredScan, clock_);
      const auto answer = ask(question, kLongestMeasuredScan);
      if (!answer && answer.error().kind != FaultKind::refused) return failure(answer.error());
      const auto taken = kLongestMeasuredScan - deadline.left();
      if (taken <= description_.within) continue;
      return failure(
          FaultKind::timeout, place_,
          fmt::format("the answer to \"{}\" takes {:.2f} s, but its time limit is {:g} s and a run reads once a "
                      "second: measure fewer inputs, or shorten the measurement of each",
                      plain(question.ask), to_seconds(taken), to_seconds(description_.within)));
    }
    is_scan_measured_ = true;
    return {};
  }

  Result<void> perform(const PreparationStep& step) {
    if (step.answers.empty()) return client_.tell(step.line);
    const auto answer = client_.ask(step.line, step.answers);
    if (!answer) return failure(answer.error());
    if (step.field.empty()) return {};
    const auto found = answer->fields.find(step.field);
    if (found != answer->fields.end() && found->second == step.required) return {};
    return failure(FaultKind::mismatch, place_,
                   fmt::format("the answer to \"{}\" is \"{}\", so the instrument is not prepared", plain(step.line),
                               plain(answer->line)));
  }

  /// Appends the readings of a question's inputs. Returns a fault if the question or that of the status failed.
  std::optional<Fault> ask_inputs(const InputQuestion& question, const InputQuestion* status,
                                  std::vector<Result<Celsius>>& readings) {
    auto answer = ask(question);
    if (!answer) return std::move(answer.error());
    const auto numbers = numbers_of(*answer, kReadingField);
    auto statuses = numbers_of(*answer, kReadingStatusField);
    if (status) {
      auto its = ask(*status);
      if (!its) return std::move(its.error());
      statuses = numbers_of(*its, kReadingField);
    }
    statuses.resize(numbers.size());
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      auto reading = convert_reading(description_, question.first + i, numbers[i],
                                     static_cast<std::int64_t>(std::clamp(statuses[i], 0.0, kLargestStatus)));
      if (!reading) reading.error() = add_location(place_, std::move(reading.error()));
      readings.push_back(std::move(reading));
    }
    return std::nullopt;
  }

  Result<FieldValues> ask(const InputQuestion& question) { return ask(question, description_.within); }
  Result<FieldValues> ask(const InputQuestion& question, Duration within) {
    for (const auto& command : question.before)
      if (auto sent = client_.tell(command); !sent) return failure(std::move(sent.error()));
    auto answer = client_.ask(question.ask, question.answers, within);
    if (!answer) return failure(std::move(answer.error()));
    return std::move(answer->fields);
  }

  ThermometerDescription description_;
  std::string place_;
  /// The steady clock if null.
  const Clock* clock_;
  TextClient client_;
  /// Number of broken connections before the one on which the instrument was recognised.
  std::optional<std::uint64_t> recognised_after_;
  bool is_prepared_ = false, is_scan_measured_ = false;
};

}  // namespace

std::unique_ptr<Thermometer> make_text_thermometer(ThermometerDescription description,
                                                   std::unique_ptr<ByteStream> stream, std::string place,
                                                   const Clock* clock) {
  return std::make_unique<TextThermometer>(std::move(description), std::move(stream), std::move(place), clock);
}

}  // namespace gyrotherm::drivers
