// SPDX-License-Identifier: Apache-2.0
/// Distributes the tasks of a job with Slurm, as job arrays, or with GNU parallel, on this machine or others. Both run
/// `gyrotherm-site task FOLDER NUMBER` for each task.
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
  std::vector<std::string> scheduler_options{};
  /// Waits until all tasks have ended. Otherwise returns after they are submitted.
  bool waits = true;
  /// Descriptor that becomes readable when the wait must end.
  int stop = -1;
};

/// Number of tasks by result. A task without a result waits, runs or has died.
struct Progress {
  std::size_t all{}, succeeded{}, failed{};
  [[nodiscard]] std::size_t left() const { return all - succeeded - failed; }
  bool operator==(const Progress&) const = default;
};
[[nodiscard]] Result<Progress> count_progress(const Job& job, const std::string& folder);

/// Returns the numbers in the format of `sbatch --array`: "0-3,7".
[[nodiscard]] std::string to_ranges(const std::vector<std::size_t>& numbers);

/// Returns the batch script of a job array: the text of FOLDER/job.sh.
[[nodiscard]] std::string slurm_script(const Job& job, const std::string& folder);

/// Submits the tasks that have no result, unless workers of an earlier call still run, and waits for them. A task that
/// dies, because its machine fails or memory is exhausted, is submitted up to three times. A task that ended with an
/// error is not repeated. Calls `report` with the progress while it waits. Fails with refused if the workers do not
/// respond or tasks died three times, or with interrupted.
[[nodiscard]] Result<Progress> distribute(const Job& job, const std::string& folder,
                                          const DistributionSettings& settings,
                                          const std::function<void(const Progress&)>& report);

}  // namespace gyrotherm::site
