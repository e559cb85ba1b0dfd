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
#include "apps/monitor/standard_answers.hpp"
#include "apps/monitor/web.hpp"

namespace gyrotherm::monitor {

/// Largest number of watchers (open event streams). Each occupies one of the 32 threads of the server.
inline constexpr int kMaxWatchers = 20;

/// Answers requests for run data. Usable from any thread.
class RunAnswers {
 public:
  RunAnswers(const RunCatalogue& catalogue, RunFeed& feed, std::function<bool()> is_stopping)
      : catalogue_(catalogue), feed_(feed), is_stopping_(std::move(is_stopping)) {}

  /// Answers a request. `subpath` is the path after "/api/v1/runs": "", "/KEY", "/KEY/series" … An event stream calls
  /// `has_access` once a second and ends when that returns false.
  [[nodiscard]] WebAnswer answer(const WebRequest& request, const std::string& subpath,
                                 std::function<bool()> has_access);
  [[nodiscard]] std::size_t cache_bytes() const { return cache_.bytes(); }
  /// Updates the overviews of long runs (series.hpp). One thread calls this at intervals.
  void update_overviews() { cache_.update_overviews(); }

 private:
  [[nodiscard]] WebAnswer answer_list() const;
  [[nodiscard]] WebAnswer answer_standard(const FoundRun& run, const RequestHead& head, bool as_figure);
  [[nodiscard]] WebAnswer answer_series(const FoundRun& run, const RequestHead& head);
  [[nodiscard]] WebAnswer answer_stream(const FoundRun& run, const RequestHead& head, std::function<bool()> has_access);

  const RunCatalogue& catalogue_;
  RunFeed& feed_;
  std::function<bool()> is_stopping_;
  SeriesCache cache_;
  StandardAnswers standard_;
};

/// Returns the planned profile, and the slot at which each segment has begun so far.
[[nodiscard]] WebAnswer profile_answer(const FoundRun& run);
/// Return the list of the files that can be downloaded, and one of these files. They are the files of a closed record,
/// and its reports.
[[nodiscard]] WebAnswer files_answer(const FoundRun& run);
[[nodiscard]] WebAnswer file_answer(const FoundRun& run, const std::string& name);

/// Metrics of the monitor itself.
struct MonitorMetrics {
  int watchers{};
  std::size_t cache_bytes{};
};
/// Returns the metrics of the runs in the text format 0.0.4 of Prometheus. `runs` are in the order of
/// RunCatalogue::runs(). An active run has all metrics. If its program is silent or has died, only availability, status
/// age, last second and alarms remain. The last run of a rig keeps its state and alarms if it was aborted or has
/// unacknowledged alarms. All other runs are only counted.
[[nodiscard]] std::string metrics_text(const std::vector<FoundRun>& runs, const MonitorMetrics& monitor);

}  // namespace gyrotherm::monitor
