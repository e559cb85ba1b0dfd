// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "analysis/model/model.hpp"
#include "tests/analysis/small_model.hpp"

namespace gyrotherm::model {
namespace {

constexpr Eigen::Index kVectors = 60;

data::SampleMatrix random_rows(Eigen::Index rows, Eigen::Index columns, std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal;
  return data::SampleMatrix::NullaryExpr(rows, columns, [&] { return normal(generator); });
}

/// Returns a model of A and B with random vectors and weights, and with a range that permits any input.
Model model_of(std::uint64_t seed) {
  Model model = data::small_svr_model();
  model.terms = {data::temperature_term("A"), data::temperature_term("B")};
  auto& svr = std::get<methods::SvrModel>(model.function);
  svr.support_vectors = random_rows(kVectors, 2, seed);
  svr.beta = 3 * random_rows(kVectors, 1, seed + 1000);
  return model;
}

/// Returns a model with random vectors as an expansion with one length per input.
Model expansion_of(std::uint64_t seed) {
  Model model = model_of(seed);
  const auto svr = std::get<methods::SvrModel>(model.function);
  model.function = methods::ExpansionModel{.centres = svr.support_vectors,
                                           .lengths = Eigen::RowVector2d{0.7, 1.9},
                                           .widths = Eigen::VectorXd::Constant(kVectors, 0.8),
                                           .weights = svr.beta,
                                           .b = svr.b};
  return model;
}

data::Clusters clusters_of(Eigen::Index rows, std::uint64_t seed) {
  data::Clusters clusters;
  clusters.thermometers = {"A", "B"};
  clusters.temperature_c = random_rows(rows, 2, seed);
  clusters.rate_c_per_min.setZero(rows, 2);
  return clusters;
}

/// Sum of Gaussians: centres (divided by the lengths), weights and width.
struct Sum {
  data::SampleMatrix centres;
  Eigen::VectorXd weights;
  double width{};
};

Sum sum_of(const Model& model) {
  if (const auto* svr = std::get_if<methods::SvrModel>(&model.function)) {
    return {svr->support_vectors, svr->beta, svr->parameters.sigma};
  }
  const auto& expansion = std::get<methods::ExpansionModel>(model.function);
  return {expansion.centres.array().rowwise() / expansion.lengths.array(), expansion.weights, expansion.widths(0)};
}

double inner(const Sum& one, const Sum& other) {
  double sum = 0;
  for (Eigen::Index i = 0; i < one.weights.size(); ++i) {
    for (Eigen::Index j = 0; j < other.weights.size(); ++j) {
      const double squares = (one.centres.row(i) - other.centres.row(j)).squaredNorm();
      sum += one.weights(i) * other.weights(j) * std::exp(-squares / (2 * one.width * one.width));
    }
  }
  return sum;
}

Eigen::VectorXd change(const Model& full, const Model& reduced, const data::Clusters& clusters) {
  return *predict(full, clusters) - *predict(reduced, clusters);
}

Model reduced(const Model& model, const data::Clusters& clusters, const ReducedSetGoal& goal) {
  auto smaller = reduce(model, clusters, goal);
  EXPECT_TRUE(smaller) << text(smaller.error());
  return *smaller;
}

TEST(ReducedSet, LosesLessWithMoreVectors) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(seed);
    const Model model = seed % 2 == 0 ? model_of(seed) : expansion_of(seed);
    double before = 1e300;
    for (int vectors = 1; vectors <= kVectors; ++vectors) {
      const ReducedSetSummary loss = *reduced(model, clusters_of(80, seed), {.vectors = vectors}).reduction;
      EXPECT_LE(loss.vectors, vectors);
      EXPECT_LE(loss.bound_deg_per_h, before * (1 + 1e-9) + 1e-9);
      before = loss.bound_deg_per_h;
    }
    EXPECT_EQ(before, 0);
  }
}

TEST(ReducedSet, KeepsModelUnchangedWithAllVectors) {
  const Model model = model_of(1);
  for (const int vectors : {static_cast<int>(kVectors), 1000}) {
    Model same = reduced(model, clusters_of(50, 1), {.vectors = vectors});
    EXPECT_EQ(same.reduction->vectors, kVectors);
    EXPECT_EQ(same.reduction->max_change_deg_per_h, 0);
    same.reduction.reset();
    EXPECT_EQ(to_json(same), to_json(model));
  }
}

TEST(ReducedSet, StatesMeasuredLoss) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(seed);
    const Model model = seed % 2 == 0 ? model_of(seed) : expansion_of(seed);
    const data::Clusters clusters = clusters_of(120, seed + 50);
    const Model smaller = reduced(model, clusters, {.vectors = 15});
    const Eigen::VectorXd measured = change(model, smaller, clusters);
    const ReducedSetSummary& loss = *smaller.reduction;
    EXPECT_GT(loss.max_change_deg_per_h, 0);
    EXPECT_NEAR(loss.max_change_deg_per_h, measured.cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_NEAR(loss.rms_change_deg_per_h, std::sqrt(measured.squaredNorm() / 120), 1e-12);
    EXPECT_EQ(loss.clusters, 120);
    EXPECT_EQ(loss.vectors_before, kVectors);
    EXPECT_EQ(loss.vectors, sum_of(smaller).weights.size());
    const Sum full = sum_of(model), kept = sum_of(smaller);
    const double norm = std::sqrt(inner(full, full) - 2 * inner(full, kept) + inner(kept, kept));
    EXPECT_NEAR(loss.bound_deg_per_h, 0.7 * norm, 1e-6);
  }
}

