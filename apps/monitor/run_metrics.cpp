// SPDX-License-Identifier: Apache-2.0
/// The metrics of the runs, for Prometheus.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "apps/monitor/run_answers.hpp"
#include "core/text.hpp"

namespace gyrotherm::monitor {
namespace {

/// Escapes the value of a label. The format requires UTF-8; a single invalid byte would make the whole text unreadable.
/// Invalid bytes become U+FFFD, as in the other answers.
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

std::string metric_labels(const FoundRun& run) {
  return fmt::format("run=\"{}\",rig=\"{}\",profile=\"{}\",simulated=\"{}\"", escaped(run.name),
                     escaped(run.info ? run.info->rig_name : ""), escaped(run.info ? run.info->profile_name : ""),
                     run.status.simulated ? 1 : 0);
}

std::optional<double> to_number(const std::optional<Celsius>& temperature) {
  return temperature ? std::optional(temperature->value) : std::nullopt;
}

/// Returns whether the run has not ended: a program executes it, or it was interrupted and can be resumed.
bool is_unfinished(const FoundRun& run) { return run.is_running() || run.was_abandoned(); }

/// Runs that have a metric. A program that does not answer has no current values, so some metrics are limited to
/// answering programs.
enum class MetricScope { answering, unfinished, all };

bool is_in_scope(MetricScope scope, const FoundRun& run) {
  switch (scope) {
    case MetricScope::answering: return run.is_running() && !run.is_silent();
    case MetricScope::unfinished: return is_unfinished(run);
    case MetricScope::all: return true;
  }
  return false;
}

struct Metric {
  const char* name;
  const char* help;
  MetricScope scope;
  std::optional<double> (*value)(const FoundRun& run);
};
constexpr std::array kMetrics{
    Metric{"gyrotherm_run_up", "1 if the program that executes the run answers, otherwise 0.", MetricScope::unfinished,
           [](const FoundRun& run) -> std::optional<double> { return run.is_running() && !run.is_silent() ? 1 : 0; }},
    Metric{"gyrotherm_run_status_age_seconds", "Time since the status of the run was written.", MetricScope::unfinished,
           [](const FoundRun& run) { return run.age_s; }},
    Metric{"gyrotherm_run_second", "Number of the last second with a sample.", MetricScope::unfinished,
           [](const FoundRun& run) -> std::optional<double> { return static_cast<double>(run.status.slot); }},
    Metric{"gyrotherm_run_alarms", "Unacknowledged alarms.", MetricScope::all,
           [](const FoundRun& run) -> std::optional<double> {
             return static_cast<double>(record::count_unacknowledged(run.status.alarms));
           }},
    Metric{"gyrotherm_run_backlog_seconds", "Seconds of samples that are not yet on the disk.", MetricScope::answering,
           [](const FoundRun& run) -> std::optional<double> { return static_cast<double>(run.status.backlog_s); }},
    Metric{"gyrotherm_run_faults_total", "Faulty readings since the start of the run.", MetricScope::answering,
           [](const FoundRun& run) -> std::optional<double> { return static_cast<double>(run.status.faults); }},
    Metric{"gyrotherm_run_faults_now", "Faults that are active now.", MetricScope::answering,
           [](const FoundRun& run) -> std::optional<double> {
             return static_cast<double>(run.status.standing.faults_now.size());
           }},
    Metric{"gyrotherm_run_segment", "Current segment of the profile, from 1.", MetricScope::answering,
           [](const FoundRun& run) -> std::optional<double> { return run.status.segment_index + 1; }},
    Metric{"gyrotherm_run_segments", "Number of segments of the profile.", MetricScope::answering,
           [](const FoundRun& run) -> std::optional<double> { return run.status.segment_count; }},
    Metric{"gyrotherm_run_left_seconds", "Remaining time if no soak is interrupted again.", MetricScope::answering,
           [](const FoundRun& run) -> std::optional<double> {
             return run.status.standing.time_left ? std::optional(to_seconds(*run.status.standing.time_left))
                                                  : std::nullopt;
           }},
    Metric{"gyrotherm_run_behind_plan_seconds", "Time for which the clock of the profile has been stopped.",
           MetricScope::answering,
           [](const FoundRun& run) -> std::optional<double> {
             return run.status.standing.behind_plan ? std::optional(to_seconds(*run.status.standing.behind_plan))
                                                    : std::nullopt;
           }},
    Metric{"gyrotherm_run_set_point_celsius", "Set point of the profile.", MetricScope::answering,
           [](const FoundRun& run) { return to_number(run.status.set_point); }},
    Metric{"gyrotherm_run_chamber_air_celsius", "Air temperature of the chamber.", MetricScope::answering,
           [](const FoundRun& run) { return to_number(run.status.chamber_air); }}};

/// Returns the head of a metric. A metric whose name ends in _total is a counter.
std::string metric_head(std::string_view name, const char* help) {
  return fmt::format("# HELP {0} {1}\n# TYPE {0} {2}\n", name, help, name.ends_with("_total") ? "counter" : "gauge");
}

void add(std::string& text, const char* name, const char* help, const std::string& lines) {
  if (!lines.empty()) text += metric_head(name, help) + lines;
}

void add_metric(std::string& text, const Metric& metric, const std::vector<FoundRun>& runs) {
  std::string lines;
  for (const auto& run : runs)
    if (const auto value = is_in_scope(metric.scope, run) ? metric.value(run) : std::nullopt;
        value && std::isfinite(*value))
      lines += fmt::format("{}{{{}}} {}\n", metric.name, metric_labels(run), *value);
  add(text, metric.name, metric.help, lines);
}

/// Adds the states. An ended run has its final state.
void add_states(std::string& text, const std::vector<FoundRun>& runs) {
  std::string lines;
  for (const auto& run : runs)
    if (is_in_scope(MetricScope::answering, run) || !is_unfinished(run))
      for (const auto state : kRunStates)
        lines += fmt::format("gyrotherm_run_state{{{},state=\"{}\"}} {}\n", metric_labels(run), name(state),
                             run.status.standing.state == state ? 1 : 0);
  add(text, "gyrotherm_run_state", "1 for the current state of the run, 0 for other states.", lines);
}

void add_thermometers(std::string& text, const std::vector<FoundRun>& runs) {
  std::string lines;
  for (const auto& run : runs)
    if (is_in_scope(MetricScope::answering, run))
      for (const auto& [channel, reading] : run.status.thermometers)
        if (reading && std::isfinite(reading->value))
          lines += fmt::format("gyrotherm_run_thermometer_celsius{{{},channel=\"{}\"}} {}\n", metric_labels(run),
                               escaped(channel), reading->value);
  add(text, "gyrotherm_run_thermometer_celsius", "Uncorrected reading of a thermometer.", lines);
}

void add_disks(std::string& text, const std::vector<FoundRun>& runs) {
  std::string lines;
  for (const auto& run : runs)
    if (is_in_scope(MetricScope::answering, run) && run.free_bytes)
      lines += fmt::format("gyrotherm_disk_free_bytes{{{}}} {}\n", metric_labels(run), *run.free_bytes);
  add(text, "gyrotherm_disk_free_bytes", "Free space on the disk of the record.", lines);
}

/// Returns whether an ended run needs attention.
bool needs_attention(const FoundRun& run) {
  const auto state = run.status.standing.state;
  return run.trouble.empty() && (record::count_unacknowledged(run.status.alarms) > 0 || state == RunState::aborting ||
                                 state == RunState::aborted);
}

/// Returns the runs with metrics: active runs, and the last run of a rig if it ended badly. Its alarms can no longer be
/// acknowledged, so it is reported until another run starts on the rig. If two runs have the same labels, only the
/// first is included, because labels must differ.
std::vector<FoundRun> select_runs(const std::vector<FoundRun>& runs) {
  std::vector<FoundRun> selected;
  std::set<std::string> names;
  std::set<std::pair<std::string, bool>> rigs;
  const auto include = [&](const FoundRun& run) {
    if (names.insert(metric_labels(run)).second) selected.push_back(run);
  };
  for (const auto& run : runs)
    if (is_unfinished(run)) include(run);
  for (const auto& run : runs) {
    if (!run.info || run.info->imported) continue;
    const bool is_the_last = rigs.emplace(run.info->rig_name, run.status.simulated).second;
    if (is_the_last && !is_unfinished(run) && needs_attention(run)) include(run);
  }
  return selected;
}

}  // namespace

std::string metrics_text(const std::vector<FoundRun>& runs, const MonitorMetrics& own) {
  const auto selected = select_runs(runs);
  std::string text;
  for (const auto& metric : kMetrics) add_metric(text, metric, selected);
  add_states(text, selected);
  add_thermometers(text, selected);
  add_disks(text, selected);
  const auto add_own = [&](const char* name, const char* help, auto value) {
    text += metric_head(name, help) + fmt::format("{} {}\n", name, value);
  };
  add_own("gyrotherm_runs_going_on", "Active runs.", std::ranges::count_if(selected, &FoundRun::is_running));
  add_own("gyrotherm_runs_found", "Records in the monitor's folders.", runs.size());
  add_own("gyrotherm_monitor_watchers", "Connected pages that watch a run.", own.watchers);
  add_own("gyrotherm_monitor_cache_bytes", "Memory used for chart overviews.", own.cache_bytes);
  return text;
}

}  // namespace gyrotherm::monitor
