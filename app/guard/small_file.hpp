/// A small file beside a record, replaced as a whole, readable by the record's group.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/result.hpp"

namespace gyrotherm {

/// Writes it under a temporary name, syncs, renames and syncs the folder; mode 0640. Fails with storage.
[[nodiscard]] Result<void> put_small_file(const std::string& path, std::string_view text);
/// Nothing if there is none. Fails with bad_file if it cannot be read, is a link or no regular file, or has more than
/// 4 MB.
[[nodiscard]] Result<std::optional<std::string>> read_small_file(const std::string& path);
/// Likewise; fails also if it belongs neither to this user nor to root, or others than they may write it.
[[nodiscard]] Result<std::optional<std::string>> read_own_small_file(const std::string& path);

}  // namespace gyrotherm
