// SPDX-License-Identifier: Apache-2.0
/// Who works on the tasks of a job: Slurm, as an array of jobs of its own, or GNU parallel, on this machine or others.
/// Neither is ours; both run `gyrotherm site task FOLDER NUMBER`.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "apps/site/job/job.hpp"
#include "core/result.hpp"

namespace gyrotherm::site {

enum class By { slurm, parallel };
[[nodiscard]] const char* name(By by);

struct Spreading {
  By by{};
  std::vector<std::string> words{};  ///< for sbatch or parallel, like "--partition=lab" or "--sshlogin=a,b"
  bool waits = true;                 ///< until all tasks are done
  int stop = -1;                     ///< a descriptor that is readable once nobody wants to wait any more
};

/// How many tasks there are, of each kind.
struct Progress {
  std::size_t all{}, good{}, bad{};
  [[nodiscard]] std::size_t left() const { return all - good - bad; }
  bool operator==(const Progress&) const = default;
};
[[nodiscard]] Result<Progress> progress_of(const Job& job, const std::string& folder);

/// The numbers of tasks that have no end yet, as sbatch has them: "0-3,7".
[[nodiscard]] std::string ranges_of(const std::vector<std::size_t>& numbers);

/// The script of an array: the text of FOLDER/job.sh.
[[nodiscard]] std::string slurm_script(const Job& job, const std::string& folder);

/// Hands out what is not done, unless those whom an earlier call has given it are still at it, and waits. A task that
/// died – with its machine, or out of memory – is handed out again, up to three times in all; one that failed is not.
/// `tell` hears how far it is. Fails with refused if who should work does not answer, or tasks die again and again, and
/// with interrupted.
[[nodiscard]] Result<Progress> spread(const Job& job, const std::string& folder, const Spreading& how,
                                      const std::function<void(const Progress&)>& tell);

}  // namespace gyrotherm::site
