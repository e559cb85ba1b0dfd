// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/placement.hpp"

#include <fmt/format.h>

#include "analysis/model/making.hpp"
#include "analysis/model/training.hpp"
#include "analysis/model/verification.hpp"
#include "apps/console/command.hpp"
#include "apps/console/interrupt.hpp"
#include "apps/gyrotherm/recorded_run.hpp"
#include "core/json.hpp"
#include "core/number_text.hpp"

namespace gyrotherm::app {
namespace {

constexpr const char* kPlacementSchema = "gyrotherm-placement/1";

struct PlacementArguments {
  std::vector<std::string> runs, unseen;
  std::string folds = "auto", clusters;
  double guard_minutes = -1;  ///< negative: not given
  bool confirm = false, unverified = false;
  data::AxisChoice axis;
  model::TrainingOptions training;
};

/// Results of a support-vector model that was trained on one set of thermometers.
struct SupportVectorResult {
  data::Figures held_out;
  std::vector<data::Figures> unseen;
};

Result<SupportVectorResult> confirm_set(Console& console, const PlacementArguments& options,
                                        const RecordedRuns& records, const RecordedRuns& unseen,
                                        const std::vector<std::string>& kept) {
  model::TrainingOptions training = options.training;
  for (const data::Term& term : model::placement_terms(kept))
    training.inputs += (training.inputs.empty() ? "" : ",") + to_string(term);
  const auto stage = fmt::format("support vectors on {} thermometers", kept.size());
  const auto sink = [&](std::string_view, double fraction) { return console.sink()(stage, fraction); };
  const auto model = train(records.datasets, records.clusters, training, sink);
  if (!model) return failure(model.error());
  SupportVectorResult confirmed{.held_out = model->leave_cycle_out, .unseen = {}};
  for (std::size_t i = 0; i < unseen.datasets.size(); ++i) {
    const auto verified = verify(*model, unseen.datasets[i], unseen.clusters[i]);
    if (!verified) return failure(verified.error());
    confirmed.unseen.push_back(verified->compensated);
  }
  return confirmed;
}

/// Returns the results of all thermometers together and of each step of the elimination; empty without --confirm.
Result<std::vector<SupportVectorResult>> confirm_steps(Console& console, const PlacementArguments& options,
                                                       const RecordedRuns& records, const RecordedRuns& unseen,
                                                       const model::Placement& placement) {
  std::vector<SupportVectorResult> all;
  if (!options.confirm) return all;
  std::vector<std::vector<std::string>> sets{placement.all.kept};
  for (const auto& step : placement.elimination) sets.push_back(step.kept);
  for (const auto& kept : sets) {
    auto confirmed = confirm_set(console, options, records, unseen, kept);
    if (!confirmed) return failure(confirmed.error());
    all.push_back(std::move(*confirmed));
  }
  return all;
}

std::string join_names(const std::vector<std::string>& names) { return fmt::format("{}", fmt::join(names, " ")); }

std::string row(const std::string& what, const model::SubsetAccuracy& set, const SupportVectorResult* confirmed) {
  auto text = fmt::format("  {:<12} {:>19} {:>21}", what,
                          format_with_error(set.held_out.std, standard_error_of_std(set.held_out)),
                          format_with_error(set.price_deg_per_h, set.price_error_deg_per_h));
  if (set.unseen) text += fmt::format(" {:>9.5f}", set.unseen->std);
  if (confirmed != nullptr) {
    text += fmt::format(" {:>9.5f}", confirmed->held_out.std);
    for (const auto& unseen : confirmed->unseen) text += fmt::format(" {:>9.5f}", unseen.std);
  }
  return text + "  " + join_names(set.kept) + "\n";
}

std::string heading(std::string_view what, const model::Placement& placement,
                    const std::vector<SupportVectorResult>& confirmed) {
  auto text = fmt::format("  {:<12} {:>19} {:>21}", what, "held out", "price");
  if (placement.all.unseen) text += fmt::format(" {:>9}", "unseen");
  if (!confirmed.empty()) {
    text += fmt::format(" {:>9}", "svr");
    for (std::size_t i = 0; i < confirmed.front().unseen.size(); ++i) text += fmt::format(" {:>9}", "unseen");
  }
  return text + "  kept\n";
}

std::string describe(const RecordedRuns& records, const model::Placement& placement,
                     const std::vector<SupportVectorResult>& confirmed) {
  std::string text;
  for (const auto& dataset : records.datasets)
    text += fmt::format("{}{}\n", dataset.simulated ? "SIMULATED " : "", dataset.path);
  text += fmt::format("STD in °/h; {}; second-order response surface{}\n", placement.folds,
                      confirmed.empty() ? "" : ", and a support-vector model tuned by a small swarm (svr)");
  text += "leaving out one after another, the smallest STD increase (price) first:\n" +
          heading("", placement, confirmed) +
          row("none", placement.all, confirmed.empty() ? nullptr : &confirmed.front());
  for (std::size_t k = 0; k < placement.elimination.size(); ++k) {
    const auto& step = placement.elimination[k];
    text += row("+ " + step.left_out.back(), step, confirmed.empty() ? nullptr : &confirmed[k + 1]);
  }
  text += "leaving out only one:\n";
  for (const auto& one : placement.alone) text += row(one.left_out.front(), one, nullptr);
  if (placement.best_pair)
    text += "leaving out two, the pair with the smallest price:\n" +
            row(join_names(placement.best_pair->left_out), *placement.best_pair, nullptr);
  if (placement.best_three)
    text += "leaving out three, the set with the smallest price:\n" +
            row(join_names(placement.best_three->left_out), *placement.best_three, nullptr);
  const auto spared = static_cast<std::size_t>(placement.spared);
  const auto& enough = spared == 0 ? placement.all : placement.elimination[spared - 1];
  return text + fmt::format("{} of {} thermometers can be left out at a price within its error; {} {}\n", spared,
                            placement.all.kept.size(), join_names(enough.kept),
                            enough.kept.size() == 1 ? "suffices" : "suffice");
}

Json set_json(const model::SubsetAccuracy& set, const SupportVectorResult* confirmed = nullptr) {
  Json json{{"left_out", set.left_out},
            {"kept", set.kept},
            {"held_out", make_json(set.held_out)},
            {"price_deg_per_h", set.price_deg_per_h},
            {"price_error_deg_per_h", set.price_error_deg_per_h}};
  if (set.unseen) json["unseen"] = make_json(*set.unseen);
  if (confirmed == nullptr) return json;
  json["svr"] = {{"held_out", make_json(confirmed->held_out)}};
  for (const auto& unseen : confirmed->unseen) json["svr"]["unseen"].push_back(make_json(unseen));
  return json;
}

std::string json(const RecordedRuns& records, const model::Placement& placement,
                 const std::vector<SupportVectorResult>& confirmed) {
  Json json{{"schema", kPlacementSchema}, {"records", Json::array()}};
  for (const auto& dataset : records.datasets)
    json["records"].push_back({{"path", dataset.path}, {"run_id", dataset.run_id}, {"simulated", dataset.simulated}});
  json["folds"] = placement.folds;
  json["all"] = set_json(placement.all, confirmed.empty() ? nullptr : &confirmed.front());
  json["elimination"] = Json::array();
  for (std::size_t k = 0; k < placement.elimination.size(); ++k)
    json["elimination"].push_back(set_json(placement.elimination[k], confirmed.empty() ? nullptr : &confirmed[k + 1]));
  json["alone"] = Json::array();
  for (const auto& one : placement.alone) json["alone"].push_back(set_json(one));
  if (placement.best_pair) json["best_pair"] = set_json(*placement.best_pair);
  if (placement.best_three) json["best_three"] = set_json(*placement.best_three);
  json["spared"] = placement.spared;
  return json_text(json) + "\n";
}

/// Fails unless the ranked records, `records`, are of one gyro with one bias reference and no run occurs twice. The
/// same applies to the records of --verify, `unseen`, which must also be other runs of the same gyro.
Result<void> check(const RecordedRuns& records, const RecordedRuns& unseen) {
  for (const RecordedRuns* runs : {&records, &unseen})
    if (auto sound = model::check_records(runs->datasets, runs->clusters); !sound) return sound;
  for (const data::Dataset& one : unseen.datasets)
    for (const data::Dataset& other : records.datasets) {
      if (one.run_id == other.run_id)
        return failure(
            FaultKind::usage, one.path,
            fmt::format("is the same run as {}; --verify requires runs that do not influence the ranking", other.path));
      if (auto one_gyro = check_same_gyro(one, other, other.path); !one_gyro) return one_gyro;
    }
  return {};
}

Result<Exit> rank_thermometers(Console& console, const PlacementArguments& given) {
  PlacementArguments options = given;
  const auto folds = data::parse_folds(options.folds);
  if (!folds) return failure(folds.error());
  options.training.folds = *folds;
  if (options.guard_minutes >= 0) options.training.folds.guard_minutes = options.guard_minutes;
  const auto records = load_recorded_runs(console, options.runs, {options.clusters, options.unverified, options.axis});
  if (!records) return failure(records.error());
  options.training.folds.programs = list_programs(records->datasets);
  const auto unseen =
      load_recorded_runs(console, options.unseen, {.unverified = options.unverified, .axis = options.axis});
  if (!unseen) return failure(unseen.error());
  if (auto sound = check(*records, *unseen); !sound) return failure(sound.error());
  watch_for_interrupts(SecondInterrupt::ends);
  const auto placement =
      model::study_placement(records->clusters, unseen->clusters, options.training.folds, console.sink());
  if (!placement) return failure(placement.error());
  const auto confirmed = confirm_steps(console, options, *records, *unseen, *placement);
  if (!confirmed) return failure(confirmed.error());
  console.print_report(console.json ? json(*records, *placement, *confirmed)
                                    : describe(*records, *placement, *confirmed));
  return Exit::done;
}

}  // namespace

void add_placement(Program& program) {
  auto [command, options] =
      add_command(program, "placement", "Ranks thermometers by the increase of the held-out STD when each is left out.",
                  "gyrotherm placement ramp.db --verify random.db", rank_thermometers);
  options.training.quick = true;
  command.add_option("runs", options.runs, "the records")->type_name(value::kRecord)->required();
  command.add_option("--verify", options.unseen, "further records to report on; they do not influence the ranking")
      ->type_name(value::kRecord);
  command
      .add_option("--folds", options.folds,
                  "kind of fold: cycles, starts, records, programs, blocks[:N] or auto (default); see train")
      ->type_name("FOLDS");
  command
      .add_option(
          "--guard", options.guard_minutes,
          "guard interval around each fold, in minutes, that is also excluded from training (default: as in train)")
      ->check(not_negative());
  command.add_option("--clusters", options.clusters, "only these clusters of each record, like 0:14")
      ->type_name("FIRST:END");
  command.add_flag(
      "--confirm", options.confirm,
      "also tune a support-vector model with a small swarm on each set of the elimination (takes minutes)");
  add_axis_options(command, options.axis);
  add_unverified_flag(command, options.unverified);
  command.add_option("--seed", options.training.tuning.swarm.seed, "seed of the swarm")->check(not_negative());
  command
      .add_option("--threads", options.training.tuning.swarm.threads,
                  "threads of the swarm; 0: all; the result is the same")
      ->check(not_negative());
}

}  // namespace gyrotherm::app
