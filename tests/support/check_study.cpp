// SPDX-License-Identifier: Apache-2.0
#include "tests/support/check_study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "analysis/assurance/diagnosis.hpp"
#include "core/random.hpp"

namespace gyrotherm::tests {
namespace {

using assurance::CheckEntry;
using assurance::CheckKind;
using assurance::History;
using Vector3 = std::array<double, 3>;  // north, east, up

constexpr double kEarthRateDegPerH = 15.041067, kLatitudeDeg = 45, kFixtureAzimuthDeg = 30;
constexpr double kRadian = std::numbers::pi / 180;
constexpr int kThermometers = 9, kDegreesPerPlateau = 14;
constexpr std::array kThermometerNames{"A", "B", "C", "D", "E", "F", "G", "H", "shell"};

struct StudyAxis {
  std::string name;
  Vector3 direction;
};

std::vector<StudyAxis> axes_of(GoldenGyro golden) {
  if (golden != GoldenGyro::triad) return {{"gyro", {0, 0, 1}}};
  const double c = std::cos(kFixtureAzimuthDeg * kRadian), s = std::sin(kFixtureAzimuthDeg * kRadian);
  return {{"x", {c, s, 0}}, {"y", {s, -c, 0}}, {"z", {0, 0, 1}}};
}

Vector3 earth_rate_vector() {
  return {kEarthRateDegPerH * std::cos(kLatitudeDeg * kRadian), 0,
          kEarthRateDegPerH * std::sin(kLatitudeDeg * kRadian)};
}

double dot(const Vector3& a, const Vector3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vector3 cross(const Vector3& a, const Vector3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

struct StudyPlateau {
  const char* label;
  double at_c;
  bool turned;
};

std::vector<StudyPlateau> plateaus_of(GoldenGyro golden) {
  std::vector<StudyPlateau> plateaus{{"20 °C", 20, false}, {"50 °C", 50, false}, {"-20 °C", -20, false}};
  if (golden == GoldenGyro::turned) plateaus.insert(plateaus.begin() + 1, {"20 °C, turned", 20, true});
  return plateaus;
}

/// The injected change in one run.
struct InjectedChange {
  int thermometer = 0;
  double thermometer_k{};
  Vector3 tilt_rad{};
  std::size_t axis = 0;
  double drift_deg_per_h{};
};

InjectedChange draw_change(const StudyOptions& options, RandomStream& random) {
  InjectedChange change;
  const double sign = random.uniform() < 0.5 ? -1 : 1, turn = 2 * std::numbers::pi * random.uniform();
  change.thermometer = static_cast<int>(kThermometers * random.uniform());
  change.axis = static_cast<std::size_t>(static_cast<double>(axes_of(options.golden).size()) * random.uniform());
  if (options.injected == Injected::thermometer) change.thermometer_k = sign * options.thermometer_k;
  if (options.injected == Injected::gyro) change.drift_deg_per_h = sign * options.drift_deg_per_h;
  const double tilt = options.injected == Injected::mount ? options.tilt_deg * kRadian : 0;
  change.tilt_rad = {tilt * std::cos(turn), tilt * std::sin(turn), 0};
  return change;
}

/// Makes the results of one check run. `share` is the share of the change that has occurred.
class RunMaker {
 public:
  RunMaker(const StudyOptions& options, const InjectedChange& change, double share, RandomStream& random)
      : options_(options), change_(change), share_(share), random_(random), plateaus_(plateaus_of(options.golden)) {}

  [[nodiscard]] CheckEntry make(int run) && {
    // As in virtual.toml; 0.0539 K combines u = 0.02 K and the yearly drift.
    constexpr double kThermometerU = 0.0539, kDrift = 0.05, kTurnOn = 0.001;
    check_.run_id = fmt::format("{:032x}", run + 1);
    check_.started_utc = fmt::format("2026-{:02}-{:02}T08:00:00Z", run / 28 + 1, run % 28 + 1);
    const auto axes = axes_of(options_.golden);
    for (std::size_t a = 0; a < axes.size(); ++a) {
      check_.axes.push_back({.axis = axes[a].name,
                             .earth_rate_deg_per_h = dot(axes[a].direction, earth_rate_vector()),
                             .direction = {},
                             .turn_on_deg_per_h = kTurnOn});
      if (axes.size() > 1) check_.axes.back().direction.assign(axes[a].direction.begin(), axes[a].direction.end());
      add_axis(axes[a], a);
    }
    for (const StudyAxis& axis : axes) add_thermometers(axis.name, axis.name == axes.front().name);
    for (const StudyAxis& axis : axes)
      for (const char* name : kThermometerNames)
        check_.thermometers.push_back({axis.name + "." + name, kThermometerU, kDrift});
    return std::move(check_);
  }

 private:
  void add(CheckKind kind, const std::string& axis, const StudyPlateau* plateau, double value, double u,
           const char* unit, const std::string& thermometer = "") {
    check_.results.push_back({.kind = kind,
                              .axis = axis,
                              .thermometer = thermometer,
                              .plateau = plateau ? plateau->label : "",
                              .at_c = plateau ? plateau->at_c : 0,
                              .turned = plateau && plateau->turned,
                              .value = value,
                              .u = u,
                              .unit = unit});
  }

  void add_axis(const StudyAxis& axis, std::size_t index) {
    const RunScatter& scatter = options_.scatter;
    const double tilted = share_ * dot(change_.tilt_rad, cross(axis.direction, earth_rate_vector()));
    const double drift = index == change_.axis ? share_ * change_.drift_deg_per_h : 0;
    const double common = scatter.bias_common * random_.normal() + drift;
    std::vector<double> biases;
    for (const StudyPlateau& plateau : plateaus_) {
      constexpr double kSlope = 3.7e-4;  // °/h/K
      biases.push_back(0.05 + kSlope * (plateau.at_c - 20) + common + (plateau.turned ? -tilted : tilted) +
                       scatter.bias_own * random_.normal());
      add(CheckKind::bias, axis.name, &plateau, biases.back(), scatter.bias_own, "°/h");
    }
    const double hot = biases[biases.size() - 2], cold = biases.back();
    add(CheckKind::temperature_coefficient, axis.name, nullptr, (hot - cold) / 80, scatter.bias_own / 56, "°/h/K");
    if (options_.golden == GoldenGyro::turned)
      add(CheckKind::earth_rate, axis.name, &plateaus_[1], (biases[0] - biases[1]) / 2, scatter.bias_own / 1.4, "°/h");
    double squares = 0;
    const int degrees = kDegreesPerPlateau * static_cast<int>(plateaus_.size());
    for (int i = 0; i < degrees; ++i) squares += std::pow(random_.normal(), 2);
    add(CheckKind::scatter, axis.name, nullptr, scatter.scatter_deg_per_h * std::sqrt(squares / degrees),
        scatter.scatter_deg_per_h / std::sqrt(2.0 * degrees), "°/h");
  }

  void add_thermometers(const std::string& unit, bool has_change) {
    const RunScatter& scatter = options_.scatter;
    std::array<double, kThermometers> offsets{};
    for (double& offset : offsets) offset = scatter.thermometer_common_k * random_.normal();
    if (has_change) offsets[static_cast<std::size_t>(change_.thermometer)] += share_ * change_.thermometer_k;
    for (const StudyPlateau& plateau : plateaus_) {
      std::array<double, kThermometers> readings = offsets;
      double sum = 0;
      for (double& reading : readings) sum += reading += scatter.thermometer_own_k * random_.normal();
      for (std::size_t i = 0; i < kThermometers; ++i)
        add(CheckKind::thermometer, unit, &plateau, readings[i] - (sum - readings[i]) / (kThermometers - 1), 3e-4, "K",
            unit + "." + kThermometerNames[i]);
    }
  }

  const StudyOptions& options_;
  const InjectedChange& change_;
  double share_;
  RandomStream& random_;
  std::vector<StudyPlateau> plateaus_;
  CheckEntry check_;
};

RandomStream stream_of(std::uint64_t seed) { return {splitmix64(seed), RandomPurpose::drift}; }

std::optional<std::size_t> first_open(const assurance::Assessment& assessment) {
  for (std::size_t r = 0; r < assessment.runs.size(); ++r)
    if (assessment.runs[r].is_open()) return r;
  return {};
}

/// Diagnoses the run of the alarm and the repeated runs until a cause is named.
std::optional<assurance::Diagnosis> diagnose_change(const History& history, const assurance::HistoryLimits& limits,
                                                    std::size_t alarm, int repeats) {
  std::optional<assurance::Diagnosis> diagnosis;
  for (std::size_t last = alarm; last <= alarm + static_cast<std::size_t>(repeats); ++last) {
    if (last >= history.checks.size() || (diagnosis && diagnosis->named)) break;
    History until = history;
    until.checks.resize(last + 1);
    diagnosis = diagnose(until, assess(until, limits));
  }
  return diagnosis;
}

void count_cause(const StudyOptions& options, const std::string& thermometer,
                 const std::optional<assurance::Diagnosis>& diagnosis, StudyResult& result) {
  if (!diagnosis || !diagnosis->named) {
    ++result.not_told;
    return;
  }
  const bool is_cause = std::string(name(*diagnosis->named)) == name(options.injected);
  const bool is_part = options.injected != Injected::thermometer || diagnosis->hypotheses.front().part == thermometer;
  ++(is_cause && is_part ? result.right : result.wrong);
}

/// Judges one history as its laboratory would, run by run.
void follow_history(const StudyOptions& options, const assurance::HistoryLimits& limits, std::uint64_t seed,
                    StudyResult& result) {
  auto random = stream_of(seed);
  const int span = options.latest - options.earliest + 1;
  const int from =
      options.injected == Injected::none ? options.runs : options.earliest + static_cast<int>(span * random.uniform());
  History history = make_history(options, seed, from);
  auto change_random = stream_of(seed);
  (void)change_random.uniform();
  const InjectedChange change = draw_change(options, change_random);
  const auto thermometer =
      axes_of(options.golden).front().name + "." + kThermometerNames[static_cast<std::size_t>(change.thermometer)];
  result.judged_runs += from - assurance::kFewestDegrees - 1;
  while (true) {
    const auto open = first_open(assess(history, limits));
    if (!open) return;
    if (static_cast<int>(*open) >= from) {
      ++result.detected;
      result.runs_to_detection.push_back(static_cast<int>(*open) - from + 1);
      count_cause(options, thermometer, diagnose_change(history, limits, *open, options.repeats), result);
      return;
    }
    ++result.false_alarms;
    history.explanations.push_back({.run_ids = {history.checks[*open].run_id}, .cause = "false_alarm", .by = "study"});
  }
}

double ranked(std::vector<int> values, double share) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::ranges::sort(values);
  const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(values.size())));
  return values[std::max<std::size_t>(rank, 1) - 1];
}

}  // namespace

