// SPDX-License-Identifier: Apache-2.0
/// A program that is planned from the uncertainty that it is expected to give: released blocks, chosen by the rule of a
/// run that ends by itself, but before the run.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "acquisition/record/decision.hpp"
#include "analysis/planning/program_path.hpp"
#include "core/result.hpp"
#include "sequencer/profile/profile.hpp"

namespace gyrotherm::app {

/// A part of a planned program: the opening, a block, or the closing segments.
struct PlannedPart {
  std::string name;
  std::vector<profile::Segment> segments;
  /// Since the start of the program, at the end of this part.
  double hours{};
  /// Expected at the end of this part, °/h; infinite if unknown.
  double u_deg_per_h{};
};

/// A shipped or given program, for comparison.
struct ComparedProgram {
  std::string name;
  double hours{};
  double u_deg_per_h{};
};

struct ProgramPlan {
  double target_deg_per_h{};
  std::string mission;
  std::string reference;  ///< path of the record that the forecasts are based on
  bool simulated{};       ///< the record is of a virtual rig
  std::vector<PlannedPart> parts;
  std::vector<ComparedProgram> compared;
  /// Reason for the end: the target is met, it cannot be met, or the time is up.
  std::string end;
};

/// Returns the uncertainty that is expected after a program, °/h.
using ForecastFunction = std::function<Result<double>(const planning::ProgramPath& program)>;

/// Chooses blocks of a profile with [until] until its rule ends the program. Fails like the forecast.
[[nodiscard]] Result<ProgramPlan> plan_program(profile::Profile released, double target_deg_per_h,
                                               const ForecastFunction& forecast, const ProgressSink& progress);

/// Returns true if the plan meets its target.
[[nodiscard]] bool is_met(const ProgramPlan& plan);

/// Returns the text of the planned profile. Comments state the expected uncertainty of each part.
[[nodiscard]] std::string profile_text(const ProgramPlan& plan, const std::string& name);
/// Returns the table that is printed.
[[nodiscard]] std::string describe(const ProgramPlan& plan);
[[nodiscard]] std::string to_json(const ProgramPlan& plan);
/// Returns the figure: expected uncertainty over hours, and the set point of the program.
[[nodiscard]] std::string to_svg(const ProgramPlan& plan);

}  // namespace gyrotherm::app
