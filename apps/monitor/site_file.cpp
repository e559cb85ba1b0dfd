// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/site_file.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <set>

#include "apps/monitor/state_folder.hpp"
#include "core/file.hpp"
#include "core/text.hpp"
#include "core/toml_reader.hpp"

namespace gyrotherm::monitor {
namespace {

constexpr auto kRuleTriggers =
    make_vocabulary<RuleTrigger::alarm, RuleTrigger::silent>("alarm", "run ended", "disk low", "silent");
constexpr double kBytesPerGigabyte = 1e9;

bool is_one_line(const std::string& text) {
  return std::ranges::none_of(text, [](unsigned char c) { return c < ' ' || c == 0x7F; });
}

/// Reads a text without control characters, for a mail header or a line that is sent to a server.
std::string read_text_line(const TomlTable& table, const char* key, const std::optional<std::string>& fallback = {}) {
  auto text = table.text(key, fallback);
  if (!is_one_line(text)) table.note_error(key, fmt::format("\"{}\" contains control characters", key));
  return text;
}

std::vector<std::string> read_texts(const TomlTable& table, const char* key) {
  auto texts = table.texts(key);
  if (texts.empty()) table.note_error(key, fmt::format("\"{}\" is empty, expected a list of strings", key));
  for (const auto& text : texts)
    if (!is_one_line(text)) table.note_error(key, fmt::format("\"{}\" contains control characters", key));
  return texts;
}

/// Reads a command. Notes an error if its program is missing, because the people whom it notifies would not learn of
/// that. A name without a folder is looked up when the command runs.
std::vector<std::string> read_command(const TomlTable& table) {
  auto command = read_texts(table, "command");
  if (!command.empty() && command.front().find('/') != std::string::npos &&
      ::access(command.front().c_str(), X_OK) != 0)
    table.note_error("command", fmt::format("\"{}\" is not a program that can be run: {}", plain(command.front()),
                                            std::strerror(errno)));
  return command;
}

std::vector<std::string> read_mail_addresses(const TomlTable& table) {
  auto addresses = read_texts(table, "mail");
  for (const auto& address : addresses) {
    const auto at = address.find('@');
    const bool is_address = at != 0 && at != std::string::npos && at + 1 < address.size() &&
                            address.find_first_of(" \t,;") == std::string::npos;
    if (!is_address)
      table.note_error("mail", fmt::format("\"{}\" is not a mail address, expected NAME@HOST", plain(address)));
  }
  return addresses;
}

NotifyAddress read_address(const TomlTable& table) {
  NotifyAddress address{.name = read_text_line(table, "name"), .method = CommandAddress{}};
  const int methods = (table.has("command") ? 1 : 0) + (table.has("mail") ? 1 : 0) + (table.has("apprise") ? 1 : 0);
  if (methods != 1) table.note_error("name", "expected exactly one of command, mail and apprise");
  if (table.has("command")) address.method = CommandAddress{read_command(table)};
  if (table.has("mail")) address.method = MailAddress{read_mail_addresses(table)};
  if (table.has("apprise")) {
    address.method = AppriseAddress{read_text_line(table, "apprise")};
    if (std::get<AppriseAddress>(address.method).url.starts_with('-'))
      table.note_error("apprise", "starts with '-', expected a URL");
  }
  return address;
}

NotifyRule read_rule(const TomlTable& table) {
  NotifyRule rule{.trigger = one_of(kRuleTriggers, table, "when"), .addresses = read_texts(table, "tell")};
  rule.name = read_text_line(table, "name", keyword_for(kRuleTriggers, rule.trigger));
  const bool is_alarm = rule.trigger == RuleTrigger::alarm;
  if (is_alarm || rule.trigger == RuleTrigger::silent)
    rule.after = table.duration("after", is_alarm ? std::chrono::minutes(10) : std::chrono::minutes(2));
  if (rule.trigger == RuleTrigger::disk_low)
    rule.free_bytes = static_cast<std::uint64_t>(std::clamp(table.number("free_gb", 5), 0.0, 1e6) * kBytesPerGigabyte);
  if (rule.trigger == RuleTrigger::silent) rule.monitor = read_text_line(table, "monitor", "");
  if (!rule.monitor.empty() && !rule.monitor.starts_with("http://") && !rule.monitor.starts_with("https://"))
    table.note_error("monitor", "expected the address of a monitor, http://… or https://…");
  rule.simulated = table.boolean("simulated", false);
  return rule;
}

/// Returns false if an address ends in ":" and no port number from 1 to 65535 follows.
bool has_valid_port(std::string_view url) {
  const auto host = url.find("://");
  const auto colon = url.find(':', host == std::string_view::npos ? 0 : host + 3);
  if (colon == std::string_view::npos) return true;
  const auto digits = url.substr(colon + 1, url.find('/', colon) - colon - 1);
  std::uint16_t port = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), port);
  return error == std::errc() && end == digits.data() + digits.size() && port != 0;
}

