// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/plan/program_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "apps/gyrotherm/run/run_goal.hpp"
#include "core/json.hpp"
#include "report/plot/plot.hpp"
#include "sequencer/profile/profile_text.hpp"
#include "sequencer/profile/released_blocks.hpp"
#include "sequencer/run/block_choice.hpp"

namespace gyrotherm::app {
namespace {

constexpr const char* kPlanSchema = "gyrotherm-plan/1";
constexpr const char *kOpening = "opening", *kClosing = "closing";

double hours(Duration time) { return to_seconds(time) / kSecondsPerHour; }

/// Returns the uncertainties expected after each block, which begins at the end of the program.
Result<std::vector<double>> forecast_blocks(const profile::Profile& program, const ForecastFunction& forecast) {
  std::vector<double> all;
  const auto from = program.segments.back().target;
  const auto so_far = program_path(program);
  for (const auto& block : program.until->blocks) {
    const auto* expanded = find_expansion(block, from);
    all.push_back(std::numeric_limits<double>::infinity());
    if (expanded == nullptr || expanded->segments.empty()) continue;
    const auto u = forecast(join(so_far, program_path(expanded->segments, from)));
    if (!u) return failure(u.error());
    all.back() = *u;
  }
  return all;
}

std::string format_u(double u_deg_per_h) {
  return std::isfinite(u_deg_per_h) ? fmt::format("{:.4f}", u_deg_per_h) : "unknown";
}

std::string mark(const ProgramPlan& plan) { return plan.simulated ? "SIMULATED: " : ""; }

std::string outcome(const ProgramPlan& plan) {
  const auto& last = plan.parts.back();
  return fmt::format("{}; U {} °/h expected in {:.1f} h, {:g} °/h wanted on {}", plan.end, format_u(last.u_deg_per_h),
                     last.hours, plan.target_deg_per_h, plan.mission);
}

/// Returns the set point at the ends of each segment, over hours.
plot::Points set_points(const ProgramPlan& plan) {
  plot::Points points{.x = {0}, .y = {plan.parts.front().segments.front().target.value}};
  for (const auto& part : plan.parts)
    for (const auto& segment : part.segments) {
      points.x.push_back(points.x.back() + hours(shortest(segment)));
      points.y.push_back(segment.target.value);
    }
  return points;
}

}  // namespace

Result<ProgramPlan> plan_program(profile::Profile released, double target_deg_per_h, const ForecastFunction& forecast,
                                 const ProgressSink& progress) {
  ProgramPlan plan;
  plan.target_deg_per_h = target_deg_per_h;
  plan.mission = released.until->mission;
  const auto u_of_opening = forecast(program_path(released));
  if (!u_of_opening) return failure(u_of_opening.error());
  plan.parts.push_back({kOpening, released.segments, hours(profile::total_time(released.segments)), *u_of_opening});
  for (int number = 1; plan.end.empty(); ++number) {
    const auto used = profile::total_time(released.segments);
    if (!should_continue(progress, "choosing blocks", to_seconds(used) / to_seconds(released.until->longest)))
      return failure(FaultKind::interrupted, "plan", "stopped on request");
    const double u_now = plan.parts.back().u_deg_per_h;
    const auto u_after = forecast_blocks(released, forecast);
    if (!u_after) return failure(u_after.error());
    const auto decision = run::decide(released, {.number = number,
                                                 .target_deg_per_h = target_deg_per_h,
                                                 .u_now_deg_per_h = u_now,
                                                 .u_after_deg_per_h = *u_after,
                                                 .used = used,
                                                 .hold_left = {},
                                                 .is_record_short = !std::isfinite(u_now)});
    auto added = add_block(released, decision.block);
    if (!added) return failure(added.error());
    plan.end = decision.end;
    double u = u_now;
    for (std::size_t i = 0; i < released.until->blocks.size(); ++i)
      if (released.until->blocks[i].name == decision.block) u = (*u_after)[i];
    if (!added->empty())
      plan.parts.push_back({decision.block.empty() ? kClosing : decision.block, std::move(*added),
                            hours(profile::total_time(released.segments)), u});
  }
  return plan;
}

bool is_met(const ProgramPlan& plan) { return plan.end == run::kMet; }

std::string profile_text(const ProgramPlan& plan, const std::string& name) {
  profile::ProfileText text{.comment = mark(plan) + outcome(plan) + "\nPlanned from " + plan.reference,
                            .name = name,
                            .title = fmt::format("Planned for U {:g} °/h on {}", plan.target_deg_per_h, plan.mission),
                            .segments = {}};
  for (const auto& part : plan.parts) {
    auto comment = fmt::format("{}: U {} °/h expected at its end, after {:.1f} h", part.name,
                               format_u(part.u_deg_per_h), part.hours);
    for (const auto& segment : part.segments) text.segments.push_back({segment, std::exchange(comment, "")});
  }
  return write_profile(text);
}

std::string describe(const ProgramPlan& plan) {
  auto text = fmt::format("{}from {}\n  {:<28} {:>7} {:>12}\n", mark(plan), plan.reference, "part", "hours", "U, °/h");
  for (const auto& part : plan.parts)
    text += fmt::format("  {:<28} {:>7.1f} {:>12}\n", part.name, part.hours, format_u(part.u_deg_per_h));
  text += outcome(plan) + "\n";
  for (const auto& compared : plan.compared)
    text += fmt::format("  in comparison: {:<13} {:>7.1f} {:>12}\n", compared.name, compared.hours,
                        format_u(compared.u_deg_per_h));
  return text;
}

std::string to_json(const ProgramPlan& plan) {
  const auto number = [](double u) { return std::isfinite(u) ? Json(u) : Json(); };
  Json json{{"schema", kPlanSchema},
            {"simulated", plan.simulated},
            {"reference", plan.reference},
            {"mission", plan.mission},
            {"target_deg_per_h", plan.target_deg_per_h},
            {"is_met", is_met(plan)},
            {"end", plan.end},
            {"parts", Json::array()},
            {"compared", Json::array()}};
  for (const auto& part : plan.parts)
    json["parts"].push_back({{"name", part.name}, {"hours", part.hours}, {"u_deg_per_h", number(part.u_deg_per_h)}});
  for (const auto& one : plan.compared)
    json["compared"].push_back({{"name", one.name}, {"hours", one.hours}, {"u_deg_per_h", number(one.u_deg_per_h)}});
  return json_text(json) + "\n";
}

std::string to_svg(const ProgramPlan& plan) {
  constexpr double kHoursPerTick = 10;
  constexpr const char *kBlue = "#1f5fa8", *kGrey = "#6b7785", *kGreen = "#2b7a4b";
  plot::Curve u{.name = "planned program", .colour = kBlue, .marker = plot::Marker::circle};
  for (const auto& part : plan.parts) {
    u.x.push_back(part.hours);
    u.y.push_back(part.u_deg_per_h);
  }
  std::vector<plot::Curve> curves{std::move(u)};
  double last = plan.parts.back().hours;
  for (const auto& one : plan.compared) {
    last = std::max(last, one.hours);
    curves.push_back({.name = one.name,
                      .colour = curves.size() == 1 ? kGreen : kGrey,
                      .x = {one.hours},
                      .y = {one.u_deg_per_h},
                      .marker = curves.size() == 1 ? plot::Marker::diamond : plot::Marker::square,
                      .line = false});
  }
  auto expected = plot::make_panel("(a) Expanded uncertainty on the mission", "U, °/h", std::move(curves), 230);
  expected.left.logarithmic = true;
  expected.rules.push_back({fmt::format("{:g} °/h wanted", plan.target_deg_per_h), plan.target_deg_per_h});
  auto points = set_points(plan);
  auto program =
      plot::make_panel("(b) Planned program", "set point, °C",
                       {{.name = "", .colour = kBlue, .x = std::move(points.x), .y = std::move(points.y)}}, 150);
  return plot::to_svg(
      {.id = "plan",
       .title = "Expected uncertainty of the planned program",
       .x = {.title = "time, h", .range = plot::Range{0, std::ceil(last / kHoursPerTick) * kHoursPerTick}},
       .panels = {std::move(expected), std::move(program)},
       .simulated = plan.simulated});
}

}  // namespace gyrotherm::app
