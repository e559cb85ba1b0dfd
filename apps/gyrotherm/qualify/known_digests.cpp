// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/qualify/known_digests.hpp"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "acquisition/record/chain.hpp"
#include "core/file.hpp"
#include "core/json.hpp"

namespace gyrotherm::app {

namespace {

constexpr const char* kDigestsSchema = "gyrotherm-digests/1";

struct DigestsFile {
  std::string schema = kDigestsSchema, program_version;
  std::vector<KnownDigests::Entry> records;
};

std::vector<std::pair<std::string, std::string>> to_entries(const record::Manifest& manifest) {
  return {manifest.begin(), manifest.end()};
}

/// Returns the digest of the record's first file; empty if the manifest does not have it.
std::string file_digest(const record::Manifest& manifest, const std::string& record_path) {
  const auto found = manifest.find(std::filesystem::path(record_path).filename().string());
  return found == manifest.end() ? std::string() : found->second;
}

void describe(auto& form, Like<DigestsFile> auto& file) {
  form("schema", file.schema);
  form("program_version", file.program_version);
  form("records", file.records);
}

}  // namespace

void describe(auto& form, Like<KnownDigests::Entry> auto& entry) {
  form("files", named_values(entry.files));
  form("rows", entry.rows);
}

KnownDigests::KnownDigests(const std::string& folder, std::string program_version)
    : path_(folder + "/digests.json"), program_version_(std::move(program_version)) {
  const auto text = read_text_file(path_, kLargestTable);
  if (!text) return;
  const auto root = JsonNode::parse(*text, path_);
  if (!root) return;
  DigestsFile file;
  read_json(*root, file);
  if (root->verdict() && file.schema == kDigestsSchema && file.program_version == program_version_)
    entries_ = std::move(file.records);
}

bool KnownDigests::is_empty() const {
  const std::scoped_lock lock(guard_);
  return entries_.empty();
}

Result<std::optional<KnownDigests::Digests>> KnownDigests::find(const std::string& record_path) const {
  if (is_empty()) return std::nullopt;
  const auto manifest = record::check_manifest(record_path);
  if (!manifest) return failure(manifest.error());
  if (!*manifest) return std::nullopt;
  const std::scoped_lock lock(guard_);
  const auto found = std::ranges::find(entries_, to_entries(**manifest), &Entry::files);
  return found == entries_.end() ? std::nullopt
                                 : std::optional(Digests{file_digest(**manifest, record_path), found->rows});
}

Result<std::string> KnownDigests::store_rows(const std::string& record_path, const std::string& rows) {
  const auto manifest = record::check_manifest(record_path);
  if (!manifest) return failure(manifest.error());
  if (!*manifest) return std::string();
  const auto files = to_entries(**manifest);
  const std::scoped_lock lock(guard_);
  std::erase_if(entries_, [&](const Entry& entry) { return entry.files == files; });
  entries_.push_back({files, rows});
  const DigestsFile stored{.program_version = program_version_, .records = entries_};
  return replace_text_file(path_, json_text(make_json(stored), 1) + "\n").map([&] {
    return file_digest(**manifest, record_path);
  });
}

}  // namespace gyrotherm::app
