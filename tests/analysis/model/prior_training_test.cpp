// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/prior_training.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "analysis/model/uncertainty.hpp"
#include "tests/analysis/random_samples.hpp"
#include "tests/analysis/synthetic_run.hpp"

namespace gyrotherm::model {
namespace {

constexpr double kTurnOn_deg_per_h = 2e-4;

/// Returns the synthetic run of one unit of a type. Each unit has its own constant and its own slopes of A − B … A − H.
data::Dataset run_of_unit(std::uint64_t unit, std::uint64_t run = 0) {
  data::Dataset dataset =
      data::make_synthetic_run({.run_id = "unit " + std::to_string(unit) + " run " + std::to_string(run),
                                .noise_deg_per_h = 0.01,
                                .absolute_deg_per_h_per_c = 2e-4,
                                .seed = 100 * unit + run + 1});
  dataset.identity = "SN " + std::to_string(unit);
  dataset.gyro_uncertainty.turn_on_repeatability_deg_per_h = kTurnOn_deg_per_h;
  const Eigen::VectorXd own = data::normal_vector(9, 7000 + unit);
  dataset.bias_deg_per_h.array() += 0.005 * own(8) + kTurnOn_deg_per_h * data::normal_vector(1, 90 * unit + run)(0);
  for (Eigen::Index j = 1; j < 8; ++j)
    dataset.bias_deg_per_h += 1e-3 * own(j) * (dataset.temperature_c.col(0) - dataset.temperature_c.col(j));
  return dataset;
}

data::Clusters beginning(const data::Clusters& run, Eigen::Index count) {
  std::vector<Eigen::Index> rows(static_cast<std::size_t>(count));
  std::iota(rows.begin(), rows.end(), 0);
  return pick_clusters(run, rows);
}

double rms(const Eigen::VectorXd& values) {
  return std::sqrt(values.squaredNorm() / static_cast<double>(values.size()));
}

const BudgetRow& row(const Model& model, Source source) {
  return *std::ranges::find(model.uncertainty->budget.rows, source, &BudgetRow::source);
}

bool has_warning(const Model& model, const std::string& what) {
  return std::ranges::any_of(model.warnings, [&](const std::string& w) { return w.find(what) != w.npos; });
}

class TypePriorTraining : public testing::Test {
 protected:
  static constexpr std::uint64_t kNext = 50;
  static void SetUpTestSuite() {
    std::vector<population::UnitClusters> units;
    for (std::uint64_t unit = 1; unit <= 8; ++unit)
      units.push_back({"SN " + std::to_string(unit), {*make_clusters(run_of_unit(unit))}});
    prior_ = *learn_prior(run_of_unit(1), units, {.type = "ring", .quick = true, .simulated = true});
    own_ = run_of_unit(kNext);
    clusters_ = *make_clusters(own_);
    used_ = run_of_unit(kNext, 1);
    used_clusters_ = *make_clusters(used_);
  }
  static Result<Model> trained_on(Eigen::Index clusters) {
    return train_with_prior(prior_, {own_}, {beginning(clusters_, clusters)}, {.folds = {}, .program_version = "1"});
  }
  static inline population::TypePrior prior_;
  static inline data::Dataset own_, used_;
  static inline data::Clusters clusters_, used_clusters_;
};

TEST_F(TypePriorTraining, LearnsTypeWithUncertaintiesOfRecord) {
  ASSERT_EQ(prior_.terms.size(), 8u);
  EXPECT_EQ(to_string(prior_.terms.front()), "A-B");
  EXPECT_EQ(to_string(prior_.terms.back()), "A");
  EXPECT_EQ(prior_.noise.turn_on_deg_per_h, kTurnOn_deg_per_h);
  EXPECT_FALSE(prior_.error_covariance.isZero(0)) << "a drift of 0.05 K is assumed";
  EXPECT_LT(prior_.input_min(7), -15);
  EXPECT_GT(prior_.input_max(7), 45);
}

TEST_F(TypePriorTraining, TrainsWholeRangeModelFromFewClusters) {
  const auto few = trained_on(45), all = trained_on(clusters_.start_s.size());
  ASSERT_TRUE(few && all) << text((few ? all : few).error());
  const auto error = [&](const Model& model) -> Eigen::VectorXd {
    const auto inputs = apply_range_policy(model, *evaluate(model.terms, used_clusters_), Outside::continued);
    EXPECT_LE(inputs.worst_excess, 0.05) << "a record of 75 min does not bound the range";
    return used_clusters_.bias_deg_per_h - predict(model, inputs);
  };
  const double raw = data::compute_figures(used_clusters_.bias_deg_per_h).std;
  EXPECT_LT(rms(error(*few)), 0.25 * raw);
  EXPECT_LE(rms(error(*all)), rms(error(*few)));
  for (const auto* model : {&*few, &*all}) {
    const Eigen::VectorXd half = *interval_half_widths(*model, *model->uncertainty, used_, used_clusters_);
    EXPECT_GT((error(*model).cwiseAbs().array() <= half.array()).cast<double>().mean(), 0.85);
  }
  EXPECT_GT(row(*few, Source::coefficients).standard_uncertainty, row(*all, Source::coefficients).standard_uncertainty);
  EXPECT_EQ(row(*few, Source::coefficients).degrees_of_freedom, 7);
}

TEST_F(TypePriorTraining, ReproducesVarianceOfPriorPrediction) {
  const auto model = trained_on(60);
  ASSERT_TRUE(model) << text(model.error());
  const auto unit = population::learn_unit(prior_, std::vector{beginning(clusters_, 60)});
  ASSERT_TRUE(unit);
  const auto told = population::predict(prior_, *unit, used_clusters_);
  const auto found = predict_with_std(*model, *evaluate(model->terms, used_clusters_));
  ASSERT_TRUE(told && found);
  EXPECT_LT((told->bias_deg_per_h - found->bias_deg_per_h).norm(), 1e-9 * told->bias_deg_per_h.norm());
  const double same = std::pow(prior_.noise.wander_deg_per_h, 2) + std::pow(kTurnOn_deg_per_h, 2);
  const Eigen::VectorXd of_function = (told->expanded_deg_per_h / 2).cwiseAbs2().array() - same;
  EXPECT_LT((of_function - found->std_deg_per_h.cwiseAbs2()).norm(), 1e-6 * of_function.norm());
}

TEST_F(TypePriorTraining, PredictsFoldWithoutItsClusters) {
  const auto model = trained_on(clusters_.start_s.size());
  ASSERT_TRUE(model) << text(model.error());
  EXPECT_EQ(model->folds, "leave one cycle out (4)");
  const data::Fold fold = data::plan_folds({clusters_})->folds[2];
  const auto without = population::learn_unit(prior_, std::vector{pick_clusters(clusters_, fold.training)});
  ASSERT_TRUE(without);
  const data::Clusters held_out = pick_clusters(clusters_, fold.held_out);
  const Eigen::VectorXd residual =
      held_out.bias_deg_per_h - population::predict(prior_, *without, held_out)->bias_deg_per_h;
  EXPECT_LT((model->leave_cycle_out_residual(fold.held_out) - residual).norm(), 1e-9 * residual.norm());
  EXPECT_NE(model->in_sample.rmse, model->leave_cycle_out.rmse);
}

TEST_F(TypePriorTraining, KeepsRunsSeparateInEveryFold) {
  const data::Clusters part = beginning(used_clusters_, 100);
  const auto model = train_with_prior(prior_, {own_, used_}, {clusters_, part}, {.folds = {}, .program_version = {}});
  ASSERT_TRUE(model) << text(model.error());
  EXPECT_EQ(model->trained_on.size(), 2u);
  EXPECT_EQ(model->leave_cycle_out_residual.size(), clusters_.start_s.size() + 100);
  const auto by_hand = population::learn_unit(prior_, std::vector{clusters_, part});
  ASSERT_TRUE(by_hand);
  const Eigen::VectorXd careful = noise_aware_coefficients(prior_, *by_hand);
  EXPECT_NEAR(std::get<methods::LinearModel>(model->function).b, careful(0), 1e-12);
  EXPECT_NEAR(model->effective_parameters, by_hand->effective_parameters, 1e-9);
  EXPECT_GT(model->effective_parameters, 1);
  EXPECT_LE(model->effective_parameters, 9 + 1e-9);
}

TEST_F(TypePriorTraining, PredictsShortRecordsOnlyFromType) {
  const auto model = trained_on(2);
  ASSERT_TRUE(model) << text(model.error());
  EXPECT_EQ(model->folds, "all held out together, predicted from the type only");
  const data::Clusters two = beginning(clusters_, 2);
  const Eigen::VectorXd by_type = population::predict(prior_, *population::learn_unit(prior_, {}), two)->bias_deg_per_h;
  EXPECT_LT((two.bias_deg_per_h - by_type - model->leave_cycle_out_residual).norm(), 1e-9);
  EXPECT_GE(row(*model, Source::model_form).standard_uncertainty, 0);
}

TEST_F(TypePriorTraining, ReportsVarianceAsSeparateRow) {
  const auto model = trained_on(60);
  ASSERT_TRUE(model) << text(model.error());
  ASSERT_TRUE(model->variance);
  EXPECT_GT(row(*model, Source::coefficients).standard_uncertainty, 0);
  EXPECT_TRUE(std::isnan(model->uncertainty->variance_in_training));
}

TEST_F(TypePriorTraining, RoundTripsModelFile) {
  const auto model = trained_on(60);
  ASSERT_TRUE(model) << text(model.error());
  const std::string json = to_json(*model);
  const auto back = model_from_json(json, "model.json");
  ASSERT_TRUE(back) << text(back.error());
  EXPECT_EQ(to_json(*back), json);
  EXPECT_EQ(back->method, kTypePriorMethod);
  EXPECT_EQ(*predict(*back, used_clusters_), *predict(*model, used_clusters_));
  for (const auto* word : {"SIMULATED", "ring", "8 units", "SN 1; SN 2"})
    EXPECT_NE(back->particulars.find(word), std::string::npos) << back->particulars;
}

TEST_F(TypePriorTraining, WarnsIfPriorContainsSameGyro) {
  EXPECT_FALSE(has_warning(*trained_on(60), "counts twice"));
  const data::Dataset known = run_of_unit(3, 1);
  const auto model = train_with_prior(prior_, {known}, {*make_clusters(known)}, {.folds = {}, .program_version = {}});
  ASSERT_TRUE(model) << text(model.error());
  EXPECT_TRUE(has_warning(*model, "counts twice"));
  population::TypePrior named = prior_;
  named.units[2] = "the third";
  const auto trained = [&] {
    return *train_with_prior(named, {known}, {*make_clusters(known)}, {.folds = {}, .program_version = {}});
  };
  EXPECT_FALSE(has_warning(trained(), "counts twice")) << "identity unknown";
  named.records = {{.name = "the third", .run_id = "another", .identity = known.identity}};
  EXPECT_TRUE(has_warning(trained(), "counts twice")) << "the identity decides, not the name";
  named.records = {{.name = "the third", .run_id = known.run_id}};
  EXPECT_TRUE(has_warning(trained(), "counts twice")) << "the same run";
  data::Dataset real = own_;
  real.simulated = false;
  const auto mixed = train_with_prior(prior_, {real}, {clusters_}, {.folds = {}, .program_version = {}});
  ASSERT_TRUE(mixed) << text(mixed.error());
  EXPECT_TRUE(has_warning(*mixed, "SIMULATED"));
}

TEST_F(TypePriorTraining, RefusesUnsuitableRecords) {
  const auto refuses = [&](const std::vector<data::Dataset>& datasets, const std::vector<data::Clusters>& clusters) {
    const auto model = train_with_prior(prior_, datasets, clusters, {.folds = {}, .program_version = {}});
    return !model && model.error().kind == FaultKind::usage;
  };
  EXPECT_TRUE(refuses({}, {}));
  EXPECT_TRUE(refuses({own_, own_}, {clusters_, clusters_}));
  data::Clusters other = clusters_;
  other.thermometers[3] = "Z";
  EXPECT_TRUE(refuses({own_}, {other}));
  other = clusters_;
  other.length_s = 50;
  EXPECT_TRUE(refuses({own_}, {other}));
  other = clusters_;
  other.temperature_c.setConstant(std::nan(""));
  EXPECT_TRUE(refuses({own_}, {other}));
  population::TypePrior of_another_zero = prior_;
  of_another_zero.records = {{.name = "SN 1", .run_id = "another", .bias_zero = "nothing removed"}};
  const auto of_two_zeros =
      train_with_prior(of_another_zero, {own_}, {clusters_}, {.folds = {}, .program_version = {}});
  ASSERT_FALSE(of_two_zeros);
  EXPECT_NE(of_two_zeros.error().what.find("different bias reference (earth rate removed) than the prior"),
            std::string::npos)
      << of_two_zeros.error().what;
  data::Dataset own_zero = own_;
  own_zero.bias_zero = of_another_zero.records.front().bias_zero = data::kOwnReference;
  EXPECT_FALSE(train_with_prior(of_another_zero, {own_zero}, {clusters_}, {.folds = {}, .program_version = {}}))
      << "the two references are means of different records";
  const auto selecting = learn_prior(own_, {}, {.inputs = "multi-point"});
  ASSERT_FALSE(selecting);
  EXPECT_EQ(selecting.error().kind, FaultKind::usage);
}

}  // namespace
}  // namespace gyrotherm::model
