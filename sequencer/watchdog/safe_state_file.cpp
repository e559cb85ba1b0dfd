#include "sequencer/watchdog/safe_state_file.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

#include "core/file.hpp"
#include "core/process.hpp"
#include "drivers/chamber/register_map_words.hpp"
#include "sequencer/watchdog/keyed_text.hpp"

namespace gyrotherm {
namespace {

constexpr const char* kOfTheMap = "of the map";

const char* order_in_words(const std::optional<WordOrder>& order) {
  const auto found =
      std::find_if(kWordOrders.begin(), kWordOrders.end(), [&](const auto& w) { return w.second == order; });
  return found == kWordOrders.end() ? kOfTheMap : found->first;
}

/// What the word stands for; nothing, and no mistake, if it is none of these.
template <class T, std::size_t N>
std::optional<T> meant(const Vocabulary<T, N>& words, std::string_view word) {
  for (const auto& [known, value] : words)
    if (word == known) return value;
  return {};
}

LinkKind read_link(KeyedText& text) {
  const auto link = meant(kLinkKinds, text.text("link"));
  if (!link) text.mistake("link: expected tcp, rtu or rtu_over_tcp");
  return link.value_or(LinkKind{});
}

std::optional<WordOrder> read_order(KeyedText& text) {
  const auto word = text.text("word_order");
  const auto order = meant(kWordOrders, word);
  if (!order && word != kOfTheMap) text.mistake("word_order: expected abcd, cdab, badc, dcba or \"of the map\"");
  return order;
}

/// Why somebody else may have written the open file; empty: nobody has.
std::string objection(int file) {
  struct stat found {};
  if (::fstat(file, &found) != 0) return "cannot be looked at";
  if (found.st_uid != ::geteuid() && found.st_uid != 0)
    return "belongs to " + user_in_words(found.st_uid) + ", who is neither root nor this user";
  return (found.st_mode & (S_IWGRP | S_IWOTH)) == 0 ? "" : "may be written by others than its owner";
}

}  // namespace

std::string safe_state_path(const std::string& record) { return record + ".armed"; }

std::string to_text(const SafeState& safe_state) {
  return fmt::format(
      "{}\nrecord: {}\nline: {}\nlink: {}\nword_order: {}\nsafe_set_point_c: {}\nswitch_off: {}\nby_program: {}\n"
      "pid: {}\nstarted: {}\nboot: {}\nmap_bytes: {}\n{}",
      kSafeStateSchema, safe_state.record, safe_state.line, name(safe_state.link),
      order_in_words(safe_state.word_order), safe_state.safe_set_point.value, safe_state.switch_off ? "yes" : "no",
      safe_state.by_program ? "yes" : "no", safe_state.written_by.pid, safe_state.written_by.started,
      safe_state.written_by.boot, safe_state.map_text.size(), safe_state.map_text);
}

Result<SafeState> parse_safe_state(std::string_view text, const std::string& file) {
  KeyedText keyed(text, file, kSafeStateSchema);
  SafeState safe_state;
  safe_state.record = keyed.text("record");
  safe_state.line = keyed.text("line");
  safe_state.link = read_link(keyed);
  safe_state.word_order = read_order(keyed);
  safe_state.safe_set_point = {keyed.number<double>("safe_set_point_c")};
  safe_state.switch_off = keyed.yes("switch_off");
  safe_state.by_program = keyed.yes("by_program");
  safe_state.written_by.pid = keyed.number<std::int32_t>("pid");
  safe_state.written_by.started = keyed.number<std::uint64_t>("started");
  safe_state.written_by.boot = keyed.text("boot");
  safe_state.map_text = keyed.rest("map_bytes");
  if (!keyed.wrong() && safe_state.written_by.pid <= 0) keyed.mistake("pid: no process has this number");
  if (auto verdict = keyed.verdict(); !verdict) return failure(std::move(verdict.error()));
  return safe_state;
}

Result<std::optional<SafeState>> read_safe_state(const std::string& file) {
  struct stat named {};
  if (::lstat(file.c_str(), &named) != 0 && errno == ENOENT) return std::nullopt;
  const auto opened = open_regular_file(file, Links::refused);
  if (!opened) return failure(opened.error());
  if (auto why = objection(opened->descriptor.number()); !why.empty())
    return failure(FaultKind::bad_file, file, std::move(why));
  const auto text = read_whole(*opened, file);
  if (!text) return failure(text.error());
  auto safe_state = parse_safe_state(*text, file);
  if (!safe_state) return failure(std::move(safe_state.error()));
  return *safe_state;
}

Result<void> write_safe_state(const SafeState& safe_state) {
  if (safe_state.record.find('\n') != std::string::npos)
    return failure(FaultKind::storage, safe_state.record, "a record's path has no line break");
  return replace_own_file(safe_state_path(safe_state.record), to_text(safe_state));
}

void remove_safe_state(const std::string& record) { ::unlink(safe_state_path(record).c_str()); }

}  // namespace gyrotherm
