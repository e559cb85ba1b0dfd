// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/qualify/training_progress.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <string_view>
#include <utility>

namespace gyrotherm::app {
namespace {

struct Weight {
  std::string_view stage;
  double seconds;  ///< on the default rig
};

/// The times of the trainings and the shares of their steps, measured on the default rig.
struct Weights {
  std::array<Weight, 4> models;
  double other_model;
  double other_models;  ///< all methods of comparison
  /// Share of a training that the choice of its inputs and parameters takes. The fit, the held-out folds and the
  /// verification follow.
  double choice;
};

constexpr Weights kFull{.models = {Weight{"training three-point", 14}, Weight{"training multi-point", 38},
                                   Weight{"training multi-point-t", 38}, Weight{"training ridge-u", 1}},
                        .other_model = 0.7,
                        .other_models = 20,
                        .choice = 0.9};
constexpr Weights kQuick{.models = {Weight{"training three-point", 1.6}, Weight{"training multi-point", 1.6},
                                    Weight{"training multi-point-t", 1.6}, Weight{"training ridge-u", 0.3}},
                         .other_model = 2,
                         .other_models = 56,
                         .choice = 0.8};

/// Share of the choice that the inputs take.
constexpr double kInputs = 0.05;

const Weights& weights_for(const TrainingKind& kind) { return kind.quick ? kQuick : kFull; }

double weigh(std::string_view model, const Weights& weights) {
  const auto* found = std::ranges::find(weights.models, model, &Weight::stage);
  return found != weights.models.end() ? found->seconds : weights.other_model;
}

/// Returns the number at the beginning of a text, or 0.
int leading_number(std::string_view text) {
  int number = 0;
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

/// Returns the completed part of the nested folds from a step like "nested, fold 2 of 4", or nothing for another step.
std::optional<double> nested_part(std::string_view step, double fraction) {
  constexpr std::string_view kFold = "nested, fold ", kOf = " of ";
  if (!step.starts_with(kFold)) return {};
  step.remove_prefix(kFold.size());
  const auto of = step.find(kOf);
  if (of == std::string_view::npos) return {};
  const int fold = leading_number(step), folds = leading_number(step.substr(of + kOf.size()));
  if (fold < 1 || folds < fold) return {};
  return (fold - 1 + fraction) / folds;
}

}  // namespace

TrainingProgress::TrainingProgress(ProgressSink show, TrainingKind kind) : show_(std::move(show)), kind_(kind) {
  const auto& weights = weights_for(kind_);
  total_ = kind_.compares ? weights.other_models : 0;
  for (const Weight& weight : weights.models) total_ += weight.seconds;
}

double TrainingProgress::completed_part(std::string_view step, double fraction) const {
  // The nested folds repeat the choice, so they take as long as all steps before them.
  const double own_share = kind_.nested ? 0.5 : 1;
  if (const auto nested = nested_part(step, fraction)) return own_share + (1 - own_share) * *nested;
  const double choice = weights_for(kind_).choice;
  if (step == "choosing inputs") return own_share * choice * kInputs * fraction;
  if (step == "tuning" || step.starts_with("choosing"))
    return own_share * choice * (kInputs + (1 - kInputs) * fraction);
  if (step == "leaving each fold out") return own_share * (choice + (1 - choice) / 2 * fraction);
  return own_share * choice;
}

bool TrainingProgress::operator()(std::string_view stage, double fraction) {
  const auto colon = stage.find(':');
  const auto model = stage.substr(0, colon);
  const auto step = colon == std::string_view::npos ? "" : stage.substr(std::min(colon + 2, stage.size()));
  if (model != model_) {
    before_ += weight_;
    weight_ = weigh(model, weights_for(kind_));
    model_ = model;
  }
  const double part = completed_part(step, std::clamp(fraction, 0.0, 1.0));
  constexpr double kAlmostDone = 0.99;
  shown_ = std::max(shown_, std::min(kAlmostDone, (before_ + weight_ * part) / total_));
  return !show_ || show_("training the models", shown_);
}

}  // namespace gyrotherm::app
