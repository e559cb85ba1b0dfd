// SPDX-License-Identifier: Apache-2.0
/// The answers on runs to the page, to scripts and to Prometheus: all below /api/v1/runs, and /metrics. They change
/// nothing.
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

inline constexpr int kMostWatchers = 20;  ///< of 32 threads; one more is told to come back later

/// Any thread.
class RunAnswers {
 public:
  RunAnswers(const RunCatalogue& catalogue, RunFeed& feed, std::function<bool()> is_stopping)
      : catalogue_(catalogue), feed_(feed), is_stopping_(std::move(is_stopping)) {}

  /// `rest` is what the path has behind "/api/v1/runs": "", "/KEY", "/KEY/series" … An answer that goes on asks once a
  /// second whether whom it is for `may_still_look`, and ends when not.
  [[nodiscard]] WebAnswer answer(const WebRequest& request, const std::string& rest,
                                 std::function<bool()> may_still_look);
  [[nodiscard]] std::size_t cache_bytes() const { return cache_.bytes(); }
  /// Makes charts of whole runs fast; one thread, now and then.
  void catch_up() { cache_.catch_up(); }

 private:
  [[nodiscard]] WebAnswer list() const;
  [[nodiscard]] WebAnswer series(const FoundRun& run, const RequestHead& head);
  [[nodiscard]] WebAnswer stream(const FoundRun& run, const RequestHead& head, std::function<bool()> may_still_look);

  const RunCatalogue& catalogue_;
  RunFeed& feed_;
  std::function<bool()> is_stopping_;
  SeriesCache cache_;
};

/// The profile as it was planned, and as far as it was carried out: when each segment really began.
[[nodiscard]] WebAnswer profile_answer(const FoundRun& run);
/// The files of a closed record and of its report; one of them, to be saved.
[[nodiscard]] WebAnswer files_answer(const FoundRun& run);
[[nodiscard]] WebAnswer file_answer(const FoundRun& run, const std::string& name);

/// The monitor's own metrics.
struct OwnFigures {
  int watchers{};
  std::size_t cache_bytes{};
};
/// Returns the metrics of the runs as Prometheus reads them (text format 0.0.4). `runs` are in the order of
/// RunCatalogue::runs(). A run that is in progress has all metrics. If its program is silent or has ended, the run has
/// those of its availability, its last second and its alarms. The last run of a rig has its state and its alarms if it
/// was aborted or has unacknowledged alarms. All other runs are only counted.
[[nodiscard]] std::string metrics_text(const std::vector<FoundRun>& runs, const OwnFigures& own);

}  // namespace gyrotherm::monitor
