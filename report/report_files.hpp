// SPDX-License-Identifier: Apache-2.0
/// The files of a report's folder. They are replaced together. A person authorises them: authorisation.json names
/// calibration.json and each of its views by SHA-256, and later these bytes are signed and no others.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"
#include "report/calibration.hpp"
#include "report/dcc.hpp"

namespace gyrotherm::report {

/// A file of a report, to be written.
struct NewFile {
  std::string name, bytes;
};

/// Replaces files of a folder in their order: the last one makes the others valid. Writes all of them under temporary
/// names before it renames any, so that a full disk changes nothing. Fails with storage; later files are then not
/// replaced.
[[nodiscard]] Result<void> replace_all(const std::string& folder, const std::vector<NewFile>& files);

inline constexpr const char* kAuthorisationFile = "authorisation.json";
inline constexpr const char* kAuthorisationSchema = "gyrotherm-authorisation/1";

struct AuthorisedFiles {
  std::string number{};  ///< the report's
  Authorisation authorised{};
  std::string program_version{};  ///< renderer of the views
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

/// The differences between the files of a folder and those named; each list is sorted.
struct FolderDifferences {
  std::vector<std::string> changed{}, missing{};
  std::vector<std::string> foreign{};  ///< neither named nor used
  [[nodiscard]] bool empty() const { return changed.empty() && missing.empty() && foreign.empty(); }
};
/// "changed calibration.html; not part of the report note.html, zz.pdf"
[[nodiscard]] std::string text(const FolderDifferences& differences);

/// Compares a folder with the files named. It may also hold files that the report rests on, each record with its
/// manifest, and those in `beside`. A file that cannot be read counts as changed.
[[nodiscard]] FolderDifferences compare_with(const std::string& folder, const std::vector<IssuedFile>& files,
                                             const std::vector<UsedFile>& used,
                                             const std::vector<std::string>& beside = {});

/// Returns the names of other entries of a folder, sorted: they are not in `names`, and the report does not use them.
[[nodiscard]] std::vector<std::string> foreign_entries(const std::string& folder, const std::vector<std::string>& names,
                                                       const std::vector<UsedFile>& used);

}  // namespace gyrotherm::report
