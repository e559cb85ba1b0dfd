#include "app/places.hpp"

#include <filesystem>

namespace gyrotherm {

std::string shipped(const std::string& path) {
  for (const auto* folder : {"", GYROTHERM_INSTALLED_DATA "/", GYROTHERM_SOURCE_DATA "/"})
    if (std::error_code error; std::filesystem::exists(folder + path, error)) return folder + path;
  return path;
}

}  // namespace gyrotherm
