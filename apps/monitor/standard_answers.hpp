// SPDX-License-Identifier: Apache-2.0
/// Answers requests for the control charts of the check standard of a run's rig (docs/check-standard.md). Usable from
/// any thread. Changes nothing.
#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "acquisition/record/check_history.hpp"
#include "apps/monitor/web.hpp"
#include "core/file.hpp"

namespace gyrotherm::monitor {

/// Largest history that is read. The memory of the monitor is limited; 500 check runs of a triad have 4 MB.
inline constexpr std::size_t kMaxHistoryBytes = kLargestText;
/// Range of the width of the figure, px.
inline constexpr int kMinChartWidth = 240, kMaxChartWidth = 1600;

class StandardAnswers {
 public:
  /// Returns the standing, all results, explanations and the diagnosis (schema gyrotherm-control-charts/1), or with
  /// `width_px` the charts as SVG. Refuses with 404 if there is no history, and if it is not a history of check runs of
  /// this rig. The reason does not contain any text of the file.
  [[nodiscard]] WebAnswer answer(const record::NamedHistory& source, std::optional<int> width_px);

 private:
  struct CachedAnswer {
    FileState state{};
    WebAnswer answer{};
  };
  std::mutex mutex_;  ///< held while an answer is computed, so that only one history is in memory
  std::map<std::string, CachedAnswer> answers_;
};

}  // namespace gyrotherm::monitor
