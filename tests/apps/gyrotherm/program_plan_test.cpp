// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/plan/program_plan.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/file.hpp"
#include "core/json.hpp"

namespace gyrotherm::app {
namespace {

profile::Profile shipped_until() {
  const std::string path = GYROTHERM_SOURCE_DIR "/profiles/until.toml";
  return *profile::parse_profile(*read_text_file(path), path);
}

/// Forecasts 0.1 °/h divided by the root of the hours with the unit on.
Result<double> per_root_hour(const planning::ProgramPath& program) {
  const auto on = (program.start.array() >= 0).count();
  return 0.1 / std::sqrt(static_cast<double>(on) / 36);
}

/// Forecasts by the span of the set points alone.
Result<double> by_span(const planning::ProgramPath& program) {
  return 1 / (1 + program.set_point_c.maxCoeff() - program.set_point_c.minCoeff());
}

TEST(ProgramPlan, AddsBlocksUntilTheTargetIsExpected) {
  const auto plan = plan_program(shipped_until(), 0.04, per_root_hour, {});
  ASSERT_TRUE(plan) << plan.error().what;
  EXPECT_TRUE(is_met(*plan));
  EXPECT_EQ(plan->parts.front().name, "opening");
  EXPECT_EQ(plan->parts.back().name, "closing");
  double before = 1;
  for (const auto& part : plan->parts) {
    EXPECT_LE(part.u_deg_per_h, before);
    before = part.u_deg_per_h;
  }
  EXPECT_LE(before, 0.04);
  EXPECT_GT((plan->parts.end() - 3)->u_deg_per_h, 0.04) << "no block more than needed";
}

TEST(ProgramPlan, StatesWhyItEndsWithoutTheTarget) {
  const auto late = plan_program(shipped_until(), 0.001, per_root_hour, {});
  ASSERT_TRUE(late);
  EXPECT_FALSE(is_met(*late));
  EXPECT_EQ(late->end, "the time is up");
  EXPECT_LE(late->parts.back().hours, 40);
  const auto useless = plan_program(shipped_until(), 0.001, by_span, {});
  ASSERT_TRUE(useless);
  EXPECT_EQ(useless->end, "U cannot be met");
}

TEST(ProgramPlan, IsAValidProfileWithTheSameSegments) {
  const auto plan = plan_program(shipped_until(), 0.04, per_root_hour, {});
  ASSERT_TRUE(plan);
  const auto text = profile_text(*plan, "planned");
  const auto read = profile::parse_profile(text, "planned.toml");
  ASSERT_TRUE(read) << gyrotherm::text(read.error());
  std::size_t segments = 0;
  for (const auto& part : plan->parts) {
    for (const auto& segment : part.segments) {
      ASSERT_LT(segments, read->segments.size());
      EXPECT_EQ(read->segments[segments].target, segment.target);
      EXPECT_EQ(read->segments[segments].duration, segment.duration);
      EXPECT_EQ(read->segments[segments].unit.off, segment.unit.off);
      ++segments;
    }
  }
  EXPECT_EQ(read->segments.size(), segments);
  EXPECT_FALSE(read->until);
  EXPECT_NE(text.find("# opening: U 0.0"), std::string::npos) << text;
}

TEST(ProgramPlan, MarksSimulatedReferences) {
  auto plan = *plan_program(shipped_until(), 0.04, per_root_hour, {});
  plan.reference = "reference.db";
  plan.compared = {{"short", 15, 0.03}, {"qualification", 61.6, 0.02}};
  for (const bool simulated : {false, true}) {
    plan.simulated = simulated;
    const auto has_mark = [](const std::string& text) { return text.find("SIMULATED") != std::string::npos; };
    EXPECT_EQ(has_mark(profile_text(plan, "p")), simulated);
    EXPECT_EQ(has_mark(describe(plan)), simulated);
    EXPECT_EQ(has_mark(to_svg(plan)), simulated);
    const auto json = Json::parse(to_json(plan));
    EXPECT_EQ(json["simulated"], simulated);
    EXPECT_EQ(json["parts"].size(), plan.parts.size());
    EXPECT_EQ(json["compared"][1]["name"], "qualification");
  }
}

TEST(ProgramPlan, FailsLikeItsForecastAndEndsOnRequest) {
  const ForecastFunction fails = [](const planning::ProgramPath&) -> Result<double> {
    return failure(FaultKind::usage, "mission", "no");
  };
  EXPECT_EQ(plan_program(shipped_until(), 0.04, fails, {}).error().kind, FaultKind::usage);
  const auto stopped =
      plan_program(shipped_until(), 0.04, per_root_hour, [](std::string_view, double) { return false; });
  EXPECT_EQ(stopped.error().kind, FaultKind::interrupted);
}

}  // namespace
}  // namespace gyrotherm::app
