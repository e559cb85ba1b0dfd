// SPDX-License-Identifier: Apache-2.0
#include "apps/site/job/spread.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <poll.h>
#include <sys/wait.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <memory>
#include <sstream>
#include <thread>

#include "core/child_process.hpp"
#include "core/deadline.hpp"
#include "core/file.hpp"
#include "core/process.hpp"
#include "core/text.hpp"

namespace gyrotherm::site {

namespace {

namespace fs = std::filesystem;

constexpr int kAttempts = 3;
// Below Slurm's default MaxArraySize, 1001.
constexpr std::size_t kLargestArray = 1000;
constexpr Duration kLook = std::chrono::milliseconds(200);
constexpr Duration kPatience = std::chrono::minutes(2);  // for Slurm's answer
constexpr auto kAskQueue = std::chrono::seconds(2);

std::string program() { return program_beside_this_one("gyrotherm-site"); }

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream all(text);
  for (std::string line; all >> line;) lines.push_back(line);
  return lines;
}

/// Returns the number of an array from the output of `sbatch --parsable`: NUMBER, or NUMBER;CLUSTER.
Result<std::string> number_of_array(const std::string& said) {
  auto number = said.substr(0, said.find_first_of(";\n"));
  const bool is_one = !number.empty() && std::ranges::all_of(number, [](char c) { return c >= '0' && c <= '9'; });
  if (is_one) return number;
  return failure(FaultKind::refused, "sbatch",
                 fmt::format("expected the number of a job, found \"{}\"", trimmed(said, " \n")));
}

/// Escapes a file name for Slurm.
std::string as_pattern(const std::string& file) {
  std::string text;
  for (const char c : file) text += c == '%' ? std::string("%%") : std::string(1, c);
  return text;
}

/// Quotes a word for a shell.
std::string for_a_shell(const std::string& word) {
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

Result<std::vector<std::size_t>> left_of(const Job& job, const std::string& folder) {
  std::vector<std::size_t> left;
  for (std::size_t i = 0; i < job.tasks.size(); ++i) {
    const auto end = end_of(folder, job.tasks[i]);
    if (!end) return failure(end.error());
    if (!*end) left.push_back(i);
  }
  return left;
}

/// The workers of a job, which work until they have finished the tasks that they were given.
class Workers {
 public:
  Workers() = default;
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;
  virtual ~Workers() = default;
  /// Returns true if workers of an earlier call still run.
  [[nodiscard]] virtual Result<bool> are_at_it() = 0;
  virtual Result<void> begin(const std::vector<std::size_t>& tasks) = 0;
  [[nodiscard]] virtual Result<bool> are_through() = 0;
};

class Slurm : public Workers {
 public:
  Slurm(const Job& job, std::string folder, const std::vector<std::string>& words)
      : job_(job), folder_(std::move(folder)), words_(words) {}

  [[nodiscard]] Result<bool> are_at_it() override {
    if (const auto text = read_text_file(ids_file())) ids_ = lines_of(*text);
    if (ids_.empty()) return false;
    return is_any_queued();
  }

  Result<void> begin(const std::vector<std::size_t>& tasks) override {
    const auto script = folder_ + "/job.sh";
    if (auto written = replace_text_file(script, slurm_script(job_, folder_)); !written) return written;
    ids_.clear();
    for (std::size_t first = 0; first < tasks.size();) {
      std::vector<std::size_t> part;
      const auto from = tasks[first] / kLargestArray * kLargestArray;
      for (; first < tasks.size() && tasks[first] < from + kLargestArray; ++first) part.push_back(tasks[first] - from);
      std::vector<std::string> command{"sbatch", "--parsable", "--array=" + ranges_of(part),
                                       "--output=" + as_pattern(folder_ + "/slurm.log")};
      command.insert(command.end(), words_.begin(), words_.end());
      command.insert(command.end(), {script, std::to_string(from)});
      const auto number = printed_by(command, kPatience).and_then(number_of_array);
      if (!number) return failure(number.error());
      ids_.push_back(*number);
      if (auto kept = replace_text_file(ids_file(), fmt::format("{}\n", fmt::join(ids_, "\n"))); !kept) return kept;
    }
    return {};
  }

  /// An array that Slurm has forgotten is finished.
  [[nodiscard]] Result<bool> are_through() override {
    const auto now = std::chrono::steady_clock::now();
    if (now - asked_ < kAskQueue) return false;
    asked_ = now;
    return is_any_queued().map([](bool any) { return !any; });
  }

 private:
  [[nodiscard]] std::string ids_file() const { return folder_ + "/slurm"; }

  /// Returns true if an array is queued. It has the number that sbatch returned, which its elements share.
  [[nodiscard]] Result<bool> is_any_queued() const {
    const auto queue = printed_by({"squeue", "--noheader", "--format=%F", "--me"}, kPatience);
    if (!queue) return failure(queue.error());
    const auto queued = lines_of(*queue);
    return std::ranges::any_of(ids_, [&](const auto& id) { return std::ranges::count(queued, id) > 0; });
  }

  const Job& job_;
  std::string folder_;
  const std::vector<std::string>& words_;
  std::vector<std::string> ids_;
  std::chrono::steady_clock::time_point asked_{};
};

class Parallel : public Workers {
 public:
  Parallel(const Job& job, std::string folder, const std::vector<std::string>& words)
      : job_(job), folder_(std::move(folder)), words_(words) {}
  ~Parallel() override {
    if (child_ <= 0) return;
    ::kill(child_, SIGTERM);
    static_cast<void>(wait_for(child_));
  }

  [[nodiscard]] Result<bool> are_at_it() override { return false; }  // they end with their caller

  Result<void> begin(const std::vector<std::size_t>& tasks) override {
    const auto jobs = std::max(1U, std::thread::hardware_concurrency() / static_cast<unsigned>(job_.threads));
    std::vector<std::string> command{"parallel", "--will-cite", "--jobs", std::to_string(jobs), "--halt", "never"};
    command.insert(command.end(), words_.begin(), words_.end());
    const std::vector<std::string> task{for_a_shell(program()), "task", for_a_shell(folder_), ":::"};
    command.insert(command.end(), task.begin(), task.end());
    for (const auto number : tasks) command.push_back(std::to_string(number));
    return start(command, {.log = folder_ + "/parallel.log"}).map([&](pid_t child) { child_ = child; });
  }

  [[nodiscard]] Result<bool> are_through() override {
    siginfo_t info{};
    if (::waitid(P_PID, static_cast<id_t>(child_), &info, WEXITED | WNOHANG | WNOWAIT) != 0 || info.si_pid == 0)
      return false;
    static_cast<void>(wait_for(child_));
    child_ = 0;
    return true;
  }

 private:
  const Job& job_;
  std::string folder_;
  const std::vector<std::string>& words_;
  pid_t child_{};
};

std::unique_ptr<Workers> workers_of(const Job& job, const std::string& folder, const Spreading& how) {
  if (how.by == By::slurm) return std::make_unique<Slurm>(job, folder, how.words);
  return std::make_unique<Parallel>(job, folder, how.words);
}

}  // namespace

const char* name(By by) { return by == By::slurm ? "slurm" : "parallel"; }

Result<Progress> progress_of(const Job& job, const std::string& folder) {
  Progress progress{.all = job.tasks.size()};
  for (const Task& task : job.tasks) {
    const auto end = end_of(folder, task);
    if (!end) return failure(end.error());
    if (*end) ++((*end)->is_good() ? progress.good : progress.bad);
  }
  return progress;
}

std::string ranges_of(const std::vector<std::size_t>& numbers) {
  std::string text;
  for (std::size_t first = 0; first < numbers.size();) {
    std::size_t last = first;
    while (last + 1 < numbers.size() && numbers[last + 1] == numbers[last] + 1) ++last;
    if (!text.empty()) text += ',';
    text += first == last ? std::to_string(numbers[first]) : fmt::format("{}-{}", numbers[first], numbers[last]);
    first = last + 1;
  }
  return text;
}

std::string slurm_script(const Job& job, const std::string& folder) {
  return fmt::format(
      "#!/bin/sh\n"
      "# {}: {} tasks. sbatch --array=0-{} --output=slurm.log job.sh 0\n"
      "#SBATCH --job-name=gyrotherm\n"
      "#SBATCH --cpus-per-task={}\n"
      "#SBATCH --requeue\n"
      "#SBATCH --open-mode=append\n"
      "exec {} task {} \"$(($1 + SLURM_ARRAY_TASK_ID))\"\n",
      job.title, job.tasks.size(), job.tasks.size() - 1, job.threads, for_a_shell(program()), for_a_shell(folder));
}

Result<Progress> spread(const Job& job, const std::string& folder, const Spreading& how,
                        const std::function<void(const Progress&)>& tell) {
  const auto absolute = fs::absolute(folder).string();
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const auto left = left_of(job, absolute);
    if (!left) return failure(left.error());
    if (left->empty()) return progress_of(job, absolute);
    const auto workers = workers_of(job, absolute, how);
    const auto at_it = workers->are_at_it();
    if (!at_it) return failure(at_it.error());
    if (!*at_it)
      if (auto begun = workers->begin(*left); !begun) return failure(begun.error());
    if (!how.waits) return progress_of(job, absolute);
    for (bool through = false; !through;) {
      const auto asked = workers->are_through();
      if (!asked) return failure(asked.error());
      // Set before the progress is read, so that a task that ends in between is seen.
      through = *asked;
      const auto progress = progress_of(job, absolute);
      if (!progress) return progress;
      tell(*progress);
      if (progress->left() == 0) return progress;
      if (!through && ready(how.stop, POLLIN, Deadline(kLook)))
        return failure(FaultKind::interrupted, folder, "is not waited for any more");
    }
  }
  return failure(FaultKind::refused, folder,
                 fmt::format("tasks have died {} times; {}/tasks and {} have their last words", kAttempts, folder,
                             how.by == By::slurm ? "slurm.log" : "parallel.log"));
}

}  // namespace gyrotherm::site
