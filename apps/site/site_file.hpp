// SPDX-License-Identifier: Apache-2.0
/// What a site file says of the store: which rig this is, where its records lie, where they go (docs/site.md). The same
/// file may say whom the live page tells of what (docs/monitor.md); each program passes over the other's part.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "apps/site/postgres.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm::site {

inline constexpr const char* kSiteSchema = "gyrotherm-site/1";

/// Where the files of finished runs go. Of folder and command at most one is there.
struct ArchiveSettings {
  std::string folder{};                ///< each as <sha256>.db
  std::vector<std::string> command{};  ///< a program and its words; {file} and {sha256} stand for what they say
  Duration within = std::chrono::hours(1);
};

struct SiteSettings {
  std::string rig{};                   ///< by what name the store knows it
  std::vector<std::string> folders{};  ///< of records; their folders are looked at, too
  StoreAddress store{};
  Duration longest_wait = std::chrono::minutes(1);    ///< between two tries to reach the store
  Duration longest_answer = std::chrono::minutes(1);  ///< of the store; after that the connection counts as lost
  ArchiveSettings archive{};
};

/// Fails with bad_file, all mistakes with their places. Relative paths are those of the file's folder; a `credential`
/// lies in `credentials`, which is $CREDENTIALS_DIRECTORY of systemd.
[[nodiscard]] Result<SiteSettings> parse_site(std::string_view text, const std::string& file,
                                              const std::string& credentials);
[[nodiscard]] Result<SiteSettings> read_site(const std::string& file);

}  // namespace gyrotherm::site
