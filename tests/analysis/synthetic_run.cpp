// SPDX-License-Identifier: Apache-2.0
#include "tests/analysis/synthetic_run.hpp"

#include <array>
#include <cmath>
#include <random>

namespace gyrotherm::data {
namespace {

constexpr int kThermometers =
    /// Thermometers A … H on the ring B–A–C–E–H–G–F–D. Each exchanges heat with its neighbours and with the chamber
    /// air.
    8;
constexpr std::array<int, kThermometers> kRing = {1, 0, 2, 4, 7, 6, 5, 3};
constexpr std::array<double, kThermometers> kHeatCapacity = {114.5, 122.3, 114.2, 87.6,
                                                             123.6, 116.1, 100.1, 118.3};  // J/K
constexpr std::array<double, kThermometers> kFilm = {0.1605, 0.1588, 0.1528, 0.1650,
                                                     0.1389, 0.1490, 0.1431, 0.1664};                       // W/K
constexpr std::array<double, kThermometers> kPower = {0.2117, 0.1940, 0.1823, 0.027, 0.027, 0, 0, 0.1176};  // W
constexpr std::array<double, kThermometers> kBiasPerGradient = {0,    5e-3,  -4e-3, 3e-3,
                                                                2e-3, -2e-3, 4e-3,  6e-3};  // °/h/°C
constexpr double kNeighbours = 0.0584;                                                      // W/K
constexpr double kStart = 20;                                                               // °C

using Temperatures = std::array<double, kThermometers>;

Temperatures after_one_second(const Temperatures& t, double air_c) {
  Temperatures watts{};
  for (int i = 0; i < kThermometers; ++i) {
    const int here = kRing[i], next = kRing[(i + 1) % kThermometers];
    const double flow = kNeighbours * (t[next] - t[here]);
    watts[here] += flow + kFilm[here] * (air_c - t[here]) + kPower[here];
    watts[next] -= flow;
  }
  Temperatures result = t;
  for (int i = 0; i < kThermometers; ++i) result[i] += watts[i] / kHeatCapacity[i];
  return result;
}

double bias_of(const Temperatures& t, double absolute) {
  double bias = absolute * (t[0] - kStart);
  for (int i = 1; i < kThermometers; ++i) bias += kBiasPerGradient[i] * (t[0] - t[i]);
  const double arms = 0.5 * (t[1] + t[3] - t[2] - t[4]);
  return bias + 8e-3 * arms * (1 + 0.005 * (t[0] - kStart));
}

struct Second {
  double set_point_c;
  int segment, cycle;
};

/// Returns one entry per second of the program. Adds its segments and cycles to the dataset.
std::vector<Second> program(const SyntheticRun& run, Dataset& dataset) {
  std::vector<Second> seconds;
  double at = kStart;
  const auto hold = [&](int cycle) {
    dataset.segments.push_back({"hold", true, {at}, {}, cycle});
    const auto segment = static_cast<int>(dataset.segments.size()) - 1;
    for (int i = 0; i < static_cast<int>(run.hold_s); ++i) seconds.push_back({at, segment, cycle});
  };
  const auto ramp = [&](double target, double rate, int cycle) {
    dataset.segments.push_back({"ramp", false, {target}, {rate}, cycle});
    const auto segment = static_cast<int>(dataset.segments.size()) - 1;
    const int duration = static_cast<int>(std::lround(60 * std::abs(target - at) / rate));
    for (int i = 0; i < duration; ++i) seconds.push_back({at + (target - at) * i / duration, segment, cycle});
    at = target;
  };
  for (std::size_t c = 0; c < run.cycle_rates_c_per_min.size(); ++c) {
    const auto cycle = static_cast<int>(c);
    dataset.cycles.push_back("cycle " + std::to_string(c + 1));
    hold(cycle);
    for (const double target : {-20.0, 50.0, kStart}) {
      ramp(target, run.cycle_rates_c_per_min[c], cycle);
      hold(cycle);
    }
  }
  return seconds;
}

Eigen::VectorXd normals(Eigen::Index count, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  return Eigen::VectorXd::NullaryExpr(count, [&] { return normal(random); });
}

/// Simulates flicker noise of a rate by filtering white noise with (1 − z⁻¹)^(−1/2) (Kasdin 1995). The flat part of its
/// Allan variance is 2 ln 2/π times the variance of the white noise. The first half is discarded, because there the
/// filter has too little history.
Eigen::VectorXd flicker(Eigen::Index count, std::mt19937_64& random) {
  const Eigen::Index all = 2 * count;
  Eigen::VectorXd reversed_filter(all);
  reversed_filter(all - 1) = 1;
  for (Eigen::Index k = 1; k < all; ++k) {
    reversed_filter(all - 1 - k) = reversed_filter(all - k) * (static_cast<double>(k) - 0.5) / static_cast<double>(k);
  }
  const Eigen::VectorXd white = normals(all, random);
  Eigen::VectorXd filtered(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Index past = count + i + 1;
    filtered(i) = reversed_filter.tail(past).dot(white.head(past));
  }
  return filtered;
}

}  // namespace

Dataset make_synthetic_run(const SyntheticRun& run) {
  Dataset dataset;
  dataset.run_id = run.run_id;
  dataset.path = run.run_id + ".db";
  dataset.simulated = true;
  dataset.thermometers = {"A", "B", "C", "D", "E", "F", "G", "H"};
  dataset.gradients = dataset.thermometers;
  dataset.three_point = {"A", "D", "G"};
  dataset.three_point_stand_in = true;
  dataset.bias_zero = "earth rate removed";
  const std::vector<Second> seconds = program(run, dataset);
  const auto rows = static_cast<Eigen::Index>(seconds.size());
  dataset.time_s = Eigen::VectorXd::LinSpaced(rows, 0, static_cast<double>(rows - 1));
  dataset.temperature_c.resize(rows, kThermometers);
  dataset.bias_deg_per_h.resize(rows);
  dataset.set_point_c.resize(rows);
  dataset.segment.resize(rows);
  dataset.cycle.resize(rows);

  std::mt19937_64 random(run.seed);
  std::normal_distribution<double> normal;
  Temperatures t;
  t.fill(kStart);
  for (int warm_up = 0; warm_up < 4 * 3600; ++warm_up) t = after_one_second(t, kStart);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const Second& second = seconds[i];
    for (int j = 0; j < kThermometers; ++j) dataset.temperature_c(i, j) = t[j] + 0.003 * normal(random);
    dataset.bias_deg_per_h(i) = bias_of(t, run.absolute_deg_per_h_per_c) + run.noise_deg_per_h * normal(random);
    dataset.set_point_c(i) = second.set_point_c;
    dataset.segment(i) = second.segment;
    dataset.cycle(i) = second.cycle;
    t = after_one_second(t, second.set_point_c);
  }
  return dataset;
}

Eigen::VectorXd simulate(const SimulatedNoise& noise, Eigen::Index samples, double interval_s,
                         std::mt19937_64& random) {
  const double interval_h = interval_s / 3600;
  Eigen::VectorXd rate = noise.N / std::sqrt(interval_h) * normals(samples, random);
  if (noise.Q > 0) {
    const Eigen::VectorXd angle_error = noise.Q * normals(samples + 1, random);
    rate += (angle_error.tail(samples) - angle_error.head(samples)) / interval_h;
  }
  if (noise.B > 0) rate += noise.B * flicker(samples, random);
  if (noise.K > 0) {
    const Eigen::VectorXd steps = noise.K * std::sqrt(interval_h) * normals(samples, random);
    double level = 0;
    for (Eigen::Index k = 0; k < samples; ++k) rate(k) += level += steps(k);
  }
  rate += noise.R * interval_h * Eigen::VectorXd::LinSpaced(samples, 0, static_cast<double>(samples - 1));
  return rate;
}

}  // namespace gyrotherm::data
