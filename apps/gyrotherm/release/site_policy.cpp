// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/release/site_policy.hpp"

#include <cstdlib>
#include <filesystem>
#include <utility>

#include "core/file.hpp"
#include "core/toml_reader.hpp"

namespace gyrotherm::app {
namespace {

constexpr auto kUnreleasedWords = make_vocabulary<Unreleased::marked, Unreleased::refused>("marked", "refused");

/// Returns the path at `key`, relative to the folder of the policy.
std::string read_path(const TomlTable& table, const char* key, const std::string& file) {
  const std::filesystem::path path(table.text(key));
  if (path.empty()) table.note_error(key, "expected a path");
  return path.is_absolute() ? path.string() : (std::filesystem::path(file).parent_path() / path).string();
}

}  // namespace

Result<SitePolicy> parse_policy(std::string_view text, const std::string& file) {
  const auto table = TomlTable::parse(text, file);
  if (!table) return failure(table.error());
  table->expect("schema", kPolicySchema);
  SitePolicy policy{.file = file};
  if (table->has("releases")) {
    const TomlTable releases = table->table("releases");
    policy.releases = ReleasePolicy{.register_folder = read_path(releases, "register", file),
                                    .trusted = read_path(releases, "trusted", file),
                                    .unreleased = one_of(kUnreleasedWords, releases, "unreleased", "marked")};
  }
  if (auto valid = table->verdict(); !valid) return failure(valid.error());
  return policy;
}

Result<std::optional<SitePolicy>> read_policy() {
  const char* const given = std::getenv(kPolicyVariable);
  const std::string file = given != nullptr && *given != '\0' ? given : kPolicyFile;
  std::error_code unknown;
  if (file == kPolicyFile && !std::filesystem::exists(file, unknown) && !unknown) return std::nullopt;
  const auto text = read_text_file(file);
  if (!text) return failure(text.error());
  return parse_policy(*text, file).map([](SitePolicy&& policy) { return std::optional(std::move(policy)); });
}

}  // namespace gyrotherm::app
