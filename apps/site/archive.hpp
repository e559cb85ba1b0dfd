// SPDX-License-Identifier: Apache-2.0
/// Copies the files of finished runs to an archive, under the digest of their content.
#pragma once

#include <string>
#include <vector>

#include "apps/site/run_text.hpp"
#include "apps/site/site_file.hpp"
#include "core/result.hpp"

namespace gyrotherm::site {

/// Returns digest and size of a file. Fails with bad_file if it cannot be read.
[[nodiscard]] Result<RunFileDigest> compute_digest(const std::string& path);

/// Archives one file. With a folder, copies the file to FOLDER/<sha256>.db unless it exists: the copy has a temporary
/// name until it is synced and its digest, computed while it is written, matches. A file with the final name is
/// therefore complete. Also removes incomplete copies of killed programs. With a command, runs it without a shell and
/// waits for its end. Kills it if its time is over or `stop` is readable. With neither, does nothing. Fails with
/// storage (no space, no folder, the file changed meanwhile), refused or timeout (the command), interrupted.
[[nodiscard]] Result<void> archive(const ArchiveSettings& settings, const RunFileDigest& file, int stop);

/// Returns the command with {file} and {sha256} replaced by the path and the digest of a file.
[[nodiscard]] std::vector<std::string> expand_command(const std::vector<std::string>& command,
                                                      const RunFileDigest& file);

}  // namespace gyrotherm::site
