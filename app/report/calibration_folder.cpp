// SPDX-License-Identifier: Apache-2.0
#include "app/report/calibration_folder.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <utility>

#include "core/file.hpp"
#include "core/process.hpp"
#include "core/sha256.hpp"
#include "report/calibration_csv.hpp"
#include "report/calibration_html.hpp"
#include "report/comparison_document.hpp"
#include "report/dcc.hpp"
#include "report/document.hpp"
#include "report/other_program.hpp"

namespace gyrotherm::app {
namespace {

constexpr const char* kPdfProgram = "gyrotherm-pdf";

/// "calibration.html", "calibration.de.html".
std::string name_in(const std::string& language, const std::string& extension,
                    const std::string& stem = "calibration") {
  return fmt::format("{}{}.{}", stem, language == "en" ? "" : "." + language, extension);
}

report::Language language_of(const std::string& code) {
  return code == "de" ? report::Language::german : report::Language::english;
}

Result<void> make_folder(const std::string& folder) {
  std::error_code trouble;
  std::filesystem::create_directories(folder, trouble);
  return trouble ? Result<void>(failure(FaultKind::storage, folder, trouble.message())) : Result<void>{};
}

/// A program of its own sets it: this one, which commands chambers, has no windows and no fonts.
Result<void> write_pdf(const std::string& folder, const std::string& language) {
  const std::string pdf = folder + "/" + name_in(language, "pdf");
  const auto ran =
      report::run_program(program_beside_this_one(kPdfProgram),
                          {folder + "/" + report::kCalibrationFile, "--language", language, "--out", pdf, "--force"});
  if (!ran) return failure(ran.error());
  if (ran->exit_code != 0) return failure(FaultKind::storage, pdf, ran->out);
  return {};
}

Result<void> write_view(Console& console, const std::string& path, const std::string& text) {
  if (auto written = replace_text_file(path, text); !written) return written;
  console.say(path);
  return {};
}

Result<void> write_in(Console& console, const report::CalibrationReport& report, const std::string& folder,
                      const std::string& language) {
  const auto document = document_of(report, language_of(language));
  if (auto written = write_view(console, folder + "/" + name_in(language, "html"), html_of(document)); !written)
    return written;
  if (auto written = write_pdf(folder, language); !written) return written;
  console.say(folder + "/" + name_in(language, "pdf"));
  return {};
}

}  // namespace

Result<FiledReport> load_calibration(const std::string& folder_or_file) {
  std::filesystem::path path = folder_or_file;
  if (std::filesystem::is_directory(path)) path /= report::kCalibrationFile;
  const auto text = read_text_file(path.string(), kLargestTable);
  if (!text) return failure(text.error());
  auto report = report::calibration_from_json(*text, path.string());
  if (!report) return failure(report.error());
  return FiledReport{std::move(*report), path.string(), sha256(*text)};
}

Result<void> write_calibration(Console& console, const report::CalibrationReport& report, const std::string& folder,
                               const std::vector<std::string>& languages) {
  if (auto made = make_folder(folder); !made) return made;
  const std::string json = to_json(report);
  const auto certificate = dcc_of(report, {.files = {{report::kCalibrationFile, sha256(json)}}});
  if (!certificate) return failure(certificate.error());
  for (const auto& [name, text] : {std::pair<const char*, std::string>{report::kCalibrationFile, json},
                                   {"calibration.csv", csv_of(report)},
                                   {report::kDccFile, *certificate}})
    if (auto written = write_view(console, folder + "/" + name, text); !written) return written;
  for (const std::string& language : languages)
    if (auto written = write_in(console, report, folder, language); !written) return written;
  return {};
}

Result<void> write_comparison(Console& console, const report::Comparison& comparison, const std::string& folder,
                              const std::vector<std::string>& languages) {
  if (auto made = make_folder(folder); !made) return made;
  if (auto written = write_view(console, folder + "/comparison.json", to_json(comparison)); !written) return written;
  for (const std::string& language : languages) {
    const std::string page = html_of(document_of(comparison, language_of(language)));
    if (auto written = write_view(console, folder + "/" + name_in(language, "html", "comparison"), page); !written)
      return written;
  }
  return {};
}

Result<void> keep_as_signed(Console& console, const std::string& folder) {
  const auto certificate = read_text_file_if_any(folder + "/" + report::kDccFile, kLargestTable);
  if (!certificate) return failure(certificate.error());
  if (!*certificate || (*certificate)->find("<ds:Signature") == std::string::npos) return {};
  const std::filesystem::path kept = std::filesystem::path(folder) / "as-signed";
  std::error_code trouble;
  std::filesystem::create_directory(kept, trouble);
  for (const std::filesystem::path& path : entries_of(folder))
    if (!trouble && std::filesystem::is_regular_file(path))
      std::filesystem::copy_file(path, kept / path.filename(), trouble);
  if (trouble) return failure(FaultKind::storage, kept.string(), trouble.message());
  console.say(kept.string());
  return {};
}

std::vector<std::string> languages_in(const std::string& folder) {
  std::vector<std::string> found;
  for (const char* language : {"en", "de"})
    if (std::filesystem::exists(folder + "/" + name_in(language, "html"))) found.emplace_back(language);
  return found;
}

}  // namespace gyrotherm::app
