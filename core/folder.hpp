/// What lies in a folder, and in which one this program lies.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace gyrotherm {

/// The paths of what lies in a folder, in no order; as many as could be read, none if it cannot be read at all. An
/// error on the way ends the list, as it may where a folder changes meanwhile; the increment of a
/// std::filesystem::directory_iterator would make an exception of it.
[[nodiscard]] std::vector<std::filesystem::path> entries_of(const std::filesystem::path& folder);

/// The path of the program `name` that was installed beside the one that runs.
[[nodiscard]] std::string program_beside_this_one(const std::string& name);

}  // namespace gyrotherm
