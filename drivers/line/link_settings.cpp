// SPDX-License-Identifier: Apache-2.0
#include "drivers/line/link_settings.hpp"

#include <fmt/format.h>

#include <array>
#include <chrono>
#include <utility>
#include <vector>

namespace gyrotherm::drivers {
namespace {

constexpr int kMostReadAtOnce = 125;
/// Maximum timeout. The watchdog must not act before three such timeouts have passed.
constexpr Duration kMaxTimeout = std::chrono::seconds(2);

bool is_pause(Duration time) { return time >= Duration::zero() && time <= kMaxPause; }

template <class T>
void override_value(T& value, const std::optional<T>& replacement) {
  if (replacement) value = *replacement;
}

}  // namespace

void check_longest(const TomlTable& table, const char* key, Duration time, Duration longest) {
  if (time > longest)
    table.note_error(
        key, fmt::format("\"{}\" is {:g} s, expected at most {:g} s", key, to_seconds(time), to_seconds(longest)));
}

LinkSettings read_line_settings(const TomlTable& table) {
  LinkSettings settings;
  if (table.has("unit")) settings.unit = whole<std::uint8_t>(table, "unit", 0, 255);
  if (table.has("timeout")) {
    settings.timeout = table.duration("timeout");
    if (*settings.timeout <= Duration::zero() || *settings.timeout > kMaxTimeout)
      table.note_error("timeout", "\"timeout\" is out of range, expected more than zero and at most 2 s");
  }
  if (table.has("echo")) settings.echo = table.boolean("echo");
  if (table.has("after_read")) settings.after_read = table.duration("after_read");
  if (table.has("after_write")) settings.after_write = table.duration("after_write");
  if (!is_pause(settings.after_read.value_or(Duration{})))
    table.note_error("after_read", "\"after_read\" is out of range, expected 0 to 10 s");
  if (!is_pause(settings.after_write.value_or(Duration{})))
    table.note_error("after_write", "\"after_write\" is out of range, expected 0 to 10 s");
  return settings;
}

LinkSettings read_link_settings(const TomlTable& table) {
  auto settings = read_line_settings(table);
  if (table.has("read_at_most"))
    settings.read_at_most = whole<std::uint16_t>(table, "read_at_most", 1, kMostReadAtOnce);
  if (table.has("returns_other_transaction"))
    settings.returns_other_transaction = table.boolean("returns_other_transaction");
  if (table.has("returns_other_unit")) settings.returns_other_unit = table.boolean("returns_other_unit");
  if (table.has("miscounts_write_replies")) settings.miscounts_write_replies = table.boolean("miscounts_write_replies");
  return settings;
}

std::string to_toml(const LinkSettings& settings) {
  std::vector<std::string> entries;
  const auto append = [&](const char* key, const auto& value) {
    if (value) entries.push_back(fmt::format("{} = {}", key, *value));
  };
  append("unit", settings.unit);
  const auto to_text = [](const std::optional<Duration>& time) {
    return time ? std::optional(fmt::format("\"{} s\"", to_seconds(*time))) : std::nullopt;
  };
  append("timeout", to_text(settings.timeout));
  append("read_at_most", settings.read_at_most);
  append("echo", settings.echo);
  append("after_read", to_text(settings.after_read));
  append("after_write", to_text(settings.after_write));
  append("returns_other_transaction", settings.returns_other_transaction);
  append("returns_other_unit", settings.returns_other_unit);
  append("miscounts_write_replies", settings.miscounts_write_replies);
  return entries.empty() ? "{}" : fmt::format("{{ {} }}", fmt::join(entries, ", "));
}

ModbusLink apply_settings(ModbusLink link, const LinkSettings& settings) {
  override_value(link.unit, settings.unit);
  override_value(link.timeout, settings.timeout);
  override_value(link.read_at_most, settings.read_at_most);
  override_value(link.echo, settings.echo);
  override_value(link.after_write, settings.after_write);
  override_value(link.returns_other_transaction, settings.returns_other_transaction);
  override_value(link.returns_other_unit, settings.returns_other_unit);
  override_value(link.miscounts_write_replies, settings.miscounts_write_replies);
  return link;
}

Result<void> check_text_settings(const LinkSettings& settings) {
  const std::array<std::pair<const char*, bool>, 4> modbus_only{
      {{"read_at_most", settings.read_at_most.has_value()},
       {"returns_other_transaction", settings.returns_other_transaction.has_value()},
       {"returns_other_unit", settings.returns_other_unit.has_value()},
       {"miscounts_write_replies", settings.miscounts_write_replies.has_value()}}};
  for (const auto& [key, is_stated] : modbus_only)
    if (is_stated)
      return failure(FaultKind::usage, key,
                     "applies to Modbus only; an instrument with lines of text has no such setting");
  return {};
}

Result<void> check_framing(const ModbusLink& link, const LinkSettings& settings) {
  if (settings.after_read)
    return failure(FaultKind::usage, "after_read", "applies to lines of text only; a Modbus link has no such setting");
  if (link.framing == ModbusLink::Framing::tcp) {
    if (settings.echo.value_or(false))
      return failure(FaultKind::usage, "echo",
                     "Modbus TCP has no echo; set it only on a serial line or with framing \"rtu_over_tcp\"");
    return {};
  }
  constexpr const char* kTcpOnly = "RTU frames have no such field; set it only on a link with framing \"tcp\"";
  if (settings.returns_other_transaction.value_or(false))
    return failure(FaultKind::usage, "returns_other_transaction", kTcpOnly);
  if (settings.returns_other_unit.value_or(false))
    return failure(FaultKind::usage, "returns_other_unit",
                   "RTU identifies a reply only by its unit number; set \"unit\" to the number of the replies");
  if (settings.miscounts_write_replies.value_or(false))
    return failure(FaultKind::usage, "miscounts_write_replies", kTcpOnly);
  return {};
}

}  // namespace gyrotherm::drivers
