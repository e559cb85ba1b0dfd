// SPDX-License-Identifier: Apache-2.0
#include "apps/site/job/job.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <set>
#include <system_error>

#include "acquisition/record/record.hpp"
#include "acquisition/record/record_files.hpp"
#include "core/child_process.hpp"
#include "core/file.hpp"
#include "core/json.hpp"
#include "core/process.hpp"

namespace gyrotherm::site {

namespace {

namespace fs = std::filesystem;

constexpr int kInterruptedExitCode = 5, kFirstSignal = 128;

std::string job_path(const std::string& folder) { return folder + "/job.json"; }
std::string task_file(const std::string& folder, const Task& task, const char* suffix) {
  return fmt::format("{}/tasks/{}{}", folder, task.name, suffix);
}

std::string machine_name() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "unknown";
}

std::vector<std::string> gyrotherm_command(const Step& step) {
  std::vector<std::string> command{sibling_program_path("gyrotherm")};
  command.insert(command.end(), step.arguments.begin(), step.arguments.end());
  return command;
}

/// Runs a command. Its output file has a temporary name until the command has succeeded.
Result<int> run_step(const Job& job, const Step& step, const std::string& log) {
  LaunchSettings launch{.folder = job.folder, .output = {}, .log = log};
  const auto output = step.output.empty() ? fs::path() : fs::path(job.folder) / step.output;
  if (!output.empty()) {
    std::error_code error;
    fs::create_directories(output.parent_path(), error);
    launch.output = fmt::format("{}.{}.{}.part", output.string(), machine_name(), ::getpid());
  }
  const auto code = run_and_wait(gyrotherm_command(step), launch);
  if (!code || launch.output.empty()) return code;
  const bool has_succeeded = *code == 0 || *code == TaskEnd::kOutsideLimits;
  if (has_succeeded && std::rename(launch.output.c_str(), output.c_str()) != 0)
    return failure(FaultKind::storage, output, std::generic_category().message(errno));
  if (!has_succeeded) ::unlink(launch.output.c_str());
  return code;
}

}  // namespace

void describe(auto& form, Like<Step> auto& step) {
  form("words", step.arguments);
  form("output", step.output);
}

void describe(auto& form, Like<Task> auto& task) {
  form("name", task.name);
  form("steps", task.steps);
  form.expect("name", !task.name.empty() && task.name.find('/') == std::string::npos,
              "expected a file name without '/'");
  form.expect("steps", !task.steps.empty(), "expected a command");
}

void describe(auto& form, Like<Job> auto& job) {
  form.derived("schema", kJobSchema);
  form("title", job.title);
  form("in", job.folder);
  form("threads", job.threads);
  form("tasks", job.tasks);
  form("then", job.final_steps);
}

void describe(auto& form, Like<TaskEnd> auto& end) {
  form("exit_code", end.exit_code);
  form("wall_s", end.wall_s);
  form("machine", end.machine);
}

Result<void> write_job(const Job& job, const std::string& folder) {
  const auto text = json_text(make_json(job), 1) + "\n";
  std::error_code error;
  fs::create_directories(folder + "/tasks", error);
  if (error) return failure(FaultKind::storage, folder, "cannot be created: " + error.message());
  const auto before = read_text_file_if_any(job_path(folder), kLargestTable);
  if (!before) return failure(before.error());
  if (*before && **before != text)
    return failure(FaultKind::usage, folder, "contains another job; choose another folder or remove this one");
  return *before ? Result<void>() : replace_text_file(job_path(folder), text);
}

Result<Job> read_job(const std::string& folder) {
  const auto path = job_path(folder);
  const auto text = read_text_file(path, kLargestTable);
  if (!text) return failure(text.error());
  const auto root = JsonNode::parse(*text, path);
  if (!root) return failure(root.error());
  Job job;
  if (const auto schema = (*root)["schema"].text(); schema != kJobSchema)
    (*root)["schema"].note_error(fmt::format("\"{}\", expected \"{}\"", schema, kJobSchema));
  read_json(*root, job);
  if (auto verdict = root->verdict(); !verdict) return failure(verdict.error());
  return job;
}

