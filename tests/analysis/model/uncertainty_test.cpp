// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/uncertainty.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <random>

#include "analysis/model/training.hpp"
#include "tests/analysis/random_samples.hpp"
#include "tests/analysis/small_model.hpp"
#include "tests/analysis/synthetic_run.hpp"

namespace gyrotherm::model {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

BudgetRow row_of(double u, double sensitivity, double degrees_of_freedom = kInfinite) {
  return {.standard_uncertainty = u, .sensitivity = sensitivity, .degrees_of_freedom = degrees_of_freedom};
}

TEST(Budget, EqualsManualSum) {
  const CombinedUncertainty sum = combined({row_of(3, 1), row_of(2, -2), row_of(0.5, 24), row_of(7, 0)});
  EXPECT_DOUBLE_EQ(sum.standard_deg_per_h, 13) << "√(3² + 4² + 12²)";
  EXPECT_EQ(sum.degrees_of_freedom, kInfinite);
  EXPECT_NEAR(sum.coverage_factor, 1.95996, 1e-5);
  EXPECT_NEAR(sum.expanded_deg_per_h, 13 * 1.95996, 1e-4);
}

TEST(Budget, IsZeroWithoutRows) {
  EXPECT_EQ(combined({}).expanded_deg_per_h, 0);
  EXPECT_EQ(combined({row_of(1, 0, 3)}).standard_deg_per_h, 0);
  EXPECT_EQ(combined({row_of(1, 0, 3)}).degrees_of_freedom, kInfinite);
}

TEST(Budget, ReproducesEndGaugeExampleOfGum) {
  // GUM H.1, in nm: calibration of the standard, measured difference, and differences of expansion coefficient and of
  // temperature.
  const std::vector<BudgetRow> rows{row_of(25, 1, 18), row_of(9.7, 1, 25.6), row_of(2.9, 1, 50), row_of(16.6, 1, 2)};
  const CombinedUncertainty sum = combined(rows, 0.99);
  EXPECT_NEAR(sum.standard_deg_per_h, 32, 0.5);
  EXPECT_NEAR(sum.degrees_of_freedom, 16.7, 0.5) << "the GUM truncates to 16";
  EXPECT_EQ(std::floor(sum.degrees_of_freedom), 16);
  EXPECT_NEAR(sum.coverage_factor, 2.92, 0.005);
  EXPECT_NEAR(sum.expanded_deg_per_h, 93, 1);
}

TEST(Budget, TruncatesDegreesOfFreedomToWholeNumber) {
  EXPECT_EQ(whole_degrees(16.7), 16);
  EXPECT_EQ(whole_degrees(98.99999999999999), 99) << "a rounding error";
  EXPECT_EQ(whole_degrees(98.9999), 98);
  EXPECT_EQ(whole_degrees(0.3), 1);
  EXPECT_EQ(whole_degrees(kInfinite), kInfinite);
  EXPECT_TRUE(std::isnan(whole_degrees(std::numeric_limits<double>::quiet_NaN())));
}

TEST(Budget, KeepsDegreesOfFreedomOfSingleSource) {
  EXPECT_DOUBLE_EQ(combined({row_of(0.3, 2, 7)}).degrees_of_freedom, 7);
  EXPECT_NEAR(combined({row_of(0.3, 2, 7)}).coverage_factor, 2.365, 0.0005);
  EXPECT_NEAR(combined({row_of(1e-100, 1, 7)}).degrees_of_freedom, 7, 1e-9) << "also for tiny contributions";
}

TEST(Budget, WidensLinearlyOutsideTrainedRange) {
  EXPECT_EQ(extrapolation_factor(0), 0);
  EXPECT_DOUBLE_EQ(extrapolation_factor(0.5), 9) << "3(2² − 1)";
  const Uncertainty known{.budget = {.averaging_s = 3600,
                                     .rows = {{.source = Source::model_form, .standard_uncertainty = 0.003},
                                              {.source = Source::turn_on, .standard_uncertainty = 0.004}}},
                          .sensitivities = {}};
  EXPECT_NEAR(expanded_outside(known, 3600, 0), 1.959964 * 0.005, 1e-8);
  EXPECT_NEAR(expanded_outside(known, 3600, 0.5), 1.959964 * std::sqrt(25e-6 + 9 * 9e-6), 1e-8);
}

TEST(Budget, ReducesWhiteNoiseForLongerMean) {
  const Budget hour{.averaging_s = 3600,
                    .rows = {{.source = Source::angle_random_walk, .standard_uncertainty = 2},
                             {.source = Source::rate_random_walk, .standard_uncertainty = 3},
                             {.source = Source::tilt, .standard_uncertainty = 4},
                             {.source = Source::counting, .standard_uncertainty = 8}}};
  const Budget four = convert_averaging(hour, 4 * 3600);
  EXPECT_DOUBLE_EQ(four.rows[0].standard_uncertainty, 1);
  EXPECT_DOUBLE_EQ(four.rows[1].standard_uncertainty, 6);
  EXPECT_DOUBLE_EQ(four.rows[2].standard_uncertainty, 4);
  EXPECT_DOUBLE_EQ(four.rows[3].standard_uncertainty, 2) << "only the two end points count";
  EXPECT_EQ(differing_rows(four.rows).size(), 3u) << "the tilt is equal in training and in use";
}

TEST(EarthRate, HasDerivativesEqualToDifferences) {
  const auto rate = [](double phi, double az, double el) {
    const auto radians = [](double degrees) { return degrees * std::numbers::pi / 180; };
    return kEarthRateDegPerHour * (std::cos(radians(phi)) * std::cos(radians(az)) * std::cos(radians(el)) +
                                   std::sin(radians(phi)) * std::sin(radians(el)));
  };
  for (const auto& [phi, az, el] : {std::array{45.0, 0.0, 90.0}, {-33.0, 120.0, 10.0}, {60.0, -45.0, -30.0}}) {
    const EarthRateSlopes slopes = earth_rate_slopes(phi, az, el);
    constexpr double h = 1e-3;
    EXPECT_NEAR(slopes.latitude, (rate(phi + h, az, el) - rate(phi - h, az, el)) / (2 * h), 1e-9);
    EXPECT_NEAR(slopes.azimuth, (rate(phi, az + h, el) - rate(phi, az - h, el)) / (2 * h), 1e-9);
    EXPECT_NEAR(slopes.elevation, (rate(phi, az, el + h) - rate(phi, az, el - h)) / (2 * h), 1e-9);
  }
  EXPECT_NEAR(0.05 * earth_rate_slopes(45, 0, 90).latitude, 0.0093, 5e-5) << "0.05° at 45°";
}

TEST(EarthRate, HasBudgetOnlyIfSubtracted) {
  data::Dataset dataset;
  dataset.gyro_uncertainty = {.latitude_deg = 45, .azimuth_deg = 0, .elevation_deg = 90};
  const auto angles = budget_of_angles(dataset).size();
  EXPECT_EQ(angles, 3u) << "latitude, azimuth and tilt";
  EXPECT_TRUE(budget_of_earth_rate(dataset).empty()) << "the Earth rate is unknown";
  dataset.bias_zero = data::kOwnReference;
  dataset.has_own_reference = true;
  EXPECT_TRUE(budget_of_earth_rate(dataset).empty());
  dataset = {.bias_zero = std::string(data::kNothingRemoved), .gyro_uncertainty = dataset.gyro_uncertainty};
  dataset.imported = true;
  dataset.earth_rate_deg_per_h = 0;
  EXPECT_TRUE(budget_of_earth_rate(dataset).empty()) << "an import with an Earth rate of 0";
  dataset.bias_zero = "earth rate removed";
  dataset.imported = false;
  dataset.earth_rate_deg_per_h = 10.6;
  EXPECT_EQ(budget_of_earth_rate(dataset).size(), angles + 1);
  dataset.gyro_uncertainty = {};
  const auto only_scale_factor = budget_of_earth_rate(dataset);
  ASSERT_EQ(only_scale_factor.size(), 1u);
  EXPECT_EQ(only_scale_factor.front().source, Source::scale_factor);
}

/// Returns the model with a trained range that contains every record.
Model model_with_any_range(Model model) {
  model.input_min.setConstant(-1e6);
  model.input_max.setConstant(1e6);
  return model;
}

class ModelUncertainty : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    dataset_ = data::make_synthetic_run({});
    dataset_.earth_rate_deg_per_h = 10.6;
    dataset_.gyro_uncertainty = {.latitude_deg = 45,
                                 .azimuth_deg = 0,
                                 .elevation_deg = 90,
                                 .latitude_uncertainty_deg = 0.001,
                                 .turn_on_repeatability_deg_per_h = 0.002};
    clusters_ = *make_clusters(dataset_);
    model_ = trained("linear", "seven-point");
  }
  static Model trained(const char* method, const char* inputs) {
    TrainingOptions options;
    options.inputs = inputs;
    options.method = method;
    options.quick = true;
    return *train({dataset_}, {clusters_}, options);
  }
  static const BudgetRow& row(const Model& model, Source source) {
    return *std::ranges::find(model.uncertainty->budget.rows, source, &BudgetRow::source);
  }
  static inline data::Dataset dataset_;
  static inline data::Clusters clusters_;
  static inline Model model_;
};

