#include "acquisition/record/calibration.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <charconv>
#include <numeric>

namespace gyrotherm {
namespace {

using std::chrono::sys_days;

/// All of `text` as a number without a sign.
std::optional<unsigned> digits(std::string_view text) {
  unsigned value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

std::string correction_in_words(const Channel& channel) {
  if (!channel.polynomial.empty()) return fmt::format("polynomial {}", fmt::join(channel.polynomial, ", "));
  return channel.offset == Kelvins{} ? "" : fmt::format("offset {:g} K", channel.offset.value);
}

}  // namespace

Celsius calibrated(const Channel& channel, Celsius reading) {
  if (channel.polynomial.empty()) return reading + channel.offset;
  return {std::accumulate(channel.polynomial.rbegin(), channel.polynomial.rend(), 0.0,
                          [&](double sum, double coefficient) { return sum * reading.value + coefficient; })};
}

std::optional<sys_days> parse_day(std::string_view text) {
  if (text.size() != 10 || text[4] != '-' || text[7] != '-') return std::nullopt;
  const auto year = digits(text.substr(0, 4)), month = digits(text.substr(5, 2)), day = digits(text.substr(8));
  if (!year || !month || !day) return std::nullopt;
  const std::chrono::year_month_day date{std::chrono::year(static_cast<int>(*year)), std::chrono::month(*month),
                                         std::chrono::day(*day)};
  return date.ok() ? std::optional<sys_days>(date) : std::nullopt;
}

std::string day_text(sys_days day) { return fmt::format("{:%F}", day); }

std::string calibration_in_words(const Channel& channel) {
  auto words = correction_in_words(channel);
  const auto add = [&](const std::string& more) { words += (words.empty() ? "" : ", ") + more; };
  if (!channel.certificate.empty()) add("certificate " + channel.certificate);
  if (channel.due) add("due " + day_text(*channel.due));
  return words.empty() ? "none" : words;
}

std::vector<std::string> overdue_calibrations(std::span<const Channel> channels, Duration utc) {
  std::vector<std::string> lines;
  for (const auto& channel : channels) {
    if (!channel.due || utc < Duration(channel.due->time_since_epoch()) + std::chrono::days(1)) continue;
    const auto certificate = channel.certificate.empty() ? "" : fmt::format(" (certificate {})", channel.certificate);
    lines.push_back(fmt::format("calibration of {}{} was due {}", channel.name, certificate, day_text(*channel.due)));
  }
  return lines;
}

}  // namespace gyrotherm
