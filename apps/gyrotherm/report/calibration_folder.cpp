// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/report/calibration_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <filesystem>
#include <sstream>
#include <system_error>
#include <utility>

#include "acquisition/record/chain.hpp"
#include "core/file.hpp"
#include "core/process.hpp"
#include "core/sha256.hpp"
#include "core/text.hpp"
#include "report/dcc.hpp"
#include "report/document.hpp"
#include "report/other_program.hpp"
#include "report/report_files.hpp"
#include "report/signed_report.hpp"

namespace gyrotherm::app {
namespace {

constexpr const char* kPdfProgram = "gyrotherm-pdf";
/// A report has a language if it has one of these views in it: the other one may have been deleted.
constexpr auto kViewExtensions = {"html", "pdf"};
/// A remark of paper.py on characters without a font or on a refused logo contains this word.
constexpr const char* kOmission = " omitted";

struct RenderedPdf {
  std::string bytes;
  /// Each names the view: "calibration.pdf: no installed font has U+4E2D; …".
  std::vector<std::string> remarks;
};

/// The files of a report, and the remarks on its PDFs.
struct RenderedReport {
  std::vector<report::NewFile> files;
  std::vector<std::string> remarks;
};

/// Returns "calibration.html" or "calibration.de.html".
std::string view_name(const std::string& language, const std::string& extension,
                      const std::string& stem = "calibration") {
  return fmt::format("{}{}.{}", stem, language == "en" ? "" : "." + language, extension);
}

report::Language parse_language(const std::string& code) {
  return code == "de" ? report::Language::german : report::Language::english;
}

Result<void> make_folder(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  return error ? Result<void>(failure(FaultKind::storage, folder, error.message())) : Result<void>{};
}

/// Returns the lines of gyrotherm-pdf, with the view instead of the program.
std::vector<std::string> read_remarks(const std::string& output, const std::string& view) {
  std::vector<std::string> remarks;
  std::istringstream lines(output);
  const std::string begin = std::string(kPdfProgram) + ": ";
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with(begin)) line.erase(0, begin.size());
    if (!line.empty()) remarks.push_back(plain(fmt::format("{}: {}", view, line)));
  }
  return remarks;
}

void print_warnings(Console& console, const std::vector<std::string>& remarks) {
  for (const std::string& remark : remarks) console.print_message("warning: " + remark);
}

/// Fails with bad_file at the folder if a PDF lacks characters or the logo, which the other views contain.
Result<void> check_is_whole(const std::vector<std::string>& remarks, const std::string& folder) {
  const auto omits = [](const std::string& remark) { return remark.find(kOmission) != std::string::npos; };
  const auto omission = std::ranges::find_if(remarks, omits);
  return omission == remarks.end() ? Result<void>{} : failure(FaultKind::bad_file, folder, *omission);
}

/// Runs gyrotherm-pdf and returns the PDF. Faults name the view. Only that separate program uses WeasyPrint, so
/// machines that write no reports do not need it.
Result<RenderedPdf> run_pdf_program(std::vector<std::string> arguments, const std::string& language,
                                    const std::string& view) {
  const auto folder = report::PrivateFolder::make();
  if (!folder) return failure(folder.error());
  const std::string pdf = *folder / view;
  arguments.insert(arguments.end(), {"--language", language, "--out", pdf});
  const auto ran = report::run_program(sibling_program_path(kPdfProgram), arguments, std::chrono::minutes(6));
  if (!ran) return failure(ran.error());
  if (ran->exit_code != 0) return failure(FaultKind::storage, view, ran->out);
  auto bytes = read_text_file(pdf, kLargestTable);
  if (!bytes) return failure(bytes.error().kind, view, bytes.error().what);
  return RenderedPdf{std::move(*bytes), read_remarks(ran->out, view)};
}

Result<RenderedPdf> render_pdf(const std::string& json, const std::string& language) {
  const auto folder = report::PrivateFolder::make();
  if (!folder) return failure(folder.error());
  const std::string source = *folder / report::kCalibrationFile;
  if (auto put = replace_own_file(source, json, Syncing::not_awaited); !put) return failure(put.error());
  return run_pdf_program({source}, language, view_name(language, "pdf"));
}

