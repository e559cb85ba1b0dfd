#include "core/user_name.hpp"

#include <fmt/format.h>

#include <fstream>

namespace gyrotherm {

/// passwd(5): name, password, number, … between colons.
std::string user_in_words(std::int64_t uid) {
  std::ifstream users("/etc/passwd");
  const auto number = ":" + std::to_string(uid) + ":";
  for (std::string line; std::getline(users, line);) {
    const auto name_ends = line.find(':');
    if (name_ends == std::string::npos || name_ends == 0) continue;
    const auto password_ends = line.find(':', name_ends + 1);
    if (password_ends == std::string::npos || line.compare(password_ends, number.size(), number) != 0) continue;
    return fmt::format("{} (uid {})", line.substr(0, name_ends), uid);
  }
  return fmt::format("unknown (uid {})", uid);
}

}  // namespace gyrotherm
