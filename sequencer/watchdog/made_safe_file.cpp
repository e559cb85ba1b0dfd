#include "sequencer/watchdog/made_safe_file.hpp"

#include <fmt/format.h>

#include "core/clock.hpp"
#include "core/file.hpp"
#include "core/text.hpp"
#include "core/toml_reader.hpp"
#include "core/toml_text.hpp"

namespace gyrotherm {
namespace {

/// Instruments and files may say anything.
std::string quoted(const std::string& text) { return toml_quoted(plain(text, Blanks::kept)); }

}  // namespace

std::string made_safe_path(const std::string& record) { return record + ".made-safe"; }

std::string to_text(const MadeSafe& trace) {
  return fmt::format(
      "schema = \"{}\"\nat = \"{}\"\nutc_ns = {}\nbecause = {}\nset_point_c = {}\nconfirmed = {}\n"
      "details = {}\n",
      kMadeSafeSchema, civil_time(trace.at), trace.at.count(), quoted(trace.because), trace.set_point.value,
      trace.confirmed, quoted(trace.details));
}

Result<MadeSafe> parse_made_safe(std::string_view text, const std::string& file) {
  const auto table = TomlTable::parse(text, file);
  if (!table) return failure(table.error());
  table->expect("schema", kMadeSafeSchema);
  table->ignore("at");  // for people; the next line has it exactly
  MadeSafe trace{.at = Duration(table->integer("utc_ns")),
                 .because = table->text("because"),
                 .set_point = {table->number("set_point_c")},
                 .confirmed = table->boolean("confirmed"),
                 .details = table->text("details")};
  if (auto verdict = table->verdict(); !verdict) return failure(std::move(verdict.error()));
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
