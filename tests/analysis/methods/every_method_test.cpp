// SPDX-License-Identifier: Apache-2.0
/// Tests that apply to every method in the table of methods.
#include <gtest/gtest.h>

#include <cmath>

#include "analysis/model/model.hpp"
#include "analysis/model/training.hpp"
#include "tests/analysis/random_samples.hpp"
#include "tests/analysis/synthetic_run.hpp"

namespace gyrotherm::methods {
namespace {

MethodOptions quick_options(int threads = 0) {
  MethodOptions options;
  options.tuning.swarm.particles = 4;
  options.tuning.swarm.iterations = 2;
  options.tuning.swarm.threads = threads;
  return options;
}

/// Returns samples with inputs for every method: a temperature, its square and cube, a gradient and rates.
data::Samples all_kinds_of_terms(Eigen::Index rows) {
  data::Samples samples = data::bent_samples(rows, 5, 0.1, 11);
  const data::Term t = data::temperature_term("A"), rate = data::rate_term("A");
  samples.terms = {t, data::gradient_term("A", "B"), t * t, rate, t * rate};
  return samples;
}

class EveryMethod : public testing::TestWithParam<Method> {};

TEST_P(EveryMethod, HasNameAndCitation) {
  const Method& method = GetParam();
  EXPECT_EQ(*find_method(method.name), &*std::ranges::find(methods(), method.name, &Method::name));
  EXPECT_FALSE(method.title.empty() || method.citation.empty() || method.inputs.empty());
}

TEST_P(EveryMethod, DoesNotDependOnThreadCount) {
  const Method& method = GetParam();
  const data::Samples samples = all_kinds_of_terms(120);
  const auto folds = folds_of(samples, 3);
  std::vector<Eigen::VectorXd> values;
  std::vector<HyperParameters> chosen;
  for (const int threads : {1, 2}) {
    const auto choice = method.choose(folds, quick_options(threads), {});
    ASSERT_TRUE(choice) << text(choice.error());
    const auto fit = method.fit(samples.set(), choice->parameters, quick_options(threads));
    ASSERT_TRUE(fit) << text(fit.error());
    values.push_back(evaluate_function(fit->function, samples.x));
    chosen.push_back(choice->parameters);
  }
  EXPECT_EQ(values[0], values[1]);
  ASSERT_EQ(chosen[0].size(), chosen[1].size());
  for (std::size_t i = 0; i < chosen[0].size(); ++i)
    EXPECT_EQ(chosen[0][i].value, chosen[1][i].value) << chosen[0][i].name;
}

TEST_P(EveryMethod, PredictsUnseenSamples) {
  const Method& method = GetParam();
  const data::Samples samples = all_kinds_of_terms(240), unseen = [] {
    data::Samples other = data::bent_samples(200, 5, 0, 12);
    return other;
  }();
  const auto choice = method.choose(folds_of(samples, 4), quick_options(), {});
  ASSERT_TRUE(choice);
  const auto fit = method.fit(samples.set(), choice->parameters, quick_options());
  ASSERT_TRUE(fit);
  EXPECT_LT((evaluate_function(fit->function, unseen.x) - unseen.y).norm(), 0.9 * unseen.y.norm());
  EXPECT_GE(fit->effective_parameters, 1);
  EXPECT_LE(fit->effective_parameters, 240);
  EXPECT_GT(count_stored_numbers(fit->function), 0);
}

TEST_P(EveryMethod, RejectsInvalidSamples) {
  const Method& method = GetParam();
  const data::Samples samples = all_kinds_of_terms(60);
  const auto choice = method.choose(folds_of(samples, 3), quick_options(), {});
  ASSERT_TRUE(choice);
  const auto fit_fault = [&](const data::SampleMatrix& x, const Eigen::VectorXd& y) {
    const auto fit = method.fit({x, y, samples.terms}, choice->parameters, quick_options());
    EXPECT_FALSE(fit);
    return fit ? Fault{} : fit.error();
  };
  data::SampleMatrix invalid = samples.x;
  invalid(3, 1) = std::nan("");
  EXPECT_EQ(fit_fault(invalid, samples.y).kind, FaultKind::usage);
  Eigen::VectorXd infinite = samples.y;
  infinite(2) = HUGE_VAL;
  EXPECT_EQ(fit_fault(samples.x, infinite).kind, FaultKind::usage);
  EXPECT_EQ(fit_fault(samples.x.topRows(1), samples.y.head(1)).kind, FaultKind::usage);
  EXPECT_EQ(fit_fault(samples.x.topRows(0), samples.y.head(0)).kind, FaultKind::usage);
}

TEST_P(EveryMethod, RequiresFoldsAndStopsWhenInterrupted) {
  const Method& method = GetParam();
  const data::Samples samples = all_kinds_of_terms(60);
  auto folds = folds_of(samples, 3);
  const auto stopped = method.choose(folds, quick_options(), [](std::string_view, double) { return false; });
  if (stopped) {
    EXPECT_TRUE(stopped->parameters.empty()) << "the method has no parameters";
    return;
  }
  EXPECT_EQ(stopped.error().kind, FaultKind::interrupted);
  EXPECT_EQ(method.choose({}, quick_options(), {}).error().kind, FaultKind::usage);
  folds[1].test_x(0, 0) = std::nan("");
  EXPECT_EQ(method.choose(folds, quick_options(), {}).error().kind, FaultKind::usage);
}

TEST_P(EveryMethod, RoundTripsThroughFile) {
  const Method& method = GetParam();
  data::SyntheticRun run;
  run.cycle_rates_c_per_min = {4, 5};
  run.hold_s = 900;
  const data::Dataset dataset = make_synthetic_run(run);
  model::TrainingOptions options;
  options.method = method.name;
  options.tuning.swarm.particles = 3;
  options.tuning.swarm.iterations = 1;
  const auto clusters = make_clusters(dataset);
  const auto model = train({dataset}, {*clusters}, options);
  ASSERT_TRUE(model) << text(model.error());
  EXPECT_EQ(model->inputs, method.inputs);
  const std::string json = to_json(*model);
  const auto back = model::model_from_json(json, "model.json");
  ASSERT_TRUE(back) << text(back.error());
  EXPECT_EQ(model::to_json(*back), json);
  const Eigen::VectorXd before = *predict(*model, *clusters), after = *model::predict(*back, *clusters);
  for (Eigen::Index i = 0; i < before.size(); ++i) {
    EXPECT_TRUE(before(i) == after(i) || (std::isnan(before(i)) && std::isnan(after(i)))) << i;
  }
  EXPECT_LT(model->in_sample.std, data::compute_figures(clusters->bias_deg_per_h).std);
}

INSTANTIATE_TEST_SUITE_P(Table, EveryMethod, testing::ValuesIn(methods().begin(), methods().end()), [](const auto& of) {
  std::string name(of.param.name);
  std::erase(name, '-');
  return name;
});

}  // namespace
}  // namespace gyrotherm::methods