TEST_F(ModelUncertainty, HasWeightsAsLinearSensitivity) {
  const auto& weights = std::get<methods::LinearModel>(model_.function).weights;
  const Eigen::VectorXd slope =
      // Slopes of A − T_j.
      model_.target_std_deg_per_h * weights.array() / model_.scaling.std.transpose().array();
  const Eigen::MatrixXd found = *sensitivities(model_, clusters_);
  const double tolerance = 1e-8 * slope.cwiseAbs().maxCoeff();
  for (Eigen::Index k = 0; k < found.rows(); ++k) {
    ASSERT_NEAR(found(k, 0), slope.sum(), tolerance);
    for (Eigen::Index j = 1; j < 8; ++j) ASSERT_NEAR(found(k, j), -slope(j - 1), tolerance);
  }
  const std::vector<Sensitivity>& all = model_.uncertainty->sensitivities;
  ASSERT_EQ(all.size(), 8u);
  EXPECT_EQ(all[0].thermometer, "A");
  EXPECT_NEAR(all[0].mean, slope.sum(), tolerance);
  EXPECT_NEAR(all[3].rms, std::abs(slope(2)), tolerance);
  EXPECT_NEAR(all[3].greatest, std::abs(slope(2)), tolerance);
}

TEST_F(ModelUncertainty, HasDerivativeAsGaussianSensitivity) {
  const Model model = data::small_svr_model();
  const data::Clusters clusters = data::three_clusters();
  const auto& svr = std::get<methods::SvrModel>(model.function);
  const data::SampleMatrix inputs = *evaluate(model.terms, clusters);
  const Eigen::MatrixXd found = *sensitivities(model_with_any_range(model), clusters);
  for (Eigen::Index k = 0; k < found.rows(); ++k) {
    const Eigen::RowVectorXd z = (inputs.row(k) - model.scaling.mean).array() / model.scaling.std.array();
    double by_gradient = 0;  // ∂b/∂(A − B)
    for (Eigen::Index i = 0; i < svr.beta.size(); ++i) {
      const Eigen::RowVectorXd apart = z - svr.support_vectors.row(i);
      const double narrow = 1 / (svr.parameters.sigma * svr.parameters.sigma);
      by_gradient -= svr.beta(i) * std::exp(-0.5 * narrow * apart.squaredNorm()) * narrow * apart(0);
    }
    by_gradient *= model.target_std_deg_per_h / model.scaling.std(0);
    EXPECT_NEAR(found(k, 0), by_gradient, 1e-5 * std::abs(by_gradient));
    EXPECT_NEAR(found(k, 1), -by_gradient, 1e-5 * std::abs(by_gradient));
  }
}

