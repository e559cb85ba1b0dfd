// SPDX-License-Identifier: Apache-2.0
/// A calibration report that a laboratory has signed: a folder with calibration.json, what people read, and dcc.xml,
/// which names each of them by its SHA-256. Who trusts the signature over dcc.xml thereby knows every file.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "report/calibration.hpp"
#include "report/signature.hpp"

namespace gyrotherm::report {

/// Something that a verifier looked at.
struct Check {
  std::string what{};  ///< "report.pdf"
  enum class Outcome { holds, fails, not_there } outcome{};
  std::string text{};  ///< what was found: "as signed", …
};

/// Signs the report of a folder: its PDFs one by one, then dcc.xml, made anew, over them, over calibration.json, and
/// over the pages (.html) and tables (.csv) beside; the first PDF is in dcc.xml too. Returns the names of the files.
/// Fails with bad_file if the report is a draft, is signed already, or as sign_dcc() and sign_pdf() do, and with
/// storage; then nothing in the folder was changed, also where the disk is full, unless it failed while files were
/// renamed.
[[nodiscard]] Result<std::vector<std::string>> sign_report(const std::string& folder, const SigningKey& key);

/// What a signed folder is found to be.
struct VerifiedReport {
  std::string identifier{};  ///< of the certificate
  std::optional<Signer> signer{};
  std::vector<Check> checks{};                ///< of dcc.xml, then of each file that it names
  std::optional<CalibrationReport> report{};  ///< calibration.json, if it is as it was signed
};

/// Looks at dcc.xml, at each file that it names, and at the signatures of the PDFs among them, which must be the same
/// signer's. What does not hold is a check that fails and not a fault; where dcc.xml is not signed by somebody who is
/// trusted, nothing else is looked at. Fails with bad_file only if a program is not installed, or the certificates
/// that are trusted cannot be read.
[[nodiscard]] Result<VerifiedReport> verify_report(const std::string& folder, const Trust& trust);

}  // namespace gyrotherm::report
