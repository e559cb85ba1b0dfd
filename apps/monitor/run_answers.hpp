// SPDX-License-Identifier: Apache-2.0
/// Answers requests for run data from the page, scripts and Prometheus: all paths below /api/v1/runs, and /metrics.
/// Changes nothing.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "apps/monitor/run_catalogue.hpp"
#include "apps/monitor/run_feed.hpp"
#include "apps/monitor/series.hpp"
#include "apps/monitor/web.hpp"

namespace gyrotherm::monitor {

/// Limit of watchers, each of which occupies one of the 32 threads. Further watchers are asked to retry later.
inline constexpr int kMaxWatchers = 20;

/// The answers. Usable from any thread.
class RunAnswers {
 public:
  RunAnswers(const RunCatalogue& catalogue, RunFeed& feed, std::function<bool()> is_stopping)
      : catalogue_(catalogue), feed_(feed), is_stopping_(std::move(is_stopping)) {}

  /// Answers a request. `rest` is the path after "/api/v1/runs": "", "/KEY", "/KEY/series" … A streamed answer calls
  /// `has_access` once a second and ends when it returns false.
  [[nodiscard]] WebAnswer answer(const WebRequest& request, const std::string& rest, std::function<bool()> has_access);
  [[nodiscard]] std::size_t cache_bytes() const { return cache_.bytes(); }
  /// Updates the overviews for charts of whole runs. Called by one thread at intervals.
  void catch_up() { cache_.catch_up(); }

 private:
  [[nodiscard]] WebAnswer list() const;
  [[nodiscard]] WebAnswer series(const FoundRun& run, const RequestHead& head);
  [[nodiscard]] WebAnswer stream(const FoundRun& run, const RequestHead& head, std::function<bool()> has_access);

  const RunCatalogue& catalogue_;
  RunFeed& feed_;
  std::function<bool()> is_stopping_;
  SeriesCache cache_;
};

/// Returns the profile as planned, and the actual beginning of each segment so far.
[[nodiscard]] WebAnswer profile_answer(const FoundRun& run);
/// Return the list of files of a closed record and its reports, and one of these files as a download.
[[nodiscard]] WebAnswer files_answer(const FoundRun& run);
[[nodiscard]] WebAnswer file_answer(const FoundRun& run, const std::string& name);

/// Metrics of the monitor itself.
struct MonitorMetrics {
  int watchers{};
  std::size_t cache_bytes{};
};
/// Returns the metrics of the runs in the text format of Prometheus, 0.0.4. `runs` are in the order of
/// RunCatalogue::runs(). An active run has all metrics. If its program is silent or has ended, the run has only
/// availability, last second and alarms. The last run of a rig has state and alarms if it was aborted or has
/// unacknowledged alarms. All other runs are only counted.
[[nodiscard]] std::string metrics_text(const std::vector<FoundRun>& runs, const MonitorMetrics& own);

}  // namespace gyrotherm::monitor
