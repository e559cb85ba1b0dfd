// SPDX-License-Identifier: Apache-2.0
/// The files that a person has authorised: authorisation.json names calibration.json and each of its views by SHA-256.
/// Whoever signs later signs these bytes and no others.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"
#include "report/calibration.hpp"
#include "report/dcc.hpp"
#include "report/new_files.hpp"

namespace gyrotherm::report {

inline constexpr const char* kAuthorisationFile = "authorisation.json";
inline constexpr const char* kAuthorisationSchema = "gyrotherm-authorisation/1";

struct AuthorisedFiles {
  std::string number{};  ///< of the report
  Authorisation authorised{};
  std::string program_version{};  ///< that rendered the views
  std::vector<IssuedFile> files{};
};

/// Returns the authorisation of a report that is authorised, over the files given.
[[nodiscard]] AuthorisedFiles authorised_files(const CalibrationReport& report, const std::vector<NewFile>& files,
                                               const std::string& program_version);

/// Returns authorisation.json, ending in a newline. Equal authorisations give equal bytes.
[[nodiscard]] std::string to_json(const AuthorisedFiles& files);

/// Reads authorisation.json. Fails with bad_file on syntax, another schema, a missing key, a name with a folder in it,
/// a name that is there twice, and where calibration.json is not named.
[[nodiscard]] Result<AuthorisedFiles> authorised_files_from_json(std::string_view json, const std::string& file);

/// How the files of a folder differ from those that are named; each list is sorted.
struct FolderDifferences {
  std::vector<std::string> changed{}, missing{};
  std::vector<std::string> foreign{};  ///< files and folders that are not named
  [[nodiscard]] bool empty() const { return changed.empty() && missing.empty() && foreign.empty(); }
};
/// "changed calibration.html; not part of the report note.html, zz.pdf"
[[nodiscard]] std::string text(const FolderDifferences& differences);

/// Compares a folder with the files named. Files that the report rests on may be there too, each record with the
/// manifest that belongs to it; so may those in `beside`. A file that cannot be read counts as changed.
[[nodiscard]] FolderDifferences compare_with(const std::string& folder, const std::vector<IssuedFile>& files,
                                             const std::vector<UsedFile>& used,
                                             const std::vector<std::string>& beside = {});

/// Returns the entries of a folder that are neither in `names` nor files that the report rests on, sorted.
[[nodiscard]] std::vector<std::string> foreign_entries(const std::string& folder, const std::vector<std::string>& names,
                                                       const std::vector<UsedFile>& used);

}  // namespace gyrotherm::report
