// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/qualify/lot_experiment.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "apps/console/interrupt.hpp"
#include "apps/gyrotherm/qualify/axis_experiment.hpp"
#include "core/file.hpp"

namespace gyrotherm::app {
namespace {

/// The three models and the recommended one.
constexpr std::size_t kMostUncompared = 4;

/// Work on one axis and its result.
struct Task {
  data::AxisChoice of;
  std::string folder;  ///< relative to the lot's folder
  std::optional<report::Report> report;
  std::string trouble;
};

std::vector<Task> list_tasks(const LotExperiment& experiment) {
  std::vector<Task> tasks;
  const auto axes = experiment.only.empty() ? data::list_axes(experiment.rate.record.info) : experiment.only;
  for (const auto& of : axes)
    tasks.push_back(
        {.of = of, .folder = of.axis.empty() ? of.unit : of.unit + "/" + of.axis, .report = {}, .trouble = {}});
  return tasks;
}

/// Returns an existing report if it was made from the same records with the same training options.
std::optional<report::Report> find_report(const LotExperiment& experiment, const Task& task) {
  const auto path = fmt::format("{}/{}/report/report.json", experiment.out, task.folder);
  if (!std::filesystem::exists(path)) return std::nullopt;
  const auto text = read_text_file(path, kLargestTable);
  if (!text) return std::nullopt;
  auto report = report::read_report(*text, path);
  if (!report) return std::nullopt;
  const auto& training = experiment.training;
  const bool same_later =
      std::ranges::equal(report->later, experiment.later,
                         [](const auto& reported, const LotRun& run) { return reported.record_sha256 == run.sha256; });
  const bool compared = report->methods.size() > kMostUncompared,
             nested = report->nested_leave_cycle_out.multi_point.has_value();
  const bool same = report->rate.record_sha256 == experiment.rate.sha256 &&
                    report->random.record_sha256 == experiment.random.sha256 && same_later &&
                    report->program_version == training.program_version && report->seed == training.seed &&
                    report->quick == training.quick && (nested || !training.nested) && compared == experiment.compare;
  return same ? std::optional(std::move(*report)) : std::nullopt;
}

Result<ExperimentRun> axis_run(const LotRun& run, const data::AxisChoice& of) {
  return extract_axis(run.record, run.path, of).map([&](data::RecordedRun recorded) {
    return ExperimentRun{.stage = run.stage,
                         .profile = run.profile,
                         .days_later = run.days_later,
                         .recorded = std::move(recorded),
                         .sha256 = run.sha256,
                         .file_sha256 = run.file_sha256};
  });
}

Result<AxisExperiment> axis_experiment(const LotExperiment& lot, const data::AxisChoice& of) {
  auto rate = axis_run(lot.rate, of);
  if (!rate) return failure(rate.error());
  auto random = axis_run(lot.random, of);
  if (!random) return failure(random.error());
  AxisExperiment experiment{.rate = std::move(*rate), .random = std::move(*random), .later = {}, .further = {}};
  for (const LotRun& run : lot.later) {
    auto later = axis_run(run, of);
    if (!later) return failure(later.error());
    experiment.later.push_back(std::move(*later));
  }
  return experiment;
}

/// Trains axes on several threads. The main thread polls the pool and shows its progress.
class TrainingPool {
 public:
  TrainingPool(const LotExperiment& lot, const rig::RigFile& rig, std::vector<Task>& tasks, std::size_t threads)
      : lot_(lot), rig_(rig), tasks_(tasks), threads_(threads) {}

  /// Trains one axis after another until none is left or a stop is requested.
  void work() {
    for (auto next = next_++; next < tasks_.size() && !stop_; next = next_++) {
      run_task(tasks_[next], threads_for(tasks_.size() - next));
      const std::lock_guard lock(mutex_);
      progress_by_folder_.erase(tasks_[next].folder);
      ++done_;
    }
  }

