// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/report/draft_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "apps/gyrotherm/report/used_files.hpp"
#include "core/count_text.hpp"
#include "core/file.hpp"
#include "core/text.hpp"

namespace gyrotherm::app {
namespace {

/// Returns a path relative to the folder of the draft; empty for no path.
std::string path_from(const std::string& folder, const std::string& path) {
  if (path.empty()) return {};
  const auto absolute = [](const std::string& one) { return std::filesystem::absolute(one).lexically_normal(); };
  return absolute(path).lexically_relative(absolute(folder + "/.").parent_path()).string();
}

std::vector<std::string> paths_from(const std::string& folder, const std::vector<std::string>& paths) {
  std::vector<std::string> all;
  for (const std::string& path : paths) all.push_back(path_from(folder, path));
  return all;
}

/// Finds the sources of a draft: at the stored path, or by their names in the folders that are searched for the files
/// of a report.
class SourceFinder {
 public:
  explicit SourceFinder(const DraftCheckOptions& options)
      : folder_(options.folder), places_(search_folders(options.folder, options.records)) {}

  std::string find(const std::string& stored) {
    if (stored.empty()) return {};
    std::error_code error;
    const std::filesystem::path at = (std::filesystem::path(folder_) / stored).lexically_normal();
    if (std::filesystem::exists(at, error)) return at.string();
    std::vector<std::string> folders = places_.others;
    folders.push_back(places_.distant);
    for (const std::string& folder : folders)
      if (const auto path = std::filesystem::path(folder) / at.filename(); std::filesystem::exists(path, error))
        return path.string();
    missing_.push_back(plain(at.filename().string()));
    return {};
  }
  std::vector<std::string> find(const std::vector<std::string>& stored) {
    std::vector<std::string> all;
    for (const std::string& one : stored) all.push_back(find(one));
    return all;
  }
  [[nodiscard]] const std::vector<std::string>& missing() const { return missing_; }

