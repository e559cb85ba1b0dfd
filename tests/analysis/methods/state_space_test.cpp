// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>

#include "analysis/methods/ridge_u.hpp"
#include "analysis/model/training.hpp"
#include "tests/analysis/random_samples.hpp"
#include "tests/analysis/synthetic_run.hpp"

namespace gyrotherm::methods {
namespace {

/// Returns clusters whose bias follows A with a time constant of 1200 s and B with one of 9600 s. Both also have a
/// small immediate effect.
data::Clusters clusters_with_two_states(const data::Dataset& dataset) {
  data::Clusters clusters = *make_clusters(dataset);
  const std::vector<data::Term> terms = {data::lag_term(1200, "A"), data::lag_term(9600, "B"),
                                         data::temperature_term("A"), data::temperature_term("B")};
  const Eigen::Vector4d weights{0.004, -0.003, 0.0005, 0.0003};
  clusters.bias_deg_per_h =
      *evaluate(terms, clusters) * weights + 2e-4 * data::normal_vector(clusters.bias_deg_per_h.size(), 1);
  return clusters;
}

bool has(const model::Model& model, double time_constant_s) {
  return std::ranges::any_of(model.hyper_parameters,
                             [&](const HyperParameter& tau) { return tau.value == time_constant_s; });
}

TEST(StateSpace, FindsTimeConstantsOfStates) {
  const data::Dataset dataset = data::make_synthetic_run({});
  const data::Clusters clusters = clusters_with_two_states(dataset);
  model::TrainingOptions options;
  options.method = "state-space";
  const auto model = train({dataset}, {clusters}, options);
  ASSERT_TRUE(model) << text(model.error());
  EXPECT_TRUE(has(*model, 1200) && has(*model, 9600));
  EXPECT_LE(model->hyper_parameters.size(), kMostStates);
  EXPECT_LT(model->leave_cycle_out.rmse, 4e-4) << "the simulated noise is 2e-4 °/h";
}

TEST(StateSpace, FitsPlaneOfChosenLagsOnly) {
  const data::Clusters clusters = *make_clusters(data::make_synthetic_run({}));
  const std::vector<data::Term> terms = {data::temperature_term("A"), data::lag_term(600, "A"),
                                         data::lag_term(2400, "A"), data::lag_term(600, "B")};
  const data::SampleMatrix x = *evaluate(terms, clusters);
  const auto fit = fit_state_space({x, clusters.bias_deg_per_h, terms}, {{"tau_1_s", 600}}, {});
  ASSERT_TRUE(fit);
  const auto& linear = std::get<LinearModel>(fit->function);
  EXPECT_EQ(linear.weights(2), 0);
  const std::vector<Eigen::Index> chosen = {0, 1, 3};
  const data::SampleMatrix chosen_x = x(Eigen::all, chosen);
  const PenalisedPlane plane = fit_plane({chosen_x, clusters.bias_deg_per_h, terms});
  EXPECT_EQ(linear.weights(chosen), plane.weights);
  EXPECT_NEAR(fit->effective_parameters, plane.effective_parameters + 1, 1e-12);
}

TEST(StateSpace, HasNoStateWithoutLag) {
  const data::Dataset dataset = data::make_synthetic_run({});
  model::TrainingOptions options;
  options.method = "state-space";
  options.inputs = "temperatures";
  const auto model = train({dataset}, {*make_clusters(dataset)}, options);
  ASSERT_TRUE(model) << text(model.error());
  EXPECT_TRUE(model->hyper_parameters.empty());
  EXPECT_EQ(std::ranges::count(model->warnings, "no input is a lag, so the model has no state"), 1);
}

}  // namespace
}  // namespace gyrotherm::methods