TEST(ReducedSet, AddsLossToUncertainty) {
  Model model = model_of(3);
  model.uncertainty.emplace();
  model.uncertainty->budget.rows = {{.source = Source::turn_on, .standard_uncertainty = 0.001},
                                    {.source = Source::model_form, .standard_uncertainty = 0.002}};
  const Model smaller = reduced(model, clusters_of(120, 7), {.vectors = 15});
  const auto& rows = smaller.uncertainty->budget.rows;
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].standard_uncertainty, 0.001);
  EXPECT_NEAR(rows[1].standard_uncertainty, std::hypot(0.002, smaller.reduction->rms_change_deg_per_h), 1e-15);
}

TEST(ReducedSet, ChangesNoPredictionByMoreThanItsBound) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(seed);
    const Model model = seed % 2 == 0 ? model_of(seed) : expansion_of(seed);
    const Model smaller = reduced(model, clusters_of(30, seed), {.vectors = 10});
    const double worst = change(model, smaller, clusters_of(5000, seed + 99)).cwiseAbs().maxCoeff();
    EXPECT_LE(worst, smaller.reduction->bound_deg_per_h);
    EXPECT_GT(worst, 0.01 * smaller.reduction->bound_deg_per_h) << "the bound must not be far too wide";
  }
}

TEST(ReducedSet, ProjectsOntoKeptVectors) {
  const Model model = model_of(3);
  const Model smaller = reduced(model, clusters_of(30, 3), {.vectors = 12});
  // The change is 0 at each kept centre. The coordinates of a centre are the scaled inputs.
  const Sum kept = sum_of(smaller);
  data::Clusters at_centres = clusters_of(12, 1);
  for (Eigen::Index i = 0; i < 12; ++i) {
    at_centres.temperature_c.row(i) =
        kept.centres.row(i).array() * model.scaling.std.array() + model.scaling.mean.array();
  }
  EXPECT_LT(change(model, smaller, at_centres).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(ReducedSet, KeepsFewestVectorsForPermittedLoss) {
  const Model model = model_of(4);
  const data::Clusters clusters = clusters_of(100, 4);
  for (const double loss : {0.3, 0.03, 0.003}) {
    const Model smaller = reduced(model, clusters, {.max_change_deg_per_h = loss});
    EXPECT_LE(smaller.reduction->max_change_deg_per_h, loss * (1 + 1e-9));
    EXPECT_LT(smaller.reduction->vectors, kVectors);
    const Model one_less = reduced(model, clusters, {.vectors = smaller.reduction->vectors - 1});
    EXPECT_GT(one_less.reduction->max_change_deg_per_h, loss);
  }
  EXPECT_EQ(reduced(model, clusters, {.max_change_deg_per_h = 1e-300}).reduction->vectors, kVectors);
}

TEST(ReducedSet, RoundTripsThroughFile) {
  const Model smaller = reduced(model_of(5), clusters_of(20, 5), {.vectors = 7});
  const auto back = model_from_json(to_json(smaller), "small.json");
  ASSERT_TRUE(back) << text(back.error());
  ASSERT_TRUE(back->reduction);
  EXPECT_EQ(to_json(*back), to_json(smaller));
}

TEST(ReducedSet, RefusesInvalidGoals) {
  const data::Clusters clusters = clusters_of(20, 6);
  const Model model = model_of(6);
  const auto refused = [&](const Model& which, const ReducedSetGoal& goal) {
    const auto smaller = reduce(which, clusters, goal);
    EXPECT_FALSE(smaller);
    EXPECT_TRUE(smaller || smaller.error().kind == FaultKind::usage);
  };
  refused(model, {});
  refused(model, {.vectors = 5, .max_change_deg_per_h = 1});
  refused(model, {.vectors = 0});
  refused(model, {.max_change_deg_per_h = 0});
  refused(model, {.max_change_deg_per_h = std::nan("")});
  refused(reduced(model, clusters, {.vectors = 5}), {.vectors = 4});
  Model other = model;
  other.function = methods::LinearModel{Eigen::Vector2d{1, 2}, 0};
  refused(other, {.vectors = 5});
  other = expansion_of(6);
  std::get<methods::ExpansionModel>(other.function).widths(3) = 0.1;
  refused(other, {.vectors = 5});
  other = model;
  other.terms[0] = data::temperature_term("Z");
  refused(other, {.vectors = 5});
  data::Clusters missing = clusters;
  missing.temperature_c.setConstant(std::nan(""));
  EXPECT_FALSE(reduce(model, missing, {.vectors = 5}));
}

}  // namespace
}  // namespace gyrotherm::model