TEST_F(ModelUncertainty, HasChangeOfPredictionAsSensitivity) {
  for (const char* method : {"ls-svm", "gp"}) {
    if (!methods::find_method(method)) continue;
    const Model model = model_with_any_range(trained(method, "three-point"));
    const Eigen::MatrixXd found = *sensitivities(model, clusters_);
    data::Clusters moved = clusters_;
    constexpr double kMove_k = 0.01;
    moved.temperature_c.col(3).array() += kMove_k;
    const Eigen::VectorXd change = *predict(model, moved) - *predict(model, clusters_);
    EXPECT_LT((change - kMove_k * found.col(3)).norm(), 0.05 * change.norm()) << method;
    EXPECT_TRUE(found.col(1).isZero(0)) << "B is not an input";
  }
}

TEST_F(ModelUncertainty, KeepsSensitivityOfPlaneOutsideRange) {
  data::Clusters far = clusters_;
  far.temperature_c.col(0).array() += 100;
  EXPECT_TRUE(sensitivities(model_, far)->isApprox(*sensitivities(model_, clusters_), 1e-6));
}

TEST_F(ModelUncertainty, EstimatesThermometerNoiseFromSamples) {
  const Eigen::RowVectorXd noise = thermometer_noise_k(dataset_, clusters_);
  for (Eigen::Index j = 0; j < 8; ++j) EXPECT_NEAR(noise(j), 0.003 / 10, 0.03 * 0.003 / 10) << "mean of 100 samples";
  double squares = 0;
  for (const Sensitivity& one : model_.uncertainty->sensitivities) squares += std::pow(one.rms * 0.003 / 10, 2);
  EXPECT_NEAR(model_.uncertainty->added_noise_deg_per_h, std::sqrt(squares), 0.03 * std::sqrt(squares));
}

TEST_F(ModelUncertainty, IgnoresGapsInNoiseEstimate) {
  data::Dataset with_gap = dataset_;
  const Eigen::Index after = with_gap.time_s.size() / 2;
  with_gap.time_s.tail(after).array() += 3600;
  with_gap.temperature_c.bottomRows(after).array() += 15;
  const Eigen::RowVectorXd noise = thermometer_noise_k(with_gap, clusters_);
  EXPECT_TRUE(noise.isApprox(thermometer_noise_k(dataset_, clusters_), 1e-3)) << noise;
}

TEST_F(ModelUncertainty, HasHalfDifferenceOfDirectionsAsHysteresis) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise(0, 0.002);
  Eigen::VectorXd residual(clusters_.start_s.size()), chance(clusters_.start_s.size());
  for (Eigen::Index k = 0; k < residual.size(); ++k) {
    chance(k) = noise(random);
    residual(k) = chance(k) + std::copysign(0.003, clusters_.rate_c_per_min.row(k).mean());
  }
  EXPECT_NEAR(estimate_hysteresis(residual, clusters_).half_deg_per_h, 0.003, 0.0004);
  EXPECT_LT(estimate_hysteresis(chance, clusters_).half_deg_per_h, 0.0006) << "noise causes hardly any hysteresis";
  EXPECT_EQ(estimate_hysteresis(Eigen::VectorXd::Zero(residual.size()), clusters_).half_deg_per_h, 0);
  EXPECT_GT(estimate_hysteresis(residual, clusters_).degrees_of_freedom,
            5 * estimate_hysteresis(chance, clusters_).degrees_of_freedom);
}

TEST_F(ModelUncertainty, IgnoresValuesMeasuredByGyroInHysteresis) {
  Eigen::VectorXd residual(clusters_.start_s.size());
  for (Eigen::Index k = 0; k < residual.size(); ++k)
    residual(k) = std::copysign(0.003, clusters_.rate_c_per_min.row(k).mean());
  data::Clusters own = clusters_;
  const Eigen::Index rows = own.temperature_c.rows(), columns = own.temperature_c.cols();
  own.thermometers.insert(own.thermometers.end(), {"self", "aux:current"});
  own.temperature_c.conservativeResize(Eigen::NoChange, columns + 2);
  own.rate_c_per_min.conservativeResize(Eigen::NoChange, columns + 2);
  own.temperature_c.col(columns) = own.temperature_c.col(0);
  own.rate_c_per_min.col(columns) = own.rate_c_per_min.col(0);
  own.temperature_c.col(columns + 1).setLinSpaced(rows, 0, 1e6);  // always rising
  own.rate_c_per_min.col(columns + 1).setConstant(1e4);
  const double expected = estimate_hysteresis(residual, clusters_).half_deg_per_h;
  EXPECT_NEAR(expected, 0.003, 0.0004);
  EXPECT_EQ(estimate_hysteresis(residual, own).half_deg_per_h, expected);
  own.rate_c_per_min.rightCols(2).setConstant(std::nan(""));
  EXPECT_EQ(estimate_hysteresis(residual, own).half_deg_per_h, expected) << "missing";
  data::Clusters alone = clusters_;
  alone.thermometers = {"self"};
  alone.temperature_c = clusters_.temperature_c.col(0);
  alone.rate_c_per_min = clusters_.rate_c_per_min.col(0);
  EXPECT_NEAR(estimate_hysteresis(residual, alone).half_deg_per_h, 0.003, 0.0004)
      << "the only temperature of the record";
  alone.thermometers = {"aux:current"};
  EXPECT_EQ(estimate_hysteresis(residual, alone).half_deg_per_h, 0);
}

