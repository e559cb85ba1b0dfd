#include "sequencer/watchdog/made_safe_file.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/clock.hpp"
#include "core/file.hpp"
#include "sequencer/watchdog/keyed_text.hpp"

namespace gyrotherm {
namespace {

std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

}  // namespace

std::string made_safe_path(const std::string& record) { return record + ".made-safe"; }

std::string to_text(const MadeSafe& trace) {
  return fmt::format("{}\nat: {}\nutc_ns: {}\nbecause: {}\nset_point_c: {}\nconfirmed: {}\ndetails: {}\n",
                     kMadeSafeSchema, civil_time(trace.at), trace.at.count(), one_line(trace.because),
                     trace.set_point.value, trace.confirmed ? "yes" : "no", one_line(trace.details));
}

Result<MadeSafe> parse_made_safe(std::string_view text, const std::string& file) {
  KeyedText keyed(text, file, kMadeSafeSchema);
  MadeSafe trace;
  static_cast<void>(keyed.text("at"));  // for people; the next line has it exactly
  trace.at = Duration(keyed.number<std::int64_t>("utc_ns"));
  trace.because = keyed.text("because");
  trace.set_point = {keyed.number<double>("set_point_c")};
  trace.confirmed = keyed.yes("confirmed");
  trace.details = keyed.text("details");
  if (auto verdict = keyed.verdict(); !verdict) return failure(std::move(verdict.error()));
  return trace;
}

Result<void> leave_trace(const std::string& record, const MadeSafe& trace) {
  return replace_own_file(made_safe_path(record), to_text(trace));
}

Result<std::optional<MadeSafe>> read_trace(const std::string& record) {
  const auto path = made_safe_path(record);
  const auto text = read_text_file_if_any(path, kLargestText, Links::refused);
  if (!text) return failure(text.error());
  if (!*text) return std::nullopt;
  auto trace = parse_made_safe(**text, path);
  if (!trace) return failure(std::move(trace.error()));
  return *trace;
}

std::string in_words(const MadeSafe& trace) {
  return fmt::format("{} by the guard at {} ({}): the chamber {} sent to {:g} °C; {}",
                     trace.confirmed ? "made safe" : "NOT made safe", civil_time(trace.at), trace.because,
                     trace.confirmed ? "was" : "could NOT be", trace.set_point.value, trace.details);
}

}  // namespace gyrotherm
