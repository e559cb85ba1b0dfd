// SPDX-License-Identifier: Apache-2.0
/// Distributes the tasks of a job: with Slurm, as an array of jobs, or with GNU parallel, on this machine or others.
/// Both third-party programs run `gyrotherm site task FOLDER NUMBER`.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "apps/site/job/job.hpp"
#include "core/result.hpp"

namespace gyrotherm::site {

enum class Scheduler { slurm, parallel };
[[nodiscard]] const char* name(Scheduler scheduler);

struct DistributionSettings {
  Scheduler scheduler{};
  /// Options for sbatch or parallel, such as "--partition=lab" or "--sshlogin=a,b".
  std::vector<std::string> words{};
  bool waits = true;  ///< until all tasks are done
  /// A descriptor that is readable once the wait must end.
  int stop = -1;
};

/// Counts of tasks by result. A task without a result waits, runs or has died.
struct Progress {
  std::size_t all{}, good{}, bad{};
  [[nodiscard]] std::size_t left() const { return all - good - bad; }
  bool operator==(const Progress&) const = default;
};
[[nodiscard]] Result<Progress> count_progress(const Job& job, const std::string& folder);

/// Returns the numbers in the form of sbatch: "0-3,7".
[[nodiscard]] std::string to_ranges(const std::vector<std::size_t>& numbers);

/// Returns the script of an array: the text of FOLDER/job.sh.
[[nodiscard]] std::string slurm_script(const Job& job, const std::string& folder);

/// Distributes the tasks that have no end, unless the workers of an earlier call still run, and waits. Distributes a
/// task up to three times in all if it dies because its machine fails or memory runs out. Does not repeat a task that
/// failed. `report` receives the progress. Fails with refused if the workers do not answer, or if tasks die repeatedly,
/// and with interrupted.
[[nodiscard]] Result<Progress> distribute(const Job& job, const std::string& folder,
                                          const DistributionSettings& settings,
                                          const std::function<void(const Progress&)>& report);

}  // namespace gyrotherm::site
