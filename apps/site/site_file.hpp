// SPDX-License-Identifier: Apache-2.0
/// The part of a site file about the store: the rig's name, the folders of its records, and the store's address
/// (docs/site.md). The same file may configure the notifications of the live page (docs/monitor.md); each program
/// ignores the other's part.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "apps/site/postgres.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm::site {

inline constexpr const char* kSiteSchema = "gyrotherm-site/1";

/// The archive of the files of finished runs. Either a folder or a command, or neither, is set.
struct ArchiveSettings {
  /// Folder for the copies, named <sha256>.db.
  std::string folder{};
  /// A program and its arguments; {file} and {sha256} are replaced.
  std::vector<std::string> command{};
  /// Time limit of the command.
  Duration within = std::chrono::hours(1);
};

struct SiteSettings {
  /// The rig's name in the store.
  std::string rig{};
  /// Folders of records; their subfolders are included.
  std::vector<std::string> folders{};
  StoreAddress store{};
  /// Longest wait between two attempts to connect.
  Duration longest_wait = std::chrono::minutes(1);
  /// Longest wait for a response of the store. After it, the connection counts as lost.
  Duration longest_answer = std::chrono::minutes(1);
  ArchiveSettings archive{};
};

/// Parses a site file. Fails with bad_file and lists all errors with their positions. Relative paths are relative to
/// the file's folder. A `credential` is a file in the folder `credentials`, which systemd provides as
/// $CREDENTIALS_DIRECTORY.
[[nodiscard]] Result<SiteSettings> parse_site(std::string_view text, const std::string& file,
                                              const std::string& credentials);
[[nodiscard]] Result<SiteSettings> read_site(const std::string& file);
/// Parses the address of the store, for a program that only queries it. Of all tables, the site file needs only
/// [store]; the others may be missing and are not checked. Otherwise like parse_site().
[[nodiscard]] Result<StoreAddress> parse_store(std::string_view text, const std::string& file,
                                               const std::string& credentials);
[[nodiscard]] Result<StoreAddress> read_store(const std::string& file);

}  // namespace gyrotherm::site
