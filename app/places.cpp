// SPDX-License-Identifier: Apache-2.0
#include "app/places.hpp"

#include <algorithm>
#include <filesystem>
#include <string_view>

#include "core/text.hpp"

namespace gyrotherm::app {

std::string shipped(const std::string& path) {
  for (const auto* folder : {"", GYROTHERM_INSTALLED_DATA "/", GYROTHERM_SOURCE_DATA "/"})
    if (std::error_code error; std::filesystem::exists(folder + path, error)) return folder + path;
  return path;
}

std::string record_named_after(const std::string& profile_name) {
  constexpr std::size_t kLongest = 100;
  std::string name;
  for (std::string_view left = profile_name; !left.empty() && name.size() < kLongest;) {
    const auto size = std::max<std::size_t>(character_size(left), 1);
    const auto character = left.substr(0, size);
    const bool leads = name.empty() && (character == "." || character == "-" || character == " ");
    const bool is_safe = plain(character) == character && character != "/" && character != "\\";
    name += is_safe && !leads ? character : "_";
    left.remove_prefix(size);
  }
  return (name.empty() ? "run" : name) + ".db";
}

}  // namespace gyrotherm::app
