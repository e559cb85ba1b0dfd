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

/// Escapes the value of a label. Replaces each invalid byte by U+FFFD, because Prometheus rejects the whole text if it
/// is not valid UTF-8.
std::string escape_label(std::string_view text) {
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
  return fmt::format("run=\"{}\",rig=\"{}\",profile=\"{}\",simulated=\"{}\"", escape_label(run.name),
                     escape_label(run.info ? run.info->rig_name : ""),
                     escape_label(run.info ? run.info->profile_name : ""), run.status.simulated ? 1 : 0);
}

std::optional<double> to_number(const std::optional<Celsius>& temperature) {
  return temperature ? std::optional(temperature->value) : std::nullopt;
}

/// Returns whether a program executes the run, or the run was interrupted and can be resumed.
bool is_unfinished(const FoundRun& run) { return run.is_running() || run.is_abandoned(); }

/// Runs for which a metric is reported. Most values are only known while the program of the run responds.
enum class MetricScope { responding, unfinished, all };

bool is_in_scope(MetricScope scope, const FoundRun& run) {
  switch (scope) {
    case MetricScope::responding: return run.is_running() && !run.is_silent();
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
    Metric{"gyrotherm_run_up", "1 if the program that executes the run responds, otherwise 0.", MetricScope::unfinished,
           [](const FoundRun& run) -> std::optional<double> { return run.is_running() && !run.is_silent() ? 1 : 0; }},
    Metric{"gyrotherm_run_status_age_seconds", "Time since the status of the run was written.", MetricScope::unfinished,
           [](const FoundRun& run) { return run.age_s; }},
    Metric{"gyrotherm_run_second", "Slot of the last sample: seconds since the start of the run.",
           MetricScope::unfinished,
           [](const FoundRun& run) -> std::optional<double> { return static_cast<double>(run.status.slot); }},
    Metric{"gyrotherm_run_alarms", "Unacknowledged alarms.", MetricScope::all,
           [](const FoundRun& run) -> std::optional<double> {
             return static_cast<double>(record::count_unacknowledged(run.status.alarms));
           }},
    Metric{"gyrotherm_run_shelved_alarms", "Alarms that an operator has shelved.", MetricScope::unfinished,
           [](const FoundRun& run) -> std::optional<double> {
             return static_cast<double>(std::ranges::count_if(run.status.alarms, &record::Alarm::is_shelved));
           }},
    Metric{"gyrotherm_run_backlog_seconds", "Seconds of samples that are not yet on the disk.", MetricScope::responding,
           [](const FoundRun& run) -> std::optional<double> { return static_cast<double>(run.status.backlog_s); }},
    Metric{"gyrotherm_run_faults_total", "Readings with a fault since the start of the run.", MetricScope::responding,
           [](const FoundRun& run) -> std::optional<double> { return static_cast<double>(run.status.faults); }},
    Metric{"gyrotherm_run_faults_now", "Faults that are active now.", MetricScope::responding,
           [](const FoundRun& run) -> std::optional<double> {
             return static_cast<double>(run.status.overview.faults_now.size());
           }},
    Metric{"gyrotherm_run_segment", "Current segment of the profile, from 1.", MetricScope::responding,
           [](const FoundRun& run) -> std::optional<double> { return run.status.segment_index + 1; }},
    Metric{"gyrotherm_run_segments", "Number of segments of the profile.", MetricScope::responding,
           [](const FoundRun& run) -> std::optional<double> { return run.status.segment_count; }},
    Metric{"gyrotherm_run_left_seconds", "Remaining time if no soak is interrupted again.", MetricScope::responding,
           [](const FoundRun& run) -> std::optional<double> {
             return run.status.overview.time_left ? std::optional(to_seconds(*run.status.overview.time_left))
                                                  : std::nullopt;
           }},
    Metric{"gyrotherm_run_behind_plan_seconds", "Time for which the clock of the profile has been stopped.",
           MetricScope::responding,
           [](const FoundRun& run) -> std::optional<double> {
             return run.status.overview.behind_plan ? std::optional(to_seconds(*run.status.overview.behind_plan))
                                                    : std::nullopt;
           }},
    Metric{"gyrotherm_run_set_point_celsius", "Set point of the profile.", MetricScope::responding,
           [](const FoundRun& run) { return to_number(run.status.set_point); }},
    Metric{"gyrotherm_run_chamber_air_celsius", "Air temperature of the chamber.", MetricScope::responding,
           [](const FoundRun& run) { return to_number(run.status.chamber_air); }}};

/// Returns the HELP and TYPE lines of a metric. A metric whose name ends in _total is a counter.
std::string metric_head(std::string_view name, const char* help) {
  return fmt::format("# HELP {0} {1}\n# TYPE {0} {2}\n", name, help, name.ends_with("_total") ? "counter" : "gauge");
}

void append_metric(std::string& text, const char* name, const char* help, const std::string& lines) {
  if (!lines.empty()) text += metric_head(name, help) + lines;
}

void append_values(std::string& text, const Metric& metric, const std::vector<FoundRun>& runs) {
  std::string lines;
  for (const auto& run : runs)
    if (const auto value = is_in_scope(metric.scope, run) ? metric.value(run) : std::nullopt;
        value && std::isfinite(*value))
      lines += fmt::format("{}{{{}}} {}\n", metric.name, metric_labels(run), *value);
  append_metric(text, metric.name, metric.help, lines);
}

/// Appends the state of each run, which for an ended run is its final state.
void append_states(std::string& text, const std::vector<FoundRun>& runs) {
  std::string lines;
  for (const auto& run : runs)
    if (is_in_scope(MetricScope::responding, run) || !is_unfinished(run))
      for (const auto state : kRunStates)
        lines += fmt::format("gyrotherm_run_state{{{},state=\"{}\"}} {}\n", metric_labels(run), name(state),
                             run.status.overview.state == state ? 1 : 0);
  append_metric(text, "gyrotherm_run_state", "1 for the current state of the run, 0 for other states.", lines);
}

void append_thermometers(std::string& text, const std::vector<FoundRun>& runs) {
  std::string lines;
  for (const auto& run : runs)
    if (is_in_scope(MetricScope::responding, run))
      for (const auto& [channel, reading] : run.status.thermometers)
        if (reading && std::isfinite(reading->value))
          lines += fmt::format("gyrotherm_run_thermometer_celsius{{{},channel=\"{}\"}} {}\n", metric_labels(run),
                               escape_label(channel), reading->value);
  append_metric(text, "gyrotherm_run_thermometer_celsius", "Uncorrected reading of a thermometer.", lines);
}

void append_disks(std::string& text, const std::vector<FoundRun>& runs) {
  std::string lines;
  for (const auto& run : runs)
    if (is_in_scope(MetricScope::responding, run) && run.free_bytes)
      lines += fmt::format("gyrotherm_disk_free_bytes{{{}}} {}\n", metric_labels(run), *run.free_bytes);
  append_metric(text, "gyrotherm_disk_free_bytes", "Free space on the disk of the record.", lines);
}

/// Returns whether an ended run was aborted or has unacknowledged alarms.
bool needs_attention(const FoundRun& run) {
  const auto state = run.status.overview.state;
  return run.read_error.empty() && (record::count_unacknowledged(run.status.alarms) > 0 ||
                                    state == RunState::aborting || state == RunState::aborted);
}

/// Returns the runs that have metrics: unfinished runs, and the last run of a rig if it needs attention. Its alarms can
/// no longer be acknowledged, so it is reported until another run starts on the rig. Of runs with the same labels, only
/// the first is included, because Prometheus requires unique labels.
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
    const bool is_last_of_rig = rigs.emplace(run.info->rig_name, run.status.simulated).second;
    if (is_last_of_rig && !is_unfinished(run) && needs_attention(run)) include(run);
  }
  return selected;
}

}  // namespace

std::string metrics_text(const std::vector<FoundRun>& runs, const MonitorMetrics& monitor) {
  const auto selected = select_runs(runs);
  std::string text;
  for (const auto& metric : kMetrics) append_values(text, metric, selected);
  append_states(text, selected);
  append_thermometers(text, selected);
  append_disks(text, selected);
  const auto append_monitor_metric = [&](const char* name, const char* help, auto value) {
    text += metric_head(name, help) + fmt::format("{} {}\n", name, value);
  };
  append_monitor_metric("gyrotherm_runs_going_on", "Active runs.",
                        std::ranges::count_if(selected, &FoundRun::is_running));
  append_monitor_metric("gyrotherm_runs_found", "Records in the monitor's folders.", runs.size());
  append_monitor_metric("gyrotherm_monitor_watchers", "Connected pages that watch a run.", monitor.watchers);
  append_monitor_metric("gyrotherm_monitor_cache_bytes", "Memory used for chart overviews.", monitor.cache_bytes);
  return text;
}

}  // namespace gyrotherm::monitor
