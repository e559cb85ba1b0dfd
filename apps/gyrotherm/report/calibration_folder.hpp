// SPDX-License-Identifier: Apache-2.0
/// Folder of a calibration report: calibration.json and its views. Also the folder of a comparison of two reports.
#pragma once

#include <string>
#include <vector>

#include "apps/console/console.hpp"
#include "core/result.hpp"
#include "report/calibration.hpp"
#include "report/comparison.hpp"
#include "report/report_files.hpp"

namespace gyrotherm::app {

using report::FiledReport;

/// Reads the report in a folder, or the file itself. Fails with bad_file.
[[nodiscard]] Result<FiledReport> load_calibration(const std::string& folder_or_file);

/// Treatment of a report without a signature and without authorisation.json, such as a draft or a copied file.
enum class WithoutDigest { accepted, refused };
/// Fails with bad_file if a report was changed after it was authorised or signed. Prints that a signature is not
/// verified.
[[nodiscard]] Result<void> check_is_unchanged(Console& console, const FiledReport& filed, WithoutDigest without_digest);

/// Writes calibration.json and its views in these languages ("en", "de"), makes the folder if needed and prints the
/// paths. For an authorised report it also writes authorisation.json, which lists the SHA-256 of all other files. Each
/// file is replaced completely or not at all, calibration.json last: if a view cannot be made, the report keeps its
/// previous state. `sources_compared` is stored in authorisation.json. Prints a warning if a PDF lacks characters or
/// the logo; for an authorised report, fails with bad_file instead. Fails with storage, or like the failing view.
[[nodiscard]] Result<void> write_calibration(Console& console, const report::CalibrationReport& report,
                                             const std::string& folder, const std::vector<std::string>& languages,
                                             bool sources_compared = false);

/// Renders calibration.json and all its views again, in the languages of the views among `names`. Fails with
/// bad_file if a PDF lacks characters or the logo, and like the failing view.
[[nodiscard]] Result<std::vector<report::NewFile>> render_calibration(const report::CalibrationReport& report,
                                                                      const std::vector<std::string>& names);

/// The paths from which a comparison was made: calibration.json of both reports, and the history of check runs or an
/// empty path.
struct ComparedFiles {
  std::string before, now, history;
};

/// Writes comparison.json, its pages and its PDF, makes the folder if needed and prints the paths. Prints a
/// warning if the PDF lacks characters. Fails with storage.
[[nodiscard]] Result<void> write_comparison(Console& console, const report::Comparison& comparison,
                                            const ComparedFiles& files, const std::string& folder,
                                            const std::vector<std::string>& languages);

/// Fails with bad_file unless the folder exists. A file in its place is refused, too.
[[nodiscard]] Result<void> check_report_folder(const std::string& folder);

/// Copies a signed report to FOLDER/as-signed before its folder changes. The copy is on the disk when this returns.
/// Does nothing if the report is not signed or the copy exists. Fails with bad_file or storage, also if the copy does
/// not have the signed files.
[[nodiscard]] Result<void> copy_signed_report(Console& console, const std::string& folder);

/// Returns the languages of the views in a folder, pages or PDFs.
[[nodiscard]] std::vector<std::string> languages_in(const std::string& folder);

}  // namespace gyrotherm::app
