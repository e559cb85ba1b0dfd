// SPDX-License-Identifier: Apache-2.0
#include "monitor/metrics.hpp"

#include <fmt/format.h>
#include <sys/statvfs.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <iterator>
#include <map>
#include <optional>

#include "core/text.hpp"

namespace gyrotherm::monitor {
namespace {

/// A label's value, as the format wants it: in UTF-8, or nothing of the whole text is read. A byte that is none is
/// U+FFFD, as in the other answers.
std::string escaped(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const auto size = character_size(text);
    const auto character = size > 0 ? text.substr(0, size) : std::string_view("\uFFFD");
    if (character == "\n")
      out += "\\n";
    else
      out.append(character == "\"" || character == "\\" ? "\\" : "").append(character);
    text.remove_prefix(std::max<std::size_t>(size, 1));
  }
  return out;
}

std::string labels_of(const FoundRun& run) {
  return fmt::format("run=\"{}\",rig=\"{}\",profile=\"{}\",simulated=\"{}\"", escaped(run.name),
                     escaped(run.info ? run.info->rig_name : ""), escaped(run.info ? run.info->profile_name : ""),
                     run.status.simulated ? 1 : 0);
}

std::optional<double> number_of(const std::optional<Celsius>& temperature) {
  return temperature ? std::optional(temperature->value) : std::nullopt;
}

struct Metric {
  const char* name;
  const char* help;
  std::optional<double> (*of)(const FoundRun& run);
};
constexpr std::array kMetrics{
    Metric{"gyrotherm_run_up", "Whether the program that carries the run out answers.",
           [](const FoundRun& run) -> std::optional<double> { return run.is_running() && !run.is_silent() ? 1 : 0; }},
    Metric{"gyrotherm_run_status_age_seconds", "Since the run's status was written.",
           [](const FoundRun& run) { return run.age_s; }},
    Metric{"gyrotherm_run_second", "The last second that has a sample.",
           [](const FoundRun& run) -> std::optional<double> { return static_cast<double>(run.status.slot); }},
    Metric{"gyrotherm_run_backlog_seconds", "Seconds that wait for the disk.",
           [](const FoundRun& run) -> std::optional<double> { return static_cast<double>(run.status.backlog_s); }},
    Metric{"gyrotherm_run_faults", "Readings that were faults, since the run started.",
           [](const FoundRun& run) -> std::optional<double> { return static_cast<double>(run.status.faults); }},
    Metric{"gyrotherm_run_faults_now", "Faults that stand now.",
           [](const FoundRun& run) -> std::optional<double> {
             return static_cast<double>(run.status.standing.faults_now.size());
           }},
    Metric{"gyrotherm_run_alarms", "Alarms that nobody has acknowledged.",
           [](const FoundRun& run) -> std::optional<double> { return static_cast<double>(run.status.alarms.size()); }},
    Metric{"gyrotherm_run_segment", "The segment of the profile, from 1.",
           [](const FoundRun& run) -> std::optional<double> { return run.status.segment_index + 1; }},
    Metric{"gyrotherm_run_segments", "The segments that the profile has.",
           [](const FoundRun& run) -> std::optional<double> { return run.status.segment_count; }},
    Metric{"gyrotherm_run_left_seconds", "Left if every soak counts from now on.",
           [](const FoundRun& run) -> std::optional<double> {
             return run.status.standing.time_left ? std::optional(to_seconds(*run.status.standing.time_left))
                                                  : std::nullopt;
           }},
    Metric{"gyrotherm_run_behind_plan_seconds", "That went by without the profile's clock.",
           [](const FoundRun& run) -> std::optional<double> {
             return run.status.standing.behind_plan ? std::optional(to_seconds(*run.status.standing.behind_plan))
                                                    : std::nullopt;
           }},
    Metric{"gyrotherm_run_set_point_celsius", "What the profile asks for.",
           [](const FoundRun& run) { return number_of(run.status.set_point); }},
    Metric{"gyrotherm_run_chamber_air_celsius", "The chamber's air.",
           [](const FoundRun& run) { return number_of(run.status.chamber_air); }}};

std::string head_of(const char* name, const char* help) {
  return fmt::format("# HELP {0} {1}\n# TYPE {0} gauge\n", name, help);
}

void add_metric(std::string& text, const Metric& metric, const std::vector<FoundRun>& runs) {
  std::string lines;
  for (const auto& run : runs)
    if (const auto value = metric.of(run); value && std::isfinite(*value))
      lines += fmt::format("{}{{{}}} {}\n", metric.name, labels_of(run), *value);
  if (!lines.empty()) text += head_of(metric.name, metric.help) + lines;
}

void add_states(std::string& text, const std::vector<FoundRun>& runs) {
  text += head_of("gyrotherm_run_state", "1 for the state that the run is in.");
  for (const auto& run : runs)
    for (const auto state : kRunStates)
      text += fmt::format("gyrotherm_run_state{{{},state=\"{}\"}} {}\n", labels_of(run), name(state),
                          run.status.standing.state == state ? 1 : 0);
}

void add_thermometers(std::string& text, const std::vector<FoundRun>& runs) {
  text += head_of("gyrotherm_run_thermometer_celsius", "What a thermometer reads, as read.");
  for (const auto& run : runs)
    for (const auto& [channel, reading] : run.status.thermometers)
      if (reading && std::isfinite(reading->value))
        text += fmt::format("gyrotherm_run_thermometer_celsius{{{},channel=\"{}\"}} {}\n", labels_of(run),
                            escaped(channel), reading->value);
}

void add_disks(std::string& text, const std::vector<FoundRun>& runs) {
  text += head_of("gyrotherm_disk_free_bytes", "Free where the run's record lies.");
  for (const auto& run : runs) {
    struct statvfs disk {};
    if (::statvfs(std::filesystem::path(run.path).parent_path().c_str(), &disk) == 0)
      text += fmt::format("gyrotherm_disk_free_bytes{{{}}} {}\n", labels_of(run), disk.f_bavail * disk.f_frsize);
  }
}

}  // namespace

std::string metrics_text(const std::vector<FoundRun>& runs, const OwnFigures& own) {
  std::vector<FoundRun> going_on;
  std::map<std::string, bool> names;  // of two runs of one name only the first has figures: labels must differ
  for (const auto& run : runs)
    if ((run.is_running() || run.was_left()) && names.emplace(labels_of(run), true).second) going_on.push_back(run);
  std::string text;
  for (const auto& metric : kMetrics) add_metric(text, metric, going_on);
  if (!going_on.empty()) {
    add_states(text, going_on);
    add_thermometers(text, going_on);
    add_disks(text, going_on);
  }
  const auto add = [&](const char* name, const char* help, auto value) {
    text += head_of(name, help) + fmt::format("{} {}\n", name, value);
  };
  add("gyrotherm_runs_going_on", "Runs that a program carries out.",
      std::ranges::count_if(going_on, &FoundRun::is_running));
  add("gyrotherm_runs_found", "Records in the monitor's folders.", runs.size());
  add("gyrotherm_monitor_watchers", "Pages that watch a run.", own.watchers);
  add("gyrotherm_monitor_cache_bytes", "Memory that holds overviews of runs.", own.cache_bytes);
  return text;
}

}  // namespace gyrotherm::monitor
