// SPDX-License-Identifier: Apache-2.0
#include "tests/report/synthetic_experiment.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <tuple>
#include <utility>

namespace gyrotherm::report {
namespace {

const std::vector<std::string> kNames = {"A", "B", "C", "D", "E", "F", "G", "H"};
constexpr double kLength_s = 100;

/// Normally distributed numbers from the minimal standard generator, which are equal on every machine.
class Noise {
 public:
  explicit Noise(std::uint64_t seed) : state_(seed) {}
  double normal() { return std::sqrt(-2 * std::log(uniform())) * std::cos(2 * std::numbers::pi * uniform()); }

 private:
  double uniform() { return static_cast<double>(state_ = state_ * 16807 % 2147483647) / 2147483647.0; }
  std::uint64_t state_;
};

struct Leg {
  double target_c{};
  double ramp_s{};
  double hold_s{};
  int cycle = -1;
};

std::vector<Leg> rate_legs(int stretch) {
  std::vector<Leg> legs;
  for (const auto& [cycle, rate] : {std::pair{0, 1.0}, {1, 2.0}, {2, 3.0}, {3, 5.0}}) {
    const double hold_s = 600.0 * stretch;
    double from = 20;
    legs.push_back({20, 0, hold_s, cycle});
    for (const double target : {-40.0, 60.0, -40.0, 60.0, 20.0}) {
      const double ramp_s = 100 * std::ceil(std::abs(target - from) / rate * 60 / 100 * std::min(1.0, stretch / 6.0));
      legs.push_back({target, ramp_s, hold_s, cycle});
      from = target;
    }
  }
  return legs;
}

std::vector<Leg> random_legs(int stretch) {
  std::vector<Leg> legs = {{20, 0, 600.0 * stretch, -1}};
  for (const double target : {22.5, -17.5, -39.5, 6.8, -14.5, 15.3, 51.7, 9.7, -24.6, 34.2, -7.7, 47.4, 17.0, 52.8}) {
    legs.push_back({target, 100.0 * (1 + std::abs(static_cast<int>(target)) % 12), 500.0 * stretch, -1});
  }
  return legs;
}

/// Sets the times, set points, segments and cycles of the clusters from the legs of the chamber program.
void set_program(data::RecordedRun& run, const std::vector<Leg>& legs) {
  std::vector<double> set_point;
  std::vector<int> segment, cycle;
  double from = 20;
  const auto add_segment = [&](const Leg& leg, bool hold, double duration_s) {
    const int clusters = static_cast<int>(duration_s / kLength_s);
    if (clusters == 0) return;
    const int index = static_cast<int>(run.dataset.segments.size());
    run.dataset.segments.push_back(
        {(hold ? "hold at " : "ramp to ") + std::to_string(static_cast<int>(leg.target_c)) + " °C", hold,
         Celsius{leg.target_c}, CelsiusPerMinute{}, leg.cycle});
    for (int k = 0; k < clusters; ++k) {
      set_point.push_back(hold ? leg.target_c : from + (leg.target_c - from) * (k + 0.5) / clusters);
      segment.push_back(index);
      cycle.push_back(leg.cycle);
    }
  };
  for (const Leg& leg : legs) {
    add_segment(leg, false, leg.ramp_s);
    add_segment(leg, true, leg.hold_s);
    from = leg.target_c;
  }
  const auto n = static_cast<Eigen::Index>(set_point.size());
  run.clusters.set_point_c = Eigen::Map<Eigen::VectorXd>(set_point.data(), n);
  run.clusters.segment = run.clusters.last_segment = Eigen::Map<Eigen::VectorXi>(segment.data(), n);
  run.clusters.cycle = Eigen::Map<Eigen::VectorXi>(cycle.data(), n);
}

/// Computes temperatures and bias. Each thermometer follows the set point with its own lag and a constant offset. The
/// bias follows the differences between thermometers.
void simulate(data::RecordedRun& run, Noise& noise) {
  constexpr std::array kLag_s = {2700.0, 2300.0, 2450.0, 1700.0, 1500.0, 1250.0, 1100.0, 1650.0};
  constexpr std::array kAbove_c = {3.3, 3.1, 3.3, 1.9, 2.3, 1.5, 1.5, 2.2};
  data::Clusters& clusters = run.clusters;
  const Eigen::Index n = clusters.set_point_c.size();
  clusters.thermometers = kNames;
  clusters.start_s = Eigen::VectorXd::LinSpaced(n, 0, kLength_s * static_cast<double>(n - 1));
  clusters.temperature_c.resize(n, 8);
  clusters.bias_deg_per_h.resize(n);
  for (Eigen::Index i = 0; i < 8; ++i) {
    double temperature = 20 + kAbove_c[static_cast<std::size_t>(i)];
    for (Eigen::Index k = 0; k < n; ++k) {
      const double goal = clusters.set_point_c(k) + kAbove_c[static_cast<std::size_t>(i)];
      temperature += (goal - temperature) * kLength_s / kLag_s[static_cast<std::size_t>(i)];
      clusters.temperature_c(k, i) = temperature + 0.001 * noise.normal();
    }
  }
  for (Eigen::Index k = 0; k < n; ++k) {
    const auto t = clusters.temperature_c.row(k);
    const double gradients = 0.7 * (t(0) - t(6)) + 0.5 * (t(0) - t(7)) - 0.4 * (t(0) - t(2)) + 0.2 * (t(3) - t(4));
    clusters.bias_deg_per_h(k) = 2.6e-3 * gradients - 4e-5 * (t(0) - 20) + 1.8e-3 * noise.normal();
  }
  clusters.bias_deg_per_h.array() -= clusters.bias_deg_per_h(0);
  clusters.rate_c_per_min.setConstant(n, 8, std::nan(""));
  clusters.rate_c_per_min.bottomRows(n - 1) =
      (clusters.temperature_c.bottomRows(n - 1) - clusters.temperature_c.topRows(n - 1)) / (kLength_s / 60);
}

model::SegmentFigures segment_figures(const data::RecordedRun& run, int index, const Eigen::VectorXd& residual) {
  std::vector<Eigen::Index> rows;
  for (Eigen::Index k = 0; k < run.clusters.segment.size(); ++k) {
    if (run.clusters.segment(k) == index) rows.push_back(k);
  }
  const auto& info = run.dataset.segments[static_cast<std::size_t>(index)];
  return {index,
          info.name,
          info.hold,
          run.clusters.start_s(rows.front()),
          kLength_s * static_cast<double>(rows.size()),
          run.clusters.temperature_c.col(0)(rows).mean(),
          run.clusters.bias_deg_per_h(rows).mean(),
          data::compute_figures(residual(rows))};
}

/// Returns a verification whose residual is `left_over` times the bias plus noise.
model::Verification verification(const data::RecordedRun& run, double left_over, bool trained_on_this, Noise& noise) {
  model::Verification v;
  v.run_id = run.dataset.run_id;
  v.simulated = run.dataset.simulated;
  v.trained_on_this = trained_on_this;
  v.raw = compute_figures(run.clusters.bias_deg_per_h, run.clusters);
  v.residual_deg_per_h = left_over * run.clusters.bias_deg_per_h;
  for (double& value : v.residual_deg_per_h) value += 1.85e-3 * noise.normal();
  v.compensated = compute_figures(v.residual_deg_per_h, run.clusters);
  std::vector<Eigen::Index> ramps, holds;
  for (Eigen::Index k = 0; k < run.clusters.segment.size(); ++k) {
    const bool hold = run.dataset.segments[static_cast<std::size_t>(run.clusters.segment(k))].hold;
    (hold ? holds : ramps).push_back(k);
  }
  v.ramps = v.corners = compute_figures(v.residual_deg_per_h(ramps), run.clusters, ramps);
  v.holds = compute_figures(v.residual_deg_per_h(holds), run.clusters, holds);
  v.to_truth = {.figures = compute_figures(left_over * run.clusters.bias_deg_per_h, run.clusters),
                .mean_removed = false};
  v.floor = {0.00187, 836, 0.00006, "Hadamard deviation at τ = 100 s of the raw bias in the last hour of 24 holds"};
  v.coverage = model::Coverage{0.95, 0.93, 150, 60, 0.0041};
  v.effective_parameters = 40;
  v.expected_in_sample_std = expected_in_sample_std(v.floor, trained_on_this ? 40 : 0, v.compensated.count);
  if (!trained_on_this) v.outside = {model::Outside::continued, 3, "A-B", 0.042};
  for (int k = 0; k < static_cast<int>(run.dataset.segments.size()); ++k) {
    v.segments.push_back(segment_figures(run, k, v.residual_deg_per_h));
  }
  return v;
}

/// Returns white noise of the gyro in holds of one hour, one sample per second.
data::HoldNoise hold_noise(Noise& noise) {
  data::Dataset holds;
  constexpr Eigen::Index kHour = 3600, kHolds = 4;
  holds.time_s = Eigen::VectorXd::LinSpaced(kHolds * kHour, 0, kHolds * kHour - 1);
  holds.bias_deg_per_h.resize(kHolds * kHour);
  for (double& value : holds.bias_deg_per_h) value = 0.0187 * noise.normal();
  holds.segment.resize(kHolds * kHour);
  for (int k = 0; k < kHolds; ++k) {
    holds.segments.push_back({"hold", true, {}, {}, -1});
    holds.segment.segment(k * kHour, kHour).setConstant(k);
  }
  return measure_hold_noise(holds);
}

data::RecordedRun make_run(const std::vector<Leg>& legs, const std::string& id, bool simulated, bool trained,
                           Noise& noise) {
  data::RecordedRun run;
  run.dataset.run_id = id;
  run.dataset.path = "/somewhere/on/this/machine/run.db";
  run.dataset.simulated = simulated;
  run.dataset.profile_name = trained ? "qualification program" : "random program";
  run.dataset.bias_zero = "earth rate removed";
  run.dataset.thermometers = run.dataset.gradients = kNames;
  if (trained) run.dataset.cycles = {"1 °C/min", "2 °C/min", "3 °C/min", "5 °C/min"};
  set_program(run, legs);
  simulate(run, noise);
  return run;
}

model::Model make_model(const std::string& inputs, std::vector<data::Term> terms, const data::RecordedRun& rate,
                        const model::Verification& in_sample, double worst_deg_per_h) {
  model::Model model;
  model.inputs = inputs;
  model.method = "svr";
  model.terms = std::move(terms);
  model.target_std_deg_per_h = in_sample.raw.std;
  methods::SvrModel svr;
  svr.support_vectors.resize(57, static_cast<Eigen::Index>(model.terms.size()));
  svr.parameters = {84.2, 4.61, 0.0525};
  svr.relative_gap = 3.1e-4;
  svr.kkt_violation = 8.8e-4;
  model.function = svr;
  model.trained_on = {{rate.dataset.run_id, rate.dataset.path, rate.dataset.profile_name, rate.dataset.simulated,
                       static_cast<int>(rate.clusters.start_s.size())}};
  model.folds = "leave one cycle out (4)";
  model.in_sample = in_sample.compensated;
  model.leave_cycle_out = in_sample.compensated;
  model.leave_cycle_out.std *= 1.1;
  for (int k = 0; k <= 30; ++k) {
    const double rmse = worst_deg_per_h * (0.55 + 0.45 * std::exp(-0.35 * (k - k % 3)));
    model.tuning.swarm.history.push_back(rmse * rmse);
  }
  model.tuning.swarm.end = svm::SwarmEnd::iterations_done;
  model.tuning.swarm.evaluations = 620;
  return model;
}

data::Term gradient(const char* first, const char* second) { return data::gradient_term(first, second); }

/// Returns a least-squares model instead of a support vector machine.
model::TrainedModel linear_model(const model::Model& like) {
  model::TrainedModel trained;
  trained.model.inputs = like.inputs;
  trained.model.method = "linear";
  trained.model.terms = like.terms;
  trained.model.function = methods::LinearModel{Eigen::VectorXd::Ones(static_cast<Eigen::Index>(like.terms.size())), 0};
  trained.model.effective_parameters = 9;
  trained.model.leave_cycle_out = {0.0038, 0, 0.0038, 0.013, 200};
  trained.model.nested_leave_cycle_out = data::Figures{0.0039, 0, 0.0039, 0.013, 200};
  trained.rate.compensated = {0.0037, 0, 0.0037, 0.012, 200};
  trained.random.compensated = {0.0030, -0.0002, 0.0030, 0.011, 150};
  trained.later = {trained.random};
  return trained;
}

/// Returns an uncertainty with one known and one assumed source.
model::Uncertainty some_uncertainty() {
  return {.budget = {.averaging_s = 3600,
                     .rows = {{.source = model::Source::angle_random_walk,
                               .standard_uncertainty = 3e-4,
                               .degrees_of_freedom = 120},
                              {.source = model::Source::thermometer_drift,
                               .of = "A",
                               .evaluation = model::Evaluation::b,
                               .standard_uncertainty = 0.05,
                               .sensitivity = 0.008,
                               .assumed = true}}},
          .sensitivities = {{"A", 0.006, 0.008, 0.011}, {"B", -0.006, 0.006, 0.007}},
          .added_noise_deg_per_h = 1e-5};
}

}  // namespace

SyntheticExperiment::SyntheticExperiment(int stretch, bool simulated) {
  Noise rate_noise(1234567890), random_noise(987654321);
  rate = make_run(rate_legs(stretch), "0123456789abcdef0123456789abcdef", simulated, true, rate_noise);
  random = make_run(random_legs(stretch), "fedcba9876543210fedcba9876543210", simulated, false, random_noise);
  later = random;
  later.dataset.run_id = "00112233445566778899aabbccddeeff";
  auto& [three_point, multi_point, multi_point_t] = qualification.models;
  for (const auto& [trained, on_rate, on_random] :
       {std::tuple{&three_point, 0.14, 0.33}, {&multi_point, 0.05, 0.12}, {&multi_point_t, 0.01, 0.03}}) {
    trained->rate = verification(rate, on_rate, true, rate_noise);
    trained->random = verification(random, on_random, false, random_noise);
    trained->later = {verification(later, 1.2 * on_random, false, random_noise)};
  }
  const std::vector<data::Term> pairs = {gradient("A", "B"), gradient("A", "G"), gradient("A", "H"),
                                         gradient("D", "E")};
  std::vector<data::Term> with_temperature = pairs;
  with_temperature.push_back(data::temperature_term("A"));
  three_point.model = make_model("three-point", {gradient("A", "D"), gradient("A", "G"), gradient("D", "G")}, rate,
                                 three_point.rate, 0.0085);
  multi_point.model = make_model("multi-point", pairs, rate, multi_point.rate, 0.0052);
  multi_point.model.selection = {pairs, 0.90, 4, false, "4 pairs exceed 0.90"};
  multi_point_t.model = make_model("multi-point-t", with_temperature, rate, multi_point_t.rate, 0.0037);
  multi_point_t.model.tuning.warnings = {"log2 C = 12 is at a bound of its search range"};
  multi_point_t.model.uncertainty = some_uncertainty();
  multi_point_t.model.warnings = multi_point_t.model.tuning.warnings;
  qualification.comparison.models = {linear_model(multi_point_t.model)};
  qualification.recommendation = model::recommend(
      {{"multi_point_t", 467, {4.4e-6, 4.2e-6, 4.5e-6}}, {"linear-seven-point", 24, {4.3e-6, 4.6e-6, 4.4e-6}}});
}

Report SyntheticExperiment::report() const {
  Report report = make_report({.rig = {.name = "virtual",
                                       .title = "Virtual rig: ring laser gyro in a climatic chamber",
                                       .gyro = "pulse counts, 0.1 arcsec each",
                                       .sha256 = std::string(64, 'e'),
                                       .is_virtual = rate.dataset.simulated,
                                       .gyro_model = {},
                                       .gyro_film = {},
                                       .gyro_model_sha256 = {},
                                       .thermometers = {{"A", "t1", "none"}}},
                               .rate = {rate, std::string(64, 'a'), std::string(64, 'b')},
                               .random = {random, std::string(64, 'c'), std::string(64, 'd')},
                               .later = {{"30 days later", later, std::string(64, 'f')}},
                               .qualification = qualification,
                               .program_version = "0.1.0",
                               .seed = 1});
  report.accept = compare_with_limits(report, {{"random.multi_point_t.std_deg_per_h", 0.003}});
  Noise noise(24680);
  for (ReportedRun* run : {&report.rate, &report.random})
    run->noise.holds = run->noise.compensated_holds = hold_noise(noise);
  return report;
}

}  // namespace gyrotherm::report