TEST_F(ModelUncertainty, MarksAssumedValues) {
  EXPECT_FALSE(row(model_, Source::latitude).assumed);
  EXPECT_EQ(row(model_, Source::latitude).standard_uncertainty, 0.001);
  EXPECT_TRUE(row(model_, Source::tilt).assumed);
  EXPECT_TRUE(row(model_, Source::thermometer_drift).assumed);
  EXPECT_EQ(row(model_, Source::thermometer_drift).standard_uncertainty, 0.05);
  EXPECT_EQ(row(model_, Source::thermometer_calibration).standard_uncertainty, 0.02);
  EXPECT_DOUBLE_EQ(row(model_, Source::turn_on).sensitivity, std::numbers::sqrt2) << "both in training and in use";
}

TEST_F(ModelUncertainty, IncludesQuantisationOfPulses) {
  EXPECT_TRUE(std::ranges::none_of(model_.uncertainty->budget.rows, [](const BudgetRow& row) {
    return row.source == Source::counting;
  })) << "the gyro reports a rate";
  constexpr double kPulse_arcsec = 1.5;
  std::vector<data::Dataset> datasets{dataset_};
  datasets.front().step_deg_per_h = kPulse_arcsec;
  const std::vector<data::Clusters> clusters{clusters_};
  Model model = model_;
  model.uncertainty = *evaluate_uncertainty(model_, {datasets, clusters, model_.leave_cycle_out_residual});
  const BudgetRow& counting = row(model, Source::counting);
  EXPECT_EQ(counting.distribution, ErrorDistribution::triangular);

  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> half_a_pulse(-kPulse_arcsec / 2, kPulse_arcsec / 2);
  double squares = 0;
  constexpr int kMeans = 20000;
  for (int i = 0; i < kMeans; ++i)
    squares += std::pow((half_a_pulse(random) - half_a_pulse(random)) / kSecondsPerHour, 2);
  EXPECT_NEAR(counting.standard_uncertainty, std::sqrt(squares / kMeans), 0.02 * counting.standard_uncertainty);
  const BudgetRow of_a_cluster = convert_averaging({.averaging_s = 3600, .rows = {counting}}, 100).rows.front();
  EXPECT_NEAR(of_a_cluster.standard_uncertainty, 0.0061, 5e-5) << "°/h: more than all else of a good gyro";
}

/// A slow wave has so few effective values that it is not significant. The model form must be reported all the same.
TEST_F(ModelUncertainty, HasFewDegreesOfFreedomOfModelFormForFewMeans) {
  const std::vector<data::Dataset> datasets{dataset_};
  const std::vector<data::Clusters> clusters{clusters_};
  const Eigen::Index count = clusters_.start_s.size();
  Model model = model_;
  const auto judged_by = [&](const Eigen::VectorXd& residual) {
    model.uncertainty = *evaluate_uncertainty(model_, {datasets, clusters, residual});
    return row(model, Source::model_form);
  };
  const Eigen::VectorXd angle = Eigen::VectorXd::LinSpaced(count, 0, 2 * std::numbers::pi);
  const BudgetRow wave = judged_by(0.05 * angle.array().sin());
  EXPECT_LT(wave.degrees_of_freedom, 8);
  const double form = std::hypot(wave.standard_uncertainty, row(model, Source::hysteresis).standard_uncertainty);
  EXPECT_NEAR(form, 0.05 / std::numbers::sqrt2, 0.001);
  EXPECT_GT(combined(model.uncertainty->budget.rows).expanded_deg_per_h, 2.3 * form)
      << "by Student's t for few degrees of freedom";
  EXPECT_EQ(judged_by(Eigen::VectorXd::Zero(count)).standard_uncertainty, 0) << "zero, like the estimate";
  EXPECT_EQ(judged_by(Eigen::VectorXd::Zero(count)).degrees_of_freedom, 1);
}

TEST(RobustStandard, EqualsRootMeanSquareWithoutTransient) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal(0, 1);
  Eigen::VectorXd residual = Eigen::VectorXd::NullaryExpr(20000, [&] { return normal(random); });
  EXPECT_NEAR(robust_standard_deg_per_h(residual, 20000), 1, 0.02);
  residual.head(200).array() += 20;  // 1 % of the means
  EXPECT_NEAR(std::sqrt(residual.squaredNorm() / 20000), std::sqrt(1 + 4), 0.05);
  EXPECT_NEAR(robust_standard_deg_per_h(residual, 20000), 1.04, 0.03)
      << "percentile 95/99 of the values without the transient";
  const Eigen::VectorXd wave = Eigen::VectorXd::LinSpaced(1000, 0, 20 * std::numbers::pi).array().sin();
  EXPECT_NEAR(robust_standard_deg_per_h(wave, 500), std::sqrt(0.5), 1e-3) << "a sine has no outliers";
  EXPECT_EQ(robust_standard_deg_per_h(Eigen::Vector4d(0, 0, 0, 10), 4), 5) << "four means are too few for a percentile";
}

