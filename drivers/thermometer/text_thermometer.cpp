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
#include "drivers/chamber/register_item.hpp"
#include "drivers/chamber/text_instrument.hpp"

namespace gyrotherm::drivers {
namespace {

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
        instrument_(description_, std::move(stream), std::move(place), clock) {}

  Result<std::string> identify() override {
    auto identity = instrument_.identify();
    if (!identity) return identity;
    if (auto measured = measure_scan(); !measured) return failure(std::move(measured.error()));
    return identity;
  }
  Result<std::string> recognise() override { return instrument_.recognise(); }
  std::uint64_t breaks() const override { return instrument_.breaks(); }

  std::vector<Result<Celsius>> read() override {
    std::vector<Result<Celsius>> readings;
    if (auto ready = instrument_.make_ready(); !ready) return {description_.inputs, failure(std::move(ready.error()))};
    for (std::size_t i = 0; i < description_.readings.size(); ++i) {
      const auto& question = description_.readings[i];
      auto failed = ask_inputs(question, description_.statuses.empty() ? nullptr : &description_.statuses[i], readings);
      if (!failed) continue;
      const bool continues = failed->kind == FaultKind::refused;
      readings.resize(continues ? question.first + question.count : description_.inputs, failure(*failed));
      if (continues) continue;
      instrument_.forget_preparation();
      break;
    }
    return readings;
  }

 private:
  /// Asks each question for readings once, with a generous time limit. Fails with timeout if an answer takes longer
  /// than the limit of the description, because all readings of a run would then be missing.
  Result<void> measure_scan() {
    if (is_scan_measured_) return {};
    const auto limit = description_.within.value_or(description_.unit.link.modbus.timeout);
    for (const auto& question : description_.readings) {
      const Deadline deadline(kLongestMeasuredScan, clock_);
      const auto answer = ask(question, kLongestMeasuredScan);
      if (!answer && answer.error().kind != FaultKind::refused) return failure(answer.error());
      const auto taken = kLongestMeasuredScan - deadline.left();
      if (taken <= limit) continue;
      return failure(
          FaultKind::timeout, place_,
          fmt::format("the answer to \"{}\" takes {:.2f} s, but its time limit is {:g} s and a run reads once a "
                      "second: measure fewer inputs, or shorten the measurement of each",
                      plain(question.ask), to_seconds(taken), to_seconds(limit)));
    }
    is_scan_measured_ = true;
    return {};
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
      auto reading =
          lower_bits(statuses[i])
              ? convert_reading(description_, question.first + i, numbers[i], static_cast<std::int64_t>(statuses[i]))
              : failure(FaultKind::corrupted, fmt::format("input {}", question.first + i + 1),
                        fmt::format("{:g} is not a status", statuses[i]));
      if (!reading) reading.error() = add_location(place_, std::move(reading.error()));
      readings.push_back(std::move(reading));
    }
    return std::nullopt;
  }

  Result<FieldValues> ask(const InputQuestion& question) { return ask(question, description_.within); }
  Result<FieldValues> ask(const InputQuestion& question, std::optional<Duration> within) {
    for (const auto& command : question.before)
      if (auto sent = instrument_.client().tell(command); !sent) return failure(std::move(sent.error()));
    auto answer = instrument_.client().ask(question.ask, question.answers, within);
    if (!answer) return failure(std::move(answer.error()));
    return std::move(answer->fields);
  }

  ThermometerDescription description_;
  std::string place_;
  /// The steady clock if null.
  const Clock* clock_;
  TextInstrument instrument_;
  bool is_scan_measured_ = false;
};

}  // namespace

std::unique_ptr<Thermometer> make_text_thermometer(ThermometerDescription description,
                                                   std::unique_ptr<ByteStream> stream, std::string place,
                                                   const Clock* clock) {
  return std::make_unique<TextThermometer>(std::move(description), std::move(stream), std::move(place), clock);
}

}  // namespace gyrotherm::drivers
