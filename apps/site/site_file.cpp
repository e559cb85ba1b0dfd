// SPDX-License-Identifier: Apache-2.0
#include "apps/site/site_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "core/file.hpp"
#include "core/toml_reader.hpp"

namespace gyrotherm::site {
namespace {

constexpr std::size_t kMaxRigNameBytes = 64;

std::string read_rig_name(const TomlTable& table, const char* key) {
  auto name = table.text(key);
  const auto is_control = [](unsigned char c) { return c < ' ' || c == 0x7F; };
  if (name.empty() || name.size() > kMaxRigNameBytes || std::ranges::any_of(name, is_control))
    table.note_error(key, fmt::format("\"{}\" is not a name, expected 1 to {} bytes without control characters", key,
                                      kMaxRigNameBytes));
  return name;
}

/// Resolves a path in a site file, which is relative to the folder of the file.
std::string resolve_path(const std::string& file, const std::string& path) {
  return (std::filesystem::path(file).parent_path() / path).string();
}

/// Returns the path of the password file: the `passfile` of the table, or its `credential` in the folder `credentials`.
/// Returns an empty text if the table has neither.
std::string read_passfile(const TomlTable& table, const std::string& file, const std::string& credentials) {
  if (table.has("passfile") && table.has("credential"))
    table.note_error("credential", "expected only one of passfile and credential");
  if (table.has("credential")) {
    if (credentials.empty())
      table.note_error("credential", "$CREDENTIALS_DIRECTORY is not set; set LoadCredential= in the systemd unit");
    return credentials + "/" + table.text("credential");
  }
  return table.has("passfile") ? resolve_path(file, table.text("passfile")) : "";
}

StoreAddress read_store_address(const TomlTable& table, const std::string& file, const std::string& credentials) {
  StoreAddress address{.conninfo = table.text("address")};
  if (address.conninfo.empty() && table.is_text("address"))
    table.note_error("address", "\"address\" is empty, expected a libpq connection string such as \"host=db\"");
  if (const auto good = check_conninfo(address.conninfo); !good && !address.conninfo.empty())
    table.note_error("address", good.error().what);
  address.passfile = read_passfile(table, file, credentials);
  address.is_credential = table.has("credential");
  return address;
}

ArchiveSettings read_archive(const TomlTable& table, const std::string& file) {
  ArchiveSettings archive;
  if (table.has("folder") == table.has("command"))
    table.note_error("folder", "expected exactly one of folder and command");
  if (table.has("folder")) archive.folder = resolve_path(file, table.text("folder"));
  if (table.has("command")) {
    archive.command = table.texts("command");
    const auto has_placeholder = [&](const char* what) {
      return std::ranges::any_of(archive.command,
                                 [&](const auto& word) { return word.find(what) != std::string::npos; });
    };
    if (!has_placeholder("{file}") || !has_placeholder("{sha256}"))
      table.note_error("command", "expected arguments that contain {file} and {sha256}");
  }
  archive.within = table.duration("within", archive.within);
  return archive;
}

/// Reads the address of the store and the limits of its connection.
void read_store_table(const TomlTable& root, const std::string& file, const std::string& credentials,
                      SiteSettings& site) {
  const auto store = root.table("store");
  site.store = read_store_address(store, file, credentials);
  site.longest_wait = store.duration("longest_wait", site.longest_wait);
  site.longest_answer = store.duration("longest_answer", site.longest_answer);
  constexpr Duration kMinTimeout = std::chrono::milliseconds(100);
  if (site.longest_wait < kMinTimeout) store.note_error("longest_wait", "expected 100 ms or more");
  if (site.longest_answer < kMinTimeout) store.note_error("longest_answer", "expected 100 ms or more");
}

void refuse_live_table(const TomlTable& root) {
  if (root.has("live"))
    root.note_error("live", "[live] is no longer used, because the store contains the live state; remove it");
}

std::string credentials_folder() {
  const char* credentials = std::getenv("CREDENTIALS_DIRECTORY");
  return credentials != nullptr ? credentials : "";
}

}  // namespace

Result<SiteSettings> parse_site(std::string_view text, const std::string& file, const std::string& credentials) {
  const auto root = TomlTable::parse(text, file);
  if (!root) return failure(root.error());
  root->expect("schema", kSiteSchema);
  root->ignore("name");
  root->ignore("notify");
  SiteSettings site{.rig = read_rig_name(*root, "rig")};
  for (const auto& folder : root->texts("folders")) site.folders.push_back(resolve_path(file, folder));
  if (site.folders.empty()) root->note_error("folders", "\"folders\" is empty, expected folders of records");
  read_store_table(*root, file, credentials, site);
  refuse_live_table(*root);
  if (root->has("archive")) site.archive = read_archive(root->table("archive"), file);
  if (const auto verdict = root->verdict(); !verdict) return failure(verdict.error());
  return site;
}

Result<SiteSettings> read_site(const std::string& file) {
  return read_text_file(file).and_then(
      [&](const std::string& text) { return parse_site(text, file, credentials_folder()); });
}

Result<StoreAddress> parse_store(std::string_view text, const std::string& file, const std::string& credentials) {
  const auto root = TomlTable::parse(text, file);
  if (!root) return failure(root.error());
  root->expect("schema", kSiteSchema);
  for (const char* key : {"name", "notify", "rig", "folders", "archive"}) root->ignore(key);
  SiteSettings site;
  read_store_table(*root, file, credentials, site);
  refuse_live_table(*root);
  if (const auto verdict = root->verdict(); !verdict) return failure(verdict.error());
  return site.store;
}

Result<StoreAddress> read_store(const std::string& file) {
  return read_text_file(file).and_then(
      [&](const std::string& text) { return parse_store(text, file, credentials_folder()); });
}

}  // namespace gyrotherm::site