const char* name(GoldenGyro golden) {
  return enumerator_text<GoldenGyro::triad>({"single", "turned", "triad"}, golden);
}

const char* name(Injected injected) {
  return enumerator_text<Injected::gyro>({"none", "thermometer", "mount", "gyro"}, injected);
}

History make_history(const StudyOptions& options, std::uint64_t seed, int from) {
  auto random = stream_of(seed);
  (void)random.uniform();  // drew `from`
  const InjectedChange change = draw_change(options, random);
  History history{.head = {.rig = "study",
                           .simulated = true,
                           .serial_numbers = {"G"},
                           .profile = "check-standard",
                           .false_alarm_rate = options.false_alarm_rate,
                           .mount_change_deg = 0.1},
                  .checks = {},
                  .explanations = {}};
  for (int run = 0; run < options.runs; ++run) {
    const double share = std::clamp((run - from + 1.0) / options.grows_over, 0.0, 1.0);
    history.checks.push_back(RunMaker(options, change, share, random).make(run));
  }
  return history;
}

StudyResult simulate_histories(const StudyOptions& options) {
  StudyResult result;
  const auto one = make_history(options, 0, options.runs);
  const auto limits = find_limits(one);
  for (int seed = 0; seed < options.seeds; ++seed)
    follow_history(options, limits, static_cast<std::uint64_t>(seed), result);
  return result;
}

double median(std::vector<int> values) { return ranked(std::move(values), 0.5); }
double quantile_95(std::vector<int> values) { return ranked(std::move(values), 0.95); }

BinomialInterval binomial_interval(int successes, int trials) {
  constexpr double kNormal95 = 1.959964;
  const double n = trials, p = successes / n, z2 = kNormal95 * kNormal95;
  const double centre = (p + z2 / (2 * n)) / (1 + z2 / n);
  const double half = kNormal95 / (1 + z2 / n) * std::sqrt(p * (1 - p) / n + z2 / (4 * n * n));
  return {std::max(0.0, centre - half), std::min(1.0, centre + half)};
}

}  // namespace gyrotherm::tests
