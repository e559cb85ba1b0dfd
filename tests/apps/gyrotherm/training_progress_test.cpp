// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/qualify/training_progress.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace gyrotherm::app {
namespace {

struct ShownProgress {
  std::vector<double> fractions;
  bool continues = true;
  ProgressSink sink() {
    return [this](std::string_view stage, double fraction) {
      EXPECT_EQ(stage, "training the models");
      fractions.push_back(fraction);
      return continues;
    };
  }
};

/// Reports the stages of a training as the model trainer does.
void report_training(TrainingProgress& progress, const std::string& model) {
  for (const std::string step : {"tuning", "fitting", "leaving each fold out"})
    for (const double fraction : {0.0, 0.5, 1.0}) EXPECT_TRUE(progress("training " + model + ": " + step, fraction));
}

TEST(TrainingProgress, NeverDecreasesAndIsCompleteOnlyAtTheEnd) {
  for (const bool compares : {false, true}) {
    ShownProgress shown;
    TrainingProgress progress(shown.sink(), compares);
    for (const char* model : {"three-point", "multi-point", "multi-point-t", "ridge-u"})
      report_training(progress, model);
    for (int other = 0; compares && other < 60; ++other) report_training(progress, "method " + std::to_string(other));
    for (std::size_t i = 1; i < shown.fractions.size(); ++i) EXPECT_GE(shown.fractions[i], shown.fractions[i - 1]) << i;
    EXPECT_EQ(shown.fractions.front(), 0);
    EXPECT_GT(shown.fractions.back(), 0.95);
    EXPECT_LT(shown.fractions.back(), 1);
  }
}

TEST(TrainingProgress, WeighsModelsByTheirTime) {
  ShownProgress shown;
  TrainingProgress progress(shown.sink(), false);
  report_training(progress, "three-point");
  progress("training multi-point: tuning", 0);
  EXPECT_NEAR(shown.fractions.back(), 14.0 / 91, 1e-12);
}

TEST(TrainingProgress, ToleratesFractionsOutOfRangeAndStagesWithoutStep) {
  ShownProgress shown;
  TrainingProgress progress(shown.sink(), false);
  progress("training three-point: tuning", 7);
  progress("training three-point: tuning", -7);
  progress("training three-point:", 0.5);
  progress("", 0.5);
  for (const double fraction : shown.fractions) EXPECT_LT(fraction, 14.8 / 91);
}

TEST(TrainingProgress, PassesTheRequestToStop) {
  ShownProgress shown;
  shown.continues = false;
  TrainingProgress progress(shown.sink(), false);
  EXPECT_FALSE(progress("training three-point: tuning", 0.1));
  TrainingProgress silent({}, false);
  EXPECT_TRUE(silent("training three-point: tuning", 0.1));
}

}  // namespace
}  // namespace gyrotherm::app
