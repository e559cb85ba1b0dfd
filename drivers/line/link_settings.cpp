// SPDX-License-Identifier: Apache-2.0
#include "drivers/line/link_settings.hpp"

#include <fmt/format.h>

#include <chrono>
#include <vector>

namespace gyrotherm::drivers {
namespace {

constexpr int kMostReadAtOnce = 125;
/// Maximum timeout. The watchdog must not act before three such timeouts have passed.
constexpr Duration kMaxTimeout = std::chrono::seconds(2);

template <class T>
void override_value(T& value, const std::optional<T>& replacement) {
  if (replacement) value = *replacement;
}

}  // namespace

LinkSettings read_link_settings(const TomlTable& table) {
  LinkSettings settings;
  if (table.has("unit")) settings.unit = whole<std::uint8_t>(table, "unit", 0, 255);
  if (table.has("timeout")) {
    settings.timeout = table.duration("timeout");
    if (*settings.timeout <= Duration::zero() || *settings.timeout > kMaxTimeout)
      table.note_error("timeout", "\"timeout\" is out of range, expected more than zero and at most 2 s");
  }
  if (table.has("read_at_most"))
    settings.read_at_most = whole<std::uint16_t>(table, "read_at_most", 1, kMostReadAtOnce);
  if (table.has("echo")) settings.echo = table.boolean("echo");
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
  if (settings.timeout) entries.push_back(fmt::format("timeout = \"{} s\"", to_seconds(*settings.timeout)));
  append("read_at_most", settings.read_at_most);
  append("echo", settings.echo);
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
  override_value(link.returns_other_transaction, settings.returns_other_transaction);
  override_value(link.returns_other_unit, settings.returns_other_unit);
  override_value(link.miscounts_write_replies, settings.miscounts_write_replies);
  return link;
}

Result<void> check_framing(const ModbusLink& link, const LinkSettings& settings) {
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