  void stop() { stop_ = true; }
  [[nodiscard]] bool is_done() const {
    const std::lock_guard lock(mutex_);
    return done_ == tasks_.size();
  }
  /// Returns "training 24 axes in parallel" and the completed fraction.
  [[nodiscard]] std::pair<std::string, double> progress() const {
    const std::lock_guard lock(mutex_);
    auto share = static_cast<double>(done_);
    for (const auto& [folder, part] : progress_by_folder_) share += part;
    return {fmt::format("training {} axes in parallel", tasks_.size()), share / static_cast<double>(tasks_.size())};
  }
  [[nodiscard]] std::optional<Fault> interrupted_by() const {
    const std::lock_guard lock(mutex_);
    return ended_;
  }

 private:
  /// Returns the number of threads for each of `left` axes. The number exceeds 1 only if fewer axes than threads are
  /// left, because some threads would otherwise be idle.
  [[nodiscard]] int threads_for(std::size_t left) const {
    return static_cast<int>(std::max<std::size_t>(1, threads_ / left));
  }

  void run_task(Task& task, int threads) {
    task.report = find_report(lot_, task);
    if (task.report) return;
    auto outcome = train_axis(task, threads);
    if (outcome) {
      task.report = std::move(outcome->report);
      return;
    }
    task.trouble = text(outcome.error());
    if (outcome.error().kind != FaultKind::interrupted && outcome.error().kind != FaultKind::storage) return;
    const std::lock_guard lock(mutex_);
    ended_ = outcome.error();
    stop_ = true;
  }

  Result<AxisOutcome> train_axis(const Task& task, int threads) {
    auto experiment = axis_experiment(lot_, task.of);
    if (!experiment) return failure(experiment.error());
    AxisOptions options{.folder = lot_.out + "/" + task.folder,
                        .compare = lot_.compare,
                        .training = lot_.training,
                        .thermal = lot_.thermal};
    options.training.threads = threads;
    std::error_code error;
    std::filesystem::create_directories(options.folder, error);
    if (error) return failure(FaultKind::storage, options.folder, "cannot be created: " + error.message());
    std::string stage;
    double stages_done = 0;
    const auto sink = [&](std::string_view now, double fraction) {
      constexpr double kStages = 3;  // models of about equal cost
      if (now != stage && !std::exchange(stage, std::string(now)).empty()) ++stages_done;
      const std::lock_guard lock(mutex_);
      progress_by_folder_[task.folder] = std::min(1.0, (std::min(stages_done, kStages - 1) + fraction) / kStages);
      return !stop_;
    };
    std::vector<std::string> warnings;
    return carry_out(*experiment, rig_, options, sink, warnings);
  }

