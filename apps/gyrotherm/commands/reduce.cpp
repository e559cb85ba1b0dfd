// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "apps/console/command.hpp"
#include "apps/gyrotherm/output_file.hpp"
#include "apps/gyrotherm/recorded_run.hpp"
#include "core/file.hpp"

namespace gyrotherm::app {
namespace {

struct ReduceArguments {
  std::string model, out, clusters;
  std::vector<std::string> runs;
  model::ReducedSetGoal goal;
  bool force = false, unverified = false;
  data::AxisChoice axis;
};

std::string describe(const model::ReducedSetSummary& r) {
  return fmt::format(
      "kept {} of {} vectors\n"
      "  change of the predictions: max {:.3g}, rms {:.3g} °/h over {} clusters; for any input at most {:.3g} °/h\n",
      r.vectors, r.vectors_before, r.max_change_deg_per_h, r.rms_change_deg_per_h, r.clusters, r.bound_deg_per_h);
}

std::string untrained_record_warning(const model::Model& model, const data::RecordedRun& recorded) {
  for (const model::TrainingRecord& record : model.trained_on) {
    if (record.run_id == recorded.dataset.run_id) return {};
  }
  return recorded.dataset.path +
         ": the model was not trained on this record; the change of its predictions is measured on it nevertheless";
}

Result<void> check_reduction_goal(const model::ReducedSetGoal& goal) {
  if (!goal.vectors && !goal.max_change_deg_per_h)
    return failure(FaultKind::usage, "--keep", "give the number of vectors with --keep, or the change with --within");
  if (goal.vectors && *goal.vectors < 1)
    return failure(FaultKind::usage, "--keep", fmt::format("{} vectors, expected at least 1", *goal.vectors));
  if (goal.max_change_deg_per_h && !(*goal.max_change_deg_per_h > 0))
    return failure(FaultKind::usage, "--within",
                   fmt::format("{} °/h, expected more than 0", *goal.max_change_deg_per_h));
  return {};
}

Result<Exit> reduce_and_write(Console& console, const ReduceArguments& options) {
  if (auto valid = check_reduction_goal(options.goal); !valid) return failure(valid.error());
  if (auto free = check_is_free(options.out, options.force); !free) return failure(free.error());
  const auto model = load_model(options.model);
  if (!model) return failure(model.error());
  std::vector<data::Clusters> clusters;
  for (const auto& run : options.runs) {
    auto recorded = load_recorded_run(
        console, run, {options.clusters, options.unverified, axis_for(*model, options.axis), model->cluster_length_s});
    if (!recorded) return failure(recorded.error());
    if (const auto warning = untrained_record_warning(*model, *recorded); !warning.empty())
      console.print_message("warning: " + warning);
    clusters.push_back(std::move(recorded->clusters));
  }
  const auto all = concatenate(clusters);
  if (!all) return failure(all.error());
  const auto smaller = reduce(*model, *all, options.goal);
  if (!smaller) return failure(smaller.error());
  if (auto written = write_model(options.out, *smaller); !written) return failure(written.error());
  console.print_report(console.json ? to_json(*smaller) : describe(*smaller->reduction));
  return Exit::done;
}

}  // namespace

void add_reduce(Program& program) {
  auto [command, options] =
      add_command(program, "reduce",
                  "Reduces the number of support vectors of a model and prints the effect on its training records.",
                  "gyrotherm reduce model.json ramp.db --within 0.0001 --out small.json", reduce_and_write);
  command.add_option("model", options.model, "the model")->type_name(value::kModel)->required();
  command.add_option("runs", options.runs, "its training records")->type_name(value::kRecord)->required();
  command.add_option("--out", options.out, "the smaller model")
      ->check(reject_dash())
      ->type_name(value::kModel)
      ->required();
  add_force_flag(command, options.force);
  auto* keep = command.add_option("--keep", options.goal.vectors, "largest number of vectors");
  command
      .add_option("--within", options.goal.max_change_deg_per_h,
                  "largest change of the prediction of any training cluster, in °/h")
      ->excludes(keep);
  command.add_option("--clusters", options.clusters, "only these clusters of each record, like 0:14")
      ->type_name("FIRST:END");
  add_axis_options(command, options.axis);
  add_unverified_flag(command, options.unverified);
}

}  // namespace gyrotherm::app
