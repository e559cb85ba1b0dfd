// SPDX-License-Identifier: Apache-2.0
/// The run that goes on, as a SEC node: a module that tells of the run, and one of each quantity that it measures.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "apps/monitor/run_catalogue.hpp"
#include "apps/monitor/secop_node.hpp"
#include "apps/monitor/series_channels.hpp"
#include "core/clock.hpp"

namespace gyrotherm::monitor {

/// The last second of a run.
struct LastSample {
  std::int64_t slot{-1};
  double utc_s{};              ///< since 1970, by the run's own clock; NaN: not known
  std::vector<double> values;  ///< in the order of series_channels(); NaN: a fault
};
/// Nothing before the first second. Fails with storage or bad_file.
[[nodiscard]] Result<std::optional<LastSample>> read_last_sample(const FoundRun& run);

/// What is to be told of a run at a moment.
struct RunMoment {
  const FoundRun* run{};               ///< null: none was found
  std::optional<LastSample> sample{};  ///< nothing: none yet
  bool stale{};                        ///< the sample is older than record::kSilentAfter
  double utc_s{};                      ///< now, since 1970
};
/// A value stands there only while the run goes on and gives samples; the structure depends on the rig alone.
[[nodiscard]] SecopNode secop_node_of(const RunMoment& moment);

/// Follows the run that goes on; among several the one that it follows already, else the one that began last. One
/// thread.
class SecopRun {
 public:
  /// `rig` names the rig whose runs are followed; empty: any.
  SecopRun(const RunCatalogue& catalogue, std::string rig, const Clock& clock);

  /// Reads what is new. Whether the structure of the node has changed.
  bool look();
  [[nodiscard]] const SecopState& state() const { return state_; }

 private:
  [[nodiscard]] std::optional<FoundRun> choose() const;

  const RunCatalogue& catalogue_;
  std::string rig_;
  const Clock& clock_;
  std::string key_;  ///< of the run
  std::string id_;   ///< its key and its own id: another run may come to the same path
  std::optional<LastSample> sample_;
  Duration came_{};  ///< when that sample was first seen
  SecopState state_;
};

}  // namespace gyrotherm::monitor
