// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/qualify/training_progress.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace gyrotherm::app {
namespace {

struct Weight {
  std::string_view stage;
  double seconds;  ///< on the default rig
};

constexpr std::array kWeights{Weight{"training three-point", 14}, Weight{"training multi-point", 38},
                              Weight{"training multi-point-t", 38}, Weight{"training ridge-u", 1}};
constexpr double kOtherModel = 0.7;
constexpr double kOtherModels = 20;  ///< all methods of comparison
/// Share of a training that the choice of its parameters takes; the fit and its verification follow.
constexpr double kChoice = 0.9;

double weigh(std::string_view model) {
  const auto* found = std::ranges::find(kWeights, model, &Weight::stage);
  return found != kWeights.end() ? found->seconds : kOtherModel;
}

}  // namespace

TrainingProgress::TrainingProgress(ProgressSink show, bool compares)
    : show_(std::move(show)), total_(compares ? kOtherModels : 0) {
  for (const Weight& weight : kWeights) total_ += weight.seconds;
}

bool TrainingProgress::operator()(std::string_view stage, double fraction) {
  const auto colon = stage.find(':');
  const auto model = stage.substr(0, colon);
  const auto step = colon == std::string_view::npos ? "" : stage.substr(std::min(colon + 2, stage.size()));
  if (model != model_) {
    before_ += weight_;
    weight_ = weigh(model);
    model_ = model;
  }
  const bool is_choice = step == "tuning" || step == "choosing inputs";
  const double part = is_choice ? kChoice * std::clamp(fraction, 0.0, 1.0) : kChoice;
  constexpr double kAlmostDone = 0.99;
  shown_ = std::max(shown_, std::min(kAlmostDone, (before_ + weight_ * part) / total_));
  return !show_ || show_("training the models", shown_);
}

}  // namespace gyrotherm::app
