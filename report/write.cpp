#include "report/write.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <system_error>

#include "report/figures.hpp"
#include "report/html.hpp"
#include "report/report_view.hpp"

namespace gyrotherm {
namespace {

namespace fs = std::filesystem;

Result<void> write_whole(const fs::path& path, const std::string& text) {
  fs::path temporary = path;
  temporary += ".part";
  std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
  file.write(text.data(), static_cast<std::streamsize>(text.size()));
  file.close();
  std::error_code error;
  if (!file) {
    fs::remove(temporary, error);
    return failure(FaultKind::storage, path.string(), "cannot be written");
  }
  fs::rename(temporary, path, error);
  if (error) return failure(FaultKind::storage, path.string(), error.message());
  return {};
}

Result<void> make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return failure(FaultKind::storage, folder.string(), error.message());
  return {};
}

/// The views without report.json itself.
Result<void> write_views(const std::string& report_json_text, const fs::path& folder) {
  const auto view = read_report(report_json_text, (folder / "report.json").string());
  if (!view) return failure(view.error());
  const auto figures = all_figures(*view);
  if (auto made = make_folder(folder / "figures"); !made) return made;
  for (const ReportFigure& figure : figures) {
    if (auto written = write_whole(folder / "figures" / (figure.id + ".svg"), figure.svg); !written) return written;
  }
  return write_whole(folder / "report.html", html_of(*view, figures));
}

}  // namespace

Result<void> write_report(const std::string& report_json_text, const std::string& folder) {
  if (auto written = write_views(report_json_text, folder); !written) return written;
  return write_whole(fs::path(folder) / "report.json", report_json_text);
}

Result<void> rebuild_report(const std::string& folder) {
  const fs::path path = fs::path(folder) / "report.json";
  std::ifstream file(path, std::ios::binary);
  if (!file) return failure(FaultKind::storage, path.string(), "cannot be opened");
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (file.bad()) return failure(FaultKind::storage, path.string(), "cannot be read");
  return write_views(text, folder);
}

}  // namespace gyrotherm
