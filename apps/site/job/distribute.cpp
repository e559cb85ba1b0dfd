// SPDX-License-Identifier: Apache-2.0
#include "apps/site/job/distribute.hpp"

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
/// Below the default MaxArraySize of Slurm, 1001.
constexpr std::size_t kMaxArraySize = 1000;
constexpr Duration kPollInterval = std::chrono::milliseconds(200);
constexpr Duration kSlurmTimeout = std::chrono::minutes(2);
constexpr auto kQueryInterval = std::chrono::seconds(2);

std::string program() { return sibling_program_path("gyrotherm-site"); }

std::vector<std::string> split_lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream all(text);
  for (std::string line; all >> line;) lines.push_back(line);
  return lines;
}

/// Parses the job number in the output of `sbatch --parsable`: NUMBER, or NUMBER;CLUSTER.
Result<std::string> parse_array_number(const std::string& output) {
  auto number = output.substr(0, output.find_first_of(";\n"));
  const bool is_number = !number.empty() && std::ranges::all_of(number, [](char c) { return c >= '0' && c <= '9'; });
  if (is_number) return number;
  return failure(FaultKind::refused, "sbatch",
                 fmt::format("expected a job number, found \"{}\"", trimmed(output, " \n")));
}

/// Escapes a file name for Slurm, in which '%' begins a replacement symbol.
std::string escape_percent(const std::string& file) {
  std::string text;
  for (const char c : file) text += c == '%' ? std::string("%%") : std::string(1, c);
  return text;
}

/// Quotes a word for a shell.
std::string quote_for_shell(const std::string& word) {
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

Result<std::vector<std::size_t>> unfinished_tasks(const Job& job, const std::string& folder) {
  std::vector<std::size_t> left;
  for (std::size_t i = 0; i < job.tasks.size(); ++i) {
    const auto end = read_task_end(folder, job.tasks[i]);
    if (!end) return failure(end.error());
    if (!*end) left.push_back(i);
  }
  return left;
}

/// The processes or cluster jobs that run the tasks of a job. They end after the tasks passed to submit().
class Workers {
 public:
  Workers() = default;
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;
  virtual ~Workers() = default;
  /// Returns true if workers of an earlier call still run.
  [[nodiscard]] virtual Result<bool> are_running() = 0;
  virtual Result<void> submit(const std::vector<std::size_t>& tasks) = 0;
  [[nodiscard]] virtual Result<bool> have_finished() = 0;
};

class Slurm : public Workers {
 public:
  Slurm(const Job& job, std::string folder, const std::vector<std::string>& scheduler_options)
      : job_(job), folder_(std::move(folder)), scheduler_options_(scheduler_options) {}

  [[nodiscard]] Result<bool> are_running() override {
    if (const auto text = read_text_file(ids_file())) ids_ = split_lines(*text);
    if (ids_.empty()) return false;
    return is_any_queued();
  }

  Result<void> submit(const std::vector<std::size_t>& tasks) override {
    const auto script = folder_ + "/job.sh";
    if (auto written = replace_text_file(script, slurm_script(job_, folder_)); !written) return written;
    ids_.clear();
    for (std::size_t first = 0; first < tasks.size();) {
      std::vector<std::size_t> part;
      const auto from = tasks[first] / kMaxArraySize * kMaxArraySize;
      for (; first < tasks.size() && tasks[first] < from + kMaxArraySize; ++first) part.push_back(tasks[first] - from);
      std::vector<std::string> command{"sbatch", "--parsable", "--array=" + to_ranges(part),
                                       "--output=" + escape_percent(folder_ + "/slurm.log")};
      command.insert(command.end(), scheduler_options_.begin(), scheduler_options_.end());
      command.insert(command.end(), {script, std::to_string(from)});
      const auto number = read_program_output(command, kSlurmTimeout).and_then(parse_array_number);
      if (!number) return failure(number.error());
      ids_.push_back(*number);
      if (auto kept = replace_text_file(ids_file(), fmt::format("{}\n", fmt::join(ids_, "\n"))); !kept) return kept;
    }
    return {};
  }

  /// Returns true if no array is queued. The queue does not contain finished arrays.
  [[nodiscard]] Result<bool> have_finished() override {
    const auto now = std::chrono::steady_clock::now();
    if (now - queried_ < kQueryInterval) return false;
    queried_ = now;
    return is_any_queued().map([](bool any) { return !any; });
  }

 private:
  [[nodiscard]] std::string ids_file() const { return folder_ + "/slurm"; }

  /// Returns true if an array is queued. All its elements have the number that sbatch returned.
  [[nodiscard]] Result<bool> is_any_queued() const {
    const auto queue = read_program_output({"squeue", "--noheader", "--format=%F", "--me"}, kSlurmTimeout);
    if (!queue) return failure(queue.error());
    const auto queued = split_lines(*queue);
    return std::ranges::any_of(ids_, [&](const auto& id) { return std::ranges::count(queued, id) > 0; });
  }

  const Job& job_;
  std::string folder_;
  const std::vector<std::string>& scheduler_options_;
  std::vector<std::string> ids_;
  std::chrono::steady_clock::time_point queried_{};
};

class Parallel : public Workers {
 public:
  Parallel(const Job& job, std::string folder, const std::vector<std::string>& scheduler_options)
      : job_(job), folder_(std::move(folder)), scheduler_options_(scheduler_options) {}
  ~Parallel() override {
    if (child_ <= 0) return;
    ::kill(child_, SIGTERM);
    static_cast<void>(wait_for(child_));
  }

  // Workers end with the process that started them.
  [[nodiscard]] Result<bool> are_running() override { return false; }

  Result<void> submit(const std::vector<std::size_t>& tasks) override {
    const auto jobs = std::max(1U, std::thread::hardware_concurrency() / static_cast<unsigned>(job_.threads));
    std::vector<std::string> command{"parallel", "--will-cite", "--jobs", std::to_string(jobs), "--halt", "never"};
    command.insert(command.end(), scheduler_options_.begin(), scheduler_options_.end());
    const std::vector<std::string> task{quote_for_shell(program()), "task", quote_for_shell(folder_), ":::"};
    command.insert(command.end(), task.begin(), task.end());
    for (const auto number : tasks) command.push_back(std::to_string(number));
    return start(command, {.log = folder_ + "/parallel.log"}).map([&](pid_t child) { child_ = child; });
  }

  [[nodiscard]] Result<bool> have_finished() override {
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
  const std::vector<std::string>& scheduler_options_;
  pid_t child_{};
};

std::unique_ptr<Workers> make_workers(const Job& job, const std::string& folder, const DistributionSettings& settings) {
  if (settings.scheduler == Scheduler::slurm) return std::make_unique<Slurm>(job, folder, settings.scheduler_options);
  return std::make_unique<Parallel>(job, folder, settings.scheduler_options);
}

}  // namespace

const char* name(Scheduler scheduler) { return scheduler == Scheduler::slurm ? "slurm" : "parallel"; }

Result<Progress> count_progress(const Job& job, const std::string& folder) {
  Progress progress{.all = job.tasks.size()};
  for (const Task& task : job.tasks) {
    const auto end = read_task_end(folder, task);
    if (!end) return failure(end.error());
    if (*end) ++((*end)->has_succeeded() ? progress.succeeded : progress.failed);
  }
  return progress;
}

std::string to_ranges(const std::vector<std::size_t>& numbers) {
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
      job.title, job.tasks.size(), job.tasks.size() - 1, job.threads, quote_for_shell(program()),
      quote_for_shell(folder));
}

