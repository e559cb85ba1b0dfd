// SPDX-License-Identifier: Apache-2.0
/// The files of finished runs, kept in a second place under the name of what is in them.
#pragma once

#include <string>
#include <vector>

#include "apps/site/run_text.hpp"
#include "apps/site/site_file.hpp"
#include "core/result.hpp"

namespace gyrotherm::site {

/// Digest and size of a file. Fails with bad_file if it cannot be read.
[[nodiscard]] Result<RunFileDigest> digest_of(const std::string& path);

/// Copies the file to FOLDER/<sha256>.db, unless it is there already: under another name first, synced, read back by
/// its digest as it is written, then renamed; so what has the name has the bytes, and what a killed program left of a
/// copy is removed. Or runs the command, without a shell, and waits for it until `stop` is readable or its time is
/// over; then it is ended. With neither nothing is done. Fails with storage (no space, no folder, the file changed
/// meanwhile), refused or timeout (the command), interrupted.
[[nodiscard]] Result<void> archive(const ArchiveSettings& settings, const RunFileDigest& file, int stop);

/// The command as it is run for a file.
[[nodiscard]] std::vector<std::string> command_for(const std::vector<std::string>& command, const RunFileDigest& file);

}  // namespace gyrotherm::site
