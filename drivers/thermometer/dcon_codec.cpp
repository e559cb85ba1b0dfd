// SPDX-License-Identifier: Apache-2.0
#include "drivers/thermometer/dcon_codec.hpp"

#include <fmt/format.h>

#include <cassert>
#include <charconv>
#include <utility>

#include "drivers/checksum.hpp"

namespace gyrotherm::drivers {

namespace {

constexpr std::string_view kOverRange = "+9999";
constexpr std::string_view kUnderRange = "-0000";  // as a number it would be a plain zero
constexpr std::size_t kLongestValue = 8;
constexpr std::size_t kSumDigits = 2;

std::string sum_of(std::string_view text) { return fmt::format("{:02X}", sum8(std::as_bytes(std::span(text)))); }

std::optional<std::uint8_t> parse_hex(std::string_view text) {
  if (text.size() != 2 || text.find_first_not_of("0123456789ABCDEF") != std::string_view::npos) return std::nullopt;
  std::uint8_t value{};
  std::from_chars(text.data(), text.data() + text.size(), value, 16);
  return value;
}

std::string address_text(char lead, std::uint8_t address) { return fmt::format("{}{:02X}", lead, address); }

tl::unexpected<Fault> corrupted(std::string_view line, std::string_view expected) {
  return failure(FaultKind::corrupted, "", fmt::format("\"{}\" is not {}", line, expected));
}

/// A sign, digits and one point among them.
std::optional<double> parse_dcon_reading(std::string_view text) {
  if (text.find('.') == std::string_view::npos || text.find_first_not_of("0123456789.", 1) != std::string_view::npos)
    return std::nullopt;
  const auto digits = text.substr(1);
  double value{};
  const auto [end, error] =
      std::from_chars(digits.data(), digits.data() + digits.size(), value, std::chars_format::fixed);
  if (error != std::errc{} || end != digits.data() + digits.size()) return std::nullopt;
  return text[0] == '-' ? -value : value;
}

/// Cut before each sign; empty if there is anything before the first.
std::vector<std::string_view> split_at_signs(std::string_view text) {
  std::vector<std::string_view> values;
  if (text.find_first_of("+-") != 0) return values;
  while (!text.empty()) {
    const auto end = std::min(text.find_first_of("+-", 1), text.size());
    values.push_back(text.substr(0, end));
    text.remove_prefix(end);
  }
  return values;
}

}  // namespace

std::string seal_dcon(std::string text, DconChecksum checksum) {
  return checksum == DconChecksum::on ? text + sum_of(text) : text;
}

Result<std::string_view> unseal_dcon(std::string_view line, DconChecksum checksum) {
  if (checksum == DconChecksum::off) return line;
  if (line.size() < kSumDigits) return corrupted(line, "an answer with a checksum");
  const auto text = line.substr(0, line.size() - kSumDigits);
  const auto sum = sum_of(text);
  if (line.substr(text.size()) != sum)
    return failure(FaultKind::corrupted, "",
                   fmt::format("\"{}\" has the checksum {}, expected {}", text, line.substr(text.size()), sum));
  return text;
}

std::string dcon_read_all(std::uint8_t address) { return address_text('#', address); }

std::string dcon_ask(std::uint8_t address, std::string_view what) { return address_text('$', address).append(what); }

Result<std::string_view> decode_dcon_answer(std::string_view line, std::uint8_t address) {
  if (line == address_text('?', address)) return failure(FaultKind::refused, "", "the module refuses the command");
  const auto lead = address_text('!', address);
  if (!line.starts_with(lead)) return corrupted(line, fmt::format("an answer of module {:02X}", address));
  return line.substr(lead.size());
}

Result<DconConfiguration> decode_dcon_configuration(std::string_view text) {
  const auto wrong = [&] { return corrupted(text, "a configuration TTCCFF"); };
  if (text.size() != 6) return wrong();
  const auto type = parse_hex(text.substr(0, 2)), baud = parse_hex(text.substr(2, 2)),
             format = parse_hex(text.substr(4));
  if (!type || !baud || !format) return wrong();
  return DconConfiguration{*type, *baud, *format};
}

std::string encode_dcon_configuration(const DconConfiguration& configuration) {
  return fmt::format("{:02X}{:02X}{:02X}", configuration.type, configuration.baud, configuration.format);
}

Result<std::uint8_t> decode_dcon_type(std::string_view text, int input) {
  const auto lead = fmt::format("C{}R", input);
  const auto type = text.starts_with(lead) ? parse_hex(text.substr(lead.size())) : std::nullopt;
  if (!type) return corrupted(text, fmt::format("the type of input {}", input));
  return *type;
}

std::optional<TemperatureRange> dcon_range(std::uint8_t type) {
  switch (type) {
    case 0x0E: return TemperatureRange{{0}, {760}};
    case 0x0F: return TemperatureRange{{0}, {1370}};
    case 0x10: return TemperatureRange{{-100}, {400}};
    case 0x11: return TemperatureRange{{0}, {1000}};
    default: return std::nullopt;
  }
}

Result<std::vector<Result<Celsius>>> decode_dcon_readings(std::string_view line, std::uint8_t address,
                                                          std::span<const TemperatureRange> ranges) {
  if (line.starts_with('?')) {
    // Either the module's own refusal or another's; neither holds readings.
    auto refusal = decode_dcon_answer(line, address);
    return failure(std::move(refusal.error()));
  }
  const auto wrong = [&] { return corrupted(line, fmt::format("{} readings", ranges.size())); };
  if (!line.starts_with('>')) return wrong();
  const auto values = split_at_signs(line.substr(1));
  if (values.size() != ranges.size()) return wrong();

  std::vector<Result<Celsius>> readings;
  readings.reserve(ranges.size());
  std::size_t width = 0;
  for (const auto text : values) {
    const auto place = fmt::format("input {}", readings.size());
    if (text == kOverRange || text == kUnderRange) {
      const auto* what = text == kOverRange ? "over range" : "under range";
      readings.push_back(failure(FaultKind::out_of_range, place, fmt::format("{} ({})", what, text)));
      continue;
    }
    const auto value = parse_dcon_reading(text);
    if (!value || text.size() > kLongestValue || (width != 0 && text.size() != width)) return wrong();
    width = text.size();
    readings.push_back(within(ranges[readings.size()], {*value}, place));
  }
  return readings;
}

std::string encode_dcon_readings(std::span<const double> celsius, const TemperatureRange& range, int decimals) {
  std::string line = ">";
  for (const double reading : celsius) {
    if (reading >= range.lowest.value && reading <= range.highest.value)
      line += fmt::format("{:+07.{}f}", reading, decimals);
    else
      line += reading < range.lowest.value ? kUnderRange : kOverRange;
  }
  return line;
}

}  // namespace gyrotherm::drivers
