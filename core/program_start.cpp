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
#include <system_error>

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

std::string objection_to(std::string_view value, std::string_view kind) {
  const bool is_numeric = kind == "INT" || kind == "UINT" || kind == "FLOAT";
  if (is_numeric && !is_number(value, kind)) return fmt::format("\"{}\" is not an accepted number", value);
  return value.empty() ? "its value is empty" : "";
}

std::string command_refusal_reason(std::string_view word, std::span<const std::string> known) {
  if (word.starts_with('-') || std::ranges::find(known, word) != known.end()) return {};
  const auto near = find_nearest(word, known);
  return near.empty() ? fmt::format("\"{}\" is not one of the commands {}", word, fmt::join(known, ", "))
                      : fmt::format("\"{}\" is not a command. Did you mean \"{}\"?", word, near);
}

std::string option_refusal_reason(std::string_view word, const std::string& command,
                                  std::span<const std::string> known) {
  const auto near = find_nearest(word, known);
  return fmt::format("{} is not an option of {}{}", word, command,
                     near.empty() ? "" : fmt::format(". Did you mean {}?", near));
}

std::string plain_error_message(const std::string& refusal) {
  constexpr std::string_view kValue = ": Value ", kRange = " not in range ", kTo = " to ";
  const auto value = refusal.find(kValue), range = refusal.find(kRange);
  const auto to = range == std::string::npos ? range : refusal.find(kTo, range);
  // CLI11 prints the largest double with 309 digits.
  if (value != std::string::npos && to != std::string::npos &&
      refusal.size() - to > std::numeric_limits<double>::max_exponent10)
    return fmt::format("{}: {} is not a number above zero", refusal.substr(0, value),
                       refusal.substr(value + kValue.size(), range - value - kValue.size()));
  constexpr std::string_view kRefusalStart = "Could not convert: ", kValueSeparator = " = ";
  const auto is = refusal.find(kValueSeparator);
  if (!refusal.starts_with(kRefusalStart) || is == std::string::npos) return refusal;
  return fmt::format("{}: \"{}\" is not an accepted number",
                     refusal.substr(kRefusalStart.size(), is - kRefusalStart.size()),
                     refusal.substr(is + kValueSeparator.size()));
}

}  // namespace gyrotherm
