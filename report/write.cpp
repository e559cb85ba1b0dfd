// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <system_error>

#include "core/file.hpp"
#include "report/views.hpp"

namespace gyrotherm::report {
namespace {

namespace fs = std::filesystem;

Result<void> make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return failure(FaultKind::storage, folder.string(), error.message());
  return {};
}

/// The views without report.json itself.
Result<void> write_views(const std::string& report_json_text, const fs::path& folder) {
  const auto report = read_report(report_json_text, (folder / "report.json").string());
  if (!report) return failure(report.error());
  const auto figures = all_figures(*report);
  if (auto made = make_folder(folder / "figures"); !made) return made;
  for (const ReportFigure& figure : figures) {
    if (auto written = replace_text_file((folder / "figures" / (figure.id + ".svg")).string(), figure.svg); !written)
      return written;
  }
  return replace_text_file((folder / "report.html").string(), html_of(*report, figures));
}

}  // namespace

Result<void> write_report(const std::string& report_json_text, const std::string& folder) {
  if (auto written = write_views(report_json_text, folder); !written) return written;
  return replace_text_file((fs::path(folder) / "report.json").string(), report_json_text);
}

Result<void> rebuild_report(const std::string& folder) {
  const auto text = read_text_file((fs::path(folder) / "report.json").string(), kLargestTable);
  if (!text) return failure(text.error());
  return write_views(*text, folder);
}

}  // namespace gyrotherm::report
