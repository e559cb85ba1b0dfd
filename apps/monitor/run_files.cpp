// SPDX-License-Identifier: Apache-2.0
/// Answers with the profile and the files of a run.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "acquisition/record/decision.hpp"
#include "acquisition/record/record_files.hpp"
#include "acquisition/record/run_source.hpp"
#include "apps/monitor/http_message.hpp"
#include "apps/monitor/run_answers.hpp"
#include "core/file.hpp"
#include "core/json.hpp"
#include "sequencer/profile/profile.hpp"
#include "sequencer/profile/released_blocks.hpp"
#include "sequencer/profile/warm_up.hpp"

namespace gyrotherm::monitor {
namespace {

namespace fs = std::filesystem;

/// Returns the time of an event in ms, or null if it is unknown.
Json event_ms(std::int64_t utc_ns) {
  return utc_ns > 0 ? Json(std::llround(static_cast<double>(utc_ns) / 1e6)) : Json(nullptr);
}

/// Returns the slot and the time at which each segment has begun so far.
Json segment_starts(const FoundRun& run) {
  Json begun = Json::array();
  const auto events =
      record::find_source_files(run.path, run.is_running()).and_then([&](const record::RecordFiles& files) {
        return record::each_row(
            files,
            {.what = "slot, segment, utc_ns", .table = "(SELECT * FROM event WHERE kind = 'segment')", .order = "id"},
            [&](const record::Statement& row) {
              if (!row.null(1))
                begun.push_back(
                    {{"segment", row.integer(1)}, {"slot", row.integer(0)}, {"utc_ms", event_ms(row.integer(2))}});
              return begun.size() < 20'000;
            });
      });
  return events ? begun : Json::array();
}

}  // namespace

namespace {

/// Returns the goal of a run that ends by itself, and its decisions so far; null for another run.
Json goal_json(const FoundRun& run, const profile::Profile& profile) {
  if (!run.info->goal || !profile.until) return nullptr;
  Json decisions = Json::array();
  const auto read =
      record::find_source_files(run.path, run.is_running()).and_then([&](const record::RecordFiles& files) {
        return record::each_row(files,
                                {.what = "slot, text, utc_ns",
                                 .table = fmt::format("(SELECT * FROM event WHERE {})", record::kIsDecision),
                                 .order = "id"},
                                [&](const record::Statement& row) {
                                  const auto decision = record::parse_decision(row.text(1));
                                  if (!decision) return true;
                                  auto json = Json(make_json(*decision));
                                  json["slot"] = row.integer(0);
                                  json["utc_ms"] = event_ms(row.integer(2));
                                  decisions.push_back(std::move(json));
                                  return decisions.size() < 20'000;
                                });
      });
  return {{"u_deg_per_h", run.info->goal->u_deg_per_h},
          {"mission", run.info->goal->mission_name},
          {"longest_s", to_seconds(profile.until->longest)},
          {"decisions", read ? std::move(decisions) : Json::array()}};
}

}  // namespace

WebAnswer profile_answer(const FoundRun& run) {
  if (!run.info || run.info->imported) return refusal(404, "the run has no profile");
  auto profile = profile::parse_profile(run.info->profile_text, run.info->profile_name);
  if (!profile) return refusal(404, "the profile cannot be read: " + profile.error().what);
  if (const auto& added = run.info->warm_up)
    if (auto warm = add_warm_ups(*profile, {.at_least = added->at_least, .air = added->air, .rate = added->rate});
        !warm)
      return refusal(404, "the profile cannot be read: " + warm.error().what);
  if (auto grown = profile::add_blocks(*profile, run.info->added_blocks); !grown)
    return refusal(404, "the profile cannot be read: " + grown.error().what);
  const auto plan = profile::plan(*profile);
  Json segments = Json::array();
  for (std::size_t i = 0; i < plan.segments.size(); ++i) {
    const auto& planned = plan.segments[i];
    const auto& segment = profile->segments[i];
    // The record has the prompts of the executed profile: no person is asked for what a supply switches.
    const auto& prompt = i < run.info->segments.size() ? run.info->segments[i].prompt : segment.prompt;
    segments.push_back({{"name", segment.name},
                        {"kind", segment.kind == profile::SegmentKind::hold ? "hold" : "ramp"},
                        {"start_s", to_seconds(planned.start)},
                        {"duration_s", to_seconds(planned.duration)},
                        {"from_c", planned.from.value},
                        {"to_c", planned.to.value},
                        {"soak_band_k", segment.guaranteed_soak ? Json(segment.soak_band.value) : Json(nullptr)},
                        {"prompt", prompt}});
  }
  return {.body = json_text(Json{{"name", profile->name},
                                 {"title", profile->title},
                                 {"segments", std::move(segments)},
                                 {"begun", segment_starts(run)},
                                 {"goal", goal_json(run, *profile)}})};
}

namespace {

/// Folders that may contain reports: the record's folder, and these subfolders of it.
constexpr std::array kReportFolders{"", "report", "calibration"};
constexpr std::array kReports{
    "report.html",      "report.pdf",        "report.json",         "report.csv",         "dcc.xml",
    "calibration.html", "calibration.pdf",   "calibration.de.html", "calibration.de.pdf", "calibration.csv",
    "calibration.json", "authorisation.json"};

/// Returns whether read_head() accepts a request for a file of this name.
bool is_requestable(const std::string& name) {
  return name.find('\\') == std::string::npos && percent_decode(percent_encode(name)) == name;
}

/// Returns the files of a closed record: the record itself and its parts. Any user with write access to the folder can
/// change the list of parts in the status file, so only its file names are used, and only if they are names of parts.
std::vector<std::string> closed_record_files(const FoundRun& run) {
  std::vector<std::string> files{run.path};
  const fs::path record(run.path);
  for (const auto& listed : run.status.parts) {
    const auto part = record::part_name(fs::path(listed).filename().string());
    if (!part || part->record != record.filename()) continue;
    auto path = record::part_path(run.path, part->part);
    if (record::path_exists(path) && std::ranges::count(files, path) == 0) files.push_back(std::move(path));
  }
  return files;
}

/// Returns the name in the page and the path of each file that can be downloaded: the files of a closed record and the
/// reports. Does not follow links.
std::vector<std::pair<std::string, fs::path>> downloadable_files(const FoundRun& run) {
  std::vector<std::pair<std::string, fs::path>> files;
  std::error_code error;
  const auto add = [&](const std::string& name, const fs::path& path) {
    if (is_requestable(name) && fs::is_regular_file(fs::symlink_status(path, error))) files.emplace_back(name, path);
  };
  if (!run.is_running())
    for (const auto& path : closed_record_files(run)) {
      add(fs::path(path).filename().string(), path);
      add(fs::path(path).filename().string() + ".sha256", path + ".sha256");
    }
  for (const auto* name : kReportFolders) {
    const auto folder = fs::path(run.path).parent_path() / name;
    if (*name != 0 && !fs::is_directory(fs::symlink_status(folder, error))) continue;
    for (const auto* report : kReports) add(*name == 0 ? report : fmt::format("{}-{}", name, report), folder / report);
  }
  return files;
}

}  // namespace

WebAnswer files_answer(const FoundRun& run) {
  Json files = Json::array();
  std::error_code error;
  for (const auto& [name, path] : downloadable_files(run))
    files.push_back({{"name", name}, {"bytes", fs::file_size(path, error)}});
  return {.body = json_text(Json{{"files", std::move(files)}, {"running", run.is_running()}})};
}

namespace {

/// Returns the Content-Disposition of a file (RFC 6266). It contains the name twice: in UTF-8, and in ASCII for clients
/// that do not support UTF-8.
std::string content_disposition(const std::string& name) {
  std::string ascii;
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"') ascii += '\\';
    if (byte < 0x80)
      ascii += c;
    else if (byte >= 0xC0)
      ascii += '_';
  }
  return fmt::format("attachment; filename=\"{}\"; filename*=UTF-8''{}", ascii, percent_encode(name));
}

}  // namespace

