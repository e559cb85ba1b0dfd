// SPDX-License-Identifier: Apache-2.0
#include "analysis/planning/forecast.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "analysis/model/prior_training.hpp"
#include "tests/analysis/synthetic_run.hpp"

namespace gyrotherm::planning {
namespace {

data::RecordedRun reference_run() {
  data::Dataset dataset = data::make_synthetic_run({.cycle_rates_c_per_min = {2, 5}});
  data::Clusters clusters = *make_clusters(dataset);
  return {std::move(dataset), std::move(clusters)};
}

ProgramPath hold_at(double at_c, Eigen::Index clusters) {
  ProgramPath path;
  path.set_point_c.setConstant(clusters, at_c);
  path.start.setZero(clusters);
  return path;
}

/// Returns holds of 30 clusters at each set point.
ProgramPath visit(const std::vector<double>& set_points_c) {
  ProgramPath path;
  for (const double set_point_c : set_points_c) path = join(path, hold_at(set_point_c, 30));
  return path;
}

TEST(Forecast, GivesTheUncertaintyOfTheReferenceForItsOwnProgram) {
  const data::RecordedRun run = reference_run();
  const ProgramPath program = recorded_path(run.dataset);
  const auto forecast = Forecast::make(run, program);
  ASSERT_TRUE(forecast) << forecast.error().what;
  const auto u = forecast->expanded_after(program);
  ASSERT_TRUE(u);
  EXPECT_NEAR(*u / forecast->reference_deg_per_h(), 1, 0.25);
}

TEST(Forecast, DecreasesWithEachRepetition) {
  const data::RecordedRun run = reference_run();
  const auto forecast = Forecast::make(run, visit({-10, 40}));
  ASSERT_TRUE(forecast);
  ProgramPath program = visit({20, -20, 50, 20});
  double before = *forecast->expanded_after(program);
  for (int repetition = 0; repetition < 4; ++repetition) {
    program = join(program, visit({-20, 50, 20}));
    const double u = *forecast->expanded_after(program);
    EXPECT_LE(u, before * (1 + 1e-9));
    before = u;
  }
}

TEST(Forecast, IsGreaterForAProgramThatDoesNotReachTheMission) {
  const data::RecordedRun run = reference_run();
  const auto forecast = Forecast::make(run, visit({50, 20, 50}));
  ASSERT_TRUE(forecast);
  const double reaching = *forecast->expanded_after(visit({20, 50, 20, 50})),
               cold = *forecast->expanded_after(visit({20, -20, 20, -20}));
  EXPECT_GT(cold, 1.5 * reaching);
}

TEST(Forecast, IsInfiniteForAConstantTemperature) {
  const data::RecordedRun run = reference_run();
  const auto forecast = Forecast::make(run, visit({20, 40}));
  ASSERT_TRUE(forecast);
  const auto u = forecast->expanded_after(hold_at(20, 10));
  ASSERT_TRUE(u);
  EXPECT_TRUE(std::isinf(*u)) << *u;
}

TEST(Forecast, DecreasesWithPowerOns) {
  data::RecordedRun run = reference_run();
  run.dataset.gyro_uncertainty.turn_on_repeatability_deg_per_h = 0.1;  // the greatest row
  const auto forecast = Forecast::make(run, visit({20, 50, 20}));
  ASSERT_TRUE(forecast);
  ProgramPath once = visit({20, -20, 50, 20, 50, 20}), four = once;
  for (Eigen::Index k = 0; k < four.start.size(); ++k) four.start(k) = static_cast<int>(4 * k / four.start.size());
  EXPECT_NEAR(*forecast->expanded_after(four) / *forecast->expanded_after(once), std::sqrt(1.25 / 2), 0.1);
}

/// Learns a prior from six units of the type. `factor` multiplies their bias.
population::TypePrior learn_type(double factor = 1) {
  std::vector<population::UnitClusters> units;
  std::optional<data::Dataset> first;
  for (std::uint64_t seed = 11; seed <= 16; ++seed) {
    data::Dataset dataset = data::make_synthetic_run({.run_id = std::to_string(seed), .seed = seed});
    data::Clusters clusters = *make_clusters(dataset);
    clusters.bias_deg_per_h *= factor;
    units.push_back({"unit " + std::to_string(seed), {std::move(clusters)}});
    if (!first) first = std::move(dataset);
  }
  return *model::learn_prior(*first, units);
}

TEST(ForecastWithPrior, NeedsFewerHours) {
  const data::RecordedRun run = reference_run();
  const ProgramPath mission = visit({-10, 40}), glance = visit({20, 15}), whole = visit({20, -20, 50, 20, -20, 50, 20});
  const auto own = Forecast::make(run, mission), typed = Forecast::make_with_prior(learn_type(), run, mission);
  ASSERT_TRUE(own && typed) << typed.error().what;
  const double own_ratio = *own->expanded_after(glance) / *own->expanded_after(whole),
               typed_ratio = *typed->expanded_after(glance) / *typed->expanded_after(whole);
  EXPECT_LT(typed_ratio, own_ratio);
  EXPECT_GE(typed_ratio, 1);
}

TEST(ForecastWithPrior, DecreasesWithEachRepetition) {
  const data::RecordedRun run = reference_run();
  const auto forecast = Forecast::make_with_prior(learn_type(), run, visit({-10, 40}));
  ASSERT_TRUE(forecast) << forecast.error().what;
  ProgramPath program = visit({20});
  double before = *forecast->expanded_after(program);
  for (int repetition = 0; repetition < 4; ++repetition) {
    program = join(program, visit({-20, 50, 20}));
    const double u = *forecast->expanded_after(program);
    EXPECT_LE(u, before * (1 + 1e-9));
    before = u;
  }
}

TEST(ForecastWithPrior, IsGreaterForAnotherType) {
  const data::RecordedRun run = reference_run();
  const ProgramPath mission = visit({-10, 40}), program = visit({20, -20, 50, 20});
  const auto same = Forecast::make_with_prior(learn_type(), run, mission),
             other = Forecast::make_with_prior(learn_type(-3), run, mission);
  ASSERT_TRUE(same && other);
  EXPECT_GT(*other->expanded_after(program), *same->expanded_after(program));
}

TEST(ForecastWithPrior, NeedsThermometersOfTheType) {
  population::TypePrior prior = learn_type();
  prior.terms.front().factors.front().first = "Z";
  EXPECT_FALSE(Forecast::make_with_prior(prior, reference_run(), visit({20})));
}

TEST(Forecast, NeedsAUsableReference) {
  data::RecordedRun run = reference_run();
  run.dataset.gradients.clear();
  EXPECT_EQ(Forecast::make(run, visit({20})).error().kind, FaultKind::usage);
  run = reference_run();
  run.clusters = pick_clusters(run.clusters, {0, 1, 2});
  EXPECT_FALSE(Forecast::make(run, visit({20})));
}

}  // namespace
}  // namespace gyrotherm::planning