Result<RenderedPdf> render_comparison_pdf(const ComparedFiles& files, const std::string& language) {
  std::vector<std::string> arguments{files.now, "--compared-with", files.before};
  if (!files.history.empty()) arguments.insert(arguments.end(), {"--check-standard", files.history});
  return run_pdf_program(std::move(arguments), language, view_name(language, "pdf", "comparison"));
}

Result<void> write_view(Console& console, const std::string& path, const std::string& text) {
  if (auto written = replace_text_file(path, text); !written) return written;
  console.print_message(path);
  return {};
}

/// Renders all files of a report. Its source, calibration.json, is the last one, because it contains the state.
Result<RenderedReport> render_files(const report::CalibrationReport& report,
                                    const std::vector<std::string>& languages) {
  const std::string json = to_json(report);
  auto certificate = make_dcc(report, {.files = {{report::kCalibrationFile, sha256(json)}}});
  if (!certificate) return failure(certificate.error());
  RenderedReport rendered;
  auto& files = rendered.files;
  files = {{"calibration.csv", results_to_csv(report)}, {report::kDccFile, std::move(*certificate)}};
  for (const std::string& language : languages) {
    auto pdf = render_pdf(json, language);
    if (!pdf) return failure(pdf.error());
    files.push_back({view_name(language, "html"), to_html(make_document(report, parse_language(language)))});
    files.push_back({view_name(language, "pdf"), std::move(pdf->bytes)});
    rendered.remarks.insert(rendered.remarks.end(), pdf->remarks.begin(), pdf->remarks.end());
  }
  files.push_back({report::kCalibrationFile, json});
  return rendered;
}

}  // namespace

Result<void> check_report_folder(const std::string& folder) {
  std::error_code error;
  if (std::filesystem::is_directory(folder, error)) return {};
  const bool is_there = std::filesystem::exists(folder, error);
  return failure(FaultKind::bad_file, folder,
                 is_there ? "is a file, expected the folder of a report" : "no such folder, expected that of a report");
}

Result<FiledReport> load_calibration(const std::string& folder_or_file) {
  const std::filesystem::path path = folder_or_file;
  return report::read_filed_report(
      (std::filesystem::is_directory(path) ? path / report::kCalibrationFile : path).string());
}

Result<void> check_is_unchanged(Console& console, const FiledReport& filed, WithoutDigest without_digest) {
  const std::string folder = std::filesystem::absolute(filed.path).parent_path().string();
  const auto expected = report::find_expected_digest(folder);
  if (!expected) return failure(expected.error());
  if (expected->empty() && without_digest == WithoutDigest::refused)
    return failure(FaultKind::bad_file, filed.path,
                   fmt::format("is authorised, but {} is missing, so nobody can tell whether it was changed",
                               report::kAuthorisationFile));
  if (filed.report.state == report::ReportState::superseded || expected->empty()) return {};
  if (filed.sha256 != *expected)
    return failure(FaultKind::bad_file, filed.path, "was changed after it was authorised or signed");
  if (report::is_signed(folder).value_or(false))
    console.print_message(filed.path + ": has the signed digest; \"report verify\" verifies the signature");
  return {};
}

Result<void> write_calibration(Console& console, const report::CalibrationReport& report, const std::string& folder,
                               const std::vector<std::string>& languages, bool sources_compared) {
  if (auto made = make_folder(folder); !made) return made;
  auto rendered = render_files(report, languages);
  if (!rendered) return failure(rendered.error());
  auto& files = rendered->files;
  if (report.state == report::ReportState::authorised) {
    if (auto whole = check_is_whole(rendered->remarks, folder); !whole) return whole;
    files.insert(files.end() - 1, {report::kAuthorisationFile,
                                   to_json(make_authorisation(report, files, GYROTHERM_VERSION, sources_compared))});
  }
  if (auto put = report::replace_all(folder, files); !put) return put;
  console.print_message(folder + "/" + report::kCalibrationFile);
  for (std::size_t i = 0; i + 1 < files.size(); ++i) console.print_message(folder + "/" + files[i].name);
  print_warnings(console, rendered->remarks);
  return {};
}

Result<std::vector<report::NewFile>> render_calibration(const report::CalibrationReport& report,
                                                        const std::vector<std::string>& names) {
  std::vector<std::string> languages;
  for (const char* language : {"en", "de"})
    if (std::ranges::any_of(kViewExtensions, [&](const char* extension) {
          return std::ranges::find(names, view_name(language, extension)) != names.end();
        }))
      languages.emplace_back(language);
  auto rendered = render_files(report, languages);
  if (!rendered) return failure(rendered.error());
  if (auto whole = check_is_whole(rendered->remarks, report.number); !whole) return failure(whole.error());
  return std::move(rendered->files);
}

