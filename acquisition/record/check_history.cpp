// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/check_history.hpp"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "core/file.hpp"
#include "core/toml_reader.hpp"

namespace gyrotherm::record {

std::vector<std::string> list_check_histories(const RunInfo& info, const std::string& record) {
  const auto rig = TomlTable::parse(info.rig_text, "rig");
  if (!rig || !rig->has("check_standard")) return {};
  const auto name = rig->table("check_standard").text("history", kDefaultCheckHistory);
  const auto beside = [&](const std::string& file) {
    return (std::filesystem::path(parent_folder(file)) / name).lexically_normal().string();
  };
  if (info.rig_file.empty() || beside(info.rig_file) == beside(record)) return {beside(record)};
  return {beside(info.rig_file), beside(record)};
}

std::string NamedHistory::find_path() const {
  const auto is_there = [](const std::string& path) { return read_file_state(path).is_there(); };
  const auto found = std::ranges::find_if(paths, is_there);
  return found == paths.end() ? std::string() : *found;
}

std::optional<NamedHistory> find_named_history(const RunInfo& info, const std::string& record) {
  auto paths = list_check_histories(info, record);
  if (paths.empty()) return std::nullopt;
  return NamedHistory{.paths = std::move(paths), .rig = info.rig_name, .simulated = is_simulated(info)};
}

}  // namespace gyrotherm::record
