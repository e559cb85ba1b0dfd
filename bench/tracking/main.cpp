// SPDX-License-Identifier: Apache-2.0
/// Measures bias tracking against the true bias. For each virtual gyro, a linear model is trained on the ramp run, and
/// the bias is tracked over the random run. The true bias comes from a repeated simulation of the random run.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "acquisition/record/record.hpp"
#include "analysis/model/training.hpp"
#include "analysis/model/verification.hpp"
#include "analysis/tracking/assessment.hpp"
#include "bench/true_bias.hpp"

namespace gyrotherm::bench {
namespace {

struct Options {
  std::string folder, inputs = "multi-point-t", method = "linear";
  int gyros = 10;
};

/// Measured and true residual bias of one run, one row per cluster. The model was trained on another run.
struct Residual {
  tracking::BiasNoise noise;
  data::Clusters clusters;
  Eigen::VectorXd measured, truth;
};

Result<model::Model> train_on(const std::string& path, const Options& options) {
  const auto dataset = data::load_dataset(path);
  if (!dataset) return failure(dataset.error());
  const auto clusters = data::make_clusters(*dataset);
  if (!clusters) return failure(clusters.error());
  model::TrainingOptions training;
  training.inputs = options.inputs;
  training.method = options.method;
  return model::train({*dataset}, {*clusters}, training);
}

/// Requires that the means of measured and true bias differ by no more than the angle random walk explains (6 σ). The
/// true bias includes turn-on and wander.
Result<void> check_truth(const tracking::BiasNoise& noise, const data::Clusters& measured, const data::Clusters& truth,
                         const std::string& path) {
  constexpr double kSigmas = 6, kSecondsPerHour = 3600;
  const double hours = static_cast<double>(measured.start_s.size()) * measured.length_s / kSecondsPerHour;
  const double apart = (measured.bias_deg_per_h - truth.bias_deg_per_h).mean();
  if (std::abs(apart) < kSigmas * noise.angle_random_walk_deg_per_sqrt_h / std::sqrt(hours)) return {};
  return failure(FaultKind::numeric, path,
                 fmt::format("the measured bias differs from the true bias of the laboratory by {:.2g} °/h", apart));
}

Result<Residual> compute_residual(const std::string& rate, const std::string& random, const Options& options) {
  const auto model = train_on(rate, options);
  if (!model) return failure(model.error());
  if (!model->residual_noise)
    return failure(FaultKind::usage, rate, "is too short for an estimate of the residual noise");
  const auto record = record::read_record(random);
  if (!record) return failure(record.error());
  const auto bias = true_bias(*record, random);
  if (!bias) return failure(bias.error());
  const data::Dataset measured = data::make_dataset(*record, random, data::list_axes(record->info).front());
  data::Dataset truth = measured;
  truth.bias_deg_per_h = *bias;
  const auto clusters = data::make_clusters(measured), of_truth = data::make_clusters(truth);
  if (!clusters || !of_truth) return failure(clusters ? of_truth.error() : clusters.error());
  const auto verification = verify(*model, measured, *clusters);
  if (!verification) return failure(verification.error());
  if (const auto good = check_truth(*model->residual_noise, *clusters, *of_truth, random); !good)
    return failure(good.error());
  const Eigen::VectorXd predicted = clusters->bias_deg_per_h - verification->residual_deg_per_h;
  return Residual{*model->residual_noise, *clusters, verification->residual_deg_per_h,
                  of_truth->bias_deg_per_h - predicted};
}

/// Accumulates the root mean square of values.
struct Mean {
  double sum{};
  int count{};
  void add(double value) {
    sum += value * value;
    ++count;
  }
  [[nodiscard]] double root() const { return std::sqrt(sum / count); }
};

/// Root mean squares over all gyros.
struct Means {
  Mean next_hour, next_hour_to_truth, to_truth, hour_deviation;
};

int measure(const Options& options) {
  std::vector<std::pair<std::string, Means>> means;
  fmt::print("gyro\tdenoiser\tlate s\tnext hour\tto truth\tnow to truth\tshuffled\tADEV hour\n");
  for (int gyro = 0; gyro < options.gyros; ++gyro) {
    const auto path = [&](const char* run) { return fmt::format("{}/{}-{}.db", options.folder, run, gyro); };
    const auto residual = compute_residual(path("rate"), path("random"), options);
    if (!residual) {
      fmt::print(stderr, "{}\n", text(residual.error()));
      return 1;
    }
    const auto& clusters = residual->clusters;
    const auto assessment = assess(residual->noise, tracking::space_evenly(residual->measured, clusters),
                                   clusters.length_s, tracking::space_evenly(residual->truth, clusters));
    if (means.empty()) {
      for (const auto& figures : assessment.denoisers) means.emplace_back(figures.name, Means{});
    }
    for (std::size_t i = 0; i < means.size(); ++i) {
      const tracking::DenoiserFigures& f = assessment.denoisers[i];
      fmt::print("{}\t{}\t{:.0f}\t{:.5f}\t{:.5f}\t{:.5f}\t{:.3f}\t{:.5f}\n", gyro, f.name, f.latency_s,
                 f.next_hour_rmse, f.next_hour_rmse_to_truth, f.rmse_to_truth, f.shuffled_gain, f.allan_hour);
      means[i].second.next_hour.add(f.next_hour_rmse);
      means[i].second.next_hour_to_truth.add(f.next_hour_rmse_to_truth);
      means[i].second.to_truth.add(f.rmse_to_truth);
      means[i].second.hour_deviation.add(f.allan_hour);
    }
    const tracking::Consistency& c = assessment.consistency;
    fmt::print("{}\tinnovations: NIS {:.3f} ({:.3f} to {:.3f}), Ljung-Box p {:.4f}; N {:.3g} B {:.3g} K {:.3g}\n", gyro,
               c.mean_square, c.low, c.high, c.whiteness.probability, residual->noise.angle_random_walk_deg_per_sqrt_h,
               residual->noise.instability_deg_per_h, residual->noise.rate_random_walk_deg_per_h_per_sqrt_h);
    std::fflush(stdout);
  }
  for (const auto& [name, mean] : means) {
    fmt::print("all\t{}\t\t{:.5f}\t{:.5f}\t{:.5f}\t\t{:.5f}\n", name, mean.next_hour.root(),
               mean.next_hour_to_truth.root(), mean.to_truth.root(), mean.hour_deviation.root());
  }
  return 0;
}

int run_program(int argc, char** argv) {
  Options options;
  CLI::App app{"Bias tracking against the true bias of virtual gyros; FOLDER has rate-N.db and random-N.db of each."};
  app.add_option("folder", options.folder)->required();
  app.add_option("--gyros", options.gyros, "gyros 0 … N − 1");
  app.add_option("--inputs", options.inputs);
  app.add_option("--method", options.method);
  CLI11_PARSE(app, argc, argv);
  return measure(options);
}

}  // namespace
}  // namespace gyrotherm::bench

int main(int argc, char** argv) { return gyrotherm::bench::run_program(argc, argv); }
