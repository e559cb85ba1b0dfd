// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <random>
#include <regex>

#include "analysis/model/training.hpp"
#include "bench/measurement.hpp"
#include "bench/svr/sections.hpp"
#include "core/file.hpp"

namespace gyrotherm::bench {
namespace {

constexpr int kClusters = 600;
constexpr int kClusterSeconds = 100;
const std::vector<std::string> kNames{"A", "B", "C", "D", "E", "F", "G", "H"};

/// Returns a record with eight thermometers that follow a slow oscillation with different lags, and a bias from their
/// differences; one row per second.
data::Dataset designed_record() {
  std::mt19937_64 generator(3);
  std::normal_distribution<double> normal;
  data::Dataset record;
  record.run_id = "designed";
  record.path = "designed.db";
  record.simulated = true;
  record.thermometers = record.gradients = kNames;
  record.three_point = {"A", "D", "G"};
  record.bias_zero = "nothing removed";
  record.segments.push_back({"swing", true, {20}, {}, -1});
  const Eigen::Index rows = kClusters * kClusterSeconds;
  record.time_s = Eigen::VectorXd::LinSpaced(rows, 0, static_cast<double>(rows - 1));
  record.temperature_c.resize(rows, static_cast<Eigen::Index>(kNames.size()));
  record.bias_deg_per_h.resize(rows);
  record.set_point_c = Eigen::VectorXd::Constant(rows, 20);
  record.segment = Eigen::VectorXi::Zero(rows);
  record.cycle = Eigen::VectorXi::Constant(rows, -1);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const double turns = record.time_s[i] / 7000;
    for (Eigen::Index k = 0; k < record.temperature_c.cols(); ++k) {
      const double phase = 2 * std::numbers::pi * (turns - 0.02 * static_cast<double>(k));
      record.temperature_c(i, k) = 20 + 35 * std::sin(phase) + 5 * std::sin(0.37 * phase) +
                                   0.05 * static_cast<double>(k) + 0.01 * normal(generator);
    }
    const auto t = record.temperature_c.row(i);
    record.bias_deg_per_h[i] = 4e-3 * (t[0] - t[3]) - 3e-3 * (t[0] - t[6]) + 2e-4 * t[0] + 0.05 * normal(generator);
  }
  return record;
}

/// Trains a model with about 500 support vectors on seven gradients and a temperature.
Result<model::Model> designed_model(const data::Dataset& record) {
  const auto clusters = make_clusters(record);
  if (!clusters) return failure(clusters.error());
  model::TrainingOptions options;
  options.inputs = "A-B,A-C,A-D,A-E,A-F,A-G,A-H,A";
  options.program_version = "bench";
  options.tuning.log2_c = {0, 0};
  options.tuning.log2_sigma = {1, 1};
  options.tuning.log2_epsilon = {-8, -8};
  options.tuning.swarm.particles = 1;
  options.tuning.swarm.iterations = 0;
  return train({record}, {*clusters}, options);
}

std::string format_rows(const data::Dataset& record, int rows) {
  std::string text = fmt::format("{},bias\n", fmt::join(kNames, ","));
  for (int i = 0; i < rows; ++i) {
    const Eigen::Index at = i % record.temperature_c.rows();
    for (const double t : record.temperature_c.row(at)) text += fmt::format("{:.2f},", t);
    text += fmt::format("{:.5f}\n", record.bias_deg_per_h[at]);
  }
  return text;
}

/// Returns the seconds of the training stage in timings.json.
std::optional<double> training_seconds(const std::string& timings) {
  const auto json = nlohmann::json::parse(timings, nullptr, false);
  if (!json.is_object() || !json.contains("stages")) return {};
  for (const auto& stage : json["stages"]) {
    if (!stage.contains("stage") || !stage.contains("wall_s") || !stage["wall_s"].is_number()) continue;
    if (stage["stage"].is_string() && stage["stage"].get<std::string>().starts_with("train"))
      return stage["wall_s"].get<double>();
  }
  return {};
}

/// Runs a shell command; its stderr passes through. Returns true on success.
bool succeeds(const std::string& command) { return std::system(command.c_str()) == 0; }

}  // namespace

Result<void> measure_compensation(const std::string& program, const std::string& scratch, int rows) {
  const data::Dataset record = designed_record();
  const auto model = designed_model(record);
  if (!model) return failure(model.error());
  const std::string model_path = scratch + "/compensation-model.json";
  const std::string rows_path = scratch + "/compensation-rows.csv";
  const std::string count_path = scratch + "/compensation-count.txt";
  if (auto ok = replace_text_file(model_path, to_json(*model)); !ok) return failure(ok.error());
  if (auto ok = replace_text_file(rows_path, format_rows(record, rows)); !ok) return failure(ok.error());
  const std::string command =
      fmt::format("cat '{}' | '{}' compensate --quiet '{}' | wc -l > '{}'", rows_path, program, model_path, count_path);
  std::vector<double> times;
  for (int run = 0; run < 3; ++run) {
    const double start = wall_seconds();
    if (!succeeds(command)) return failure(FaultKind::refused, command, "failed; its output is above");
    times.push_back(wall_seconds() - start);
  }
  const auto counted = read_text_file(count_path);
  const bool complete = counted && std::atoi(counted->c_str()) == rows + 1;
  if (!complete) print_progress("compensate did not print one row for each input row");
  const auto& function = std::get<methods::SvrModel>(model->function);
  print_progress(fmt::format("compensate: {} rows in {:.2f} s of wall clock, {} support vectors", rows, median(times),
                             function.beta.size()));
  print_figure("compensate as text, rows/s", rows / median(times), at_least(3e5), complete);
  return {};
}

Result<void> measure_qualification(const std::string& program, const std::string& scratch) {
  const std::string folder = scratch + "/qualification";
  std::filesystem::remove_all(folder);
  if (!succeeds(fmt::format("'{}' qualify --quiet --out '{}' >&2", program, folder)))
    return failure(FaultKind::refused, "qualify", "failed; its output is above");
  const auto timings = read_text_file(folder + "/timings.json");
  if (!timings) return failure(timings.error());
  print_progress("timings of qualify: " + std::regex_replace(*timings, std::regex(R"(\s+)"), " "));
  print_figure("qualify, training stage (three models, full swarm), s", training_seconds(*timings), at_most(15));
  return {};
}

}  // namespace gyrotherm::bench
