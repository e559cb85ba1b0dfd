// SPDX-License-Identifier: Apache-2.0
#include "sequencer/watchdog/safe_state_file.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <system_error>

#include "core/clock.hpp"
#include "core/file.hpp"
#include "core/process.hpp"
#include "core/text.hpp"
#include "core/toml_reader.hpp"
#include "core/toml_text.hpp"

namespace gyrotherm::watchdog {

namespace {

constexpr const char* kFromMap = "of the map";

const char* to_string(const std::optional<drivers::WordOrder>& order) {
  const auto found = std::find_if(drivers::kWordOrders.begin(), drivers::kWordOrders.end(),
                                  [&](const auto& w) { return w.second == order; });
  return found == drivers::kWordOrders.end() ? kFromMap : found->first;
}

std::optional<drivers::WordOrder> read_order(const TomlTable& table) {
  if (table.text("word_order") == kFromMap) return std::nullopt;
  return one_of(drivers::kWordOrders, table, "word_order");
}

ProcessIdentity read_identity(const TomlTable& table) {
  const auto pid = table.integer("pid"), started = table.integer("started");
  if (pid <= 0) table.note_error("pid", "expected a process id above 0");
  if (started < 0) table.note_error("started", "expected a start time of 0 or more");
  return {.pid = pid, .started = static_cast<std::uint64_t>(started), .boot = table.text("boot")};
}

/// Writes a text as a list of its lines, because a map is longer than the longest quoted text of a file.
std::string quoted_lines(std::string_view text) {
  std::string lines;
  for (std::size_t end; (end = text.find('\n')) != std::string_view::npos; text.remove_prefix(end + 1))
    lines += fmt::format("  {},\n", toml_quoted(text.substr(0, end)));
  return lines + fmt::format("  {}\n", toml_quoted(text));
}

/// Writes settings as " \"communication_unit\" = 15 ".
std::string inline_settings(const drivers::ControllerSettings& settings) {
  std::vector<std::string> pairs;
  for (const auto& [name, value] : settings) pairs.push_back(fmt::format("{} = {}", toml_quoted(name), value));
  return pairs.empty() ? "" : fmt::format(" {} ", fmt::join(pairs, ", "));
}

/// Writes parameters as " \"channel\" = \"1\" ".
std::string inline_parameters(const drivers::TextParameters& parameters) {
  std::vector<std::string> pairs;
  for (const auto& [name, value] : parameters)
    pairs.push_back(fmt::format("{} = {}", toml_quoted(name), toml_quoted(value)));
  return fmt::format(" {} ", fmt::join(pairs, ", "));
}

drivers::TextParameters read_parameters(const TomlTable& table) {
  drivers::TextParameters parameters;
  for (const auto& name : table.keys()) parameters[name] = table.text(name);
  return parameters;
}

drivers::ControllerSettings read_settings(const TomlTable& table) {
  drivers::ControllerSettings settings;
  for (const auto& name : table.keys()) settings[name] = table.number(name);
  return settings;
}

Duration read_observe(const TomlTable& table) {
  constexpr double kLongestS = 3600;
  const double seconds = table.number("observe_s");
  if (seconds >= 0 && seconds <= kLongestS) return from_seconds(seconds);
  table.note_error("observe_s", "expected 0 to 3600 s");
  return kUsualObserve;
}

/// Returns the reason to distrust the open file: another user owns it or may write it. Empty if there is none.
std::string distrust_reason(int file) {
  struct stat found {};
  if (::fstat(file, &found) != 0) return "its status cannot be read";
  if (found.st_uid != ::geteuid() && found.st_uid != 0)
    return "belongs to " + describe_user(found.st_uid) + ", who is neither root nor this user";
  return (found.st_mode & (S_IWGRP | S_IWOTH)) == 0
             ? ""
             : "can be written by other users; remove their write permission (chmod go-w)";
}

}  // namespace

std::string safe_state_path(const std::string& record) { return record + ".safe-state"; }

std::string to_text(const SafeState& safe_state) {
  const auto unless_empty = [](const char* key, const std::string& value) {
    return value.empty() ? std::string() : fmt::format("{} = {}\n", key, toml_quoted(value));
  };
  return fmt::format(
      "schema = \"{}\"\nrecord = {}\nline = {}\nlink = \"{}\"\nlink_settings = {}\nword_order = \"{}\"\n"
      "safe_set_point_c = {}\nswitch_off = {}\nby_program = {}\nobserve_s = {}\nsettings = {{{}}}\npid = {}\n"
      "started = {}\nboot = {}\n{}{}{}{}map = [\n{}]\n",
      kSafeStateSchema, toml_quoted(safe_state.record), toml_quoted(safe_state.line), name(safe_state.link),
      to_toml(safe_state.link_settings), to_string(safe_state.word_order), safe_state.safe_set_point.value,
      safe_state.switch_off, safe_state.by_program, to_seconds(safe_state.observe),
      inline_settings(safe_state.settings), safe_state.written_by.pid, safe_state.written_by.started,
      toml_quoted(safe_state.written_by.boot), unless_empty("power", safe_state.power),
      unless_empty("identity", safe_state.identity),
      safe_state.parameters.empty() ? ""
                                    : fmt::format("parameters = {{{}}}\n", inline_parameters(safe_state.parameters)),
      safe_state.also ? fmt::format("also = {}\n", drivers::to_toml(*safe_state.also)) : "",
      quoted_lines(safe_state.map_text));
}

Result<SafeState> parse_safe_state(std::string_view text, const std::string& file) {
  const auto table = TomlTable::parse(text, file);
  if (!table) return failure(table.error());
  const bool is_new = table->choice("schema", {std::string(kSafeStateSchema), std::string(kPreviousSafeStateSchema)}) ==
                      kSafeStateSchema;
  if (!table->is_list("map")) table->note_error("map", "\"map\" is not a list, expected the lines of a register map");
  SafeState safe_state{.record = table->text("record"),
                       .line = table->text("line"),
                       .link = one_of(drivers::kLinkKinds, *table, "link"),
                       .word_order = read_order(*table),
                       .link_settings = drivers::read_link_settings(table->table("link_settings")),
                       .parameters = read_parameters(table->table("parameters")),
                       .safe_set_point = {table->number("safe_set_point_c")},
                       .switch_off = table->boolean("switch_off"),
                       .by_program = table->boolean("by_program"),
                       .observe = is_new ? read_observe(*table) : kUsualObserve,
                       .settings = is_new ? read_settings(table->table("settings")) : drivers::ControllerSettings{},
                       .written_by = read_identity(*table),
                       .map_text = fmt::format("{}", fmt::join(table->texts("map"), "\n")),
                       .power = table->text("power", ""),
                       .identity = table->text("identity", "")};
  if (table->has("also")) safe_state.also = drivers::read_relay_settings(table->table("also"));
  if (auto verdict = table->verdict(); !verdict) return failure(std::move(verdict.error()));
  return safe_state;
}

Result<std::optional<SafeState>> read_safe_state(const std::string& file) {
  struct stat named {};
  if (::lstat(file.c_str(), &named) != 0 && errno == ENOENT) return std::nullopt;
  const auto opened = open_regular_file(file, Links::refused);
  if (!opened) return failure(opened.error());
  if (auto why = distrust_reason(opened->descriptor.number()); !why.empty())
    return failure(FaultKind::bad_file, file, std::move(why));
  const auto text = read_whole(*opened, file);
  if (!text) return failure(text.error());
  auto safe_state = parse_safe_state(*text, file);
  if (!safe_state) return failure(std::move(safe_state.error()));
  return *safe_state;
}

Result<void> write_safe_state(const SafeState& safe_state) {
  if (!is_utf8(safe_state.record))
    return failure(FaultKind::storage, safe_state.record, "the record's path is not valid UTF-8");
  return replace_own_file(safe_state_path(safe_state.record), to_text(safe_state));
}

void remove_safe_state(const std::string& record) { ::unlink(safe_state_path(record).c_str()); }

namespace {

/// Quotes a text from an instrument or a file, which may have control characters.
std::string quoted(const std::string& text) { return toml_quoted(plain(text, Blanks::kept)); }

/// Returns the line of a key, or nothing for an empty text.
std::string optional_line(const char* key, const std::string& text) {
  return text.empty() ? "" : fmt::format("{} = {}\n", key, quoted(text));
}

}  // namespace

std::string made_safe_path(const std::string& record) { return record + ".made-safe"; }

std::string to_text(const MadeSafe& trace) {
  return fmt::format(
      "schema = \"{}\"\nat = \"{}\"\nutc_ns = {}\nbecause = {}\nset_point_c = {}\nconfirmed = {}\n"
      "details = {}\n{}{}{}",
      kMadeSafeSchema, civil_time(trace.at), trace.at.count(), quoted(trace.because), trace.set_point.value,
      trace.confirmed, quoted(trace.details), optional_line("relay", trace.relay), optional_line("by", trace.by),
      optional_line("given_up", trace.given_up));
}

Result<MadeSafe> parse_made_safe(std::string_view text, const std::string& file) {
  const auto table = TomlTable::parse(text, file);
  if (!table) return failure(table.error());
  table->expect("schema", kMadeSafeSchema);
  // "at" is for human readers; "utc_ns" contains the exact time.
  table->ignore("at");
  MadeSafe trace{.at = Duration(table->integer("utc_ns")),
                 .because = table->text("because"),
                 .set_point = {table->number("set_point_c")},
                 .confirmed = table->boolean("confirmed"),
                 .details = table->text("details"),
                 .relay = table->text("relay", ""),
                 .by = table->text("by", ""),
                 .given_up = table->text("given_up", "")};
  if (auto verdict = table->verdict(); !verdict) return failure(std::move(verdict.error()));
  return trace;
}

Result<void> write_trace(const std::string& record, const MadeSafe& trace) {
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

bool was_released(const std::string& record) {
  std::error_code error;
  return !std::filesystem::exists(safe_state_path(record), error) && !error &&
         !std::filesystem::exists(made_safe_path(record), error) && !error;
}

std::string give_up_path(const std::string& record) { return record + ".give-up"; }

Result<void> write_give_up(const std::string& record, const std::string& who_and_why) {
  return replace_own_file(give_up_path(record), plain(who_and_why, Blanks::kept) + "\n");
}

std::string read_give_up(const std::string& record) {
  const auto path = give_up_path(record);
  const auto opened = open_regular_file(path, Links::refused);
  if (!opened || !distrust_reason(opened->descriptor.number()).empty()) return "";
  auto text = read_whole(*opened, path).value_or("");
  text = plain(text.substr(0, text.find('\n')), Blanks::kept);
  return text.empty() ? "no reason stated" : text;
}

void remove_give_up(const std::string& record) { ::unlink(give_up_path(record).c_str()); }

std::string describe(const MadeSafe& trace) {
  const auto* state = !trace.given_up.empty() ? "GIVEN UP" : trace.confirmed ? "made safe" : "NOT yet made safe";
  return fmt::format("{} by {} at {} ({}): the chamber {} {:g} °C; {}{}", state,
                     trace.by.empty() ? "the guard" : trace.by, civil_time(trace.at),
                     trace.given_up.empty() ? trace.because : trace.given_up,
                     trace.confirmed ? "was sent to" : "is NOT confirmed to have reached its safe set point of",
                     trace.set_point.value, trace.details, trace.relay.empty() ? "" : "; " + trace.relay);
}

}  // namespace gyrotherm::watchdog