TEST_F(ModelUncertainty, MarksRowsChosenOnTheseFolds) {
  const std::vector<data::Dataset> datasets{dataset_};
  const std::vector<data::Clusters> clusters{clusters_};
  Model model = model_;
  using Remarks = std::vector<std::string>;
  EXPECT_EQ(remarks(row(model, Source::model_form)), Remarks{"only power-on held out"})
      << "no parameter was chosen on these folds";
  model.uncertainty = *evaluate_uncertainty(model_, {datasets, clusters, model_.leave_cycle_out_residual, true});
  EXPECT_EQ(remarks(row(model, Source::model_form)), (Remarks{"chosen on these folds", "only power-on held out"}));
  const auto back = model_from_json(to_json(model), "model.json");
  ASSERT_TRUE(back) << text(back.error());
  EXPECT_TRUE(row(*back, Source::model_form).chosen_on_these_folds);
  EXPECT_FALSE(row(*back, Source::turn_on).chosen_on_these_folds);
}

TEST_F(ModelUncertainty, MarksSinglePowerOn) {
  data::Dataset dataset = dataset_;
  ASSERT_GE(dataset.segments.size(), 3u);
  dataset.segments[1].unit.off = true;
  const std::vector<data::Dataset> datasets{dataset};
  const std::vector<data::Clusters> clusters{*make_clusters(dataset)};
  ASSERT_EQ(clusters.front().start_s.size(), clusters_.start_s.size());
  Model model = model_;
  model.uncertainty = *evaluate_uncertainty(model_, {datasets, clusters, model_.leave_cycle_out_residual});
  EXPECT_TRUE(remarks(row(model, Source::model_form)).empty());
  EXPECT_DOUBLE_EQ(row(model, Source::turn_on).sensitivity, std::sqrt(1.5)) << "two power-ons";
}

TEST_F(ModelUncertainty, IncreasesDriftWithRootOfTimeSinceCalibration) {
  data::Dataset dated = dataset_;
  dated.started_utc = std::chrono::sys_days(std::chrono::year(2026) / 4 / 2).time_since_epoch() + std::chrono::hours(6);
  dated.thermometer_uncertainty.assign(8, {.calibration = Kelvins{0.01},
                                           .rectangular = true,
                                           .drift_in_a_year = Kelvins{0.08},
                                           .calibrated = std::chrono::year(2026) / 1 / 1});
  const Eigen::VectorXd none = model_.leave_cycle_out_residual;
  const std::vector<data::Dataset> datasets{dated};
  const std::vector<data::Clusters> clusters{clusters_};
  Model model = model_;
  model.uncertainty = *evaluate_uncertainty(model_, {datasets, clusters, none});
  const BudgetRow& drift = row(model, Source::thermometer_drift);
  EXPECT_FALSE(drift.assumed);
  EXPECT_NEAR(drift.standard_uncertainty, 0.04, 1e-4) << "91.25 days are a quarter of a year";
  EXPECT_EQ(row(model, Source::thermometer_calibration).distribution, ErrorDistribution::rectangular);
  EXPECT_EQ(row(model, Source::thermometer_calibration).standard_uncertainty, 0.01);
}

/// The drift of a discharge current is 0.0041 mA. Its unit is not the kelvin.
TEST_F(ModelUncertainty, StatesDriftOfUnitValueInItsUnit) {
  data::Dataset dataset = dataset_;
  dataset.thermometers = {"A", "aux:current"};
  dataset.input_units = {"°C", "mA"};
  dataset.thermometer_uncertainty = {{}, {.calibration = Kelvins{}, .drift_in_a_year = Kelvins{0.0041}}};
  const auto rows = budget_of_thermometer(dataset, {.thermometer = "aux:current", .rms = 2});
  ASSERT_EQ(rows.size(), 1u) << "the sensor belongs to the unit, so its error does not change";
  EXPECT_EQ(rows[0].source, Source::input_drift);
  EXPECT_EQ(row_unit(rows[0]), "mA");
  EXPECT_DOUBLE_EQ(contribution_deg_per_h(rows[0]), 0.0082);
  const auto of_a = budget_of_thermometer(dataset, {.thermometer = "A", .rms = 2});
  ASSERT_EQ(of_a.size(), 2u);
  EXPECT_EQ(row_unit(of_a[1]), "K");
  Model model = model_;
  model.uncertainty->budget.rows = rows;
  const auto back = model_from_json(to_json(model), "model.json");
  ASSERT_TRUE(back) << text(back.error());
  EXPECT_EQ(row_unit(row(*back, Source::input_drift)), "mA");
  EXPECT_NEAR(rows_for_run(dataset, rows)[0].standard_uncertainty, 0.0041, 1e-12) << "neither calibration day is known";
}

TEST_F(ModelUncertainty, IncludesDriftUntilUnseenRun) {
  const auto rows_in = [&](const data::Dataset& run) {
    Model model = model_;
    model.uncertainty->budget.rows = rows_for_run(run, model.uncertainty->budget.rows);
    return model;
  };
  EXPECT_EQ(row(rows_in(dataset_), Source::thermometer_drift).standard_uncertainty, 0.05) << "limited to one year";
  data::Dataset dated = dataset_;
  dated.started_utc = std::chrono::days(4 * 365 + 1);
  dated.thermometer_uncertainty.assign(8, {.drift_in_a_year = Kelvins{0.02}, .calibrated = std::chrono::sys_days{}});
  Model said = rows_in(dated);
  EXPECT_NEAR(row(said, Source::thermometer_drift).standard_uncertainty, std::hypot(0.05, 0.04), 1e-12);
  EXPECT_TRUE(row(said, Source::thermometer_drift).assumed) << "the training record states no drift";
  for (BudgetRow& one : said.uncertainty->budget.rows) one.assumed = false;
  said.uncertainty->budget.rows = rows_for_run(dataset_, said.uncertainty->budget.rows);
  EXPECT_TRUE(row(said, Source::thermometer_drift).assumed) << "this run states no drift either";
  EXPECT_FALSE(row(said, Source::turn_on).assumed) << "the turn-on does not depend on drift";
}

