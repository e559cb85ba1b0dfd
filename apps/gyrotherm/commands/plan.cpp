// SPDX-License-Identifier: Apache-2.0
/// The command `plan`: proposes a program for a rig from the uncertainty that is wanted.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "analysis/planning/forecast.hpp"
#include "apps/console/command.hpp"
#include "apps/console/interrupt.hpp"
#include "apps/gyrotherm/output_file.hpp"
#include "apps/gyrotherm/plan/program_plan.hpp"
#include "apps/gyrotherm/recorded_run.hpp"
#include "apps/gyrotherm/rig_source.hpp"
#include "apps/gyrotherm/run/carry_out.hpp"
#include "apps/gyrotherm/run/checked_profile.hpp"
#include "apps/gyrotherm/run/run_goal.hpp"
#include "core/count_text.hpp"
#include "core/file.hpp"
#include "sequencer/profile/released_blocks.hpp"

namespace gyrotherm::app {
namespace {

struct PlanArguments {
  std::string rig, released = "until", mission, record, prior, out;
  double target_deg_per_h{};
  std::uint64_t seed = 0;
  bool force = false, unverified = false;
  data::AxisChoice axis;
};

/// Returns a path with another ending: "plan.toml" gives "plan.svg".
std::string beside(const std::string& path, const std::string& ending) {
  return std::filesystem::path(path).replace_extension(ending).string();
}

/// Returns the record that the forecasts are based on. Without one, records the profile `short` on a virtual rig.
Result<std::string> find_reference(Console& console, const PlanArguments& options, const rig::RigFile& rig) {
  if (!options.record.empty()) return options.record;
  if (!rig.simulated)
    return failure(FaultKind::usage, "--record",
                   "a real rig needs the record of a unit of the type, which may be the unit itself: what a program "
                   "teaches is forecast from it");
  const auto path = beside(options.out, "reference.db");
  if (std::filesystem::exists(path)) return path;
  const auto profile = read_profile("short", &rig);
  if (!profile) return failure(profile.error());
  console.print_message("recording the program \"short\" on the virtual rig as a reference");
  if (auto ran = start_run(console, *profile, rig, path, {.seed = options.seed}); !ran) return failure(ran.error());
  return path;
}

/// Returns the path of the mission on which the uncertainty counts.
Result<planning::ProgramPath> read_mission(const std::string& given) {
  const auto mission = read_profile(given, nullptr);
  if (!mission) return failure(mission.error());
  return program_path(*mission);
}

/// Adds the expected uncertainty of the shipped programs that the rig can carry out.
Result<void> compare_shipped(ProgramPlan& plan, const ForecastFunction& forecast, const rig::RigFile& rig) {
  for (const char* name : {"short", "qualification"}) {
    const auto profile = read_profile(name, &rig);
    if (!profile) continue;  // beyond the limits of the rig
    const auto u = forecast(program_path(*profile));
    if (!u) return failure(u.error());
    plan.compared.push_back({name, to_seconds(profile::total_time(profile->segments)) / kSecondsPerHour, *u});
  }
  return {};
}

/// Returns the forecast of the recommended model, and with a type prior also that of the model with the prior.
Result<std::vector<planning::Forecast>> make_forecasts(Console& console,
                                                       const std::optional<population::TypePrior>& prior,
                                                       const data::RecordedRun& reference,
                                                       const planning::ProgramPath& mission) {
  std::vector<planning::Forecast> forecasts;
  auto own = planning::Forecast::make(reference, mission, console.sink());
  if (!own) return failure(own.error());
  forecasts.push_back(std::move(*own));
  if (!prior) return forecasts;
  auto with_prior = planning::Forecast::make_with_prior(*prior, reference, mission);
  if (!with_prior) return failure(with_prior.error());
  forecasts.push_back(std::move(*with_prior));
  return forecasts;
}

/// Returns the lowest expanded uncertainty that the forecasts give after the program, because a run that ends by itself
/// uses the better model. Infinite without a forecast.
Result<double> least_expanded(const std::vector<planning::Forecast>& forecasts, const planning::ProgramPath& program) {
  double least = std::numeric_limits<double>::infinity();
  for (const auto& forecast : forecasts) {
    const auto u = forecast.expanded_after(program);
    if (!u) return failure(u.error());
    least = std::min(least, *u);
  }
  return least;
}

Result<ProgramPlan> make_plan(Console& console, const PlanArguments& options, const rig::RigFile& rig,
                              profile::Profile released) {
  std::optional<population::TypePrior> prior;
  if (!options.prior.empty()) {
    auto read = load_type_prior(options.prior);
    if (!read) return failure(read.error());
    prior = std::move(*read);
  }
  if (!options.mission.empty()) released.until->mission = options.mission;
  const auto mission = read_mission(released.until->mission);
  if (!mission) return failure(mission.error());
  const auto path = find_reference(console, options, rig);
  if (!path) return failure(path.error());
  const auto reference = load_recorded_run(console, *path, {{}, options.unverified, options.axis});
  if (!reference) return failure(reference.error());
  constexpr Eigen::Index kFewestClusters = 20;
  if (const auto clusters = reference->clusters.bias_deg_per_h.size(); clusters < kFewestClusters)
    return failure(FaultKind::usage, *path,
                   fmt::format("has {} of {:g} s, expected at least {} for a plan", format_count(clusters, "cluster"),
                               reference->clusters.length_s, kFewestClusters));
  const auto forecasts = make_forecasts(console, prior, *reference, *mission);
  if (!forecasts) return failure(forecasts.error());
  const ForecastFunction expanded = [&](const planning::ProgramPath& program) {
    return least_expanded(*forecasts, program);
  };
  auto plan = plan_program(std::move(released), options.target_deg_per_h, expanded, console.sink());
  if (!plan) return failure(plan.error());
  plan->reference = options.prior.empty() ? *path : fmt::format("{} and {}", *path, options.prior);
  plan->simulated = reference->dataset.simulated;
  if (const auto compared = compare_shipped(*plan, expanded, rig); !compared) return failure(compared.error());
  return plan;
}

Result<Exit> plan_and_write(Console& console, const PlanArguments& options) {
  if (auto named = check_is_toml(options.out, "a profile"); !named) return failure(named.error());
  const auto figure = beside(options.out, "svg");
  for (const auto& path : {options.out, figure})
    if (auto free = check_is_free(path, options.force); !free) return failure(free.error());
  const auto rig = load_rig(options.rig);
  if (!rig) return failure(rig.error());
  auto released = read_profile(options.released, &*rig);
  if (!released) return failure(released.error());
  if (!released->until)
    return failure(FaultKind::usage, "--released",
                   fmt::format("{} has no table [until], expected a profile with released blocks such as \"until\"",
                               options.released));
  watch_for_interrupts(SecondInterrupt::ends);
  const auto plan = make_plan(console, options, *rig, std::move(*released));
  if (!plan) return failure(plan.error());
  const auto text = profile_text(*plan, std::filesystem::path(options.out).stem().string());
  if (const auto valid = parse_checked_profile(&*rig, text, options.out); !valid) return failure(valid.error());
  if (auto written = replace_text_file(options.out, text); !written) return failure(written.error());
  if (auto written = replace_text_file(figure, to_svg(*plan)); !written) return failure(written.error());
  console.print_report(console.json ? to_json(*plan) : describe(*plan));
  console.print_message(fmt::format("{} and {} written", options.out, figure));
  return is_met(*plan) ? Exit::done : Exit::outside_limits;
}

}  // namespace

void add_plan(Program& program) {
  auto [command, options] =
      add_command(program, "plan",
                  "Proposes a program for a rig: released blocks until a target uncertainty is expected. Writes a "
                  "profile and its figure.",
                  "gyrotherm plan virtual --target-u 0.006 --out plan.toml", plan_and_write);
  command.add_option("rig", options.rig, "the rig")->type_name(value::kRig)->required();
  command
      .add_option("--target-u", options.target_deg_per_h,
                  "wanted expanded uncertainty of a mean over 1 h on the mission, °/h")
      ->check(CLI::PositiveNumber)
      ->required();
  command.add_option("--out", options.out, "the profile; its figure has the ending .svg")
      ->check(reject_dash())
      ->type_name(value::kProfile)
      ->required();
  add_force_flag(command, options.force);
  command
      .add_option("--released", options.released,
                  "profile with [until]: its opening, released blocks, closing segments and longest duration "
                  "(default: until)")
      ->type_name(value::kProfile);
  command.add_option("--mission", options.mission, "program on which U counts (default: that of --released)")
      ->type_name(value::kProfile);
  command
      .add_option("--record", options.record,
                  "record of a unit of the type (default: the profile \"short\" on a virtual rig, recorded beside the "
                  "plan)")
      ->type_name(value::kRecord);
  command
      .add_option("--prior", options.prior,
                  "a type prior written by type-prior, if the unit will be trained with it; the lower forecast counts")
      ->type_name(value::kModel);
  command.add_option("--seed", options.seed, "seed of the virtual gyro that is recorded")->check(not_negative());
  add_axis_options(command, options.axis);
  add_unverified_flag(command, options.unverified);
}

}  // namespace gyrotherm::app
