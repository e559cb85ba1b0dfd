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
  for (const std::string step : {"choosing inputs", "tuning", "fitting", "leaving each fold out"})
    for (const double fraction : {0.0, 0.5, 1.0}) EXPECT_TRUE(progress("training " + model + ": " + step, fraction));
}

TEST(TrainingProgress, NeverDecreasesAndIsCompleteOnlyAtTheEnd) {
  for (const bool compares : {false, true}) {
    ShownProgress shown;
    TrainingProgress progress(shown.sink(), {.compares = compares});
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
  TrainingProgress progress(shown.sink(), {});
  report_training(progress, "three-point");
  progress("training multi-point: choosing inputs", 0);
  EXPECT_NEAR(shown.fractions.back(), 14.0 / 91, 1e-12);
}

/// The inputs are chosen within a moment, so the choice of the parameters must not begin with its end.
TEST(TrainingProgress, GrowsDuringEachStepOfATraining) {
  for (const bool quick : {false, true}) {
    ShownProgress shown;
    TrainingProgress progress(shown.sink(), {.quick = quick});
    double before = -1;
    for (const std::string model : {"three-point", "multi-point", "multi-point-t"}) {
      for (const std::string step : {"choosing inputs", "tuning", "leaving each fold out"})
        for (const double fraction : {0.1, 0.5, 1.0}) {
          progress("training " + model + ": " + step, fraction);
          EXPECT_GT(shown.fractions.back(), before) << quick << model << step << fraction;
          before = shown.fractions.back();
        }
    }
  }
  ShownProgress shown;
  TrainingProgress progress(shown.sink(), {});
  progress("training three-point: choosing inputs", 1);
  EXPECT_LT(shown.fractions.back(), 0.01);
  progress("training three-point: choosing on held-out folds", 0.5);
  EXPECT_NEAR(shown.fractions.back(), 0.5 * 14 * 0.9 / 91, 0.005);
}

TEST(TrainingProgress, WeighsModelsOfASmallSwarmEqually) {
  ShownProgress shown;
  TrainingProgress progress(shown.sink(), {.quick = true});
  std::vector<double> begins;
  for (const std::string model : {"three-point", "multi-point", "multi-point-t", "ridge-u"}) {
    progress("training " + model + ": choosing inputs", 0);
    begins.push_back(shown.fractions.back());
  }
  EXPECT_NEAR(begins[2], 2 * begins[1], 1e-12);
  EXPECT_NEAR(begins[3], 3 * begins[1], 1e-12);
  EXPECT_GT(begins[1], 0.3);
}

TEST(TrainingProgress, GrowsDuringNestedFolds) {
  ShownProgress shown;
  TrainingProgress progress(shown.sink(), {.nested = true});
  progress("training three-point: leaving each fold out", 1);
  const double before = shown.fractions.back();
  EXPECT_LT(before, 0.5 * 14 / 91);
  std::vector<double> folds;
  for (int fold = 1; fold <= 4; ++fold) {
    progress("training three-point: nested, fold " + std::to_string(fold) + " of 4", 0.5);
    folds.push_back(shown.fractions.back());
  }
  for (std::size_t i = 1; i < folds.size(); ++i) EXPECT_NEAR(folds[i] - folds[i - 1], 0.125 * 14 / 91, 1e-12) << i;
  EXPECT_GT(folds.front(), before);
  for (const char* step : {"nested, fold", "nested, fold x of y", "nested, fold 5 of 4", "nested, fold 1 of 0"})
    progress(std::string("training three-point: ") + step, 0.5);
  EXPECT_EQ(shown.fractions.back(), folds.back());
}

TEST(TrainingProgress, ToleratesFractionsOutOfRangeAndStagesWithoutStep) {
  ShownProgress shown;
  TrainingProgress progress(shown.sink(), {});
  progress("training three-point: tuning", 7);
  progress("training three-point: tuning", -7);
  progress("training three-point:", 0.5);
  progress("", 0.5);
  for (const double fraction : shown.fractions) EXPECT_LT(fraction, 14.8 / 91);
}

TEST(TrainingProgress, PassesTheRequestToStop) {
  ShownProgress shown;
  shown.continues = false;
  TrainingProgress progress(shown.sink(), {});
  EXPECT_FALSE(progress("training three-point: tuning", 0.1));
  TrainingProgress silent({}, {});
  EXPECT_TRUE(silent("training three-point: tuning", 0.1));
}

}  // namespace
}  // namespace gyrotherm::app
