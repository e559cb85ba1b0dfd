// SPDX-License-Identifier: Apache-2.0
#include "core/process.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <system_error>

namespace gyrotherm {

void ensure(bool holds, const char* invariant) {
  if (holds) return;
  std::fprintf(stderr, "gyrotherm: a safety invariant is violated, the program ends: %s\n", invariant);
  std::abort();
}

std::string sibling_program_path(const std::string& name) {
  std::error_code error;
  auto own = std::filesystem::read_symlink("/proc/self/exe", error).string();
  if (const auto gone = own.rfind(" (deleted)"); gone != std::string::npos) own.resize(gone);
  return std::filesystem::path(own).replace_filename(name).string();
}

bool is_executable(const std::string& path) {
  std::error_code error;
  return std::filesystem::is_regular_file(path, error) && ::access(path.c_str(), X_OK) == 0;
}

std::string find_program_in_path(const std::string& name, const std::string& folder) {
  const char* path = std::getenv("PATH");
  std::string_view rest = path != nullptr ? path : "/usr/bin:/bin";
  while (!rest.empty()) {
    const auto colon = rest.find(':');
    const auto file = std::filesystem::path(folder) / rest.substr(0, colon) / name;  // absolute paths replace `folder`
    if (is_executable(file)) return file.string();
    rest = colon == std::string_view::npos ? std::string_view() : rest.substr(colon + 1);
  }
  return {};
}

/// Reads /etc/passwd (passwd(5)). The first fields of each line are name, password and user number, separated by
/// colons.
std::string user_name(std::int64_t uid) {
  std::ifstream users("/etc/passwd");
  const auto number = ":" + std::to_string(uid) + ":";
  for (std::string line; std::getline(users, line);) {
    const auto name_ends = line.find(':');
    if (name_ends == std::string::npos || name_ends == 0) continue;
    const auto password_ends = line.find(':', name_ends + 1);
    if (password_ends == std::string::npos || line.compare(password_ends, number.size(), number) != 0) continue;
    return line.substr(0, name_ends);
  }
  return "unknown";
}

std::string describe_user(std::int64_t uid) { return fmt::format("{} (uid {})", user_name(uid), uid); }

}  // namespace gyrotherm