MailServer read_mail_server(const TomlTable& table, const std::string& file) {
  MailServer mail{.url = read_text_line(table, "server"),
                  .from = read_text_line(table, "from"),
                  .user = read_text_line(table, "user", ""),
                  .password = {},
                  .requires_tls = table.boolean("secure", true)};
  if (!mail.url.starts_with("smtp://") && !mail.url.starts_with("smtps://"))
    table.note_error("server", "expected the address of a mail server, smtp://HOST:PORT or smtps://HOST:PORT");
  else if (!has_valid_port(mail.url))
    table.note_error("server", fmt::format("\"{}\" has no valid port, expected 1 to 65535", plain(mail.url)));
  if (mail.user.empty()) return mail;
  const auto name = std::filesystem::path(file).parent_path() / table.text("password_file");
  const auto password = read_private_file(name.string());
  if (!password || !*password)
    table.note_error("password_file", password ? name.string() + " does not exist" : text(password.error()));
  else
    mail.password = (*password)->substr(0, (*password)->find('\n'));
  return mail;
}

void check_names(const TomlTable& notify, const Site& site) {
  std::set<std::string> names;
  for (const auto& address : site.addresses) {
    if (!names.insert(address.name).second)
      notify.note_error("address", fmt::format("duplicate address \"{}\"", address.name));
    if (std::holds_alternative<MailAddress>(address.method) && !site.mail)
      notify.note_error("address",
                        fmt::format("\"{}\" requires a mail server, but [notify.mail] is missing", address.name));
  }
  std::set<std::string> rules;
  for (const auto& rule : site.rules) {
    if (!rules.insert(rule.name).second) notify.note_error("rule", fmt::format("duplicate rule \"{}\"", rule.name));
    for (const auto& name : rule.addresses)
      if (!names.contains(name))
        notify.note_error(
            "rule", fmt::format("rule \"{}\" notifies \"{}\", which is not an address of this file", rule.name, name));
  }
}

}  // namespace

Result<Site> parse_site(std::string_view text, const std::string& file) {
  const auto root = TomlTable::parse(text, file);
  if (!root) return failure(root.error());
  root->expect("schema", kSiteSchema);
  // apps/site/site_file.hpp reads these keys.
  for (const char* key : {"rig", "folders", "store", "archive"}) root->ignore(key);
  Site site{.name = read_text_line(*root, "name", ""), .has_store = root->has("store")};
  if (root->has("live"))
    root->note_error("live", "[live] is no longer used, because the store contains the live state; remove the table");
  const auto notify = root->table("notify");
  for (const auto& table : notify.tables("address")) site.addresses.push_back(read_address(table));
  for (const auto& table : notify.tables("rule")) site.rules.push_back(read_rule(table));
  if (notify.has("mail")) site.mail = read_mail_server(notify.table("mail"), file);
  check_names(notify, site);
  if (const auto verdict = root->verdict(); !verdict) return failure(verdict.error());
  return site;
}

Result<Site> read_site(const std::string& file) {
  return read_text_file(file).and_then([&](const std::string& text) { return parse_site(text, file); });
}

}  // namespace gyrotherm::monitor
