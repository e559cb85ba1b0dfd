/// What lies in a folder.
#pragma once

#include <filesystem>
#include <vector>

namespace gyrotherm {

/// The paths of what lies in a folder, in no order; as many as could be read, none if it cannot be read at all. An
/// error on the way ends the list, as it may where a folder changes meanwhile; the increment of a
/// std::filesystem::directory_iterator would make an exception of it.
[[nodiscard]] std::vector<std::filesystem::path> entries_of(const std::filesystem::path& folder);

}  // namespace gyrotherm
