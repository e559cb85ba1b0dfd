// SPDX-License-Identifier: Apache-2.0
/// A signed calibration report: a folder with calibration.json, the human-readable files, and dcc.xml. dcc.xml lists
/// the SHA-256 of every file; the signature of dcc.xml therefore protects all of them.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "report/calibration.hpp"
#include "report/report_files.hpp"
#include "report/signature.hpp"

namespace gyrotherm::report {

/// Result of examining one file.
struct Check {
  std::string what{};  ///< "report.pdf"
  enum class Outcome {
    holds,
    fails,
    not_there,        ///< record or model stored elsewhere
    unsigned_beside,  ///< belongs to a record in the folder, but no digest covers it
    missing,          ///< listed in dcc.xml
    foreign           ///< in the folder, not listed
  } outcome{};
  std::string text{};  ///< "unchanged since it was signed"
};
/// Returns true for an outcome that makes the verification of the folder fail: all except holds, not_there and
/// unsigned_beside.
[[nodiscard]] bool is_failure(Check::Outcome outcome);

/// Callback that renders the files with the given names from an authorised report.
using RenderFiles =
    std::function<Result<std::vector<NewFile>>(const CalibrationReport& report, const std::vector<std::string>& names)>;

/// Signs the report of a folder. It signs each PDF, then writes and signs a new dcc.xml over the PDFs, over every other
/// file listed in authorisation.json, and over authorisation.json itself; dcc.xml embeds the PDF in its mandatory
/// language. The signed bytes are those that `render` makes from calibration.json. Returns the names of the files.
/// Fails with usage if the report was authorised after `now_utc`. Fails with bad_file if the report is a draft, is
/// already signed, or has no authorisation.json; if a file was changed
/// or removed after authorisation, is not rendered to the same bytes, or is not part of the report; or like sign_dcc()
/// and sign_pdf(). Fails with storage. A failure leaves the folder unchanged, even on a full disk, unless the failure
/// occurs while files are being renamed.
[[nodiscard]] Result<std::vector<std::string>> sign_report(const std::string& folder, const SigningKey& key,
                                                           const RenderFiles& render, const std::string& now_utc);

/// Compares the files of a folder with its authorisation. Fails with bad_file if authorisation.json is missing or
/// cannot be read.
[[nodiscard]] Result<FolderDifferences> compare_with_authorisation(const std::string& folder,
                                                                   const CalibrationReport& report);

/// Returns true if the dcc.xml of a folder contains a signature, without verifying it. Fails with storage.
[[nodiscard]] Result<bool> is_signed(const std::string& folder);

/// Returns the files that dcc.xml of a signed folder names. Does not verify the signature. Fails with bad_file or
/// storage.
[[nodiscard]] Result<std::vector<IssuedFile>> list_signed_files(const std::string& folder);

/// Returns the SHA-256 that calibration.json must have: from dcc.xml of a signed folder, otherwise from
/// authorisation.json; empty for a draft. Does not verify the signature. Fails with bad_file or storage.
[[nodiscard]] Result<std::string> find_expected_digest(const std::string& folder);

/// Result of verifying a signed folder.
struct VerifiedReport {
  std::string identifier{};
  std::optional<Signer> signer{};
  /// Results for dcc.xml, for the files listed in it, and for other files.
  std::vector<Check> checks{};
  /// The contents of calibration.json if the file is unchanged.
  std::optional<CalibrationReport> report{};
};

/// Verifies dcc.xml, each file that it lists, the signatures of listed PDFs, which must be by the same signer, and that
/// the folder has no other files. A mismatch is a failed check and not a fault. If dcc.xml has no signature of a
/// trusted signer, nothing else is examined. Fails with bad_file only if a program is not installed or the trusted
/// certificates cannot be read.
[[nodiscard]] Result<VerifiedReport> verify_report(const std::string& folder, const Trust& trust);

}  // namespace gyrotherm::report