  const LotExperiment& lot_;
  const rig::RigFile& rig_;
  std::vector<Task>& tasks_;
  std::size_t threads_;
  std::atomic<std::size_t> next_{0};
  std::atomic<bool> stop_{false};
  mutable std::mutex mutex_;
  std::size_t done_ = 0;
  /// Completed fraction of each active axis.
  std::map<std::string, double> progress_by_folder_;
  std::optional<Fault> ended_;
};

Result<void> train_in_parallel(Console& console, const LotExperiment& lot, const rig::RigFile& rig,
                               std::vector<Task>& tasks) {
  constexpr auto kPollInterval = std::chrono::milliseconds(100);
  const auto thread_count = lot.training.threads > 0 ? static_cast<unsigned>(lot.training.threads)
                                                     : std::max(1U, std::thread::hardware_concurrency());
  TrainingPool pool(lot, rig, tasks, thread_count);
  {
    std::vector<std::jthread> workers;
    for (unsigned i = 0; i < std::min<std::size_t>(thread_count, tasks.size()); ++i)
      workers.emplace_back([&pool] { pool.work(); });
    while (!pool.is_done() && !pool.interrupted_by()) {
      std::this_thread::sleep_for(kPollInterval);
      const auto [stage, share] = pool.progress();
      console.progress(stage, share);
      if (interrupted()) pool.stop();
    }
  }
  if (const auto ended = pool.interrupted_by()) return failure(*ended);
  return {};
}

/// Returns the seconds of a run in which an axis was not read.
double missing_s(const record::Record& record, const data::AxisChoice& of) {
  const auto& units = record.info.units;
  const auto unit = std::ranges::find(units, of.unit, &record::UnitInfo::name);
  const auto& columns = record.units[static_cast<std::size_t>(unit - units.begin())];
  const auto axis = std::ranges::find(unit->axes, of.axis, &record::AxisInfo::name) - unit->axes.begin();
  return static_cast<double>(
      std::ranges::count_if(columns.rotation[static_cast<std::size_t>(axis)], [](double n) { return std::isnan(n); }));
}

/// Adds a line for each event of a run that concerns a unit, in the order of the record.
void add_events(const LotRun& run, std::vector<std::string>& events) {
  for (const auto& [slot, event] : run.record.events) {
    const bool is_about_unit = record::find_unit(run.record.info, event.about.channel) != nullptr;
    if (is_about_unit) events.push_back(fmt::format("{}, second {}: {}", run.stage, slot, event.text));
  }
}

report::Lot summarise(const LotExperiment& experiment, const rig::RigFile& rig, const std::vector<Task>& tasks) {
  report::Lot lot{.rig_name = rig.name,
                  .rig_title = rig.title,
                  .simulated = rig.simulated,
                  .program_version = experiment.training.program_version,
                  .seed = experiment.training.seed,
                  .quick = experiment.training.quick,
                  .axes = {},
                  .events = {},
                  .order_number = experiment.rate.record.info.order_number};
  for (const Task& task : tasks) {
    const auto* unit = record::find_unit(experiment.rate.record.info, task.of.unit);
    report::LotAxis axis{.unit = task.of.unit,
                         .axis = task.of.axis,
                         .serial_number = unit->serial_number,
                         .model = unit->model,
                         .folder = task.folder,
                         .verdict = "failed",
                         .trouble = task.trouble};
    axis.missing_s = missing_s(experiment.rate.record, task.of) + missing_s(experiment.random.record, task.of);
    if (task.report) copy_results(*task.report, axis);
    lot.axes.push_back(std::move(axis));
  }
  if (!experiment.only.empty()) return lot;
  compare(lot);
  add_events(experiment.rate, lot.events);
  add_events(experiment.random, lot.events);
  return lot;
}

/// Writes the report of each unit with several axes. The report of a single axis is also the report of its unit.
Result<void> write_unit_reports(const LotExperiment& experiment, const report::Lot& lot,
                                const std::vector<Task>& tasks) {
  std::map<std::string, std::vector<std::pair<std::string, report::Report>>> units;
  for (const Task& task : tasks)
    if (task.report && !task.of.axis.empty()) units[task.of.unit].emplace_back(task.of.axis, *task.report);
  for (const auto& [unit, axes] : units) {
    const auto folder = fmt::format("{}/{}/report", experiment.out, unit);
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (auto written = replace_text_file(folder + "/report.html", unit_to_html(lot, unit, axes)); !written)
      return written;
  }
  return {};
}

}  // namespace

Result<std::vector<data::AxisChoice>> find_axes(const std::vector<std::string>& names, const record::RunInfo& info) {
  const auto all = data::list_axes(info);
  std::vector<data::AxisChoice> found;
  for (const std::string& name : names) {
    const auto before = found.size();
    std::ranges::copy_if(all, std::back_inserter(found), [&](const data::AxisChoice& axis) {
      return (axis.unit == name || qualified_name(axis) == name) && std::ranges::find(found, axis) == found.end();
    });
    if (found.size() > before) continue;
    std::vector<std::string> existing;
    for (const auto& axis : all) existing.push_back(qualified_name(axis));
    return failure(FaultKind::usage, "--only",
                   fmt::format("unknown axis or unit \"{}\"; the axes are {}", name, fmt::join(existing, ", ")));
  }
  return found;
}

Result<report::Lot> carry_out(Console& console, const LotExperiment& experiment, const rig::RigFile& rig) {
  auto tasks = list_tasks(experiment);
  if (auto trained = train_in_parallel(console, experiment, rig, tasks); !trained) return failure(trained.error());
  auto lot = summarise(experiment, rig, tasks);
  if (!experiment.only.empty()) return lot;
  const auto written = write_unit_reports(experiment, lot, tasks)
                           .and_then([&] { return replace_text_file(experiment.out + "/lot.json", to_json(lot)); })
                           .and_then([&] { return replace_text_file(experiment.out + "/lot.html", to_html(lot)); });
  if (!written) return failure(written.error());
  return lot;
}

}  // namespace gyrotherm::app
