// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/report/used_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "acquisition/record/chain.hpp"
#include "acquisition/record/record.hpp"
#include "acquisition/record/record_files.hpp"
#include "apps/gyrotherm/qualify/axis_experiment.hpp"
#include "core/file.hpp"
#include "core/text.hpp"

namespace gyrotherm::app {
namespace {

using report::Check;

/// Counts the files of a record, including its parts, that the report names.
int count_named_files(const report::CalibrationReport& report, const std::string& record) {
  return 1 + static_cast<int>(std::ranges::count_if(report.files, [&](const report::UsedFile& file) {
           const auto part = record::part_name(file.name);
           return file.role == "record_part" && part && part->record == record;
         }));
}

/// Returns whether the digest of a record's rows is the one that the report names. Early builds exported rows without
/// the lists of thermometers, so a report of such a build has the digest of that table.
bool has_rows(const std::string& path, const std::string& sha256) {
  auto record = record::read_record(path);
  if (!record) return false;
  if (digest_rows(*record) == sha256) return true;
  for (auto& unit : record->info.units) {
    unit.gradients.clear();
    unit.three_point.clear();
  }
  return digest_rows(*record) == sha256;
}

/// Returns what the report states differently from the header of a record; empty if they agree.
std::string find_false_claim(const record::RunInfo& info, const report::CalibrationReport& report) {
  if (record::is_simulated(info) && !report.simulated) return "is simulated, but the report is not marked as simulated";
  const record::UnitInfo* unit = record::find_unit(info, report.item.name);
  if (unit == nullptr) return plain(fmt::format("has no unit \"{}\"", report.item.name));
  for (const auto& [what, recorded, reported] :
       {std::tuple("model", &unit->model, &report.item.model),
        std::tuple("serial number", &unit->serial_number, &report.item.serial_number)})
    if (!recorded->empty() && *recorded != *reported)
      return plain(fmt::format("contains the {} \"{}\", but the report \"{}\"", what, *recorded, *reported));
  return {};
}

/// Returns the mark of a simulated record, which names the virtual instruments of a real rig.
std::string simulation_note(const record::RunInfo& info) {
  if (!record::is_simulated(info)) return {};
  return info.virtual_rig ? "; SIMULATED" : "; SIMULATED: " + record::describe_simulation(info);
}

Check check_record(const report::CalibrationReport& report, const report::UsedFile& file, const std::string& path,
                   bool has_bytes) {
  using enum Check::Outcome;
  const auto verified = record::verify_record(path);
  if (!verified) return {file.name, fails, text(verified.error())};
  if (!has_bytes && !has_rows(path, file.sha256))
    return {file.name, fails, "is not the file on which the report is based"};
  if (const int named = count_named_files(report, file.name); has_bytes && verified->files != named)
    return {file.name, fails, fmt::format("has {} files, but the report names {}", verified->files, named)};
  const auto info = record::read_info(path);
  if (!info) return {file.name, fails, text(info.error())};
  if (const std::string claim = find_false_claim(*info, report); !claim.empty()) return {file.name, fails, claim};
  return {file.name, holds,
          fmt::format("is the file on which the report is based, and all of its {} rows are unchanged{}",
                      verified->rows, simulation_note(*info))};
}

/// Returns the files in a folder that have the name of a used file and may be this file.
std::vector<std::string> list_candidates(const std::string& folder, const report::UsedFile& file,
                                         const std::vector<report::UsedFile>& all) {
  const std::filesystem::path wanted = file.name;
  if (file.name.empty() || wanted.is_absolute() || std::ranges::find(wanted, "..") != wanted.end()) return {};
  std::vector<std::string> names{file.name}, found;
  if (report::has_name_in_text(file)) names.push_back(file.name + ".toml");
  std::error_code error;
  for (const std::string& name : names) {
    const auto path = std::filesystem::path(folder) / name;
    const auto digest = [&] { return record::file_digest(path.string()).value_or(""); };
    if (std::filesystem::is_regular_file(path, error) && report::may_be_used_file(name, digest, file, all))
      found.push_back(path.string());
  }
  return found;
}

/// Returns a TOML file of a folder with the digest of a used file that is named in its text; empty if there is none.
std::string find_named_in_text(const std::string& folder, const report::UsedFile& file) {
  if (!report::has_name_in_text(file)) return {};
  for (const auto& path : list_folder(folder))
    if (path.extension() == ".toml" && record::file_digest(path.string()) == file.sha256) return path.string();
  return {};
}

/// Returns true if the path is in the folder of the report.
bool is_in_own_folder(const SearchFolders& folders, const std::string& path) {
  return path.starts_with(folders.own + "/");
}

}  // namespace

SearchFolders search_folders(const std::string& folder, const std::vector<std::string>& given) {
  std::error_code error;
  const std::filesystem::path here = (std::filesystem::absolute(folder, error) / "").lexically_normal().parent_path();
  SearchFolders all{.own = here.string(), .others = given, .distant = here.parent_path().parent_path().string()};
  all.others.push_back(here.parent_path().string());
  return all;
}

std::string find_used_file(const SearchFolders& folders, const report::UsedFile& file,
                           const std::vector<report::UsedFile>& all) {
  const auto has_digest = [&](const std::string& path) { return record::file_digest(path) == file.sha256; };
  if (const auto own = list_candidates(folders.own, file, all); !own.empty()) return own.front();
  std::string first;
  for (const std::string& folder : folders.others)
    for (const std::string& path : list_candidates(folder, file, all)) {
      if (has_digest(path)) return path;
      if (first.empty()) first = path;
    }
  for (const std::string& path : list_candidates(folders.distant, file, all))
    if (has_digest(path)) return path;
  for (const std::string& folder : folders.others)
    if (auto path = find_named_in_text(folder, file); !path.empty()) return path;
  return first;
}

Check check_used_file(const SearchFolders& folders, const report::CalibrationReport& report,
                      const report::UsedFile& file) {
  using enum Check::Outcome;
  const std::string path = find_used_file(folders, file, report.files);
  if (path.empty()) return {file.name, not_there, "was not found; not checked"};
  const auto digest = record::file_digest(path);
  const bool has_bytes = digest && *digest == file.sha256;
  if (file.role == "record") return check_record(report, file, path, has_bytes);
  // A file that is named in its text may have any file name, so another file may have its name.
  if (!has_bytes && report::has_name_in_text(file) && !is_in_own_folder(folders, path))
    return {file.name, not_there, fmt::format("was not found; {} is another file; not checked", plain(path))};
  if (!has_bytes) return {file.name, fails, "is not the file on which the report is based"};
  return {file.name, holds, "is the file on which the report is based"};
}

}  // namespace gyrotherm::app