 private:
  std::string folder_;
  SearchFolders places_;
  std::vector<std::string> missing_;
};

/// Reads sources.json of a folder; nothing if it is missing.
Result<std::optional<report::DraftSources>> read_sources(const std::string& folder) {
  const std::string path = folder + "/" + report::kSourcesFile;
  const auto json = read_text_file_if_any(path, kLargestTable);
  if (!json) return failure(json.error());
  if (!*json) return std::optional<report::DraftSources>();
  auto sources = report::draft_sources_from_json(**json, path);
  if (!sources) return failure(sources.error());
  return std::optional(std::move(*sources));
}

Result<report::LaboratoryFile> read_laboratory(const std::string& path) {
  const auto text = read_text_file(path);
  if (!text) return failure(text.error());
  return report::parse_laboratory(*text, path);
}

/// Compares a report with the one made again. State and authorisation are not data of the sources.
Result<void> compare_with_sources(const report::FiledReport& filed, report::CalibrationReport again) {
  constexpr std::size_t kMostKeys = 8;
  again.state = filed.report.state;
  again.authorised = filed.report.authorised;
  const auto changed = report::find_changed_keys(to_json(filed.report), to_json(again));
  if (!changed) return failure(changed.error());
  if (changed->empty()) return {};
  const std::vector<std::string> first(
      changed->begin(), changed->begin() + static_cast<std::ptrdiff_t>(std::min(kMostKeys, changed->size())));
  return failure(
      FaultKind::bad_file, filed.path,
      plain(fmt::format("differs from the report that its records, models, order and laboratory file yield "
                        "now, in {}{}; make the report again",
                        fmt::join(first, ", "),
                        changed->size() > kMostKeys ? fmt::format(" and {} more", changed->size() - kMostKeys) : "")));
}

/// Compares the files that are found with the report.
Result<void> compare_found_files(Console& console, const report::FiledReport& filed, const DraftCheckOptions& options) {
  const SearchFolders folders = search_folders(options.folder, options.records);
  for (const report::UsedFile& file : filed.report.files) {
    const report::Check check = check_used_file(folders, filed.report, file);
    if (report::is_failure(check.outcome)) return failure(FaultKind::bad_file, check.what, check.text);
    console.print_message(plain(fmt::format("{}: {}", check.what, check.text)));
  }
  return {};
}

Result<CheckedDraft> check_without_sources(Console& console, const report::FiledReport& filed,
                                           const DraftCheckOptions& options, const std::string& laboratory,
                                           const std::string& reason) {
  if (!options.without_sources)
    return failure(FaultKind::usage, filed.path,
                   reason +
                       "; name the folders of these files with --records, make the report again, or authorise it "
                       "unchecked with --without-sources");
  if (laboratory.empty())
    return failure(FaultKind::usage, "--laboratory", "name laboratory.toml, which gives persons the role authorising");
  auto read = read_laboratory(laboratory);
  if (!read) return failure(read.error());
  if (auto same = compare_found_files(console, filed, options); !same) return failure(same.error());
  console.print_message(plain(fmt::format(
      "WARNING: {}: the report is authorised without a comparison with its sources, which authorisation.json states",
      reason)));
  return CheckedDraft{std::move(*read), false};
}

/// Fails if a draft was changed after the program wrote it. Does not check a report in another state.
Result<void> check_digest(const report::FiledReport& filed, const report::DraftSources& sources) {
  if (filed.report.state != report::ReportState::draft || filed.sha256 == sources.calibration_sha256) return {};
  return failure(FaultKind::bad_file, filed.path,
                 "was changed after the program wrote it (sources.json); make the report again");
}

}  // namespace

report::DraftSources name_sources(const CalibrationArguments& options, const std::string& folder,
                                  const std::string& unit, const std::string& calibration_sha256) {
  return {.program_version = GYROTHERM_VERSION,
          .calibration_sha256 = calibration_sha256,
          .unit = unit,
          .records = paths_from(folder, options.runs),
          .models_left = paths_from(folder, options.left),
          .models_found = paths_from(folder, options.found),
          .folder_left = path_from(folder, options.left_folder),
          .folder_found = path_from(folder, options.found_folder),
          .inputs = options.inputs,
          .laboratory = path_from(folder, options.laboratory),
          .order = path_from(folder, options.order),
          .check_standard = path_from(folder, options.check_standard),
          .unverified = options.unverified};
}

Result<CheckedDraft> check_draft(Console& console, const report::FiledReport& filed, const DraftCheckOptions& options) {
  const auto contradictions = report::find_contradictions(filed.report);
  if (!contradictions.empty())
    return failure(FaultKind::bad_file, filed.path,
                   fmt::format("contradicts itself: {}; make the report again", fmt::join(contradictions, "; ")));
  const auto sources = read_sources(options.folder);
  if (!sources) return failure(sources.error());
  if (!*sources)
    return check_without_sources(console, filed, options, options.laboratory,
                                 "cannot be compared with its sources, because sources.json is missing");
  if (auto as_written = check_digest(filed, **sources); !as_written) return failure(as_written.error());
  SourceFinder finder(options);
  CalibrationArguments again{.runs = finder.find((*sources)->records),
                             .left = finder.find((*sources)->models_left),
                             .found = finder.find((*sources)->models_found),
                             .left_folder = finder.find((*sources)->folder_left),
                             .found_folder = finder.find((*sources)->folder_found),
                             .inputs = (*sources)->inputs,
                             .unit = (*sources)->unit,
                             .laboratory = options.laboratory,
                             .order = finder.find((*sources)->order),
                             .out = {},
                             .check_standard = finder.find((*sources)->check_standard),
                             .unverified = (*sources)->unverified};
  if (again.laboratory.empty()) again.laboratory = finder.find((*sources)->laboratory);
  if (!finder.missing().empty())
    return check_without_sources(
        console, filed, options, again.laboratory,
        fmt::format("cannot be compared with its sources: not found: {}", fmt::join(finder.missing(), ", ")));
  auto made = make_calibration(console, again, (*sources)->unit);
  if (!made) return failure(made.error());
  if (auto same = compare_with_sources(filed, std::move(*made)); !same) return failure(same.error());
  auto laboratory = read_laboratory(again.laboratory);
  if (!laboratory) return failure(laboratory.error());
  console.print_message(
      plain(fmt::format("{}: is what {}, {}, {} and {} yield", filed.path, fmt::join(again.runs, ", "),
                        format_count((*sources)->models_left.size(), "model"), again.order, again.laboratory)));
  return CheckedDraft{std::move(*laboratory), true};
}

}  // namespace gyrotherm::app
