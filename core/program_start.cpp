// SPDX-License-Identifier: Apache-2.0
#include "core/program_start.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <ranges>
#include <string>
#include <system_error>
#include <vector>

#include "core/text.hpp"

namespace gyrotherm {
namespace {

template <class Number>
bool can_parse(std::string_view text, Number& number) {
  const char* end = text.data() + text.size();
  const auto [behind, error] = std::from_chars(text.data(), end, number);
  return error == std::errc() && behind == end;
}

bool is_number(std::string_view text, std::string_view kind) {
  if (std::int64_t whole = 0; kind == "INT") return can_parse(text, whole);
  if (std::uint64_t natural = 0; kind == "UINT") return can_parse(text, natural);
  double number = 0;
  return can_parse(text, number) && std::isfinite(number);
}

/// Returns the reason for refusing a text that is not a number, with the number to write if it has a decimal comma.
std::string number_refusal_reason(std::string_view text) {
  std::string with_point(text);
  if (std::ranges::count(text, ',') == 1) std::ranges::replace(with_point, ',', '.');
  const bool has_comma = with_point != text && is_number(with_point, "FLOAT");
  return fmt::format("\"{}\" is not an accepted number{}", text,
                     has_comma ? fmt::format("; it has a decimal comma, write {}", with_point) : "");
}

}  // namespace

void open_standard_descriptors() {
  for (const int number : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(number, F_GETFD) >= 0) continue;
    const int opened = ::open("/dev/null", number == STDERR_FILENO ? O_WRONLY : O_RDONLY);  // lowest free number
    if (opened != number) ::close(opened);
  }
}

void write_to_stderr(std::string_view text) { std::fwrite(text.data(), 1, text.size(), stderr); }

Result<void> write_to_stdout(std::string_view text) {
  const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0;
  if (written || is_stdout_closed()) return {};
  return failure(FaultKind::storage, "stdout", "cannot be written");
}

bool is_stdout_closed() {
  pollfd out{STDOUT_FILENO, POLLOUT, 0};
  return ::poll(&out, 1, 0) == 1 && (out.revents & POLLERR) != 0;
}

std::string value_refusal_reason(std::string_view value, std::string_view kind) {
  const bool is_numeric = kind == "INT" || kind == "UINT" || kind == "FLOAT";
  if (is_numeric && !is_number(value, kind)) return number_refusal_reason(value);
  return value.empty() ? "its value is empty" : "";
}

std::string command_refusal_reason(std::string_view word, std::span<const std::string> known) {
  if (word.starts_with('-') || std::ranges::find(known, word) != known.end()) return {};
  const auto near = find_nearest(word, known);
  return near.empty() ? fmt::format("\"{}\" is not one of the commands {}", word, fmt::join(known, ", "))
                      : fmt::format("\"{}\" is not a command. Did you mean \"{}\"?", word, near);
}

namespace {

std::string without_dashes(std::string_view option) {
  return std::string(option.substr(std::min(option.find_first_not_of('-'), option.size())));
}

/// Returns the option with the nearest name; the dashes before the names are not compared.
std::string find_nearest_option(std::string_view word, std::span<const std::string> known) {
  std::vector<std::string> names;
  for (const auto& option : known) names.push_back(without_dashes(option));
  const auto near = std::ranges::find(names, find_nearest(without_dashes(word), names));
  return near == names.end() || near->empty() ? "" : known[static_cast<std::size_t>(near - names.begin())];
}

}  // namespace

std::string option_refusal_reason(std::string_view word, const std::string& command,
                                  std::span<const std::string> known) {
  const auto near = find_nearest_option(word, known);
  return fmt::format("{} is not an option of {}{}", word, command,
                     near.empty() ? "" : fmt::format(". Did you mean {}?", near));
}

std::string misplaced_option_reason(std::string_view word, const std::string& command) {
  return fmt::format("{0} is an option of {1}, expected it after {1}", word, command);
}

