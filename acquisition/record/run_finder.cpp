// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/run_finder.hpp"

#include <filesystem>
#include <string_view>

#include "acquisition/record/run_parts.hpp"
#include "core/file.hpp"

namespace gyrotherm::record {

namespace {

namespace fs = std::filesystem;

bool names_a_record(const fs::path& path) {
  if (path.extension() != ".db") return false;
  if (path.stem().extension() == ".live") return false;
  const auto part = part_name(path.string());
  const auto is_told_of = [](const std::string& record) { return is_there(status_path(record)); };
  return !part || is_told_of(path.string()) || (!is_there(part->record) && !is_told_of(part->record));
}

}  // namespace

std::set<std::string> records_in(const std::string& folder) {
  std::set<std::string> records;
  for (const auto& path : entries_of(folder)) {
    auto text = path.string();
    if (text.ends_with(".db.status")) text.resize(text.size() - std::string_view(".status").size());
    if (names_a_record(text)) records.insert(text);
  }
  return records;
}

std::optional<RunStatus> told_status(const std::string& path) {
  const auto file = status_path(path);
  const auto text = read_text_file_if_any(file, kLargestText, Links::refused);
  if (!text || !*text) return std::nullopt;
  auto status = parse_status(**text, file);
  if (!status) return std::nullopt;
  status->path = path;
  return *std::move(status);
}

bool is_fresh(const RunStatus& status) {
  const auto age = age_of(status);
  return !status.finished && age && *age <= kSilentAfter;
}

std::optional<RunStatus> fresh_status(const std::string& path) {
  auto status = told_status(path);
  if (!status || !is_fresh(*status)) return std::nullopt;
  status->being_written = true;
  return status;
}

}  // namespace gyrotherm::record
