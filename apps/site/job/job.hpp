// SPDX-License-Identifier: Apache-2.0
/// A job: independent tasks, each a list of commands of gyrotherm, in a folder that all participating machines share. A
/// task whose process or machine died is repeated. The files that a command writes do not depend on the machine, so two
/// machines may run the same task. Usable from any thread and process.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/result.hpp"

namespace gyrotherm::site {

inline constexpr const char* kJobSchema = "gyrotherm-job/1";

/// A command of gyrotherm, without the program's name. Paths are relative to the job's folder.
struct Step {
  std::vector<std::string> arguments{};
  /// File for its standard output; empty: the task's log.
  std::string output{};
};

struct Task {
  std::string name{};  ///< also of its files
  std::vector<Step> steps{};
};

struct Job {
  std::string title{};
  std::string folder{};  ///< in which commands run
  int threads = 1;       ///< per task
  std::vector<Task> tasks{};
  /// Steps after the last task, on the machine that waits.
  std::vector<Step> final_steps{};
};

/// Result of a task that has ended. A task that waits, runs or has died has none.
struct TaskEnd {
  /// Exit code of the first failed command, or of the last one.
  int exit_code{};
  double wall_s{};
  std::string machine{};
  [[nodiscard]] bool has_succeeded() const { return exit_code == 0 || exit_code == kOutsideLimits; }
  /// Exit code of a command whose result is outside its limits. The task counts as done.
  static constexpr int kOutsideLimits = 1;
};

/// Creates the folder and writes FOLDER/job.json. Fails with usage if the folder contains another job, or with storage.
[[nodiscard]] Result<void> write_job(const Job& job, const std::string& folder);
/// Reads a job. Fails with bad_file.
[[nodiscard]] Result<Job> read_job(const std::string& folder);

/// Reads FOLDER/tasks/NAME.json. Returns nothing if it does not exist. Fails with bad_file.
[[nodiscard]] Result<std::optional<TaskEnd>> read_task_end(const std::string& folder, const Task& task);
/// Removes the result of a failed task, so the task is repeated.
void remove_task_end(const std::string& folder, const Task& task);

/// Runs a task unless it has a result, and stores the result. Writes the errors of its commands to
/// FOLDER/tasks/NAME.log. Fails with usage if the task does not exist. Fails with interrupted, and
/// stores no result, if a signal or a stop request ended a command.
[[nodiscard]] Result<TaskEnd> run_task(const Job& job, const std::string& folder, std::size_t index);

/// Runs one command in the job's folder, with the standard output of this program. Returns its exit code.
[[nodiscard]] Result<int> run_step(const Job& job, const Step& step);

// Plans of the jobs that a site can distribute.

/// Arguments that are passed to each command, and the number of threads of each task.
struct PlanOptions {
  std::vector<std::string> arguments{};
  int threads = 1;
};

/// Plans `qualify --only` for each axis of the experiment in the folder `lot`, and finally `qualify`, which writes the
/// summary. The records must exist. Fails like read_info(), or with usage if there is only one axis.
[[nodiscard]] Result<Job> plan_lot(const std::string& rig, const std::string& lot, const PlanOptions& options);
/// Returns the command that makes the records for plan_lot().
[[nodiscard]] Step make_lot_records_step(const std::string& rig, const std::string& lot, const PlanOptions& options);

/// The records and the range of seeds for plan_seeds().
struct Seeds {
  std::vector<std::string> records, verify;
  std::uint64_t first = 1, last = 20;
};
/// Plans the training of one model per seed, in OUT/seed-N/, and its verification on the records `verify`. Fails with
/// usage if the range contains no seed or more than 100,000.
[[nodiscard]] Result<Job> plan_seeds(const Seeds& seeds, const std::string& out, const PlanOptions& options);

/// Plans a cross-validation over units, one record per unit, in OUT/NAME/, where NAME is the file name of the record.
/// Each task learns the type prior without one unit, trains a model of that unit on its first `hours` with the prior,
/// and verifies the model on the remaining hours. Fails with usage if there are fewer than four records, or if two have
/// the same name.
[[nodiscard]] Result<Job> plan_leave_one_out(const std::vector<std::string>& records, double hours,
                                             const std::string& out, const PlanOptions& options);

/// Plans `placement` for each axis of the first record. The results are OUT/AXIS.json. Fails like read_info().
[[nodiscard]] Result<Job> plan_placement(const std::vector<std::string>& records, const std::string& out,
                                         const PlanOptions& options);

}  // namespace gyrotherm::site
