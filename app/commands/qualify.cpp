/// The whole experiment: two runs, three models, a report.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>

#include "acquisition/record/export.hpp"
#include "acquisition/record/record.hpp"
#include "analysis/methods/method.hpp"
#include "analysis/model/training.hpp"
#include "analysis/model/verification.hpp"
#include "app/command.hpp"
#include "app/commands/qualify_report.hpp"
#include "app/interrupt.hpp"
#include "app/places.hpp"
#include "app/recorded_run.hpp"
#include "app/run/carry_out.hpp"
#include "app/timings.hpp"
#include "core/file.hpp"
#include "core/sha256.hpp"
#include "report/write.hpp"

namespace gyrotherm {
namespace {

struct QualifyArguments {
  std::string rig, out, rate_profile, random_profile;
  std::uint64_t seed = 0;
  int threads = 0;
  bool quick = false, nested = false;
};

using Run = QualificationRun;

/// True if the record at `path` is (part of) this very experiment.
bool belongs(const RunInfo& info, const Profile& profile, const RigFile& rig, std::uint64_t seed) {
  return info.profile_text == profile.text && info.rig_text == rig.text &&
         info.chamber_map_text == rig.chamber_map.text && info.gyro_model_text == rig.gyro_model.text &&
         info.program_version == GYROTHERM_VERSION && (!rig.simulated || info.seed == seed);
}

/// Records a run, or goes on with it, or keeps it: whatever is still to be done.
Result<void> record(Console& console, const Run& run, const RigFile& rig, std::uint64_t seed) {
  if (!std::filesystem::exists(run.path)) return start_run(console, run.profile, rig, seed, run.path);
  const auto before = read_record(run.path);
  if (!before) return failure(before.error());
  if (!belongs(before->info, run.profile, rig, seed))
    return failure(FaultKind::usage, run.path,
                   "is of another experiment (profile, rig, seed or program differ); choose another --out");
  if (!before->finished) return resume_run(console, run.path, {});
  console.say(fmt::format("{}: already recorded", run.path));
  return {};
}

Result<void> load(Console& console, Run& run) {
  if (auto checked = check_recorded_run(console, run.path, false); !checked) return checked;
  const auto rows = read_record(run.path);
  if (!rows) return failure(rows.error());
  auto dataset = make_dataset(*rows, run.path);
  auto clusters = make_clusters(dataset);
  if (!clusters) return failure(clusters.error());
  run.recorded = {std::move(dataset), std::move(*clusters)};
  run.sha256 = sha256(to_csv(*rows));
  return {};
}

/// What is trained, and how it is called while it is.
struct Task {
  std::string stage, method, inputs;
};

Result<TrainedModel> train_model(Console& console, const QualifyArguments& options, const Task& task, const Run& rate,
                                 const Run& random) {
  TrainingOptions training;
  training.inputs = task.inputs;
  training.method = task.method;
  training.nested = options.nested;
  training.quick = options.quick;
  training.program_version = GYROTHERM_VERSION;
  training.tuning.swarm.seed = options.seed;
  training.tuning.swarm.threads = options.threads;
  const auto sink = [&](std::string_view stage, double fraction) {
    return console.sink()(fmt::format("{}: {}", task.stage, stage), fraction);
  };
  const auto began = std::chrono::steady_clock::now();
  auto model = train({rate.recorded.dataset}, {rate.recorded.clusters}, training, sink);
  if (!model) return failure(model.error());
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
  auto on_rate = verify(*model, rate.recorded.dataset, rate.recorded.clusters);
  if (!on_rate) return failure(on_rate.error());
  auto on_random = verify(*model, random.recorded.dataset, random.recorded.clusters);
  if (!on_random) return failure(on_random.error());
  return TrainedModel{std::move(*model), std::move(*on_rate), std::move(*on_random), took.count()};
}

Result<std::vector<TrainedModel>> train_models(Console& console, const QualifyArguments& options, const Run& rate,
                                               const Run& random) {
  std::vector<TrainedModel> models;
  for (const std::string inputs : {"three-point", "multi-point", "multi-point-t"}) {
    auto model = train_model(console, options, {"training " + inputs, "svr", inputs}, rate, random);
    if (!model) return failure(model.error());
    if (auto written = replace_text_file(fmt::format("{}/model-{}.json", options.out, inputs), to_json(model->model));
        !written)
      return failure(written.error());
    models.push_back(std::move(*model));
  }
  return models;
}

/// Every other method on the inputs it is published with, and those that learn quickly also on those of the model that
/// is recommended for use; least squares on those of all three models, for what the support vectors are worth.
std::vector<Task> tasks_of_comparison() {
  const std::vector<std::string_view> quick{"stepwise", "ridge", "rbfnn", "kohonen-rbfnn", "ls-svm", "gp"};
  std::vector<std::pair<std::string, std::string>> rows;
  for (const Method& method : methods()) {
    if (method.name != "svr") rows.emplace_back(method.name, method.inputs);
    if (std::ranges::count(quick, method.name) > 0) rows.emplace_back(method.name, "multi-point-t");
    if (method.name != "linear") continue;
    for (const auto* inputs : {"three-point", "multi-point", "multi-point-t", "seven-point"})
      rows.emplace_back(method.name, inputs);
  }
  std::vector<Task> tasks;
  for (const auto& [method, inputs] : rows)
    tasks.push_back({fmt::format("comparing {} of {}, {}", tasks.size() + 1, rows.size(), method), method, inputs});
  return tasks;
}

/// A method that cannot be trained on this record is left out with a warning: the experiment stands without it.
Result<std::vector<TrainedModel>> train_compared(Console& console, const QualifyArguments& options, const Run& rate,
                                                 const Run& random, Timings& timings,
                                                 std::vector<std::string>& warnings) {
  std::vector<TrainedModel> compared;
  for (const Task& task : tasks_of_comparison()) {
    timings.begin(fmt::format("compare {} on {}", task.method, task.inputs));
    auto model = train_model(console, options, task, rate, random);
    if (model) {
      compared.push_back(std::move(*model));
      continue;
    }
    if (model.error().kind == FaultKind::interrupted) return failure(model.error());
    warnings.push_back(fmt::format("{} on {} is not compared: {}", task.method, task.inputs, text(model.error())));
    console.say(warnings.back());
  }
  return compared;
}

Result<Run> plan_run(const std::string& stage, const std::string& profile, const RigFile& rig, const std::string& out) {
  auto read = read_profile(profile, &rig);
  if (!read) return failure(read.error());
  if (auto checked = check_accept(*read, profile); !checked) return failure(checked.error());
  return Run{.stage = stage,
             .path = fmt::format("{}/{}.db", out, stage),
             .profile = std::move(*read),
             .recorded = {},
             .sha256 = {}};
}

Result<Exit> qualify(Console& console, const QualifyArguments& options) {
  const auto rig = read_rig(options.rig.empty() ? shipped("profiles/rigs/virtual.toml") : options.rig);
  if (!rig) return failure(rig.error());
  auto rate =
      plan_run("rate", options.rate_profile.empty() ? shipped("profiles/qualification.toml") : options.rate_profile,
               *rig, options.out);
  if (!rate) return failure(rate.error());
  auto random =
      plan_run("random", options.random_profile.empty() ? shipped("profiles/random.toml") : options.random_profile,
               *rig, options.out);
  if (!random) return failure(random.error());
  watch_for_interrupts(rig->simulated ? SecondInterrupt::ends : SecondInterrupt::is_counted);
  std::error_code error;
  std::filesystem::create_directories(options.out, error);
  if (error) return failure(FaultKind::storage, options.out, "cannot be made: " + error.message());
  if (rig->simulated) console.say(fmt::format("SIMULATED: {}, seed {}", rig->title, options.seed));

  Timings timings;
  for (auto* run : {&*rate, &*random}) {
    timings.begin("record " + run->stage);
    if (auto recorded = record(console, *run, *rig, options.seed); !recorded) return failure(recorded.error());
  }
  watch_for_interrupts(SecondInterrupt::ends);  // no chamber is driven any more
  timings.begin("read records");
  for (auto* run : {&*rate, &*random})
    if (auto loaded = load(console, *run); !loaded) return failure(loaded.error());
  timings.begin("train three models");
  auto models = train_models(console, options, *rate, *random);
  if (!models) return failure(models.error());
  std::vector<std::string> warnings;
  auto compared = train_compared(console, options, *rate, *random, timings, warnings);
  if (!compared) return failure(compared.error());
  timings.begin("report");
  const Qualification all{.rig = *rig,
                          .seed = options.seed,
                          .rate = *rate,
                          .random = *random,
                          .models = *models,
                          .compared = *compared,
                          .warnings = std::move(warnings)};
  const auto report = assemble_report(all);
  const auto folder = options.out + "/report";
  if (auto written = write_report(report.json, folder); !written) return failure(written.error());
  timings.end();
  if (auto written = replace_text_file(options.out + "/timings.json", timings.to_json()); !written)
    return failure(written.error());
  console.data(console.json ? report.json : result_table(all));
  console.say(timings.words() + folder + "/report.html");
  for (const auto& missed : report.missed) console.say("FAIL: " + missed);
  return report.missed.empty() ? Exit::done : Exit::outside_limits;
}

}  // namespace

void add_qualify(Program& program) {
  auto options = std::make_shared<QualifyArguments>();
  auto command = add_command(program, "qualify",
                             "The whole experiment: the rate program, the random program, three models, the report. "
                             "Run again, it goes on where it was.",
                             "gyrotherm qualify --out out");
  command.option("--out", options->out, "the folder for everything that is made").required();
  command.option("--rig", options->rig, "the rig (default: profiles/rigs/virtual.toml, a dry run)");
  command.option("--seed", options->seed, "draws the virtual gyro, its noise, and the swarm; 0 is the gyro of the file")
      .not_negative();
  command.option("--threads", options->threads, "of the training; 0: all; the result is the same");
  command.flag("--quick", options->quick, "a small swarm, for a try; the report says so");
  command.flag("--nested", options->nested,
               "also choose everything anew without each held-out cycle: training takes about twice as long");
  command.option("--rate-profile", options->rate_profile, "instead of profiles/qualification.toml");
  command.option("--random-profile", options->random_profile, "instead of profiles/random.toml");
  command.action([&program, options] { return qualify(program.console, *options); });
}

}  // namespace gyrotherm
