// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/uncertainty.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include "analysis/data/hold_noise.hpp"
#include "core/quantity.hpp"

namespace gyrotherm::model {
namespace {

constexpr double kStep_k = 1e-3;
constexpr double kInfinite = std::numeric_limits<double>::infinity();

// Values assumed where the record does not state them.
constexpr double kCalibration_k = 0.02, kDriftInAYear_k = 0.05, kYearsSinceCalibration = 1;
constexpr double kTurnOn_deg_per_h = 0.001;
constexpr double kLatitude_deg = 0.01, kAzimuth_deg = 0.1, kTilt_deg = 1.0 / 60;
constexpr double kScaleFactor_ppm = 10;

/// Evaluates the inputs of the model with one thermometer's readings shifted by `by_k`.
Result<data::SampleMatrix> evaluate_shifted(const Model& model, data::Clusters clusters, Eigen::Index thermometer,
                                            double by_k) {
  clusters.temperature_c.col(thermometer).array() += by_k;
  return evaluate(model.terms, clusters);
}

bool uses_thermometer(const Model& model, const std::string& thermometer) {
  return std::ranges::any_of(model.terms, [&](const data::Term& term) {
    return std::ranges::any_of(term.factors, [&](const data::Factor& factor) {
      return factor.kind != data::FactorKind::rate && (factor.first == thermometer || factor.second == thermometer);
    });
  });
}

/// Adds the row of a noise coefficient from the Allan fit, even if it is not significant. Adds no row if the estimate
/// is 0.
void add_noise_row(std::vector<BudgetRow>& rows, const data::AllanFit& fit, data::NoiseTerm term, Source source) {
  const data::NoiseCoefficient coefficient = estimate_from_square(find_coefficient(fit, term));
  if (!(coefficient.value > 0)) return;
  rows.push_back({.source = source,
                  .evaluation = Evaluation::a,
                  .standard_uncertainty = noise_deviation(coefficient, kSecondsPerHour),
                  .degrees_of_freedom = degrees_of_freedom_for(coefficient.value, coefficient.error)});
}

/// Pools the noise floors of all records, weighted by their number of differences.
data::NoiseFloor pooled_floor(const TrainingBasis& on) {
  data::NoiseFloor all;
  double squares = 0, error_squares = 0;
  for (std::size_t i = 0; i < on.datasets.size(); ++i) {
    const data::NoiseFloor floor = noise_floor(on.clusters[i], on.datasets[i]);
    if (floor.differences == 0 || !std::isfinite(floor.deg_per_h)) continue;
    all.differences += floor.differences;
    squares += floor.differences * std::pow(floor.deg_per_h, 2);
    error_squares += std::pow(floor.differences * floor.error_deg_per_h, 2);
  }
  if (all.differences == 0) return all;
  all.deg_per_h = std::sqrt(squares / all.differences);
  all.error_deg_per_h = std::sqrt(error_squares) / all.differences;
  return all;
}

/// Noise floor of the training records, and whether it comes from the held-out residual.
struct BudgetFloor {
  data::NoiseFloor floor;
  bool of_residual{};
};

/// Returns the pooled noise floor. If no record has a hold, returns the white noise of the held-out residual.
BudgetFloor find_floor(const TrainingBasis& on, const data::Clusters& clusters) {
  if (std::ranges::any_of(on.datasets, &data::has_hold)) return {pooled_floor(on), false};
  return {data::residual_noise(clusters, on.held_out_residual_deg_per_h, on.datasets.front().step_deg_per_h), true};
}

/// Returns the noise of the compensated holds of the record with the longest total hold time.
data::HoldNoise longest_hold_noise(const Model& model, const TrainingBasis& on) {
  data::HoldNoise most;
  for (std::size_t i = 0; i < on.datasets.size(); ++i) {
    const auto predicted = predict(model, on.clusters[i]);
    if (!predicted) continue;
    const Eigen::VectorXd residual = on.clusters[i].bias_deg_per_h - *predicted;
    data::HoldNoise noise = measure_compensated_hold_noise(on.datasets[i], on.clusters[i], residual);
    if (!noise.curve.empty() && noise.seconds > most.seconds) most = std::move(noise);
  }
  return most;
}

/// Returns the standard uncertainty that quantisation causes in a mean over `averaging_s`, °/h; 0 for a unit that
/// outputs a rate.
double quantisation_deg_per_h(const data::Dataset& dataset, double averaging_s) {
  // The standard deviation of a triangular distribution is its half-width divided by √6.
  constexpr double kTriangularDivisor = 6;
  return dataset.step_deg_per_h / averaging_s / std::sqrt(kTriangularDivisor);
}

void add_noise_rows(std::vector<BudgetRow>& rows, const Model& model, const TrainingBasis& on,
                    const BudgetFloor& known) {
  const data::NoiseFloor& floor = known.floor;
  const data::Dataset& first = on.datasets.front();
  const data::HoldNoise noise = longest_hold_noise(model, on);
  if (find_coefficient(noise.fit, data::NoiseTerm::angle_random_walk).seen)
    add_noise_row(rows, noise.fit, data::NoiseTerm::angle_random_walk, Source::angle_random_walk);
  if (rows.empty() && floor.differences > 0) {
    const double length_s = on.clusters.front().length_s;
    const double white = std::pow(floor.deg_per_h, 2) - std::pow(quantisation_deg_per_h(first, length_s), 2);
    rows.push_back({.source = Source::angle_random_walk,
                    .evaluation = Evaluation::a,
                    .standard_uncertainty = std::sqrt(std::max(0.0, white) * length_s / kSecondsPerHour),
                    .degrees_of_freedom = degrees_of_freedom_for(floor.deg_per_h, floor.error_deg_per_h),
                    .without_holds = known.of_residual});
  }
  add_noise_row(rows, noise.fit, data::NoiseTerm::bias_instability, Source::flicker);
  add_noise_row(rows, noise.fit, data::NoiseTerm::rate_random_walk, Source::rate_random_walk);
  if (first.step_deg_per_h > 0)
    rows.push_back({.source = Source::counting,
                    .evaluation = Evaluation::b,
                    .distribution = ErrorDistribution::triangular,
                    .standard_uncertainty = quantisation_deg_per_h(first, kSecondsPerHour)});
}

/// Computes the model form row from the part of the held-out residual that noise and hysteresis do not explain. It uses
/// the estimate even if it is not significant. Its degrees of freedom are those of the difference of the squares (GUM
/// G.3 and G.4); if the residual is far above the noise floor, they are the effective number of residuals minus one. If
/// the noise floor comes from the same residual, the squares of white noise σ have the covariance 2σ⁴/n. The form is
/// then at least the error of the p coefficients, pσ²/n, which the residual contains and the noise floor does not.
BudgetRow make_form_row(const data::Figures& figures, double standard, const BudgetFloor& known, double hysteresis,
                        const TrainingBasis& on, double parameters) {
  const data::NoiseFloor& floor = known.floor;
  BudgetRow row{
      .source = Source::model_form, .evaluation = Evaluation::a, .chosen_on_these_folds = on.chosen_on_these_folds};
  const double residual = std::pow(standard, 2);
  const double square = residual - std::pow(floor.deg_per_h, 2) - std::pow(hysteresis, 2);
  const double least = known.of_residual ? parameters * std::pow(floor.deg_per_h, 2) / figures.count : 0;
  row.standard_uncertainty = std::sqrt(std::max(least, square));
  const double freedom = std::max(1.0, figures.effective.of_std - 1);
  const double shared = known.of_residual ? 4 * std::pow(floor.deg_per_h, 4) / floor.differences : 0;
  const double independent =
      std::pow(residual, 2) * 2 / freedom + std::pow(2 * floor.deg_per_h * floor.error_deg_per_h, 2);
  row.degrees_of_freedom = std::max(1.0, 2 * square * square / std::max(independent - shared, 0.25 * independent));
  if (!(square > 0)) row.degrees_of_freedom = 1;
  return row;
}

/// Adds the rows of the model itself: its form and its hysteresis.
void add_model_rows(std::vector<BudgetRow>& rows, const Model& model, const data::Clusters& clusters,
                    const TrainingBasis& on, const BudgetFloor& floor) {
  const Eigen::VectorXd& residual = on.held_out_residual_deg_per_h;
  const std::vector<Eigen::Index> known = data::finite_rows(residual);
  if (known.size() < 2) return;
  const data::Figures figures = compute_figures(residual(known), clusters, known);
  const Hysteresis hysteresis = estimate_hysteresis(residual, clusters);
  const double as_limits = hysteresis.half_deg_per_h / std::numbers::sqrt3;
  const double standard = robust_standard_deg_per_h(residual(known), figures.effective.of_std);
  rows.push_back(make_form_row(figures, standard, floor, as_limits, on, model.effective_parameters));
  rows.back().only_start_held_out = count_power_ons(clusters) < 2;
  rows.push_back({.source = Source::hysteresis,
                  .evaluation = Evaluation::a,
                  .distribution = ErrorDistribution::rectangular,
                  .standard_uncertainty = as_limits,
                  .degrees_of_freedom = hysteresis.degrees_of_freedom,
                  .chosen_on_these_folds = on.chosen_on_these_folds});
}

/// Returns the uncertainty that a record states for a thermometer; empty if it states none.
record::ThermometerUncertainty stated_uncertainty(const data::Dataset& dataset, const std::string& thermometer) {
  const auto at = std::ranges::find(dataset.thermometers, thermometer) - dataset.thermometers.begin();
  if (at >= std::ssize(dataset.thermometer_uncertainty)) return {};
  return dataset.thermometer_uncertainty[static_cast<std::size_t>(at)];
}

/// Returns the unit of an input in the record; empty if it has none.
std::string input_unit(const data::Dataset& dataset, const std::string& input) {
  const auto at = std::ranges::find(dataset.thermometers, input) - dataset.thermometers.begin();
  const std::string unit =
      at < std::ssize(dataset.input_units) ? dataset.input_units[static_cast<std::size_t>(at)] : std::string();
  return unit == "°C" ? "K" : unit;  // a drift is a difference
}

/// Returns the years between calibration and record; no value if the day of calibration is unknown or after the record.
std::optional<double> years_since_calibration(const data::Dataset& dataset,
                                              const record::ThermometerUncertainty& thermometer) {
  using Days = std::chrono::duration<double, std::chrono::days::period>;
  constexpr double kDaysInAYear = 365.25;
  if (!thermometer.calibrated) return std::nullopt;
  const double days = Days(dataset.started_utc).count() - Days(thermometer.calibrated->time_since_epoch()).count();
  return days >= 0 ? std::optional(days / kDaysInAYear) : std::nullopt;
}

/// Returns a type B row with the value that the record states, or the assumed one.
BudgetRow stated_or_assumed_row(Source source, const std::optional<double>& stated, double assumed,
                                double sensitivity) {
  return {.source = source,
          .evaluation = Evaluation::b,
          .standard_uncertainty = stated.value_or(assumed),
          .sensitivity = sensitivity,
          .assumed = !stated};
}

std::optional<double> optional_value(const std::optional<Kelvins>& kelvins) {
  return kelvins ? std::optional(kelvins->value) : std::nullopt;
}

/// Computes the drift from the calibration to the run of a record, K. Assumes 0.05 K per year and one year where the
/// record does not state them.
double drift_until_run_k(const data::Dataset& dataset, const record::ThermometerUncertainty& stated) {
  const double in_a_year_k = optional_value(stated.drift_in_a_year).value_or(kDriftInAYear_k);
  return in_a_year_k * std::sqrt(years_since_calibration(dataset, stated).value_or(kYearsSinceCalibration));
}

/// Adds the turn-on row and the rows for the subtraction of the Earth rate.
void add_gyro_rows(std::vector<BudgetRow>& rows, const data::Dataset& dataset, int power_ons) {
  rows.push_back(stated_or_assumed_row(Source::turn_on, dataset.gyro_uncertainty.turn_on_repeatability_deg_per_h,
                                       kTurnOn_deg_per_h, std::sqrt(1 + 1.0 / std::max(1, power_ons))));
  for (BudgetRow& row : budget_of_earth_rate(dataset)) rows.push_back(std::move(row));
}

/// Returns √Σ(c_i n_i)² of the mean of one cluster, with the thermometer noise of the first record.
double added_noise(const std::vector<Sensitivity>& sensitivities, const TrainingBasis& on) {
  const std::vector<std::string>& names = on.clusters.front().thermometers;
  const Eigen::RowVectorXd noise_k = thermometer_noise_k(on.datasets.front(), on.clusters.front());
  double squares = 0;
  for (const Sensitivity& one : sensitivities) {
    const auto at = std::ranges::find(names, one.thermometer) - names.begin();
    if (std::isfinite(noise_k(at))) squares += std::pow(one.rms * noise_k(at), 2);
  }
  return std::sqrt(squares);
}

/// Returns the model's own variance in each cluster, (°/h)². It grows outside the trained range without
/// extrapolation_factor().
Result<Eigen::VectorXd> function_variance(const Model& model, const data::Clusters& clusters) {
  const auto inputs = evaluate(model.terms, clusters);
  if (!inputs) return failure(inputs.error());
  return predict_with_std(model, *inputs).map([](const Prediction& predicted) -> Eigen::VectorXd {
    return predicted.std_deg_per_h.cwiseAbs2();
  });
}

/// Returns the columns whose mean is the gyro's temperature. These are all thermometers, including those that the model
/// does not use; all models of a record are therefore compared at the same temperatures. The unit's own values are
/// excluded: most are not temperatures, and a missing value would exclude the cluster. The unit's own temperature is
/// used if there is no thermometer.
std::vector<Eigen::Index> temperature_columns(const std::vector<std::string>& inputs) {
  std::vector<Eigen::Index> columns;
  for (std::size_t i = 0; i < inputs.size(); ++i)
    if (!data::is_own_value(inputs[i])) columns.push_back(static_cast<Eigen::Index>(i));
  const auto self = std::ranges::find(inputs, data::kSelf);
  if (columns.empty() && self != inputs.end()) columns.push_back(self - inputs.begin());
  return columns;
}

constexpr int kFewestPerDirection = 3;

/// Residuals of clusters in one temperature step.
struct TemperatureStep {
  double rising{}, falling{};  ///< sums
  int rises{}, falls{};
};

/// Returns a slope of the Earth rate, °/h per degree, or 0 for the remainder of a difference or a cosine that should be
/// 0: less than a billionth of the greatest possible slope.
double remove_residue(double slope) {
  constexpr double kGreatest = kEarthRateDegPerHour * std::numbers::pi / 180, kRelative = 1e-9;
  return std::abs(slope) < kRelative * kGreatest ? 0 : slope;
}

}  // namespace

double robust_standard_deg_per_h(const Eigen::VectorXd& residual_deg_per_h, double effective) {
  constexpr double kOneSigma = 0.6827, kTwoSided95 = 1.959964;
  const auto count = static_cast<double>(residual_deg_per_h.size());
  Eigen::VectorXd magnitude = residual_deg_per_h.cwiseAbs();
  std::ranges::sort(magnitude);
  const double inflation = effective >= 1 ? 1 + 1 / effective : 2;
  const auto quantile = [&](double share) {
    const double rank = std::ceil(std::min(1.0, share * inflation) * count);
    return magnitude(static_cast<Eigen::Index>(std::clamp(rank, 1.0, count)) - 1);
  };
  return std::min(std::sqrt(residual_deg_per_h.squaredNorm() / count),
                  std::max(quantile(kCoverage) / kTwoSided95, quantile(kOneSigma)));
}

std::vector<BudgetRow> budget_of_thermometer(const data::Dataset& dataset, const Sensitivity& sensitivity) {
  const record::ThermometerUncertainty stated = stated_uncertainty(dataset, sensitivity.thermometer);
  BudgetRow calibration = stated_or_assumed_row(Source::thermometer_calibration, optional_value(stated.calibration),
                                                kCalibration_k, sensitivity.rms);
  if (stated.rectangular) calibration.distribution = ErrorDistribution::rectangular;
  const auto years = years_since_calibration(dataset, stated);
  BudgetRow drift = stated_or_assumed_row(Source::thermometer_drift, optional_value(stated.drift_in_a_year),
                                          kDriftInAYear_k, sensitivity.rms);
  drift.standard_uncertainty *= std::sqrt(years.value_or(kYearsSinceCalibration));
  drift.assumed = drift.assumed || !years;
  calibration.of = drift.of = sensitivity.thermometer;
  if (data::is_temperature(sensitivity.thermometer)) return {std::move(calibration), std::move(drift)};
  // A constant error of a value measured by the unit is a property of the unit. Such an input has a drift row, but no
  // calibration row.
  drift.source = Source::input_drift;
  drift.unit = input_unit(dataset, sensitivity.thermometer);
  return {std::move(drift)};
}

BudgetRow budget_of_scale_factor(const data::Dataset& dataset, double rate_deg_per_h) {
  constexpr double kPerPpm = 1e-6;
  return stated_or_assumed_row(Source::scale_factor, dataset.gyro_uncertainty.scale_factor_uncertainty_ppm,
                               kScaleFactor_ppm, rate_deg_per_h * kPerPpm);
}

std::vector<BudgetRow> budget_of_angles(const data::Dataset& dataset) {
  const record::GyroUncertainty& gyro = dataset.gyro_uncertainty;
  if (!gyro.latitude_deg || !gyro.azimuth_deg || !gyro.elevation_deg) return {};
  std::vector<BudgetRow> rows;
  const EarthRateSlopes slopes = earth_rate_slopes(*gyro.latitude_deg, *gyro.azimuth_deg, *gyro.elevation_deg);
  rows.push_back(
      stated_or_assumed_row(Source::latitude, gyro.latitude_uncertainty_deg, kLatitude_deg, slopes.latitude));
  rows.push_back(stated_or_assumed_row(Source::azimuth, gyro.azimuth_uncertainty_deg, kAzimuth_deg, slopes.azimuth));
  if (gyro.fixture_azimuth_deg && gyro.fixture_elevation_deg) {
    const FixtureSlopes of = fixture_slopes(gyro);
    rows.push_back(
        stated_or_assumed_row(Source::fixture_elevation, gyro.elevation_uncertainty_deg, kTilt_deg, of.elevation));
    rows.push_back(stated_or_assumed_row(Source::fixture_roll, gyro.roll_uncertainty_deg, kTilt_deg, of.roll));
    rows.push_back(
        stated_or_assumed_row(Source::axis_direction, gyro.direction_uncertainty_deg, kTilt_deg, of.direction));
  } else {
    rows.push_back(stated_or_assumed_row(Source::tilt, gyro.tilt_uncertainty_deg, kTilt_deg, slopes.elevation));
  }
  return rows;
}

std::vector<BudgetRow> budget_of_earth_rate(const data::Dataset& dataset) {
  if (!data::is_earth_rate_removed(dataset)) return {};
  std::vector<BudgetRow> rows = budget_of_angles(dataset);
  rows.push_back(budget_of_scale_factor(dataset, *dataset.earth_rate_deg_per_h));
  return rows;
}

Result<Eigen::MatrixXd> sensitivities(const Model& model, const data::Clusters& clusters) {
  const auto inputs = evaluate(model.terms, clusters);
  if (!inputs) return failure(inputs.error());
  const RangedInputs ranged = apply_range_policy(model, *inputs, Outside::continued);
  const auto moved = [&](const data::SampleMatrix& by) {
    RangedInputs there = ranged;
    there.inputs += by;
    if (there.bounded.size() > 0) there.bounded += by;
    return predict(model, there);
  };
  Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(clusters.temperature_c.rows(), clusters.temperature_c.cols());
  for (Eigen::Index i = 0; i < slopes.cols(); ++i) {
    if (!uses_thermometer(model, clusters.thermometers[static_cast<std::size_t>(i)])) continue;
    const auto above = evaluate_shifted(model, clusters, i, kStep_k),
               below = evaluate_shifted(model, clusters, i, -kStep_k);
    if (!above || !below) return failure(above ? below.error() : above.error());
    slopes.col(i) = (moved(*above - *inputs) - moved(*below - *inputs)) / (2 * kStep_k);
  }
  return slopes;
}

std::vector<Sensitivity> summarise_sensitivities(const Eigen::MatrixXd& sensitivities,
                                                 const std::vector<std::string>& thermometers) {
  assert(sensitivities.cols() == std::ssize(thermometers));
  const std::vector<Eigen::Index> rows = data::finite_rows(sensitivities);
  std::vector<Sensitivity> all;
  for (std::size_t i = 0; i < thermometers.size() && !rows.empty(); ++i) {
    const Eigen::VectorXd slopes = sensitivities(rows, static_cast<Eigen::Index>(i));
    if (slopes.isZero(0)) continue;
    all.push_back({.thermometer = thermometers[i],
                   .mean = slopes.mean(),
                   .rms = std::sqrt(slopes.squaredNorm() / static_cast<double>(rows.size())),
                   .greatest = slopes.cwiseAbs().maxCoeff()});
  }
  return all;
}

Eigen::RowVectorXd thermometer_noise_k(const data::Dataset& dataset, const data::Clusters& clusters) {
  constexpr double kOfSecondDifferences = 6;
  const auto& t = dataset.temperature_c;
  const Eigen::Index inner = std::max<Eigen::Index>(t.rows() - 2, 0);
  Eigen::RowVectorXd noise = Eigen::RowVectorXd::Constant(t.cols(), std::numeric_limits<double>::quiet_NaN());
  const double samples = clusters.samples.cast<double>().mean();
  // Permitted span from the first to the last of three samples, in sample intervals; a gap exceeds it.
  constexpr double kMaxSpanOfThree = 2.5;
  const auto span = (dataset.time_s.tail(inner) - dataset.time_s.head(inner)).array();
  const Eigen::Array<bool, Eigen::Dynamic, 1> together = span <= kMaxSpanOfThree * sample_interval_s(dataset);
  for (Eigen::Index j = 0; j < t.cols(); ++j) {
    Eigen::ArrayXd squares =
        (t.col(j).tail(inner) - 2 * t.col(j).segment(inner > 0 ? 1 : 0, inner) + t.col(j).head(inner)).array().square();
    squares = together.select(squares, std::numeric_limits<double>::quiet_NaN());
    const Eigen::Index count = squares.isFinite().count();
    if (count == 0) continue;
    const double mean = squares.isFinite().select(squares, 0).sum() / static_cast<double>(count);
    noise(j) = std::sqrt(mean / kOfSecondDifferences / samples);
  }
  return noise;
}

double correlation_factor(const Model& model) {
  const auto freedom = [&](double number) { return std::max(1.0, number - model.effective_parameters); };
  return std::max(1.0, freedom(model.in_sample.count) / freedom(model.in_sample.effective.of_mean));
}

Hysteresis estimate_hysteresis(const Eigen::VectorXd& residual_deg_per_h, const data::Clusters& clusters) {
  constexpr double kStep_c = 5, kLeastRate_c_per_min = 0.05;
  const std::vector<Eigen::Index> columns = temperature_columns(clusters.thermometers);
  if (columns.empty()) return {};
  std::map<long, TemperatureStep> steps;
  for (Eigen::Index k = 0; k < residual_deg_per_h.size(); ++k) {
    const double rate = clusters.rate_c_per_min(k, columns).mean();
    const double temperature = clusters.temperature_c(k, columns).mean();
    if (!std::isfinite(residual_deg_per_h(k)) || !(std::abs(rate) > kLeastRate_c_per_min)) continue;
    TemperatureStep& step = steps[std::lround(temperature / kStep_c)];
    (rate > 0 ? step.rising : step.falling) += residual_deg_per_h(k);
    ++(rate > 0 ? step.rises : step.falls);
  }
  std::erase_if(steps,
                [](const auto& step) { return std::min(step.second.rises, step.second.falls) < kFewestPerDirection; });
  if (steps.empty()) return {};
  const std::vector<Eigen::Index> known = data::finite_rows(residual_deg_per_h);
  const double variance = residual_deg_per_h(known).squaredNorm() / static_cast<double>(known.size());
  double squares = 0, error_squares = 0;
  for (const auto& [number, step] : steps) {
    const double half = 0.5 * (step.rising / step.rises - step.falling / step.falls);
    const double chance = 0.25 * variance * (1.0 / step.rises + 1.0 / step.falls);
    squares += half * half - chance;
    error_squares += 2 * chance * chance + 4 * std::max(0.0, half * half - chance) * chance;
  }
  if (!(squares > 0)) return {};
  const double freedom = error_squares > 0 ? 2 * squares * squares / error_squares : kInfinite;
  return {.half_deg_per_h = std::sqrt(squares / static_cast<double>(steps.size())),
          .degrees_of_freedom = std::max(1.0, freedom)};
}

Result<Uncertainty> evaluate_uncertainty(const Model& model, const TrainingBasis& on) {
  assert(!on.datasets.empty() && on.datasets.size() == on.clusters.size());
  const auto clusters = concatenate(on.clusters);
  if (!clusters) return failure(clusters.error());
  assert(on.held_out_residual_deg_per_h.size() == clusters->start_s.size());
  const auto slopes = sensitivities(model, *clusters);
  if (!slopes) return failure(slopes.error());
  Uncertainty result{.budget = {.averaging_s = kSecondsPerHour, .rows = {}},
                     .sensitivities = summarise_sensitivities(*slopes, clusters->thermometers)};
  auto& rows = result.budget.rows;
  BudgetFloor floor = find_floor(on, *clusters);
  if (!std::isfinite(floor.floor.deg_per_h)) floor = {};
  add_noise_rows(rows, model, on, floor);
  result.added_noise_deg_per_h = added_noise(result.sensitivities, on);
  rows.push_back(
      {.source = Source::thermometer_noise,
       .evaluation = Evaluation::a,
       .standard_uncertainty = result.added_noise_deg_per_h * std::sqrt(clusters->length_s / kSecondsPerHour)});
  add_model_rows(rows, model, *clusters, on, floor);
  if (model.variance && !on.variance_is_a_row) {
    const auto open = function_variance(model, *clusters);
    if (!open) return failure(open.error());
    const std::vector<Eigen::Index> known = data::finite_rows(*open);
    if (!known.empty()) result.variance_in_training = (*open)(known).mean();
  }
  for (const Sensitivity& one : result.sensitivities)
    for (BudgetRow& row : budget_of_thermometer(on.datasets.front(), one)) rows.push_back(std::move(row));
  add_gyro_rows(rows, on.datasets.front(), count_power_ons(*clusters));
  return result;
}

ThermometersInUse thermometers_in_use(const data::Dataset& dataset) {
  ThermometersInUse all;
  for (const std::string& name : dataset.thermometers) {
    const record::ThermometerUncertainty stated = stated_uncertainty(dataset, name);
    const auto drift_k = optional_value(stated.drift_in_a_year);
    all.uncertainty_k.push_back(
        std::hypot(optional_value(stated.calibration).value_or(0), drift_k.value_or(kDriftInAYear_k)));
  }
  return all;
}

double turn_on_repeatability(const data::Dataset& dataset) {
  return dataset.gyro_uncertainty.turn_on_repeatability_deg_per_h.value_or(kTurnOn_deg_per_h);
}

double yearly_drift_deg_per_h(const Model& model, const data::Dataset& dataset) {
  if (!model.uncertainty) return 0;
  double squares = 0;
  for (const Sensitivity& one : model.uncertainty->sensitivities) {
    const double drift_k =
        optional_value(stated_uncertainty(dataset, one.thermometer).drift_in_a_year).value_or(kDriftInAYear_k);
    squares += std::pow(one.rms * drift_k, 2);
  }
  return std::sqrt(squares);
}

double drift_between_k(const BudgetRow& row, const data::Dataset& dataset) {
  const record::ThermometerUncertainty stated = stated_uncertainty(dataset, row.of);
  if (row.assumed && !years_since_calibration(dataset, stated)) return row.standard_uncertainty;
  return std::hypot(row.standard_uncertainty, drift_until_run_k(dataset, stated));
}

std::vector<double> drifts_between_k(const data::Dataset& trained, const data::Dataset& used) {
  std::vector<double> all;
  for (const std::string& name : used.thermometers) {
    const record::ThermometerUncertainty then = stated_uncertainty(trained, name), now = stated_uncertainty(used, name);
    const bool a_day_is_known = years_since_calibration(trained, then) || years_since_calibration(used, now);
    all.push_back(std::hypot(a_day_is_known ? drift_until_run_k(trained, then) : 0, drift_until_run_k(used, now)));
  }
  return all;
}

std::vector<BudgetRow> rows_for_run(const data::Dataset& dataset, std::vector<BudgetRow> rows) {
  for (BudgetRow& row : rows) {
    if (!is_drift(row.source)) continue;
    const record::ThermometerUncertainty stated = stated_uncertainty(dataset, row.of);
    row.standard_uncertainty = drift_between_k(row, dataset);
    row.assumed = row.assumed || !stated.drift_in_a_year || !years_since_calibration(dataset, stated);
  }
  return rows;
}

Result<Eigen::VectorXd> interval_half_widths(const Model& model, const Uncertainty& trained,
                                             const data::Dataset& dataset, const data::Clusters& clusters) {
  const auto slopes = sensitivities(model, clusters);
  if (!slopes) return failure(slopes.error());
  const auto rows = rows_for_run(dataset, differing_rows(convert_averaging(trained.budget, clusters.length_s).rows));
  const auto inputs = evaluate(model.terms, clusters);
  if (!inputs) return failure(inputs.error());
  const Eigen::VectorXd excess = apply_range_policy(model, *inputs, Outside::extrapolate).excess;
  Eigen::VectorXd variance = form_variance(rows) * excess.unaryExpr(&extrapolation_factor);
  const bool is_a_row = std::ranges::find(rows, Source::coefficients, &BudgetRow::source) != rows.end();
  if (model.variance && (is_a_row || std::isfinite(trained.variance_in_training))) {
    const auto open = function_variance(model, clusters);
    if (!open) return failure(open.error());
    variance += is_a_row ? *open : (open->array() - trained.variance_in_training).max(0).matrix();
  }
  for (const BudgetRow& row : rows) {
    if (row.source == Source::coefficients && model.variance) continue;
    if (!is_drift(row.source)) {
      variance.array() += std::pow(contribution_deg_per_h(row), 2);
      continue;
    }
    const auto at = std::ranges::find(clusters.thermometers, row.of) - clusters.thermometers.begin();
    if (at == std::ssize(clusters.thermometers)) continue;
    variance.array() += (slopes->col(at).array() * row.standard_uncertainty).square();
  }
  return combined(rows).coverage_factor * variance.cwiseSqrt();
}

Result<std::optional<BudgetRow>> budget_of_extrapolation(const Model& model, const Uncertainty& trained,
                                                         const std::vector<BudgetRow>& rows,
                                                         const data::Clusters& clusters) {
  const auto inputs = evaluate(model.terms, clusters);
  if (!inputs) return failure(inputs.error());
  const std::vector<Eigen::Index> known = data::finite_rows(*inputs);
  const RangedInputs ranged = apply_range_policy(model, *inputs, Outside::extrapolate);
  if (ranged.rows.empty()) return std::optional<BudgetRow>();
  Eigen::VectorXd variance = form_variance(rows) * ranged.excess.unaryExpr(&extrapolation_factor);
  const auto coefficients = std::ranges::find(rows, Source::coefficients, &BudgetRow::source);
  const double included =
      coefficients != rows.end() ? std::pow(contribution_deg_per_h(*coefficients), 2) : trained.variance_in_training;
  if (model.variance && std::isfinite(included)) {
    const auto open = function_variance(model, clusters);
    if (!open) return failure(open.error());
    for (const Eigen::Index at : ranged.rows) variance(at) += std::max(0.0, (*open)(at)-included);
  }
  return std::optional(BudgetRow{.source = Source::extrapolation,
                                 .evaluation = Evaluation::b,
                                 .standard_uncertainty = std::sqrt(variance(known).mean())});
}

FixtureSlopes fixture_slopes(const record::GyroUncertainty& known) {
  constexpr double kRadian = std::numbers::pi / 180;
  const auto along = [](double azimuth_deg, double elevation_deg) {  // north, east, down
    const double az = azimuth_deg * kRadian, el = elevation_deg * kRadian;
    return Eigen::Vector3d(std::cos(el) * std::cos(az), std::cos(el) * std::sin(az), -std::sin(el));
  };
  const double phi = *known.latitude_deg * kRadian;
  const Eigen::Vector3d earth = kEarthRateDegPerHour * Eigen::Vector3d(std::cos(phi), 0, -std::sin(phi));
  const Eigen::Vector3d axis = along(*known.azimuth_deg, *known.elevation_deg);
  const Eigen::Vector3d about_level = along(*known.fixture_azimuth_deg + 90, 0);
  const Eigen::Vector3d about_x = along(*known.fixture_azimuth_deg, *known.fixture_elevation_deg);
  return {.elevation = remove_residue(kRadian * earth.dot(about_level.cross(axis))),
          .roll = remove_residue(kRadian * earth.dot(about_x.cross(axis))),
          .direction = remove_residue(kRadian * earth.cross(axis).norm() / std::numbers::sqrt2)};
}

EarthRateSlopes earth_rate_slopes(double latitude_deg, double azimuth_deg, double elevation_deg) {
  constexpr double kRadian = std::numbers::pi / 180;
  const double phi = latitude_deg * kRadian, az = azimuth_deg * kRadian, el = elevation_deg * kRadian;
  const double per_degree = kEarthRateDegPerHour * kRadian;
  return {
      .latitude =
          remove_residue(per_degree * (-std::sin(phi) * std::cos(az) * std::cos(el) + std::cos(phi) * std::sin(el))),
      .azimuth = remove_residue(-per_degree * std::cos(phi) * std::sin(az) * std::cos(el)),
      .elevation =
          remove_residue(per_degree * (-std::cos(phi) * std::cos(az) * std::sin(el) + std::sin(phi) * std::cos(el)))};
}

}  // namespace gyrotherm::model