/// The content type makes the browser save the file: a report must not be displayed as a page of the monitor.
WebAnswer file_answer(const FoundRun& run, const std::string& name) {
  const auto files = downloadable_files(run);
  const auto found = std::ranges::find_if(files, [&](const auto& file) { return file.first == name; });
  if (found == files.end()) return refusal(404, "the run has no file of this name");
  auto opened = open_regular_file(found->second.string(), Links::refused);
  if (!opened) return refusal(404, opened.error().what);
  WebAnswer answer{.type = "application/octet-stream", .stream_size = opened->size};
  answer.headers.emplace_back("Content-Disposition", content_disposition(name));
  if (opened->size == 0) return answer;
  answer.stream = [file = std::make_shared<RegularFile>(std::move(*opened))](const Send& send) {
    std::string piece(std::size_t{64} * 1024, '\0');
    for (std::uint64_t remaining = file->size; remaining > 0;) {
      const auto piece_size = std::min<std::uint64_t>(remaining, piece.size());
      const auto size = ::read(file->descriptor.number(), piece.data(), piece_size);
      if (size <= 0 || !send({piece.data(), static_cast<std::size_t>(size)})) return false;
      remaining -= static_cast<std::uint64_t>(size);
    }
    return true;
  };
  return answer;
}

}  // namespace gyrotherm::monitor