TEST_F(ModelUncertainty, AddsDriftOfTwoRunsPerThermometer) {
  const auto at_years = [&](double years) {
    data::Dataset run = dataset_;
    run.started_utc = std::chrono::seconds(static_cast<long>(years * 365.25 * 86400));
    run.thermometer_uncertainty.assign(8, {.drift_in_a_year = Kelvins{0.02}, .calibrated = std::chrono::sys_days{}});
    return run;
  };
  const auto all = [](double each) {
    return testing::ElementsAreArray(std::vector(8, testing::DoubleNear(each, 1e-9)));
  };
  EXPECT_THAT(drifts_between_k(dataset_, dataset_), all(0.05))
      << "without stated days, one year between the runs is assumed";
  EXPECT_THAT(drifts_between_k(at_years(0), at_years(0)), all(0)) << "both runs are on the day of the calibration";
  EXPECT_THAT(drifts_between_k(at_years(0), at_years(4)), all(0.04));
  EXPECT_THAT(drifts_between_k(at_years(1), at_years(4)), all(std::hypot(0.02, 0.04)));
  EXPECT_THAT(drifts_between_k(dataset_, at_years(4)), all(std::hypot(0.05, 0.04)))
      << "the first run was one year after its calibration";
}

TEST_F(ModelUncertainty, ComputesEffectOfOneYearOfDrift) {
  double squares = 0;
  for (const Sensitivity& one : model_.uncertainty->sensitivities) squares += std::pow(one.rms, 2);
  EXPECT_NEAR(yearly_drift_deg_per_h(model_, dataset_), 0.05 * std::sqrt(squares), 1e-15) << "no drift is stated";
  data::Dataset said = dataset_;
  said.thermometer_uncertainty.assign(8, {.drift_in_a_year = Kelvins{0.02}});
  EXPECT_NEAR(yearly_drift_deg_per_h(model_, said), 0.02 * std::sqrt(squares), 1e-15);
  Model silent = model_;
  silent.uncertainty.reset();
  EXPECT_EQ(yearly_drift_deg_per_h(silent, dataset_), 0);
}

/// Draws an error from the distribution of a budget row, in the unit of the row.
double draw_error(const BudgetRow& row, std::mt19937_64& random) {
  const double half_width = std::numbers::sqrt3 * row.standard_uncertainty;
  if (row.distribution == ErrorDistribution::rectangular)
    return std::uniform_real_distribution<double>(-half_width, half_width)(random);
  return std::normal_distribution<double>(0, row.standard_uncertainty)(random);
}

/// Returns the clusters of the first hour, in which the temperature is constant.
data::Clusters first_hold(const data::Clusters& clusters) {
  std::vector<Eigen::Index> rows(36);
  std::iota(rows.begin(), rows.end(), 0);
  return pick_clusters(clusters, rows);
}

TEST_F(ModelUncertainty, WidensWithUncertaintyOfCoefficients) {
  const data::Clusters hold = first_hold(clusters_);
  for (const char* method : {"linear", "lsf", "ridge", "ridge-u", "stepwise", "gp"}) {
    SCOPED_TRACE(method);
    TrainingOptions options;
    options.inputs = "temperatures";
    options.method = method;
    options.quick = true;
    const auto model = train({dataset_}, {hold}, options);
    ASSERT_TRUE(model) << model.error().what;
    ASSERT_TRUE(std::isfinite(model->uncertainty->variance_in_training));
    const Eigen::VectorXd error = clusters_.bias_deg_per_h - *predict(*model, clusters_);
    const Eigen::VectorXd half = *interval_half_widths(*model, *model->uncertainty, dataset_, clusters_);
    const auto known = data::finite_rows(Eigen::VectorXd(error + half));
    const auto held = std::ranges::count_if(known, [&](Eigen::Index k) { return std::abs(error(k)) <= half(k); });
    EXPECT_GE(static_cast<double>(held), 0.8 * static_cast<double>(known.size()));
  }
}

TEST_F(ModelUncertainty, AddsOnlyVarianceAboveTrainingMean) {
  Model without = model_;
  without.variance.reset();
  const Eigen::VectorXd half = *interval_half_widths(model_, *model_.uncertainty, dataset_, clusters_);
  const Eigen::VectorXd least = *interval_half_widths(without, *model_.uncertainty, dataset_, clusters_);
  const Eigen::VectorXd open = predict_with_std(model_, *evaluate(model_.terms, clusters_))->std_deg_per_h.cwiseAbs2();
  const double k = combined(model_.uncertainty->budget.rows).coverage_factor;
  int wider = 0;
  for (Eigen::Index row = 0; row < half.size(); ++row) {
    const double beyond = std::max(0.0, open(row) - open.mean());
    EXPECT_GE(half(row), least(row));
    if (beyond > 0) {
      ++wider;
    } else {
      EXPECT_EQ(half(row), least(row));
    }
    EXPECT_NEAR(half(row) * half(row) - least(row) * least(row), k * k * beyond, 0.1 * k * k * beyond + 1e-12);
  }
  EXPECT_GT(wider, 0);
  EXPECT_LT(wider, half.size());
}

