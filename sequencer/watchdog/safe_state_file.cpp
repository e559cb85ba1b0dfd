#include "sequencer/watchdog/safe_state_file.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

#include "core/text_file.hpp"
#include "core/user_name.hpp"
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

std::string armed_path(const std::string& record) { return record + ".armed"; }

std::string to_text(const Armed& armed) {
  return fmt::format(
      "{}\nrecord: {}\nline: {}\nlink: {}\nword_order: {}\nsafe_set_point_c: {}\nswitch_off: {}\nby_program: {}\n"
      "pid: {}\nstarted: {}\nboot: {}\nmap_bytes: {}\n{}",
      kArmedSchema, armed.record, armed.line, name(armed.link), order_in_words(armed.word_order),
      armed.safe_set_point.value, armed.switch_off ? "yes" : "no", armed.by_program ? "yes" : "no", armed.armed_by.pid,
      armed.armed_by.started, armed.armed_by.boot, armed.map_text.size(), armed.map_text);
}

Result<Armed> parse_armed(std::string_view text, const std::string& file) {
  KeyedText keyed(text, file, kArmedSchema);
  Armed armed;
  armed.record = keyed.text("record");
  armed.line = keyed.text("line");
  armed.link = read_link(keyed);
  armed.word_order = read_order(keyed);
  armed.safe_set_point = {keyed.number<double>("safe_set_point_c")};
  armed.switch_off = keyed.yes("switch_off");
  armed.by_program = keyed.yes("by_program");
  armed.armed_by.pid = keyed.number<std::int32_t>("pid");
  armed.armed_by.started = keyed.number<std::uint64_t>("started");
  armed.armed_by.boot = keyed.text("boot");
  armed.map_text = keyed.rest("map_bytes");
  if (!keyed.wrong() && armed.armed_by.pid <= 0) keyed.mistake("pid: no process has this number");
  if (auto verdict = keyed.verdict(); !verdict) return failure(std::move(verdict.error()));
  return armed;
}

Result<std::optional<Armed>> read_armed(const std::string& file) {
  struct stat named {};
  if (::lstat(file.c_str(), &named) != 0 && errno == ENOENT) return std::nullopt;
  const auto opened = open_regular_file(file, Links::refused);
  if (!opened) return failure(opened.error());
  if (auto why = objection(opened->descriptor.number()); !why.empty())
    return failure(FaultKind::bad_file, file, std::move(why));
  const auto text = read_whole(*opened, file);
  if (!text) return failure(text.error());
  auto armed = parse_armed(*text, file);
  if (!armed) return failure(std::move(armed.error()));
  return *armed;
}

Result<void> arm(const Armed& armed) {
  if (armed.record.find('\n') != std::string::npos)
    return failure(FaultKind::storage, armed.record, "a record's path has no line break");
  return replace_own_file(armed_path(armed.record), to_text(armed));
}

void disarm(const std::string& record) { ::unlink(armed_path(record).c_str()); }

}  // namespace gyrotherm
