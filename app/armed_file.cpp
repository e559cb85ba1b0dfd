#include "app/armed_file.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>

#include "app/keyed_text.hpp"
#include "app/small_file.hpp"

namespace gyrotherm {
namespace {

constexpr std::array kLinks{LinkKind::tcp, LinkKind::rtu, LinkKind::rtu_over_tcp};
constexpr std::array<std::string_view, 5> kOrders{"abcd", "cdab", "badc", "dcba", "of the map"};

std::string_view order_in_words(const std::optional<WordOrder>& order) {
  return kOrders.at(order ? static_cast<std::size_t>(*order) : kOrders.size() - 1);
}

LinkKind read_link(KeyedText& text) {
  const auto word = text.text("link");
  for (const auto kind : kLinks)
    if (word == name(kind)) return kind;
  text.mistake("link: expected tcp, rtu or rtu_over_tcp");
  return {};
}

std::optional<WordOrder> read_order(KeyedText& text) {
  const auto word = text.text("word_order");
  const auto found = std::find(kOrders.begin(), kOrders.end(), word);
  if (found == kOrders.end()) text.mistake("word_order: expected abcd, cdab, badc, dcba or \"of the map\"");
  if (found >= kOrders.end() - 1) return {};
  return static_cast<WordOrder>(found - kOrders.begin());
}

}  // namespace

std::string armed_path(const std::string& record) { return record + ".armed"; }

std::string to_text(const Armed& armed) {
  return fmt::format(
      "{}\nrecord: {}\nline: {}\nlink: {}\nword_order: {}\nsafe_set_point_c: {}\nswitch_off: {}\npid: {}\n"
      "started: {}\nboot: {}\nmap_bytes: {}\n{}",
      kArmedSchema, armed.record, armed.line, name(armed.link), order_in_words(armed.word_order),
      armed.safe_set_point.value, armed.switch_off ? "yes" : "no", armed.armed_by.pid, armed.armed_by.started,
      armed.armed_by.boot, armed.map_text.size(), armed.map_text);
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
  armed.armed_by.pid = keyed.number<std::int32_t>("pid");
  armed.armed_by.started = keyed.number<std::uint64_t>("started");
  armed.armed_by.boot = keyed.text("boot");
  armed.map_text = keyed.rest("map_bytes");
  if (!keyed.wrong() && armed.armed_by.pid <= 0) keyed.mistake("pid: no process has this number");
  if (auto verdict = keyed.verdict(); !verdict) return failure(std::move(verdict.error()));
  return armed;
}

Result<std::optional<Armed>> read_armed(const std::string& file) {
  const auto text = read_small_file(file);
  if (!text) return failure(text.error());
  if (!*text) return std::nullopt;
  auto armed = parse_armed(**text, file);
  if (!armed) return failure(std::move(armed.error()));
  return *armed;
}

Result<void> arm(const Armed& armed) {
  if (armed.record.find('\n') != std::string::npos)
    return failure(FaultKind::storage, armed.record, "a record's path has no line break");
  return put_small_file(armed_path(armed.record), to_text(armed));
}

void disarm(const std::string& record) { ::unlink(armed_path(record).c_str()); }

}  // namespace gyrotherm
