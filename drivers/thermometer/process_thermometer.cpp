// SPDX-License-Identifier: Apache-2.0
#include "drivers/thermometer/process_thermometer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <utility>

#include "core/deadline.hpp"
#include "core/text.hpp"
#include "drivers/thermometer/placed_readings.hpp"

namespace gyrotherm::drivers {
namespace {

constexpr TemperatureRange kPossibleRange{{-273.15}, {3000}};
constexpr std::size_t kMaxAnswer = std::size_t{64} * 1024;  ///< bytes per answer
constexpr int kMostFailures = 10;
constexpr std::string_view kNoReading = "-";

template <class Number>
std::optional<Number> parse_whole_number(std::string_view text) {
  Number number{};
  const auto* const last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), last, number);
  return error == std::errc{} && end == last ? std::optional(number) : std::nullopt;
}

/// Removes the first token and the blank after it from `text`, and returns the token.
std::string_view take_token(std::string_view& text) {
  const auto blank = text.find(' ');
  const auto token = text.substr(0, blank);
  text = blank == std::string_view::npos ? std::string_view() : text.substr(blank + 1);
  return token;
}

std::string shorten(std::string_view text) {
  constexpr std::size_t kMaxShownBytes = 60;
  return plain(text.substr(0, kMaxShownBytes)) + (text.size() > kMaxShownBytes ? "…" : "");
}

std::optional<double> parse_decimal(std::string_view token) {
  if (token.empty() || token.find_first_not_of("0123456789.eE+-") != std::string_view::npos) return std::nullopt;
  if (token.front() == '+') {
    token.remove_prefix(1);
    if (token.starts_with('-')) return std::nullopt;
  }
  double value{};
  const auto* const last = token.data() + token.size();
  const auto [end, error] = std::from_chars(token.data(), last, value);
  return error == std::errc{} && end == last ? std::optional(value) : std::nullopt;
}

}  // namespace

std::optional<NumberedLine> split_numbered_line(std::string_view line) {
  if (line.ends_with('\r')) line.remove_suffix(1);
  const auto number = parse_whole_number<std::uint64_t>(take_token(line));
  return number ? std::optional(NumberedLine{*number, line}) : std::nullopt;
}

Result<ProcessGreeting> decode_process_greeting(std::string_view text) {
  const auto protocol = take_token(text);
  if (protocol != kProcessProtocol)
    return failure(FaultKind::mismatch, "hello",
                   fmt::format("received \"{}\", expected {}", shorten(protocol), kProcessProtocol));
  const auto inputs = parse_whole_number<std::size_t>(take_token(text));
  if (!inputs || *inputs < 1 || *inputs > kMostProcessInputs || trimmed(text).empty())
    return failure(FaultKind::corrupted, "hello",
                   fmt::format("expected {} INPUTS NAME, with 1 to {} inputs", kProcessProtocol, kMostProcessInputs));
  return ProcessGreeting{*inputs, plain(trimmed(text))};
}

std::string encode_process_greeting(const ProcessGreeting& greeting) {
  return fmt::format("{} {} {}", kProcessProtocol, greeting.inputs, greeting.identity);
}

Result<std::vector<Result<Celsius>>> decode_process_readings(std::string_view text, std::size_t inputs) {
  const auto whole = text;
  const auto not_readings = [&] {
    return failure(FaultKind::corrupted, "read", fmt::format("\"{}\" is not {} readings", shorten(whole), inputs));
  };
  std::vector<Result<Celsius>> readings;
  while (!text.empty()) {
    const auto token = take_token(text);
    const auto place = fmt::format("input {}", readings.size() + 1);
    const auto value = parse_decimal(token);
    if (readings.size() == inputs || (!value && token != kNoReading)) return not_readings();
    readings.push_back(value ? check_range(kPossibleRange, {*value}, place)
                             : failure(FaultKind::out_of_range, place, "the program reports no reading"));
  }
  if (readings.size() != inputs || whole.ends_with(' ')) return not_readings();
  return readings;
}

std::string encode_process_readings(std::span<const std::optional<double>> celsius) {
  std::string text;
  for (const auto& reading : celsius) {
    if (!text.empty()) text += ' ';
    text += reading ? fmt::format("{:.6f}", *reading) : std::string(kNoReading);
  }
  return text;
}

namespace {

class ProcessThermometer final : public Thermometer {
 public:
  ProcessThermometer(std::unique_ptr<ByteStream> line, std::string place, ProcessThermometerOptions options)
      : line_(std::move(line)), place_(std::move(place)), options_(std::move(options)) {}

