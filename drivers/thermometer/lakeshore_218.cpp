// SPDX-License-Identifier: Apache-2.0
#include "drivers/thermometer/lakeshore_218.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "drivers/line/text_exchange.hpp"
#include "drivers/thermometer/placed_readings.hpp"

namespace gyrotherm::drivers {
namespace {

constexpr Celsius kAbsoluteZero{-273.15};
constexpr Celsius kMaxTemperature{1000};  ///< above every supported sensor

/// Returns the reading, or a fault if it is impossible. An input without a working sensor reads 0 K.
Result<Celsius> check_plausible(Celsius reading, std::size_t input) {
  if (reading > kAbsoluteZero && reading <= kMaxTemperature) return reading;
  return failure(FaultKind::out_of_range, fmt::format("input {}", input),
                 fmt::format("{} °C is an impossible reading", reading.value));
}

/// Appends a reading, formatted as by "{:+08.3f}" for three decimals. Uses integers, which are faster: a virtual run
/// formats millions of readings.
void append_reading(std::string& line, double reading, int decimals) {
  constexpr double kMaxReading = 999;
  constexpr int kMaxDecimals = 6;
  if (!(std::abs(reading) < kMaxReading) || decimals < 1 || decimals > kMaxDecimals) {
    line += fmt::format("{:+0{}.{}f}", reading, decimals + 5, decimals);
    return;
  }
  auto rest = static_cast<std::int64_t>(std::nearbyint(std::abs(reading) * std::pow(10, decimals)));
  std::array<char, 12> digits;
  const auto size = static_cast<std::size_t>(decimals) + 5;
  for (std::size_t i = size - 1; i > 0; --i) {
    if (i == 4) {
      digits[i] = '.';
      continue;
    }
    digits[i] = static_cast<char>('0' + rest % 10);
    rest /= 10;
  }
  digits[0] = std::signbit(reading) ? '-' : '+';
  line.append(digits.data(), size);
}

}  // namespace

Result<std::vector<Result<Celsius>>> decode_crdg(std::string_view line) {
  const auto not_readings = [&] {
    return failure(FaultKind::corrupted, "CRDG?", fmt::format("\"{}\" is not {} readings", line, kLakeshore218Inputs));
  };
  std::vector<Result<Celsius>> readings;
  readings.reserve(kLakeshore218Inputs);
  for (auto rest = line; readings.size() < kLakeshore218Inputs;) {
    const auto comma = rest.find(',');
    const auto value = parse_signed_decimal(rest.substr(0, comma));
    if (!value) return not_readings();
    readings.push_back(check_plausible({*value}, readings.size() + 1));
    const bool last = readings.size() == kLakeshore218Inputs;
    if (last != (comma == std::string_view::npos)) return not_readings();
    if (!last) rest.remove_prefix(comma + 1);
  }
  return readings;
}

std::string encode_crdg(std::span<const double> celsius, int decimals) {
  std::string line;
  for (const double reading : celsius) {
    if (!line.empty()) line += ',';
    append_reading(line, reading, decimals);
  }
  return line;
}

namespace {

constexpr const char* kTerminator = "\r\n";
constexpr std::string_view kIdentity = "LSCI,MODEL218";
const ResyncQuery kResync{.question = "*IDN?", .answer_begins = "LSCI,"};

class Lakeshore218 final : public Thermometer {
 public:
  Lakeshore218(std::unique_ptr<ByteStream> line, std::string place, Lakeshore218Timing timing)
      : exchange_(std::move(line), {.question_end = kTerminator,
                                    .answer_end = kTerminator,
                                    .within = timing.within,
                                    .pause = timing.pause,
                                    .is_only_instrument = true,
                                    .clock = timing.clock}),
        place_(std::move(place)) {}

  Result<std::string> identify() override {
    auto identity = exchange_.query(kResync.question, kResync);
    if (!identity) return failure(add_location(place_, std::move(identity.error())));
    if (!identity->starts_with(kIdentity))
      return failure(add_location(
          place_, {FaultKind::mismatch, "*IDN?", fmt::format("received \"{}\", expected {}…", *identity, kIdentity)}));
    resync_.answer_begins = *identity;
    return identity;
  }

  std::vector<Result<Celsius>> read() override {
    return add_locations(
        place_, kLakeshore218Inputs,
        exchange_.query("CRDG? 0", resync_).and_then([](const auto& line) { return decode_crdg(line); }));
  }

 private:
  TextExchange exchange_;
  std::string place_;
  /// After a lost answer, only the instrument that was identified last is accepted.
  ResyncQuery resync_ = kResync;
};

}  // namespace

std::unique_ptr<Thermometer> make_lakeshore_218(std::unique_ptr<ByteStream> line, std::string place,
                                                Lakeshore218Timing timing) {
  return std::make_unique<Lakeshore218>(std::move(line), std::move(place), timing);
}

}  // namespace gyrotherm::drivers
