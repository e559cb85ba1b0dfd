// SPDX-License-Identifier: Apache-2.0
/// Computes the decisions of a run that ends by itself, from the seconds recorded so far.
#pragma once

#include <atomic>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/record/decision.hpp"
#include "acquisition/record/record.hpp"
#include "analysis/planning/assessment.hpp"
#include "apps/console/console.hpp"
#include "apps/gyrotherm/run/run_goal.hpp"
#include "core/result.hpp"
#include "sequencer/run/block_choice.hpp"
#include "sequencer/run/run_controller.hpp"

namespace gyrotherm::app {

/// Uncertainties that a decision needs, and the reason why they could not be computed.
struct AssessedRun {
  double u_now_deg_per_h{};
  std::vector<double> u_after_deg_per_h{};
  /// The greatest gain of each block over all axes; see planning::Assessment.
  std::vector<double> gains{};
  std::string trouble{};  ///< empty: none
  bool is_interrupted = false;
};

/// Computes the uncertainty now and after each block, which begins at the end of the record, in the recommended model
/// of each axis. The result is the greatest over all axes that had a reading in the last two clusters.
[[nodiscard]] AssessedRun assess_run(const record::Record& history, const planning::ProgramPath& mission,
                                     const std::vector<planning::ProgramPath>& blocks,
                                     const ProgressSink& progress = {});

class RunDecider {
 public:
  /// `history` is a record without rows for a new run, and all that was recorded for a resumed one. The results do not
  /// depend on where a row comes from. If `in_worker`, decisions are computed in a thread of their own while the run
  /// continues; otherwise during after_tick(). Returns null for a run with a fixed end. Fails with bad_file if the
  /// mission cannot be read.
  [[nodiscard]] static Result<std::unique_ptr<RunDecider>> make(record::Record history, bool in_worker);
  /// Stops a computation and waits for its end.
  ~RunDecider();
  RunDecider(const RunDecider&) = delete;
  RunDecider& operator=(const RunDecider&) = delete;

  /// Adds the second of the last tick. If a decision is due, computes it, or begins to, and carries it out when it is
  /// available. Fails with storage.
  [[nodiscard]] Result<void> after_tick(run::RunController& run_controller, Console& console);

  /// Describes the progress for operators, `seconds` after the start of the run.
  [[nodiscard]] std::string describe_progress(std::int64_t seconds) const;

 private:
  RunDecider(record::Record history, planning::ProgramPath mission, bool in_worker);
  [[nodiscard]] AssessedRun assess_now(const run::RunController& run_controller);
  void begin_assessment(const run::RunController& run_controller);
  [[nodiscard]] Result<void> carry_out(run::RunController& run_controller, Console& console,
                                       const AssessedRun& assessed);

  record::Record history_;
  planning::ProgramPath mission_;
  bool in_worker_;
  std::optional<record::Decision> last_;
  /// The computation in progress.
  std::future<AssessedRun> assessment_;
  std::atomic<bool> is_stopping_ = false;
};

}  // namespace gyrotherm::app
