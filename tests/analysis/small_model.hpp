// SPDX-License-Identifier: Apache-2.0
/// Small models with known parameters.
#pragma once

#include "analysis/model/model.hpp"

namespace gyrotherm::data {

/// Returns a model with the inputs A − B and dA/dt and two support vectors. Every field of its file has a value.
[[nodiscard]] inline model::Model small_svr_model() {
  model::Model model;
  model.program_version = "0.1.0";
  model.inputs = "A-B,rate:A";
  model.method = "svr";
  model.terms = {gradient_term("A", "B"), rate_term("A")};
  model.scaling = {Eigen::RowVector2d{0.1, 0}, Eigen::RowVector2d{1.0 / 3, 2}};
  model.target_mean_deg_per_h = 0.01;
  model.target_std_deg_per_h = 0.7;
  model.function = methods::SvrModel{.support_vectors = (SampleMatrix(2, 2) << 0.5, -1, 1.0 / 7, 2).finished(),
                                     .beta = Eigen::Vector2d{1.5, -1.5},
                                     .b = 0.125,
                                     .parameters = {4, 1.25, 0.05},
                                     .relative_gap = 1e-7,
                                     .kkt_violation = 2e-6};
  model.trained_on = {{"run-1", "rate.db", "qualification", true, 2216}};
  model.selection = {{gradient_term("A", "B")}, 0.9, 1, true, "the °/h statement"};
  model.tuning.best = {4, 1.25, 0.05};
  model.tuning.cross_validation_mse = 1e-5;
  model.tuning.swarm.end = svm::SwarmEnd::stalled;
  model.tuning.swarm.best = {2, 0.3219, -4.3};
  model.tuning.swarm.history = {3e-5, 1e-5};
  model.tuning.swarm.coordinates_on_edge = {2};
  model.tuning.swarm.evaluations = 620;
  model.tuning.warnings = {"an edge"};
  model.tuning_options.swarm.seed = 18446744073709551615u;
  model.tuning_options.fixed_epsilon = 0.05;
  model.quick = true;
  model.folds = "leave one cycle out (4)";
  model.in_sample = {0.002, 1e-5, 0.0021, 0.01, 2216};
  model.leave_cycle_out = {0.003, 2e-5, 0.0031, 0.02, 2216};
  model.leave_cycle_out_residual = Eigen::Vector3d{0.1, -0.2, 1e-300};
  model.residual_noise = {.angle_random_walk_deg_per_sqrt_h = 0.05,
                          .instability_deg_per_h = 0.02,
                          .rate_random_walk_deg_per_h_per_sqrt_h = 1.0 / 3,
                          .start_deg_per_h = 0.25};
  model.input_min = Eigen::RowVector2d{-1, -5};
  model.input_max = Eigen::RowVector2d{1, 5};
  model.warnings = {"careful"};
  model.uncertainty = {.budget = {.averaging_s = 3600,
                                  .rows = {{.source = model::Source::thermometer_drift,
                                            .of = "A",
                                            .evaluation = model::Evaluation::b,
                                            .distribution = model::ErrorDistribution::rectangular,
                                            .standard_uncertainty = 0.05,
                                            .sensitivity = -0.1,
                                            .degrees_of_freedom = 12.5,
                                            .assumed = true}}},
                       .sensitivities = {{.thermometer = "A", .mean = -0.1, .rms = 0.125, .greatest = 0.5}},
                       .added_noise_deg_per_h = 1e-4};
  return model;
}

/// Returns three clusters with thermometers A and B.
[[nodiscard]] inline Clusters three_clusters() {
  Clusters clusters;
  clusters.thermometers = {"A", "B"};
  clusters.start_s = Eigen::Vector3d{0, 100, 200};
  clusters.temperature_c = (Eigen::MatrixXd(3, 2) << 20, 19.75, 21.5, 21.125, 18, 18.5).finished();
  clusters.rate_c_per_min = (Eigen::MatrixXd(3, 2) << 0, 0, 0.9, 0.825, -2.1, -1.575).finished();
  clusters.bias_deg_per_h = Eigen::Vector3d{0.2, -0.1, 0.4};
  clusters.set_point_c = Eigen::Vector3d{20, 21, 18};
  clusters.segment.setConstant(3, -1);
  clusters.last_segment.setConstant(3, -1);
  clusters.cycle.setConstant(3, -1);
  clusters.samples.setConstant(3, 100);
  return clusters;
}

/// Returns a linear model with a slope of 0.1 °/h per kelvin of A.
[[nodiscard]] inline model::Model small_slope_model() {
  model::Model model = small_svr_model();
  model.terms = {temperature_term("A")};
  model.scaling = {Eigen::RowVectorXd::Constant(1, 20), Eigen::RowVectorXd::Constant(1, 1)};
  model.target_mean_deg_per_h = 0;
  model.target_std_deg_per_h = 1;
  model.function = methods::LinearModel{.weights = Eigen::VectorXd::Constant(1, 0.1), .b = 0};
  model.input_min = Eigen::RowVectorXd::Constant(1, -100);
  model.input_max = Eigen::RowVectorXd::Constant(1, 100);
  return model;
}

}  // namespace gyrotherm::data