std::string misspelt_command_reason(std::string_view word, const std::string& command,
                                    std::span<const std::string> known) {
  if (word.starts_with('-') || std::ranges::find(known, word) != known.end()) return {};
  const auto near = find_nearest(word, known);
  if (near.empty() || ::access(std::string(word).c_str(), F_OK) == 0) return {};
  return fmt::format("\"{}\" is not a command of {}. Did you mean \"{}\"?", word, command, near);
}

std::string extra_word_refusal_reason(std::string_view word, const std::string& form) {
  return fmt::format("\"{}\" is not expected here; the form is: {} [options]", word, form);
}

namespace {

/// Rewrites "--as: C not in {libsvm,c}", CLI11's message for a value that is not one of a list. Returns an empty string
/// for any other message.
std::string explain_choice(const std::string& refusal) {
  constexpr std::string_view kName = ": ", kList = " not in {";
  const auto name = refusal.find(kName), list = refusal.rfind(kList);
  if (name == std::string::npos || list == std::string::npos || list < name + kName.size() || !refusal.ends_with('}'))
    return {};
  std::vector<std::string> known;
  const auto begins = list + kList.size();
  for (const auto each : std::views::split(std::string_view(refusal).substr(begins, refusal.size() - 1 - begins), ','))
    known.emplace_back(each.begin(), each.end());
  const auto value = refusal.substr(name + kName.size(), list - name - kName.size());
  const auto near = find_nearest(value, known);
  return fmt::format("{}: \"{}\" is not one of {}{}", refusal.substr(0, name), value, fmt::join(known, ", "),
                     near.empty() ? "" : fmt::format("; did you mean \"{}\"?", near));
}

/// Rewrites "--guard: Value 0 not in range 1.000000 to 3600.000000", CLI11's message for a number that is too small or
/// too large. Returns an empty string for any other message.
std::string explain_range(const std::string& refusal) {
  constexpr std::string_view kValue = ": Value ", kRange = " not in range ", kTo = " to ";
  const auto value = refusal.find(kValue), range = refusal.rfind(kRange);
  const auto to = range == std::string::npos ? range : refusal.find(kTo, range);
  if (value == std::string::npos || to == std::string::npos || range < value + kValue.size()) return {};
  const auto name = refusal.substr(0, value);
  const auto number = refusal.substr(value + kValue.size(), range - value - kValue.size());
  if (!is_number(number, "FLOAT")) return fmt::format("{}: {}", name, number_refusal_reason(number));
  // CLI11 prints the largest double with 309 digits.
  if (refusal.size() - to > std::numeric_limits<double>::max_exponent10)
    return fmt::format("{}: {} is not a number above zero", name, number);
  double least = 0, most = 0;
  if (!can_parse(refusal.substr(range + kRange.size(), to - range - kRange.size()), least)) return {};
  if (!can_parse(refusal.substr(to + kTo.size()), most)) return {};
  if (double given = 0; can_parse(number, given) && given >= least && given <= most)
    return fmt::format("{}: {} is not a whole number", name, number);
  return fmt::format("{}: {} is outside {:g} to {:g}", name, number, least, most);
}

}  // namespace

std::string plain_error_message(const std::string& refusal) {
  constexpr std::string_view kTooMany = ": At Most 1 required but received ";
  if (const auto at = refusal.find(kTooMany); at != std::string::npos)
    return fmt::format("{} is given {} times, expected once", refusal.substr(0, at),
                       refusal.substr(at + kTooMany.size()));
  constexpr std::string_view kOneRequired = ": 1 required ";
  if (const auto at = refusal.find(kOneRequired); at != std::string::npos && refusal.ends_with(" missing"))
    return refusal.substr(0, at) + ": its value is missing";
  if (auto choice = explain_choice(refusal); !choice.empty()) return choice;
  if (auto range = explain_range(refusal); !range.empty()) return range;
  constexpr std::string_view kRefusalStart = "Could not convert: ", kValueSeparator = " = ";
  const auto is = refusal.find(kValueSeparator);
  if (!refusal.starts_with(kRefusalStart) || is == std::string::npos) return refusal;
  return fmt::format("{}: {}", refusal.substr(kRefusalStart.size(), is - kRefusalStart.size()),
                     number_refusal_reason(refusal.substr(is + kValueSeparator.size())));
}

}  // namespace gyrotherm
