#include "core/folder.hpp"

#include <system_error>

namespace gyrotherm {

std::vector<std::filesystem::path> entries_of(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> found;
  std::error_code error;
  for (std::filesystem::directory_iterator at(folder, error), end; !error && at != end; at.increment(error))
    found.push_back(at->path());
  return found;
}

std::string program_beside_this_one(const std::string& name) {
  std::error_code error;
  auto own = std::filesystem::read_symlink("/proc/self/exe", error).string();
  if (const auto gone = own.rfind(" (deleted)"); gone != std::string::npos) own.resize(gone);
  return std::filesystem::path(own).replace_filename(name).string();
}

}  // namespace gyrotherm