Result<std::optional<TaskEnd>> read_task_end(const std::string& folder, const Task& task) {
  const auto path = task_file(folder, task, ".json");
  const auto text = read_text_file_if_any(path);
  if (!text) return failure(text.error());
  if (!*text) return std::nullopt;
  const auto root = JsonNode::parse(**text, path);
  if (!root) return failure(root.error());
  TaskEnd end;
  read_json(*root, end);
  if (auto verdict = root->verdict(); !verdict) return failure(verdict.error());
  return end;
}

void remove_task_end(const std::string& folder, const Task& task) {
  ::unlink(task_file(folder, task, ".json").c_str());
}

Result<TaskEnd> run_task(const Job& job, const std::string& folder, std::size_t index) {
  if (index >= job.tasks.size())
    return failure(
        FaultKind::usage, folder,
        fmt::format("task {} does not exist; the job has {} tasks, numbered from 0", index, job.tasks.size()));
  const Task& task = job.tasks[index];
  const auto before = read_task_end(folder, task);
  if (!before) return failure(before.error());
  if (*before) return **before;
  const auto began = std::chrono::steady_clock::now();
  TaskEnd end{.machine = machine_name()};
  for (const Step& step : task.steps) {
    const auto code = run_step(job, step, fs::absolute(task_file(folder, task, ".log")));
    if (!code) return failure(code.error());
    if (*code == kInterruptedExitCode || *code >= kFirstSignal)
      return failure(FaultKind::interrupted, task.name, fmt::format("stopped with exit code {}", *code));
    end.exit_code = *code;
    if (!end.has_succeeded()) break;
  }
  end.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  if (auto written = replace_text_file(task_file(folder, task, ".json"), json_text(make_json(end), 1) + "\n"); !written)
    return failure(written.error());
  return end;
}

Result<int> run_step(const Job& job, const Step& step) {
  return run_and_wait(gyrotherm_command(step), {.folder = job.folder});
}

