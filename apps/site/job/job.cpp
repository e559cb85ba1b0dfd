// SPDX-License-Identifier: Apache-2.0
#include "apps/site/job/job.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <system_error>

#include "core/child_process.hpp"
#include "core/file.hpp"
#include "core/json.hpp"
#include "core/process.hpp"

namespace gyrotherm::site {

namespace {

namespace fs = std::filesystem;

constexpr int kInterruptedExitCode = 5, kFirstSignal = 128;

std::string job_path(const std::string& folder) { return folder + "/job.json"; }
std::string file_of(const std::string& folder, const Task& task, const char* suffix) {
  return fmt::format("{}/tasks/{}{}", folder, task.name, suffix);
}

std::string machine_name() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "unknown";
}

std::vector<std::string> with_program(const Step& step) {
  std::vector<std::string> command{program_beside_this_one("gyrotherm")};
  command.insert(command.end(), step.words.begin(), step.words.end());
  return command;
}

/// What a command prints appears where it is wanted once it has printed all.
Result<int> carry_out(const Job& job, const Step& step, const std::string& log) {
  Surroundings around{.folder = job.in, .output = {}, .log = log};
  const auto output = step.output.empty() ? fs::path() : fs::path(job.in) / step.output;
  if (!output.empty()) {
    std::error_code error;
    fs::create_directories(output.parent_path(), error);
    around.output = fmt::format("{}.{}.{}.part", output.string(), machine_name(), ::getpid());
  }
  const auto code = run_to_its_end(with_program(step), around);
  if (!code || around.output.empty()) return code;
  const bool is_whole = *code == 0 || *code == TaskEnd::kOutsideLimits;
  if (is_whole && std::rename(around.output.c_str(), output.c_str()) != 0)
    return failure(FaultKind::storage, output, std::generic_category().message(errno));
  if (!is_whole) ::unlink(around.output.c_str());
  return code;
}

}  // namespace

void describe(auto& form, Like<Step> auto& step) {
  form("words", step.words);
  form("output", step.output);
}

void describe(auto& form, Like<Task> auto& task) {
  form("name", task.name);
  form("steps", task.steps);
  form.expect("name", !task.name.empty() && task.name.find('/') == std::string::npos, "expected the name of a file");
  form.expect("steps", !task.steps.empty(), "expected a command");
}

void describe(auto& form, Like<Job> auto& job) {
  form.derived("schema", kJobSchema);
  form("title", job.title);
  form("in", job.in);
  form("threads", job.threads);
  form("tasks", job.tasks);
  form("then", job.then);
}

void describe(auto& form, Like<TaskEnd> auto& end) {
  form("exit_code", end.exit_code);
  form("wall_s", end.wall_s);
  form("machine", end.machine);
}

Result<void> write_job(const Job& job, const std::string& folder) {
  const auto text = text_of(json_of(job), 1) + "\n";
  std::error_code error;
  fs::create_directories(folder + "/tasks", error);
  if (error) return failure(FaultKind::storage, folder, "cannot be made: " + error.message());
  const auto before = read_text_file_if_any(job_path(folder), kLargestTable);
  if (!before) return failure(before.error());
  if (*before && **before != text)
    return failure(FaultKind::usage, folder, "has another job; choose another folder, or remove this one");
  return *before ? Result<void>() : replace_text_file(job_path(folder), text);
}

Result<Job> read_job(const std::string& folder) {
  const auto path = job_path(folder);
  const auto text = read_text_file(path, kLargestTable);
  if (!text) return failure(text.error());
  const auto root = JsonPlace::parse(*text, path);
  if (!root) return failure(root.error());
  Job job;
  if (const auto schema = (*root)["schema"].text(); schema != kJobSchema)
    (*root)["schema"].mistake(fmt::format("\"{}\", expected \"{}\"", schema, kJobSchema));
  read_json(*root, job);
  if (auto verdict = root->verdict(); !verdict) return failure(verdict.error());
  return job;
}

Result<std::optional<TaskEnd>> end_of(const std::string& folder, const Task& task) {
  const auto path = file_of(folder, task, ".json");
  const auto text = read_text_file_if_any(path);
  if (!text) return failure(text.error());
  if (!*text) return std::nullopt;
  const auto root = JsonPlace::parse(**text, path);
  if (!root) return failure(root.error());
  TaskEnd end;
  read_json(*root, end);
  if (auto verdict = root->verdict(); !verdict) return failure(verdict.error());
  return end;
}

void forget_end(const std::string& folder, const Task& task) { ::unlink(file_of(folder, task, ".json").c_str()); }

Result<TaskEnd> carry_out(const Job& job, const std::string& folder, std::size_t index) {
  if (index >= job.tasks.size())
    return failure(FaultKind::usage, folder, fmt::format("has {} tasks, and no number {}", job.tasks.size(), index));
  const Task& task = job.tasks[index];
  const auto before = end_of(folder, task);
  if (!before) return failure(before.error());
  if (*before) return **before;
  const auto began = std::chrono::steady_clock::now();
  TaskEnd end{.machine = machine_name()};
  for (const Step& step : task.steps) {
    const auto code = carry_out(job, step, fs::absolute(file_of(folder, task, ".log")));
    if (!code) return failure(code.error());
    if (*code == kInterruptedExitCode || *code >= kFirstSignal)
      return failure(FaultKind::interrupted, task.name, fmt::format("was stopped: exit code {}", *code));
    end.exit_code = *code;
    if (!end.is_good()) break;
  }
  end.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  if (auto written = replace_text_file(file_of(folder, task, ".json"), text_of(json_of(end), 1) + "\n"); !written)
    return failure(written.error());
  return end;
}

Result<int> carry_out(const Job& job, const Step& step) {
  return run_to_its_end(with_program(step), {.folder = job.in});
}

}  // namespace gyrotherm::site
