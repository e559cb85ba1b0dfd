// SPDX-License-Identifier: Apache-2.0
/// A calibration report that a laboratory has signed: a folder with calibration.json, what people read, and dcc.xml,
/// which names each of them by its SHA-256. Who trusts the signature over dcc.xml thereby knows every file.
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

/// A file that a verifier has examined.
struct Check {
  std::string what{};  ///< "report.pdf"
  enum class Outcome {
    holds,
    fails,
    not_there,  ///< a record or a model elsewhere
    missing,    ///< named by dcc.xml
    foreign     ///< in the folder, named by nothing
  } outcome{};
  std::string text{};  ///< "as it was signed"
};
/// Returns true if the folder is not the signed report because of this outcome.
[[nodiscard]] bool is_failure(Check::Outcome outcome);

/// Renders all files of an authorised report anew, those among them that have the names given.
using RenderFiles =
    std::function<Result<std::vector<NewFile>>(const CalibrationReport& report, const std::vector<std::string>& names)>;

/// Signs the report of a folder: its PDFs one by one, then dcc.xml, made anew, over them and over every other file that
/// authorisation.json names, and over authorisation.json itself; the first PDF is in dcc.xml too. What is signed is
/// what `render` makes of calibration.json. Returns the names of the files. Fails with bad_file if the report is a
/// draft, is signed already, or has no authorisation.json; if a file was changed or removed since it was authorised, is
/// not rendered to the same bytes, or is not part of the report; or as sign_dcc() and sign_pdf() do. Fails with
/// storage. In all cases nothing in the folder was changed, also where the disk is full, unless it failed while files
/// were renamed.
[[nodiscard]] Result<std::vector<std::string>> sign_report(const std::string& folder, const SigningKey& key,
                                                           const RenderFiles& render);

/// Reads the authorisation of a folder and compares its files with it. Fails with bad_file if authorisation.json is
/// missing or cannot be read.
[[nodiscard]] Result<FolderDifferences> compare_with_authorisation(const std::string& folder,
                                                                   const CalibrationReport& report);

/// Whether dcc.xml of a folder bears a signature, whatever it is worth. Fails with storage.
[[nodiscard]] Result<bool> is_signed(const std::string& folder);

/// What a signed folder is found to be.
struct VerifiedReport {
  std::string identifier{};  ///< of the certificate
  std::optional<Signer> signer{};
  std::vector<Check> checks{};                ///< of dcc.xml, of each file that it names, of foreign files
  std::optional<CalibrationReport> report{};  ///< calibration.json, if it is as it was signed
};

/// Looks at dcc.xml, at each file that it names, at the signatures of the PDFs among them, which must be the same
/// signer's, and for files in the folder that are not part of the report. What does not hold is a check that fails and
/// not a fault; where dcc.xml is not signed by somebody who is trusted, nothing else is looked at. Fails with bad_file
/// only if a program is not installed, or the certificates that are trusted cannot be read.
[[nodiscard]] Result<VerifiedReport> verify_report(const std::string& folder, const Trust& trust);

}  // namespace gyrotherm::report