TEST_F(ModelUncertainty, HasRowOfExtrapolationOnlyOutsideTrainedRange) {
  Model model = model_;
  model.variance.reset();
  const std::vector<BudgetRow> rows{
      {.source = Source::turn_on, .standard_uncertainty = 0.001},
      {.source = Source::model_form, .standard_uncertainty = 0.002, .degrees_of_freedom = 9}};
  const Uncertainty& trained = *model.uncertainty;
  const auto inside = budget_of_extrapolation(model, trained, rows, clusters_);
  ASSERT_TRUE(inside) << inside.error().what;
  EXPECT_FALSE(*inside) << "the clusters of the training";
  const Eigen::RowVectorXd width = model.input_max - model.input_min;
  model.input_max = model.input_min + 0.5 * width;
  const auto outside = budget_of_extrapolation(model, trained, rows, clusters_);
  ASSERT_TRUE(outside && *outside);
  EXPECT_EQ((*outside)->source, Source::extrapolation);
  EXPECT_EQ((*outside)->evaluation, Evaluation::b);
  EXPECT_FALSE(std::isfinite((*outside)->degrees_of_freedom));
  const auto inputs = *evaluate(model.terms, clusters_);
  double sum = 0;
  const auto known = data::finite_rows(inputs);
  for (const Eigen::Index row : known) {
    const double excess = ((inputs.row(row) - model.input_max).array() / (0.5 * width.array())).maxCoeff();
    sum += 4e-6 * extrapolation_factor(std::max(0.0, excess));
  }
  EXPECT_NEAR((*outside)->standard_uncertainty, std::sqrt(sum / static_cast<double>(known.size())), 1e-12);
  model.variance = model_.variance;
  ASSERT_TRUE(model.variance);
  const auto with_variance = budget_of_extrapolation(model, trained, rows, clusters_);
  ASSERT_TRUE(with_variance && *with_variance);
  EXPECT_GE((*with_variance)->standard_uncertainty, (*outside)->standard_uncertainty);
}

TEST_F(ModelUncertainty, WidensCoefficientsForCorrelatedResiduals) {
  data::Clusters wandering = clusters_;
  double wander = 0;
  const Eigen::VectorXd steps = data::normal_vector(clusters_.bias_deg_per_h.size(), 5);
  for (Eigen::Index row = 0; row < steps.size(); ++row) {
    wander = 0.9 * wander + 0.003 * steps(row);
    wandering.bias_deg_per_h(row) += wander;
  }
  TrainingOptions options;
  options.inputs = "A";
  options.method = "linear";
  const auto model = train({dataset_}, {wandering}, options);
  ASSERT_TRUE(model) << model.error().what;
  const double count = model->in_sample.count, effective = model->in_sample.effective.of_mean;
  ASSERT_LT(effective, 0.3 * count);
  const double in_training = model->uncertainty->variance_in_training;
  const double by_hand = 2 * count * std::pow(model->in_sample.rmse, 2) / (effective - 2) / count;
  EXPECT_NEAR(in_training, by_hand, 1e-6 * by_hand) << "two coefficients, each with 1/n of the variance";
}

/// White noise of 0.16 °/h in rows of 10 s, no effect of temperature, no hold. U of a mean over τ is 1.96·0.16/√(τ/10
/// s) and a part for the model, which a record of 11 h determines to a few hundredths.
TEST(UncertaintyWithoutHolds, ScalesWithAveragingTime) {
  constexpr int kSeeds = 30;
  double hour = 0, row = 0, walk = 0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    std::mt19937_64 random(static_cast<std::uint64_t>(seed));
    std::normal_distribution<double> noise(0, 0.16);
    constexpr Eigen::Index kRows = 11 * 360;
    data::Dataset dataset;
    dataset.run_id = "imported";
    dataset.imported = true;
    dataset.thermometers = dataset.gradients = {"A"};
    dataset.gyro_uncertainty.turn_on_repeatability_deg_per_h = 0;
    dataset.time_s = dataset.moment_s = Eigen::VectorXd::LinSpaced(kRows, 0, 10.0 * (kRows - 1));
    dataset.temperature_c = 20 + 20 * (dataset.time_s.array() / 3600).sin();
    dataset.bias_deg_per_h = Eigen::VectorXd::NullaryExpr(kRows, [&] { return 3 + noise(random); });
    dataset.set_point_c.setConstant(kRows, std::nan(""));
    dataset.segment.setConstant(kRows, -1);
    dataset.cycle.setConstant(kRows, -1);
    TrainingOptions options;
    options.method = "linear";
    options.inputs = "temperatures";
    const auto model = train({dataset}, {*make_clusters(dataset)}, options);
    ASSERT_TRUE(model) << text(model.error());
    const auto& rows = model->uncertainty->budget.rows;
    const auto white = std::ranges::find(rows, Source::angle_random_walk, &BudgetRow::source);
    ASSERT_NE(white, rows.end());
    EXPECT_EQ(remarks(*white), std::vector<std::string>{"from the residual, no holds"});
    walk += white->standard_uncertainty / kSeeds;
    EXPECT_NEAR(white->degrees_of_freedom, 203, 20) << "½(u/Δu)² of about 390 second differences";
    hour += mean_uncertainty(*model->uncertainty, 3600).expanded_deg_per_h / kSeeds;
    row += mean_uncertainty(*model->uncertainty, 10).expanded_deg_per_h / kSeeds;
  }
  EXPECT_NEAR(walk, 0.16 / std::sqrt(360), 0.04 * 0.16 / std::sqrt(360));
  EXPECT_GT(hour, 1.96 * 0.16 / std::sqrt(360));
  EXPECT_LT(hour, 4 * 1.96 * 0.16 / std::sqrt(360)) << "six times before";
  EXPECT_NEAR(row, 1.96 * 0.16, 0.15 * 1.96 * 0.16);
}

