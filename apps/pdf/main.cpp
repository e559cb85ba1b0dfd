// SPDX-License-Identifier: Apache-2.0
/// gyrotherm-pdf: makes the PDF of a calibration report or of a comparison of two, or a PNG of a figure. paper.py
/// renders both.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <span>
#include <sstream>
#include <string>

#include "apps/pdf/paper_html.hpp"
#include "core/file.hpp"
#include "core/program_start.hpp"
#include "core/sha256.hpp"
#include "core/shipped.hpp"
#include "core/text.hpp"
#include "report/comparison.hpp"
#include "report/document.hpp"
#include "report/other_program.hpp"
#include "report/report_files.hpp"

namespace gyrotherm::pdf {
namespace {

/// Exit codes, with the same values as in gyrotherm.
enum class PdfExit : int { done = 0, usage = 2, file = 4 };

struct Arguments {
  std::string report, compared_with, history, language = "en", out, figure;
  int width_px = 1600;
  bool force = false;
};

void print_error(std::string_view message) { write_to_stderr(fmt::format("gyrotherm-pdf: {}\n", plain(message))); }

/// Returns midnight UTC of a day such as "2026-11-20", in s since 1970, or nothing if the text is not a day.
std::optional<std::int64_t> utc_midnight(const std::string& day) {
  int year{}, month{}, day_of_month{};
  if (day.size() != 10 || std::sscanf(day.c_str(), "%4d-%2d-%2d", &year, &month, &day_of_month) != 3)
    return std::nullopt;
  const std::chrono::year_month_day date{std::chrono::year(year), std::chrono::month(static_cast<unsigned>(month)),
                                         std::chrono::day(static_cast<unsigned>(day_of_month))};
  if (!date.ok()) return std::nullopt;
  return std::chrono::duration_cast<std::chrono::seconds>(std::chrono::sys_days(date).time_since_epoch()).count();
}

/// Returns the date of the PDF in s since 1970: SOURCE_DATE_EPOCH, the day of issue, or the last day of the
/// calibration, whichever is available first. The current time is not used, so the same report always gives the same
/// file.
std::optional<std::int64_t> pdf_date(const report::CalibrationReport& report) {
  if (const char* given = std::getenv("SOURCE_DATE_EPOCH"); given != nullptr) {
    std::int64_t seconds{};
    const std::string_view text = given;
    const auto read = std::from_chars(text.data(), text.data() + text.size(), seconds);
    constexpr std::int64_t kYear10000 = 253402300800;
    if (read.ec == std::errc{} && read.ptr == text.data() + text.size() && seconds >= 0 && seconds < kYear10000)
      return seconds;
  }
  const auto issued = utc_midnight(report.issued);
  return issued ? issued : utc_midnight(report.ended);
}

struct RenderedFile {
  std::string bytes;
  /// Warnings, one per line, for example about an omitted logo or missing glyphs.
  std::string remarks;
};

/// Returns the last line of the output. After a Python traceback, it is the error message.
std::string find_last_line(std::string text) {
  while (text.ends_with('\n')) text.pop_back();
  return text.substr(text.rfind('\n') + 1);
}

/// Runs paper.py on the text `input` in a folder that only this user can read. Faults name `input_file`, the file of
/// the user.
Result<RenderedFile> run_paper(const std::string& kind, const std::string& input, const std::string& input_file,
                               const std::string& option) {
  constexpr std::chrono::minutes kTimeout{5};
  const auto program = find_shipped_file("apps/pdf/paper.py");
  if (program.empty()) return failure(FaultKind::bad_file, "apps/pdf/paper.py", "is not installed");
  const auto folder = report::PrivateFolder::make();
  if (!folder) return failure(folder.error());
  const std::string source = *folder / "given", out = *folder / "made";
  if (auto written = replace_own_file(source, input, Syncing::not_awaited); !written) return failure(written.error());
  const auto ran = report::run_program(std::filesystem::absolute(program), {kind, source, out, option}, kTimeout);
  if (!ran) return failure(ran.error());
  if (ran->exit_code != 0) return failure(FaultKind::bad_file, input_file, find_last_line(ran->out));
  auto bytes = read_text_file(out, kLargestTable);
  if (!bytes) return failure(bytes.error());
  return RenderedFile{std::move(*bytes), ran->out};
}

report::Language chosen_language(const Arguments& arguments) {
  return arguments.language == "de" ? report::Language::german : report::Language::english;
}

Result<RenderedFile> render_report(const Arguments& arguments) {
  const auto filed = report::read_filed_report(arguments.report);
  if (!filed) return failure(filed.error());
  PaperFacts facts{
      .program = "gyrotherm " GYROTHERM_VERSION, .source_sha256 = filed->sha256, .utc_s = pdf_date(filed->report)};
  if (arguments.compared_with.empty()) {
    const bool is_authorised = filed->report.state == report::ReportState::authorised;
    return run_paper("pdf", paper_html(make_document(filed->report, chosen_language(arguments)), facts),
                     arguments.report, is_authorised ? "--signature-field" : "--plain");
  }
  const auto earlier = report::read_filed_report(arguments.compared_with);
  if (!earlier) return failure(earlier.error());
  const auto comparison = report::compare_files(*earlier, *filed, arguments.history);
  if (!comparison) return failure(comparison.error());
  facts.source_sha256 = sha256(to_json(*comparison));
  facts.source = "comparison.json";
  return run_paper("pdf", paper_html(make_document(*comparison, chosen_language(arguments)), facts), arguments.report,
                   "--plain");
}

Result<RenderedFile> render_figure(const Arguments& arguments) {
  const auto svg = read_text_file(arguments.figure, kLargestTable);
  if (!svg) return failure(svg.error());
  return run_paper("png", *svg, arguments.figure, std::to_string(arguments.width_px));
}

/// Checks that the output file may be written. Overwrites an existing file only with `force`, and only if it is empty,
/// a PDF or a PNG, so a record is never overwritten.
Result<void> check_output_path(const std::string& path, bool force) {
  if (std::error_code error; !std::filesystem::exists(path, error)) return {};
  if (!force) return failure(FaultKind::usage, path, "exists; --force overwrites it");
  const auto existing = read_text_file(path, kLargestTable);
  if (!existing) return failure(existing.error());
  if (existing->empty() || existing->starts_with("%PDF-") || existing->starts_with("\x89PNG")) return {};
  return failure(FaultKind::usage, path, "is neither a PDF nor a PNG; --force does not overwrite other files");
}

Result<void> write_output(const Arguments& arguments) {
  if (auto permitted = check_output_path(arguments.out, arguments.force); !permitted) return permitted;
  const auto made = arguments.figure.empty() ? render_report(arguments) : render_figure(arguments);
  if (!made) return failure(made.error());
  if (auto written = replace_text_file(arguments.out, made->bytes); !written) return written;
  std::istringstream remarks(made->remarks);
  for (std::string remark; std::getline(remarks, remark);) print_error(remark);
  return {};
}

int run(int argc, char** argv) {
  CLI::App app(
      "Example: gyrotherm-pdf calibration.json --language en --out report.pdf\n\n"
      "Writes a calibration report as PDF/A-1b on A4, ready to be signed; with --png, converts a figure to PNG.",
      "gyrotherm-pdf");
  Arguments arguments;
  app.set_version_flag("--version", "gyrotherm-pdf " GYROTHERM_VERSION);
  auto* report = app.add_option("report", arguments.report, "calibration.json of the report");
  auto* compared = app.add_option("--compared-with", arguments.compared_with,
                                  "calibration.json of an earlier report: write the PDF of the comparison");
  compared->needs(report);
  app.add_option("--check-standard", arguments.history, "history of check runs, for a comparison")->needs(compared);
  app.add_option("--language", arguments.language, "en or de")->check(CLI::IsMember({"en", "de"}));
  app.add_option("--png", arguments.figure, "SVG figure of gyrotherm to convert to PNG, instead of a report")
      ->excludes(report);
  app.add_option("--width", arguments.width_px, "width of the PNG in pixels")->check(CLI::Range(16, 20000));
  app.add_option("--out", arguments.out, "output file")->required();
  app.add_flag("--force", arguments.force, "overwrite an existing PDF or PNG");
  refuse_invalid_values(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    print_error(find_error_cause(error.what(), app, std::span(argv, static_cast<std::size_t>(argc))));
    return static_cast<int>(PdfExit::usage);
  }
  if (arguments.report.empty() && arguments.figure.empty()) {
    print_error("expected a calibration.json, or --png with a figure; see --help");
    return static_cast<int>(PdfExit::usage);
  }
  const auto made = write_output(arguments);
  if (made) return static_cast<int>(PdfExit::done);
  print_error(text(made.error()));
  return static_cast<int>(made.error().kind == FaultKind::usage ? PdfExit::usage : PdfExit::file);
}

}  // namespace
}  // namespace gyrotherm::pdf

int main(int argc, char** argv) {
  gyrotherm::open_standard_descriptors();
  return gyrotherm::pdf::run(argc, argv);
}
