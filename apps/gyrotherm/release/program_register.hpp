// SPDX-License-Identifier: Apache-2.0
/// The register of a site's released programs: profiles, rig files, register maps and descriptions that one person has
/// reviewed and another has released by a signature. A release names the SHA-256 of a text, so it holds for this text
/// under any file name, and for no other text.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/record/run_info.hpp"
#include "apps/gyrotherm/release/site_policy.hpp"
#include "core/result.hpp"
#include "report/signature.hpp"
#include "sequencer/profile/profile.hpp"
#include "sequencer/rig/rig_file.hpp"

namespace gyrotherm::app {

inline constexpr const char* kReleaseSchema = "gyrotherm-release/1";

/// A step of a release: the person and the time (UTC).
struct ReleaseStep {
  std::string by{}, at{};
};

/// An entry of the register.
struct Release {
  std::string title;   ///< name of the file, for people
  std::string sha256;  ///< digest of the text
  std::string revision;
  ReleaseStep reviewed;
  ReleaseStep released{};
  /// Signature over signed_text(), PEM; empty while the program is only reviewed.
  std::string signature{};
};

/// Returns the state of an entry for people: "reviewed" or "released".
[[nodiscard]] const char* state_of(const Release& release);
/// Returns the text that a signature covers: the entry without its signature, as JSON.
[[nodiscard]] std::string signed_text(const Release& release);
/// Formats the file of an entry.
[[nodiscard]] std::string to_json(const Release& release);
/// Parses the file of an entry. Fails with bad_file.
[[nodiscard]] Result<Release> parse_release(std::string_view json, const std::string& file);

/// Returns the path of the entry for a text with this SHA-256.
[[nodiscard]] std::string release_path(const std::string& register_folder, const std::string& sha256);
/// Reads the entry for a text with this SHA-256; nothing if there is none. Fails with bad_file if the entry is invalid
/// or is one of another text.
[[nodiscard]] Result<std::optional<Release>> find_release(const std::string& register_folder,
                                                          const std::string& sha256);
/// Reads all entries, ordered by title and revision. Fails with bad_file if one is invalid.
[[nodiscard]] Result<std::vector<Release>> list_releases(const std::string& register_folder);

/// Verifies the signature of an entry. Fails with bad_file if the program is only reviewed, or like
/// report::verify_bytes().
[[nodiscard]] Result<report::Signer> verify_release(const Release& release, const std::string& file,
                                                    const report::Trust& trust);

/// A text that takes part in a run.
struct ProgramText {
  std::string title;  ///< such as "profile short"
  std::string text;
};

/// Returns the texts of a run: the profile, the rig file, and each map and description that the rig file names.
[[nodiscard]] std::vector<ProgramText> list_programs(const profile::Profile& profile, const rig::RigFile& rig);

/// Looks up each text in the register of a policy and verifies its release. A text without a valid release has the
/// reason in `unreleased`.
[[nodiscard]] std::vector<record::ProgramRelease> judge_programs(const std::vector<ProgramText>& programs,
                                                                 const ReleasePolicy& policy);

/// Returns the releases of a run under the policy of this machine; nothing if it has none. Fails with usage if the
/// policy refuses unreleased programs, the rig is real, and a text is unreleased. Fails like read_policy().
[[nodiscard]] Result<std::vector<record::ProgramRelease>> check_releases(const profile::Profile& profile,
                                                                         const rig::RigFile& rig);

}  // namespace gyrotherm::app
