// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/run/run_decider.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "analysis/data/clusters.hpp"
#include "analysis/data/dataset.hpp"
#include "apps/console/interrupt.hpp"
#include "core/process.hpp"
#include "sequencer/profile/released_blocks.hpp"
#include "sequencer/run/resume.hpp"

namespace gyrotherm::app {
namespace {

constexpr double kUnknownU = std::numeric_limits<double>::infinity();
/// An axis without a reading for this long is left out of a decision.
constexpr std::size_t kSilentRows = 200;

/// Returns whether the axis has a reading among the last rows.
bool is_present(const record::Record& history, const data::AxisChoice& choice) {
  for (std::size_t unit = 0; unit < history.info.units.size(); ++unit) {
    const auto& info = history.info.units[unit];
    if (history.info.units.size() > 1 && info.name != choice.unit) continue;
    for (std::size_t axis = 0; axis < info.axes.size(); ++axis) {
      if (info.axes.size() > 1 && info.axes[axis].name != choice.axis) continue;
      const auto& counts = history.units[unit].rotation[axis];
      const auto first = counts.end() - static_cast<std::ptrdiff_t>(std::min(kSilentRows, counts.size()));
      if (std::any_of(first, counts.end(), [](double count) { return !std::isnan(count); })) return true;
    }
  }
  return false;
}

/// Assesses one axis. Fails as assess() and make_clusters() do.
Result<planning::Assessment> assess_axis(const record::Record& history, const data::AxisChoice& axis,
                                         const planning::ProgramPath& mission,
                                         const std::vector<planning::ProgramPath>& blocks,
                                         const ProgressSink& progress) {
  data::RecordedRun recorded{.dataset = data::make_dataset(history, "this run", axis), .clusters = {}};
  auto clusters = data::make_clusters(recorded.dataset);
  if (!clusters) return failure(clusters.error());
  recorded.clusters = std::move(*clusters);
  const auto prior = history.info.goal ? history.info.goal->prior_text : std::string();
  return planning::assess(recorded, mission, blocks, {.prior = prior}, progress);
}

std::vector<planning::ProgramPath> block_paths(const profile::Profile& profile) {
  std::vector<planning::ProgramPath> paths;
  const auto from = profile.segments.back().target;
  for (const auto& block : profile.until->blocks) {
    const auto* expanded = find_expansion(block, from);
    paths.push_back(program_path(expanded ? std::span(expanded->segments) : std::span<const profile::Segment>(), from));
  }
  return paths;
}

}  // namespace

AssessedRun assess_run(const record::Record& history, const planning::ProgramPath& mission,
                       const std::vector<planning::ProgramPath>& blocks, const ProgressSink& progress) {
  AssessedRun all{.u_now_deg_per_h = 0,
                  .u_after_deg_per_h = std::vector<double>(blocks.size(), 0),
                  .gains = std::vector<double>(blocks.size(), 0)};
  bool is_any_present = false;
  for (const auto& axis : data::list_axes(history.info)) {
    if (is_unused(history.info, axis.unit) || !is_present(history, axis)) continue;
    is_any_present = true;
    const auto assessed = assess_axis(history, axis, mission, blocks, progress);
    if (!assessed) {
      all.is_interrupted = assessed.error().kind == FaultKind::interrupted;
      all.trouble = fmt::format("{}: {}", qualified_name(axis), text(assessed.error()));
      break;
    }
    all.u_now_deg_per_h = std::max(all.u_now_deg_per_h, assessed->u_now_deg_per_h);
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      all.u_after_deg_per_h[i] = std::max(all.u_after_deg_per_h[i], assessed->u_after_deg_per_h[i]);
      all.gains[i] = std::max(all.gains[i], assessed->gains[i]);
    }
  }
  if (!is_any_present) all.trouble = "no axis has a reading in the last 200 s";
  if (all.trouble.empty()) return all;
  all.u_now_deg_per_h = kUnknownU;
  std::ranges::fill(all.u_after_deg_per_h, kUnknownU);
  return all;
}

