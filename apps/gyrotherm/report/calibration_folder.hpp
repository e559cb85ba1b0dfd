// SPDX-License-Identifier: Apache-2.0
/// The folder of a calibration report: calibration.json, and beside it its views; and that of a comparison of two.
#pragma once

#include <string>
#include <vector>

#include "apps/console/console.hpp"
#include "core/result.hpp"
#include "report/calibration.hpp"
#include "report/comparison.hpp"
#include "report/report_files.hpp"

namespace gyrotherm::app {

/// A report as its file has it.
struct FiledReport {
  report::CalibrationReport report;
  std::string path;    ///< of calibration.json
  std::string sha256;  ///< … and of its bytes
};

/// Reads the report of a folder, or a file of one. Fails with bad_file.
[[nodiscard]] Result<FiledReport> load_calibration(const std::string& folder_or_file);

/// Writes calibration.json and its views in these languages ("en", "de"), making the folder if needed, and says where;
/// of a report that is authorised authorisation.json too, which names all of them by their SHA-256. Each file appears
/// whole or not at all, calibration.json behind all others: where a view cannot be made, the report is in the state in
/// which it was. Fails with storage, or as a view does.
[[nodiscard]] Result<void> write_calibration(Console& console, const report::CalibrationReport& report,
                                             const std::string& folder, const std::vector<std::string>& languages);

/// Renders calibration.json and all its views anew, in the languages of the pages among `names`. Fails as a view does.
[[nodiscard]] Result<std::vector<report::NewFile>> render_calibration(const report::CalibrationReport& report,
                                                                      const std::vector<std::string>& names);

/// Writes comparison.json and its pages, making the folder if needed, and says where. Fails with storage.
[[nodiscard]] Result<void> write_comparison(Console& console, const report::Comparison& comparison,
                                            const std::string& folder, const std::vector<std::string>& languages);

/// Copies a report that is signed into FOLDER/as-signed, before the folder says something else; does nothing where it
/// is not signed, or a copy is there. Fails with bad_file or storage.
[[nodiscard]] Result<void> keep_as_signed(Console& console, const std::string& folder);

/// The languages of the views that a folder has.
[[nodiscard]] std::vector<std::string> languages_in(const std::string& folder);

}  // namespace gyrotherm::app
