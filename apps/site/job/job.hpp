// SPDX-License-Identifier: Apache-2.0
/// A job: independent tasks, each a list of commands of gyrotherm, in a folder that all participating machines share. A
/// task that died is repeated. Commands write whole files whose content does not depend on the machine, so two machines
/// may carry out the same task. Any thread and process.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/result.hpp"

namespace gyrotherm::site {

inline constexpr const char* kJobSchema = "gyrotherm-job/1";

/// A command of gyrotherm, without the program's name. Paths are relative to the job's `in`.
struct Step {
  std::vector<std::string> words{};
  /// File for its standard output; empty: the task's log.
  std::string output{};
};

struct Task {
  std::string name{};  ///< also names its files
  std::vector<Step> steps{};
};

struct Job {
  std::string title{};
  std::string in{};  ///< folder in which commands run
  int threads = 1;   ///< per task
  std::vector<Task> tasks{};
  /// Steps after the last task, on the machine that waits.
  std::vector<Step> then{};
};

/// The end of a task. A task that waits, runs or has died has none.
struct TaskEnd {
  /// Exit code of the first failed command, or of the last one.
  int exit_code{};
  double wall_s{};
  std::string machine{};
  [[nodiscard]] bool is_good() const { return exit_code == 0 || exit_code == kOutsideLimits; }
  /// Exit code of a task that is done with a result outside its limits.
  static constexpr int kOutsideLimits = 1;
};

/// Writes FOLDER/job.json and makes the folder. Fails with usage if the folder has another job, or with storage.
[[nodiscard]] Result<void> write_job(const Job& job, const std::string& folder);
/// Reads a job. Fails with bad_file.
[[nodiscard]] Result<Job> read_job(const std::string& folder);

/// Reads FOLDER/tasks/NAME.json.
[[nodiscard]] Result<std::optional<TaskEnd>> read_task_end(const std::string& folder, const Task& task);
/// Removes the end of a failed task, so that the task is repeated.
void remove_task_end(const std::string& folder, const Task& task);

/// Carries out one task, unless it is done. Writes the errors of its commands to FOLDER/tasks/NAME.log. Fails with
/// interrupted if a signal or a stop request ended a command; then the task has no end.
[[nodiscard]] Result<TaskEnd> carry_out(const Job& job, const std::string& folder, std::size_t task);

/// Carries out one command in the job's folder, with this program's standard output. Returns its exit code.
[[nodiscard]] Result<int> carry_out(const Job& job, const Step& step);

// The jobs of a site for many machines: every axis of a lot, many seeds, each unit left out of its type, the value of
// every thermometer for every axis. Each command also works on a single machine.

/// Arguments that are passed to each command, and the number of threads of each task.
struct PlanOptions {
  std::vector<std::string> words{};
  int threads = 1;
};

/// Plans `qualify --only` for every axis of the experiment in the folder `lot`, which must have its records, and then
/// `qualify`, which writes the summary. Fails as read_info() does, or with usage if there is only one axis.
[[nodiscard]] Result<Job> plan_lot(const std::string& rig, const std::string& lot, const PlanOptions& options);
/// Returns the command that makes these records, on this machine.
[[nodiscard]] Step make_lot_records_step(const std::string& rig, const std::string& lot, const PlanOptions& options);

/// The records and the range of seeds for plan_seeds().
struct Seeds {
  std::vector<std::string> records, verify;
  std::uint64_t first = 1, last = 20;
};
/// Plans one model per seed, each verified on the same records, in OUT/seed-N/. Fails with usage without a seed, or if
/// there are more than a queue accepts.
[[nodiscard]] Result<Job> plan_seeds(const Seeds& seeds, const std::string& out, const PlanOptions& options);

/// Plans a cross-validation over units, one record each, in OUT/NAME/, where NAME is the record's. Each task leaves one
/// unit out of the prior of its type, trains a model of that unit's first hours with the prior, and verifies it on the
/// unit's remaining clusters. Fails with usage if there are fewer than four records, or two of one name.
[[nodiscard]] Result<Job> plan_leave_one_out(const std::vector<std::string>& records, double hours,
                                             const std::string& out, const PlanOptions& options);

/// Plans `placement` of each axis of the first record, into OUT/AXIS.json.
[[nodiscard]] Result<Job> plan_placement(const std::vector<std::string>& records, const std::string& out,
                                         const PlanOptions& options);

}  // namespace gyrotherm::site