Result<Progress> distribute(const Job& job, const std::string& folder, const DistributionSettings& settings,
                            const std::function<void(const Progress&)>& report) {
  const auto absolute = fs::absolute(folder).string();
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const auto left = unfinished_tasks(job, absolute);
    if (!left) return failure(left.error());
    if (left->empty()) return count_progress(job, absolute);
    const auto workers = make_workers(job, absolute, settings);
    const auto running = workers->are_running();
    if (!running) return failure(running.error());
    if (!*running)
      if (auto submitted = workers->submit(*left); !submitted) return failure(submitted.error());
    if (!settings.waits) return count_progress(job, absolute);
    for (bool finished = false; !finished;) {
      const auto is_finished = workers->have_finished();
      if (!is_finished) return failure(is_finished.error());
      // Query the workers before counting, so a task that ends between the two calls is counted.
      finished = *is_finished;
      const auto progress = count_progress(job, absolute);
      if (!progress) return progress;
      report(*progress);
      if (progress->left() == 0) return progress;
      if (!finished && wait_until_ready(settings.stop, POLLIN, Deadline(kPollInterval)))
        return failure(FaultKind::interrupted, folder, "interrupted while waiting for the tasks");
    }
  }
  return failure(FaultKind::refused, folder,
                 fmt::format("tasks died {} times; see the logs in {}/tasks and {}", kAttempts, folder,
                             settings.scheduler == Scheduler::slurm ? "slurm.log" : "parallel.log"));
}

}  // namespace gyrotherm::site
