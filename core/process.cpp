// SPDX-License-Identifier: Apache-2.0
#include "core/process.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <system_error>

namespace gyrotherm {

void ensure(bool holds, const char* law) {
  if (holds) return;
  fmt::print(stderr, "gyrotherm: a law of safety is broken, the program ends: {}\n", law);
  std::fflush(stderr);
  std::abort();
}

std::string program_beside_this_one(const std::string& name) {
  std::error_code error;
  auto own = std::filesystem::read_symlink("/proc/self/exe", error).string();
  if (const auto gone = own.rfind(" (deleted)"); gone != std::string::npos) own.resize(gone);
  return std::filesystem::path(own).replace_filename(name).string();
}

/// A line of passwd(5) is name, password, number, … between colons.
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

std::string user_in_words(std::int64_t uid) { return fmt::format("{} (uid {})", user_name(uid), uid); }

}  // namespace gyrotherm
