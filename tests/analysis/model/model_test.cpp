// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/model.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/analysis/small_model.hpp"

namespace gyrotherm::model {
namespace {

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

Model two_term_model() {
  Model model = data::small_svr_model();
  model.method = "linear";
  model.function = methods::LinearModel{Eigen::Vector2d{2, -0.5}, 0.25};
  model.selection = {};
  return model;
}

Model two_function_model() {
  Model model = two_term_model();
  model.method = "rbfnn";
  model.hyper_parameters = {{"centres", 2}, {"lambda", 1e-3}};
  model.effective_parameters = 2.5;
  model.function = methods::ExpansionModel{.centres = (data::SampleMatrix(2, 2) << 0.5, -1, 1.0 / 7, 2).finished(),
                                           .lengths = Eigen::RowVector2d{1, 2},
                                           .widths = Eigen::Vector2d{0.5, 3},
                                           .weights = Eigen::Vector2d{1.5, -0.75},
                                           .b = 0.125};
  return model;
}

Model two_neuron_model() {
  Model model = two_term_model();
  model.method = "bpnn";
  model.function = methods::NetworkModel{.weights = (data::SampleMatrix(1, 2) << 0.5, -1).finished(),
                                         .offsets = Eigen::VectorXd::Constant(1, 0.1),
                                         .out = Eigen::VectorXd::Constant(1, 2),
                                         .b = -0.5};
  return model;
}

TEST(Model, FollowsFormula) {
  const data::Clusters clusters = data::three_clusters();
  const auto predicted = predict(data::small_svr_model(), clusters);
  ASSERT_TRUE(predicted);
  const double z0 = (0.375 - 0.1) * 3, z1 = 0.9 / 2;
  const auto kernel = [&](double v0, double v1) {
    return std::exp(-((z0 - v0) * (z0 - v0) + (z1 - v1) * (z1 - v1)) / (2 * 1.25 * 1.25));
  };
  const double f = 1.5 * kernel(0.5, -1) - 1.5 * kernel(1.0 / 7, 2) + 0.125;
  EXPECT_NEAR((*predicted)(1), 0.7 * f + 0.01, 1e-14);
  const auto straight = predict(two_term_model(), clusters);
  EXPECT_NEAR((*straight)(1), 0.7 * (2 * z0 - 0.5 * z1 + 0.25) + 0.01, 1e-14);
  const auto bump = [&](double c0, double c1, double width) {
    return std::exp(-0.5 * ((z0 - c0) * (z0 - c0) + (z1 - c1) * (z1 - c1) / 4) / (width * width));
  };
  const auto expanded = predict(two_function_model(), clusters);
  const double sum = 1.5 * bump(0.5, -1, 0.5) - 0.75 * bump(1.0 / 7, 2, 3) + 0.125;
  EXPECT_NEAR((*expanded)(1), 0.7 * sum + 0.01, 1e-14);
  const auto network = predict(two_neuron_model(), clusters);
  EXPECT_NEAR((*network)(1), 0.7 * (2 * std::tanh(0.5 * z0 - z1 + 0.1) - 0.5) + 0.01, 1e-14);
}

TEST(Model, PredictsNanForMissingReading) {
  data::Clusters clusters = data::three_clusters();
  clusters.temperature_c(1, 0) = std::nan("");
  EXPECT_TRUE(std::isnan((*predict(data::small_svr_model(), clusters))(1)));
  EXPECT_FALSE(std::isnan((*predict(data::small_svr_model(), clusters))(2)));
}

TEST(Model, RefusesClustersWithoutItsThermometers) {
  data::Clusters clusters = data::three_clusters();
  clusters.thermometers = {"A", "C"};
  const auto predicted = predict(data::small_svr_model(), clusters);
  ASSERT_FALSE(predicted);
  EXPECT_EQ(predicted.error().kind, FaultKind::usage);
}

TEST(ModelFile, RoundTripsBitForBit) {
  for (const Model& model : {data::small_svr_model(), two_term_model(), two_function_model(), two_neuron_model()}) {
    const auto back = model_from_json(to_json(model), "model.json");
    ASSERT_TRUE(back) << text(back.error());
    EXPECT_EQ(to_json(*back), to_json(model));
    EXPECT_EQ(*predict(*back, data::three_clusters()), *predict(model, data::three_clusters()));
    EXPECT_EQ(back->leave_cycle_out_residual, model.leave_cycle_out_residual);
    EXPECT_EQ(back->selection.statement, model.selection.statement);
  }
  EXPECT_EQ(model_from_json(to_json(data::small_svr_model()), "m")->tuning_options.swarm.seed, 18446744073709551615u);
}

TEST(ModelFile, AcceptsMethodOfEarlierVersion) {
  Model model = data::small_svr_model();
  model.method = "svr-joint";
  model.function = methods::ExpansionModel{.centres = (data::SampleMatrix(2, 2) << 0.5, -1, 1.0 / 7, 2).finished(),
                                           .lengths = Eigen::RowVector2d{1, 1},
                                           .widths = Eigen::Vector2d{1.25, 1.25},
                                           .weights = Eigen::Vector2d{1.5, -1.5},
                                           .b = 0.125,
                                           .slope = Eigen::Vector2d{-2.5, 1.0 / 3}};
  model.hyper_parameters = {{"C", 4}, {"plane penalty", 4.0 / 3}};
  const std::string json = replaced(to_json(model), "\"best\": {", "\"best\": {\"plane_penalty\": 1.25, ");
  const auto back = model_from_json(json, "model.json");
  ASSERT_TRUE(back) << text(back.error());
  EXPECT_EQ(back->method, "svr-joint");
  EXPECT_EQ(*predict(*back, data::three_clusters()), *predict(model, data::three_clusters()));
}

TEST(ModelFile, ReportsLineAndColumnOfSyntaxError) {
  const auto model = model_from_json("{\n \"schema\": ?}", "m.json");
  ASSERT_FALSE(model);
  EXPECT_EQ(model.error().kind, FaultKind::bad_file);
  EXPECT_EQ(model.error().where, "m.json:2:12");
}

/// Returns a model file with minimum and maximum of an input exchanged. Clamping to such a range would set every value
/// to the same limit.
std::string model_file_with_reversed_range(Model model) {
  std::swap(model.input_min(1), model.input_max(1));
  return to_json(model);
}

TEST(ModelFile, ReportsPathOfInvalidContent) {
  const std::string good = to_json(data::small_svr_model());
  const struct {
    std::string json, where;
  } laws[] = {{replaced(good, "gyrotherm-model/1", "gyrotherm-model/9"), "schema"},
              {replaced(good, "\"method\": \"svr\"", "\"method\": \"magic\""), "method"},
              {replaced(good, "\"form\": \"svr\"", "\"form\": \"magic\""), "function.form"},
              {replaced(good, "\"gradient\"", "\"slope\""), "terms[0].factors[0].kind"},
              {model_file_with_reversed_range(data::small_svr_model()), "terms[1].max"},
              {replaced(good, "\"b\": 0.125", "\"b\": null"), "function.b"},
              {replaced(good, "\"b\": 0.125,", ""), "function.b"},
              {replaced(good, "\"sigma\": 1.25", "\"sigma\": 0"), "function.parameters.sigma"},
              {replaced(good, "\"beta\": [", "\"beta\": [1,"), "function.beta"},
              {replaced(good, "\"angle_random_walk_deg_per_sqrt_h\": 0.05", "\"angle_random_walk_deg_per_sqrt_h\": 0"),
               "residual_noise.angle_random_walk_deg_per_sqrt_h"},
              {replaced(good, "\"support_vectors\": [", "\"support_vectors\": [[1],"), "function.support_vectors[0]"}};
  for (const auto& law : laws) {
    const auto model = model_from_json(law.json, "m.json");
    ASSERT_FALSE(model) << law.where;
    EXPECT_EQ(model.error().kind, FaultKind::bad_file);
    EXPECT_EQ(model.error().where, "m.json: " + law.where);
  }
}

TEST(ModelFile, RefusesNonFiniteNumbers) {
  Model model = data::small_svr_model();
  std::get<methods::SvrModel>(model.function).beta(0) = std::nan("");
  EXPECT_EQ(model_from_json(to_json(model), "m.json").error().where, "m.json: function.beta[0]");
  EXPECT_FALSE(model_from_json(replaced(to_json(data::small_svr_model()), "0.125", "1e999"), "m.json"));
}

/// The squares or the quotients of such numbers would overflow.
TEST(ModelFile, RefusesExtremeNumbers) {
  const std::string svr = to_json(data::small_svr_model()), expansion = to_json(two_function_model());
  const struct {
    std::string json, where;
  } laws[] = {{replaced(svr, "\"b\": 0.125", "\"b\": 1e308"), "function.b"},
              {replaced(to_json(two_term_model()), "\"b\": 0.25", "\"b\": -1e31"), "function.b"},
              {replaced(svr, "\"std\": 0.3333333333333333", "\"std\": 1e-320"), "terms[0].std"},
              {replaced(svr, "\"max\": 1.0", "\"max\": 1e200"), "terms[0].max"},
              {replaced(svr, "\"std_deg_per_h\": 0.7", "\"std_deg_per_h\": 1e200"), "target.std_deg_per_h"},
              {replaced(svr, "\"sigma\": 1.25", "\"sigma\": 1e-200"), "function.parameters.sigma"},
              {replaced(svr, "\"beta\": [", "\"beta\": [1e300,"), "function.beta[0]"},
              {replaced(expansion, "\"widths\": [", "\"widths\": [1e-200,"), "function.widths"},
              {replaced(svr, "\"start_deg_per_h\": 0.25", "\"start_deg_per_h\": 1e200"), "residual_noise"},
              {replaced(replaced(svr, "\"combined\"", "\"left_out\""), "\"standard_uncertainty\": 0.05",
                        "\"standard_uncertainty\": 1e200"),
               "uncertainty"}};
  for (const auto& law : laws) {
    const auto model = model_from_json(law.json, "m.json");
    ASSERT_FALSE(model) << law.where;
    EXPECT_EQ(model.error().kind, FaultKind::bad_file);
    EXPECT_EQ(model.error().where, "m.json: " + law.where);
  }
}

TEST(ModelFile, ReportsFaultForTruncatedOrCorruptFile) {
  const std::string good = to_json(data::small_svr_model());
  for (std::size_t length = 0; length + 2 < good.size(); length += 7) {
    EXPECT_FALSE(model_from_json(std::string_view(good).substr(0, length), "m.json"));
  }
  for (std::size_t at = 0; at < good.size(); at += 5) {
    std::string spoilt = good;
    spoilt[at] = "0\"]}{,-e"[at % 8];
    const auto model = model_from_json(spoilt, "m.json");
    EXPECT_TRUE(!model || model_from_json(to_json(*model), "m.json")) << at;
  }
  for (const char* json : {"null", "[]", "{}", "1", "\"\"", "[[[[[[", "\xff\xfe"})
    EXPECT_FALSE(model_from_json(json, "m.json"));
}

/// Returns four rows of inputs. The second and third are outside the range of the small model, which is A − B in [−1,
/// 1] and dA/dt in [−5, 5].
data::SampleMatrix two_outside() { return (data::SampleMatrix(4, 2) << 0.5, 1, 1.5, 1, 0, -7.5, -1, 5).finished(); }

/// Predicts the bias with a policy for inputs outside the range.
Eigen::VectorXd predicted_under(Outside policy, const Model& model, const data::SampleMatrix& inputs) {
  return predict(model, apply_range_policy(model, inputs, policy));
}

/// The training means are 0.1 and 0. Row 1 keeps 0.9/1.4 of its distance from the mean. Row 2 keeps 2/3, so its A − B
/// is 0.1 − 2/30.
TEST(TrainedRange, MovesBoundedPointTowardsTrainingMean) {
  const Model model = data::small_svr_model();
  const RangedInputs ranged = apply_range_policy(model, two_outside(), Outside::continued);
  EXPECT_EQ(ranged.inputs, two_outside());
  EXPECT_TRUE(ranged.bounded.isApprox((data::SampleMatrix(4, 2) << 0.5, 1, 1, 0.9 / 1.4, 0.1 / 3, -5, -1, 5).finished(),
                                      1e-15));
  EXPECT_EQ(ranged.rows, (std::vector<Eigen::Index>{1, 2}));
  EXPECT_TRUE(ranged.excess.isApprox(Eigen::Vector4d(0, 0.25, 0.25, 0)));
}

/// Returns a model with slopes of +0.01 and −0.01 °/h per K. Its bias depends only on the difference of the
/// thermometers.
Model opposed_slopes() {
  Model model = data::small_svr_model();
  model.terms = {data::temperature_term("A"), data::temperature_term("B")};
  model.scaling = {Eigen::RowVector2d{20, 20}, Eigen::RowVector2d{1, 1}};
  model.target_mean_deg_per_h = 0;
  model.target_std_deg_per_h = 1;
  model.input_min = Eigen::RowVector2d{-17, -18};
  model.input_max = Eigen::RowVector2d{58, 54};
  model.function = methods::LinearModel{.weights = Eigen::Vector2d{0.01, -0.01}, .b = 0};
  return model;
}

TEST(TrainedRange, KeepsDifferenceOfThermometersOutsideTogether) {
  const data::SampleMatrix hot = (data::SampleMatrix(2, 2) << 50, 49, 69, 68).finished();
  for (const Outside policy : {Outside::continued, Outside::extrapolate}) {
    const Eigen::VectorXd predicted = predicted_under(policy, opposed_slopes(), hot);
    EXPECT_NEAR(predicted(0), 0.01, 1e-15);
    EXPECT_NEAR(predicted(1), 0.01, 1e-15);
  }
  Model beside = opposed_slopes();  // a plane and a wide Gaussian
  beside.function = methods::ExpansionModel{.centres = data::SampleMatrix::Zero(1, 2),
                                            .lengths = Eigen::RowVector2d{100, 100},
                                            .widths = Eigen::VectorXd::Ones(1),
                                            .weights = Eigen::VectorXd::Ones(1),
                                            .slope = Eigen::Vector2d{0.01, -0.01}};
  // The point keeps 34/48 of its distance from (20, 20), because B reaches its limit of 54 first.
  const double a = 49.0 * 34 / 48, b = 34;
  EXPECT_NEAR(predicted_under(Outside::continued, beside, hot)(1), 0.01 + std::exp(-(a * a + b * b) / 2e4), 1e-15);
}

TEST(TrainedRange, RecomputesProductsFromBoundedFactors) {
  Model model = opposed_slopes();
  const data::Term a = data::temperature_term("A"), b = data::temperature_term("B");
  model.terms = {a, b, a * b, a * data::rate_term("A")};
  EXPECT_EQ(recomputed_products(model.terms).size(), 1u) << "the rate of A is not an input itself";
  model.scaling = {Eigen::RowVector4d{20, 20, 410, 0}, Eigen::RowVector4d::Ones()};
  model.input_min = Eigen::RowVector4d{-20, -20, 0, -100};
  model.input_max = Eigen::RowVector4d{60, 60, 3600, 100};
  model.function = methods::NetworkModel{};
  const data::SampleMatrix row = (data::SampleMatrix(1, 4) << 100, 60, 6000, 8).finished();
  const data::SampleMatrix bounded = apply_range_policy(model, row, Outside::continued).bounded;
  EXPECT_EQ(bounded, (data::SampleMatrix(1, 4) << 60, 40, 2400, 4).finished()) << "moved half of the way to the mean";
}

TEST(TrainedRange, ReportsFarthestTermRelativeToRange) {
  const RangedInputs ranged = apply_range_policy(data::small_svr_model(), two_outside(), Outside::extrapolate);
  EXPECT_EQ(ranged.worst_term, 0) << "0.5 of 2 equals 2.5 of 10; the first term is reported";
  EXPECT_DOUBLE_EQ(ranged.worst_excess, 0.25);
  EXPECT_EQ(ranged.inputs, two_outside());
}

TEST(TrainedRange, RefusesWholeRows) {
  const Model model = data::small_svr_model();
  const Eigen::VectorXd predicted = predicted_under(Outside::refuse, model, two_outside());
  EXPECT_TRUE(std::isfinite(predicted(0)));
  EXPECT_TRUE(std::isnan(predicted(1)));
  EXPECT_TRUE(std::isnan(predicted(2)));
  EXPECT_TRUE(std::isfinite(predicted(3)));
}

TEST(TrainedRange, AppliesEqualPoliciesInside) {
  const Model model = data::small_svr_model();
  const data::SampleMatrix inside = (data::SampleMatrix(2, 2) << -1, 5, 0.25, -0.5).finished();
  for (const Outside policy : {Outside::continued, Outside::refuse, Outside::extrapolate}) {
    EXPECT_EQ(predicted_under(policy, model, inside), predict(model, inside)) << name(policy);
    EXPECT_EQ(apply_range_policy(model, inside, policy).worst_term, -1);
  }
}

TEST(TrainedRange, ContinuesWithoutStepAndStaysBounded) {
  const Model model = data::small_svr_model();
  const data::SampleMatrix edge = (data::SampleMatrix(1, 2) << 1, 2).finished();
  const double last = predict(model, edge)(0);
  for (const double beyond : {1e-12, 1e-9, 1e-6}) {
    const data::SampleMatrix outside = (data::SampleMatrix(1, 2) << 1 + beyond, 2).finished();
    EXPECT_NEAR(predicted_under(Outside::continued, model, outside)(0), last, 10 * beyond) << beyond;
  }
  const data::SampleMatrix far = (data::SampleMatrix(1, 2) << 0.1 + 0.9e6, 0).finished();
  const data::SampleMatrix end = (data::SampleMatrix(1, 2) << 1, 0).finished();
  EXPECT_NEAR(predicted_under(Outside::continued, model, far)(0), predict(model, end)(0), 1e-12);
}

TEST(TrainedRange, ToleratesRoundingOfMeans) {
  const data::SampleMatrix edge = (data::SampleMatrix(1, 2) << 1 + 1e-14, -5 - 1e-12).finished();
  EXPECT_TRUE(apply_range_policy(data::small_svr_model(), edge, Outside::refuse).rows.empty());
}

TEST(TrainedRange, DoesNotCountMissingInputAsOutside) {
  const data::SampleMatrix missing = (data::SampleMatrix(1, 2) << std::nan(""), 100).finished();
  const RangedInputs ranged = apply_range_policy(data::small_svr_model(), missing, Outside::continued);
  EXPECT_TRUE(ranged.rows.empty());
  EXPECT_TRUE(std::isnan(predicted_under(Outside::continued, data::small_svr_model(), missing)(0)));
}

TEST(TrainedRange, ParsesPolicyNames) {
  for (const Outside policy : {Outside::continued, Outside::refuse, Outside::extrapolate}) {
    EXPECT_EQ(*parse_outside(name(policy)), policy);
  }
  const auto wrong = parse_outside("ignore");
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().kind, FaultKind::usage);
}

}  // namespace

}  // namespace gyrotherm::model