namespace {

using Arguments = std::vector<std::string>;

Arguments operator+(Arguments arguments, const Arguments& more) {
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

Job make_empty_job(std::string title, const PlanOptions& options) {
  return {.title = std::move(title),
          .folder = fs::current_path().string(),
          .threads = options.threads,
          .tasks = {},
          .final_steps = {}};
}

struct Axis {
  std::string label;  ///< "u1.x"
  Arguments options;  ///< options that select it
};

std::vector<Axis> list_axes(const record::RunInfo& info) {
  std::vector<Axis> axes;
  for (const auto& unit : info.units)
    for (std::size_t i = record::is_unused(info, unit.name) ? unit.axes.size() : 0; i < unit.axes.size(); ++i) {
      Axis axis{.label = record::axis_label(unit, i), .options = {"--unit", unit.name}};
      if (unit.axes.size() > 1) axis.options = axis.options + Arguments{"--axis", unit.axes[i].name};
      axes.push_back(std::move(axis));
    }
  return axes;
}

Arguments qualify_command(const std::string& rig, const std::string& lot, const PlanOptions& options) {
  return Arguments{"qualify", "--rig", rig, "--out", lot} + options.arguments;
}

/// Fails like record::read_info() if a record cannot be read. Otherwise every task would fail on it.
Result<void> check_records(const std::vector<std::string>& records) {
  for (const std::string& record : records)
    if (const auto info = record::read_info(record); !info) return failure(info.error());
  return {};
}

Arguments thread_options(const PlanOptions& options) { return {"--threads", std::to_string(options.threads)}; }

}  // namespace

Step make_lot_records_step(const std::string& rig, const std::string& lot, const PlanOptions& options) {
  return {.arguments = qualify_command(rig, lot, options) + Arguments{"--records-only"}, .output = {}};
}

Result<Job> plan_lot(const std::string& rig, const std::string& lot, const PlanOptions& options) {
  const auto info = record::read_info(record::ramp_record_path(lot));
  if (!info) return failure(info.error());
  const auto axes = list_axes(*info);
  if (axes.size() < 2) return failure(FaultKind::usage, rig, "has only one axis; run gyrotherm qualify instead");
  auto job = make_empty_job("every axis of " + lot, options);
  for (const Axis& axis : axes)
    job.tasks.push_back({.name = axis.label,
                         .steps = {{.arguments = qualify_command(rig, lot, options) + thread_options(options) +
                                                 Arguments{"--quiet", "--only", axis.label},
                                    .output = {}}}});
  job.final_steps = {{.arguments = qualify_command(rig, lot, options), .output = {}}};
  return job;
}

Result<Job> plan_seeds(const Seeds& seeds, const std::string& out, const PlanOptions& options) {
  constexpr std::uint64_t kMaxSeeds = 100'000;
  if (seeds.last < seeds.first || seeds.last - seeds.first >= kMaxSeeds)
    return failure(FaultKind::usage, "--first, --last",
                   fmt::format("{} to {}, expected 1 to {} seeds", seeds.first, seeds.last, kMaxSeeds));
  for (const auto* records : {&seeds.records, &seeds.verify})
    if (auto good = check_records(*records); !good) return failure(good.error());
  auto job = make_empty_job(fmt::format("seeds {} to {}", seeds.first, seeds.last), options);
  for (std::uint64_t i = 0; i <= seeds.last - seeds.first; ++i) {
    const auto seed = seeds.first + i;
    const auto name = fmt::format("seed-{}", seed);
    const auto model = fmt::format("{}/{}/model.json", out, name);
    Task task{.name = name, .steps = {}};
    task.steps.push_back({.arguments = Arguments{"train"} + seeds.records + options.arguments +
                                       thread_options(options) +
                                       Arguments{"--quiet", "--seed", std::to_string(seed), "--force", "--out", model},
                          .output = fmt::format("{}/{}/train.txt", out, name)});
    if (!seeds.verify.empty())
      task.steps.push_back({.arguments = Arguments{"verify", model} + seeds.verify + Arguments{"--json"},
                            .output = fmt::format("{}/{}/verify.json", out, name)});
    job.tasks.push_back(std::move(task));
  }
  return job;
}

Result<Job> plan_leave_one_out(const std::vector<std::string>& records, double hours, const std::string& out,
                               const PlanOptions& options) {
  // Leaves three records for the prior.
  constexpr std::size_t kMinRecords = 4;
  constexpr double kClustersPerHour = 36;
  constexpr double kMaxHours = 100'000;
  if (records.size() < kMinRecords)
    return failure(FaultKind::usage, {},
                   fmt::format("{} records, expected {} or more, one per unit", records.size(), kMinRecords));
  if (!(hours * kClustersPerHour >= 1 && hours <= kMaxHours))
    return failure(FaultKind::usage, "--hours",
                   fmt::format("{:g}, expected at least one cluster (100 s) and at most {:g} h", hours, kMaxHours));
  if (auto good = check_records(records); !good) return failure(good.error());
  const auto clusters = std::lround(hours * kClustersPerHour);
  std::set<std::string> names;
  auto job = make_empty_job(fmt::format("{} units, each left out", records.size()), options);
  for (const auto& record : records) {
    const auto name = fs::path(record).stem().string();
    if (!names.insert(name).second)
      return failure(FaultKind::usage, record,
                     "another record has this file name; results are named after the record, so rename one");
    Arguments others;
    for (const auto& other : records)
      if (other != record) others.push_back(fmt::format("{}={}", fs::path(other).stem().string(), other));
    const auto file = [&](const char* what) { return fmt::format("{}/{}/{}", out, name, what); };
    job.tasks.push_back(
        {.name = name,
         .steps = {
             {.arguments = Arguments{"type-prior"} + others + options.arguments +
                           Arguments{"--quiet", "--force", "--out", file("prior.json")},
              .output = file("prior.txt")},
             {.arguments = {"train", record, "--prior", file("prior.json"), "--clusters", fmt::format("0:{}", clusters),
                            "--quiet", "--force", "--out", file("model.json")},
              .output = file("train.txt")},
             {.arguments = {"verify", file("model.json"), record, "--clusters", fmt::format("{}:", clusters), "--json"},
              .output = file("verify.json")}}});
  }
  return job;
}

Result<Job> plan_placement(const std::vector<std::string>& records, const std::string& out,
                           const PlanOptions& options) {
  if (auto good = check_records(records); !good) return failure(good.error());
  const auto info = record::read_info(records.front());
  if (!info) return failure(info.error());
  auto job = make_empty_job("placement on " + records.front(), options);
  for (const Axis& axis : list_axes(*info))
    job.tasks.push_back({.name = axis.label,
                         .steps = {{.arguments = Arguments{"placement"} + records + axis.options + options.arguments +
                                                 thread_options(options) + Arguments{"--quiet", "--json"},
                                    .output = fmt::format("{}/{}.json", out, axis.label)}}});
  return job;
}

}  // namespace gyrotherm::site