RunDecider::RunDecider(record::Record history, planning::ProgramPath mission, bool in_worker)
    : history_(std::move(history)), mission_(std::move(mission)), in_worker_(in_worker) {
  for (const auto& [slot, event] : history_.events)
    if (record::is_decision(event)) last_ = record::parse_decision(event.text);
}

Result<std::unique_ptr<RunDecider>> RunDecider::make(record::Record history, bool in_worker) {
  if (!history.info.goal) return nullptr;
  auto mission = mission_path(*history.info.goal);
  if (!mission) return failure(mission.error());
  return std::unique_ptr<RunDecider>(new RunDecider(std::move(history), std::move(*mission), in_worker));
}

RunDecider::~RunDecider() {
  is_stopping_ = true;
  if (assessment_.valid()) assessment_.wait();
}

/// Computes in this thread. Ctrl-C ends the computation.
AssessedRun RunDecider::assess_now(const run::RunController& run_controller) {
  return assess_run(history_, mission_, block_paths(run_controller.profile()),
                    [](std::string_view, double) { return !interrupted(); });
}

/// Computes a copy of the history in a thread of its own.
void RunDecider::begin_assessment(const run::RunController& run_controller) {
  assessment_ = std::async(std::launch::async, [this, history = history_, mission = mission_,
                                                blocks = block_paths(run_controller.profile())] {
    block_signals();
    return assess_run(history, mission, blocks, [this](std::string_view, double) { return !is_stopping_; });
  });
}

Result<void> RunDecider::carry_out(run::RunController& run_controller, Console& console, const AssessedRun& assessed) {
  const auto& profile = run_controller.profile();
  const auto decision =
      run::decide(profile, {.number = last_ ? last_->number + 1 : 1,
                            .target_deg_per_h = history_.info.goal->u_deg_per_h,
                            .u_now_deg_per_h = assessed.u_now_deg_per_h,
                            .u_after_deg_per_h = assessed.u_after_deg_per_h,
                            .gains = assessed.gains,
                            .used = kSecond * run_controller.next_slot(),
                            .hold_left = time_left(profile, run_controller.state()),
                            .is_record_short = assessed.trouble.empty() && !std::isfinite(assessed.u_now_deg_per_h)});
  if (!assessed.trouble.empty())
    run_controller.note(EventKind::fault, "the uncertainty cannot be computed: " + assessed.trouble);
  const auto first = history_.info.segments.size();
  if (auto done = run_controller.carry_out(decision); !done) return done;
  last_ = decision;
  console.print_message(record::decision_event(decision, {}, 0).text);
  const auto& segments = run_controller.profile().segments;
  std::vector<record::RunInfo::SegmentInfo> added;
  for (auto i = first; i < segments.size(); ++i) added.push_back(run::describe_segment(segments[i]));
  record::add_block(history_.info, first, added, decision.block);
  return {};
}

Result<void> RunDecider::after_tick(run::RunController& run_controller, Console& console) {
  record::append_sample(history_, run_controller.last());
  if (assessment_.valid()) {
    if (assessment_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return {};
    const auto assessed = assessment_.get();
    return run_controller.awaits_decision() ? carry_out(run_controller, console, assessed) : Result<void>();
  }
  if (!run_controller.awaits_decision()) return {};
  if (in_worker_) return begin_assessment(run_controller), Result<void>();
  const auto assessed = assess_now(run_controller);
  return assessed.is_interrupted ? Result<void>() : carry_out(run_controller, console, assessed);
}

std::string RunDecider::describe_progress(std::int64_t seconds) const {
  return last_
             ? record::describe_progress(*last_, seconds)
             : fmt::format("U is computed at the end of the opening, {:g} °/h wanted", history_.info.goal->u_deg_per_h);
}

}  // namespace gyrotherm::app