  Result<std::string> identify() override {
    greeting_.reset();
    auto greeted = greet(Deadline(options_.greeting_timeout, options_.clock));
    if (!greeted) return failure(add_location(place_, std::move(greeted.error())));
    return greeting_->identity;
  }

  std::uint64_t breaks() const override { return breaks_; }

  std::vector<Result<Celsius>> read() override {
    auto readings = query_readings(Deadline(options_.within, options_.clock));
    failures_ = readings ? 0 : failures_ + 1;
    if (failures_ >= kMostFailures && options_.end_program) {
      options_.end_program();
      reset_connection();
      failures_ = 0;
    }
    return add_locations(place_, options_.channels, std::move(readings));
  }

 private:
  Result<std::vector<Result<Celsius>>> query_readings(const Deadline& deadline) {
    if (!greeting_)
      if (auto greeted = greet(deadline); !greeted) return failure(std::move(greeted.error()));
    const auto answer = query("read", deadline);
    if (!answer) return failure(answer.error());
    auto readings = decode_process_readings(*answer, greeting_->inputs);
    if (readings) readings->erase(readings->begin() + static_cast<std::ptrdiff_t>(options_.channels), readings->end());
    return readings;
  }

  Result<void> greet(const Deadline& deadline) {
    const auto answer = query("hello", deadline);
    if (!answer) return failure(answer.error());
    auto greeting = decode_process_greeting(*answer);
    if (!greeting) return failure(std::move(greeting.error()));
    if (greeting->inputs < options_.channels)
      return failure(FaultKind::mismatch, "hello",
                     fmt::format("the program has {} inputs, but the rig file names {} channels", greeting->inputs,
                                 options_.channels));
    greeting_ = std::move(*greeting);
    return {};
  }

  Result<std::string> query(std::string_view token, const Deadline& deadline) {
    const auto question = fmt::format("{} {}\n", ++number_, token);
    if (auto sent = line_->write(std::as_bytes(std::span(question)), deadline.left()); !sent)
      return note_broken_line(std::move(sent.error()));
    std::size_t received = 0;
    while (true) {
      if (auto answer = take_answer(); !answer || *answer)
        return answer.map([](std::optional<std::string> found) { return std::move(*found); });
      if (received > kMaxAnswer)
        return failure(FaultKind::corrupted, std::string(token), "more than 64 KiB in answer to one request");
      std::array<std::byte, 4096> some{};
      const auto size = line_->read(some, deadline.left());
      if (!size) return note_broken_line(size.error());
      received += *size;
      text_.append(reinterpret_cast<const char*>(some.data()), *size);
    }
  }

  /// Removes complete lines from the received text until one answers the latest request. Discards answers to earlier
  /// requests. Fails if a line is not an answer, and returns nothing if the answer is incomplete.
  Result<std::optional<std::string>> take_answer() {
    for (auto end = text_.find('\n'); end != std::string::npos; end = text_.find('\n')) {
      const auto line = text_.substr(0, end);
      text_.erase(0, end + 1);
      const auto numbered = split_numbered_line(line);
      if (!numbered || numbered->number > number_ || line.size() > kLongestProcessLine) {
        text_.clear();
        return failure(FaultKind::corrupted, "", fmt::format("\"{}\" is not an answer to a request", shorten(line)));
      }
      if (numbered->number == number_) return std::string(numbered->rest);
    }
    if (text_.size() <= kLongestProcessLine) return std::nullopt;
    text_.clear();
    return failure(FaultKind::corrupted, "", fmt::format("no end of line in {} bytes", kLongestProcessLine));
  }

  tl::unexpected<Fault> note_broken_line(Fault fault) {
    if (fault.kind == FaultKind::disconnected) reset_connection();
    return failure(std::move(fault));
  }
  void reset_connection() {
    ++breaks_;
    greeting_.reset();
    text_.clear();
  }

  std::unique_ptr<ByteStream> line_;
  std::string place_;
  ProcessThermometerOptions options_;
  std::optional<ProcessGreeting> greeting_;
  std::uint64_t number_{};  ///< latest request
  /// Received text that is not a complete line.
  std::string text_;
  int failures_{};  ///< consecutive
  std::uint64_t breaks_{};
};

}  // namespace

std::unique_ptr<Thermometer> make_process_thermometer(std::unique_ptr<ByteStream> line, std::string place,
                                                      ProcessThermometerOptions options) {
  return std::make_unique<ProcessThermometer>(std::move(line), std::move(place), std::move(options));
}

}  // namespace gyrotherm::drivers
