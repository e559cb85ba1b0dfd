// SPDX-License-Identifier: Apache-2.0
/// A job: tasks that need nothing of each other, each of them commands of gyrotherm, as a folder that every machine
/// sees which works on it. A task that died is done again: what commands leave they leave as whole files, the same
/// whoever made them, so that it does no harm if two machines work on one task. For any thread and process.
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
  std::string output{};  ///< the file for what it prints; empty: the task's log
};

struct Task {
  std::string name{};  ///< also of its files
  std::vector<Step> steps{};
};

struct Job {
  std::string title{};
  std::string in{};  ///< the folder that commands are carried out in
  int threads = 1;   ///< that each task uses
  std::vector<Task> tasks{};
  std::vector<Step> then{};  ///< once all are done, where they were waited for
};

/// What became of a task; there is none while it waits, is worked on, or has died.
struct TaskEnd {
  int exit_code{};  ///< of the first command that failed, or the last
  double wall_s{};
  std::string machine{};
  [[nodiscard]] bool is_good() const { return exit_code == 0 || exit_code == kOutsideLimits; }
  static constexpr int kOutsideLimits = 1;  ///< done, and the result is told
};

/// FOLDER/job.json; the folder is made. Fails with usage if there is another job, or with storage.
[[nodiscard]] Result<void> write_job(const Job& job, const std::string& folder);
/// Fails with bad_file.
[[nodiscard]] Result<Job> read_job(const std::string& folder);

/// FOLDER/tasks/NAME.json.
[[nodiscard]] Result<std::optional<TaskEnd>> end_of(const std::string& folder, const Task& task);
/// A task that failed is as one that was not begun.
void forget_end(const std::string& folder, const Task& task);

/// Carries out one task, unless it is done; what its commands complain about goes to FOLDER/tasks/NAME.log. Fails
/// with interrupted if a command was ended by a signal or asked to stop: nothing is said of the task then.
[[nodiscard]] Result<TaskEnd> carry_out(const Job& job, const std::string& folder, std::size_t task);

/// Carries out one command where the job's are, with what it prints going where this program's goes; its exit code.
[[nodiscard]] Result<int> carry_out(const Job& job, const Step& step);

// The jobs that a site plans for many machines: every axis of a lot, many seeds, each unit left out of its type, the
// price of every thermometer of every axis. Each command is one that a single machine would be given.

/// Words that are passed on to the command, and what each task may use.
struct PlanOptions {
  std::vector<std::string> words{};
  int threads = 1;
};

/// Every axis of the experiment in the folder `lot`, whose records are there: `qualify --only`, and then `qualify`,
/// which sums up. Fails as read_info() does, or with usage if there is one axis alone.
[[nodiscard]] Result<Job> plan_lot(const std::string& rig, const std::string& lot, const PlanOptions& options);
/// What makes the records ready for that, on this machine.
[[nodiscard]] Step records_of_lot(const std::string& rig, const std::string& lot, const PlanOptions& options);

/// One model a seed, each verified on the same records, into OUT/seed-N/. Fails with usage if there is no seed, or more
/// than any queue takes.
struct Seeds {
  std::vector<std::string> records, verify;
  std::uint64_t first = 1, last = 20;
};
[[nodiscard]] Result<Job> plan_seeds(const Seeds& seeds, const std::string& out, const PlanOptions& options);

/// Each of these records of different units left out of the prior of their type, which then helps a model of its own
/// first hours, which is verified on all the others: into OUT/NAME/, where NAME is the record's. Fails with usage if
/// there are fewer than four, or two of one name.
[[nodiscard]] Result<Job> plan_leave_one_out(const std::vector<std::string>& records, double hours,
                                             const std::string& out, const PlanOptions& options);

/// `placement` of each axis of the first record, into OUT/AXIS.json.
[[nodiscard]] Result<Job> plan_placement(const std::vector<std::string>& records, const std::string& out,
                                         const PlanOptions& options);

}  // namespace gyrotherm::site
