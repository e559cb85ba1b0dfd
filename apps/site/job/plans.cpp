// SPDX-License-Identifier: Apache-2.0
#include "apps/site/job/plans.hpp"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <set>

#include "acquisition/record/record.hpp"

namespace gyrotherm::site {

namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

Words operator+(Words words, const Words& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

Job empty_job(std::string title, const PlanOptions& options) {
  return {.title = std::move(title),
          .in = fs::current_path().string(),
          .threads = options.threads,
          .tasks = {},
          .then = {}};
}

struct Axis {
  std::string label;  ///< "u1.x"
  Words options;      ///< that choose it
};

std::vector<Axis> axes_of(const record::RunInfo& info) {
  std::vector<Axis> axes;
  for (const auto& unit : info.units)
    for (std::size_t i = 0; i < unit.axes.size(); ++i) {
      Axis axis{.label = record::axis_label(unit, i), .options = {"--unit", unit.name}};
      if (unit.axes.size() > 1) axis.options = axis.options + Words{"--axis", unit.axes[i].name};
      axes.push_back(std::move(axis));
    }
  return axes;
}

Words qualify(const std::string& rig, const std::string& lot, const PlanOptions& options) {
  return Words{"qualify", "--rig", rig, "--out", lot} + options.words;
}

Words with_threads(const PlanOptions& options) { return {"--threads", std::to_string(options.threads)}; }

}  // namespace

Step records_of_lot(const std::string& rig, const std::string& lot, const PlanOptions& options) {
  return {.words = qualify(rig, lot, options) + Words{"--records-only"}, .output = {}};
}

Result<Job> plan_lot(const std::string& rig, const std::string& lot, const PlanOptions& options) {
  const auto info = record::read_info(lot + "/rate.db");
  if (!info) return failure(info.error());
  const auto axes = axes_of(*info);
  if (axes.size() < 2) return failure(FaultKind::usage, rig, "has one axis; gyrotherm qualify trains it");
  auto job = empty_job("every axis of " + lot, options);
  for (const Axis& axis : axes)
    job.tasks.push_back({.name = axis.label,
                         .steps = {{.words = qualify(rig, lot, options) + with_threads(options) +
                                             Words{"--quiet", "--only", axis.label},
                                    .output = {}}}});
  job.then = {{.words = qualify(rig, lot, options), .output = {}}};
  return job;
}

Result<Job> plan_seeds(const Seeds& seeds, const std::string& out, const PlanOptions& options) {
  constexpr std::uint64_t kMost = 100'000;
  if (seeds.last < seeds.first || seeds.last - seeds.first >= kMost)
    return failure(FaultKind::usage, "--first, --last",
                   fmt::format("{} to {}, expected 1 to {} seeds", seeds.first, seeds.last, kMost));
  auto job = empty_job(fmt::format("seeds {} to {}", seeds.first, seeds.last), options);
  for (std::uint64_t i = 0; i <= seeds.last - seeds.first; ++i) {
    const auto seed = seeds.first + i;
    const auto name = fmt::format("seed-{}", seed);
    const auto model = fmt::format("{}/{}/model.json", out, name);
    Task task{.name = name, .steps = {}};
    task.steps.push_back({.words = Words{"train"} + seeds.records + options.words + with_threads(options) +
                                   Words{"--quiet", "--seed", std::to_string(seed), "--force", "--out", model},
                          .output = fmt::format("{}/{}/train.txt", out, name)});
    if (!seeds.verify.empty())
      task.steps.push_back({.words = Words{"verify", model} + seeds.verify + Words{"--json"},
                            .output = fmt::format("{}/{}/verify.json", out, name)});
    job.tasks.push_back(std::move(task));
  }
  return job;
}

Result<Job> plan_leave_one_out(const std::vector<std::string>& records, double hours, const std::string& out,
                               const PlanOptions& options) {
  constexpr std::size_t kFewest = 4;        // three are left for the prior
  constexpr double kClustersOfAnHour = 36;  // of 100 s
  if (records.size() < kFewest)
    return failure(FaultKind::usage, {}, fmt::format("{} units, expected {} or more", records.size(), kFewest));
  const auto clusters = std::lround(hours * kClustersOfAnHour);
  std::set<std::string> names;
  auto job = empty_job(fmt::format("{} units, each left out", records.size()), options);
  for (const auto& record : records) {
    const auto name = fs::path(record).stem().string();
    if (!names.insert(name).second)
      return failure(FaultKind::usage, record, "another record has this name; what is left of each goes by it");
    Words others;
    for (const auto& other : records)
      if (other != record) others.push_back(fmt::format("{}={}", fs::path(other).stem().string(), other));
    const auto file = [&](const char* what) { return fmt::format("{}/{}/{}", out, name, what); };
    job.tasks.push_back(
        {.name = name,
         .steps = {
             {.words = Words{"type-prior"} + others + options.words +
                       Words{"--quiet", "--force", "--out", file("prior.json")},
              .output = file("prior.txt")},
             {.words = {"train", record, "--prior", file("prior.json"), "--clusters", fmt::format("0:{}", clusters),
                        "--quiet", "--force", "--out", file("model.json")},
              .output = file("train.txt")},
             {.words = {"verify", file("model.json"), record, "--clusters", fmt::format("{}:", clusters), "--json"},
              .output = file("verify.json")}}});
  }
  return job;
}

Result<Job> plan_placement(const std::vector<std::string>& records, const std::string& out,
                           const PlanOptions& options) {
  const auto info = record::read_info(records.front());
  if (!info) return failure(info.error());
  auto job = empty_job("placement on " + records.front(), options);
  for (const Axis& axis : axes_of(*info))
    job.tasks.push_back({.name = axis.label,
                         .steps = {{.words = Words{"placement"} + records + axis.options + options.words +
                                             with_threads(options) + Words{"--quiet", "--json"},
                                    .output = fmt::format("{}/{}.json", out, axis.label)}}});
  return job;
}

}  // namespace gyrotherm::site
