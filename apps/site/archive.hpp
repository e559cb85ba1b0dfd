// SPDX-License-Identifier: Apache-2.0
/// Copies the files of finished runs to an archive. A file is named after the digest of its content.
#pragma once

#include <string>
#include <vector>

#include "apps/site/run_text.hpp"
#include "apps/site/site_file.hpp"
#include "core/result.hpp"

namespace gyrotherm::site {

/// Returns digest and size of a file. Fails with bad_file if it cannot be read.
[[nodiscard]] Result<RunFileDigest> compute_digest(const std::string& path);

/// Archives a file with the folder or the command of the settings; without either, does nothing.
///
/// Folder: copies the file to FOLDER/<sha256>.db unless that exists. The copy has a temporary name until it is synced
/// and its digest has been checked, so a file with the final name is complete. Also removes incomplete copies of
/// publishers that were killed.
///
/// Command: runs it without a shell and waits for its end. Kills it and its children if the time is over or `stop` is
/// readable.
///
/// Fails with storage (no space, no folder, or the file has changed), refused or timeout (the command), or interrupted.
[[nodiscard]] Result<void> archive(const ArchiveSettings& settings, const RunFileDigest& file, int stop);

/// Replaces {file} and {sha256} in a command by the path and the digest of a file.
[[nodiscard]] std::vector<std::string> expand_command(const std::vector<std::string>& command,
                                                      const RunFileDigest& file);

}  // namespace gyrotherm::site
