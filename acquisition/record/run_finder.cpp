// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/run_finder.hpp"

#include <filesystem>
#include <string_view>

#include "acquisition/record/run_parts.hpp"
#include "acquisition/record/status_file.hpp"
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

}  // namespace gyrotherm::record
