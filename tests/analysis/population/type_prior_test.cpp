// SPDX-License-Identifier: Apache-2.0
#include "analysis/population/type_prior.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include "analysis/methods/ridge_u.hpp"
#include "tests/analysis/random_samples.hpp"

namespace gyrotherm::population {
namespace {

/// Type of gyros whose bias in °/h is w_0 + w_1 (A − 20) + w_2 (A − B) + w_3 (A − C) plus unexplained noise.
struct SimulatedType {
  Eigen::Vector4d mean{0.01, -2e-4, 8e-3, -5e-3};
  Eigen::Vector4d spread{0.002, 1e-4, 2e-3, 2e-3};  ///< standard deviations, independent
  UnexplainedNoise noise{0.002, 0.001, 4000, 0.001};
};

/// Returns a run with temperatures between −40 and 60 °C and with differences that lag and jitter.
data::Clusters temperature_run(Eigen::Index count, std::uint64_t seed) {
  data::Clusters run;
  run.thermometers = {"A", "B", "C"};
  run.start_s.resize(count);
  run.temperature_c.resize(count, 3);
  const Eigen::MatrixXd jitter = 0.1 * data::normal_matrix(count, 2, seed);
  const double phase = 0.7 * static_cast<double>(seed % 9);
  for (Eigen::Index k = 0; k < count; ++k) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(k) / 150 + phase;
    const double a = 10 - 50 * std::cos(angle + 0.5 * std::sin(0.37 * angle));
    run.start_s(k) = 100.0 * static_cast<double>(k);
    run.temperature_c.row(k) << a, a - 3 * std::sin(angle) - jitter(k, 0), a - 1.5 * std::sin(angle - 1) - jitter(k, 1);
  }
  run.rate_c_per_min.setZero(count, 3);
  run.bias_deg_per_h.setZero(count);
  run.set_point_c = run.temperature_c.col(0);
  for (Eigen::VectorXi* numbers : {&run.segment, &run.last_segment, &run.cycle, &run.samples}) numbers->setZero(count);
  return run;
}

Eigen::MatrixXd simulated_inputs(const data::Clusters& run) {
  Eigen::MatrixXd inputs(run.start_s.size(), 4);
  const auto t = [&](Eigen::Index j) { return run.temperature_c.col(j).array(); };
  inputs.col(0).setOnes();
  inputs.col(1) = t(0) - 20;
  inputs.col(2) = t(0) - t(1);
  inputs.col(3) = t(0) - t(2);
  return inputs;
}

struct SimulatedUnit {
  Eigen::Vector4d coefficients;
  std::vector<data::Clusters> runs;
};

data::Clusters simulated_run(const SimulatedType& type, const Eigen::Vector4d& coefficients, Eigen::Index count,
                             std::uint64_t seed) {
  data::Clusters run = temperature_run(count, seed);
  const Eigen::MatrixXd root = noise_covariance(type.noise, run.start_s).llt().matrixL();
  run.bias_deg_per_h = simulated_inputs(run) * coefficients + root * data::normal_vector(count, seed + 5000);
  return run;
}

SimulatedUnit simulated_unit(const SimulatedType& type, std::uint64_t seed, Eigen::Index count = 300) {
  SimulatedUnit unit{type.mean + type.spread.cwiseProduct(data::normal_vector(4, seed + 900000)), {}};
  for (std::uint64_t run = 0; run < 2; ++run)
    unit.runs.push_back(simulated_run(type, unit.coefficients, count, 10 * seed + run));
  return unit;
}

std::vector<UnitClusters> simulated_units(const SimulatedType& type, int count, std::uint64_t seed) {
  std::vector<UnitClusters> units;
  for (int u = 0; u < count; ++u)
    units.push_back(
        {"unit " + std::to_string(u), simulated_unit(type, 1000 * seed + static_cast<std::uint64_t>(u)).runs});
  return units;
}

/// Returns the first `count` clusters of a run.
data::Clusters first_clusters(const data::Clusters& run, Eigen::Index count) {
  std::vector<Eigen::Index> rows(static_cast<std::size_t>(count));
  std::iota(rows.begin(), rows.end(), 0);
  return pick_clusters(run, rows);
}

double rms(const Eigen::VectorXd& values) {
  return std::sqrt(values.squaredNorm() / static_cast<double>(values.size()));
}

TEST(TypePrior, RecoversTypeAndNoise) {
  const SimulatedType type;
  const auto prior = learn_type_prior(simulated_units(type, 40, 1), {.type = "simulated"});
  ASSERT_TRUE(prior) << text(prior.error());
  EXPECT_EQ(prior->type, "simulated");
  EXPECT_EQ(prior->units.size(), 40u);
  ASSERT_EQ(prior->terms.size(), 3u);
  EXPECT_EQ(to_string(prior->terms[2]), "A-C");
  EXPECT_NEAR(prior->noise.white_deg_per_h / type.noise.white_deg_per_h, 1, 0.05);
  EXPECT_NEAR(prior->noise.wander_deg_per_h / type.noise.wander_deg_per_h, 1, 0.15);
  EXPECT_NEAR(std::log(prior->noise.wander_time_s / type.noise.wander_time_s), 0, 0.4);
  for (Eigen::Index j = 1; j < 4; ++j) {
    SCOPED_TRACE(j);
    const double std = prior->scaling.std(j - 1);
    const double spread = std::sqrt(prior->next_unit.covariance(j, j)) / std;
    EXPECT_NEAR(prior->next_unit.mean(j) / std, type.mean(j), 4 * type.spread(j) / std::sqrt(40.0));
    EXPECT_NEAR(std::log(spread / type.spread(j)), 0, 0.4);
  }
}

/// Returns units whose coefficients are independent in the components: at the mean temperature, the constant and the
/// slopes per standard deviation of each term have the same spread.
std::vector<UnitClusters> units_with_independent_components(int count, std::uint64_t seed) {
  const SimulatedType type;
  const Eigen::Vector4d input_std(1, 35, 2.1, 1.06);
  constexpr double kSpread = 0.003, kMeanBelow20 = 10;
  std::vector<UnitClusters> units;
  for (int u = 0; u < count; ++u) {
    const std::uint64_t number = 1000 * seed + static_cast<std::uint64_t>(u);
    const Eigen::Vector4d own = kSpread * data::normal_vector(4, number + 900000).cwiseQuotient(input_std);
    Eigen::Vector4d coefficients = type.mean + own;
    coefficients(0) += kMeanBelow20 * own(1);
    units.push_back({"unit " + std::to_string(u), {simulated_run(type, coefficients, 150, 10 * number)}});
  }
  return units;
}

/// The data of a unit must not choose the variances from which its own data are predicted. Strong shrinkage to these
/// variances would otherwise nearly always be preferred to no correlations.
TEST(TypePrior, ChoosesNoCorrelationsAsOftenAsStrongShrinkageForIndependentCoefficients) {
  constexpr int kTypes = 40;
  int without = 0, strongest = 0;
  for (std::uint64_t seed = 1; seed <= kTypes; ++seed) {
    const auto prior = learn_type_prior(units_with_independent_components(6, seed));
    ASSERT_TRUE(prior) << text(prior.error());
    without += prior->correlations_worth_units == 0 ? 1 : 0;
    strongest += prior->correlations_worth_units == 100 ? 1 : 0;
  }
  EXPECT_GE(without, kTypes / 3);
  EXPECT_LE(strongest, kTypes / 2);
}

TEST(TypePrior, UsesThermometersInsteadOfValuesMeasuredByGyro) {
  std::vector<UnitClusters> units = simulated_units({}, 3, 1);
  const auto renamed = [&](std::vector<std::string> names) {
    for (UnitClusters& unit : units)
      for (data::Clusters& run : unit.runs) run.thermometers = names;
  };
  const auto inputs = [&] {
    const auto prior = learn_type_prior(units, {.quick = true});
    EXPECT_TRUE(prior);
    std::vector<std::string> terms;
    if (!prior) return terms;
    for (const data::Term& term : prior->terms) terms.push_back(to_string(term));
    return terms;
  };
  renamed({"A", "B", "aux:frames"});
  EXPECT_EQ(inputs(), (std::vector<std::string>{"A", "A-B"}));
  renamed({"aux:frames", "self", "aux:current"});
  EXPECT_EQ(inputs(), std::vector<std::string>{"self"})
      << "the gyro's own temperature is used if there is no thermometer";
}

struct CoverageCount {
  double truth{}, units{};
  void add(double share) {
    truth += share;
    units += 1;
  }
  [[nodiscard]] double share() const { return truth / units; }
};

/// A prior from twelve units predicts further units from 0 to 300 clusters of their own data. The true bias, including
/// turn-on, is within U (k = 2) about as often as for a normal distribution, and U decreases with the amount of data.
TEST(TypePrior, HasNominalCoverageForNextUnit) {
  const SimulatedType type;
  const std::vector<Eigen::Index> counts = {0, 20, 80, 300};
  std::vector<CoverageCount> coverage(counts.size());
  std::vector<double> expanded(counts.size());
  for (std::uint64_t draw = 1; draw <= 12; ++draw) {
    const auto prior = learn_type_prior(simulated_units(type, 12, draw), {.quick = draw % 4 != 0});
    ASSERT_TRUE(prior);
    for (std::uint64_t next = 0; next < 12; ++next) {
      const SimulatedUnit unit = simulated_unit(type, 500000 + 100 * draw + next);
      const double turn_on = type.noise.turn_on_deg_per_h * data::normal_vector(1, draw * 100 + next)(0);
      const data::Clusters used = temperature_run(200, draw * 1000 + next);
      UnexplainedNoise wander = type.noise;
      wander.white_deg_per_h = 1e-9;
      wander.turn_on_deg_per_h = 0;
      const Eigen::MatrixXd root = noise_covariance(wander, used.start_s).llt().matrixL();
      const Eigen::VectorXd truth = simulated_inputs(used) * unit.coefficients +
                                    root * data::normal_vector(200, draw * 77 + next) +
                                    Eigen::VectorXd::Constant(200, turn_on);
      for (std::size_t i = 0; i < counts.size(); ++i) {
        std::vector<data::Clusters> own;
        if (counts[i] > 0) own.push_back(first_clusters(unit.runs[0], counts[i]));
        const auto coefficients = learn_unit(*prior, own);
        ASSERT_TRUE(coefficients);
        const auto predicted = predict(*prior, *coefficients, used);
        ASSERT_TRUE(predicted);
        const Eigen::ArrayXd error = (predicted->bias_deg_per_h - truth).cwiseAbs();
        coverage[i].add((error <= predicted->expanded_deg_per_h.array()).cast<double>().mean());
        expanded[i] += rms(predicted->expanded_deg_per_h);
      }
    }
  }
  for (std::size_t i = 0; i < counts.size(); ++i) {
    EXPECT_GT(coverage[i].share(), 0.90) << counts[i];
    EXPECT_LT(coverage[i].share(), 0.985) << counts[i];
    EXPECT_LT(expanded[i], i > 0 ? expanded[i - 1] : 1e300) << counts[i];
  }
  EXPECT_LT(expanded[3], 0.7 * expanded[0]);
}

/// The prior and 20 clusters of a unit predict its bias better than a plane fitted to 40 clusters.
TEST(TypePrior, ReducesOwnDataNeededByUnit) {
  const SimulatedType type;
  const auto prior = learn_type_prior(simulated_units(type, 12, 3), {.quick = true});
  ASSERT_TRUE(prior);
  double with_prior = 0, without_prior = 0, twice_as_long = 0;
  for (std::uint64_t next = 0; next < 20; ++next) {
    const SimulatedUnit unit = simulated_unit(type, 600000 + next, 600);
    const data::Clusters used = temperature_run(200, next + 3), few = first_clusters(unit.runs[0], 20);
    const Eigen::VectorXd truth = simulated_inputs(used) * unit.coefficients;
    const auto error_of_plane = [&](const data::Clusters& own) {
      const auto z = *evaluate(prior->terms, own), at = *evaluate(prior->terms, used);
      const auto plane = methods::penalised_plane(z, own.bias_deg_per_h, Eigen::Matrix3d::Zero());
      return rms(((at * plane.weights).array() + plane.b).matrix() - truth);
    };
    with_prior += rms(predict(*prior, *learn_unit(*prior, std::vector{few}), used)->bias_deg_per_h - truth);
    without_prior += error_of_plane(few);
    twice_as_long += error_of_plane(first_clusters(unit.runs[0], 40));
  }
  EXPECT_LT(with_prior, 0.5 * without_prior);
  EXPECT_LT(with_prior, twice_as_long);
}

TEST(TypePrior, UsesEveryRunOfUnitAndOnlyPriorWithoutRuns) {
  const auto prior = learn_type_prior(simulated_units({}, 6, 2), {.quick = true});
  ASSERT_TRUE(prior);
  const auto nothing = learn_unit(*prior, {});
  ASSERT_TRUE(nothing);
  EXPECT_LT((nothing->coefficients.mean - prior->next_unit.mean).norm(), 1e-15);
  const SimulatedUnit unit = simulated_unit({}, 99);
  const auto one = learn_unit(*prior, std::vector{unit.runs[0]}), both = learn_unit(*prior, unit.runs);
  ASSERT_TRUE(one && both);
  EXPECT_LT(both->coefficients.covariance.trace(), one->coefficients.covariance.trace());
  // The prior and the turn-on scatter of two runs limit the uncertainty of the constant.
  const double turn_on_precision = 2 / std::pow(prior->noise.turn_on_deg_per_h, 2);
  EXPECT_GT(both->coefficients.covariance(0, 0), 1 / (1 / prior->next_unit.covariance(0, 0) + turn_on_precision));
}

/// The careful slopes minimise the error for inexact readings. With exact thermometers they are the most likely slopes.
TEST(TypePrior, AppliesUncertaintyOfThermometers) {
  const auto units = simulated_units({}, 6, 2);
  const Eigen::RowVector3d uncertainty(0.1, 0.2, 0.4);
  const auto exact = learn_type_prior(units, {.quick = true});
  const auto in_error = learn_type_prior(units, {.thermometer_uncertainty_k = {0.1, 0.2, 0.4}, .quick = true});
  ASSERT_TRUE(exact && in_error);
  const auto unit = learn_unit(*in_error, units[2].runs);
  ASSERT_TRUE(unit);
  const Eigen::Vector4d likeliest = unit->coefficients.mean, careful = noise_aware_coefficients(*in_error, *unit);
  EXPECT_EQ(noise_aware_coefficients(*exact, *learn_unit(*exact, units[2].runs)), likeliest);
  EXPECT_NEAR(careful(0) + unit->centre.dot(careful.tail(3)), likeliest(0) + unit->centre.dot(likeliest.tail(3)),
              1e-12);
  // Sum of squared errors over the runs of all units, each relative to its own mean.
  const auto error_of = [&](const Eigen::Vector4d& coefficients) {
    double sum = 0;
    for (std::uint64_t draw = 0; draw < 300; ++draw) {
      for (const UnitClusters& other : units) {
        data::Clusters read = other.runs[draw % 2];
        read.temperature_c.rowwise() += data::normal_vector(3, draw).transpose().cwiseProduct(uncertainty);
        const Eigen::MatrixXd at = apply(exact->scaling, *evaluate(exact->terms, other.runs[draw % 2]));
        const Eigen::MatrixXd seen = apply(exact->scaling, *evaluate(exact->terms, read));
        sum += ((seen.rowwise() - at.colwise().mean()) * coefficients.tail(3) -
                (at.rowwise() - at.colwise().mean()) * likeliest.tail(3))
                   .squaredNorm();
      }
    }
    return sum;
  };
  const double least = error_of(careful);
  // A step away from the most likely slopes, and two steps towards them.
  for (const double step : {-0.3, 0.3, 1.0}) EXPECT_GT(error_of(careful + step * (likeliest - careful)), least) << step;
}

/// The terms are A, A − B and A − C, so u² increases by (Σw·drift_A)² + (w₂·drift_B)² + (w₃·drift_C)².
TEST(TypePrior, WidensUncertaintyByThermometerDrift) {
  const auto units = simulated_units({}, 6, 2);
  const auto prior = learn_type_prior(units, {.thermometer_uncertainty_k = {0.1, 0.2, 0.4}, .quick = true});
  ASSERT_TRUE(prior);
  const data::Clusters& used = units[0].runs[0];
  const auto unit = learn_unit(*prior, units[2].runs);
  ASSERT_TRUE(unit);
  const auto u_squared_with = [&](const std::vector<double>& drift_k) -> Eigen::VectorXd {
    const auto predicted = predict(*prior, *unit, used, drift_k);
    if (!predicted) return Eigen::VectorXd();
    return (predicted->expanded_deg_per_h / kUnitCoverageFactor).cwiseAbs2();
  };
  const Eigen::VectorXd without = u_squared_with({});
  EXPECT_EQ(u_squared_with({0, 0, 0}), without) << "no time has passed";
  const Eigen::Vector3d slopes =
      noise_aware_coefficients(*prior, *unit).tail(3).cwiseQuotient(prior->scaling.std.transpose());
  const double of_drift = Eigen::Vector3d(0.01 * slopes.sum(), -0.02 * slopes(1), -0.03 * slopes(2)).squaredNorm();
  const Eigen::VectorXd added = u_squared_with({0.01, 0.02, 0.03}) - without;
  EXPECT_LT((added.array() - of_drift).abs().maxCoeff(), 1e-9 * of_drift);
  EXPECT_EQ(u_squared_with({0.05}).size(), 0) << "expected one drift for each thermometer";
  EXPECT_EQ(u_squared_with({0.05, -0.05, 0.05}).size(), 0);
}

TEST(TypePrior, RoundTripsThroughFile) {
  const auto prior = learn_type_prior(
      simulated_units({}, 5, 2), {.type = "RLG-1 \"°\"", .thermometer_uncertainty_k = {0.1, 0.2, 0.05}, .quick = true});
  ASSERT_TRUE(prior);
  const std::string json = to_json(*prior);
  const auto read = type_prior_from_json(json, "type.json");
  ASSERT_TRUE(read) << text(read.error());
  EXPECT_EQ(to_json(*read), json);
  EXPECT_EQ(read->terms, prior->terms);
  EXPECT_EQ(read->next_unit.mean, prior->next_unit.mean);
  EXPECT_EQ(read->next_unit.covariance, prior->next_unit.covariance);
  EXPECT_EQ(read->term_spread, prior->term_spread);
  EXPECT_EQ(read->error_covariance, prior->error_covariance);
  EXPECT_EQ(read->noise.wander_time_s, prior->noise.wander_time_s);
}

TEST(TypePrior, ReportsErrorInFile) {
  const auto prior = learn_type_prior(simulated_units({}, 5, 2), {.quick = true});
  ASSERT_TRUE(prior);
  const auto fault_with = [&](const std::string& from, const std::string& to) {
    std::string json = to_json(*prior);
    const auto at = json.find(from);
    EXPECT_NE(at, json.npos) << from;
    json.replace(at, from.size(), to);
    const auto read = type_prior_from_json(json, "type.json");
    return read ? std::string() : text(read.error());
  };
  EXPECT_NE(fault_with("prior/1", "prior/9").find("gyrotherm-type-prior/1"), std::string::npos);
  EXPECT_NE(fault_with("\"noise\"", "\"noises\"").find("noise"), std::string::npos);
  EXPECT_NE(fault_with("\"white_deg_per_h\": ", "\"white_deg_per_h\": -").find("white_deg_per_h"), std::string::npos);
  TypePrior negative = *prior;
  negative.next_unit.covariance(1, 1) = -1;
  EXPECT_FALSE(type_prior_from_json(to_json(negative), "type.json"));
  EXPECT_NE(fault_with("\"covariance_deg2_per_h2\": [", "\"covariance_deg2_per_h2\": [[1],").find("covariance"),
            std::string::npos);
  EXPECT_FALSE(type_prior_from_json("{", "type.json"));
}

TEST(TypePrior, RejectsInconsistentUnits) {
  const auto units = simulated_units({}, 4, 1);
  const auto refuses = [](std::vector<UnitClusters> of, const TypePriorOptions& options = {}) {
    const auto prior = learn_type_prior(of, options);
    return !prior && prior.error().kind == FaultKind::usage;
  };
  EXPECT_TRUE(refuses({units[0], units[1]}));
  EXPECT_TRUE(refuses({units[0], units[1], units[0]}));
  EXPECT_TRUE(refuses({units[0], units[1], {"empty", {}}}));
  auto other = units;
  other[2].runs[0].thermometers[1] = "Z";
  EXPECT_TRUE(refuses(other));
  other = units;
  other[3].runs[1].length_s = 50;
  EXPECT_TRUE(refuses(other));
  EXPECT_TRUE(refuses(units, {.terms = {data::temperature_term("H")}}));
  EXPECT_TRUE(refuses(units, {.thermometer_uncertainty_k = {0.05}}));
  const auto prior = learn_type_prior(units, {.quick = true});
  ASSERT_TRUE(prior);
  data::Clusters run = units[0].runs[0];
  run.length_s = 10;
  EXPECT_FALSE(learn_unit(*prior, std::vector{run}));
  EXPECT_FALSE(predict(*prior, *learn_unit(*prior, {}), run));
}

}  // namespace
}  // namespace gyrotherm::population
