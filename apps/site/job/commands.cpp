// SPDX-License-Identifier: Apache-2.0
#include "apps/site/job/commands.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/signalfd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "apps/site/job/distribute.hpp"
#include "apps/site/job/job.hpp"
#include "core/clock.hpp"
#include "core/file.hpp"
#include "core/process.hpp"
#include "core/program_start.hpp"

namespace gyrotherm::site {

namespace {

namespace fs = std::filesystem;

struct JobOptions {
  std::string by, out, rig, lot;
  std::vector<std::string> scheduler_options, records, verify;
  bool detach = false, again = false, wait = false;
  std::uint64_t first_seed = 1, last_seed = 20;
  double hours = 4;
  std::size_t number = 0;
  PlanOptions plan;
};

Result<DistributionSettings> make_distribution_settings(const JobOptions& options) {
  DistributionSettings settings{
      .scheduler = {}, .scheduler_options = options.scheduler_options, .waits = !options.detach};
  const bool has_slurm = !find_program_in_path("sbatch").empty();
  settings.scheduler = options.by == name(Scheduler::slurm) || (options.by.empty() && has_slurm) ? Scheduler::slurm
                                                                                                 : Scheduler::parallel;
  if (settings.scheduler == Scheduler::slurm && !has_slurm)
    return failure(FaultKind::usage, "--by slurm",
                   "sbatch is not installed; install slurm-client or use --by parallel");
  if (settings.scheduler == Scheduler::parallel && find_program_in_path("parallel").empty())
    return failure(FaultKind::usage, "--by parallel",
                   "GNU parallel is not installed; install parallel or slurm-client");
  if (options.detach && settings.scheduler == Scheduler::parallel)
    return failure(FaultKind::usage, "--detach", "requires --by slurm: parallel ends with this program");
  return settings;
}

/// Prints the time and the progress, such as "7 of 24 tasks done, 1 failed".
void print_progress(const Progress& progress) {
  const std::string failed = progress.failed > 0 ? fmt::format(", {} failed", progress.failed) : "";
  write_to_stderr(fmt::format("{} {} of {} tasks done{}\n", civil_time(SteadyClock().now().utc), progress.succeeded,
                              progress.all, failed));
}

/// Prints the failed tasks. Returns the exit code of the first one, or 0 if none failed.
Result<int> report_failures(const Job& job, const std::string& folder) {
  std::vector<std::string> failed;
  int code = 0;
  for (const Task& task : job.tasks) {
    const auto end = read_task_end(folder, task);
    if (!end) return failure(end.error());
    if (!*end || (*end)->has_succeeded()) continue;
    if (failed.empty()) code = (*end)->exit_code;
    failed.push_back(fmt::format("{} (exit code {})", task.name, (*end)->exit_code));
  }
  if (!failed.empty())
    write_to_stderr(fmt::format("{} of {} tasks failed: {}; see their logs in {}/tasks\n", failed.size(),
                                job.tasks.size(), fmt::join(failed, ", "), folder));
  return code;
}

/// Distributes the tasks of a job, waits for them, and runs the final steps.
Result<int> run_job(const Job& job, const std::string& folder, const JobOptions& options) {
  auto settings = make_distribution_settings(options);
  if (!settings) return failure(settings.error());
  sigset_t ends;
  sigemptyset(&ends);
  sigaddset(&ends, SIGINT);
  sigaddset(&ends, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &ends, nullptr);
  const Descriptor stop(::signalfd(-1, &ends, SFD_CLOEXEC | SFD_NONBLOCK));
  settings->stop = stop.number();
  Progress reported{};
  const auto progress = distribute(job, folder, *settings, [&](const Progress& now) {
    if (now != std::exchange(reported, now)) print_progress(now);
  });
  pthread_sigmask(SIG_UNBLOCK, &ends, nullptr);
  if (!progress && progress.error().kind == FaultKind::interrupted && settings->scheduler == Scheduler::slurm)
    write_to_stderr(fmt::format("the tasks continue; wait for them with: gyrotherm site job {} --wait\n", folder));
  if (!progress) return failure(progress.error());
  if (!settings->waits) {
    write_to_stderr(fmt::format("submitted; print the progress with: gyrotherm site job {}\n", folder));
    return 0;
  }
  int code = 0;
  for (const Step& step : job.final_steps) {
    const auto ended = run_step(job, step);
    if (!ended) return ended;
    code = std::max(code, *ended);
  }
  const auto failed = report_failures(job, folder);
  return failed && *failed != 0 ? failed : code;
}

Result<int> start_job(const Result<Job>& job, const std::string& out, const JobOptions& options) {
  if (!job) return failure(job.error());
  if (const auto settings = make_distribution_settings(options); !settings) return failure(settings.error());
  const auto folder = out + "/job";
  if (auto written = write_job(*job, folder); !written) return failure(written.error());
  return run_job(*job, folder, options);
}

Result<int> train_lot(const JobOptions& options) {
  const auto settings = make_distribution_settings(options);
  if (!settings) return failure(settings.error());
  Job recording{.title = {}, .folder = fs::current_path().string(), .tasks = {}, .final_steps = {}};
  const auto recorded = run_step(recording, make_lot_records_step(options.rig, options.lot, options.plan));
  if (!recorded || *recorded != 0) return recorded;
  return start_job(plan_lot(options.rig, options.lot, options.plan), options.lot, options);
}

Result<int> continue_job(const JobOptions& options) {
  const auto job = read_job(options.out);
  if (!job) return failure(job.error());
  std::string lines;
  for (const Task& task : job->tasks) {
    const auto end = read_task_end(options.out, task);
    if (!end) return failure(end.error());
    if (options.again && *end && !(*end)->has_succeeded()) remove_task_end(options.out, task);
    const auto state = !*end ? "not done" : (*end)->has_succeeded() ? "done" : "failed";
    const auto detail =
        *end ? fmt::format("{:8.1f} s on {}, exit code {}", (*end)->wall_s, (*end)->machine, (*end)->exit_code) : "";
    lines += fmt::format("{:<24} {:<9}{}\n", task.name, state, detail);
  }
  if (auto written = write_to_stdout(lines); !written) return failure(written.error());
  if (options.again || options.wait) return run_job(*job, options.out, options);
  return 0;
}

Result<int> run_task_command(const JobOptions& options) {
  const auto job = read_job(options.out);
  if (!job) return failure(job.error());
  const auto end = run_task(*job, options.out, options.number);
  if (!end) return failure(end.error());
  return end->has_succeeded() ? 0 : end->exit_code;
}

void add_distribution_options(CLI::App& command, JobOptions& options) {
  command
      .add_option("--by", options.by,
                  "scheduler of the tasks: slurm or parallel (GNU parallel; default: slurm if sbatch is installed)")
      ->check(CLI::IsMember({name(Scheduler::slurm), name(Scheduler::parallel)}));
  command
      .add_option("--with", options.scheduler_options,
                  "an argument for sbatch or parallel, such as --with=--partition=lab")
      ->allow_extra_args(false);
}

void add_plan_options(CLI::App& command, JobOptions& options) {
  add_distribution_options(command, options);
  command.add_flag("--detach", options.detach, "submit to Slurm and do not wait");
  command.add_option("--threads", options.plan.threads, "threads of each task")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
}

}  // namespace

void add_job_commands(CLI::App& program, std::vector<std::string> task_arguments, Action& action) {
  const auto options = std::make_shared<JobOptions>();
  options->plan.arguments = std::move(task_arguments);
  const auto add = [&](const char* name, const char* help, Result<int> (*act)(const JobOptions&)) -> CLI::App& {
    auto& command = *program.add_subcommand(name, help);
    command.callback([options, act, &action] { action = [options, act] { return act(*options); }; });
    return command;
  };

  auto& train =
      add("train",
          "Example: gyrotherm-site train --rig lot.toml --lot lot --by slurm -- --seed 3\n\n"
          "Trains the models of every axis of a lot, one task per axis, and writes the summary as qualify does.",
          train_lot);
  train.add_option("--rig", options->rig, "the rig")->required();
  train.add_option("--lot", options->lot, "the folder of the experiment (qualify --out)")->required();
  add_plan_options(train, *options);

  auto& seeds =
      add("seeds",
          "Example: gyrotherm-site seeds ramp.db --verify random.db --last 50 --out seeds -- --inputs "
          "multi-point-t\n\nTrains one model per seed of the swarm and verifies each.",
          [](const JobOptions& o) {
            return start_job(
                plan_seeds({.records = o.records, .verify = o.verify, .first = o.first_seed, .last = o.last_seed},
                           o.out, o.plan),
                o.out, o);
          });
  seeds.add_option("records", options->records, "the training records")->required();
  seeds.add_option("--verify", options->verify, "the record on which each model is verified");
  seeds.add_option("--first", options->first_seed, "the first seed")->capture_default_str();
  seeds.add_option("--last", options->last_seed, "the last seed")->capture_default_str();
  seeds.add_option("--out", options->out, "the folder for all results")->required();
  add_plan_options(seeds, *options);

  auto& units = add(
      "leave-one-out",
      "Example: gyrotherm-site leave-one-out u1.db u2.db u3.db u4.db --out units\n\n"
      "Leaves out each unit in turn: learns the type prior from the others, trains a model on the first hours of "
      "the unit with this prior, and verifies it on the remaining hours.",
      [](const JobOptions& o) { return start_job(plan_leave_one_out(o.records, o.hours, o.out, o.plan), o.out, o); });
  units.add_option("records", options->records, "one record of each unit")->required();
  units
      .add_option("--hours", options->hours, "length of the part of each record that trains the unit's model, in hours")
      ->capture_default_str();
  units.add_option("--out", options->out, "the folder for all results")->required();
  add_plan_options(units, *options);

  auto& placement =
      add("placement",
          "Example: gyrotherm-site placement ramp.db --out placement -- --confirm\n\n"
          "Ranks the thermometers for each axis of the records.",
          [](const JobOptions& o) { return start_job(plan_placement(o.records, o.out, o.plan), o.out, o); });
  placement.add_option("records", options->records, "the records")->required();
  placement.add_option("--out", options->out, "the folder for all results")->required();
  add_plan_options(placement, *options);

  auto& job = add("job", "Example: gyrotherm-site job lot/job --wait\n\nPrints the progress of a job.", continue_job);
  job.add_option("job", options->out, "the folder of the job")->required();
  job.add_flag("--wait", options->wait, "submit the unfinished tasks, wait for them, and carry out the final steps");
  job.add_flag("--again", options->again, "also repeat failed tasks");
  add_distribution_options(job, *options);

  auto& task = add(
      "task",
      "Example: gyrotherm-site task lot/job 7\n\nCarries out one task of a job. Slurm and parallel call this command.",
      run_task_command);
  task.add_option("job", options->out, "the folder of the job")->required();
  task.add_option("number", options->number, "number of the task, from 0")->required();
}

bool passes_arguments(std::string_view command) {
  constexpr std::array kPassing{"train", "seeds", "leave-one-out", "placement"};
  return std::ranges::count(kPassing, command) > 0;
}

}  // namespace gyrotherm::site