TEST_F(ModelUncertainty, AgreesWithMonteCarlo) {
  const std::vector<BudgetRow>& rows = model_.uncertainty->budget.rows;
  const CombinedUncertainty by_budget = combined(rows);
  const Model model = model_with_any_range(model_);
  data::Clusters hour = pick_clusters(clusters_, {100, 101, 102, 103, 104, 105});
  const Eigen::MatrixXd true_c = hour.temperature_c;
  const double undisturbed = predict(model, hour)->mean();
  std::mt19937_64 random(11);
  constexpr int kDraws = 10000;
  Eigen::VectorXd errors(kDraws);
  for (double& error : errors) {
    hour.temperature_c = true_c;
    error = 0;
    for (const BudgetRow& row : rows) {
      const auto thermometer = std::ranges::find(hour.thermometers, row.of) - hour.thermometers.begin();
      if (row.of.empty())
        error += row.sensitivity * draw_error(row, random);
      else
        hour.temperature_c.col(thermometer).array() += draw_error(row, random);
    }
    error -= predict(model, hour)->mean() - undisturbed;
  }
  EXPECT_NEAR(std::sqrt(errors.squaredNorm() / kDraws), by_budget.standard_deg_per_h,
              0.05 * by_budget.standard_deg_per_h);
  Eigen::VectorXd magnitudes = errors.cwiseAbs();
  std::ranges::sort(magnitudes);
  EXPECT_NEAR(magnitudes(kDraws * 95 / 100), by_budget.expanded_deg_per_h, 0.05 * by_budget.expanded_deg_per_h);
}

TEST_F(ModelUncertainty, IncludesNoiseOfGyro) {
  const BudgetRow& walk = row(model_, Source::angle_random_walk);
  EXPECT_NEAR(walk.standard_uncertainty, 0.02 / std::sqrt(3600), 0.02 / std::sqrt(3600) * 0.05);
  EXPECT_GT(walk.degrees_of_freedom, 100);
}

TEST_F(ModelUncertainty, RoundTripsThroughModelFile) {
  const auto back = model_from_json(to_json(model_), "model.json");
  ASSERT_TRUE(back) << text(back.error());
  ASSERT_TRUE(back->uncertainty);
  EXPECT_EQ(to_json(*back), to_json(model_));
  EXPECT_EQ(combined(back->uncertainty->budget.rows).expanded_deg_per_h,
            combined(model_.uncertainty->budget.rows).expanded_deg_per_h);
  EXPECT_EQ(row(*back, Source::thermometer_drift).degrees_of_freedom, kInfinite);
}

TEST_F(ModelUncertainty, RefusesFileWithInconsistentSum) {
  std::string json = to_json(model_);
  const auto at = json.find("\"U_deg_per_h\": ");
  ASSERT_NE(at, std::string::npos);
  json.insert(at + std::string("\"U_deg_per_h\": ").size(), "1");  // above 1
  const auto back = model_from_json(json, "model.json");
  ASSERT_FALSE(back);
  EXPECT_EQ(back.error().where, "model.json: uncertainty.combined");
  const auto from = json.find("\"combined\": {"), to = json.find('}', from);
  json.erase(from, json.find('"', to) - from);
  const auto without = model_from_json(json, "model.json");
  EXPECT_TRUE(without) << text(without.error());
}

/// The slopes of an axis along or across the axis of rotation of its fixture are 0, and not what doubles leave of it.
TEST(EarthRateSlopes, AreZeroWithoutNumericalResidue) {
  for (const double azimuth : {0.0, 90.0, 180.0, 270.0, 360.0})
    for (const double elevation : {-90.0, 0.0, 90.0}) {
      const EarthRateSlopes slopes = earth_rate_slopes(0, azimuth, elevation);
      const FixtureSlopes of = fixture_slopes({.latitude_deg = 0,
                                               .azimuth_deg = azimuth,
                                               .elevation_deg = elevation,
                                               .fixture_azimuth_deg = 0,
                                               .fixture_elevation_deg = 0});
      for (const double slope :
           {slopes.latitude, slopes.azimuth, slopes.elevation, of.elevation, of.roll, of.direction})
        EXPECT_TRUE(slope == 0 || std::abs(slope) > 1e-3) << azimuth << " " << elevation << " " << slope;
    }
  EXPECT_NE(earth_rate_slopes(50, 90.001, 0).latitude, 0) << "a small angle is not a residue";
}

TEST(TrainedBlock, MergesRangesByThermometer) {
  std::vector<TrainingRecord> records(3);
  records[0].block = BlockRange{-10.4, 40.6, {"A", "B"}, {{"shell", -20.5, 50}}};
  records[2].block = BlockRange{-5, 45.2, {"B", "C"}, {{"shell", -39.1, 40}, {"self", 1, 2}}};
  const auto all = trained_block(records);
  ASSERT_TRUE(all);
  EXPECT_EQ(*all, (BlockRange{-10.4, 45.2, {"A", "B", "C"}, {{"shell", -39.1, 50}, {"self", 1, 2}}}));
  EXPECT_EQ(describe(*all), "block −10 to 45 °C (A, B, C), shell −39 to 50 °C, self 1 to 2 °C");
  EXPECT_EQ(describe(BlockRange{-17.6, 58.4}), "block −17 to 58 °C") << "a model of gyrotherm 0.1.0";
}

}  // namespace
}  // namespace gyrotherm::model
