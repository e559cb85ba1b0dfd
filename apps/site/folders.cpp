// SPDX-License-Identifier: Apache-2.0
#include "apps/site/folders.hpp"

#include <filesystem>
#include <system_error>

#include "core/file.hpp"

namespace gyrotherm::site {

namespace {

namespace fs = std::filesystem;

constexpr int kDeepest = 3;

void add(const fs::path& folder, int depth, std::vector<std::string>& folders) {
  folders.push_back(folder.string());
  if (depth == kDeepest) return;
  for (const auto& entry : entries_of(folder)) {
    std::error_code error;
    if (fs::is_directory(fs::symlink_status(entry, error))) add(entry, depth + 1, folders);
  }
}

}  // namespace

std::vector<std::string> folders_below(const std::vector<std::string>& tops) {
  std::vector<std::string> folders;
  for (const auto& top : tops) add(top, 0, folders);
  return folders;
}

}  // namespace gyrotherm::site
