// SPDX-License-Identifier: Apache-2.0
#include "drivers/thermometer/pt12.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <utility>

#include "core/text.hpp"
#include "drivers/line/text_exchange.hpp"
#include "drivers/thermometer/placed_readings.hpp"

namespace gyrotherm::drivers {
namespace {

constexpr TemperatureRange kPlatinumRange{{-200}, {850}};

bool is_nan(std::string_view text) {
  const auto is_equal_letter = [](char a, char b) { return (a | 0x20) == b; };
  return std::ranges::equal(text, std::string_view("nan"), is_equal_letter);
}

/// Parses one number in standard or scientific notation, or NaN. Returns nothing for any other text.
std::optional<double> parse_number(std::string_view text) {
  if (is_nan(text)) return std::numeric_limits<double>::quiet_NaN();
  const bool negative = text.starts_with('-');
  if (negative || text.starts_with('+')) text.remove_prefix(1);
  if (text.empty() || text[0] == '-' || text.find_first_not_of("0123456789.eE+-") != std::string_view::npos)
    return std::nullopt;
  double value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return negative ? -value : value;
}

std::vector<std::string_view> split_at_commas(std::string_view line) {
  std::vector<std::string_view> items;
  for (auto rest = line;;) {
    const auto comma = rest.find(',');
    items.push_back(trimmed(rest.substr(0, comma), " "));
    if (comma == std::string_view::npos) return items;
    rest.remove_prefix(comma + 1);
  }
}

Result<Celsius> to_celsius(double value, std::size_t input) {
  const auto place = fmt::format("T{}", input);
  if (std::isnan(value)) return failure(FaultKind::out_of_range, place, "no probe is connected (NaN)");
  return check_range(kPlatinumRange, {value}, place);
}

}  // namespace

Result<std::vector<Result<Celsius>>> decode_pt12_temperatures(std::string_view line) {
  const auto items = split_at_commas(line);
  const auto not_readings = [&] {
    return failure(FaultKind::corrupted, "T?", fmt::format("\"{}\" is not {} readings", line, kPt12Inputs));
  };
  if (items.size() != kPt12Inputs) return not_readings();
  std::vector<Result<Celsius>> readings;
  readings.reserve(kPt12Inputs);
  for (const auto item : items) {
    const auto value = parse_number(item);
    if (!value) return not_readings();
    readings.push_back(to_celsius(*value, readings.size() + 1));
  }
  return readings;
}

std::string encode_pt12_temperatures(std::span<const std::optional<double>> celsius) {
  std::string line;
  for (const auto& reading : celsius) {
    if (!line.empty()) line += ", ";
    line += reading ? fmt::format("{:.5f}", *reading) : "NaN";
  }
  return line;
}

namespace {

constexpr std::string_view kPt12 = "PT12";
const ResyncQuery kPt12Resync{.question = "ID?", .answer_begins = "PT12"};

class Pt12 final : public Thermometer {
 public:
  Pt12(std::unique_ptr<ByteStream> line, std::string place, Pt12Timing timing)
      : exchange_(std::move(line), {.question_end = "\r",
                                    .answer_end = "\r\n",
                                    .within = timing.within,
                                    .pause = timing.pause,
                                    .is_only_instrument = true,
                                    .clock = timing.clock}),
        place_(std::move(place)) {}

  Result<std::string> identify() override {
    auto identity = exchange_.query(kPt12Resync.question, kPt12Resync);
    if (!identity) return failure(add_location(place_, std::move(identity.error())));
    if (*identity != kPt12)
      return failure(add_location(
          place_, {FaultKind::mismatch, "ID?", fmt::format("received \"{}\", expected {}", *identity, kPt12)}));
    auto serial = exchange_.query("SN?", kPt12Resync);
    if (!serial) return failure(add_location(place_, std::move(serial.error())));
    return fmt::format("{} {}", kPt12, *serial);
  }

  std::vector<Result<Celsius>> read() override {
    return add_locations(place_, kPt12Inputs, exchange_.query("T?", kPt12Resync).and_then([](const auto& line) {
      return decode_pt12_temperatures(line);
    }));
  }

 private:
  TextExchange exchange_;
  std::string place_;
};

}  // namespace

std::unique_ptr<Thermometer> make_pt12(std::unique_ptr<ByteStream> line, std::string place, Pt12Timing timing) {
  return std::make_unique<Pt12>(std::move(line), std::move(place), timing);
}

}  // namespace gyrotherm::drivers
