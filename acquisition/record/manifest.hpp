/// The fingerprint of a closed run, RUN.db.sha256, in the form that `sha256sum -c` checks.
#pragma once

#include <optional>
#include <set>
#include <string>

#include "core/result.hpp"

namespace gyrotherm {

/// "RUN.db" → "RUN.db.sha256".
[[nodiscard]] std::string manifest_path(const std::string& record_path);

/// Of the record's file and of every part after it, up to number `last_part`, with logs that were left beside them. No
/// connection to any of them may be open in this process. Fails with storage.
[[nodiscard]] Result<void> write_manifest(const std::string& record_path, int last_part);

/// The names of the files that agree with the manifest, which are all that it names; nothing if the record has none.
/// Fails with bad_file naming the first file that differs, or a log that lies beside a file and is not named.
[[nodiscard]] Result<std::optional<std::set<std::string>>> check_manifest(const std::string& record_path);

}  // namespace gyrotherm
