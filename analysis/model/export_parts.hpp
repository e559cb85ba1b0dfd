// SPDX-License-Identifier: Apache-2.0
/// The parts of an exported model's C program. Each is written by a file of its own, NAME_export.cpp; model_export.cpp
/// puts them together.
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

/// Returns the index of an item in a list that has it.
[[nodiscard]] Eigen::Index index_in(const auto& items, const auto& item) {
  return std::ranges::find(items, item) - items.begin();
}

// provenance

/// Returns what is known of a model as lines of a block comment, each begun with a space and ended: what it computes,
/// from what it was trained and whether that was simulated, its figures, and the trained range of each input.
[[nodiscard]] std::string c_provenance(const Model& model);

// function

/// Returns tables and "static double function_of(const double z[], const double bounded[])".
[[nodiscard]] std::string c_function(const methods::Function& function);

/// Returns the sum of the weights of what the function adds up: it says how much the rounding of that sum can amount
/// to.
[[nodiscard]] double sum_of_weights(const methods::Function& function);

/// Returns whether every constant of the function, and what is divided by, can be written in C.
[[nodiscard]] bool has_finite_constants(const methods::Function& function);

// range

/// Writes "static void bound(double x[])", which moves inputs to the bounded point; nothing for a function that is all
/// plane.
[[nodiscard]] std::string bounding_in_c(const Model& model);

// lag

/// Returns the words of the C texts that depend on lags: parameters, a ring of what each lag has followed (as
/// SlidingLags keeps it), and the function that moves it on. All are empty for a model without lags.
[[nodiscard]] CWords lag_words(const Model& model, std::string_view name, const std::vector<std::string>& thermometers);

// lead

/// Returns the words of the C texts that depend on the stream's lag: its description and, if the model is_led(), a ring
/// of predictions and the extrapolation from it.
[[nodiscard]] CWords lead_words(const Model& model, std::string_view name);

// self_test

/// Known answers for the self-test of an exported model: temperatures and what the model predicts from them.
struct KnownAnswers {
  /// Means of the last cluster length and of the one before; columns are thermometers.
  data::SampleMatrix mean_c, before_c;
  data::SampleMatrix lag_k;        ///< columns are the model's lags
  Eigen::VectorXd bias_deg_per_h;  ///< predicted, as Outside::continued does
  std::vector<bool> outside;       ///< an input was
};

/// Computes six answers near what the model was trained on and two farther out; the same each time.
[[nodiscard]] KnownAnswers known_answers(const Model& model, const std::vector<std::string>& thermometers);

/// Returns the tables of NAME_self_test.
[[nodiscard]] CWords self_test_words(const KnownAnswers& answers);

/// A part of an exported program; all empty where the model has nothing for it.
struct CPart {
  std::string declarations;  ///< for the header
  std::string definitions;   ///< for the source; needs <math.h>
  std::string test;          ///< for the body of NAME_self_test: returns 1 if known answers do not come out again
};

// uncertainty

/// Writes NAME_uncertainty and NAME_uncertainty_outside: U of a mean of compensated bias over the model's cluster
/// length, and the contributions that it is made of. Empty for a model that says nothing of its uncertainty. Fails with
/// usage if these are not finite.
[[nodiscard]] Result<CPart> uncertainty_in_c(const Model& model, std::string_view name);

// tracking

/// Writes NAME_tracker, NAME_track_start and NAME_track: RestTracker in C, its constants those of the noise at means
/// over `seconds`: a whole Kalman filter of four states without allocation, some hundred operations once in so many
/// seconds. Its covariance goes along instead of a gain that is fixed, since it is the start that matters most: while a
/// turn-on is being learnt the gain falls from near 1 to a hundredth, and it rises again after the gyro has moved for
/// hours. Fails with usage if a constant or a known answer is not finite.
[[nodiscard]] Result<CPart> tracking_in_c(const tracking::BiasNoise& noise, int seconds, std::string_view name);

}  // namespace gyrotherm::model
