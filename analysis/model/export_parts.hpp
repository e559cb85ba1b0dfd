// SPDX-License-Identifier: Apache-2.0
/// The parts of an exported model's C program. Each NAME_export.cpp writes one part; model_export.cpp assembles them.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/methods/method.hpp"
#include "analysis/model/c_text.hpp"
#include "analysis/model/model.hpp"
#include "analysis/tracking/bias_noise.hpp"
#include "core/result.hpp"

namespace gyrotherm::model {

/// Returns the index of an item in a list that contains it.
[[nodiscard]] Eigen::Index index_in(const auto& items, const auto& item) {
  return std::ranges::find(items, item) - items.begin();
}

// provenance

/// Returns the description of a model as lines of a block comment, each with a leading space and a line end: function,
/// training records and whether they were simulated, accuracy, and the trained range of each input.
[[nodiscard]] std::string c_provenance(const Model& model);

// function

/// Returns the tables and "static double function_of(const double z[], const double bounded[])".
[[nodiscard]] std::string c_function(const methods::Function& function);

/// Returns the sum of the weights of the function's terms, which bounds the rounding error of their sum.
[[nodiscard]] double sum_of_weights(const methods::Function& function);

/// Returns true if every constant and every divisor of the function is finite and can therefore be written as a C
/// constant.
[[nodiscard]] bool has_finite_constants(const methods::Function& function);

// range

/// Writes "static void bound(double x[])", which moves inputs to the bounded point (see Outside). Returns an empty text
/// if the function is only a plane.
[[nodiscard]] std::string bounding_in_c(const Model& model);

// lag

/// Returns the placeholders of the C templates that depend on lags: parameters, a ring buffer of each lag's past values
/// (as in SlidingLags) and the function that advances it. All are empty for a model without lags.
[[nodiscard]] CPlaceholders lag_placeholders(const Model& model, std::string_view name,
                                             const std::vector<std::string>& thermometers);

// lead

/// Returns the placeholders of the C templates that depend on the stream's lag: its description and, if is_led(), a
/// ring buffer of predictions and the extrapolation from it.
[[nodiscard]] CPlaceholders lead_placeholders(const Model& model, std::string_view name);

// self_test

/// Known answers for the self-test of an exported model: temperatures and the model's predictions.
struct KnownAnswers {
  /// Means over the last cluster length and over the one before it; columns are thermometers.
  data::SampleMatrix mean_c, before_c;
  /// Lags, K; columns are the model's lags.
  data::SampleMatrix lag_k;
  /// Predictions, as with Outside::continued.
  Eigen::VectorXd bias_deg_per_h;
  /// True for each row with an input outside the trained range.
  std::vector<bool> outside;
};

/// Computes six known answers near the training data and two outside the trained range. The result is deterministic.
[[nodiscard]] KnownAnswers known_answers(const Model& model, const std::vector<std::string>& thermometers);

/// Returns the placeholders with the tables of NAME_self_test.
[[nodiscard]] CPlaceholders self_test_placeholders(const KnownAnswers& answers);

/// One part of an exported program; all texts are empty if the model does not need the part.
struct CPart {
  std::string declarations;  ///< text for the header file
  /// Definitions for the source; they need <math.h>.
  std::string definitions;
  /// Statements for the body of NAME_self_test; they return 1 if a known answer is not reproduced.
  std::string test;
};

// uncertainty

/// Writes NAME_uncertainty and NAME_uncertainty_outside: U of a mean of compensated bias over the model's cluster
/// length, and the contributions to it. Returns an empty part for a model without an uncertainty. Fails with usage if a
/// value is not finite.
[[nodiscard]] Result<CPart> uncertainty_in_c(const Model& model, std::string_view name);

// tracking

/// Writes NAME_tracker, NAME_track_start and NAME_track: RestTracker in C for this noise and means over `seconds`. It
/// is a complete four-state Kalman filter without allocation, with some hundred operations once per `seconds`. It
/// propagates the covariance instead of using a fixed gain, because the optimal gain varies: while the filter learns
/// the turn-on bias, the gain falls from nearly 1 to about 0.01, and it rises again after hours of motion. Fails with
/// usage if a constant or a known answer is not finite.
[[nodiscard]] Result<CPart> tracking_in_c(const tracking::BiasNoise& noise, int seconds, std::string_view name);

}  // namespace gyrotherm::model
