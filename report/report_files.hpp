// SPDX-License-Identifier: Apache-2.0
/// Files in the folder of a report: how they are replaced together, and how a folder is compared with its
/// authorisation. authorisation.json contains the SHA-256 of calibration.json and of each view; only files with these
/// hashes are signed.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"
#include "report/calibration.hpp"
#include "report/dcc.hpp"

namespace gyrotherm::report {

/// A report that was read from its file.
struct FiledReport {
  CalibrationReport report;
  std::string path;  ///< calibration.json
  std::string sha256;
};

/// Reads a calibration.json. Fails as read_text_file() and calibration_from_json() do.
[[nodiscard]] Result<FiledReport> read_filed_report(const std::string& path);

/// A file to be written.
struct NewFile {
  std::string name, bytes;
};

/// Replaces files of a folder in the given order, the file that makes the others valid last. All files are first
/// written under temporary names, so a full disk changes nothing. Fails with storage; the files after the failed one
/// are then not replaced.
[[nodiscard]] Result<void> replace_all(const std::string& folder, const std::vector<NewFile>& files);

inline constexpr const char* kAuthorisationFile = "authorisation.json";
/// Folder, in that of a superseded report, with the copy of the report as it was signed.
inline constexpr const char* kSignedCopyFolder = "as-signed";
inline constexpr const char* kAuthorisationSchema = "gyrotherm-authorisation/1";

struct AuthorisedFiles {
  std::string number{};
  Authorisation authorised{};
  std::string program_version{};  ///< version that rendered the views
  /// True if the report was made again from its records, models, order and laboratory file before its authorisation.
  bool sources_compared{};
  std::vector<IssuedFile> files{};
};

/// Returns the authorisation of an authorised report over the given files.
[[nodiscard]] AuthorisedFiles make_authorisation(const CalibrationReport& report, const std::vector<NewFile>& files,
                                                 const std::string& program_version, bool sources_compared = false);

/// Returns authorisation.json, ending in a newline. The text depends only on `files`.
[[nodiscard]] std::string to_json(const AuthorisedFiles& files);

/// Reads authorisation.json. Fails with bad_file on syntax errors, another schema, a missing key, a name with a folder,
/// a duplicate name, or if calibration.json is not listed.
[[nodiscard]] Result<AuthorisedFiles> authorised_files_from_json(std::string_view json, const std::string& file);

/// Differences between a folder and a list of files; each list is sorted.
struct FolderDifferences {
  std::vector<std::string> changed{}, missing{};
  std::vector<std::string> foreign{};  ///< neither listed nor used
  [[nodiscard]] bool empty() const { return changed.empty() && missing.empty() && foreign.empty(); }
};
/// Returns "changed calibration.html; not part of the report note.html, zz.pdf".
[[nodiscard]] std::string text(const FolderDifferences& differences);

/// Compares a folder with the listed files. The folder may also contain the files used by the report, as
/// find_unlisted_entries() lists them, and the files named in `beside`. A symbolic link and a file that cannot be read
/// are reported as changed.
[[nodiscard]] FolderDifferences compare_folder(const std::string& folder, const std::vector<IssuedFile>& files,
                                               const std::vector<UsedFile>& used,
                                               const std::vector<std::string>& beside = {});

/// Returns true for a symbolic link, also to a missing file.
[[nodiscard]] bool is_symbolic_link(const std::string& path);

/// Returns true if a report names this file by the name inside it: a profile, a rig or a column map. The file itself
/// may also be called NAME.toml.
[[nodiscard]] bool has_name_in_text(const UsedFile& file);

/// Returns true if a file called `name` may be a used file. A file with another digest is none if `all` lists it in
/// another role, or if it is not a TOML file and has_name_in_text() is true: a column map may have the name of the
/// table that it describes. `digest` returns the SHA-256 of the file and is called only if needed.
[[nodiscard]] bool may_be_used_file(const std::string& name, const std::function<std::string()>& digest,
                                    const UsedFile& file, const std::vector<UsedFile>& all);

/// Returns the status files in a folder that belong to used records in the folder, sorted. No digest covers them.
[[nodiscard]] std::vector<std::string> find_unsigned_entries(const std::string& folder,
                                                             const std::vector<UsedFile>& used);

/// Returns the entries of a folder that are neither in `names` nor used by the report, sorted. Used are regular files
/// that may_be_used_file() accepts under the name of a used file, a profile, a rig or a column map also with ".toml"
/// after its name if only one of both is there, and the manifest and the status file of a used record that is there.
[[nodiscard]] std::vector<std::string> find_unlisted_entries(const std::string& folder,
                                                             const std::vector<std::string>& names,
                                                             const std::vector<UsedFile>& used);

}  // namespace gyrotherm::report