Result<void> write_comparison(Console& console, const report::Comparison& comparison, const ComparedFiles& files,
                              const std::string& folder, const std::vector<std::string>& languages) {
  if (auto made = make_folder(folder); !made) return made;
  if (auto written = write_view(console, folder + "/comparison.json", to_json(comparison)); !written) return written;
  for (const std::string& language : languages) {
    const std::string page = to_html(make_document(comparison, parse_language(language)));
    if (auto written = write_view(console, folder + "/" + view_name(language, "html", "comparison"), page); !written)
      return written;
    const auto pdf = render_comparison_pdf(files, language);
    if (!pdf) return failure(pdf.error());
    if (auto written = write_view(console, folder + "/" + view_name(language, "pdf", "comparison"), pdf->bytes);
        !written)
      return written;
    print_warnings(console, pdf->remarks);
  }
  return {};
}

namespace {

/// Writes the content of a file, or the entries of a folder, to the disk. Some file systems cannot sync a folder
/// (EINVAL).
Result<void> sync_path(const std::filesystem::path& path) {
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file.is_open() && (::fsync(file.number()) == 0 || errno == EINVAL)) return {};
  return failure(FaultKind::storage, path.string(), std::generic_category().message(errno));
}

/// Checks that a copy has every file of the folder, as it is or as it was signed, before the original is overwritten.
/// The signed digest counts too, because an interrupted command may have replaced the original.
Result<void> check_copy(const std::filesystem::path& folder, const std::filesystem::path& copy,
                        const std::vector<report::IssuedFile>& files) {
  for (const std::filesystem::path& path : list_folder(folder)) {
    if (!std::filesystem::is_regular_file(path)) continue;
    const std::string name = path.filename().string();
    const auto copied = record::file_digest((copy / name).string()), own = record::file_digest(path.string());
    const auto listed = std::ranges::find(files, name, &report::IssuedFile::name);
    const bool is_as_signed = copied && listed != files.end() && *copied == listed->sha256;
    if (is_as_signed || (copied && own && *copied == *own)) continue;
    return failure(FaultKind::storage, copy.string(), "is not a complete copy of the signed report; move it away");
  }
  return {};
}

/// Copies the files of a folder into an empty folder and syncs the copies.
Result<void> copy_files(const std::string& folder, const std::filesystem::path& copy) {
  for (const std::filesystem::path& path : list_folder(folder)) {
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) continue;
    const std::filesystem::path to = copy / path.filename();
    std::filesystem::copy_file(path, to, error);
    if (error) return failure(FaultKind::storage, to.string(), error.message());
    if (auto synced = sync_path(to); !synced) return synced;
  }
  return sync_path(copy);
}

}  // namespace

Result<void> copy_signed_report(Console& console, const std::string& folder) {
  const auto is_signed = report::is_signed(folder);
  if (!is_signed) return failure(is_signed.error());
  if (!*is_signed) return {};
  const auto files = report::list_signed_files(folder);
  if (!files) return failure(files.error());
  const std::filesystem::path kept = std::filesystem::path(folder) / report::kSignedCopyFolder,
                              begun = kept.string() + ".new";
  std::error_code error;
  if (std::filesystem::exists(kept, error)) return check_copy(folder, kept, *files);
  std::filesystem::remove_all(begun, error);
  if (!std::filesystem::create_directory(begun, error))
    return failure(FaultKind::storage, begun.string(), error.message());
  if (auto copied = copy_files(folder, begun); !copied) return copied;
  if (auto whole = check_copy(folder, begun, *files); !whole) return whole;
  std::filesystem::rename(begun, kept, error);
  if (error) return failure(FaultKind::storage, kept.string(), error.message());
  if (auto synced = sync_path(folder); !synced) return synced;
  console.print_message(kept.string());
  return {};
}

std::vector<std::string> languages_in(const std::string& folder) {
  std::vector<std::string> found;
  for (const char* language : {"en", "de"})
    if (std::ranges::any_of(kViewExtensions, [&](const char* extension) {
          return std::filesystem::exists(folder + "/" + view_name(language, extension));
        }))
      found.emplace_back(language);
  return found;
}

}  // namespace gyrotherm::app
