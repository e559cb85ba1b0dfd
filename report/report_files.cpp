// SPDX-License-Identifier: Apache-2.0
#include "report/report_files.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "core/file.hpp"
#include "core/json.hpp"
#include "core/sha256.hpp"
#include "core/text.hpp"

namespace gyrotherm::report {
namespace {

constexpr const char* kStatusEnd = ".status";

bool is_file_in(const std::string& folder, const std::string& name) {
  std::error_code error;
  return std::filesystem::is_regular_file(std::filesystem::path(folder) / name, error);
}

}  // namespace

void describe(auto& form, Like<IssuedFile> auto& file) {
  form("name", file.name);
  form.expect("name", !file.name.empty() && file.name.find('/') == std::string::npos,
              "expected the name of a file, without its folder");
  form("sha256", file.sha256);
}

void describe(auto& form, Like<AuthorisedFiles> auto& authorisation) {
  form("number", authorisation.number);
  form("name", authorisation.authorised.name);
  form("utc", authorisation.authorised.utc);
  form("program_version", authorisation.program_version);
  form.if_present("sources_compared", authorisation.sources_compared, authorisation.sources_compared);
  form("files", authorisation.files);
  std::set<std::string> names;
  for (const IssuedFile& file : authorisation.files) names.insert(file.name);
  form.expect("files", names.size() == authorisation.files.size(), "a file is listed twice");
  form.expect("files", names.contains(kCalibrationFile), "calibration.json is missing");
}

Result<FiledReport> read_filed_report(const std::string& path) {
  const auto text = read_text_file(path, kLargestTable);
  if (!text) return failure(text.error());
  auto report = calibration_from_json(*text, path);
  if (!report) return failure(report.error());
  return FiledReport{std::move(*report), path, gyrotherm::sha256(*text)};
}

Result<void> replace_all(const std::string& folder, const std::vector<NewFile>& files) {
  const auto beside = [&](const NewFile& file) { return folder + "/" + file.name + ".new"; };
  Result<void> done;
  std::vector<NewFile> written;
  for (const NewFile& file : files) {
    if (done = replace_text_file(beside(file), file.bytes); !done) break;
    written.push_back(file);
  }
  for (const NewFile& file : written) {
    std::error_code error;
    const std::string path = folder + "/" + file.name;
    if (done) std::filesystem::rename(beside(file), path, error);
    if (error) done = failure(FaultKind::storage, path, "cannot be written: " + error.message());
    if (!done) std::filesystem::remove(beside(file), error);
  }
  const Descriptor place(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (place.is_open()) ::fsync(place.number());
  return done;
}

AuthorisedFiles make_authorisation(const CalibrationReport& report, const std::vector<NewFile>& files,
                                   const std::string& program_version, bool sources_compared) {
  AuthorisedFiles all{.number = report.number,
                      .authorised = report.authorised.value_or(Authorisation{}),
                      .program_version = program_version,
                      .sources_compared = sources_compared};
  for (const NewFile& file : files) all.files.push_back({file.name, sha256(file.bytes)});
  std::ranges::sort(all.files, {}, &IssuedFile::name);
  return all;
}

std::string to_json(const AuthorisedFiles& files) {
  Json json{{"schema", kAuthorisationSchema}};
  json.update(make_json(files));
  return json_text(json, 1) + "\n";
}

Result<AuthorisedFiles> authorised_files_from_json(std::string_view json, const std::string& file) {
  const auto place = JsonNode::parse(json, file);
  if (!place) return failure(place.error());
  if (const std::string schema = (*place)["schema"].text(); schema != kAuthorisationSchema)
    (*place)["schema"].note_error(fmt::format("\"{}\", expected \"{}\"", schema, kAuthorisationSchema));
  AuthorisedFiles files;
  read_json(*place, files);
  if (auto verdict = place->verdict(); !verdict) return failure(verdict.error());
  return files;
}

std::string text(const FolderDifferences& differences) {
  std::vector<std::string> parts;
  const auto add = [&](const char* what, const std::vector<std::string>& names) {
    if (!names.empty()) parts.push_back(plain(fmt::format("{} {}", what, fmt::join(names, ", "))));
  };
  add("changed", differences.changed);
  add("missing", differences.missing);
  add("not part of the report", differences.foreign);
  return fmt::format("{}", fmt::join(parts, "; "));
}

bool is_symbolic_link(const std::string& path) {
  std::error_code error;
  return std::filesystem::is_symlink(path, error);
}

bool has_name_in_text(const UsedFile& file) {
  return file.role == "profile" || file.role == "rig" || file.role == "column_map";
}

bool may_be_used_file(const std::string& name, const std::function<std::string()>& digest, const UsedFile& file,
                      const std::vector<UsedFile>& all) {
  const auto is_other = [&](const UsedFile& one) { return one.name == name && one.sha256 != file.sha256; };
  if (has_name_in_text(file) && !name.ends_with(".toml")) return digest() == file.sha256;
  if (std::ranges::none_of(all, is_other)) return true;
  const std::string own = digest();
  return std::ranges::none_of(all, [&](const UsedFile& one) { return is_other(one) && one.sha256 == own; });
}

std::vector<std::string> find_unsigned_entries(const std::string& folder, const std::vector<UsedFile>& used) {
  std::vector<std::string> found;
  for (const UsedFile& file : used)
    if (file.role == "record" && is_file_in(folder, file.name) && is_file_in(folder, file.name + kStatusEnd))
      found.push_back(file.name + kStatusEnd);
  std::ranges::sort(found);
  return found;
}

std::vector<std::string> find_unlisted_entries(const std::string& folder, const std::vector<std::string>& names,
                                               const std::vector<UsedFile>& used) {
  std::set<std::string> known(names.begin(), names.end());
  for (const UsedFile& file : used) {
    const auto digest = [&] { return sha256(read_text_file(folder + "/" + file.name, kLargestTable).value_or("")); };
    const bool is_there = is_file_in(folder, file.name) && may_be_used_file(file.name, digest, file, used);
    if (is_there) known.insert(file.name);
    if (is_there && file.role == "record") known.insert({file.name + ".sha256", file.name + kStatusEnd});
    if (!is_there && has_name_in_text(file)) known.insert(file.name + ".toml");
  }
  std::vector<std::string> foreign;
  for (const auto& path : list_folder(folder))
    if (const std::string name = path.filename().string(); !known.contains(name)) foreign.push_back(name);
  std::ranges::sort(foreign);
  return foreign;
}

FolderDifferences compare_folder(const std::string& folder, const std::vector<IssuedFile>& files,
                                 const std::vector<UsedFile>& used, const std::vector<std::string>& beside) {
  FolderDifferences found;
  std::vector<std::string> names = beside;
  for (const IssuedFile& file : files) {
    names.push_back(file.name);
    const std::string path = folder + "/" + file.name;
    const auto bytes = read_text_file_if_any(path, kLargestTable);
    if (is_symbolic_link(path)) {
      found.changed.push_back(file.name);
    } else if (bytes && !*bytes) {
      found.missing.push_back(file.name);
    } else if (!bytes || sha256(**bytes) != file.sha256) {
      found.changed.push_back(file.name);
    }
  }
  for (auto* list : {&found.changed, &found.missing}) std::ranges::sort(*list);
  found.foreign = find_unlisted_entries(folder, names, used);
  return found;
}

}  // namespace gyrotherm::report
